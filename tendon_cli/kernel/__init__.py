"""Fold the model's arithmetic over whole blocks of states, in compiled code or in NumPy.

Both give the same bits; NumPy does all of it if there is no compiled code.

In C the arithmetic of a state is written once, in `state.h`: `drive_at` computes the quantities of
a design in one direction, `lines_at` some of its states as straight lines in pretension, and
`state_at` these states at a pretension. Everything computed of many states is a *fold* over that:
`rows.h` writes the row of each state, `extremes.h` finds the smallest and largest values and
counts, and `window.h` finds the pretensions at which every limit is kept. The last two take designs
in batches, one design a lane (`batch.h`). `arrays.h` lists all inputs and results once; `native.py`
checks the arrays that Python passes. Everything is compiled for each kind of processor, and the
best that runs here is used.

To add a fold: list its results in `arrays.h`, as EXTREMES does; write a header with a function
that `for_each_batch` calls for all designs in each direction, and that calls `lines_at` (and
`state_at`, if it needs a pretension); let `entry.h` export it and `native.py` call it, like
`find_extremes`. Write the same in `tendon_cli/model/` with NumPy, and choose between the two here.
Raise VERSION. `tests/kernel/` holds both to the same bits.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from tendon_cli.kernel.native import Columns, Native
from tendon_cli.model import window
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import SHARES, Bounds, bounded_forms
from tendon_cli.model.extremes import Extremes, begin, fold, merge_tensions
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import spring_room
from tendon_cli.quantities import SIDES

if TYPE_CHECKING:
    from tendon_cli.model.moving import Moving

NO_COMPILED_VARIABLE = "TENDON_NO_COMPILED"
"""Environment variable that, if it is set to anything, makes NumPy do all of the work."""

VERSION = 19
"""Version of the C code, compiled into it. Raise it with every change of numbers or of the calling
interface, so that code compiled before is not used."""

RowWriter = Callable[[Columns, range], Collection[str] | None]
"""Writes some rows of a block into columns of that many rows, and returns the names of the columns
with NaN, or None if it did not search them."""


@cache
def native() -> Native | None:
    """Load the compiled code. Return None if there is none of this version, or it is not wanted."""
    if os.environ.get(NO_COMPILED_VARIABLE):
        return None
    spec = importlib.util.find_spec("tendon_cli.kernel._native")
    if spec is None or not spec.origin:
        return None
    try:
        code = Native(spec.origin)
    except (OSError, ValueError):
        return None
    return code if code.version == VERSION else None


def missing_compiler_hint() -> str | None:
    """Return a hint for users who have no compiled code and did not ask for that, else None."""
    if native() is not None or os.environ.get(NO_COMPILED_VARIABLE):
        return None
    return (
        "NumPy did it all, several times slower than compiled code: "
        "install a C compiler, then tendon again"
    )


def row_writer(at: State, shape: tuple[int, ...], keys: Columns) -> RowWriter:
    """Return a function that writes rows of a block of states.

    Several threads may call it at once. It computes only the result columns that it is given. NumPy
    computes those that the compiled code does not know.

    Args:
        at: States of the block.
        shape: Lengths of the designs' axes, directions and angles; the last axis is fastest.
        keys: Columns besides those of `State.columns` and `status` (int8). They broadcast to the
            shape and have the types of the columns to be written.
    """
    code = native()
    if code is None:
        return columns_writer({**keys, "status": at.status, **at.columns()}, shape)
    given = _given(at)
    known = {*keys, "status", *code.results}
    key_values = {name: np.ascontiguousarray(values) for name, values in keys.items()}
    keys_with_nan = [name for name, values in key_values.items() if np.isnan(values).any()]

    def write(columns: Columns, rows: range) -> Collection[str]:
        wanted = {name: values for name, values in key_values.items() if name in columns}
        with_nan = code.rows(shape, given, wanted, columns, rows.start, len(rows))
        others = {name: values for name, values in columns.items() if name not in known}
        if others:
            columns_writer(at.columns(others), shape)(others, rows)
        others_with_nan = [name for name, values in others.items() if np.isnan(values).any()]
        return [*keys_with_nan, *with_nan, *others_with_nan]

    return write


def fold_extremes(folded: Extremes, at: State, elbow_angle: Array, shape: tuple[int, ...]) -> None:
    """Fold all states of a block into the extremes of its designs, as `model.extremes.fold` does.

    Args:
        folded: Extremes by name, over the designs' axes; changed in place.
        at: States of the block.
        elbow_angle: Elbow angles of the states, rad.
        shape: Lengths of the designs' axes, directions and angles.
    """
    code = native()
    if code is None:
        fold(folded, at, elbow_angle)
    else:
        code.extremes(shape, _given(at), np.ascontiguousarray(elbow_angle), folded)


def fold_motion(folded: Extremes, moving: Moving) -> None:
    """Fold all states along a trajectory into the extremes of its designs, where they count.

    Where the tendons turn, torque and tensions may be those of either direction; the stiffness is
    that of the states that hold.

    Args:
        folded: Extremes of no state yet by name, over the designs' axes; changed in place.
        moving: The designs along their trajectory.
    """
    angle = moving.trajectory.angle[moving.trajectory.counted]
    shape = (*folded["slack"].shape, 1, len(angle))
    held, turned = moving.counted_states
    fold_extremes(folded, held, angle, shape)
    other = begin(folded["slack"].shape)
    fold_extremes(other, turned, angle, shape)
    merge_tensions(folded, other)
    folded["slack"][...] = moving.slack_count()


def fold_window(
    folded: Extremes,
    at: State,
    bounds: Bounds,
    shape: tuple[int, ...],
    first: int,
    angles: int,
) -> None:
    """Fold all states of a block into the windows of its designs, as `model.window.fold` does.

    Args:
        folded: Ends of the windows by name, over the designs' axes; changed in place.
        at: States of the block. Their pretension does not matter.
        bounds: Limits of the designs.
        shape: Lengths of the designs' axes, directions and angles; 1 along axes on which nothing
            but pretension depends.
        first: Number of the block's first elbow angle in each direction.
        angles: Number of elbow angles in each direction, of which the block may have a part.
    """
    at = replace(at, design=at.design.with_pretension(0.0))
    code = native()
    if code is None:
        directions = np.arange(shape[-2])[:, np.newaxis]
        states = directions * angles + first + np.arange(shape[-1])
        window.fold(folded, at, bounds, states)
        return
    given = _given(at)
    alone, forms = _bound_inputs(at, bounds)
    # Compiled code takes only so many forms at once; the tightest end is the same in any order.
    for start in range(0, max(1, len(forms)), code.most_forms):
        some_forms = forms[start : start + code.most_forms]
        code.window(shape, given, alone, some_forms, folded, first, angles)


_UNBOUNDED = {"least": -np.inf, "most": np.inf}
"""Ends of a range without bounds."""


def _bound_inputs(
    at: State, bounds: Bounds
) -> tuple[dict[str, Array], tuple[dict[str, Array], ...]]:
    """Return bounds as compiled code takes them.

    Returns:
        Bounds on a tension or the stiffness alone, by the names of BOUNDS in `arrays.h`, and forms
        of several of them, by the names of FORM.
    """
    alone = {
        f"{share}_{end}": _as_input(bound) for share in SHARES for end, bound in _UNBOUNDED.items()
    }
    forms = []
    for bounded in bounded_forms(at, bounds):
        both_ends = {end: getattr(bounded, end) for end in _UNBOUNDED}
        ends = {end: bound for end, bound in both_ends.items() if bound is not None}
        if not bounded.alone:
            shares = {share: getattr(bounded.form, share) for share in SHARES}
            values = shares | _UNBOUNDED | ends
            forms.append({name: _as_input(value) for name, value in values.items()})
            continue
        for end, bound in ends.items():
            name = f"{bounded.alone}_{end}"
            tighter = np.maximum if end == "least" else np.minimum
            alone[name] = _as_input(tighter(alone[name], bound))
    return alone, tuple(forms)


def _as_input(value: npt.ArrayLike) -> Array:
    """Return a contiguous array of float64."""
    return np.ascontiguousarray(value, dtype=np.float64)


def _given(at: State) -> dict[str, Array]:
    """Return the inputs of states for compiled code, by the names of GIVEN in `arrays.h`."""
    design = at.design
    motion = at.motion
    flexor_slope, extensor_slope = at.arm_slopes
    values = {
        "moment_arm": motion.flexor_moment_arm,
        "pulling_arm": motion.pulling_arm,
        "extensor_arm": motion.extensor_moment_arm,
        "flexor_travel": motion.flexor_travel,
        "extensor_travel": motion.extensor_travel,
        "flexor_slope": flexor_slope,
        "extensor_slope": extensor_slope,
        "sine": at.sine,
        "cosine": at.cosine,
        "other_torque": at.other_torque,
        "other_slope": at.other_slope,
        "pressed": at.is_pressed,
        "spring_room": spring_room(at),
        "gravity_moment": at.gravity_moment,
        "flexor_radius": design.flexor_radius,
        "ratio": design.ratio,
        "unilateral": design.unilateral,
    }
    resting_sides = at.resting or (at.flexor, at.extensor)
    for name, resting in zip(SIDES, resting_sides, strict=True):
        side = getattr(at, name)
        for part in ("capstan", "tendon", "spring", "anchor"):
            values[f"{name}_{part}"] = getattr(side, part)
        for part in ("tendon", "spring"):
            values[f"{name}_{part}_resting"] = getattr(resting, part)
        values[f"{name}_pretension"] = getattr(design, name).pretension
    return {name: _as_input(value) for name, value in values.items()}


def columns_writer(columns: Mapping[str, npt.ArrayLike], shape: tuple[int, ...]) -> RowWriter:
    """Return a function that writes rows from columns that broadcast to a shape."""

    def write(targets: Columns, rows: range) -> None:
        for name, target in targets.items():
            values = np.broadcast_to(np.asarray(columns[name]), shape)
            if len(rows) == values.size:
                target.reshape(shape)[...] = values
            else:
                target[...] = values.ravel()[rows.start : rows.stop]

    return write
