"""Windows of pretension along a motion in time.

Which way the tendons slide depends on the pretension, too, so that a window is no longer where all
half-lines of its states meet: at each pretension only the states count that hold there, and where
the tendons turn those of the other direction (`moving`). The pretensions that keep every limit may
then form several intervals: where a tendon turns at one sample more, a few newtons are lost in the
middle. So pretensions are tried, more of them between two wherever the states that count may break
a limit, and the widest interval is the window. SI units, angles in radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, map_arrays, shape_of
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING, POWER, PRETENSION, Codes
from tendon_cli.model.motor import select_points
from tendon_cli.model.moving import Moving, peak_power
from tendon_cli.model.sliding import with_neighbours
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.model.window import StateEnds, Window, broken_by_design, ceiling, ends_of_states

OF_WHAT_HOLDS = ("min_elbow_stiffness", "peak_motor_speed")
"""Limits for which only the states that hold count, also where the tendons turn."""
_SAMPLES = 9
"""Pretensions of each design that are tried first."""
_FINEST = 2.0**-11
"""Least distance of two pretensions that differ in nothing, as a share of all that are tried."""
_COARSE = 2.0**-6
"""Least distance, as such a share, of two at which the same states count."""
_SAME = 1e-12
"""Relative distance within which two pretensions are the same."""
_CLOSE = 4e-12
"""Relative distance between which the end of a window is known well enough."""
_ROUNDS = 80
"""Most rounds of pretensions tried between others."""
_TINY = 1e-9
"""Least bound on power, W, to which an excess is related."""
_STATES_AT_ONCE = 2**16
"""States that are worked out together."""
_STEP = 100.0  # N; beyond the largest limit, if nothing bounds a window
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
    unset = design.with_pretension(np.zeros(flat_shape))
    flat = select_points(unset, flat_shape, places)
    largest = np.broadcast_to(over_design[0], flat_shape).ravel()
    broken = np.broadcast_to(over_design[1], flat_shape).ravel()
    search = Search(flat, trajectory, _flat_bounds(bounds, flat_shape), largest)
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
    return replace(
        found,
        low=np.where(is_broken, np.nan, found.low),
        high=np.where(is_broken, np.nan, np.minimum(found.high, largest)),
        low_state=np.where(is_broken, -1, found.low_state),
        high_state=np.where(is_broken | is_ceiling, -1, found.high_state),
        low_by=np.where(is_broken, broken, found.low_by).astype(np.int8),
        high_by=np.where(is_broken, broken, np.where(is_ceiling, PRETENSION, found.high_by)).astype(
            np.int8
        ),
    )


@dataclass(frozen=True, eq=False)
class Tightest:
    """Tightest ends of the states that count at a pretension, (tried,) each."""

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


@dataclass(frozen=True, eq=False)
class Tried:
    """Pretensions that were tried, (tried,) each."""

    design: Rows
    """Number of the design."""
    pretension: Array
    """The pretension, N."""
    tight: Tightest
    """Tightest ends of the states that count there."""
    power: Array
    """Excess over the limit on power as a share of it; minus infinite without such a limit."""
    counts: Flags
    """Candidates that count there for each kind of limit, (tried, kinds, 2, samples)."""

    @cached_property
    def excess(self) -> Array:
        """Distance of the pretensions from those that all states that count allow, N."""
        reserve = _SAME * np.abs(self.pretension)
        below = self.tight.low - self.pretension
        return np.asarray(np.maximum(below, self.pretension - self.tight.high) - reserve)

    @cached_property
    def is_kept(self) -> Flags:
        """True where all limits are kept."""
        return (self.excess <= 0.0) & ~(self.power > 0.0)

    def select(self, rows: Rows | Flags) -> Tried:
        """Select some of them."""
        selected: Tried = map_arrays(self, lambda values: values[rows])
        return selected

    def without_counts(self) -> Tried:
        """Return the same without the candidates that count, which take most of the memory."""
        return replace(self, counts=np.zeros((len(self.design), 0), dtype=np.bool_))

    @classmethod
    def concatenate(cls, first: Tried, *others: Tried) -> Tried:
        """Concatenate several of them."""
        joined: Tried = map_arrays(first, lambda *values: np.concatenate(values), *others)
        return joined


@dataclass(frozen=True, eq=False)
class Search:
    """Designs along a single axis, (N, 1, 1), whose windows along a trajectory are sought."""

    design: Design
    trajectory: Trajectory
    bounds: Bounds
    largest: Array
    """Largest pretension of each design, (N,), N."""

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

    def _select(self, rows: Rows) -> Moving:
        """Return some of the designs along the trajectory."""
        if self.count == 1:
            return self.moving
        return Moving.of(select_points(self.design, (self.count, 1, 1), (rows,)), self.trajectory)

    # --- Limits on states -------------------------------------------------------------------------

    @cached_property
    def _ends(self) -> StateEnds:
        """Ends that limits set in candidates at the samples that count.

        They are (designs, kinds, 2, samples). The first kind of limit counts in both directions
        where tendons turn, the second only in states that hold. Where none keeps a limit, `low` is
        infinite and `high` minus infinite.
        """
        free = {"min_elbow_stiffness": -np.inf}
        held = {name: self.bounds[name] for name in OF_WHAT_HOLDS if name in self.bounds}
        both = {name: bound for name, bound in self.bounds.items() if name not in OF_WHAT_HOLDS}
        speed = self.bounds.speed
        of_kinds = (Bounds(speed=speed, **free, **both), Bounds(speed=speed, **held))
        shape = (self.count, 2, self.moving.shape[-1])
        counted = self.trajectory.counted
        parts = [
            [
                np.broadcast_to(values, shape)[..., counted]
                for values in ends_of_states(self.moving.candidates, bounds)
            ]
            for bounds in of_kinds
        ]
        low, high, low_by, high_by, blocked = (
            np.stack(values, axis=1) for values in zip(*parts, strict=True)
        )
        is_blocked = blocked != NOTHING
        return StateEnds(
            low=np.where(is_blocked, np.inf, low),
            high=np.where(is_blocked, -np.inf, high),
            low_by=np.where(is_blocked, blocked, low_by),
            high_by=np.where(is_blocked, blocked, high_by),
            blocked=blocked,
        )

    def _counts(self, moving: Moving) -> Flags:
        """Return where candidates count for each kind of limit, (tried, kinds, 2, samples)."""
        sliding = moving.sliding.within(self.trajectory.counted)
        holds = np.concatenate([sliding.flexion, ~sliding.flexion], axis=-2)
        return np.stack([holds | sliding.turning, holds & ~sliding.passing], axis=1)

    def _tightest(self, designs: Rows, counts: Flags) -> Tightest:
        """Return the tightest ends of the candidates that count.

        Args:
            designs: Numbers of the designs, (tried,).
            counts: Candidates that count, (tried, kinds, 2, samples).
        """
        counted = self.trajectory.counted
        values = []
        for sign, end, code in ((1.0, "low", "low_by"), (-1.0, "high", "high_by")):
            asked = np.where(counts, sign * getattr(self._ends, end)[designs], -np.inf)
            flat = asked.reshape(len(designs), -1)
            place = flat.argmax(axis=1)
            top = flat[np.arange(len(designs)), place]
            codes = getattr(self._ends, code).reshape(self.count, -1)[designs, place]
            _, direction, sample = np.unravel_index(place, asked.shape[1:])
            state = direction * len(self.trajectory.time) + counted.start + sample
            is_one = top > -np.inf
            values += [sign * top, np.where(is_one, state, -1), np.where(is_one, codes, NOTHING)]
        return Tightest(*values)

    # --- Pretensions that are tried ---------------------------------------------------------------

    def _try(self, designs: Rows, pretensions: Array) -> Tried:
        """Try a pretension, N, of each of some designs, (tried,)."""
        at_once = max(1, _STATES_AT_ONCE // (2 * len(self.trajectory.time)))
        parts = []
        for start in range(0, len(designs), at_once):
            rows = designs[start : start + at_once]
            pretension = pretensions[start : start + at_once]
            moving = self._select(rows).at_pretension(pretension[:, np.newaxis, np.newaxis])
            counts = self._counts(moving)
            tight = self._tightest(rows, counts)
            parts.append(Tried(rows, pretension, tight, self._power_excess(rows, moving), counts))
        return Tried.concatenate(*parts)

    def _all_tried(self) -> Tried:
        """Try pretensions until their order is known, by design and then by pretension."""
        first, last = self._range()
        shares = np.linspace(0.0, 1.0, _SAMPLES)
        samples = first[:, np.newaxis] + (last - first)[:, np.newaxis] * shares
        low, high = (end[:, np.newaxis] for end in self._kept_either_way(first, last))
        samples = np.sort(np.hstack([samples, low, high]), axis=1)
        is_new = np.diff(samples, axis=1, prepend=-1.0) > 0.0
        if not self.bounds.asks_power:
            is_new &= (samples <= low) | (samples >= high)  # nothing is broken between these
        designs = np.repeat(np.arange(self.count), is_new.sum(axis=1))
        tried = self._try(designs, samples[is_new])
        is_first = np.diff(designs, prepend=-1) > 0
        below = tried.select(~np.roll(is_first, -1))
        above = tried.select(~is_first)
        finest = _FINEST * (last - first)
        known = [tried.without_counts()]
        for attempt in range(_ROUNDS):
            is_unclear = self._is_unclear(below, above, finest)
            if not is_unclear.any():
                break
            below = below.select(is_unclear)
            above = above.select(is_unclear)
            between = self._try(below.design, _between(below, above, is_aimed=attempt % 3 != 2))
            known.append(between.without_counts())
            below = Tried.concatenate(below, between)
            above = Tried.concatenate(between, above)
        every = Tried.concatenate(*known)
        return every.select(np.lexsort((every.pretension, every.design)))

    def _range(self) -> tuple[Array, Array]:
        """Return the smallest and the largest pretension that may be in a window, (N,) each, N."""
        least = self._ends.low.min(axis=2).max(axis=(1, 2))
        most = self._ends.high.max(axis=2).min(axis=(1, 2))
        beyond = self._beyond()
        first = np.clip(least, 0.0, beyond)
        last = np.minimum(np.minimum(most, beyond), self.largest)
        if self.bounds.asks_power:
            # A limit on power may bind far beyond the others.
            is_endless = np.minimum(most, self.largest) > beyond
            for _ in range(_DOUBLINGS):
                at_last = self._try(np.arange(self.count), last)
                is_kept = is_endless & at_last.is_kept
                if not is_kept.any():
                    break
                last = np.where(is_kept, first + 2.0 * (last - first), last)
        return np.minimum(first, np.maximum(last, 0.0)), np.maximum(last, 0.0)

    def _beyond(self) -> Array:
        """Return pretensions beyond every limit of candidates that is one, (N,), N."""
        ends = np.stack([self._ends.low, self._ends.high], axis=1)
        finite = np.where(np.isfinite(ends), ends, 0.0)
        return np.asarray(finite.reshape(self.count, -1).max(axis=1, initial=0.0) + _STEP)

    def _kept_either_way(self, first: Array, last: Array) -> tuple[Array, Array]:
        """Return the ends of what keeps the limits on states in both directions, (N,), N.

        They lie within the range that is tried, also where there is no such pretension.
        """
        low = self._ends.low.max(axis=(1, 2, 3))
        high = self._ends.high.min(axis=(1, 2, 3))
        return np.clip(low, first, last), np.clip(high, first, last)

    def _is_unclear(self, below: Tried, above: Tried, finest: Array) -> Flags:
        """Return True where more is to be tried between two pretensions of a design.

        Args:
            below: The smaller ones.
            above: The larger ones.
            finest: Least distance between two that are both kept or both not, (N,), N.
        """
        width = above.pretension - below.pretension
        start = below.pretension.reshape(-1, 1, 1, 1)
        stop = above.pretension.reshape(-1, 1, 1, 1)
        low = self._ends.low[below.design]
        high = self._ends.high[below.design]
        # Where a tendon turns, either direction may be the one that holds.
        is_near = with_neighbours(with_neighbours((below.counts | above.counts)[:, :1]))
        may_break = (is_near & ((low > start) | (high < stop))).any(axis=(1, 2, 3))
        is_throughout = (low > stop) | (high < start)
        stays_broken = (below.counts & above.counts & is_throughout).any(axis=(1, 2, 3))
        differ = (below.counts != above.counts).any(axis=(1, 2, 3))
        least = np.minimum(below.power, above.power)
        most = np.maximum(below.power, above.power)
        with np.errstate(invalid="ignore"):
            change = np.where(most == least, 0.0, most - least)
        may_break &= differ | (width > _COARSE / _FINEST * finest[below.design])
        may_break |= most + change > 0.0
        stays_broken |= least - change > 0.0
        differs = below.is_kept != above.is_kept
        is_open = np.where(below.is_kept, may_break, ~stays_broken)
        close = _CLOSE * (above.pretension + 1.0)
        return np.where(differs, width > close, is_open & (width > finest[below.design] + close))

    # --- Windows ----------------------------------------------------------------------------------

    def windows(self) -> Window:
        """Return the widest windows of the designs, without limits on whole designs."""
        tried = self._all_tried()
        window = self._conflicts(tried)
        starts, stops = _widest_runs(tried)
        self._set(window, tried, starts, upper=False)
        self._set(window, tried, stops, upper=True)
        is_zero = ~(window.low > 0.0) & ~np.isnan(window.low)
        window.low[is_zero] = 0.0
        window.low_state[is_zero] = -1
        window.low_by[is_zero] = NOTHING
        is_endless = np.isinf(window.high)
        window.high_state[is_endless] = -1
        window.high_by[is_endless] = NOTHING
        return window

    def _conflicts(self, tried: Tried) -> Window:
        """Return what stands in for the windows of designs that have none.

        That are the tightest ends where the states miss their limits by least; NaN if no pretension
        suits a state, or if the ends do not tell why.
        """
        order = np.lexsort((tried.excess, tried.design))
        place = order[np.searchsorted(tried.design, np.arange(self.count))]
        tight = tried.select(place).tight
        by_power = tried.excess[place] <= 0.0
        is_hopeless = np.isposinf(tight.low) | np.isneginf(tight.high)
        is_hopeless |= tight.low <= tight.high
        unknown = np.full(self.count, np.nan)
        return Window(
            low=np.where(is_hopeless, np.nan, tight.low),
            high=np.where(is_hopeless, np.nan, tight.high),
            low_state=np.where(by_power, -1, tight.low_state),
            high_state=np.where(by_power, -1, tight.high_state),
            low_angle=unknown.copy(),
            high_angle=unknown.copy(),
            low_by=np.where(by_power, POWER, tight.low_by).astype(np.int8),
            high_by=np.where(by_power, POWER, tight.high_by).astype(np.int8),
        )

    def _set(self, window: Window, tried: Tried, ends: Rows, *, upper: bool) -> None:
        """Set the lower or upper ends of windows and the limits that bind there, in place.

        Args:
            window: The windows.
            tried: All that was tried, by design and pretension.
            ends: Places of the last pretensions that keep the limits, one for each such design.
            upper: True for upper ends.
        """
        name = "high" if upper else "low"
        step = 1 if upper else -1
        kept = tried.select(ends)
        tightest = getattr(kept.tight, name)
        beyond = np.clip(ends + step, 0, len(tried.design) - 1)
        is_last = (beyond == ends) | (tried.design[beyond] != kept.design)
        broken = tried.select(np.where(is_last, ends, beyond))
        is_exact = np.abs(tightest - kept.pretension) <= 2.0 * _CLOSE * (kept.pretension + 1.0)
        end = np.where(is_exact, tightest, kept.pretension)
        is_low = broken.tight.low - broken.pretension > broken.pretension - broken.tight.high
        is_low = np.where(is_last, not upper, is_low)
        state = np.where(is_low, broken.tight.low_state, broken.tight.high_state)
        by = np.where(is_low, broken.tight.low_by, broken.tight.high_by)
        by_power = ~is_last & (broken.excess <= 0.0)
        if by_power.any():
            rows = np.flatnonzero(by_power)
            state[rows] = self._states_of_most_power(kept.design[rows], end[rows])
            by = np.where(by_power, POWER, by)
        if upper:
            end = np.where(is_last & (tightest > kept.pretension) & ~is_exact, np.inf, end)
        getattr(window, name)[kept.design] = end
        getattr(window, f"{name}_state")[kept.design] = state
        getattr(window, f"{name}_by")[kept.design] = by

    # --- Power ------------------------------------------------------------------------------------

    def _power_excess(self, designs: Rows, moving: Moving) -> Array:
        """Return the excess over the limit on power as a share of it, (tried,).

        It is minus infinity where no sample has power, or nothing bounds it.
        """
        if not self.bounds.asks_power:
            return np.full(len(designs), -np.inf)
        bound = np.asarray(self.bounds[LIMIT_NAMES[POWER]])
        of_designs = bound.reshape(-1)[designs] if bound.size > 1 else bound.reshape(-1)
        share = (peak_power(moving) - of_designs) / np.maximum(of_designs, _TINY)
        return np.where(np.isnan(share), -np.inf, share)

    def _states_of_most_power(self, designs: Rows, pretension: Array) -> Rows:
        """Return the states in which the motor gives most at pretensions, (tried,), N."""
        moving = self._select(designs).at_pretension(pretension[:, np.newaxis, np.newaxis])
        counted = self.trajectory.counted
        shape = (len(designs), 1, len(self.trajectory.time))
        power = np.broadcast_to(moving.power, shape)
        known = np.where(moving.passing | np.isnan(power), -np.inf, power)[:, 0, counted]
        sample = counted.start + known.argmax(axis=1)
        flexes = moving.flexion.reshape(len(designs), -1)[np.arange(len(designs)), sample]
        return np.asarray(np.where(flexes, 0, shape[-1]) + sample)


def _between(below: Tried, above: Tried, *, is_aimed: bool) -> Array:
    """Return pretensions between others, N.

    They lie in the middle; or, between one that is kept and one that is not, where the states that
    count in the first just keep their limits, and just beyond.
    """
    start = below.pretension
    stop = above.pretension
    middle = 0.5 * (start + stop)
    if not is_aimed:
        return middle
    aim = np.where(below.is_kept, below.tight.high, above.tight.low)
    kept = np.where(below.is_kept, start, stop)
    outward = np.where(below.is_kept, 1.0, -1.0)
    beyond = 0.7 * _CLOSE * (stop + 1.0)
    is_there = np.abs(aim - kept) <= beyond
    aim = np.where(is_there, kept + outward * beyond, aim)
    is_between = (below.is_kept != above.is_kept) & (aim > start) & (aim < stop)
    return np.where(is_between, aim, middle)


def _widest_runs(tried: Tried) -> tuple[Rows, Rows]:
    """Return the first and last place of the widest interval that is kept, one for each design.

    Designs without one are left out.
    """
    kept = tried.is_kept
    is_new = np.append(True, tried.design[1:] != tried.design[:-1])
    before = np.append(False, kept[:-1]) & ~is_new
    after = np.append(kept[1:], False) & ~np.append(is_new[1:], True)
    starts = np.flatnonzero(kept & ~before)
    stops = np.flatnonzero(kept & ~after)
    width = tried.pretension[stops] - tried.pretension[starts]
    order = np.lexsort((width, tried.design[starts]))
    is_widest = np.append(np.diff(tried.design[starts][order]) != 0, True)[: len(order)]
    widest = order[is_widest]
    return starts[widest], stops[widest]
