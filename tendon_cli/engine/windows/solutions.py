"""Solved choices: their windows and limits, the share served, and worst values at a pretension."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from tendon_cli.engine.windows.advice import NO_ROOM, advice_of
from tendon_cli.engine.windows.by_choice import ByChoice, Selection
from tendon_cli.engine.windows.coverage import ROUNDING, serves
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import Goal, Question
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.study_arm import given_pretensions, tension_per_length
from tendon_cli.engine.windows.worst import WORST, Worst
from tendon_cli.model import window
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.limits import Codes
from tendon_cli.model.window import Ends, Window
from tendon_cli.studies.accuracy import Accuracy

End = Literal["from", "to"]
"""Lower or upper end of a window, as in the names of columns."""
ENDS: tuple[End, ...] = ("from", "to")
"""Both ends."""

NEEDED = 3.0
"""Tolerance that is enough, as a multiple of the accuracy with which a suit can be set."""
WINDOWS_AT_ONCE = 2**19
"""Windows, choices times conditions, that are solved together."""


@dataclass(frozen=True, eq=False)
class Binding(ByChoice):
    """Limits that set one end of windows, (choices,)."""

    by: Codes
    """Limit that binds: index into `limits.LIMIT_NAMES`, or NOTHING."""
    condition: Rows
    """Row of the condition under which it binds."""
    state: Rows
    """State that binds: place among directions and angles, -1 if the limit belongs to none."""
    angle: Array
    """Elbow angle that binds, rad, if it lies between the samples, else NaN."""


@dataclass(frozen=True, eq=False)
class Solutions(ByChoice):
    """Solved choices: a value of each for every choice, NaN if there is none."""

    points: Points
    """The choices."""
    pretension_from: Array
    """Lower end of the window, N. The window is empty if from > to, NaN if no pretension could
    do."""
    pretension_to: Array
    """Upper end, N; infinite if nothing bounds it."""
    from_binding: Binding
    """Limit that sets the lower end."""
    to_binding: Binding
    """Limit that sets the upper end."""
    windows: npt.NDArray[np.int64]
    """Number of intervals of pretension that serve enough; the widest is the window."""
    tolerance: Array
    """Share by which the pretension may be off: 1 if nothing bounds the window above."""
    tolerance_length: Array
    """Half the window as a length taken from both tendons, m; infinite if nothing bounds it."""
    settable: Array
    """Share of the tolerance needed that the window has, 1 at most: of `NEEDED` accuracies."""
    reserve: Array
    """Tension of the kind that is read that the accuracy of setting is worth, N."""
    served: Array
    """Largest share that one pretension serves."""
    served_at: Array
    """Share that the pretension of the choice serves."""
    pretension: Array
    """Pretension of the choice, N."""
    feasible: Flags
    """True if some pretension serves enough; if the pretension is given, that this one does."""
    worst: Worst
    """Worst values at the pretension; NaN where they are not worked out."""
    between_samples: npt.NDArray[np.int64]
    """Place in `limit_phrases.STATUSES`: result of the proof that a window holds at every angle."""
    advice: npt.NDArray[np.int64]
    """Advice that the choice fails at its pretension, as the sum of codes; 0 if it keeps all.

    The lowest bit is set if the choice cannot be built: the flexor's spring has no room.
    """

    def __len__(self) -> int:
        return len(self.points)

    @property
    def row(self) -> Rows:
        """Rows in `choices.parquet`."""
        return self.points.row

    @property
    def can_be_built(self) -> Flags:
        """True unless worst values show that the flexor's spring has no room, or if not judged."""
        return np.asarray(np.bitwise_and(self.advice, NO_ROOM) == 0)

    @property
    def can_be_set(self) -> Flags:
        """True where the window is so wide that an error of setting stays within it."""
        return np.asarray(self.settable * NEEDED >= 1.0 - ROUNDING)

    @property
    def has_window(self) -> Flags:
        """True where some pretension serves enough."""
        return np.asarray(self.pretension_from <= self.pretension_to)

    def pretension_at(self, end: End) -> Array:
        """Return one end of the windows, N."""
        return self.pretension_from if end == "from" else self.pretension_to

    def binding(self, end: End) -> Binding:
        """Return the limits that set one end of the windows."""
        return self.from_binding if end == "from" else self.to_binding

    def scores(self, goals: tuple[Goal, ...]) -> Array:
        """Return the scores by each goal, (choices, goals); -infinity without a window."""
        scores = np.column_stack([goal.score(self._goal_values(goal)) for goal in goals])
        return np.where(self.feasible[:, np.newaxis], scores, -np.inf)

    def _goal_values(self, goal: Goal) -> Array:
        """Return the values of a goal: of an axis of the choices, or the field of its name."""
        if goal.column in self.points.columns:
            return self.points.columns[goal.column]
        if goal.column in self.worst.motion:
            return self.worst.motion[goal.column]
        holder = self.worst if goal.column in WORST else self
        values: Array = getattr(holder, goal.column)
        return values

    def with_worst(self, question: Question, rows: Selection, values: Worst) -> Solutions:
        """Return the same choices with worst values for some of them, and the advice they fail.

        Args:
            question: The question.
            rows: Places of these choices.
            values: Worst values, (rows,) each.
        """
        advice = self.advice.copy()
        advice[rows] = advice_of(question, self.points.select(rows), values)
        worst = self.worst.with_values(rows, values)
        return replace(self, worst=worst, advice=advice)


