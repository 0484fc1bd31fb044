"""Help if no choice has a window: the least change of one number that gives one.

A fix changes a number of the choice that is nearest to a window, a relaxation a limit or a
condition for all choices. Both are sought alike (`least`): among values from the study's own to the
farthest plausible one, each with the windows of the question's own sample; then the value is
printed with as few digits as keep the window, and judged once by the fresh sample. A change with
which the suit cannot be built does not help.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from tendon_cli import say
from tendon_cli.answers.notes import note_on_judges, note_on_remedies
from tendon_cli.answers.question_facts import choice_values
from tendon_cli.engine.windows.order import Order
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import (
    Question,
    cost_per_design,
    is_sought,
    least_share_for,
    with_enough,
)
from tendon_cli.engine.windows.solutions import Solutions, solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.verification import Verified, Verifier, fresh_record
from tendon_cli.engine.windows.worst import WORST
from tendon_cli.model.kinematics import Array, Flags, Rows, Spline
from tendon_cli.model.limits import LIMITS
from tendon_cli.studies.space.axis import LIMIT, NamedAxis, evenly_spaced, limit_of
from tendon_cli.studies.space.space import ANCHORS
from tendon_cli.studies.study import keys
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.units import parse_measure
from tendon_cli.verbs.answer_record import FixRecord, PartRecord, RelaxationRecord

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
"""Numbers that a designer can change, and the plausible range of each, SI."""
_VALUES = 33
"""Values of a number that are tried on the way to the farthest."""
_FEW_VALUES = 9
"""The same where each window is sought pretension by pretension."""
_SECTIONS = 9
"""Values tried between two neighbours to narrow down where a window opens."""
_NARROW = 1e-3
"""Relative width at which that is narrow enough."""
_DIGITS = range(3, 16)
"""Numbers of significant digits with which a value is printed."""
_MOST_OF_ONE = 250_000
"""Most states of one choice under all conditions; beyond it, only some groups are tried."""
_FEWEST_GROUPS = 64
"""Fewest groups that are tried."""
_MOST_OF_ALL = 2**26
"""Most states of all choices under all conditions; beyond it, evenly spaced choices are tried."""
_MOST_JUDGED = 2_500_000
"""Most states by which a fresh sample judges a change; beyond it, some members judge."""
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


class Help(NamedTuple):
    """Changes that would give a window, and notes on how they were found."""

    fixes: Sequence[FixRecord] = ()
    relaxations: Sequence[RelaxationRecord] = ()
    notes: Sequence[str] = ()


@dataclass(frozen=True, eq=False)
class Change:
    """A change of one number of a study: of its choices or conditions, or a limit."""

    key: str
    """Dotted key of the number."""
    before: float
    """Value in the study, SI; of several values the largest magnitude, of limits the loosest."""
    farthest: float
    """Farthest plausible value, SI."""
    points: Points
    """Choices for which it counts."""

    def between(self, first: float, last: float, count: int) -> Array:
        """Return values from one to another, by equal factors if both are above zero."""
        if min(first, last) > 0.0 and np.isfinite(first):
            return np.geomspace(first, last, count)
        return np.linspace(first if np.isfinite(first) else 100.0 * last, last, count)

    def solve(self, solver: Solver, values: Array, points: Points) -> Solutions:
        """Solve choices with some values of the number, all with one value after the other."""
        question = solver.question
        if self.key not in question.condition_numbers:
            rows = np.tile(np.arange(len(points)), len(values))
            of_rows = np.repeat(values, len(points))
            changed = points.select(rows).with_numbers({self.key: of_rows})
            return solve(solver, changed, of_feasible=True)
        parts = [
            solve(solver.for_question(self.changed(question, value)), points, of_feasible=True)
            for value in values.tolist()
        ]
        return parts[0] if len(parts) == 1 else Solutions.concatenate(parts)

    def changed(self, question: Question, value: float) -> Question:
        """Return the question with another value of a number that its conditions set.

        Their values are scaled together. A limit becomes the same under all of them.
        """
        of_conditions = question.condition_numbers.get(self.key)
        if of_conditions is None:
            return question
        new = np.full(len(of_conditions), value)
        if limit_of(self.key) is None:
            new = of_conditions * (value / np.abs(of_conditions).max())
        return question.with_numbers({self.key: new})


class Least(NamedTuple):
    """The least change with which a choice has a window."""

    value: float
    """Value as it is printed, SI."""
    text: str
    """The value with its unit."""
    choice: Solutions
    """The choice that is then first."""
    pretension: str
    """Pretension in its window, as it is printed, N."""
    judged: Verified | None
    """Judgement of a fresh sample; None without one."""


# --- The search -----------------------------------------------------------------------------------


def least(change: Change, solver: Solver, verifier: Verifier | None) -> Least | None:
    """Return the change nearest to the study's own value with which a choice has a window.

    A window that opens and closes again between two values that are tried may be missed.

    Args:
        change: The change.
        solver: Solver of the question.
        verifier: Judge of the fresh sample; None without one.

    Returns:
        The change; None if no value up to the farthest helps.
    """
    count = _FEW_VALUES if is_sought(solver.question) else _VALUES
    values = change.between(change.before, change.farthest, count)
    points = change.points
    opening = _first_opening(change, solver, values, points)
    if opening is None:
        return None
    place, points = opening
    if place == 0:
        return None  # the study's own value gives a window already
    while place > 0 and abs(values[place] - values[place - 1]) > _NARROW * abs(values[place]):
        values = change.between(values[place - 1], values[place], _SECTIONS)
        narrower = _first_opening(change, solver, values[1:], points)
        if narrower is None:
            place = len(values) - 1
            break
        place = narrower[0] + 1
        points = narrower[1]
    return _printed(change, solver, verifier, float(values[place]), points)


def _first_opening(
    change: Change, solver: Solver, values: Array, points: Points
) -> tuple[int, Points] | None:
    """Return the place of the first value that gives windows, and the choices that have one."""
    at_once = max(1, _MOST_OF_ALL // _states(solver.question, len(points)))
    for start in range(0, len(values), at_once):
        part = values[start : start + at_once]
        opens = _opens(change.solve(solver, part, points)).reshape(len(part), len(points))
        if opens.any():
            place = int(np.argmax(opens.any(axis=1)))
            return start + place, points.select(np.flatnonzero(opens[place]))
    return None


def _opens(solved: Solutions) -> Flags:
    return np.asarray(solved.feasible & solved.can_be_built)


def _printed(
    change: Change, solver: Solver, verifier: Verifier | None, value: float, points: Points
) -> Least:
    """Return a change as a study can have it: rounded away from the study's value, and judged."""
    quantity = keys()[change.key].quantity
    toward = np.inf if change.farthest > change.before else -np.inf
    for digits in _DIGITS:
        text = say.quantity(quantity, value, digits, toward=toward)
        rounded = parse_measure(text.replace(",", ""), quantity.dimension).si
        solved = change.solve(solver, np.array([rounded]), points)
        opens = _opens(solved)
        if opens.any():
            solved = solved.select(opens)
            break
    choice = solved.select([Order.of(solver.question).best(solved)])
    low = float(choice.pretension_from[0])
    high = float(choice.pretension_to[0])
    exact = float(choice.pretension[0])
    if solver.question.placement.given is not None:
        low = exact
        high = exact
    pretension = say.number_within(exact, low, high, 3)
    judged = None
    if verifier is not None:
        of_sample = verifier.for_question(change.changed(verifier.solver.question, rounded))
        as_printed = np.array([float(pretension.replace(",", ""))])
        (judged,) = of_sample.judge(choice.points, as_printed)
    return Least(rounded, text, choice, pretension, judged)


