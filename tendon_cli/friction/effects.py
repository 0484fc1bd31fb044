"""What the readings say about the rig: zero offsets, delay, force dependence and drift, each as a column of the fit.

For rows that slip, with offsets o of the cells and δ the delay of the load's cell,

    ln(F_motor/F_load) = ln g ± μφ + o_motor/F_motor - o_load/F_load + δ d ln F/dt.

An effect is found where its column explains more than chance does, and then it is fitted. Several effects may explain
the same thing: then the number stands only as far as they agree on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.friction.estimate import Linear, Points, solve
from tendon_cli.friction.reading.readings import Floats

OFFSETS, DELAY, FORCE, DRIFT, GAIN_DRIFT = "offsets", "delay", "force_dependence", "drift", "gain_drift"
_BY_CHANCE = {OFFSETS: 0.05, DELAY: 0.05, FORCE: 0.01, DRIFT: 0.01, GAIN_DRIFT: 0.01}
"""Largest probability by which chance alone would show an effect; less for those that put the number in doubt."""
_MATTERS = 0.003
"""An effect that moves μ by less, as a share, is left alone."""
_AS_GOOD = 3.0
"""Difference of the log likelihood within which another effect explains the same."""
_NAMES = {OFFSETS: "the zero offsets", DELAY: "the delay of a cell"}
_PLAUSIBLE_GAIN = 0.05
_MOST = 3
_WORST, _WORST_OF_ONE = 0.03, 0.2
"""A further effect is not fitted where it would leave μ known to no better than this share: it is the same as another.

