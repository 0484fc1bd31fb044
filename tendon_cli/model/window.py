"""The window of pretension: the pretensions of both sides at which a design keeps every limit.

Every limit on a form of a state (`limits`) is a half-line in the common pretension, so a design's
window over its states is one interval, and each of its ends belongs to one limit in one state.
Nothing is searched; the ends are exact. The window is a fold over states: `begin`, `fold` in any
portions, `finish`. Arguments broadcast as in `actuator`; SI units, angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds, bound_ends
from tendon_cli.model.design import Design
from tendon_cli.model.extremes import Extremes, nan_where
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.limits import (
    EXTENSOR_SLACK,
    FLEXOR_SLACK,
    LIMIT_NAMES,
    NO_EQUILIBRIUM,
    NOTHING,
    PRETENSION,
    Codes,
)
from tendon_cli.model.setting import Reading, pretension_of, reading_at
from tendon_cli.model.statics import SLACK_TOLERANCE

Element = TypeVar("Element", bound=np.generic)


@dataclass(frozen=True, eq=False)
class Ends:
    """Pretensions at which designs keep all limits in all states, from `low` to `high`.

    A window is empty where low > high. Both are NaN where no pretension keeps some limit.
    """

    low: Array
    """Smallest pretension of both sides, at least 0, N."""
    high: Array
    """Largest pretension, N; infinite if nothing bounds it."""
    low_state: Rows
    """Index of the binding state among the design's states; where the ends are NaN, of the first
    state that no pretension satisfies; -1 if the limit belongs to no state."""
    high_state: Rows
    """The same for the largest."""
    low_angle: Array
    """Elbow angle that binds, rad, if it differs from that of the state (`whole_motion`), else
    NaN."""
    high_angle: Array
    """The same for the largest."""

    @property
    def is_open(self) -> Flags:
        """True where some pretension keeps all limits."""
        return np.asarray(self.low <= self.high)


AnyEnds = TypeVar("AnyEnds", bound=Ends)


@dataclass(frozen=True, eq=False)
class Window(Ends):
    """Ends of windows with the limits that bind there, or that no pretension keeps."""

    low_by: Codes
    """Index into LIMIT_NAMES, or NOTHING."""
    high_by: Codes
    """The same for the largest."""


class StateEnds(NamedTuple):
    """Windows of single states."""

    low: Array
    """Smallest pretension, N."""
    high: Array
    """Largest pretension, N; infinite where nothing bounds it."""
    low_by: Codes
    """Limit that sets the smallest, index into LIMIT_NAMES."""
    high_by: Codes
    """Limit that sets the largest; if nothing bounds it, the side that goes slack first."""
    blocked: Codes
    """First limit that no pretension keeps, or NOTHING."""


def begin(shape: tuple[int, ...]) -> Extremes:
    """Return the tightest ends over no state yet, for designs of a shape.

    They are `low` and `high` (N), the states that set them, and the first state that is `blocked`.
    States of the same designs may then be folded in several portions.
    """
    starts = {
        "low": -np.inf,
        "high": np.inf,
        "low_state": -1.0,
        "high_state": -1.0,
        "blocked": np.inf,
    }
    return {name: np.full(shape, start) for name, start in starts.items()}


def fold(folded: Extremes, at: State, bounds: Bounds, states: Rows) -> None:
    """Tighten ends by more states, in place.

    Args:
        folded: Tightest ends so far.
        at: States, which lie along the last two axes.
        bounds: Limits of the designs.
        states: Indices of these states among the design's, in the shape of the last two axes.
    """
    ends = ends_of_states(at, bounds)
    shape = (*folded["low"].shape, *states.shape)
    numbers = states.ravel().astype(np.float64)

    def flat(values: npt.NDArray[Element]) -> npt.NDArray[Element]:
        """Return values of states as (designs, states)."""
        return np.broadcast_to(values, shape).reshape(*shape[:-2], -1)

    low = np.where(np.isnan(ends.low), -np.inf, ends.low)
    high = np.where(np.isnan(ends.high), np.inf, ends.high)
    for name, values, sign in (("low", low, 1.0), ("high", high, -1.0)):
        of_states = flat(values)
        place = np.argmax(sign * of_states, axis=-1)
        end = np.take_along_axis(of_states, place[..., np.newaxis], axis=-1)[..., 0]
        state = numbers[place]
        known = folded[name]
        known_state = folded[f"{name}_state"]
        is_tighter = sign * end > sign * known
        is_earlier = (end == known) & np.isfinite(end) & (state < known_state)
        is_new = is_tighter | is_earlier
        np.copyto(known, end, where=is_new)
        np.copyto(known_state, state, where=is_new)
    first = np.min(np.where(flat(ends.blocked) != NOTHING, numbers, np.inf), axis=-1)
    np.minimum(folded["blocked"], first, out=folded["blocked"])


def finish(folded: Extremes, design: Design, bounds: Bounds) -> Ends:
    """Return the ends, from the tightest over all states and from what holds for whole designs."""
    is_broken = drop_state_axes(broken_by_design(design, bounds)) != NOTHING
    largest = drop_state_axes(ceiling(design, bounds))
    is_empty = np.isfinite(folded["blocked"]) | is_broken
    low = nan_where(is_empty, np.maximum(folded["low"], 0.0))
    high = nan_where(is_empty, np.minimum(folded["high"], largest))
    blocked_state = np.where(is_broken, -1.0, folded["blocked"])
    is_low_zero = ~(folded["low"] > 0.0)
    is_high_ceiling = (largest < folded["high"]) | np.isinf(folded["high"])
    low_state = np.where(is_low_zero, -1.0, folded["low_state"])
    high_state = np.where(is_high_ceiling, -1.0, folded["high_state"])
    return Ends(
        low=low,
        high=high,
        low_state=np.where(is_empty, blocked_state, low_state).astype(np.int64),
        high_state=np.where(is_empty, blocked_state, high_state).astype(np.int64),
        low_angle=np.full(low.shape, np.nan),
        high_angle=np.full(high.shape, np.nan),
    )


def ceiling(design: Design, bounds: Bounds) -> Array:
    """Return the largest F0 that `max_pretension` allows, itself a reading of the design's kind."""
    largest = bounds.of(design).get("max_pretension")
    if largest is None:
        return np.full((), np.inf)
    return pretension_of(design, largest)


