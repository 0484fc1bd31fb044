"""How limits on the motor and the transmission narrow a window of pretension.

Where all states are taut, spool angle, motor torque and dα/dθ are straight lines in pretension F. Limits on speed,
backlash and torque band are half-lines therefore, as those of `window`; spool travel is the largest of lines less the
smallest, which is convex. Power is a product of two lines, friction's loss a sum of such, so that the pretensions that
they allow may be in several intervals, of which the widest is used (`intervals`). Arguments broadcast as in `window`;
SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import evaluate
from tendon_cli.model.cycle import gauss, taken
from tendon_cli.model.design import Design
from tendon_cli.model.intervals import Measure, cut_to_widest, shut
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.motor import MotorRates, motor_rates
from tendon_cli.model.response import SLACK_TOLERANCE
from tendon_cli.model.window import Window

_UNIT = 100.0
"""N; between multiples of it lines and parabolas are drawn."""
_LONG_STEP = float(np.radians(7.5))


@dataclass(frozen=True, eq=False)
class MotorBounds:
    """What the motor of a design is held to at a speed of the elbow, in SI; infinite where nothing is asked."""

    speed: float
    """Of the elbow, rad/s."""
    max_spool_travel: float = np.inf
    max_backlash: float = np.inf
    max_torque_band: float = np.inf
    peak_motor_speed: float = np.inf
    peak_motor_power: float = np.inf
    max_motor_work_in: float = np.inf
    max_friction_loss: float = np.inf
    min_efficiency: float = -np.inf

    @property
    def asked(self) -> list[str]:
        """The limits that are given."""
        return [each.name for each in fields(self)[1:] if np.isfinite(getattr(self, each.name))]


@dataclass(frozen=True, eq=False)
class Narrowed:
    """The windows that are left, and in how many intervals; the widest is the window."""

    window: Window
    intervals: npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class _Lines:
    """base + gain F of states, (designs, states)."""

    base: Array
    gain: Array

    def at(self, pretension: Array) -> Array:
        """Values at one pretension of each design, (designs,)."""
        return np.asarray(self.base + self.gain * pretension[:, np.newaxis])


def narrowed(found: Window, design: Design, elbow_angle: Array, flexion: Flags, bounds: MotorBounds) -> Narrowed:
    """Windows within the limits of the motor, too; directions (D, 1) and elbow angles (1, K) as for `window`.

    Empty windows stay as they are.
    """
    shape = found.low.shape or (1,)
    whole = {each.name: np.array(getattr(found, each.name)).reshape(shape) for each in fields(found)}
    intervals, open_ = np.zeros(shape, dtype=np.int64), np.nonzero(found.is_open.reshape(shape))
    if not open_[0].size or not bounds.asked:
        return Narrowed(found, found.is_open.astype(np.int64))
    some = Window(**{name: values[open_] for name, values in whole.items()})
    of_some = taken(design, (*shape, 1, 1), open_)
    motor = _Motor(of_some, np.asarray(elbow_angle), flexion, some.low.shape, bounds)
    for name, lines, most in motor.half_lines():
        _cut(some, LIMIT_NAMES.index(name), lines, most)
    measures = {LIMIT_NAMES.index(name): measure for name, measure in motor.measures()}
    intervals[open_] = cut_to_widest(some, measures) if measures else some.is_open
    for name, values in whole.items():
        values[open_] = getattr(some, name)
    shaped = {name: values.reshape(found.low.shape) for name, values in whole.items()}
    return Narrowed(Window(**shaped), intervals.reshape(found.low.shape))


def excess(
    name: str, design: Design, elbow_angle: Array, flexion: Flags, bounds: MotorBounds, pretension: complex, state: int
) -> complex:
    """By how much one design exceeds a limit at a pretension; also of complex numbers, for derivatives.

    `state` is the one that binds, as windows have it, where the limit is kept state by state. The design's own axes are
    two, of one each.
    """
    motor, at = _Motor(design, elbow_angle, flexion, (1, 1), bounds), np.array([pretension])
    for limit, lines, most in motor.half_lines():
        if limit == name:
            value = complex(lines.at(at)[0, state])
            return (value if value.real > 0.0 else -value) - most
    return complex(dict(motor.measures())[name](at)[0])


class _Motor:
    """Lines of the motor's quantities over all states of designs of a shape, all taut."""

    def __init__(
        self, design: Design, elbow_angle: Array, flexion: Flags, shape: tuple[int, ...], bounds: MotorBounds
    ) -> None:
        self.design, self.angles, self.flexion, self.bounds = design, elbow_angle, flexion, bounds
        self.shape = shape
        self.ways = np.broadcast_to(np.where(flexion, 1.0, -1.0), (np.size(flexion), elbow_angle.size))
        rates, torque = zip(*(self._rates(pretension, elbow_angle) for pretension in (0.0, _UNIT)), strict=True)
        self.spool_angle = self._lines([each.spool_angle for each in rates])
        self.spool_speed = self._lines([each.spool_speed for each in rates])
        self.torque = self._lines(list(torque))

    def _rates(self, pretension: float, angles: Array) -> tuple[MotorRates, Array]:
        sides = {name: replace(getattr(self.design, name), pretension=pretension) for name in ("flexor", "extensor")}
        taut = replace(self.design, unilateral=False, **sides)
        state = evaluate(taut, angles, self.flexion)
        return motor_rates(taut, state), state.motor_torque

    def _flat(self, values: Array) -> Array:
        """Values of states as (designs, states)."""
        states = np.size(self.flexion), values.shape[-1]
        return np.broadcast_to(values, (*self.shape, *states)).reshape(-1, states[0] * states[1])

    def _lines(self, values: list[Array]) -> _Lines:
        base, above = (self._flat(each) for each in values)
        return _Lines(base, (above - base) / _UNIT)

    def half_lines(self) -> Iterator[tuple[str, _Lines, float]]:
        """Every limit on lines, both ways."""
        speed = self.bounds.speed
        for name, lines in (
            ("peak_motor_speed", _Lines(speed * self.spool_speed.base, speed * self.spool_speed.gain)),
            ("max_backlash", self._between(self.spool_angle)),
            ("max_torque_band", self._between(self.torque)),
        ):
            most = getattr(self.bounds, name)
            if name in self.bounds.asked and lines is not None:
                yield name, lines, most
                yield name, _Lines(-lines.base, -lines.gain), most

    def _between(self, lines: _Lines) -> _Lines | None:
        """The difference between the directions, where there are both."""
        ways = np.ravel(self.flexion)
        if ways.all() or not ways.any():
            return None
        there, back = int(np.argmax(ways)), int(np.argmin(ways))
        shaped = [each.reshape(len(each), len(ways), -1) for each in (lines.base, lines.gain)]
        base, gain = (each[:, there] - each[:, back] for each in shaped)
        return _Lines(base, gain)

    def measures(self) -> Iterator[tuple[str, Measure]]:
        """Every limit on what is no line."""
        bounds, forward = self.bounds, self._flat(self.ways)
        if "max_spool_travel" in bounds.asked:
            yield "max_spool_travel", lambda at: np.ptp(self.spool_angle.at(at), axis=1) - bounds.max_spool_travel
        if "peak_motor_power" in bounds.asked:
            yield (
                "peak_motor_power",
                lambda at: (
                    np.max(forward * bounds.speed * self.torque.at(at) * self.spool_speed.at(at), axis=1)
                    - bounds.peak_motor_power
                ),
            )
        if "max_friction_loss" in bounds.asked:
            lost = self._loss()
            yield "max_friction_loss", lambda at: lost(at) - bounds.max_friction_loss
        if "max_motor_work_in" in bounds.asked:
            done = self._work()
            yield "max_motor_work_in", lambda at: done(at) - bounds.max_motor_work_in
        if "min_efficiency" in bounds.asked:
            work, loss = self._work(), self._loss()
            # Without work there is no efficiency, and nothing that could be held to one.
            yield (
                "min_efficiency",
                lambda at: np.where(work(at) > 0.0, loss(at) - (1.0 - bounds.min_efficiency) * work(at), -np.inf),
            )

    def _work(self) -> Measure:
        """Work of the motor where it drives, J: in fine steps, for it has kinks where it begins to brake."""
        nodes, weights = gauss(np.unique(self.angles))
        found = [self._rates(pretension, nodes[np.newaxis]) for pretension in (0.0, _UNIT)]
        torque, turning = self._lines([each for _, each in found]), self._lines([each.spool_speed for each, _ in found])
        forward, weight = np.repeat(self.ways[:, 0], len(nodes)), np.tile(weights, np.size(self.flexion))
        return lambda at: np.asarray(np.maximum(forward * torque.at(at) * turning.at(at), 0.0) @ weight)

    def _loss(self) -> Measure:
        """What friction takes, J: a parabola in pretension, and smooth over all angles."""
        span = np.array([self.angles.min(), self.angles.max()])
        nodes, weights = gauss(span, _LONG_STEP)
        weight = np.outer(self.ways[:, 0], weights).ravel()
        first, second, third = (
            self._flat(self._rates(pretension, nodes[np.newaxis])[0].friction) @ weight
            for pretension in (0.0, _UNIT, 2.0 * _UNIT)
        )
        slope, bend = (4.0 * second - 3.0 * first - third) / 2.0, (third - 2.0 * second + first) / 2.0
        return lambda at: np.asarray(first + at / _UNIT * (slope + at / _UNIT * bend))


def _cut(found: Window, code: int, lines: _Lines, most: float) -> None:
    """Cut windows by half-lines of states, in place."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = (most - lines.base) / lines.gain
    below, above = np.where(lines.gain < 0.0, ends, -np.inf), np.where(lines.gain > 0.0, ends, np.inf)
    low, high = below.max(axis=1), above.min(axis=1)
    higher, lower = low > found.low, high < found.high
    found.low[higher], found.low_by[higher], found.low_state[higher] = low[higher], code, below.argmax(axis=1)[higher]
    found.high[lower], found.high_by[lower], found.high_state[lower] = high[lower], code, above.argmin(axis=1)[lower]
    hopeless = ((lines.gain == 0.0) & (lines.base > most * (1.0 + SLACK_TOLERANCE))).any(axis=1)
    shut(found, code, hopeless)