One alone may: an effect that shows, although its size is hardly known, makes the interval as wide as it has to be.
"""
_LEAST_SPREAD = 0.015
"""Standard deviation of the log force, below which neither offsets nor delay nor force dependence can be told."""


@dataclass(frozen=True, eq=False)
class Effect:
    """One thing that may be wrong with the rig."""

    name: str
    columns: tuple[Floats, ...]


@dataclass(frozen=True, eq=False)
class Fitted:
    """The fit with the effects that were found, and what else was tried."""

    points: Points
    linear: Linear
    with_gain: bool
    effects: tuple[Effect, ...]
    """Those fitted, in the order of their columns after μ and gain."""
    rivals: dict[str, float] = field(default_factory=dict)
    """μ by effects that would explain the readings as well as one of those fitted."""
    robust: bool = False

    @property
    def friction(self) -> float:
        """μ."""
        return float(self.linear.values[0])

    @property
    def log_gain(self) -> float:
        """Log of the ratio of the gains; 0 where it cannot be told."""
        return float(self.linear.values[1]) if self.with_gain else 0.0

    def value(self, name: str, part: int = 0) -> tuple[float, float] | None:
        """Value and standard error of a fitted effect."""
        at = 1 + int(self.with_gain)
        for effect in self.effects:
            if effect.name == name:
                return float(self.linear.values[at + part]), self.linear.error(at + part)
            at += len(effect.columns)
        return None

    def of_effects(self, *, per_point: bool = False) -> Floats:
        """What the fitted effects add to the log ratio of each reading, or of each point."""
        columns = [column for effect in self.effects for column in effect.columns]
        added = np.zeros(len(self.points.force))
        for column, value in zip(columns, self.linear.values[1 + int(self.with_gain) :], strict=True):
            added += column * value
        return added if per_point else np.asarray(added[self.points.part])

    def bias(self, column: Floats) -> float:
        """What leaving a column out of the plain fit does to μ, per unit of its value."""
        return float(np.linalg.lstsq(np.stack(base_of(self.points, self.with_gain), axis=1), column, rcond=None)[0][0])

    def doubt(self, known: dict[str, Effect]) -> float:
        """Standard error of μ for offsets or a delay that chance may hide, of those that the readings can tell at all.

        The fits with and without each count by Akaike's weights, each with its own error and how far it moves μ
        (Burnham and Anderson, Model Selection and Multimodel Inference, 2002, 4.3.2).
        """
        own = self.linear.error(0)
        spread, weights = 0.0, 1.0
        fitted = {effect.name for effect in self.effects}
        for name in (name for name in (OFFSETS, DELAY) if name in known and name not in fitted):
            linear = self.with_effect(known[name])
            if not self.tells(linear):
                continue
            gain = linear.likelihood - self.linear.likelihood - len(known[name].columns)
            weight = math.exp(min(gain, 50.0))
            moved = float(linear.values[0]) - self.friction
            spread += weight * max(linear.error(0) ** 2 - own**2 + moved**2, 0.0)
            weights += weight
        return math.sqrt(spread / weights)

    def tells(self, linear: Linear) -> bool:
        """Whether μ is known with an effect fitted; if so, the interval counts the effect, fitted or not."""
        return not linear.assumed and linear.error(0) <= _WORST * abs(self.friction)

    def with_effect(self, effect: Effect) -> Linear:
        """The fit with one more effect."""
        columns = [*base_of(self.points, self.with_gain), *(c for known in self.effects for c in known.columns)]
        return solve(self.points, [*columns, *effect.columns], robust=self.robust)


def base_of(points: Points, with_gain: bool) -> list[Floats]:
    """The columns of μ and of the gain."""
    turn = points.way * points.bend_angle
    return [turn, np.ones(len(turn))] if with_gain else [turn]


def _exact_offsets(fitted: Fitted) -> Fitted:
    """The same with offsets that need not be small against the forces."""
    if not any(effect.name == OFFSETS for effect in fitted.effects):
        return fitted
    for _ in range(4):
        linear, points = fitted.linear, fitted.points
        cells = np.exp(points.log_ratio - linear.residual) * points.force, points.force
        columns = []
        for part, (cell, sign) in enumerate(zip(cells, (-1.0, 1.0), strict=True)):
            offset = (fitted.value(OFFSETS, part) or (0.0, 0.0))[0]
            offset = float(np.clip(offset, -0.5 * cell.min(), 0.5 * cell.min()))
            columns.append(sign * (np.log1p(-offset / cell) / offset if offset else -1.0 / cell))
        effects = tuple(Effect(e.name, tuple(columns)) if e.name == OFFSETS else e for e in fitted.effects)
        all_columns = [*base_of(points, fitted.with_gain), *(c for effect in effects for c in effect.columns)]
        linear = solve(points, all_columns, robust=fitted.robust)
        fitted = replace(fitted, linear=linear, effects=effects)
    return fitted


def offset_columns(fitted: Fitted) -> tuple[Floats, Floats]:
    """What 1 of offset of the motor's and of the load's cell does to the log ratio of each point."""
    line = fitted.points.log_ratio - fitted.linear.residual
    return np.exp(-line) / fitted.points.force, -1.0 / fitted.points.force


def known_effects(points: Points, linear: Linear, with_gain: bool) -> dict[str, Effect]:
    """The effects whose columns the readings have, from the plain fit."""
    base = base_of(points, with_gain)
    log_force = np.log(points.force)
    away = log_force - np.mean(log_force)
    fitted = sum(column * value for column, value in zip(base, linear.values, strict=True))
    known = {
        OFFSETS: (np.exp(-fitted) / points.force, -1.0 / points.force),
        FORCE: (base[0] * away,),
    }
    if points.rate is not None and np.any(points.rate):
        known[DELAY] = (points.rate,)
    if not _varies(points, solve(points, [*base, *known[OFFSETS]]).scatter[1]):
        known = {}
    known[DRIFT], known[GAIN_DRIFT] = (base[0] * points.place,), (points.place.copy(),)
    if not with_gain:
        known = {name: known[name] for name in (DELAY, DRIFT) if name in known}
    return {name: Effect(name, columns) for name, columns in known.items()}


def _varies(points: Points, noise: float) -> bool:
    """Whether the force changes within the directions, by far more than its noise, which the ratio shares."""
    log_force = np.log(points.force)
    left = np.concatenate([log_force[points.way == way] - np.mean(log_force[points.way == way])
                           for way in np.unique(points.way)])  # fmt: skip
    return bool(np.std(left) > max(_LEAST_SPREAD, 6.0 * noise))


def fit_effects(
    points: Points, *, with_gain: bool, robust: bool = False, forced: tuple[str, ...] = (), barred: tuple[str, ...] = ()
) -> tuple[Fitted, dict[str, Effect]]:
    """Fit μ with the effects that are asked for and those that the readings show; and all that could be tried."""
    plain = solve(points, base_of(points, with_gain), robust=robust)
    known = known_effects(points, plain, with_gain)
    fitted = Fitted(points, plain, with_gain, (), robust=robust)
    for name in forced:
        if name not in known:
            why = "the force hardly varies" if name == OFFSETS or points.rate is not None else "the file has no time"
            raise InputError(
                f"{_NAMES[name]} cannot be told: {why}",
                hint=f"measure with forces that vary, or leave --{name.removesuffix('s')} out",
            )
        fitted = _extended(fitted, known[name])
    for _ in range(_MOST):
        taken = {effect.name for effect in fitted.effects}
        tried = {
            name: (effect, fitted.with_effect(effect))
            for name, effect in known.items()
            if name not in taken | set(barred)
        }
        shown = {name: linear for name, (effect, linear) in tried.items() if _is_shown(fitted, effect, linear)}
        if not shown:
            break
        # Of those that explain the readings equally well the simplest, with the fewest columns.
        best = max(linear.likelihood for linear in shown.values())
        equal = [name for name, linear in shown.items() if best - linear.likelihood < _AS_GOOD]
        chosen = min(equal, key=lambda name: (len(known[name].columns), -shown[name].likelihood))
        rivals = {name: float(shown[name].values[0]) for name in equal if name != chosen}
        fitted = _extended(fitted, known[chosen], rivals)
    return _exact_offsets(fitted), known


def _extended(fitted: Fitted, effect: Effect, rivals: dict[str, float] | None = None) -> Fitted:
    effects, known = (*fitted.effects, effect), fitted.rivals | (rivals or {})
    return replace(fitted, linear=fitted.with_effect(effect), effects=effects, rivals=known)


def _is_shown(fitted: Fitted, effect: Effect, linear: Linear) -> bool:
    """Whether an effect explains more than chance does, and enough to matter."""
    from scipy.special import fdtrc

    worst = _WORST if fitted.effects else _WORST_OF_ONE
    if linear.assumed or linear.degrees_of_freedom < 1 or linear.error(0) > worst * abs(fitted.friction):
        return False
    if fitted.with_gain and abs(linear.values[1]) > abs(fitted.log_gain) + _PLAUSIBLE_GAIN:
        return False  # the effect stands for something else
    first = len(linear.values) - len(effect.columns)
    values, covariance = linear.values[first:], linear.covariance[first:, first:]
    moved = abs(sum(value * fitted.bias(column) for value, column in zip(values, effect.columns, strict=True)))
    reach = sum(float(np.ptp(value * column)) for value, column in zip(values, effect.columns, strict=True))
    if max(moved, 0.1 * reach / float(np.max(fitted.points.bend_angle))) < _MATTERS * abs(fitted.friction):
        return False
    strength = float(values @ np.linalg.pinv(covariance, hermitian=True) @ values) / len(values)
    inside = all(_within(fitted.points, column) for column in effect.columns)
    free = max(linear.degrees_of_freedom, linear.within if inside else 0)
    return float(fdtrc(len(values), free, strength)) < _BY_CHANCE[effect.name]


def _within(points: Points, column: Floats) -> bool:
    """Whether a column changes mostly within strokes, so that the scatter of the strokes does not hide it."""
    mean = np.bincount(points.stroke, column) / np.bincount(points.stroke)
    ways = np.bincount(points.stroke, points.way) > 0
    between = sum(float(np.sum((mean[ways == way] - mean[ways == way].mean()) ** 2)) for way in np.unique(ways))
    within = float(np.sum((column - mean[points.stroke]) ** 2))
    return within / len(column) > between / len(mean)
