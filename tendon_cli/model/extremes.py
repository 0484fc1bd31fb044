"""What designs come to over all their states: smallest, largest, counted. A fold of the rows of states.

A fold starts from `begin`, takes states in any order and in any portions by `fold`, and ends in `finished`, whose
results are the columns of a table of designs. Nothing is rounded on the way but what the rows are, so that the columns
are the extremes of the rows to the last bit.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model import statics
from tendon_cli.model.actuator import Situation, State
from tendon_cli.model.design import F0, Design, changed
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMITS, contact_pressure
from tendon_cli.model.portions import Kind, Place, StateAxes, cut
from tendon_cli.model.response import SLACK_TOLERANCE
from tendon_cli.model.setting import Reading

Found = dict[str, Array]
"""Over designs, by name."""

_SMALLEST = (
    "min_flexor_tension", "min_extensor_tension", "min_elbow_stiffness", "first_slack_angle", "margin",
    "lowest_elbow_torque", "lowest_motor_torque",
)  # fmt: skip
_LARGEST = (
    "max_tension", "max_extensor_distal", "max_spring_extension", "max_slack", "required_pretension",
    "highest_elbow_torque", "highest_motor_torque",
)  # fmt: skip
COUNTS = ("slack", "no_equilibrium", "unstable")
_TENSIONS = ("low_flexor", "high_flexor", "low_extensor", "high_extensor")
_OVER_ANGLES = dict.fromkeys(
    (*_TENSIONS, "lowest_motor_torque", "highest_motor_torque", "min_elbow_stiffness"), np.nan
) | {"slack": 0.0, "first_slack_angle": np.inf, "unstable": 0.0}  # fmt: skip
"""What states at a pretension come to over elbow angles, tensions at the distal end, and where none is so."""


def begin(shape: tuple[int, ...]) -> Found:
    """Nothing found yet, for designs of a shape; other axes or angles of the same designs may be folded in turn."""
    starts = dict.fromkeys(_SMALLEST, np.inf) | dict.fromkeys(_LARGEST, -np.inf) | dict.fromkeys(COUNTS, 0.0)
    return {name: np.full(shape, start) for name, start in starts.items()}


def fold(found: Found, at: Situation, elbow_angle: Array) -> None:
    """Take in states, whose last two axes are directions and elbow angles (rad); the others are those of `found`.

    What does not depend on pretension is worked out once for all pretensions, in portions of states.
    """
    if len(elbow_angle) > 1 and at.follows_angle:  # tension scales differently along a sheath at each angle
        for index in range(len(elbow_angle)):
            fold(found, changed(at, partial(_angle, index=index)), elbow_angle[index : index + 1])
        return
    shape = (*found["slack"].shape, *np.broadcast_shapes(at.flexor.capstan.shape, np.shape(elbow_angle))[-2:])
    axes, ascending = StateAxes(shape, _axis_of_pretension(at, shape)), np.argsort(elbow_angle, kind="stable")
    angles = elbow_angle[ascending]

    def laid(values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
        return axes.laid(values if values.shape[-1] == 1 else values[..., ascending])

    if axes.free is not None or not np.array_equal(angles, elbow_angle):
        at = changed(at, laid)
    into, places = begin(axes.designs), list(axes.portions())
    for place in places:
        here = at if len(places) == 1 else changed(at, partial(cut, place=place))
        _take(into, _of_portion(here, angles[place[axes.angles]], axes), axes.directions)
    _take(found, {name: axes.back(values) for name, values in into.items()})


def _angle(values: npt.NDArray[Kind], index: int) -> npt.NDArray[Kind]:
    """One elbow angle of what may vary along them."""
    return values if values.shape[-1] == 1 else values[..., index : index + 1]


def _axis_of_pretension(at: Situation, shape: tuple[int, ...]) -> int | None:
    """The longest axis of designs that nothing but pretension depends on; None where there is none."""
    tied = vars(at.coupling) | {"resting": np.zeros(())}
    others = *tied.values(), *(at.coupling.resting or ()), *at.motor_arms, at.other_slope, at.design.unilateral
    known = np.broadcast_shapes((1,) * len(shape), *map(np.shape, others))
    free = (axis for axis, length in enumerate(shape[:-2]) if known[axis] == 1 < length)
    return max(free, key=shape.__getitem__, default=None)


def _of_portion(at: Situation, elbow_angle: Array, axes: StateAxes) -> Found:
    """What some ascending elbow angles of each direction come to, over designs along their axes."""
    along, sides = axes.angles, (at.design.flexor.pretension, at.design.extensor.pretension)
    shape = np.broadcast_shapes(axes.designs, at.flexor.capstan.shape)
    met = {name: np.full(shape, start) for name, start in _OVER_ANGLES.items()}
    for run, state in _states(at, axes):
        for name, values in _over_angles(state, elbow_angle, along).items():
            met[name][run] = values
        if axes.free is None:
            met["max_slack"] = np.fmax.reduce(state.longest_slack, axis=along, keepdims=True)
    before = _before_pretension(at, along)
    surplus = at.coupling.common_pretension(*sides) - before["required_pretension"]  # the least: rounding keeps order
    met["margin"] = np.fmin(surplus, np.minimum(*sides))
    if axes.free is not None:
        taut = len(elbow_angle) > met["slack"] + before["no_equilibrium"]
        met["max_slack"] = np.fmax(_longest_slack(at, axes), np.where(taut & at.design.unilateral, 0.0, np.nan))
    return before | _of_tensions(at, met)


def _states(at: Situation, axes: StateAxes) -> Iterator[tuple[Place, State]]:
    """The states at some pretensions after the other, and the places of these."""
    if axes.free is None:
        yield (), State.of(at)
        return
    flexor, extensor = np.asarray(at.design.flexor.pretension), np.asarray(at.design.extensor.pretension)
    for run in axes.runs():
        yield run, State(at, cut(flexor, run), cut(extensor, run))


def _longest_slack(at: Situation, axes: StateAxes) -> Array:
    """The longest slack length over elbow angles, m; NaN where no side is slack.

    Rounding keeps the order of states, so that on either side it is that of the state with the largest shortfall, if
    this is slack. Where another may be and this not, which takes two as near as the tolerance of slack, all are seen.
    """
    response, along, unilateral = at.response, axes.angles, np.asarray(at.design.unilateral)
    pretension = at.coupling.common_pretension(at.design.flexor.pretension, at.design.extensor.pretension)
    longest = np.full(np.broadcast_shapes(axes.designs, pretension.shape), np.nan)
    backward = at.coupling.elbow_torque < 0.0
    for is_side, per_path in zip((backward, ~backward), at.slack_per_path, strict=True):
        if not (its_states := is_side & unilateral & ~response.idle).any():
            continue
        shortfall, limit = (np.where(its_states, values, -np.inf) for values in (response.shortfall, response.limit))
        largest = np.fmax.reduce(shortfall, axis=along, keepdims=True)
        its = np.fmax.reduce(np.where(shortfall == largest, limit, -np.inf), axis=along, keepdims=True)
        if np.any((pretension >= its) & (pretension < np.fmax.reduce(limit, axis=along, keepdims=True))):
            for run, state in _states(at, axes):
                longest[run] = np.fmax.reduce(state.longest_slack, axis=along, keepdims=True)
            return longest
        length = statics.loose_path(at.coupling, pretension - largest) * per_path
        longest = np.fmax(longest, np.where(pretension < its, length, np.nan))
    return longest


def _before_pretension(at: Situation, along: int) -> Found:
    """What states come to whatever their pretension, over elbow angles along an axis."""
    unanswerable = np.isnan(at.coupling.moment_arm)
    torque = np.where(unanswerable, np.nan, at.coupling.elbow_torque)
    each = np.broadcast_to(unanswerable, np.broadcast_shapes(unanswerable.shape, at.flexor.capstan.shape))
    return {
        "lowest_elbow_torque": np.fmin.reduce(torque, axis=along, keepdims=True),
        "highest_elbow_torque": np.fmax.reduce(torque, axis=along, keepdims=True),
        "no_equilibrium": np.add.reduce(each, axis=along, keepdims=True),
        "required_pretension": np.fmax.reduce(at.response.shortfall, axis=along, keepdims=True),
    }


def _over_angles(state: State, elbow_angle: Array, along: int) -> dict[str, npt.NDArray[Any]]:
    """What states come to at their pretensions over ascending elbow angles, by the names of `_OVER_ANGLES`.

    Each quantity is gone over as soon as it is there, while it is in the processor's cache.
    """
    values: dict[str, npt.NDArray[Any]] = {}

    def ends(names: tuple[str, str], quantity: Array) -> None:
        for name, ufunc in zip(names, (np.fmin, np.fmax), strict=True):
            values[name] = ufunc.reduce(quantity, axis=along, keepdims=True)

    ends(("low_flexor", "high_flexor"), state.balance.flexor)
    ends(("low_extensor", "high_extensor"), state.balance.extensor)
    ends(("lowest_motor_torque", "highest_motor_torque"), state.motor_torque)
    stiffness = state.elbow_stiffness
    values["min_elbow_stiffness"] = least = np.fmin.reduce(stiffness, axis=along, keepdims=True)
    if (least < 0.0).any():
        values["unstable"] = np.add.reduce(stiffness < 0.0, axis=along, keepdims=True, dtype=np.int32)
    if (slack := state.balance.is_slack).any():
        values["slack"] = count = np.add.reduce(slack, axis=along, keepdims=True, dtype=np.int32)
        first = elbow_angle[slack.argmax(axis=along, keepdims=True)]
        values["first_slack_angle"] = np.where(count > 0, first, np.inf)
    return values


def _of_tensions(at: Situation, met: Found) -> Found:
    """Tension only scales along a sheath, and the spring's extension with it, so distal ones suffice."""
    low_x, high_x, low_y, high_y = (met.pop(name) for name in _TENSIONS)
    capstan_x, capstan_y = at.flexor.capstan, at.extensor.capstan
    return met | {
        "min_flexor_tension": np.fmin(low_x, low_x / capstan_x),
        "min_extensor_tension": np.fmin(low_y, low_y / capstan_y),
        "max_tension": np.fmax(np.fmax(high_x, high_x / capstan_x), np.fmax(high_y, high_y / capstan_y)),
        "max_extensor_distal": high_y,
        "max_spring_extension": np.fmax(high_x * at.flexor.spring, high_y * at.extensor.spring),
    }


