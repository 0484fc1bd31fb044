"""Relaxations: the least change of one demand, all else equal, that gives some choice a window.

The more a demand is relaxed, the more choices have a window, so that bisection over these finds the
least change; for postures and anchors that is not proved.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tendon_cli import say
from tendon_cli.answer_record import RelaxationRecord, Values
from tendon_cli.answers.fixes import edge
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question_facts import recorded_value
from tendon_cli.answers.solve import Solutions, solve
from tendon_cli.answers.text_remedies import quantity_of_demand
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMITS
from tendon_cli.quantities import Quantity
from tendon_cli.space.axis import Numbers, Rows
from tendon_cli.units import parse_measure

_MOST = 2**28
"""Most states of all choices under all conditions; beyond it, evenly spaced choices are tried."""
_ROUNDS = 12
"""Most bisections of a demand."""
_SECTIONS = 3
"""Values in each round: both ends and their middle."""
_FARTHEST = 10.0
"""Factor up to which an upper limit is raised."""
_SOFTER = 40.0
"""Most by which the required stiffness is lowered, N m/rad."""
_WIDTH = "arm.contact_width"
_WIDEST = 0.2
"""Widest strap that is tried, m."""
_ANCHOR = "anchor.stiffness"
_FIRMEST = 1e5
"""Firmest tissue and cuff that is tried, N/m."""


class Demand(NamedTuple):
    """A demand of the study that could be relaxed."""

    key: str
    before: float
    """Value in the study, SI; of several values the largest magnitude."""
    farthest: float
    """Farthest value to which it is relaxed, SI."""
    rows: Rows
    """Choices for which it counts."""

    @property
    def quantity(self) -> Quantity:
        """Quantity of the value."""
        return quantity_of_demand(self.key)

    def relaxed(
        self, problem: Problem, value: float, numbers: Numbers, count: int
    ) -> tuple[Problem, Numbers]:
        """Return the question and its choices with another value of this demand.

        Values of conditions are scaled toward 0 together.

        Args:
            problem: The question.
            value: The value, SI.
            numbers: Numbers of the choices.
            count: Number of choices.

        Returns:
            The question and the numbers of the choices.
        """
        if self.key.startswith("limits."):
            return problem.bounded(self.key.removeprefix("limits."), value), numbers
        of_conditions = problem.condition_numbers.get(self.key)
        if of_conditions is None:
            return problem, {**numbers, self.key: np.full(count, value)}
        scaled = of_conditions * (value / np.abs(of_conditions).max())
        return problem.saying({self.key: scaled}), numbers


def relaxations(problem: Problem, limits: set[str]) -> list[RelaxationRecord]:
    """Return the least change of each demand that gives some choice a window, as recorded.

    Args:
        problem: The question.
        limits: Limits that leave choices without a window.

    Returns:
        Records, SI. `after` is null if even `farthest` gives no window; `served` is then the
        largest share, else that of the choice that is named, at `pretension`, N.
    """
    count = len(problem.choices)
    states = len(problem.conditions) * problem.states_per_design
    most = max(1, _MOST // states)
    rows = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))
    return [_least_change(problem, demand) for demand in _demands(problem, limits, rows)]


def _demands(problem: Problem, limits: set[str], rows: Rows) -> Iterator[Demand]:
    """Yield the demands of a study that could be relaxed."""
    for name in sorted(limits & set(problem.bounds)):
        value = float(problem.bounds[name])
        is_stiffness = name == "min_elbow_stiffness"
        if is_stiffness:
            farthest = value - _SOFTER
        elif LIMITS[name].from_below:
            farthest = 0.0
        else:
            farthest = _FARTHEST * value
        if (value > 0.0 or is_stiffness) and np.isfinite(value):
            yield Demand(f"limits.{name}", value, farthest, rows)

    single = problem.choices.single
    of_choices = []
    if "max_contact_pressure" in limits:
        same_width = np.full(len(rows), single.get(_WIDTH, np.nan))
        widths = np.asarray(problem.choices.numbers(rows).get(_WIDTH, same_width))
        is_widest = widths == widths.max()
        of_choices.append(Demand(_WIDTH, float(widths.max()), _WIDEST, rows[is_widest]))
    of_choices.append(Demand(_ANCHOR, float(single.get(_ANCHOR, np.inf)), _FIRMEST, rows))
    for demand in of_choices:
        is_plausible = 0.0 < demand.before < demand.farthest
        if is_plausible and demand.key not in problem.condition_numbers:
            yield demand

    for key in ("load.mass", "arm.upper_arm_angle"):
        values = problem.condition_numbers.get(key)
        if values is not None and np.ptp(values) > 0.0:
            yield Demand(key, float(np.abs(values).max()), 0.0, rows)


def _least_change(problem: Problem, demand: Demand) -> RelaxationRecord:
    """Return the record of the least change of one demand."""

    def solve_with(value: float, rows: Rows) -> Solutions:
        """Solve choices with another value of the demand."""
        relaxed, numbers = demand.relaxed(problem, value, problem.choices.numbers(rows), len(rows))
        solved = solve(relaxed, numbers, len(rows), with_worst=False)
        return Solutions(solved.results, rows, problem.choices.columns(rows))

    solved = solve_with(demand.farthest, demand.rows)
    if not solved["feasible"].any():
        return {
            "key": demand.key,
            "before": demand.before,
            "farthest": demand.farthest,
            "after": None,
            "printed": "",
            "choice": None,
            "values": {},
            "pretension": None,
            "served": float(solved["served"].max()),
        }
    rows = solved.row[solved["feasible"]]

    def first_open(values: Array) -> tuple[int | None, int]:
        """Try a value, and go on with the choices that it gives a window."""
        nonlocal rows
        is_feasible = solve_with(values.item(), rows)["feasible"]
        if not is_feasible.any():
            return None, 0
        rows = rows[is_feasible]
        return 0, 0

    spaced = np.geomspace if demand.key == _ANCHOR else np.linspace
    least = edge(first_open, demand.before, demand.farthest, _SECTIONS, _ROUNDS, spaced)
    toward = np.inf if demand.farthest > demand.before else -np.inf
    printed = say.quantity(demand.quantity, least, toward=toward)
    after = parse_measure(printed.replace(",", ""), demand.quantity.dimension).si
    solved = solve_with(after, rows)
    best = solved.select([int(np.lexsort((-solved["tolerance"], -solved["served_at"]))[0])])
    values: Values = {}
    for axis in problem.choices.axes:
        place_or_value = best[axis.column][0]
        value = axis.names[place_or_value] if axis.names else float(place_or_value)
        values[axis.column] = recorded_value(value)
    return {
        "key": demand.key,
        "before": demand.before,
        "farthest": demand.farthest,
        "after": after,
        "printed": printed,
        "choice": int(best.row[0]),
        "values": values,
        "pretension": best.scalar("pretension"),
        "served": best.scalar("served_at"),
    }
