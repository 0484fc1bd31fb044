"""What the readings may show of the rig, each effect as a column of the line through points of strokes.

For rows that slip, with o the zero offsets, δ the delay of the load's cell, n the power of the force and ε friction
outside
of the bend,

    ln((F_motor - o_motor)/(F_load - o_load)) = ±(μφ (1 + n ln(F/F̄)) + ε) + ln g + δ d ln F/dt + u + e

where u is common to the rows of a stroke: strokes are the independent sample.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.reading.readings import Floats, Integers

OFFSETS, DELAY, FORCE, ENTRY = "offsets", "delay", "force", "entry"
PER_STROKE = 8
"""Points of a stroke: enough for the force within it to show, few enough that rows beside each other are one."""

_PRIOR = {OFFSETS: 0.05, DELAY: 0.05, FORCE: 0.2, ENTRY: 0.3}
"""Standard deviation of an effect before anything is read: offsets in shares of the median force, a delay in strokes,
n,
and ε in shares of μφ. It is what good and bad rigs have."""
_VARIES, _VARIES_NOISE = 0.015, 6.0
"""Standard deviation of ln F within a way, of itself and over the noise of a point, from which the force says
anything."""
_STROKES = 4
"""From which a delay, a dependence on force or friction outside is tried: with fewer, one odd stroke is one."""
SAME_BEND = 0.02
"""Bend angles that differ by less are one: nobody measures them better."""


@dataclass(frozen=True, eq=False)
class Points:
    """Means over parts of strokes, on the limit."""

    motor: Floats
    load: Floats
    way: Integers
    bend: Floats
    stroke: Integers
    """0, 1, ... without gaps."""
    rate: Floats | None
    """d ln F/dt; None if there is no order in time."""
    place: Floats
    """Along the file, from -1/2 to 1/2."""
    duration: float
    """Of a usual stroke, in the unit of the rate's time."""
    noise: float
    """Standard deviation of ln F of a point from noise alone."""

    @property
    def both_ways(self) -> bool:
        """Whether gain and friction can be told apart."""
        return len(np.unique(self.way[self.bend > 0.0])) == 2

    @property
    def log_ratio(self) -> Floats:
        """ln(F_motor/F_load)."""
        return np.asarray(np.log(self.motor / self.load))

    @property
    def strokes(self) -> int:
        """How many."""
        return int(self.stroke.max()) + 1

    @property
    def mean_force(self) -> float:
        """ln F that the power of the force counts from."""
        return float(np.mean(np.log(self.load)))

    @property
    def varies(self) -> bool:
        """Whether the force within a way varies enough to show what depends on it."""
        log_force = np.log(self.load)
        spread = max(float(np.std(log_force[self.way == way])) for way in np.unique(self.way))
        return spread > max(_VARIES, _VARIES_NOISE * self.noise)

    @property
    def bends(self) -> int:
        """How many bend angles there are."""
        return len(np.unique(bend_groups(self.bend[self.bend > 0.0])))

    def columns(self, effects: tuple[str, ...], zeros: Floats) -> list[Floats]:
        """Slopes of the log ratio in each number of the line, at these offsets."""
        turn = self.way * self.bend
        columns = [turn, np.ones(len(turn))] if self.both_ways else [turn]
        for effect in effects:
            if effect == OFFSETS:
                columns += [1.0 / (self.motor - zeros[0]), -1.0 / (self.load - zeros[1])]
            elif effect == DELAY and self.rate is not None:
                columns.append(self.rate)
            elif effect == FORCE:
                columns.append(turn * (np.log(self.load) - self.mean_force))
            elif effect == ENTRY:
                columns.append(self.way.astype(np.float64))
        return columns


def bend_groups(bend: Floats) -> Integers:
    """A number from 1 for each angle, the same for angles that are one."""
    values, place = np.unique(bend, return_inverse=True)
    steps = (
        np.concatenate([[False], np.diff(values) > SAME_BEND * values[1:]]) if len(values) else np.zeros(0, dtype=bool)
    )
    return np.asarray(1 + np.cumsum(steps), dtype=np.int64)[place]


@dataclass(frozen=True, eq=False)
class EffectModel:
    """One set of effects, fitted."""

    effects: tuple[str, ...]
    values: Floats
    """μ, ln g if there are both ways, then the effects': two offsets, delay, n μ, ε."""
    covariance: Floats
    evidence: float
    residual: Floats
    """Of the points."""
    between: float
    """Standard deviation of strokes about the line."""
    within: float
    """Of points about their stroke."""
    free: int
    """Strokes less what is fitted to them."""
    zero: tuple[float, float]
    """What μ changes by per unit of a zero error in each cell; 0 if the offsets are fitted."""
    both_ways: bool

    @property
    def friction(self) -> float:
        """μ."""
        return float(self.values[0])

    @property
    def log_gain(self) -> float:
        """ln g; 0 if it cannot be told."""
        return float(self.values[1]) if self.both_ways else 0.0

    def value(self, effect: str, part: int = 0) -> tuple[float, float]:
        """An effect and its standard error."""
        before = self.effects[: self.effects.index(effect)]
        at = 1 + self.both_ways + sum(2 if name == OFFSETS else 1 for name in before) + part
        return float(self.values[at]), math.sqrt(max(float(self.covariance[at, at]), 0.0))

    def shape(
        self, motor: Floats, load: Floats, way: Integers, bend: Floats, rate: Floats | None, mean: float
    ) -> Floats:
        """What the effects add to the log ratio of rows; `mean` is the ln F that n counts from."""
        added = np.zeros(len(motor))
        if OFFSETS in self.effects:
            # A row whose force is mostly offset is left with 5 % of it, so that it has a ratio.
            left = [
                np.maximum(cell - self.value(OFFSETS, part)[0], 0.05 * cell) for part, cell in ((0, motor), (1, load))
            ]
            added += np.log(motor / load) - np.log(left[0] / left[1])
        if DELAY in self.effects and rate is not None:
            added += self.value(DELAY)[0] * rate
        if FORCE in self.effects:
            added += self.value(FORCE)[0] * way * bend * (np.log(load) - mean)
        if ENTRY in self.effects:
            added += self.value(ENTRY)[0] * way
        return added


@dataclass(frozen=True)
class EffectPriors:
    """What may be tried, and how likely its sizes are before anything is read."""

    prior: dict[str, float]
    """Standard deviation of each effect's numbers."""

    def sets(self) -> list[tuple[str, ...]]:
        """Every set; offsets and a dependence on force bend the line alike and are not fitted together."""
        names = list(self.prior)
        every = (chosen for size in range(len(names) + 1) for chosen in itertools.combinations(names, size))
        return [chosen for chosen in every if not {OFFSETS, FORCE} <= set(chosen)]


def candidates_of(points: Points, friction: float, zero: float | None) -> EffectPriors:
    """The effects that these points can say something about; `zero` is the stated uncertainty of the cells' zero."""
    prior: dict[str, float] = {}
    if points.both_ways and points.varies:
        prior[OFFSETS] = zero or _PRIOR[OFFSETS] * float(np.median(np.minimum(points.motor, points.load)))
        if points.strokes >= _STROKES:
            if points.rate is not None and np.ptp(points.rate) > 0.0:
                prior[DELAY] = _PRIOR[DELAY] * points.duration
            prior[FORCE] = _PRIOR[FORCE] * friction
    if points.both_ways and points.bends > 1 and points.strokes >= _STROKES:
        prior[ENTRY] = _PRIOR[ENTRY] * friction * float(np.median(points.bend))
    return EffectPriors(prior)
