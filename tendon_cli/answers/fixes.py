"""What would give a choice without a window one: the least change of each parameter."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.phrases import COSTS, Row, costs, parameter
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.solve import WORST, Solutions, solve
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import Quantity
from tendon_cli.space.axis import Numbers
from tendon_cli.studies.study import keys
from tendon_cli.units import parse_measure

PARAMETERS = {
    "spring.stiffness": (200.0, 5e4),
    "spool.ratio": (0.3, 2.0),
    "spool.flexor_radius": (0.01, 0.08),
    "arm.elbow_radius": (0.02, 0.1),
    "sheath.friction": (0.005, 0.3),
    "sheath.bend_angle": (0.2, 12.0),
    "arm.a1": (0.005, 0.1),
    "arm.b1": (0.05, 0.3),
    "arm.a2": (0.002, 0.08),
    "arm.b2": (0.05, 0.25),
    "tendon.length": (0.2, 5.0),
    "tendon.diameter": (4e-4, 4e-3),
}
"""What a designer can change, and between which values that is plausible, SI."""

_POINTS = 65
_SECTIONS = 16
_ROUNDS = 14
_MOST = (
    250_000  # states of one choice under all conditions; beyond it, some conditions stand for all
)
_OF_MOTOR = 50  # states that take as long as one does with limits on the motor
_FEW = 8

First = Callable[[Array], tuple[int | None, int]]
"""Of some values the first that gives a window, and the one that is nearest to do so."""


def fixes(problem: Problem, choice: Solutions) -> list[dict[str, Any]]:
    """What each parameter alone does for one choice, as recorded, the least change first.

    SI; `after` is null if no value within the plausible range gives a window, else `printed` is a value as a study can
    have it, rounded so that it gives one, too, and `printed_pretension` is one of that, N.
    """
    numbers = problem.numbers_of(choice.columns)
    before = {
        key: value for key in PARAMETERS if 0.0 < (value := _now(problem, numbers, key)) < np.inf
    }
    all_fixes = [_fix(problem, numbers, key, value) for key, value in before.items()]
    return sorted(
        all_fixes,
        key=lambda fix: abs(np.log(fix["after"] / fix["before"])) if fix["after"] else np.inf,
    )


def sampled(problem: Problem, choice: Solutions) -> Problem:
    """The same question under as many of its persons, draws or conditions as changes can be tried for.

    They are drawn at random, but for those that bind the choice.
    """
    groups = len(problem.weighting)
    of_choice = (
        len(problem.conditions)
        * problem.states_per_design
        * (_OF_MOTOR if problem.bounds.of_motion else 1)
    )
    most = max(_FEW, groups * _MOST // of_choice)
    if most >= groups:
        return problem
    ends = np.array([choice["from_condition"][0], choice["to_condition"][0]])
    binding = np.unique(problem.groups[np.minimum(ends, len(problem.groups) - 1)])
    order = np.random.default_rng(1).permutation(groups)
    chosen = np.concatenate([binding, order[~np.isin(order, binding)]])[:most]
    return problem.select_groups(np.sort(chosen))


def _now(problem: Problem, numbers: Numbers, key: str) -> float:
    """A parameter's value in a choice; NaN if it differs between conditions or sides."""
    space = problem.choices.at(numbers, problem.condition_numbers)
    if key in problem.condition_numbers or key in space.of_sides:
        return np.nan
    return float(np.asarray(replace(space.number(key), scales=()).within(space.whole)).item())