# --- What is tried --------------------------------------------------------------------------------


def what_would_help(
    solver: Solver, choice: Solutions, limits: set[str], verifier: Verifier | None
) -> Help:
    """Return fixes and relaxations where no choice has a window, and notes on how they were found.

    Args:
        solver: Solver of the question.
        choice: The choice that is nearest to a window.
        limits: Limits that leave choices without a window.
        verifier: Judge of the fresh sample; None without one.
    """
    question = solver.question
    notes = []
    few = _of_few_groups(question, choice)
    if len(few.groups) < len(question.groups):
        notes.append(note_on_remedies(len(few.groups), len(question.groups), question.groups.noun))
    judge = verifier
    if verifier is not None:
        of_one = max(1, _states(verifier.solver.question, 1) // len(verifier.sample))
        judge = verifier.thinned(max(_FEWEST_GROUPS, _MOST_JUDGED // of_one))
        if len(judge.sample) < len(verifier.sample):
            notes.append(note_on_judges(len(judge.sample), fresh_record(verifier.sample)))
    of_few = solver.for_question(few)
    every = evenly_spaced(len(question.choices), max(1, _MOST_OF_ALL // _states(few, 1)))
    changes = _demands(few, limits, question.points(every))
    relaxations = [_relaxation(of_few, change, least(change, of_few, judge)) for change in changes]
    return Help(_fixes(of_few, choice, judge), relaxations, notes)


def _states(question: Question, choices: int) -> int:
    """Return the number of states of some choices under all conditions, or what takes as long."""
    return choices * len(question.conditions) * cost_per_design(question)


def _of_few_groups(question: Question, choice: Solutions) -> Question:
    """Return the question for the groups that bind a choice, and others at random, if all are many.

    They count as serving enough where so many of them show it.
    """
    groups = len(question.groups)
    most = max(_FEWEST_GROUPS, groups * _MOST_OF_ONE // _states(question, 1))
    if most >= groups or question.conditions.groups is None:
        return question
    ends = np.array([choice.from_binding.condition[0], choice.to_binding.condition[0]])
    binding: Rows = np.unique(question.groups.of[ends])
    order = np.random.default_rng(1).permutation(groups)
    chosen = np.concatenate([binding, order[~np.isin(order, binding)]])[:most]
    few = question.within_groups(question.groups.conditions_of(chosen))
    if not question.sample.sets_by_sample:
        return few
    return with_enough(few, least_share_for(few.serve, few.groups.effective_count))


def _fixes(solver: Solver, choice: Solutions, verifier: Verifier | None) -> list[FixRecord]:
    """Return the least change of each number of a choice, that by the smallest factor first."""
    fixes = []
    for key, (low, high) in PARAMETERS.items():
        before = _current_value(solver.question, choice.points, key)
        if not 0.0 < before < np.inf:
            continue
        found = []
        for end in (low, high):
            is_beyond = end < before if end == low else end > before
            change = Change(key, before, end, choice.points)
            nearest = least(change, solver, verifier) if is_beyond else None
            if nearest is not None:
                found.append(nearest)
        best = min(found, key=lambda of: abs(np.log(of.value / before)), default=None)
        fixes.append(_fix(solver.question, key, before, best))
    return sorted(
        fixes, key=lambda fix: abs(np.log(fix.after / fix.before)) if fix.after else np.inf
    )


def _current_value(question: Question, points: Points, key: str) -> float:
    """Return a number of a choice, as the study has it.

    It is NaN if it differs between conditions or sides, follows the joint, or counts for nothing.
    """
    space = question.choices.at(points.numbers, question.arm)
    section, _, name = key.partition(".")
    is_replaced = section == "arm" and name in ANCHORS
    if is_replaced and question.study.joint.excursion is not None:
        return np.nan
    if key in question.condition_numbers or key in space.keys_of_sides:
        return np.nan
    value = replace(space.number(key), scales=()).within(space.whole)
    return np.nan if isinstance(value, Spline) else float(np.ravel(value)[0])


def _demands(question: Question, limits: set[str], points: Points) -> Iterator[Change]:
    """Yield the changes of the demands of a study that could be relaxed."""
    for name in sorted(limits & set(question.bounds)):
        value = _loosest(question, name, points)
        is_stiffness = name == "min_elbow_stiffness"
        if is_stiffness:
            farthest = value - _SOFTER
        elif LIMITS[name].from_below:
            farthest = 0.0
        else:
            farthest = _FARTHEST * value
        if (value > 0.0 or is_stiffness) and np.isfinite(value):
            yield Change(f"{LIMIT}{name}", value, farthest, points)

    single = question.choices.single
    of_choices = []
    if "max_contact_pressure" in limits:
        same_width = np.full(len(points), single.get(_WIDTH, np.nan))
        widths = np.asarray(points.numbers.get(_WIDTH, same_width))
        widest = points.select(widths == widths.max())
        of_choices.append(Change(_WIDTH, float(widths.max()), _WIDEST, widest))
    stiffness = float(single.get(_ANCHOR, np.inf))
    of_choices.append(Change(_ANCHOR, stiffness, _FIRMEST, points))
    for change in of_choices:
        is_plausible = 0.0 < change.before < change.farthest
        if is_plausible and change.key not in question.condition_numbers:
            yield change

    for key in ("load.mass", "arm.upper_arm_angle"):
        values = question.condition_numbers.get(key)
        if values is not None and np.ptp(values) > 0.0:
            yield Change(key, float(np.abs(values).max()), 0.0, points)


def _loosest(question: Question, name: str, points: Points) -> float:
    """Return the loosest value of a limit among some choices, SI; infinite without a limit."""
    space = question.choices.at(points.numbers, question.condition_numbers)
    limit = space.limits.get(name)
    if limit is None:
        return float(np.asarray(question.bounds[name]).item())
    values = LIMITS[name].bound_of(limit.within(space.whole))
    return float(values.min() if LIMITS[name].from_below else values.max())


# --- The record -----------------------------------------------------------------------------------


def _fix(question: Question, key: str, before: float, found: Least | None) -> FixRecord:
    """Return the record of the least change of one number of a choice."""
    unknown: dict[str, Any] = dict.fromkeys(WORST)
    record = FixRecord(
        parameter=key,
        before=before,
        after=None,
        plausible=PARAMETERS[key],
        pretension=None,
        printed="",
        printed_pretension="",
        served_verified=None,
        **unknown,
    )
    if found is None:
        return record
    choice = found.choice
    worst: dict[str, Any] = {name: finite_or_none(getattr(choice.worst, name)[0]) for name in WORST}
    return replace(
        record,
        **worst,
        after=found.value,
        pretension=finite_or_none(choice.pretension[0]),
        printed=found.text,
        printed_pretension=found.pretension,
        served_verified=None if found.judged is None else found.judged.record,
        nearest=_nearest_part(question, key, found.value),
    )


def _nearest_part(question: Question, key: str, value: float) -> PartRecord | None:
    """Return the row of a table of choices whose value of a number is nearest, by its factor.

    Return None if no table sets the number.
    """
    for axis in question.choices.axes:
        values = axis.numbers.get(key)
        if not isinstance(axis, NamedAxis) or values is None or not (values > 0.0).any():
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = np.abs(np.log(values / value))
        in_order = np.lexsort([axis.rank, distance])  # NaN comes last
        row = int(in_order[0])
        return PartRecord(table=axis.key, name=axis.names[row], value=float(values[row]))
    return None


def _relaxation(solver: Solver, change: Change, found: Least | None) -> RelaxationRecord:
    """Return the record of the least change of one demand."""
    question = solver.question
    counts = question.conditions.groups is not None
    record = RelaxationRecord(
        key=change.key,
        before=change.before,
        farthest=change.farthest,
        after=None,
        printed="",
        choice=None,
        values={},
        pretension=None,
        printed_pretension="",
        served=None,
        served_verified=None,
    )
    if found is None:
        at_farthest = change.solve(solver, np.array([change.farthest]), change.points)
        return replace(record, served=float(at_farthest.served.max()) if counts else None)
    first = found.choice
    return replace(
        record,
        after=found.value,
        printed=found.text,
        choice=int(first.row[0]),
        values=choice_values(question, first.points, 0),
        pretension=float(first.pretension[0]),
        printed_pretension=found.pretension,
        served=float(first.served_at[0]) if counts else None,
        served_verified=None if found.judged is None else found.judged.record,
    )
