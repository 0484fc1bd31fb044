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
from tendon_cli.answers.question_facts import recorded_value
from tendon_cli.answers.text_remedies import quantity_of_demand
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.limits import LIMITS
from tendon_cli.quantities import Quantity
from tendon_cli.space.axis import evenly_spaced
from tendon_cli.units import parse_measure
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import Question
from tendon_cli.windows.solutions import Solutions, solve
from tendon_cli.windows.solver import Solver

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

    def relaxed(self, question: Question, value: float, points: Points) -> tuple[Question, Points]:
        """Return the question and its choices with another value of this demand.

        Values of conditions are scaled toward 0 together.

        Args:
            question: The question.
            value: The value, SI.
            points: The choices.
        """
        if self.key.startswith("limits."):
            return question.with_bound(self.key.removeprefix("limits."), value), points
        of_conditions = question.condition_numbers.get(self.key)
        if of_conditions is None:
            return question, points.with_numbers({self.key: np.full(len(points), value)})
        scaled = of_conditions * (value / np.abs(of_conditions).max())
        return question.with_numbers({self.key: scaled}), points


def relaxations(solver: Solver, limits: set[str]) -> list[RelaxationRecord]:
    """Return the least change of each demand that gives some choice a window, as recorded.

    Args:
        solver: Solver of the question.
        limits: Limits that leave choices without a window.

    Returns:
        Records, SI. `after` is null if even `farthest` gives no window; `served` is then the
        largest share, else that of the choice that is named, at `pretension`, N.
    """
    question = solver.question
    count = len(question.choices)
    states = len(question.conditions) * question.states_per_design
    most = max(1, _MOST // states)
    rows = evenly_spaced(count, most)
    return [_least_change(solver, demand) for demand in _demands(question, limits, rows)]


def _demands(question: Question, limits: set[str], rows: Rows) -> Iterator[Demand]:
    """Yield the demands of a study that could be relaxed."""
    for name in sorted(limits & set(question.bounds)):
        value = float(question.bounds[name])
        is_stiffness = name == "min_elbow_stiffness"
        if is_stiffness:
            farthest = value - _SOFTER
        elif LIMITS[name].from_below:
            farthest = 0.0
        else:
            farthest = _FARTHEST * value
        if (value > 0.0 or is_stiffness) and np.isfinite(value):
            yield Demand(f"limits.{name}", value, farthest, rows)

    single = question.choices.single
    of_choices = []
    if "max_contact_pressure" in limits:
        same_width = np.full(len(rows), single.get(_WIDTH, np.nan))
        widths = np.asarray(question.choices.numbers(rows).get(_WIDTH, same_width))
        is_widest = widths == widths.max()
        of_choices.append(Demand(_WIDTH, float(widths.max()), _WIDEST, rows[is_widest]))
    of_choices.append(Demand(_ANCHOR, float(single.get(_ANCHOR, np.inf)), _FIRMEST, rows))
    for demand in of_choices:
        is_plausible = 0.0 < demand.before < demand.farthest
        if is_plausible and demand.key not in question.condition_numbers:
            yield demand

    for key in ("load.mass", "arm.upper_arm_angle"):
        values = question.condition_numbers.get(key)
        if values is not None and np.ptp(values) > 0.0:
            yield Demand(key, float(np.abs(values).max()), 0.0, rows)


def _least_change(solver: Solver, demand: Demand) -> RelaxationRecord:
    """Return the record of the least change of one demand."""
    question = solver.question

    def solve_with(value: float, rows: Rows) -> Solutions:
        """Solve choices with another value of the demand."""
        relaxed, points = demand.relaxed(question, value, question.points(rows))
        return solve(solver.for_question(relaxed), points, with_worst=False)

    solved = solve_with(demand.farthest, demand.rows)
    if not solved.feasible.any():
        return {
            "key": demand.key,
            "before": demand.before,
            "farthest": demand.farthest,
            "after": None,
            "printed": "",
            "choice": None,
            "values": {},
            "pretension": None,
            "served": float(solved.served.max()),
        }
    rows = solved.row[solved.feasible]

    def first_open(values: Array) -> tuple[int | None, int]:
        """Try a value, and go on with the choices that it gives a window."""
        nonlocal rows
        is_feasible = solve_with(values.item(), rows).feasible
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
    best = solved.select([int(np.lexsort((-solved.tolerance, -solved.served_at))[0])])
    values: Values = {}
    for axis in question.choices.axes:
        place_or_value = best.points.columns[axis.column][0]
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
        "pretension": float(best.pretension[0]),
        "served": float(best.served_at[0]),
    }