def as_read(ends: AnyEnds, design: Design) -> AnyEnds:
    """Return ends in the reading in which the design's pretension is given.

    They are NaN where the reading does not grow with the pretension, and so does not tell it. Over
    a slack tendon a gauge shows the same whatever the pretension: an upper end that lies there is
    below all readings, since none tells that the pretension is low enough.
    """
    if design.shows_f0:
        return ends
    reading = Reading.of(design)
    return read_by(ends, Reading(*map(drop_state_axes, vars(reading).values())))


def read_by(ends: AnyEnds, reading: Reading) -> AnyEnds:
    """Return ends as a gauge shows them (`as_read`), without axes of states."""
    tells = reading.gain > 0.0
    with np.errstate(invalid="ignore"):
        low = reading.shown(ends.low)
        high = reading.while_taut(ends.high)
    return replace(ends, low=np.where(tells, low, np.nan), high=np.where(tells, high, np.nan))


def reading_of(pretension: Array, design: Design) -> Array:
    """Return pretensions of designs, N, in the reading in which the design's own is given, N."""
    if design.shows_f0:
        return pretension
    with np.errstate(invalid="ignore"):
        return reading_at(design, pretension[..., np.newaxis, np.newaxis])[..., 0, 0]


def broken_by_design(design: Design, bounds: Bounds) -> Codes:
    """Return the first limit on a number of the design that it breaks at any pretension.

    That is the limit's code, or NOTHING.
    """
    bounds = bounds.of(design)
    broken = np.full((1, 1), NOTHING, dtype=np.int8)
    for limit in bounds.asked:
        code = LIMIT_NAMES.index(limit.name)
        if limit.of_design is None or code == PRETENSION:
            continue
        bound = bounds[limit.name]
        is_broken = limit.beyond(limit.of_design(design), bound) > SLACK_TOLERANCE * np.abs(bound)
        broken = np.where(is_broken & (broken == NOTHING), np.int8(code), broken)
    return broken


def with_binding_limits(
    ends: Ends, design: Design, elbow_angle: Array, flexion: Flags, bounds: Bounds
) -> Window:
    """Return ends with the limits that bind, computed anew in the binding states only.

    Args:
        ends: Ends of windows.
        design: Designs.
        elbow_angle: Angles of all states, (1, K), rad.
        flexion: Directions of all states, (D, 1).
        bounds: Limits of the designs.
    """
    broken = drop_state_axes(broken_by_design(design, bounds))

    def binding(state: Rows, beside: Array, *, upper: bool) -> Codes:
        """Return the codes of the limits that bind in states, or at the angles `beside` them."""
        direction, place = np.divmod(np.maximum(state, 0), elbow_angle.size)
        angle = np.where(np.isnan(beside), elbow_angle.ravel()[place], beside)
        at = State.of(
            design,
            angle[..., np.newaxis, np.newaxis],
            flexion.ravel()[direction][..., np.newaxis, np.newaxis],
        )
        of_states = ends_of_states(at, bounds)
        in_state = drop_state_axes(of_states.high_by if upper else of_states.low_by)
        blocked = drop_state_axes(of_states.blocked)
        in_no_state = np.full((), NOTHING)
        if upper:
            in_no_state = np.where(np.isfinite(ends.high), PRETENSION, NOTHING)
        code = np.where(
            np.isnan(ends.low),
            np.where(state < 0, broken, blocked),
            np.where(state < 0, in_no_state, in_state),
        )
        return code.astype(np.int8)

    return Window(
        **vars(ends),
        low_by=binding(ends.low_state, ends.low_angle, upper=False),
        high_by=binding(ends.high_state, ends.high_angle, upper=True),
    )


def ends_of_states(at: State, bounds: Bounds) -> StateEnds:
    """Return the window of each state, and the limits that set its ends."""
    required = at.response.required
    low = np.zeros(())
    high = np.full((), np.inf)
    low_by = slack_codes(at)
    high_by = low_by
    blocked = np.where(np.isnan(required), np.int8(NO_EQUILIBRIUM), np.int8(NOTHING))
    for end in bound_ends(at, bounds):
        code = np.int8(end.code)
        moves = end.gain != 0.0
        below = np.where(end.is_lower & moves, end.margin, -np.inf)
        above = np.where(~end.is_lower & moves, end.margin, np.inf)
        blocked = np.where(end.is_hopeless & (blocked == NOTHING), code, blocked)
        low_by = np.where(below > low, code, low_by)
        low = np.maximum(low, below)
        high_by = np.where(above < high, code, high_by)
        high = np.minimum(high, above)
    return StateEnds(required + low, required + high, low_by, high_by, blocked)


def slack_codes(at: State) -> Codes:
    """Return the code of the side that goes slack first as pretension falls."""
    return np.where(at.coupling.elbow_torque < 0.0, np.int8(FLEXOR_SLACK), np.int8(EXTENSOR_SLACK))


def drop_state_axes(values: npt.NDArray[Element]) -> npt.NDArray[Element]:
    """Drop the two axes of states, each one long, from values of designs that have axes."""
    return values.reshape(values.shape[:-2]) if values.ndim else values
