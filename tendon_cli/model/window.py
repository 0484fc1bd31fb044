"""The window of pretension: between which pretensions of both sides a design keeps every limit, exactly.

Every limit on a form of a state (`limits`) is a half-line in the common pretension, so a design's window over its
states is one interval, and each of its ends belongs to one limit in one state. Nothing is searched. It is a fold over
states: `begin`, `fold` in any portions, `finished`. Arguments broadcast as in `actuator`; SI units, angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds, ends_of
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import (
    EXTENSOR_SLACK,
    FLEXOR_SLACK,
    LIMIT_NAMES,
    NO_EQUILIBRIUM,
    NOTHING,
    PRETENSION,
    Codes,
)
from tendon_cli.model.setting import pretension_of, shown
from tendon_cli.model.statics import SLACK_TOLERANCE

Positions = npt.NDArray[np.int64]
Kind = TypeVar("Kind", bound=np.generic)
Found = dict[str, Array]
"""The tightest ends over states, by name: `low`, `high`, their states, and the first state that is `blocked`."""


@dataclass(frozen=True, eq=False)
class Ends:
    """The pretensions at which designs keep all limits in all states: from `low` to `high`; empty where low > high.

    Both are NaN where no pretension could do.
    """

    low: Array
    """Smallest pretension of both sides, at least 0, N."""
    high: Array
    """Largest, N; infinite where nothing bounds it."""
    low_state: Positions
    """The state that binds, by its place among the design's states, or where no pretension could do, the first in
    which that is so; -1 where the limit belongs to no state."""
    high_state: Positions
    low_angle: Array
    """The elbow angle that binds, rad, if it is not that of the state but beside it (`between`); else NaN."""
    high_angle: Array

    @property
    def is_open(self) -> npt.NDArray[np.bool_]:
        """Whether any pretension keeps all limits."""
        return np.asarray(self.low <= self.high)


Kept = TypeVar("Kept", bound=Ends)


@dataclass(frozen=True, eq=False)
class Window(Ends):
    """The ends of windows with the limits that bind there, or where no pretension could do, the reason."""

    low_by: Codes
    """Index into LIMIT_NAMES, or NOTHING."""
    high_by: Codes


def window(design: Design, elbow_angle: Array, flexion: Flags, bounds: Bounds) -> Window:
    """The windows of designs over their states: of angles (1, K) in each direction, (D, 1), or (1, K) in a motion."""
    at, states = State.of(design, elbow_angle, flexion), (len(flexion), elbow_angle.size)
    of_design = _ceiling(design, bounds), _broken_by_design(design, bounds)
    shape = np.broadcast_shapes(
        *(each.shape for each in (*ends_of_states(at, bounds), *of_design)), states
    )
    folded = begin(shape[:-2])
    fold(folded, at, bounds, np.arange(states[0] * states[1]).reshape(states))
    return named(finished(folded, design, bounds), design, elbow_angle, flexion, bounds)


def begin(shape: tuple[int, ...]) -> Found:
    """No state yet, for designs of a shape; other angles of the same designs may be folded in turn."""
    starts = {
        "low": -np.inf,
        "high": np.inf,
        "low_state": -1.0,
        "high_state": -1.0,
        "blocked": np.inf,
    }
    return {name: np.full(shape, start) for name, start in starts.items()}


def fold(folded: Found, at: State, bounds: Bounds, states: Positions) -> None:
    """Take in states, which lie along the last two axes and whose places among the design's are `states`."""
    low, high, _, _, blocked = ends_of_states(at, bounds)
    whole = (*folded["low"].shape, *states.shape)
    numbers = states.ravel().astype(np.float64)

    def flat(values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
        return np.broadcast_to(values, whole).reshape(*whole[:-2], -1)

    ends = (
        ("low", np.where(np.isnan(low), -np.inf, low), 1.0),
        ("high", np.where(np.isnan(high), np.inf, high), -1.0),
    )
    for name, values, sign in ends:
        spread = flat(values)
        place = np.argmax(sign * spread, axis=-1)
        end, state, before = _at(spread, place), numbers[place], folded[f"{name}_state"]
        tighter = (sign * end > sign * folded[name]) | (
            (end == folded[name]) & np.isfinite(end) & (state < before)
        )
        np.copyto(folded[name], end, where=tighter)
        np.copyto(before, state, where=tighter)
    first = np.min(np.where(flat(blocked) != NOTHING, numbers, np.inf), axis=-1)
    np.minimum(folded["blocked"], first, out=folded["blocked"])


def finished(folded: Found, design: Design, bounds: Bounds) -> Ends:
    """The ends, from the tightest over all states and from what holds for the whole design."""
    fixed = _over_design(_broken_by_design(design, bounds)) != NOTHING
    ceiling = _over_design(_ceiling(design, bounds))
    low, high, stuck = folded["low"], folded["high"], np.isfinite(folded["blocked"])
    empty = stuck | fixed
    state = np.where(fixed, -1.0, folded["blocked"])
    by_floor, by_ceiling = ~(low > 0.0), (ceiling < high) | np.isinf(high)
    low_state = np.where(empty, state, np.where(by_floor, -1.0, folded["low_state"]))
    high_state = np.where(empty, state, np.where(by_ceiling, -1.0, folded["high_state"]))
    return Ends(
        low=np.where(empty, np.nan, np.maximum(low, 0.0)),
        high=np.where(empty, np.nan, np.minimum(high, ceiling)),
        low_state=low_state.astype(np.int64),
        high_state=high_state.astype(np.int64),
        low_angle=np.full(low.shape, np.nan),
        high_angle=np.full(high.shape, np.nan),
    )


def _ceiling(design: Design, bounds: Bounds) -> Array:
    """The largest F0 that is allowed, of a limit that is read as the design's pretension is."""
    most = bounds.get("max_pretension")
    return np.full((), np.inf) if most is None else pretension_of(design, most)


def as_read(ends: Kept, design: Design) -> Kept:
    """Ends as the design's pretension is read."""
    with np.errstate(invalid="ignore"):
        low, high = (
            shown(design, end[..., np.newaxis, np.newaxis])[..., 0, 0]
            for end in (ends.low, ends.high)
        )
    return replace(ends, low=low, high=high)


def _broken_by_design(design: Design, bounds: Bounds) -> Codes:
    """The first limit on a number of the design that it breaks whatever its pretension, by its code, or NOTHING."""
    code = np.full((1, 1), NOTHING, dtype=np.int8)
    for limit in bounds.asked:
        if limit.of_design is not None and LIMIT_NAMES.index(limit.name) != PRETENSION:
            bound = bounds[limit.name]
            broken = limit.beyond(limit.of_design(design), bound) > SLACK_TOLERANCE * np.abs(bound)
            code = np.where(
                broken & (code == NOTHING), np.int8(LIMIT_NAMES.index(limit.name)), code
            )
    return code


def named(ends: Ends, design: Design, elbow_angle: Array, flexion: Flags, bounds: Bounds) -> Window:
    """Ends with the limits that bind, worked out anew in the states that bind alone.

    The states are all of `elbow_angle`, (1, K), in each direction of `flexion`, (D, 1), or (1, K) along a trajectory.
    """
    limits, fixed = [], _over_design(_broken_by_design(design, bounds))
    for state, beside, upper in (
        (ends.low_state, ends.low_angle, False),
        (ends.high_state, ends.high_angle, True),
    ):
        direction, place = np.divmod(np.maximum(state, 0), elbow_angle.size)
        angle = np.where(np.isnan(beside), elbow_angle.ravel()[place], beside)[
            ..., np.newaxis, np.newaxis
        ]
        way = np.broadcast_to(flexion, (len(flexion), elbow_angle.size))[direction, place]
        at = State.of(design, angle, way[..., np.newaxis, np.newaxis])
        _, _, low_by, high_by, blocked = ends_of_states(at, bounds)
        of_state, reason = map(_over_design, (high_by if upper else low_by, blocked))
        of_none = np.where(np.isfinite(ends.high), PRETENSION, NOTHING) if upper else NOTHING
        by = np.where(
            np.isnan(ends.low),
            np.where(state < 0, fixed, reason),
            np.where(state < 0, of_none, of_state),
        )
        limits.append(by.astype(np.int8))
    return Window(**vars(ends), low_by=limits[0], high_by=limits[1])


def ends_of_states(at: State, bounds: Bounds) -> tuple[Array, Array, Codes, Codes, Codes]:
    """Smallest and largest pretension of each state, the limits that say so, and the one no pretension could keep."""
    required, slack = at.response.required, slack_codes(at)
    low, high, low_by, high_by = np.zeros(()), np.full((), np.inf), slack, slack
    blocked = np.where(np.isnan(required), np.int8(NO_EQUILIBRIUM), np.int8(NOTHING))
    for code, end, is_lower, gain, hopeless in ends_of(at, bounds):
        below = np.where(is_lower & (gain != 0.0), end, -np.inf)
        above = np.where(~is_lower & (gain != 0.0), end, np.inf)
        blocked = np.where(hopeless & (blocked == NOTHING), np.int8(code), blocked)
        low_by, low = np.where(below > low, np.int8(code), low_by), np.maximum(low, below)
        high_by, high = np.where(above < high, np.int8(code), high_by), np.minimum(high, above)
    return required + low, required + high, low_by, high_by, blocked


def slack_codes(at: State) -> Codes:
    """Which side goes slack first as pretension falls."""
    return np.where(at.coupling.elbow_torque < 0.0, np.int8(FLEXOR_SLACK), np.int8(EXTENSOR_SLACK))


def _at(values: npt.NDArray[Kind], where: Positions) -> npt.NDArray[Kind]:
    taken: npt.NDArray[Kind] = np.take_along_axis(values, where[..., np.newaxis], axis=-1)[..., 0]
    return taken


def _over_design(values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
    """Values of designs, which have two axes of one state where they have any."""
    return values.reshape(values.shape[:-2]) if values.ndim else values
