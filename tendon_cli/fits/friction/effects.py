"""Effects of the rig that readings may show, each a column of the line through points of strokes.

For rows that slip, with o the zero offsets, δ the delay of the load's cell, n the power of the
force and ε friction outside of the bend,

    ln((F_motor - o_motor)/(F_load - o_load))
        = ±(μφ (1 + n ln(F/F̄)) + ε) + ln g + δ d ln F/dt + u + e

where u is common to the rows of a stroke: strokes are the independent sample.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.fits.friction.usable_rows import Log, bend_groups
from tendon_cli.fits.log_rows import Floats, means_by

OFFSETS = ("offset_motor", "offset_load")
DELAY = "delay"
FORCE = "force_dependence"
ENTRY = "entry"
PRIOR = {OFFSETS[0]: 0.05, OFFSETS[1]: 0.05, DELAY: 0.05, FORCE: 0.2, ENTRY: 0.3}
"""Prior standard deviation of each effect, as good and bad rigs have it: offsets in shares of the
median force, a delay in strokes, n, and ε in shares of μφ."""
STRICT = {DELAY: 5.0, FORCE: 5.0, ENTRY: 3.0}
"""Log odds against an effect; none against offsets, since every cell has a zero error. Few loggers
are late, and a force dependence mimics offsets."""
_VARIES = 0.015
"""Least standard deviation of ln F within a way from which the force says anything."""
_VARIES_NOISE = 4.0
"""The same over the noise of a point; both must be exceeded."""
_STROKES = 4
"""Least number of strokes from which a delay, a dependence on force or friction outside is tried:
with fewer, one odd stroke looks like it."""


def columns_of(points: Log, effects: tuple[str, ...], zeros: Floats) -> list[Floats]:
    """Return the derivatives of the log ratio by μ, by ln g if it is fitted, and by each effect.

    Args:
        points: Means over parts of strokes, as `with_one_force` returns them.
        effects: Names of effects.
        zeros: Offsets of the motor's and of the load's cell at which the derivatives hold.

    Returns:
        A column of points for μ, for ln g if both directions are read, and for each effect.
    """
    columns = [points.way * points.bend]
    if points.both_ways:
        columns.append(np.ones(len(points.way)))
    return columns + [_slope(points, effect, zeros) for effect in effects]


def with_one_force(points: Log) -> Log:
    """Return points whose two forces come from the mean of both cells.

    Noise of a cell moves the log ratio and 1/F of that cell together, which passes for a zero
    error. The mean of ln F of both cells has as much of either noise, and their ratio none of it.
    """
    kind = np.unique(points.way * bend_groups(points.bend), return_inverse=True)[1]
    half = 0.5 * (means_by(kind, points.log_ratio)[kind] - points.log_ratio)
    motor = points.motor * np.exp(half)
    return replace(points, motor=motor, load=points.load * np.exp(-half))


def _slope(log: Log, effect: str, zeros: Floats) -> Floats:
    """Return the derivative of the log ratio by one effect, per row."""
    if effect == OFFSETS[0]:
        return np.asarray(1.0 / (log.motor - zeros[0]))
    if effect == OFFSETS[1]:
        return np.asarray(-1.0 / (log.load - zeros[1]))
    if effect == DELAY and log.rate is not None:
        return log.rate
    if effect == FORCE:
        return log.way * log.bend * (np.log(log.load) - log.mean_force)
    return log.way.astype(np.float64)


def priors_of(points: Log, duration: float, zero: float | None) -> dict[str, float]:
    """Return the prior standard deviation of each effect that these points can show.

    Args:
        points: Means over parts of strokes.
        duration: Duration of a stroke, in the unit of the time.
        zero: Stated standard uncertainty of the cells' zero; None if it is not stated.
    """
    ratio = points.log_ratio
    force = np.log(points.load)
    frictions = np.abs(ratio - np.median(ratio)) / np.maximum(points.bend, 1e-9)
    friction = max(np.median(frictions), 1e-9)
    noise = 0.0 if points.settled else np.median(points.noise)
    spread = max(np.std(force[points.way == way]) for way in np.unique(points.way))
    varies = points.both_ways and spread > max(_VARIES, _VARIES_NOISE * noise)
    has_strokes = points.both_ways and points.strokes >= _STROKES
    bends = np.unique(bend_groups(points.bend[points.bend > 0.0]))
    scale = dict.fromkeys(PRIOR, 0.0)
    if varies:
        scale |= dict.fromkeys(OFFSETS, np.median(np.minimum(points.motor, points.load)))
    if varies and has_strokes:
        scale[FORCE] = friction
    if varies and has_strokes and points.rate is not None and np.ptp(points.rate) > 0.0:
        scale[DELAY] = duration
    if has_strokes and len(bends) > 1:
        scale[ENTRY] = friction * np.median(points.bend)
    priors = {effect: scale[effect] * share for effect, share in PRIOR.items() if scale[effect]}
    if zero and varies:
        priors |= dict.fromkeys(OFFSETS, zero)
    return priors


def sets_of(priors: dict[str, float]) -> list[tuple[str, ...]]:
    """Return every set of effects that is fitted, the empty one first.

    An offset of one cell alone is a set of its own: it is simpler than one of both, between which
    a prior would share it out. Offsets of both, or one with a delay, bend the line as a
    dependence on force does, so no set has that beside them.
    """
    known = [effect for effect in PRIOR if effect in priors]
    sizes = range(len(known) + 1)
    every = itertools.chain.from_iterable(itertools.combinations(known, size) for size in sizes)
    return [
        effects
        for effects in every
        if FORCE not in effects or len({*OFFSETS, DELAY}.intersection(effects)) <= 1
    ]


@dataclass(frozen=True, eq=False)
class EffectModel:
    """Fit of one set of effects."""

    effects: tuple[str, ...]
    values: Floats
    """μ, ln g if both directions are read, then the effects (for the force, nμ)."""
    covariance: Floats
    evidence: float
    """Log of the probability of the readings under the model, up to a constant."""
    residual: Floats
    """Residual of each point."""
    free: int
    """Degrees of freedom: strokes less the numbers fitted to them."""
    zero: tuple[float, float]
    """Change of μ by a unit of zero error in each cell; 0 if its offset is fitted."""
    late: float
    """Change of μ by a unit of delay of the load's cell; 0 if a delay is fitted."""

    @property
    def friction(self) -> float:
        """μ."""
        return float(self.values[0])

    @property
    def error(self) -> float:
        """Standard error of μ under this model."""
        return math.sqrt(max(self.covariance[0, 0], 0.0))

    @property
    def fits_zero(self) -> bool:
        """True if the zero error of a cell is fitted."""
        return not set(OFFSETS).isdisjoint(self.effects)

    @property
    def has_alike_zeros(self) -> bool:
        """True if zero errors of both cells are fitted that are more alike than different."""
        if not set(OFFSETS) <= set(self.effects):
            return False
        motor, load = (self.value(name)[0] for name in OFFSETS)
        return abs(motor + load) > abs(motor - load)

    @property
    def log_gain(self) -> float:
        """ln g; 0 if only one direction is read."""
        has_gain = len(self.values) > 1 + len(self.effects)
        return self.values[1] if has_gain else 0.0

    def value(self, effect: str) -> tuple[float, float]:
        """Return an effect and its standard error."""
        place = self._place(effect)
        return float(self.values[place]), math.sqrt(max(self.covariance[place, place], 0.0))

    def error_from(self, effect: str) -> float:
        """Return the part of the standard error of μ that comes from an effect."""
        error = self.value(effect)[1]
        return abs(self.covariance[0, self._place(effect)]) / error if error else 0.0

    def _place(self, effect: str) -> int:
        """Return the place of an effect among the fitted numbers."""
        return len(self.values) - len(self.effects) + self.effects.index(effect)

    def shape(self, rows: Log) -> Floats:
        """Return the part of the log ratio that the effects add in each row."""
        added = np.zeros(len(rows.motor))
        for effect in self.effects:
            value = self.value(effect)[0]
            if effect not in OFFSETS:
                added += value * _slope(rows, effect, np.zeros(2))
                continue
            force = rows.motor if effect == OFFSETS[0] else rows.load
            # A row whose force is mostly offset is left with 5 % of it, so that it has a ratio.
            left = np.log(force / np.maximum(force - value, 0.05 * force))
            added += left if effect == OFFSETS[0] else -left
        return added
