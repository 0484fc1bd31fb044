"""How limits on the whole motion narrow a window of pretension: those of `limits` that are no forms of single states.

Where all states are taut, spool angle, motor torque and dα/dθ are straight lines in pretension F. Limits on backlash
and torque band are half-lines therefore, as those of `window`; spool travel is the largest of lines less the smallest,
which is convex. Power is a product of two lines, friction's loss a sum of such, so that the pretensions that they allow
may be in several intervals, of which the widest is used: their ends are sought by bisection between samples. Arguments
broadcast as in `window`; SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import SIDES, State, evaluate
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Real
from tendon_cli.model.limits import LIMIT_NAMES, LIMITS
from tendon_cli.model.motor import gauss, motor_rates, select_points
from tendon_cli.model.statics import SLACK_TOLERANCE
from tendon_cli.model.window import Positions, Window

_STEP = 100.0  # N; how far the search for an end begins where a window has none
_SAMPLES, _HALVINGS, _DOUBLINGS = 65, 45, 16
_UNIT = 100.0  # N; between multiples of it lines and parabolas are drawn
Measure = Callable[[Array], Array]
"""By how much a limit is exceeded at a pretension of each design, (designs,): above 0 it is broken."""


@dataclass(frozen=True, eq=False)
class Lines:
    """base + gain F of states, (designs, states)."""

    base: Array
    gain: Array

    def at(self, pretension: Array) -> Array:
        """Values at one pretension of each design, (designs,)."""
        return np.asarray(self.base + self.gain * pretension[:, np.newaxis])


def narrowed(
    windows: Window,
    design: Design,
    elbow_angle: Array,
    flexion: Flags,
    bounds: Bounds,
    loads: tuple[float, float] | None = None,
) -> Window:
    """Windows within the limits of the motor, too; directions (D, 1) and elbow angles (1, K) as for `window`.

    The widest interval is what is left. Power is that of all loads (kg) between two, if they are given. Empty windows
    stay as they are.
    """
    shape = windows.low.shape or (1,)
    whole = {name: np.array(values).reshape(shape) for name, values in vars(windows).items()}
    open_ = np.nonzero(windows.is_open.reshape(shape))
    if not open_[0].size or not bounds.of_motion:
        return windows
    some = Window(**{name: values[open_] for name, values in whole.items()})
    of_some = select_points(design, (*shape, 1, 1), open_)
    motor = Motor(of_some, np.asarray(elbow_angle), flexion, some.low.shape, bounds.speed, loads)
    measures = {}
    for limit in bounds.of_motion:
        code, bound = LIMIT_NAMES.index(limit.name), bounds[limit.name]
        if limit.excess is not None:
            measures[code] = limit.excess(motor, bound)
        elif limit.lines is not None and (lines := limit.lines(motor)) is not None:
            for sign in (1.0, -1.0):
                _cut(some, code, Lines(sign * lines.base, sign * lines.gain), bound)
    if measures:
        _cut_to_widest(some, measures)
    for name, values in whole.items():
        values[open_] = getattr(some, name)
    return Window(**{name: values.reshape(windows.low.shape) for name, values in whole.items()})


def excess(
    name: str,
    design: Design,
    elbow_angle: Array,
    flexion: Flags,
    bounds: Bounds,
    pretension: complex,
    state: int,
) -> complex:
    """By how much one design exceeds a limit at a pretension; also of complex numbers, for derivatives.

    `state` is the one that binds, as windows have it, where the limit is kept state by state. The design's own axes are
    two, of one each.
    """
    motor, at = Motor(design, elbow_angle, flexion, (1, 1), bounds.speed), np.array([pretension])
    limit, bound = LIMITS[name], bounds[name]
    if limit.lines is not None and (lines := limit.lines(motor)) is not None:
        value = complex(lines.at(at)[0, state])
        return (value if value.real > 0.0 else -value) - complex(bound)
    if limit.excess is None:
        raise ValueError(f"{name} is no limit on the whole motion")
    return complex(limit.excess(motor, bound)(at)[0])


@dataclass(eq=False)
class Motor:
    """Lines of the motor's quantities over all states of designs of a shape, all taut."""

    design: Design
    angles: Array
    flexion: Flags
    shape: tuple[int, ...]
    speed: Real
    loads: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        self.ways = np.broadcast_to(
            np.where(self.flexion, 1.0, -1.0), (len(self.flexion), self.angles.size)
        )
        self.trajectory = self.design.trajectory  # along which rates are per second
        self.velocity = (
            self.ways * self.speed if self.trajectory is None else np.ones(self.ways.shape)
        )
        self.spool_angle, self.spool_speed, self.torque = self._lines(self.angles)

    def _lines(self, angles: Array) -> list[Lines]:
        """Spool angle, its speed and the motor's torque, from those at no pretension and at `_UNIT`."""
        values = []
        for state in (self._taut(pretension, angles) for pretension in (0.0, _UNIT)):
            rates = motor_rates(state)
            values.append(
                [
                    self._flat(each)
                    for each in (rates.spool_angle, rates.spool_speed, state.motor_torque)
                ]
            )
        return [Lines(base, (above - base) / _UNIT) for base, above in zip(*values, strict=True)]

    def _taut(self, pretension: float, angles: Array) -> State:
        sides = {name: replace(getattr(self.design, name), pretension=pretension) for name in SIDES}
        return evaluate(replace(self.design, unilateral=False, **sides), angles, self.flexion)

    def _flat(self, values: Array) -> Array:
        """Values of states as (designs, states)."""
        states = len(self.flexion), values.shape[-1]
        return np.broadcast_to(values, (*self.shape, *states)).reshape(-1, states[0] * states[1])

    def between(self, lines: Lines) -> Lines | None:
        """The difference between the directions, where there are both."""
        ways = np.ravel(self.flexion)
        if ways.all() or not ways.any():
            return None
        there, back = int(np.argmax(ways)), int(np.argmin(ways))
        shaped = [each.reshape(len(each), len(ways), -1) for each in (lines.base, lines.gain)]
        return Lines(*(each[:, there] - each[:, back] for each in shaped))

    def power(self, at: Array) -> Array:
        """Of the motor in each state at one pretension of each design, W: (designs, states)."""
        forward = self._flat(self.velocity)
        power = np.asarray(forward * self.torque.at(at) * self.spool_speed.at(at))
        if self.loads is None:
            return power
        torque, more = (each.torque.at(at) for each in self._of_loads)
        turning, faster = (each.spool_speed.at(at) for each in self._of_loads)
        # A parabola in the load, as torque and speed are lines in it.
        with np.errstate(divide="ignore", invalid="ignore"):
            top = -0.5 * (torque / (more - torque) + turning / (faster - turning))
            most = forward * (torque + top * (more - torque)) * (turning + top * (faster - turning))
        return np.where((top > 0.0) & (top < 1.0), np.fmax(power, most), power)

    @cached_property
    def _of_loads(self) -> list[Motor]:
        """With the least and the largest load."""
        given = self.angles, self.flexion, self.shape, self.speed
        return [Motor(replace(self.design, load_mass=load), *given) for load in self.loads or ()]

    @cached_property
    def work(self) -> Measure:
        """Work of the motor where it drives, J: in fine steps, for it has kinks where it begins to brake."""
        if self.trajectory is not None:
            seconds = self.trajectory.weights
            return lambda at: np.asarray(np.maximum(self.power(at), 0.0) @ seconds)
        nodes, weights = gauss(np.unique(self.angles))
        _, turning, torque = self._lines(nodes[np.newaxis])
        forward, weight = (
            np.repeat(self.ways[:, 0], len(nodes)),
            np.tile(weights, np.size(self.flexion)),
        )
        return lambda at: np.asarray(
            np.maximum(forward * torque.at(at) * turning.at(at), 0.0) @ weight
        )

    @cached_property
    def loss(self) -> Measure:
        """What friction takes, J: a parabola in pretension, and smooth over all angles."""
        nodes, weights = gauss(
            np.array([self.angles.min(), self.angles.max()]), float(np.radians(7.5))
        )
        weight = np.outer(self.ways[:, 0], weights).ravel()
        if self.trajectory is not None:
            nodes, weight = self.trajectory.angle, self.trajectory.weights
        first, second, third = (
            self._flat(motor_rates(self._taut(pretension, nodes[np.newaxis])).friction) @ weight
            for pretension in (0.0, _UNIT, 2.0 * _UNIT)
        )
        slope, bend = (
            (4.0 * second - 3.0 * first - third) / 2.0,
            (third - 2.0 * second + first) / 2.0,
        )
        return lambda at: np.asarray(first + at / _UNIT * (slope + at / _UNIT * bend))