def _take(found: Found, values: Found, directions: int | None = None) -> None:
    """Fold what some states come to into what was found, over directions where these have an axis."""
    for name, value in values.items():
        ufunc = np.add if name in COUNTS else np.fmin if name in _SMALLEST else np.fmax
        several = directions is not None and value.shape[directions] > 1
        whole = ufunc.reduce(value, axis=directions, keepdims=True) if several else value
        ufunc(found[name], whole, out=found[name])


def finished(found: Found, states: int) -> Found:
    """The result columns of designs, from the extremes over all `states` of each; NaN where no state has a result."""
    unanswerable, failing = found["no_equilibrium"] > 0, found["slack"] + found["no_equilibrium"]
    known = {name: np.where(np.isinf(found[name]), np.nan, found[name]) for name in (*_SMALLEST, *_LARGEST)}
    columns = {name: values for name, values in known.items() if not name.endswith(("_torque", "_distal"))} | {
        "peak_elbow_torque": _with_sign(known["lowest_elbow_torque"], known["highest_elbow_torque"]),
        "peak_motor_torque": _with_sign(known["lowest_motor_torque"], known["highest_motor_torque"]),
        "slack_fraction": failing / states,
        "unstable_fraction": found["unstable"] / states,
        "required_pretension": np.where(unanswerable, np.nan, np.maximum(0.0, known["required_pretension"])),
        "margin": np.where(unanswerable, np.nan, known["margin"]),
    }
    # Minus zero becomes zero: which of the two is the smallest depends on the order in which states are taken.
    return {name: values + 0.0 for name, values in columns.items()}


