"""What an answer says of a choice between the samples: the worst there, by how much an end may be off, its curves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question import LOADS
from tendon_cli.answers.solve import Solutions, quantities_under_each, worst_columns
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import contact_pressure
from tendon_cli.model.motor_window import narrowed
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.model.whole_motion import end_curves
from tendon_cli.model.window import Ends, Window, as_read, named, window
from tendon_cli.space.axis import PRETENSION, Numbers
from tendon_cli.studies.measured_motion import at_times
from tendon_cli.studies.study import keys

_DENSER, _MOST_NEAR = (
    16,
    16,
)  # how much, and for how many of the conditions that are tightest at either end
_MOST_SAMPLES = 2**16  # of a trajectory, times the conditions
_SAFE, _MISSED, _LEAST = 1.1, 0.05, 1e-6
"""The dense grid misses at most 3 % of what is missed near an end, and elsewhere 1.2 % of the worst; the rest is
room. N for what is rounded."""
_BESIDE, _AT_ONCE = 0.01, 2**8
"""Conditions that come so near to the worst, as a share of that and of all between, may be it at other angles."""
_STEPS = 16  # between two angles
METHOD = (
    "interval arithmetic with outward rounding on Taylor forms of second order over cells of the angle and of numbers"
    " in a box, in both directions, at both ends of the window and of the loads"
)


def worst_between(
    problem: Problem, numbers: Numbers, pretension: Array, served: Flags
) -> dict[str, Array]:
    """The worst of one choice at all angles over the conditions that its pretension serves, (1,); NaN if none.

    Between two angles a quantity may exceed both by an eighth of its second difference. Wherever twice that makes it
    the worst, it is taken at denser angles and at the tops of the parabolas through these.
    """
    whole = quantities_under_each(problem, numbers, pretension, served)
    most, known = whole.max(axis=1), np.isfinite(whole)
    least = np.where(known, whole, np.inf).min(axis=1)
    with np.errstate(invalid="ignore"):
        near = most - _BESIDE * (np.abs(most) + most - least)
    rows, angles = (
        np.flatnonzero((known & (whole >= near[:, np.newaxis])).any(axis=0)),
        problem.angles.ravel(),
    )
    given = {**numbers, PRETENSION: pretension}
    dense = np.linspace(angles[0], angles[-1], _STEPS * (len(angles) - 1) + 1)[np.newaxis]
    for part in problem.cut(len(rows) if len(angles) > 2 else 0, _AT_ONCE):
        some = rows[part]
        design = problem.paired(given, np.zeros_like(some), some)
        values = _quantities_at(design, problem.angles, problem.flexion)
        with np.errstate(invalid="ignore"):
            rise = np.abs(np.diff(values, 2)).max(axis=-1, keepdims=True) / 4.0
        may = (
            np.maximum(values[..., 1:], values[..., :-1]) + rise
            >= most[:, np.newaxis, np.newaxis, np.newaxis]
        )
        for place in np.flatnonzero(may.any(axis=(0, 1, 2))):
            finer = dense[:, max(0, place * _STEPS - 1) : (place + 1) * _STEPS + 2]
            most = np.fmax(
                most, _tops(_quantities_at(design, finer, problem.flexion)).max(axis=(1, 2, 3))
            )
    return worst_columns(np.where(np.isfinite(most), most, np.nan)[:, np.newaxis])


def _quantities_at(design: Design, angles: Array, flexion: Flags) -> Array:
    """Six quantities of states, the larger the worse, (6, designs, directions, angles)."""
    state = State.of(design, angles, flexion)
    x, y = state.balance.flexor, state.balance.extensor
    tension = np.maximum(
        np.maximum(x, state.flexor_tension_proximal), np.maximum(y, state.extensor_tension_proximal)
    )
    extension, torque = (
        np.maximum(x * state.flexor.spring, y * state.extensor.spring),
        state.motor_torque,
    )
    six = (tension, extension, torque, -torque, -state.elbow_stiffness, contact_pressure(design, y))
    values: Array = np.stack(np.broadcast_arrays(*six))
    return np.where(np.isnan(values), -np.inf, values)


def _tops(values: Array) -> Array:
    """Values, those that are largest among neighbours at the top of the parabola through the three."""
    before, here, after = values[..., :-2], values[..., 1:-1], values[..., 2:]
    with np.errstate(divide="ignore", invalid="ignore"):
        top = here - (after - before) ** 2 / (8.0 * (before - 2.0 * here + after))
    peak = (here >= before) & (here >= after) & (top > here)
    return np.concatenate([values, np.where(peak, top, here)], axis=-1)


def estimated(problem: Problem, numbers: Numbers, one: Solutions, ends: Ends) -> float | None:
    """By how much ends that are sampled may be off, N, as they are read; None if none is, or no window may be left.

    `ends` are those over all angles, as F0. Sampled are those that limits on the whole motion set, and all along a
    trajectory. It is what samples sixteen times as dense take from the window, and a share of what samples as wide as
    the window's, displaced by shares of a step, miss at worst.
    """
    trajectory = problem.study.trajectory
    if not problem.bounds.of_motion and trajectory is None:
        return None
    within, common = (
        problem.finish_ends(ends, numbers),
        (one["pretension_from"][0], one["pretension_to"][0]),
    )
    low, high = (
        np.where(each[0] * sign <= end * sign, each[0] * sign, -np.inf)
        for each, end, sign in zip((within.low, within.high), common, (1.0, -1.0), strict=True)
    )
    most = (
        _MOST_NEAR
        if trajectory is None
        else max(1, min(_MOST_NEAR, _MOST_SAMPLES // len(trajectory.time)))
    )
    rows = np.unique([*np.argsort(-low)[:most], *np.argsort(-high)[:most]])
    places = problem.angles[0] if trajectory is None else trajectory.time
    step = (places[-1] - places[0]) / (len(places) - 1)
    displaced = [
        np.append(places[:-1] + share * step, places[[0, -1]])
        for share in np.arange(_DENSER) / _DENSER
    ]
    displaced = [np.unique(np.minimum(each, places[-1])) for each in displaced]
    near_ends = step * 2.0 ** (-0.5 * np.arange(1, 2 * _DENSER))
    finest = np.unique(np.concatenate([*displaced, places[0] + near_ends, places[-1] - near_ends]))
    design = problem.paired(numbers, np.zeros_like(rows), rows)
    if trajectory is None:
        some = Ends(**{name: values[0, rows] for name, values in vars(ends).items()})
        ends_over = _ends_over_angles(problem, design, some)
    else:
        ends_over = _ends_along(problem, design, trajectory)
    tightest = ends_over(finest)
    with np.errstate(invalid="ignore"):
        off = [
            np.nan_to_num(tightest - ends_over(each), nan=0.0, posinf=np.inf) for each in displaced
        ]
    estimate = float(
        np.max(_SAFE * np.maximum(off[0], 0.0) + _MISSED * np.max(np.abs(off), axis=0)) + _LEAST
    )
    return estimate if np.isfinite(estimate) else None


def _ends_over_angles(
    problem: Problem, design: Design, of_states: Ends
) -> Callable[[Array], Array]:
    """Ends of the windows of one choice under some conditions, by the angles at which the whole motion is taken."""
    some = named(of_states, design, problem.angles, problem.flexion, problem.bounds)

    def ends(angles: Array) -> Array:
        each = narrowed(
            some, design, angles[np.newaxis], problem.flexion, problem.bounds, problem.loads
        )
        return _common(as_read(each, design))

    return ends


def _ends_along(
    problem: Problem, design: Design, trajectory: Trajectory
) -> Callable[[Array], Array]:
    """The same, by the times at which a trajectory is taken; dense ones wherever near those friction may turn."""

    def ends(times: Array) -> Array:
        motion, either = at_times(trajectory, times), list[Array]()
        for moved in motion.turning if len(times) > len(trajectory.time) + 1 else [motion]:
            given = (
                replace(design, trajectory=moved),
                moved.angle[np.newaxis],
                moved.flexion[np.newaxis],
            )
            each = narrowed(window(*given, problem.bounds), *given, problem.bounds, problem.loads)
            either.append(_common(as_read(each, design)))
        return np.asarray(np.max(either, axis=0))

    return ends


def _common(windows: Window) -> Array:
    """From where on all windows are kept, and to where with the sign changed; infinite if there is none."""
    ends = np.array([windows.low.max(), -windows.high.min()])
    return np.where(np.isnan(ends), np.inf, ends)


def scope(problem: Problem) -> str:
    """For what a proof holds, in words: "every angle from 0 to 90 deg and every load from 0 to 10 kg"."""
    words = [_every("angle", "elbow_angle", problem.angles)]
    for axis in problem.conditions.axes:
        if (axis.key in LOADS or axis.is_interval) and len(axis) > 1:
            name = keys()[axis.key].number.quantity.name
            what = "load" if axis.key == "load.mass" else name.replace("_", " ")
            words.append(_every(what, name, axis.values))
    return say.listed(words)


def _every(what: str, quantity: str, values: Array) -> str:
    low, high = (say.quantity(quantity, float(end)) for end in (values.min(), values.max()))
    unit = high.partition(" ")[2]
    return f"every {what} from {low.removesuffix(' ' + unit)} to {high}"


def curves_of(problem: Problem, choice: Solutions, ends: Ends) -> dict[str, Any]:
    """One choice over the elbow angle (rad): what each limit asks for, N, over both directions and all conditions.

    `ends` are those of its windows, as they are read. If some conditions are not served at its pretension, only those
    that are count (`all_conditions`). `lower` and `upper` have by limit the least and the largest pretensions, null
    where it asks for nothing; `samples` are the study's angles. Limits on the whole motion have no curve.
    """
    lower, upper = dict[str, Array](), dict[str, Array]()
    numbers, pretension = problem.numbers_of(choice.columns), choice["pretension"][:1]
    serves = (ends.low <= pretension) & (pretension <= ends.high)
    counts = serves if serves.any() else ~serves
    for _, conditions, design in problem.chunks(numbers, 1):
        held = counts[:, conditions, np.newaxis, np.newaxis]
        some = end_curves(design, problem.angles, problem.flexion, problem.bounds, held)
        for whole, part, tighter in zip(
            (lower, upper), some, (np.maximum, np.minimum), strict=True
        ):
            whole |= {
                name: tighter(values, whole.get(name, values)) for name, values in part.items()
            }
    return {
        "elbow_angle": problem.angles.ravel().tolist(),
        "samples": np.unique(problem.study.angles).tolist(),
        "all_conditions": bool(counts.all()),
        "lower": {name: _listed(values) for name, values in lower.items()},
        "upper": {name: _listed(values) for name, values in upper.items()},
    }


def _listed(values: Array) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]