def solve(solver: Solver, points: Points, *, of_feasible: bool = False) -> Solutions:
    """Solve choices.

    Args:
        solver: Solver of the question.
        points: The choices.
        of_feasible: True to work out the worst values of feasible choices alone.

    Raises:
        Stopped: The run was cancelled.
    """
    parts = []
    question = solver.question
    at_once = max(1, WINDOWS_AT_ONCE // len(question.conditions))
    for rows in solver.cut(len(points), at_once):
        selected = points.select(rows)
        solved, served = solve_windows(solver, selected)
        places = np.flatnonzero(solved.feasible) if of_feasible else np.arange(len(selected))
        if len(places):
            pretension = solved.pretension[places]
            worst = solver.worst(selected.select(places), pretension, served[places])
            solved = solved.with_worst(question, places, worst)
        parts.append(solved)
    return parts[0] if len(parts) == 1 else Solutions.concatenate(parts)


def solve_windows(
    solver: Solver, points: Points, ends: Ends | None = None
) -> tuple[Solutions, Flags]:
    """Solve the windows and pretensions of choices, without the worst values at these.

    Args:
        solver: Solver of the question.
        points: The choices.
        ends: Ends of their windows, (choices, conditions), if they are known.

    Returns:
        The choices; and True where one serves a condition at its pretension, (choices,
        conditions).
    """
    question = solver.question
    count = len(points)
    placement = question.placement
    given = given_pretensions(question, points)
    if ends is None:
        ends = solver.ends(points, given)
    groups = question.groups
    group_low, group_high = groups.windows(ends.low, ends.high)
    common = _common_windows(question, ends, group_low, group_high)
    low = common.low
    high = common.high
    per_length = tension_per_length(question, points)
    reserve = _reserve(question.study.setting.accuracy, per_length)
    if placement.given is None:
        at_best = placement.within(common.best_low, common.best_high, reserve)
        pretension = np.where(low <= high, placement.within(low, high, reserve), at_best)
    else:
        pretension = given
    is_served = serves(group_low, group_high, pretension[:, np.newaxis])  # (choices, groups)
    served_at = groups.share(is_served)
    feasible = low <= high
    if placement.given is not None:
        feasible = served_at >= question.sample.enough - ROUNDING
    conditions = np.concatenate([common.low_condition, common.high_condition])
    named = _name_limits(question, points, ends, conditions)
    solved = Solutions(
        points=points,
        pretension_from=low,
        pretension_to=high,
        from_binding=Binding(
            by=named.low_by[:count],
            condition=common.low_condition,
            state=_pick(ends.low_state, common.low_condition),
            angle=_pick(ends.low_angle, common.low_condition),
        ),
        to_binding=Binding(
            by=named.high_by[count:],
            condition=common.high_condition,
            state=_pick(ends.high_state, common.high_condition),
            angle=_pick(ends.high_angle, common.high_condition),
        ),
        windows=common.windows,
        tolerance=_tolerance(low, high),
        tolerance_length=_half_window(low, high) / per_length,
        settable=_settable(_half_window(low, high), reserve),
        reserve=reserve,
        served=common.served,
        served_at=served_at,
        pretension=pretension,
        feasible=feasible,
        worst=Worst.unknown(count, solver.columns_of_motion),
        between_samples=np.zeros(count, dtype=np.int64),
        advice=np.zeros(count, dtype=np.int64),
    )
    return solved, is_served[:, groups.of]


class _CommonWindows(NamedTuple):
    """Widest interval of pretension that serves enough, for each choice, (choices,)."""

    low: Array
    """Lower end, N; over all conditions, and above the upper end, if no pretension does."""
    high: Array
    """Upper end, N."""
    low_condition: Rows
    """Condition that binds below."""
    high_condition: Rows
    """Condition that binds above."""
    windows: npt.NDArray[np.int64]
    """Number of such intervals."""
    served: Array
    """Largest share that one pretension serves."""
    best_low: Array
    """Lower end of the interval that serves this share, N."""
    best_high: Array
    """Upper end, N."""


def _common_windows(
    question: Question, ends: Ends, group_low: Array, group_high: Array
) -> _CommonWindows:
    """Find the widest interval of pretension that serves enough, for each choice.

    Args:
        question: The question.
        ends: Ends of windows, (choices, conditions), N.
        group_low: Lower ends of groups, (choices, groups), N.
        group_high: Upper ends.
    """
    # A condition that no pretension suits leaves no window at all, and is the reason: argmax takes
    # the first NaN.
    # Conditions that bind equally are told apart by their values, not by their order.
    order = question.conditions.rows_by_value
    low_condition = order[np.argmax(ends.low[:, order], axis=1)]
    high_condition = order[np.argmin(ends.high[:, order], axis=1)]
    low = _pick(ends.low, low_condition)
    high = _pick(ends.high, high_condition)
    covered = question.groups.coverage(group_low, group_high, serve=question.sample.enough)
    serves_all = low <= high
    windows = serves_all.astype(np.int64)
    if question.sample.enough < 1.0:
        windows = covered.windows
        rows = np.flatnonzero(~np.isnan(covered.low))
        has_window = (group_low <= group_high)[:, question.groups.of]
        for end, of_conditions, covered_end, condition in (
            (low, ends.low, covered.low, low_condition),
            (high, ends.high, covered.high, high_condition),
        ):
            end[rows] = covered_end[rows]
            is_at_end = of_conditions[rows] == covered_end[rows, np.newaxis]
            binds = is_at_end & has_window[rows]
            condition[rows] = order[np.argmax(binds[:, order], axis=1)]
    return _CommonWindows(
        low=low,
        high=high,
        low_condition=low_condition,
        high_condition=high_condition,
        windows=windows,
        served=np.where(serves_all, 1.0, covered.served),
        best_low=covered.best_low,
        best_high=covered.best_high,
    )


def _name_limits(question: Question, points: Points, ends: Ends, condition: Rows) -> Window:
    """Return windows with the limits that bind, each of a choice under one condition, (pairs,).

    Conditions are listed for all choices in turn, then for all choices again.
    """
    rows = np.arange(len(condition)) % len(points)
    picked = {name: values[rows, condition] for name, values in vars(ends).items()}
    if isinstance(ends, Window):
        return Window(**picked)
    design = question.paired_designs(points, rows, condition)
    return window.with_binding_limits(
        Ends(**picked), design, question.angles, question.flexion, question.bounds
    )


def _pick(values: npt.NDArray[Any], condition: Rows) -> npt.NDArray[Any]:
    """Pick the value of each choice, (choices, conditions), under one condition, (choices,)."""
    picked: npt.NDArray[Any] = np.take_along_axis(values, condition[:, np.newaxis], axis=1)[:, 0]
    return picked


def _tolerance(low: Array, high: Array) -> Array:
    """Return (to - from)/(to + from), the share by which the pretension may be off.

    It is 1 if nothing bounds the window above, and NaN without a window.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        share = (high - low) / (high + low)
    share = np.where(high == 0.0, 0.0, share)  # a window from 0 to 0 tolerates nothing
    share = np.where(np.isinf(high), 1.0, share)
    return np.where(low <= high, share, np.nan)


def _reserve(accuracy: Accuracy, per_length: Array) -> Array:
    """Return the tension that the accuracy of setting is worth, (choices,), N.

    Args:
        accuracy: Accuracy of setting.
        per_length: Growth of what is read per length taken from both tendons, (choices,), N/m.
    """
    if accuracy.length is None:
        return np.full(len(per_length), accuracy.tension)
    return np.asarray(accuracy.length * per_length)


def _half_window(low: Array, high: Array) -> Array:
    """Return half the width of windows, N; infinite without an upper end, NaN without a window."""
    with np.errstate(invalid="ignore"):
        half = 0.5 * (high - low)
    return np.where(low <= high, half, np.nan)


def _settable(half_window: Array, reserve: Array) -> Array:
    """Return the share of the tolerance needed that windows have, 1 at most; NaN without a window.

    Args:
        half_window: Half the width of windows, (choices,), N.
        reserve: Tension that the accuracy of setting is worth, N.
    """
    needed = NEEDED * reserve
    enough = half_window >= needed
    with np.errstate(invalid="ignore", divide="ignore"):
        share = half_window / needed
    return np.where(enough, 1.0, share)