def as_read(columns: Found, design: Design) -> Found:
    """The result columns of designs with what is a pretension as the design's own is read."""
    if design.read == F0:
        return columns
    line, set_to = Reading.of(design, design.read), design.flexor.pretension
    least = {name: columns[name][..., np.newaxis, np.newaxis] for name in ("required_pretension", "margin")}
    required = line.shown(least["required_pretension"])
    margin = line.shown(set_to) - line.shown(set_to - least["margin"])
    return columns | {"required_pretension": required[..., 0, 0], "margin": margin[..., 0, 0]}


def judged(columns: Found, limits: Mapping[str, float]) -> dict[str, npt.NDArray[np.bool_]]:
    """Which designs are taut in every state, stable in each, and within every limit on a column as well, SI.

    Limits are kept with the tolerance of slack. Those on what `columns` have not are left out, and what is no number
    keeps them.
    """
    taut, stable = columns["slack_fraction"] == 0.0, ~(columns["min_elbow_stiffness"] < limits["min_elbow_stiffness"])
    feasible = taut & stable
    for name, bound in limits.items():
        column = name if LIMITS[name].of_design else LIMITS[name].column
        if column in columns and name != "min_elbow_stiffness":
            feasible = feasible & ~(LIMITS[name].beyond(columns[column], bound) > SLACK_TOLERANCE * abs(bound))
    return {"taut": taut, "stable": stable, "feasible": feasible}


def of_design(design: Design, found: Found) -> Found:
    """What limits bound of designs that no state has, by the limit's name, and the contact pressure (Pa)."""
    pressure = contact_pressure(design, found["max_extensor_distal"][..., np.newaxis, np.newaxis])
    values = {name: limit.of_design(design) for name, limit in LIMITS.items() if limit.of_design is not None}
    values["max_contact_pressure"] = pressure
    shape = found["slack"].shape
    return {name: np.broadcast_to(value, (*shape, 1, 1))[..., 0, 0] for name, value in values.items()}


def of_forms(names: Iterable[str], at: Situation) -> Found:
    """What designs come to in limits on forms of states, over the last two axes; NaN where no state has a result."""
    state, found = State.of(at), {}
    for name in names:
        values = np.atleast_2d(LIMITS[name].value(state))
        found[name] = (np.fmin if LIMITS[name].from_below else np.fmax).reduce(values, axis=(-2, -1))
    return found


def _with_sign(lowest: Array, highest: Array) -> Array:
    """Of two values the one of larger magnitude, with its sign."""
    return np.where(-lowest > highest, lowest, highest)
