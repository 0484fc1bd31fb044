"""The model's arithmetic on whole blocks of states, by compiled code where there is some, else by NumPy: the same bits.

In C a state stands once, in `state.h`: `drive_at` is what a design has in one direction, `lines_at` some of its states
as straight lines in pretension, `state_at` these at a pretension. What is wanted of many states is a *fold* over that:
`rows.h` writes each state's row, `extremes.h` finds what is smallest, largest and counted, `window.h` between which
pretensions every limit is kept; the last two take designs `beside.h` each other, one a lane. `arrays.h` names, once,
what goes in and out; `native.py` checks what Python hands over. Everything is compiled for each kind of processor, and
the best that runs here is taken.

To add a fold: name its results in `arrays.h`, as EXTREMES does; write `your_fold.h` with a visit that `over_designs`
makes to all designs in each direction, and that calls `lines_at` (and `state_at`, where it wants a pretension); let
`entry.h` export it and `native.py` call it, like extremes. Say the same in `tendon_cli/model/` with NumPy, and here
choose between the two. Raise VERSION. `tests/kernel/` holds both to the same bits.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import numpy.typing as npt

from tendon_cli.kernel.native import Columns, Native
from tendon_cli.model import window
from tendon_cli.model.actuator import SIDES, State
from tendon_cli.model.bounds import SHARES, Bounds, held_forms
from tendon_cli.model.extremes import Found, fold
from tendon_cli.model.forms import is_nothing
from tendon_cli.model.kinematics import Array

UNWANTED = "TENDON_NO_COMPILED"
"""Environment variable that, set to anything, has NumPy do it all."""

VERSION = 18
"""Of the C code, which is compiled with it: raised with every change, so that what was compiled before is not used."""

RowWriter = Callable[[Columns, range], Collection[str] | None]
"""Writes some rows of a block into columns of that many rows; says which hold NaN, or None where it was not asked."""


@cache
def native() -> Native | None:
    """The compiled code; None if there is none of this version, or none is wanted."""
    spec = (
        None if os.environ.get(UNWANTED) else importlib.util.find_spec("tendon_cli.kernel._native")
    )
    try:
        code = Native(spec.origin) if spec and spec.origin else None
    except (OSError, ValueError):
        return None
    return code if code and code.version == VERSION else None


@cache
def kind() -> str | None:
    """The kind of processor whose code is used; None where NumPy does it all."""
    code = native()
    return code.kinds[-1] if code else None


def remark() -> str | None:
    """What to tell whoever has no compiled code and did not ask for that."""
    if kind() is not None or os.environ.get(UNWANTED):
        return None
    return "NumPy did it all, several times slower than compiled code: install a C compiler, then tendon again"


def row_writer(at: State, shape: tuple[int, ...], keys: Columns) -> RowWriter:
    """What writes the rows of a block of states of a shape (designs' axes, directions, angles), the last axis fastest.

    Columns are those of `State.columns`, `status` as int8, and those of `keys`, which broadcast to the shape and have
    the columns' types; of the results only those asked for are written. Safe from several threads. NumPy works out the
    columns that compiled code does not know.
    """
    code, chosen = native(), kind()
    if code is None or chosen is None:
        return writer_of({**keys, "status": at.status, **at.columns()}, shape)
    known = {*keys, "status", *code.results}
    given, spread = (
        _given(at),
        {name: np.ascontiguousarray(values) for name, values in keys.items()},
    )
    null = [name for name, values in spread.items() if np.isnan(values).any()]

    def write(columns: Columns, rows: range) -> Collection[str]:
        wanted = {name: values for name, values in spread.items() if name in columns}
        results = code.rows(chosen, shape, given, wanted, columns, rows.start, len(rows))
        others = {name: values for name, values in columns.items() if name not in known}
        if others:
            writer_of(at.columns(others), shape)(others, rows)
        return [
            *null,
            *results,
            *(name for name, values in others.items() if np.isnan(values).any()),
        ]

    return write


def fold_extremes(found: Found, at: State, elbow_angle: Array, shape: tuple[int, ...]) -> None:
    """Fold all states of a block into what is known of its designs: `model.extremes.fold`."""
    code, chosen = native(), kind()
    if code is None or chosen is None:
        fold(found, at, elbow_angle)
    else:
        code.extremes(chosen, shape, _given(at), np.ascontiguousarray(elbow_angle), found)


def fold_window(
    found: window.Found,
    at: State,
    bounds: Bounds,
    shape: tuple[int, ...],
    first: int = 0,
    angles: int | None = None,
) -> None:
    """Fold all states of a block into what is known of its designs: `model.window.fold`.

    The elbow angles of the block are those from `first` on of `angles` in each direction, by default all. Pretension
    plays no part, so axes that nothing else depends on are one long in `shape`.
    """
    sides = {side: replace(getattr(at.design, side), pretension=0.0) for side in SIDES}
    at = replace(at, design=replace(at.design, **sides))
    total, code, chosen = angles or shape[-1], native(), kind()
    if code is None or chosen is None:
        states = np.arange(shape[-2])[:, np.newaxis] * total + first + np.arange(shape[-1])
        window.fold(found, at, bounds, states)
    else:
        given, (one, forms) = _given(at), _held_to(at, bounds)
        for start in range(
            0, max(1, len(forms)), code.most_forms
        ):  # the tightest end is the same whatever comes first
            some = forms[start : start + code.most_forms]
            code.window(chosen, shape, given, one, some, found, first, total)


def _held_to(at: State, bounds: Bounds) -> tuple[dict[str, Array], tuple[dict[str, Array], ...]]:
    """What compiled code takes of bounds: those on one share, by the names of BOUNDS in `arrays.h`, and other forms."""
    one = {
        f"{share}_{end}": _as_input(sign * np.inf)
        for share in SHARES
        for end, sign in _ENDS.items()
    }
    forms = []
    for held in held_forms(at, bounds):
        shares = {share: getattr(held.form, share) for share in SHARES}
        ends = {end: getattr(held, end) for end in _ENDS if getattr(held, end) is not None}
        alone = [
            share for share, value in shares.items() if isinstance(value, float) and value == 1.0
        ]
        if len(alone) == 1 and sum(not is_nothing(value) for value in shares.values()) == 1:
            for end, bound in ends.items():
                tighter = np.maximum if end == "least" else np.minimum
                one[f"{alone[0]}_{end}"] = _as_input(tighter(one[f"{alone[0]}_{end}"], bound))
        else:
            unbounded = {end: sign * np.inf for end, sign in _ENDS.items()}
            forms.append(
                {name: _as_input(value) for name, value in (shares | unbounded | ends).items()}
            )
    return one, tuple(forms)


_ENDS = {"least": -1.0, "most": 1.0}


def _as_input(value: npt.ArrayLike) -> Array:
    return np.ascontiguousarray(value, dtype=np.float64)


def _given(at: State) -> dict[str, Array]:
    """What compiled code takes of states, by the names of GIVEN in `arrays.h`."""
    design, motion = at.design, at.motion
    values = {
        name: getattr(motion, name) for name in ("pulling_arm", "flexor_travel", "extensor_travel")
    }
    values |= {
        name: getattr(at, name)
        for name in ("sine", "cosine", "other_torque", "other_slope", "gravity_moment")
    }
    values |= {"moment_arm": motion.flexor_moment_arm, "extensor_arm": motion.extensor_moment_arm}
    values |= dict(zip(("flexor_slope", "extensor_slope"), at.arm_slopes, strict=True))
    values |= {name: getattr(design, name) for name in ("flexor_radius", "ratio", "unilateral")}
    for name, resting in zip(SIDES, at.resting or (at.flexor, at.extensor), strict=True):
        side = getattr(at, name)
        values |= {
            f"{name}_{part}": getattr(side, part)
            for part in ("capstan", "tendon", "spring", "anchor")
        }
        values |= {
            f"{name}_{part}_resting": getattr(resting, part) for part in ("tendon", "spring")
        }
        values[f"{name}_pretension"] = getattr(design, name).pretension
    return {name: _as_input(value) for name, value in values.items()}


def writer_of(columns: Mapping[str, npt.ArrayLike], shape: tuple[int, ...]) -> RowWriter:
    """Writes rows from columns that broadcast to a shape."""

    def write(to: Columns, rows: range) -> None:
        for name, column in to.items():
            values = np.broadcast_to(np.asarray(columns[name]), shape)
            if len(rows) == values.size:
                column.reshape(shape)[...] = values
            else:
                column[...] = values.ravel()[rows.start : rows.stop]

    return write
