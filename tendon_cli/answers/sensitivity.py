"""How both ends of a window move with every number of the study, by derivative in the state that binds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tendon_cli.answers.candidates import Candidates, numbers_of
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.solve import solve
from tendon_cli.model.bounds import Bounds, limit_end
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Spline
from tendon_cli.model.limits import LIMIT_NAMES, LIMITS
from tendon_cli.model.limits import PRETENSION as LIMIT_PRETENSION
from tendon_cli.model.motor_window import excess
from tendon_cli.model.setting import shown
from tendon_cli.space.axis import PRETENSION, WORDS, of_side
from tendon_cli.studies.study import keys

End = Literal["from", "to"]

_STEP = 1e-30
"""Of an imaginary change: a complex step has no error of difference, so it may be as small as can be."""
_SHARE = 0.01
_NEAR = 3
"""States apart that count as the same, for the angle that binds moves with most numbers."""


@dataclass(frozen=True)
class Sensitivity:
    """How one end of a window moves with one number."""

    end: End
    key: str
    """Dotted key of the number; of a limit `limits.` and its name."""
    value: float
    """In the state that binds, SI."""
    slope: float
    """N per SI unit."""
    steady: bool
    """Whether the same limit binds in the same state when the number is 1 % larger or smaller."""

    @property
    def per_percent(self) -> float:
        """N per 1 % of the number."""
        return self.slope * self.value / 100.0


def sensitivities(problem: Problem, choice: Candidates) -> list[Sensitivity]:
    """Of both ends of one choice's window, the largest per 1 % first; none of an end that no limit on motion sets."""
    slopes: list[Sensitivity] = []
    ends: tuple[End, End] = ("from", "to")
    for end in ends:
        code = int(getattr(choice.solutions, f"{end}_by")[0])
        state = int(getattr(choice.solutions, f"{end}_state")[0])
        is_set = state >= 0 or (code >= 0 and _is_of_motion(LIMIT_NAMES[code]))
        if is_set and np.isfinite(getattr(choice.solutions, f"pretension_{end}")[0]):
            slopes += _of_end(problem, choice, end, code, state)
    return sorted(slopes, key=lambda each: -abs(each.per_percent))


def _of_end(problem: Problem, choice: Candidates, end: End, code: int, state: int) -> list[Sensitivity]:
    condition = int(getattr(choice.solutions, f"{end}_condition")[0])
    numbers = dict(numbers_of(problem, choice.columns))
    alone = problem.under(np.array([condition]))
    pretension = float(getattr(choice.solutions, f"pretension_{end}")[0])
    design, name, slopes = alone.design(numbers), LIMIT_NAMES[code], []
    of_motor = _OfMotor(alone, design, code, state, pretension) if _is_of_motion(name) else None
    direction, place = divmod(state, alone.angles.size)
    beside = float(getattr(choice.solutions, f"{end}_angle")[0])
    angle = float(alone.angles[0, place]) if np.isnan(beside) else beside
    bound = of_motor or _OfState(alone, code, angle, bool(alone.flexion[direction, 0]), end == "to")
    for key, value in _numbers_at(alone, numbers).items():
        changed = {key: np.array([value + _STEP * 1j])}
        slope = bound.slope(alone.design(numbers, {**alone.condition_numbers, **changed}))
        slopes.append(Sensitivity(end, key, value, slope, _is_steady(problem, numbers, key, value, end, (code, state))))
    if name not in problem.bounds:
        return slopes
    if "motion.speed" in (need.key for need in LIMITS[name].needs):
        speed = float(problem.bounds.speed)
        slopes.append(Sensitivity(end, "motion.speed", speed, bound.slope(design, "speed"), steady=True))
    return [*slopes, Sensitivity(end, f"limits.{name}", problem.limit(name), bound.slope(design, name), steady=True)]


@dataclass(frozen=True, eq=False)
class _OfState:
    """An end that a limit on a state sets: it is where the limit is just kept."""

    alone: Problem
    code: int
    angle: float
    flexion: bool
    upper: bool

    def slope(self, design: Design, bound: str | None = None) -> float:
        """How it moves with what is complex in a design, or with the bound itself."""
        at = np.array([[self.angle]]), np.array([[self.flexion]])
        bounds = self.alone.bounds if bound is None else _stepped(self.alone.bounds, bound)
        end = limit_end(self.code, design, *at, bounds, upper=self.upper)
        read = end if self.code == LIMIT_PRETENSION else shown(design, end)
        return float(read.imag.item()) / _STEP


@dataclass(frozen=True, eq=False)
class _OfMotor:
    """An end F that a limit on the motor sets: its excess e is 0 there, so that dF/dp = -(de/dp)/(de/dF)."""

    alone: Problem
    design: Design
    code: int
    state: int
    pretension: float

    def slope(self, design: Design, bound: str | None = None) -> float:
        """How it moves with what is complex in a design, or with a bound or the speed."""
        given = self.alone.bounds
        bounds = given if bound is None else _stepped(given, bound)
        return -self._excess(design, bounds, self.pretension) / self._excess(
            self.design, given, self.pretension + _STEP * 1j
        )

    def _excess(self, design: Design, bounds: Bounds, pretension: complex) -> float:
        name, alone = LIMIT_NAMES[self.code], self.alone
        return excess(name, design, alone.angles, alone.flexion, bounds, pretension, self.state).imag


def _stepped(bounds: Bounds, name: str) -> Bounds:
    """Bounds of which one, or the speed, is complex."""
    return bounds.changed(name, np.asarray((bounds.speed if name == "speed" else bounds[name]) + _STEP * 1j))


def _is_of_motion(name: str) -> bool:
    return name in LIMITS and LIMITS[name].of_motion


def _numbers_at(alone: Problem, numbers: dict[str, Array]) -> dict[str, float]:
    """Every number that counts for a choice under one condition, by its key; of one side where the sides differ."""
    space = alone.points(numbers, alone.condition_numbers)
    values = {}
    for (key, side), number in space.of_the_model.items():
        if key not in (PRETENSION, *WORDS) and key in keys() and not isinstance(number.value, Spline):
            name = of_side(key, side) if side and key in space.of_sides else key
            values[name] = float(np.asarray(number.within(space.whole)).item())
    return {key: value for key, value in values.items() if np.isfinite(value)}


def _is_steady(
    problem: Problem, numbers: dict[str, Array], key: str, value: float, end: End, binding: tuple[int, int]
) -> bool:
    """Whether the same limit binds in the same state when a number is 1 % larger, and smaller, in every condition."""
    for factor in (1.0 - _SHARE, 1.0 + _SHARE):
        given = problem.condition_numbers.get(key)
        scaled = np.full(len(problem.conditions), value) if given is None else np.where(np.isnan(given), value, given)
        solutions = solve(problem.saying({key: scaled * factor}), numbers, 1, with_worst=False)
        by, state = int(getattr(solutions, f"{end}_by")[0]), int(getattr(solutions, f"{end}_state")[0])
        if by != binding[0] or abs(state - binding[1]) > _NEAR:
            return False
    return True
