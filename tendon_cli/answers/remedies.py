"""Remedies if no choice has a window: fixes of a parameter, and relaxations of a demand.

A fix changes a parameter of the choice that is nearest to a window. A relaxation changes a limit or
a condition for all choices: the further it goes, the more of them have a window, so that bisection
finds the least one; for postures and anchors that is not proved.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tendon_cli.answer_record import FixRecord, PartRecord, RelaxationRecord
from tendon_cli.answers.fresh_search import FreshSearch
from tendon_cli.answers.least_change import (
    BISECTION,
    SCAN,
    SPARING_BISECTION,
    SPARING_SCAN,
    Change,
    ChangeSearch,
    PrintedChange,
    printed_pretension,
)
from tendon_cli.answers.question_facts import choice_values
from tendon_cli.answers.verified_record import verified_record
from tendon_cli.model.kinematics import Spline
from tendon_cli.model.limits import LIMITS
from tendon_cli.space.axis import LIMIT, NamedAxis, evenly_spaced
from tendon_cli.space.space import ANCHORS
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.windows.order import Order, last_stage
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import Question, cost_per_design, is_sought
from tendon_cli.windows.solutions import Solutions
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

_MOST_OF_ONE = 60_000
"""Most states of one choice under all conditions; beyond it, only some groups are tried."""
_MOST_JUDGED = 2_500_000
"""States of one choice under all conditions of a fresh sample, above which only some of its members
judge a change, if each window is sought pretension by pretension."""
_FEWEST_JUDGES = 200
"""Fewest members of a fresh sample who judge a change."""
_FEW = 8
"""Fewest groups that are tried."""
_MOST_OF_ALL = 2**28
"""Most states of all choices under all conditions; beyond it, evenly spaced choices are tried."""
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


# --- Fixes ----------------------------------------------------------------------------------------


def fixes(solver: Solver, choice: Solutions, search: FreshSearch | None = None) -> list[FixRecord]:
    """Return the least change of each parameter alone that gives one choice a window, as recorded.

    The parameter that changes by the smallest factor comes first. Values are SI. `after` is null if
    no value within the plausible range gives a window. Otherwise `printed` is a value that a study
    can have, rounded so that it gives one, too, and `printed_pretension` is a pretension in that
    window, N. If a fresh sample judges, the window is that of the sample, and `after` is the
    printed value. A value with which the choice cannot be built is named only if no other helps.

    Args:
        solver: Solver of the question.
        choice: The choice.
        search: Search for what serves enough of a fresh sample; None without one.
    """
    all_fixes = []
    for key in PARAMETERS:
        before = _current_value(solver.question, choice.points, key)
        if 0.0 < before < np.inf:
            all_fixes.append(_fix(solver, choice.points, key, before, search))
    return sorted(
        all_fixes,
        key=lambda fix: abs(np.log(fix["after"] / fix["before"])) if fix["after"] else np.inf,
    )


def sampled(question: Question, choice: Solutions) -> Question:
    """Return the question for some of its groups if all are too many to try changes for.

    They are the groups that bind the choice, and others at random.
    """
    groups = len(question.groups)
    most = _groups_to_try(question)
    if most >= groups:
        return question
    ends = np.array([choice.from_binding.condition[0], choice.to_binding.condition[0]])
    binding = np.unique(question.groups.of[np.minimum(ends, len(question.conditions) - 1)])
    order = np.random.default_rng(1).permutation(groups)
    chosen = np.concatenate([binding, order[~np.isin(order, binding)]])[:most]
    return question.within_groups(question.groups.conditions_of(chosen))


def _groups_to_try(question: Question) -> int:
    """Return the number of groups for which changes are tried, at most."""
    return _groups_within(question, _MOST_OF_ONE, _FEW)


def members_to_judge(question: Question) -> int:
    """Return the number of members of a fresh sample who judge changes, at most.

    Args:
        question: Question under the conditions of the sample.
    """
    if not is_sought(question):
        return len(question.groups)
    return _groups_within(question, _MOST_JUDGED, _FEWEST_JUDGES)


def _groups_within(question: Question, states: int, fewest: int) -> int:
    """Return how many groups take as long as so many states, but not fewer than `fewest`."""
    cost = len(question.conditions) * cost_per_design(question)
    return max(fewest, len(question.groups) * states // cost)


def _current_value(question: Question, points: Points, key: str) -> float:
    """Return a parameter's value in a choice.

    It is NaN if the value differs between conditions or sides, or follows the joint.
    """
    space = question.choices.at(points.numbers, question.condition_numbers)
    if key in question.condition_numbers or key in space.keys_of_sides:
        return np.nan
    unscaled = replace(space.number(key), scales=())
    value = unscaled.within(space.whole)
    return np.nan if isinstance(value, Spline) else float(np.asarray(value).item())


def _fix(
    solver: Solver, points: Points, key: str, before: float, search: FreshSearch | None
) -> FixRecord:
    """Return the record of the least change of one parameter that gives a choice a window."""
    low, high = PARAMETERS[key]
    ends = []
    is_used = _is_used(solver.question, key)
    if is_used and low < before:
        ends.append(low)
    if is_used and before < high:
        ends.append(high)
    effort = SPARING_SCAN if is_sought(solver.question) else SCAN
    found: list[tuple[Change, PrintedChange]] = []
    for end in ends:
        change = Change(key, before, end, points, effort, is_geometric=True)
        least = _least(solver, change, search)
        if least is not None:
            found.append((change, least))
    if not found:
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
            "can_be_built": None,
            "served_verified": None,
        }
    change, least = min(
        found, key=lambda of: (not of[1].can_be_built, abs(np.log(of[1].least / before)))
    )
    judged = least.judged
    after = least.value
    solved = least.solved
    pretension = least.judged_at
    if judged is None:
        after = least.least
        pretension = printed_pretension(solver.question, least.solved, digits=3)
        solved = change.solve(solver, np.array([after]), points, with_worst=True)
    record: FixRecord = {
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
        "printed": least.text,
        "printed_pretension": pretension,
        "can_be_built": least.can_be_built,
        "served_verified": None if judged is None else verified_record(judged),
    }
    nearest = _nearest_part(solver.question, key, after)
    if nearest is not None:
        record["nearest"] = nearest
    return record


def _is_used(question: Question, key: str) -> bool:
    """Return False for an anchor if travels are measured: no state depends on it."""
    section, _, name = key.partition(".")
    is_anchor = section == "arm" and name in ANCHORS
    return not (is_anchor and question.study.joint.excursion is not None)


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
        return {"table": axis.key, "name": axis.names[row], "value": float(values[row])}
    return None


def _least(solver: Solver, change: Change, search: FreshSearch | None) -> PrintedChange | None:
    """Return the least change that gives a choice a window, if possible one that can be built.

    Where another pretension is enough without a change, only one with which it can be built counts.

    Args:
        solver: Solver of the question.
        change: The change.
        search: Search for what serves enough of a fresh sample; None without one.

    Returns:
        The change with the first choice; None if no value tried gives a window.
    """
    least = None
    if search is None or not search.has_window:
        least = _least_of_any(solver, change, search, must_be_buildable=False)
        if least is None or least.can_be_built:
            return least
    buildable = _least_of_any(solver, change, search, must_be_buildable=True)
    if buildable is None or not buildable.can_be_built:
        return least
    return buildable


def _least_of_any(
    solver: Solver, change: Change, search: FreshSearch | None, *, must_be_buildable: bool
) -> PrintedChange | None:
    """Return the least change that gives a choice a window, with the choice that is then first.

    Args:
        solver: Solver of the question.
        change: The change.
        search: Search for what serves enough of a fresh sample; None without one.
        must_be_buildable: True if a choice that cannot be built does not count.
    """
    start = None
    if search is None or search.refuted is None:
        of_sample = ChangeSearch(solver, change, must_be_buildable=must_be_buildable)
        opening = of_sample.least()
        if opening is None:
            return None
        start = of_sample.printed(opening)
        first = _best_opened(solver.question, start.solved)
        start = start._replace(solved=first)
        change = replace(change, points=first.points)
    if search is None:
        return start
    return search.least(change, start, must_be_buildable=must_be_buildable)


def choices_to_relax_for(question: Question) -> Points:
    """Return all choices of the grid, or evenly spaced ones if they are too many to try."""
    cost = len(question.conditions) * cost_per_design(question)
    return question.points(evenly_spaced(len(question.choices), max(1, _MOST_OF_ALL // cost)))


def relaxations(
    solver: Solver, limits: set[str], points: Points, search: FreshSearch | None = None
) -> list[RelaxationRecord]:
    """Return the least change of each demand that gives some choice a window, as recorded.

    Args:
        solver: Solver of the question.
        limits: Limits that leave choices without a window.
        points: Choices that are tried.
        search: Search for what serves enough of a fresh sample; None without one.

    Returns:
        Records, SI. `after` is null if even `farthest` gives no window; `served` is then the
        largest share, else that of the choice that is named, at `pretension`, N. A choice that
        cannot be built is named only if no other has a window.
    """
    demands = _demands(solver.question, limits, points)
    return [_relaxation(solver, change, search) for change in demands]


def _demands(question: Question, limits: set[str], points: Points) -> Iterator[Change]:
    """Yield the changes of the demands of a study that could be relaxed."""
    effort = SPARING_BISECTION if is_sought(question) else BISECTION
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
            yield Change(f"{LIMIT}{name}", value, farthest, points, effort)

    single = question.choices.single
    of_choices = []
    if "max_contact_pressure" in limits:
        same_width = np.full(len(points), single.get(_WIDTH, np.nan))
        widths = np.asarray(points.numbers.get(_WIDTH, same_width))
        widest = points.select(widths == widths.max())
        of_choices.append(Change(_WIDTH, float(widths.max()), _WIDEST, widest, effort))
    stiffness = float(single.get(_ANCHOR, np.inf))
    of_choices.append(Change(_ANCHOR, stiffness, _FIRMEST, points, effort, is_geometric=True))
    for change in of_choices:
        is_plausible = 0.0 < change.before < change.farthest
        if is_plausible and change.key not in question.condition_numbers:
            yield change

    for key in ("load.mass", "arm.upper_arm_angle"):
        values = question.condition_numbers.get(key)
        if values is not None and np.ptp(values) > 0.0:
            yield Change(key, float(np.abs(values).max()), 0.0, points, effort)


def _loosest(question: Question, name: str, points: Points) -> float:
    """Return the loosest value of a limit among some choices, SI; infinite without a limit."""
    space = question.choices.at(points.numbers, question.condition_numbers)
    limit = space.limits.get(name)
    if limit is None:
        return float(np.asarray(question.bounds[name]).item())
    values = LIMITS[name].bound_of(limit.within(space.whole))
    return float(values.min() if LIMITS[name].from_below else values.max())


def _best_opened(question: Question, solved: Solutions) -> Solutions:
    """Return the choice that is first by the rules before all goals, and can be set best.

    If none has a window, return the first.
    """
    if not solved.feasible.any():
        return solved.select([0])
    order = Order.of(question)
    with_window = solved.select(solved.feasible)
    scores = np.column_stack([order.first_scores(with_window), with_window.settable])
    tied = last_stage(scores)
    rank = order.rank(with_window.points, tied)
    return with_window.select(tied[[np.argmin(rank)]])


def _relaxation(solver: Solver, change: Change, search: FreshSearch | None) -> RelaxationRecord:
    """Return the record of the least change of one demand."""
    question = solver.question
    least = _least(solver, change, search)
    if least is None:
        at_farthest = change.solve(solver, np.array([change.farthest]), change.points)
        return {
            "key": change.key,
            "before": change.before,
            "farthest": change.farthest,
            "after": None,
            "printed": "",
            "choice": None,
            "values": {},
            "pretension": None,
            "printed_pretension": "",
            "served": _share(question, at_farthest.served.max()),
            "can_be_built": None,
            "served_verified": None,
        }
    first = least.solved
    judged = least.judged
    return {
        "key": change.key,
        "before": change.before,
        "farthest": change.farthest,
        "after": least.value,
        "printed": least.text,
        "choice": int(first.row[0]),
        "values": choice_values(question, first.points, 0),
        "pretension": float(first.pretension[0]),
        "printed_pretension": least.judged_at or printed_pretension(question, first, digits=4),
        "served": _share(question, first.served_at[0]),
        "can_be_built": least.can_be_built,
        "served_verified": None if judged is None else verified_record(judged),
    }


def _share(question: Question, served: float) -> float | None:
    """Return a share of persons or draws as recorded; None without both."""
    return None if question.conditions.groups is None else float(served)
