"""Fixes for a choice without a window: the least change of each parameter that gives it one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tendon_cli import say
from tendon_cli.answer_record import FixRecord
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import Quantity
from tendon_cli.studies.study import keys
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.units import parse_measure
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import Question
from tendon_cli.windows.solutions import Solutions, solve
from tendon_cli.windows.solver import Solver

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
"""Parameters that a designer can change, and the plausible range of each, SI."""

_POINTS = 65
"""Values tried on the way to the end of a plausible range."""
_SECTIONS = 16
"""Values tried between two neighbours of these."""
_ZOOMS = 4
"""Most times that a narrow window is sought around the most promising value."""
_ROUNDS = 14
"""Rounds in which the value at which a window opens is narrowed down."""
_MOST = 250_000
"""Most states of one choice under all conditions; beyond it, only some groups are tried."""
_OF_MOTOR = 50
"""Factor on the time of a state with limits on the motor."""
_FEW = 8
"""Fewest groups that are tried."""

FirstOpen = Callable[[Array], tuple[int | None, int]]
"""Function from values to two places: of the first that gives a window (None if none does), and of
the one that is nearest to giving one."""


def fixes(solver: Solver, choice: Solutions) -> list[FixRecord]:
    """Return the least change of each parameter alone that gives one choice a window, as recorded.

    The parameter that changes by the smallest factor comes first. Values are SI. `after` is null if
    no value within the plausible range gives a window. Otherwise `printed` is a value that a study
    can have, rounded so that it gives one, too, and `printed_pretension` is a pretension in that
    window, N.
    """
    all_fixes = []
    for key in PARAMETERS:
        before = _current_value(solver.question, choice.points, key)
        if 0.0 < before < np.inf:
            all_fixes.append(_fix(solver, choice.points, key, before))
    return sorted(
        all_fixes,
        key=lambda fix: abs(np.log(fix["after"] / fix["before"])) if fix["after"] else np.inf,
    )


def sampled(question: Question, choice: Solutions) -> Question:
    """Return the question for some of its groups if all are too many to try changes for.

    They are the groups that bind the choice, and others at random.
    """
    groups = len(question.groups)
    states = len(question.conditions) * question.states_per_design
    if question.bounds.of_motion:
        states *= _OF_MOTOR
    most = max(_FEW, groups * _MOST // states)
    if most >= groups:
        return question
    ends = np.array([choice.from_binding.condition[0], choice.to_binding.condition[0]])
    binding = np.unique(question.groups.of[np.minimum(ends, len(question.conditions) - 1)])
    order = np.random.default_rng(1).permutation(groups)
    chosen = np.concatenate([binding, order[~np.isin(order, binding)]])[:most]
    return question.for_groups(np.sort(chosen))


def _current_value(question: Question, points: Points, key: str) -> float:
    """Return a parameter's value in a choice; NaN if it differs between conditions or sides."""
    space = question.choices.at(points.numbers, question.condition_numbers)
    if key in question.condition_numbers or key in space.keys_of_sides:
        return np.nan
    unscaled = replace(space.number(key), scales=())
    return float(np.asarray(unscaled.within(space.whole)).item())


