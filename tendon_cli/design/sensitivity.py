"""How both ends of a window move with every number of the study, by derivative in the state that binds."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Literal

import numpy as np

from tendon_cli.design.candidates import Candidates, numbers_of
from tendon_cli.design.numbers import SIDE
from tendon_cli.design.problem import Flags, Problem
from tendon_cli.design.solve import solve
from tendon_cli.model import limits
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import Bounds
from tendon_cli.study.study import SIDES

End = Literal["from", "to"]

_STEP = 1e-30
"""Of an imaginary change: a complex step has no error of difference, so it may be as small as can be."""
_SHARE = 0.01

ARM = ("a1", "b1", "a2", "b2", "elbow_radius", "forearm_mass", "forearm_com", "load_distance", "upper_arm_angle",
       "contact_width")  # fmt: skip


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
    """Of both ends of one choice's window, the largest per 1 % first; none of an end that no limit of a state sets.

    Limits of the motor have none either.
    """
    found: list[Sensitivity] = []
    ends: tuple[End, End] = ("from", "to")
    for end in ends:
        code = int(getattr(choice.solutions, f"{end}_by")[0])
        state = int(getattr(choice.solutions, f"{end}_state")[0])
        if state >= 0 and code < limits.OF_THE_MOTOR and np.isfinite(getattr(choice.solutions, f"pretension_{end}")[0]):
            found += _of_end(problem, choice, end, code, state)
    return sorted(found, key=lambda each: -abs(each.per_percent))


def _of_end(problem: Problem, choice: Candidates, end: End, code: int, state: int) -> list[Sensitivity]:
    condition = int(getattr(choice.solutions, f"{end}_condition")[0])
    numbers = dict(numbers_of(problem, choice.columns))
    alone = problem.under(np.array([condition]))
    flexion, angle = divmod(state, problem.angles.size)
    at = problem.angles[:, [angle]], problem.flexion[[flexion]]
    found = []
    for key, value in _numbers_at(alone, numbers).items():
        changed = {key: np.array([value + _STEP * 1j])}
        design = alone.design(numbers, alone.condition_numbers | changed)
        slope = limits.limit_end(code, design, *at, problem.bounds).imag.item() / _STEP
        found.append(Sensitivity(end, key, value, slope, _is_steady(problem, numbers, key, value, end, (code, state))))
    return found + _of_limit(problem, alone.design(numbers), end, code, at)


def _numbers_at(alone: Problem, numbers: dict[str, Array]) -> dict[str, float]:
    """Every number that counts for a choice under one condition, by its key; of one side where the sides differ."""
    design = alone.design(numbers)
    found = {f"arm.{name}": _single(getattr(design.arm.anchors, name, getattr(design.arm, name, None))) for name in ARM}
    found |= {
        "spool.flexor_radius": _single(design.flexor_radius),
        "spool.ratio": _single(design.ratio),
        "load.mass": _single(design.load_mass),
    }
    for argument, key in SIDE.items():
        table, _, name = key.rpartition(".")
        of_sides = [_single(getattr(getattr(design, side), argument)) for side in SIDES]
        given = (*alone.study.numbers, *alone.condition_numbers, *numbers)
        if any(f"{table}.{side}.{name}" in given for side in SIDES):
            found |= {f"{table}.{side}.{name}": value for side, value in zip(SIDES, of_sides, strict=True)}
        else:
            found[key] = of_sides[0]
    return {key: value for key, value in found.items() if not np.isnan(value)}


def _single(value: object) -> float:
    return float(np.asarray(value).item())


def _of_limit(problem: Problem, design: Design, end: End, code: int, at: tuple[Array, Flags]) -> list[Sensitivity]:
    """And of the limit itself."""
    name = limits.LIMIT_NAMES[code]
    if name not in {each.name for each in fields(Bounds)}:
        return []
    own = float(getattr(problem.bounds, name))
    complex_bound: Any = own + _STEP * 1j
    slope = limits.limit_end(code, design, *at, replace(problem.bounds, **{name: complex_bound})).imag.item() / _STEP
    return [Sensitivity(end, f"limits.{name}", own, slope, steady=True)]


def _is_steady(
    problem: Problem, numbers: dict[str, Array], key: str, value: float, end: End, binding: tuple[int, int]
) -> bool:
    """Whether the same limit binds in the same state when a number is 1 % larger, and smaller, in every condition."""
    for factor in (1.0 - _SHARE, 1.0 + _SHARE):
        given = problem.condition_numbers.get(key)
        scaled = np.full(len(problem.conditions), value) if given is None else np.where(np.isnan(given), value, given)
        found = solve(problem.saying({key: scaled * factor}), numbers, 1, with_worst=False)
        if (int(getattr(found, f"{end}_by")[0]), int(getattr(found, f"{end}_state")[0])) != binding:
            return False
    return True