def _cut(windows: Window, code: int, lines: Lines, most: Real) -> None:
    """Cut windows by half-lines of states, in place."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = (most - lines.base) / lines.gain
    for name, sign in (("low", 1.0), ("high", -1.0)):
        asked = np.where(sign * lines.gain < 0.0, sign * ends, -np.inf)
        tightest = asked.max(axis=1)
        _set(
            windows,
            name,
            tightest > sign * getattr(windows, name),
            sign * tightest,
            code,
            asked.argmax(axis=1),
        )
    hopeless = ((lines.gain == 0.0) & (lines.base > most * (1.0 + SLACK_TOLERANCE))).any(axis=1)
    _close(windows, code, hopeless)


def _set(
    windows: Window,
    name: str,
    which: Flags,
    end: Array,
    code: int | Positions,
    state: int | Positions,
) -> None:
    """Give some of the windows another lower or upper end, in place."""
    for of_end, new in (
        (name, end),
        (f"{name}_by", code),
        (f"{name}_state", state),
        (f"{name}_angle", np.nan),
    ):
        values = getattr(windows, of_end)
        values[which] = np.broadcast_to(new, values.shape)[which]


def _cut_to_widest(windows: Window, measures: dict[int, Measure]) -> None:
    """Cut open windows to the widest interval within other limits, in place."""
    start = np.where(windows.is_open, windows.low, 0.0)
    stop = np.where(np.isfinite(windows.high) & windows.is_open, windows.high, start + _STEP)
    endless = windows.is_open & np.isinf(windows.high)
    for _ in range(_DOUBLINGS if endless.any() else 0):  # beyond where any limit is kept
        stop = np.where(endless & ~_broken(stop, measures), start + 2.0 * (stop - start), stop)
    places = start + np.linspace(0.0, 1.0, _SAMPLES)[:, np.newaxis] * (stop - start)
    broken = {
        code: np.array([measure(at) > 0.0 for at in places]) for code, measure in measures.items()
    }
    kept = ~np.any(list(broken.values()), axis=0)
    rows, places_of = np.arange(len(start)), np.arange(_SAMPLES)[:, np.newaxis]
    # The widest: it is longest since the last broken sample.
    since = places_of - np.maximum.accumulate(np.where(kept, -1, places_of))
    last = since.argmax(axis=0)
    first = last - since[last, rows] + 1
    some = windows.is_open & kept.any(axis=0)
    for name, inner, outer in (("low", first, first - 1), ("high", last, last + 1)):
        cut, beyond = (
            (outer >= 0) & (outer < _SAMPLES),
            places[np.clip(outer, 0, _SAMPLES - 1), rows],
        )
        _set(windows, name, some & cut, *_edge(places[inner, rows], beyond, measures), -1)
    worst = np.array([each.sum(axis=0) for each in broken.values()]).argmax(axis=0)
    _close(windows, np.array(list(broken))[worst], windows.is_open & ~some)


def _broken(at: Array, measures: dict[int, Measure]) -> npt.NDArray[np.bool_]:
    return np.asarray(np.any([measure(at) > 0.0 for measure in measures.values()], axis=0))


def _edge(
    inside: Array, outside: Array, measures: dict[int, Measure]
) -> tuple[Array, npt.NDArray[np.int64]]:
    """Where between two pretensions the limits are just kept, and the limit that is broken beyond."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        broken = _broken(middle, measures)
        inside, outside = np.where(broken, inside, middle), np.where(broken, middle, outside)
    beyond = np.array([measure(outside) for measure in measures.values()])
    return inside, np.array(list(measures))[beyond.argmax(axis=0)]


def _close(
    windows: Window, code: int | npt.NDArray[np.int64], which: npt.NDArray[np.bool_]
) -> None:
    """Leave no pretension at all, for a reason."""
    which = which & ~np.isnan(windows.low)
    for ends, by in ((windows.low, windows.low_by), (windows.high, windows.high_by)):
        ends[which], by[which] = np.nan, np.broadcast_to(code, which.shape)[which]