def _fix(solver: Solver, points: Points, key: str, before: float) -> FixRecord:
    """Return the record of the least change of one parameter that gives a choice a window."""
    low, high = PARAMETERS[key]

    def solve_at(values: Array, *, with_worst: bool = False) -> Solutions:
        """Solve the choice with each value of the parameter."""
        changed = points.repeat(len(values)).with_numbers({key: values})
        return solve(solver, changed, with_worst=with_worst)

    def first_open(values: Array) -> tuple[int | None, int]:
        """Return the places of the first value with a window, and of the nearest to one."""
        solved = solve_at(values)
        is_open = solved.feasible
        nearest = int(np.argsort(_width(solver.question, solved), kind="stable")[-1])
        return int(np.argmax(is_open)) if is_open.any() else None, nearest

    ends = []
    if low < before:
        ends.append(low)
    if before < high:
        ends.append(high)
    nearest_values = [_nearest_open(first_open, before, end) for end in ends]
    values = [value for value in nearest_values if value is not None]
    if not values:
        return {
            "parameter": key,
            "before": before,
            "after": None,
            "plausible": (low, high),
            "pretension": None,
            "max_tension": None,
            "max_spring_extension": None,
            "peak_motor_torque": None,
            "min_elbow_stiffness": None,
            "max_contact_pressure": None,
            "printed": "",
            "printed_pretension": "",
        }
    after = min(values, key=lambda value: abs(np.log(value / before)))
    solved = solve_at(np.array([after]), with_worst=True)
    printed, pretension = _printed(solve_at, keys()[key].number.quantity, before, after)
    return {
        "parameter": key,
        "before": before,
        "after": after,
        "plausible": (low, high),
        "pretension": finite_or_none(solved.pretension[0]),
        "max_tension": finite_or_none(solved.worst.max_tension[0]),
        "max_spring_extension": finite_or_none(solved.worst.max_spring_extension[0]),
        "peak_motor_torque": finite_or_none(solved.worst.peak_motor_torque[0]),
        "min_elbow_stiffness": finite_or_none(solved.worst.min_elbow_stiffness[0]),
        "max_contact_pressure": finite_or_none(solved.worst.max_contact_pressure[0]),
        "printed": printed,
        "printed_pretension": pretension,
    }


def _printed(
    solve_at: Callable[[Array], Solutions], quantity: Quantity, before: float, after: float
) -> tuple[str, str]:
    """Return the shortest text of a value beyond `after` that gives a window when it is typed in.

    The second text is a pretension in that window.
    """
    toward = np.inf if after > before else -np.inf
    for digits in range(3, 16):
        text = say.quantity(quantity, after, digits, toward=toward)
        value = parse_measure(text.replace(",", ""), quantity.dimension).si
        solved = solve_at(np.array([value]))
        if solved.feasible[0]:
            pretension = float(solved.pretension[0])
            low = float(solved.pretension_from[0])
            high = float(solved.pretension_to[0])
            return text, say.number_within(pretension, low, high, digits=3)
    return repr(after), ""


def _nearest_open(first_open: FirstOpen, before: float, end: float) -> float | None:
    """Return the value nearest to `before`, toward `end`, that gives a window; None without one."""
    values = np.geomspace(before, end, _POINTS)
    place, nearest = first_open(values)
    # A narrow window may hide on either side of the value that is nearest to giving one.
    for _ in range(_ZOOMS):
        if place is not None:
            break
        below = values[max(nearest - 1, 0)]
        above = values[min(nearest + 1, len(values) - 1)]
        values = np.geomspace(below, above, _SECTIONS)
        place, nearest = first_open(values)
    if place is None:
        return None
    if place == 0:
        return float(values[0])
    return edge(first_open, float(values[place - 1]), float(values[place]), _SECTIONS, _ROUNDS)


def edge(
    first_open: FirstOpen,
    empty: float,
    open_: float,
    sections: int,
    rounds: int,
    spaced: Callable[..., Array] = np.linspace,
) -> float:
    """Narrow down the value at which a window opens, and return the nearest that has one.

    Args:
        first_open: Function from values to the place of the first that gives a window.
        empty: A value without a window.
        open_: A value with one.
        sections: Values in each round.
        rounds: Most rounds.
        spaced: Function that spaces values between two, such as `numpy.geomspace`.
    """
    for _ in range(rounds):
        values = spaced(empty, open_, sections)
        values[-1] = open_
        inner, _ = first_open(values[1:-1])
        place = sections - 1 if inner is None else inner + 1
        if (empty, open_) == (values[place - 1], values[place]):
            break
        empty = float(values[place - 1])
        open_ = float(values[place])
    return open_


def _width(question: Question, solutions: Solutions) -> Array:
    """Return the width of windows, N; if a share is enough, the share served in excess of it."""
    if question.serve < 1.0:
        return solutions.served - question.serve
    with np.errstate(invalid="ignore"):
        width = solutions.pretension_to - solutions.pretension_from
    return np.where(np.isnan(width), -np.inf, width)
