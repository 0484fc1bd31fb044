"""What the readings may show of the rig, each effect as a column of the line through points of strokes.

For rows that slip, with o the zero offsets, δ the delay of the load's cell, n the power of the force and ε friction
outside of the bend,

    ln((F_motor - o_motor)/(F_load - o_load)) = ±(μφ (1 + n ln(F/F̄)) + ε) + ln g + δ d ln F/dt + u + e

where u is common to the rows of a stroke: strokes are the independent sample.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.plateaus import bend_groups
from tendon_cli.friction.reading.readings import Floats, Integers

OFFSETS, DELAY, FORCE, ENTRY = "offsets", "delay", "force", "entry"
PRIOR = {OFFSETS: 0.05, DELAY: 0.05, FORCE: 0.2, ENTRY: 0.3}
"""Standard deviation of an effect before anything is read: offsets in shares of the median force, a delay in strokes,
n, and ε in shares of μφ. It is what good and bad rigs have."""
PER_STROKE = 8
"""Points of a stroke: enough for the force within it to show, few enough that neighbouring rows are one."""
_VARIES, _VARIES_NOISE = 0.015, 6.0
"""Standard deviation of ln F within a way, of itself and over the noise of a point, from which the force says
anything."""
_STROKES = 4
"""From which a delay, a dependence on force or friction outside is tried: with fewer, one odd stroke is one."""


@dataclass(frozen=True, eq=False)
class Forces:
    """Both forces of rows, or means over some of them, and what effects depend on."""

    motor: Floats
    load: Floats
    way: Integers
    bend: Floats
    rate: Floats | None
    """d ln F/dt; None if there is no order in time."""
    mean_force: float
    """ln F that the power of the force counts from."""

    @property
    def log_ratio(self) -> Floats:
        """ln(F_motor/F_load)."""
        return np.asarray(np.log(self.motor / self.load))

    def slope(self, effect: str) -> Floats:
        """Change of the log ratio per unit of an effect other than offsets."""
        if effect == DELAY and self.rate is not None:
            return self.rate
        if effect == FORCE:
            return self.way * self.bend * (np.log(self.load) - self.mean_force)
        return self.way.astype(np.float64)


@dataclass(frozen=True, eq=False)
class Points(Forces):
    """Means over parts of strokes, on the limit."""

    stroke: Integers
    """0, 1, ... without gaps."""
    place: Floats
    """Along the file, from -1/2 to 1/2."""
    duration: float
    """Of a usual stroke, in the unit of the rate's time."""
    noise: float
    """Standard deviation of ln F of a point from noise alone."""

    @property
    def both_ways(self) -> bool:
        """Whether gain and friction can be separated."""
        return len(np.unique(self.way[self.bend > 0.0])) == 2

    @property
    def strokes(self) -> int:
        """How many."""
        return int(self.stroke.max()) + 1

    def columns(self, effects: tuple[str, ...], zeros: Floats) -> list[Floats]:
        """Slopes of the log ratio in each number of the line, at these offsets; offsets come first of the effects."""
        turn = self.way * self.bend
        columns = [turn, np.ones(len(turn))] if self.both_ways else [turn]
        if OFFSETS in effects:
            columns += [1.0 / (self.motor - zeros[0]), -1.0 / (self.load - zeros[1])]
        return columns + [self.slope(effect) for effect in effects if effect != OFFSETS]

    def priors(self, zero: float | None) -> dict[str, float]:
        """Standard deviation of the effects that these points can say something about, before anything is read.

        `zero` is the stated uncertainty of the cells' zero.
        """
        bends = len(np.unique(bend_groups(self.bend[self.bend > 0.0])))
        ratio = self.log_ratio
        turn = np.abs(ratio - np.median(ratio)) / np.maximum(self.bend, 1e-9)
        friction, force = max(float(np.median(turn)), 1e-9), np.log(self.load)
        spread = max(float(np.std(force[self.way == way])) for way in np.unique(self.way))
        varies = self.both_ways and spread > max(_VARIES, _VARIES_NOISE * self.noise)
        many = self.both_ways and self.strokes >= _STROKES
        median_force = float(np.median(np.minimum(self.motor, self.load)))
        possible = {
            OFFSETS: (varies, zero or PRIOR[OFFSETS] * median_force),
            DELAY: (
                varies and many and self.rate is not None and np.ptp(self.rate) > 0.0,
                PRIOR[DELAY] * self.duration,
            ),
            FORCE: (varies and many, PRIOR[FORCE] * friction),
            ENTRY: (many and bends > 1, PRIOR[ENTRY] * friction * float(np.median(self.bend))),
        }
        return {effect: prior for effect, (can_show, prior) in possible.items() if can_show}


@dataclass(frozen=True, eq=False)
class EffectModel:
    """One set of effects, fitted."""

    effects: tuple[str, ...]
    values: Floats
    """μ, ln g if there are both ways, then the effects': two offsets, delay, n μ, ε."""
    covariance: Floats
    evidence: float
    """Log of the probability of the readings under the model, but for a constant."""
    residual: Floats
    """Of the points."""
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
    def error(self) -> float:
        """Standard error of μ under this model."""
        return math.sqrt(max(float(self.covariance[0, 0]), 0.0))

    @property
    def log_gain(self) -> float:
        """ln g; 0 if one way is read only."""
        return float(self.values[1]) if self.both_ways else 0.0

    def value(self, effect: str, part: int = 0) -> tuple[float, float]:
        """An effect and its standard error; offsets have two parts."""
        before = self.effects[: self.effects.index(effect)]
        at = 1 + self.both_ways + len(before) + (OFFSETS in before) + part
        return float(self.values[at]), math.sqrt(max(float(self.covariance[at, at]), 0.0))

    def shape(self, rows: Forces) -> Floats:
        """What the effects add to the log ratio of rows."""
        added = np.zeros(len(rows.motor))
        for effect in self.effects:
            if effect != OFFSETS:
                added += self.value(effect)[0] * rows.slope(effect)
                continue
            # A row whose force is mostly offset is left with 5 % of it, so that it has a ratio.
            zeros = self.value(OFFSETS)[0], self.value(OFFSETS, 1)[0]
            motor, load = (np.maximum(cell - zero, 0.05 * cell)
                           for cell, zero in zip((rows.motor, rows.load), zeros, strict=True))  # fmt: skip
            added += rows.log_ratio - np.log(motor / load)
        return added


def sets_of(effects: dict[str, float]) -> list[tuple[str, ...]]:
    """Every set; offsets and a dependence on force bend the line alike and are not fitted together."""
    every = itertools.chain.from_iterable(itertools.combinations(effects, size) for size in range(len(effects) + 1))
    return [chosen for chosen in every if not {OFFSETS, FORCE} <= set(chosen)]
