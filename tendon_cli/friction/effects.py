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

from tendon_cli.friction.reading.readings import Floats
from tendon_cli.friction.usable_rows import Log, bend_groups

OFFSETS, DELAY, FORCE, ENTRY = ("offset_motor", "offset_load"), "delay", "force_dependence", "entry"
PRIOR = {OFFSETS[0]: 0.05, OFFSETS[1]: 0.05, DELAY: 0.05, FORCE: 0.2, ENTRY: 0.3}
"""Standard deviation of an effect before anything is read: offsets in shares of the median force, a delay in strokes,
n, and ε in shares of μφ. It is what good and bad rigs have."""
STRICT = {DELAY: 5.0, FORCE: 5.0, ENTRY: 3.0}
"""Log odds against an effect; none against offsets, since every cell has a zero error. Few loggers are late, and a
force dependence mimics offsets."""
_VARIES, _VARIES_NOISE = 0.015, 4.0
"""Standard deviation of ln F within a way, of itself and over the noise of a point, from which the force says
anything."""
_STROKES = 4
"""From which a delay, a dependence on force or friction outside is tried: with fewer, one odd stroke is one."""


def columns_of(points: Log, effects: tuple[str, ...], zeros: Floats) -> list[Floats]:
    """Slopes of the log ratio in μ, in ln g if there are both ways, and in each effect, at these offsets."""
    columns = [points.way * points.bend, *[np.ones(len(points.way))] * points.both_ways]
    return columns + [_slope(points, effect, zeros) for effect in effects]


def _slope(log: Log, effect: str, zeros: Floats) -> Floats:
    if effect in OFFSETS:
        return np.asarray(
            1.0 / (log.motor - zeros[0]) if effect == OFFSETS[0] else -1.0 / (log.load - zeros[1])
        )
    if effect == DELAY and log.rate is not None:
        return log.rate
    if effect == FORCE:
        return np.asarray(log.way * log.bend * (np.log(log.load) - log.mean_force))
    return log.way.astype(np.float64)


def priors_of(points: Log, duration: float, zero: float | None) -> dict[str, float]:
    """Standard deviation of the effects that these points can say something about, before anything is read.

    `duration` is that of a stroke, `zero` the stated uncertainty of the cells' zero.
    """
    ratio, force = points.log_ratio, np.log(points.load)
    turn = np.abs(ratio - np.median(ratio)) / np.maximum(points.bend, 1e-9)
    friction = max(float(np.median(turn)), 1e-9)
    noise = 0.0 if points.settled else float(np.median(points.noise))
    spread = max(float(np.std(force[points.way == way])) for way in np.unique(points.way))
    varies = points.both_ways and spread > max(_VARIES, _VARIES_NOISE * noise)
    many = points.both_ways and points.strokes >= _STROKES
    bent = np.unique(bend_groups(points.bend[points.bend > 0.0]))
    scale = dict.fromkeys(PRIOR, 0.0)
    if varies:
        scale |= dict.fromkeys(OFFSETS, float(np.median(np.minimum(points.motor, points.load))))
    if varies and many:
        scale[FORCE] = friction
    if varies and many and points.rate is not None and np.ptp(points.rate) > 0.0:
        scale[DELAY] = duration
    if many and len(bent) > 1:
        scale[ENTRY] = friction * float(np.median(points.bend))
    priors = {effect: scale[effect] * share for effect, share in PRIOR.items() if scale[effect]}
    return priors | (dict.fromkeys(OFFSETS, zero) if zero and varies else {})


def sets_of(priors: dict[str, float]) -> list[tuple[str, ...]]:
    """Every set; offsets and a dependence on force bend the line alike and are not fitted together."""
    alone = [(effect,) for effect in priors if effect not in OFFSETS]
    groups = [OFFSETS, *alone] if OFFSETS[0] in priors else alone
    every = itertools.chain.from_iterable(
        itertools.combinations(groups, size) for size in range(len(groups) + 1)
    )
    sets = [tuple(itertools.chain.from_iterable(chosen)) for chosen in every]
    return [chosen for chosen in sets if not {OFFSETS[0], FORCE} <= set(chosen)]


@dataclass(frozen=True, eq=False)
class EffectModel:
    """One set of effects, fitted.

    `values` are μ, ln g if there are both ways, then the effects' (of the force nμ); `evidence` is the log of the
    probability of the readings under the model, but for a constant; `residual` that of the points; `free` the strokes
    less what is fitted to them; `zero` what a unit of zero error in each cell does to μ, 0 if offsets are fitted.
    """

    effects: tuple[str, ...]
    values: Floats
    covariance: Floats
    evidence: float
    residual: Floats
    free: int
    zero: tuple[float, float]

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
        return float(self.values[1]) if len(self.values) > 1 + len(self.effects) else 0.0

    def value(self, effect: str) -> tuple[float, float]:
        """An effect and its standard error."""
        at = len(self.values) - len(self.effects) + self.effects.index(effect)
        return float(self.values[at]), math.sqrt(max(float(self.covariance[at, at]), 0.0))

    def shape(self, rows: Log) -> Floats:
        """What the effects add to the log ratio of rows."""
        others = [effect for effect in self.effects if effect not in OFFSETS]
        added = sum(
            (self.value(effect)[0] * _slope(rows, effect, np.zeros(2)) for effect in others),
            np.zeros(1),
        )
        if OFFSETS[0] in self.effects:
            # A row whose force is mostly offset is left with 5 % of it, so that it has a ratio.
            motor, load = (
                np.maximum(cell - self.value(offset)[0], 0.05 * cell)
                for cell, offset in zip((rows.motor, rows.load), OFFSETS, strict=True)
            )
            added = added + rows.log_ratio - np.log(motor / load)
        return np.broadcast_to(added, rows.motor.shape)
