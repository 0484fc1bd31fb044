"""Windows of pretension along a motion in time.

Which way the tendons slide depends on the pretension, too, so that a window is no longer where all
half-lines of its states meet: at each pretension only the states count that hold there, and where
the tendons turn those of the other direction (`moving`). A pretension that keeps every limit
whichever way the tendons slide is in the window; from there an end moves outward from limit to
limit, as long as those that count are kept. If there is no such pretension, one is sought among
samples. SI units, angles in radians.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, shape_of
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING, POWER, PRETENSION, Codes
from tendon_cli.model.motor import select_points
from tendon_cli.model.moving import Moving, motion_columns
from tendon_cli.model.power_window import widest
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.model.window import Window, broken_by_design, ceiling, ends_of_states
from tendon_cli.quantities import SIDES

OF_WHAT_HOLDS = ("min_elbow_stiffness", "peak_motor_speed")
"""Limits for which only the states that hold count, also where the tendons turn."""
_SAMPLES = 17
"""Pretensions among which a window is sought if none suits both directions everywhere."""
_MOVES = 12
"""Most moves of an end from limit to limit before it is bisected."""
_HALVINGS = 50
_SAME = 1e-12
"""Relative distance within which two pretensions are the same."""
_ROOT_STEPS = 90
"""Most steps of the search for an end that power sets, a third of them halvings."""
_CLOSE = 1e-11
"""Relative width of an interval in which an end is known well enough."""
_TINY = 1e-9
"""Least bound on power, W, to which an excess is related."""
_STATES_AT_ONCE = 2**16
"""States of a portion of samples."""
_STEP = 100.0  # N; beyond the largest limit, if nothing bounds a window that is sought
_DOUBLINGS = 16
"""Most doublings of a window without an upper end, until the limit on power is broken."""


def window_along(design: Design, trajectory: Trajectory, bounds: Bounds) -> Window:
    """Return the windows of designs along a trajectory, with all limits.

    The binding states are numbered over both directions, flexion first, and all samples.

    Args:
        design: Designs, which have the trajectory.
        trajectory: The motion.
        bounds: Limits of the designs.
    """
    bounds = bounds.of(design)
    design = replace(design, limits={})
    over_design = (ceiling(design, bounds), broken_by_design(design, bounds))
    of_bounds = [np.shape(bound)[:-2] for bound in bounds.values()]
    shape = np.broadcast_shapes(
        shape_of(design), *(values.shape[:-2] for values in over_design), *of_bounds
    )
    flat_shape = (*(shape or (1,)), 1, 1)
    count = math.prod(shape)
    places = np.unravel_index(np.arange(count), shape or (1,))
    # A pretension of each, so that some of them can be selected whatever else they share.
    unset = np.zeros(flat_shape)
    sides = {name: replace(getattr(design, name), pretension=unset) for name in SIDES}
    flat = select_points(replace(design, **sides), flat_shape, places)
    largest = np.broadcast_to(over_design[0], flat_shape).ravel()
    broken = np.broadcast_to(over_design[1], flat_shape).ravel()
    search = Search(flat, trajectory, _flat_bounds(bounds, flat_shape))
    found = _within_the_design(search.windows(), largest, broken)
    return Window(**{name: values.reshape(shape) for name, values in vars(found).items()})


def _flat_bounds(bounds: Bounds, shape: tuple[int, ...]) -> Bounds:
    """Return bounds along a single axis of designs if they vary among these."""
    flat = {
        name: np.broadcast_to(bound, shape).reshape(-1, 1, 1) if np.ndim(bound) else bound
        for name, bound in bounds.items()
    }
    return Bounds(speed=bounds.speed, **flat)


def _within_the_design(found: Window, largest: Array, broken: Codes) -> Window:
    """Return windows with the limits on whole designs: the largest pretension, and broken ones."""
    is_ceiling = (largest < found.high) & ~np.isnan(found.high)
    is_broken = broken != NOTHING
    return Window(
        low=np.where(is_broken, np.nan, found.low),
        high=np.where(is_broken, np.nan, np.minimum(found.high, largest)),
        low_state=np.where(is_broken, -1, found.low_state),
        high_state=np.where(is_broken | is_ceiling, -1, found.high_state),
        low_angle=found.low_angle,
        high_angle=found.high_angle,
        low_by=np.where(is_broken, broken, found.low_by).astype(np.int8),
        high_by=np.where(is_broken, broken, np.where(is_ceiling, PRETENSION, found.high_by)).astype(
            np.int8
        ),
    )


class Tightest(NamedTuple):
    """Tightest ends of the states that count at a pretension, (designs,) each."""

    low: Array
    """Largest pretension that any needs, N; infinite if none suits one."""
    low_state: Rows
    """State that needs it."""
    low_by: Codes
    """Limit that needs it, index into LIMIT_NAMES."""
    high: Array
    """Smallest that any allows, N; minus infinite if none suits one."""
    high_state: Rows
    """State that allows no more."""
    high_by: Codes
    """Limit that allows no more."""

    def select(self, rows: Rows) -> Tightest:
        """Select the ends of some designs."""
        return Tightest(
            self.low[rows],
            self.low_state[rows],
            self.low_by[rows],
            self.high[rows],
            self.high_state[rows],
            self.high_by[rows],
        )

    def excess(self, pretension: Array) -> Array:
        """Return the distance of pretensions from those that all these states allow, N."""
        reserve = _SAME * np.abs(pretension)
        return np.asarray(np.maximum(self.low - pretension, pretension - self.high) - reserve)

    def allows(self, pretension: Array) -> Flags:
        """Return where a pretension keeps the limits of all these states."""
        return self.excess(pretension) <= 0.0


class CandidateEnds(NamedTuple):
    """Ends that limits set in candidates at the samples that count, (designs, 2, samples) each."""

    low: Array
    """Smallest pretension, N; infinite where none keeps a limit."""
    low_by: Codes
    """Limit that sets it."""
    high: Array
    """Largest pretension, N; minus infinite where none keeps a limit."""
    high_by: Codes
    """Limit that sets it."""


@dataclass(frozen=True, eq=False)
class Search:
    """Designs along a single axis, (N, 1, 1), whose windows along a trajectory are sought."""

    design: Design
    trajectory: Trajectory
    bounds: Bounds

    @cached_property
    def moving(self) -> Moving:
        """The designs along the trajectory."""
        moving = Moving.of(self.design, self.trajectory)
        # Worked out once for all pretensions.
        vars(moving.candidates).update(response=moving.candidates.response)
        return moving

    @property
    def count(self) -> int:
        """Number of designs."""
        return math.prod(self.moving.shape[:-1])

    def select(self, rows: Rows) -> Search:
        """Select some of the designs."""
        shape = (self.count, 1, 1)
        bounds = {
            name: np.asarray(bound)[rows] if np.ndim(bound) else bound
            for name, bound in self.bounds.items()
        }
        return Search(
            select_points(self.design, shape, (rows,)),
            self.trajectory,
            Bounds(speed=self.bounds.speed, **bounds),
        )

    # --- Limits on states -------------------------------------------------------------------------

    @cached_property
    def _ends(self) -> tuple[CandidateEnds, CandidateEnds]:
        """Ends of limits that count in both directions where tendons turn, and of the others."""
        free = {"min_elbow_stiffness": -np.inf}
        held = {name: self.bounds[name] for name in OF_WHAT_HOLDS if name in self.bounds}
        both = {name: bound for name, bound in self.bounds.items() if name not in OF_WHAT_HOLDS}
        speed = self.bounds.speed
        return (
            self._ends_of(Bounds(speed=speed, **free, **both)),
            self._ends_of(Bounds(speed=speed, **held)),
        )

    def _ends_of(self, bounds: Bounds) -> CandidateEnds:
        """Return the ends that some limits set."""
        ends = ends_of_states(self.moving.candidates, bounds)
        counted = self.trajectory.counted
        shape = (self.count, 2, self.moving.shape[-1])
        low, high, low_by, high_by, blocked = (
            np.broadcast_to(values, shape)[..., counted] for values in ends
        )
        is_blocked = blocked != NOTHING
        return CandidateEnds(
            low=np.where(is_blocked, np.inf, low),
            low_by=np.where(is_blocked, blocked, low_by),
            high=np.where(is_blocked, -np.inf, high),
            high_by=np.where(is_blocked, blocked, high_by),
        )

    def _counts(self, moving: Moving) -> tuple[Flags, Flags]:
        """Return where candidates count, (..., 2, samples): those that may hold, and that do."""
        counted = self.trajectory.counted
        sliding = moving.sliding.within(counted)
        holds = np.concatenate([sliding.flexion, ~sliding.flexion], axis=-2)
        return holds | sliding.turning, holds & ~sliding.passing

    def tightest(self, pretension: Array) -> Tightest:
        """Return the tightest ends of the states that count at pretensions, (..., N) each, N."""
        return self._tightest(self._counts(self._at(pretension)))

    def _at(self, pretension: Array) -> Moving:
        """Return the designs at pretensions, (..., N), N."""
        return self.moving.at_pretension(pretension[..., np.newaxis, np.newaxis])

    def _tightest(self, counts: tuple[Flags, Flags]) -> Tightest:
        """Return the tightest ends of the candidates that count, for either kind of limit."""
        values = []
        for sign, end, code in ((1.0, "low", "low_by"), (-1.0, "high", "high_by")):
            largest: Any = -np.inf
            state: Any = -1
            by: Any = np.int8(NOTHING)
            for ends, which in zip(self._ends, counts, strict=True):
                asked = np.where(which, sign * getattr(ends, end), -np.inf)
                designs = asked.shape[:-2]
                flat = asked.reshape(*designs, -1)
                codes = np.broadcast_to(getattr(ends, code), asked.shape).reshape(flat.shape)
                place = flat.argmax(axis=-1)[..., np.newaxis]
                top = np.take_along_axis(flat, place, axis=-1)[..., 0]
                is_tighter = top > largest
                largest = np.where(is_tighter, top, largest)
                state = np.where(is_tighter, self._number(place[..., 0]), state)
                by = np.where(is_tighter, np.take_along_axis(codes, place, axis=-1)[..., 0], by)
            values += [sign * largest, state, by]
        return Tightest(*values)

    def _number(self, place: Rows) -> Rows:
        """Return the numbers of candidates over both directions and all samples."""
        counted = self.trajectory.counted
        direction, sample = np.divmod(place, counted.stop - counted.start)
        return np.asarray(direction * len(self.trajectory.time) + counted.start + sample)

    # --- Windows ----------------------------------------------------------------------------------

    def windows(self) -> Window:
        """Return the windows of the designs, without limits on whole designs."""
        everywhere = np.ones((1, 2, 1), dtype=np.bool_)
        inner = self._tightest((everywhere, everywhere))
        low = np.maximum(inner.low, 0.0)
        window = _window_of(inner)
        grows = np.flatnonzero(low <= inner.high)
        self._move(window, grows, upper=True)
        self._move(window, grows, upper=False)
        seeks = np.flatnonzero(~(low <= inner.high))
        if len(seeks):
            _put(window, seeks, self.select(seeks).sampled())
        is_zero = ~(window.low > 0.0) & ~np.isnan(window.low)
        window.low[is_zero] = 0.0
        window.low_state[is_zero] = -1
        window.low_by[is_zero] = NOTHING
        is_endless = np.isinf(window.high)
        window.high_state[is_endless] = -1
        window.high_by[is_endless] = NOTHING
        return self._within_power(window)

    def _move(self, window: Window, rows: Rows, *, upper: bool) -> None:
        """Move an end of windows outward, in place, as far as the states that count allow.

        Args:
            window: Windows, within which no direction of sliding breaks a limit.
            rows: Designs whose windows are moved.
            upper: True for upper ends.
        """
        if not len(rows):
            return
        name = "high" if upper else "low"
        search = self if len(rows) == self.count else self.select(rows)
        inside = np.maximum(getattr(window, name)[rows], 0.0)
        last = self._beyond(rows)
        inside = np.minimum(inside, last)
        for _ in range(_MOVES):
            if not len(rows):
                return
            tight = search.tightest(inside)
            target = np.minimum(tight.high, last) if upper else np.maximum(tight.low, 0.0)
            is_settled = np.abs(target - inside) <= _SAME * np.abs(target)
            is_open = is_settled & upper & (tight.high > last)
            _set(window, name, rows[is_settled], tight.select(np.flatnonzero(is_settled)))
            window.high[rows[is_open]] = np.inf
            moves = np.flatnonzero(~is_settled)
            rows = rows[moves]
            if not len(rows):
                return
            search = search.select(moves)
            last = last[moves]
            inside = inside[moves]
            outside = target[moves]
            beyond = search.tightest(outside)
            is_kept = beyond.allows(outside)
            cut = np.flatnonzero(~is_kept)
            if len(cut):
                part = search.select(cut)
                ends, broken = part.bisect(inside[cut], outside[cut])
                _set(window, name, rows[cut], broken, ends)
            kept = np.flatnonzero(is_kept)
            rows = rows[kept]
            if len(rows) and len(cut):
                search = search.select(kept)
            inside = outside[kept]
            last = last[kept]
        if len(rows):
            _set(window, name, rows, search.tightest(inside), inside)

    def _beyond(self, rows: Rows) -> Array:
        """Return pretensions beyond every limit of candidates that is one, (rows,), N."""
        largest = np.zeros(len(rows))
        for ends in self._ends:
            for values in (ends.low[rows], ends.high[rows]):
                finite = np.where(np.isfinite(values), values, 0.0)
                largest = np.maximum(largest, finite.max(axis=(1, 2)))
        return largest + _STEP

    def bisect(self, inside: Array, outside: Array) -> tuple[Array, Tightest]:
        """Bisect between pretensions that keep all limits and some that do not, (N,) each, N.

        Returns:
            The last that keep them, and the tightest ends just beyond.
        """
        for _ in range(_HALVINGS):
            middle = 0.5 * (inside + outside)
            keeps = self.tightest(middle).allows(middle)
            inside = np.where(keeps, middle, inside)
            outside = np.where(keeps, outside, middle)
        return inside, self.tightest(outside)

    def sampled(self) -> Window:
        """Return windows found among samples, or without one the limits that conflict.

        The widest interval of samples that keep them is used.
        """
        least = np.full(self.count, -np.inf)
        most = np.full(self.count, np.inf)
        for ends in self._ends:
            least = np.maximum(least, ends.low.min(axis=1).max(axis=1))
            most = np.minimum(most, ends.high.max(axis=1).min(axis=1))
        last = np.minimum(most, self._beyond(np.arange(self.count)))
        first = np.clip(least, 0.0, last)
        samples = _spread(first, last)  # (N, samples), N
        tight = self._at_samples(samples)
        excess = tight.excess(samples.ravel()).reshape(samples.shape)
        window = _window_of(tight.select(_flat_place(excess.argmin(axis=1))))
        start, stop = widest(excess <= 0.0)
        has_kept = start >= 0
        is_unclear = ~has_kept & (window.low <= window.high)
        window.low[is_unclear] = np.nan
        window.high[is_unclear] = np.nan
        for name, inner, step in (("low", start, -1), ("high", stop, 1)):
            outer = inner + step
            is_inside = has_kept & (outer >= 0) & (outer < _SAMPLES)
            edge = np.take_along_axis(samples, np.maximum(inner, 0)[:, np.newaxis], axis=1)[:, 0]
            at_edge = np.flatnonzero(has_kept & ~is_inside)
            _set(window, name, at_edge, tight.select(_flat_place(inner)[at_edge]), edge[at_edge])
            cut = np.flatnonzero(is_inside)
            if len(cut):
                found, broken = self.select(cut).bisect(edge[cut], samples[cut, outer[cut]])
                _set(window, name, cut, broken, found)
        return window

    def _at_samples(self, samples: Array) -> Tightest:
        """Return the tightest ends at samples, (N, samples) N, of each design in turn."""
        first = self.tightest(samples[:, 0])
        found: list[Any] = [np.repeat(values[:, np.newaxis], _SAMPLES, axis=1) for values in first]
        # Where limits conflict at every pretension, all samples are one.
        apart = np.flatnonzero(samples[:, -1] > samples[:, 0])
        if len(apart):
            search = self if len(apart) == self.count else self.select(apart)
            for part in search.portions(1, _SAMPLES):
                tight: tuple[Any, ...] = search.tightest(samples[apart, part].T)
                for of_all, values in zip(found, tight, strict=True):
                    of_all[apart, part] = values.T
        return Tightest(*(values.ravel() for values in found))

    def portions(self, first: int, last: int) -> Iterator[slice]:
        """Yield slices of samples of pretension at which all designs are worked out together."""
        step = max(1, _STATES_AT_ONCE // (self.count * len(self.trajectory.time)))
        for start in range(first, last, step):
            yield slice(start, min(start + step, last))

    # --- Power ------------------------------------------------------------------------------------

    def _within_power(self, window: Window) -> Window:
        """Return windows with the limit on the motor's power, too.

        It allows no half-line of pretensions: the widest interval among samples is used, with ends
        by a search for the root of the excess.
        """
        rows = np.flatnonzero(window.low <= window.high)
        if not self.bounds.asks_power or not len(rows):
            return window
        search = self.select(rows)
        part = Window(**{name: values[rows] for name, values in vars(window).items()})
        search.cut_to_widest(part)
        for name in ("low", "high"):
            is_by_power = getattr(part, f"{name}_by") == POWER
            by_power = np.flatnonzero(is_by_power & np.isfinite(getattr(part, name)))
            if len(by_power):
                ends = getattr(part, name)[by_power]
                states = search.select(by_power).states_of_most_power(ends)
                getattr(part, f"{name}_state")[by_power] = states
        _put(window, rows, part)
        return window

    def cut_to_widest(self, window: Window) -> None:
        """Cut windows to the widest interval within the limit on power, in place."""
        samples = _spread(window.low, self._last_within_power(window))  # (N, samples), N
        parts = [self.power_excess(samples[:, part].T) for part in self.portions(0, _SAMPLES)]
        excess = np.concatenate(parts).T  # (N, samples)
        start, stop = widest(~(excess > 0.0))
        has_kept = start >= 0
        for name, inner, step in (("low", start, -1), ("high", stop, 1)):
            ends = getattr(window, name)
            outer = inner + step
            cut = np.flatnonzero(has_kept & (outer >= 0) & (outer < _SAMPLES))
            ends[~has_kept] = np.nan
            if len(cut):
                part = self.select(cut)
                ends[cut] = part.root(samples[cut, inner[cut]], samples[cut, outer[cut]])
            moved = np.append(np.flatnonzero(~has_kept), cut)
            getattr(window, f"{name}_by")[moved] = POWER
            getattr(window, f"{name}_state")[moved] = -1

    def _last_within_power(self, window: Window) -> Array:
        """Return the upper ends up to which the limit on power is sought, (N,), N.

        A window without an upper end is followed until it is broken: it may bind far beyond the
        other limits.
        """
        is_endless = np.isinf(window.high)
        last = np.where(is_endless, self._beyond(np.arange(self.count)), window.high)
        for _ in range(_DOUBLINGS):
            is_kept = is_endless & (self.power_excess(last) <= 0.0)
            if not is_kept.any():
                break
            last = np.where(is_kept, window.low + 2.0 * (last - window.low), last)
        return last

    def power_excess(self, pretension: Array) -> Array:
        """Return the excess over the limit on power at pretensions, (..., N), N, as a share of it.

        It is minus infinity where no sample has power.
        """
        name = LIMIT_NAMES[POWER]
        bound = np.asarray(self.bounds[name])
        of_designs = bound.reshape(-1) if bound.ndim else bound
        power = motion_columns(self._at(pretension), [name])[name]
        share = (power - of_designs) / np.maximum(of_designs, _TINY)
        return np.broadcast_to(np.where(np.isnan(share), -np.inf, share), pretension.shape)

    def root(self, inside: Array, outside: Array) -> Array:
        """Return the last pretensions that keep the limit on power, (N,), N.

        Between those that do and those that do not, a secant is tried and the interval halved in
        turn, so that jumps of the excess do no harm.
        """
        low = inside
        high = outside
        of_low = self.power_excess(low)
        of_high = self.power_excess(high)
        for attempt in range(_ROOT_STEPS):
            with np.errstate(divide="ignore", invalid="ignore"):
                share = of_low / (of_low - of_high)
            share = np.where(np.isfinite(share), share, 0.5)
            if attempt % 3 == 2:
                share = np.full(share.shape, 0.5)
            # A step past the root brings in the far end, too.
            nudge = np.where(attempt % 3 == 1, 1e-9, -1e-9)
            middle = low + np.clip(share + nudge, 0.0, 1.0) * (high - low)
            of_middle = self.power_excess(middle)
            keeps = of_middle <= 0.0
            low = np.where(keeps, middle, low)
            of_low = np.where(keeps, of_middle, of_low)
            high = np.where(keeps, high, middle)
            of_high = np.where(keeps, of_high, of_middle)
            if np.all(np.abs(high - low) <= _CLOSE * np.abs(high)):
                break
        return low

    def states_of_most_power(self, pretension: Array) -> Rows:
        """Return the states in which the motor gives most at pretensions, (N,), N."""
        moving = self._at(pretension)
        counted = self.trajectory.counted
        shape = (self.count, 1, len(self.trajectory.time))
        power = np.broadcast_to(moving.power, shape)
        known = np.where(moving.passing | np.isnan(power), -np.inf, power)[:, 0, counted]
        sample = counted.start + known.argmax(axis=1)
        flexes = moving.flexion.reshape(self.count, -1)[np.arange(self.count), sample]
        return np.asarray(np.where(flexes, 0, shape[-1]) + sample)


def _window_of(tight: Tightest) -> Window:
    """Return the tightest ends as windows; NaN where no pretension suits a state."""
    is_hopeless = np.isinf(tight.low) & (tight.low > 0.0)
    is_hopeless |= np.isinf(tight.high) & (tight.high < 0.0)
    unknown = np.full(len(tight.low), np.nan)
    return Window(
        low=np.where(is_hopeless, np.nan, tight.low),
        high=np.where(is_hopeless, np.nan, tight.high),
        low_state=tight.low_state.copy(),
        high_state=tight.high_state.copy(),
        low_angle=unknown.copy(),
        high_angle=unknown.copy(),
        low_by=tight.low_by.copy(),
        high_by=tight.high_by.copy(),
    )


def _spread(first: Array, last: Array) -> Array:
    """Return samples from first to last pretensions, (N, samples), N."""
    shares = np.linspace(0.0, 1.0, _SAMPLES)
    return np.asarray(first[:, np.newaxis] + (last - first)[:, np.newaxis] * shares)


def _flat_place(sample: Rows) -> Rows:
    """Return the places of one sample of each design, (N,), among all of all designs."""
    return np.arange(len(sample)) * _SAMPLES + sample


def _set(window: Window, name: str, rows: Rows, tight: Tightest, ends: Array | None = None) -> None:
    """Set one end of windows and the limit that binds there, in place.

    Args:
        window: Windows.
        name: "low" or "high".
        rows: Windows that are set.
        tight: Tightest ends of these.
        ends: Ends of these, N, by default the tightest.
    """
    getattr(window, name)[rows] = getattr(tight, name) if ends is None else ends
    getattr(window, f"{name}_state")[rows] = getattr(tight, f"{name}_state")
    getattr(window, f"{name}_by")[rows] = getattr(tight, f"{name}_by")


def _put(window: Window, rows: Rows, part: Window) -> None:
    """Put windows into the places of some others."""
    for name, values in vars(part).items():
        getattr(window, name)[rows] = values