def _fix(problem: Problem, numbers: Numbers, key: str, before: float) -> dict[str, Any]:
    low, high = PARAMETERS[key]

    def tried(values: Array, *, with_worst: bool = False) -> Solutions:
        changed = {name: np.repeat(value, len(values)) for name, value in numbers.items()}
        return solve(problem, changed | {key: values}, len(values), with_worst=with_worst)

    def first(values: Array) -> tuple[int | None, int]:
        solved = tried(values)
        opens = solved["feasible"]
        nearest = int(np.argsort(_width(problem, solved), kind="stable")[-1])
        return int(np.argmax(opens)) if opens.any() else None, nearest

    ends = [end for end in (low, high) if (end - before) * (end - low - (high - end)) > 0.0]
    values = [value for end in ends if (value := _nearest(first, before, end)) is not None]
    record = {"parameter": key, "before": before, "after": None, "plausible": (low, high)}
    if not values:
        return record | {"pretension": None, "printed": "", "printed_pretension": ""}
    after = min(values, key=lambda value: abs(np.log(value / before)))
    solved = tried(np.array([after]), with_worst=True)
    costs = {
        name: solved.scalar(name) if np.isfinite(solved.scalar(name)) else None
        for name in ("pretension", *WORST)
    }
    printed, pretension = _printed(tried, keys()[key].number.quantity, before, after)
    return record | {"after": after, **costs, "printed": printed, "printed_pretension": pretension}


def _printed(
    tried: Callable[[Array], Solutions], of: Quantity, before: float, after: float
) -> tuple[str, str]:
    """The shortest text of a value beyond `after` that opens a window when it is typed in, and a pretension in it."""
    toward = np.inf if after > before else -np.inf
    for digits in range(3, 16):
        text = say.quantity(of, after, digits, toward=toward)
        solved = tried(np.array([parse_measure(text.replace(",", ""), of.dimension).si]))
        if solved["feasible"][0]:
            at, low, high = (
                solved.scalar(name) for name in ("pretension", "pretension_from", "pretension_to")
            )
            return text, say.within(at, low, high, digits=3)
    return repr(after), ""


def _nearest(first: First, before: float, end: float) -> float | None:
    """The value nearest to `before`, on the way to `end`, that opens a window."""
    values = np.geomspace(before, end, _POINTS)
    at, nearest = first(values)
    for _ in range(
        4
    ):  # between three values, where a narrow window may hide: around the nearest to have one
        if at is not None:
            break
        values = np.geomspace(
            values[max(nearest - 1, 0)], values[min(nearest + 1, len(values) - 1)], _SECTIONS
        )
        at, nearest = first(values)
    if not at:
        return None if at is None else float(values[0])
    return edge(first, float(values[at - 1]), float(values[at]), _SECTIONS, _ROUNDS)


def edge(
    first: First,
    empty: float,
    open_: float,
    sections: int,
    rounds: int,
    spaced: Callable[..., Array] = np.linspace,
) -> float:
    """Where a window opens between two values; the last that has one."""
    for _ in range(rounds):
        values = spaced(empty, open_, sections)
        values[-1] = open_
        inner, _ = first(values[1:-1])
        at = sections - 1 if inner is None else inner + 1
        if (empty, open_) == (values[at - 1], values[at]):
            break
        empty, open_ = float(values[at - 1]), float(values[at])
    return open_


def _width(problem: Problem, solutions: Solutions) -> Array:
    """How far a window is open, N; if a share is asked for, by how much more than enough is served."""
    if problem.enough < 1.0:
        return solutions["served"] - problem.enough
    with np.errstate(invalid="ignore"):
        width = solutions["pretension_to"] - solutions["pretension_from"]
    return np.where(np.isnan(width), -np.inf, width)


def fixes_table(fixes: list[Row]) -> Iterator[say.Block]:
    """What each parameter alone would have to become, as a table."""
    lines = [["", "N", *COSTS.values()]]
    for fix in (fix for fix in fixes if fix["after"] is not None):
        before = parameter(fix["parameter"], fix["before"])
        lines.append([f"{before} to {fix['printed']}", fix["printed_pretension"], *costs(fix)])
    yield say.heading("What would help, all else equal")
    yield from [say.table(lines)] if len(lines) > 1 else ()
    idle = [
        keys()[fix["parameter"]].number.quantity.symbol for fix in fixes if fix["after"] is None
    ]
    yield from say.items([f"no plausible value of these helps: {', '.join(idle)}"] if idle else [])
