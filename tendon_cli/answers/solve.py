"""Solved choices: their windows and limits, the share served, and worst values at a pretension."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.answers.coverage import ROUNDING, group_windows, normalise, serves, share_served
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question import ColumnArrays, Goal, select_numbers
from tendon_cli.model import extremes, window
from tendon_cli.model.actuator import State
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import contact_pressure
from tendon_cli.model.window import Ends, Window
from tendon_cli.space.axis import Numbers, Rows

WORST = (
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_contact_pressure",
)
"""Columns of a choice: the worst over all conditions that its pretension serves."""

_WINDOWS_AT_ONCE = 2**19
"""Windows, choices times conditions, that are solved together."""


@dataclass(frozen=True, eq=False)
class Solutions:
    """Solved choices.

    Results are columns of `choices.parquet`, (choices,), NaN if there is no value:

    - `pretension_from` and `pretension_to`: ends of the window, N. The upper end is infinite if
      nothing bounds it; the window is empty if from > to, and NaN if no pretension could do.
    - `from_by` and `to_by`: limits that bind, as indices into `limits.LIMIT_NAMES`, or NOTHING.
    - `from_state` and `to_state`: states that bind, as places among directions and angles, -1 if
      the limit belongs to none.
    - from_angle and to_angle: elbow angles that bind, rad, if they lie between the samples.
    - `has_worst`: true where the columns `WORST` are known; elsewhere they are NaN, or a bound.
    """

    results: ColumnArrays
    row: Rows
    """Rows in `choices.parquet`; -1 for one between the points of the grid that has none yet."""
    columns: ColumnArrays
    """Values of each axis, SI, or the positions of named values among their names."""

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """Return an axis or a result by the name of its column."""
        return self.columns[name] if name in self.columns else self.results[name]

    def __len__(self) -> int:
        return len(self.row)

    def scalar(self, name: str) -> float:
        """Return a result of the first choice."""
        return float(self[name][0])

    @property
    def has_window(self) -> Flags:
        """True where some pretension serves enough."""
        return np.asarray(self["pretension_from"] <= self["pretension_to"])

    def scores(self, goals: tuple[Goal, ...]) -> Array:
        """Return the scores by each goal, (choices, goals); -infinity without a window."""
        scores = np.column_stack([goal.score(self[goal.column]) for goal in goals])
        return np.where(self["feasible"][:, np.newaxis], scores, -np.inf)

    def with_worst(
        self, rows: Rows | slice, values: dict[str, Array], *, has_worst: bool = True
    ) -> Solutions:
        """Return the same choices with worst values for some of them.

        Args:
            rows: Places of these choices.
            values: Columns of `WORST`, (rows,) each.
            has_worst: False if the values are only bounds.
        """
        changed = {name: self[name].copy() for name in (*WORST, "has_worst")}
        for name, column in {**values, "has_worst": has_worst}.items():
            changed[name][rows] = column
        return replace(self, results=self.results | changed)

    def select(self, rows: Rows | Flags | list[int]) -> Solutions:
        """Select choices by place or mask."""
        results = {name: values[rows] for name, values in self.results.items()}
        columns = {name: values[rows] for name, values in self.columns.items()}
        return Solutions(results, self.row[rows], columns)

    @classmethod
    def concatenate(cls, parts: list[Solutions]) -> Solutions:
        """Concatenate solutions of several parts."""
        first = parts[0]
        results = {
            name: np.concatenate([part.results[name] for part in parts]) for name in first.results
        }
        columns = {
            name: np.concatenate([part.columns[name] for part in parts]) for name in first.columns
        }
        return cls(results, np.concatenate([part.row for part in parts]), columns)


def solve_rows(problem: Problem, rows: Rows) -> Solutions:
    """Solve the choices in some rows of the question's choices."""
    return replace(solve_columns(problem, problem.choices.columns(rows), len(rows)), row=rows)


def solve_columns(
    problem: Problem, columns: ColumnArrays, count: int, *, with_worst: bool = True
) -> Solutions:
    """Solve `count` choices, anywhere in the space of choices, by their columns."""
    solved = solve(problem, problem.numbers_of(columns), count, with_worst=with_worst)
    return replace(solved, columns=columns)


def solve(problem: Problem, numbers: Numbers, count: int, *, with_worst: bool = True) -> Solutions:
    """Solve choices by their numbers.

    Args:
        problem: The question.
        numbers: Numbers of the choices, (count,) each.
        count: Number of choices.
        with_worst: False to leave out worst values, which saves two thirds of the time.

    Raises:
        Stopped: The run was cancelled.
    """
    parts = []
    for rows in problem.cut(count, max(1, _WINDOWS_AT_ONCE // len(problem.conditions))):
        selected = select_numbers(numbers, rows)
        solved, served = solve_windows(problem, selected, rows.stop - rows.start)
        worst_values = worst(problem, selected, solved["pretension"], served) if with_worst else {}
        parts.append(solved.with_worst(slice(None), worst_values, has_worst=with_worst))
    return parts[0] if len(parts) == 1 else Solutions.concatenate(parts)


def solve_windows(
    problem: Problem, numbers: Numbers, count: int, ends: Ends | None = None
) -> tuple[Solutions, Flags]:
    """Solve the windows and pretensions of choices, without the worst values at these.

    Args:
        problem: The question.
        numbers: Numbers of the choices, (count,) each.
        count: Number of choices.
        ends: Ends of their windows, (choices, conditions), if they are known.

    Returns:
        The choices, without rows and columns; and True where one serves a condition at its
        pretension, (choices, conditions).
    """
    if ends is None:
        ends = problem.ends(numbers, count)
    group_low, group_high = group_windows(ends.low, ends.high, problem.groups)
    results, best = _common_window(problem, ends, group_low, group_high)
    low = results["pretension_from"]
    high = results["pretension_to"]
    if problem.given is None:
        pretension = np.where(low <= high, _within(problem, low, high), _within(problem, *best))
    else:
        pretension = np.full(count, problem.given)
    is_served = serves(group_low, group_high, pretension[:, np.newaxis])  # (choices, groups)
    shares = np.minimum(is_served @ normalise(problem.weighting), 1.0)
    served_at = np.where(is_served.all(axis=1), 1.0, shares)  # exactly 1 if all groups are served
    binding = np.concatenate([results["from_condition"], results["to_condition"]])
    named = _name_limits(problem, numbers, ends, binding)
    results["from_by"] = named.low_by[:count]
    results["to_by"] = named.high_by[count:]
    for end, name in (("from", "low"), ("to", "high")):
        condition = results[f"{end}_condition"]
        results[f"{end}_state"] = _pick(getattr(ends, f"{name}_state"), condition)
        results[f"{end}_angle"] = _pick(getattr(ends, f"{name}_angle"), condition)
    results["tolerance"] = _tolerance(low, high)
    results["served_at"] = served_at
    results["pretension"] = pretension
    results |= dict.fromkeys(WORST, np.full(count, np.nan))
    results["has_worst"] = np.zeros(count, dtype=np.bool_)
    results["between_samples"] = np.zeros(count, dtype=np.int64)
    if problem.given is None:
        results["feasible"] = low <= high
    else:
        results["feasible"] = served_at >= problem.enough - ROUNDING
    return Solutions(results, np.full(count, -1), {}), is_served[:, problem.groups]


def _common_window(
    problem: Problem, ends: Ends, group_low: Array, group_high: Array
) -> tuple[ColumnArrays, tuple[Array, Array]]:
    """Find the widest interval of pretension that serves enough, for each choice.

    If there is none, its ends are those over all conditions, and it is empty.

    Args:
        problem: The question.
        ends: Ends of windows, (choices, conditions), N.
        group_low: Lower ends of groups, (choices, groups), N.
        group_high: Upper ends.

    Returns:
        Columns of the interval, of the conditions that bind it, of the number of such intervals,
        and of the largest share served; and the ends of the interval that serves this share, N.
    """
    # A condition that no pretension suits leaves no window at all, and is the reason: argmax takes
    # the first NaN.
    from_condition = np.argmax(ends.low, axis=1)
    to_condition = np.argmin(ends.high, axis=1)
    low = _pick(ends.low, from_condition)
    high = _pick(ends.high, to_condition)
    covered = share_served(group_low, group_high, problem.weighting, enough=problem.enough)
    serves_all = low <= high
    windows = serves_all.astype(np.int64)
    served = np.where(serves_all, 1.0, covered.served)
    if problem.enough < 1.0:
        windows = covered.windows
        rows = np.flatnonzero(~np.isnan(covered.low))
        has_window = (group_low <= group_high)[:, problem.groups]
        for end, of_conditions, covered_end, condition in (
            (low, ends.low, covered.low, from_condition),
            (high, ends.high, covered.high, to_condition),
        ):
            end[rows] = covered_end[rows]
            is_at_end = of_conditions[rows] == covered_end[rows, np.newaxis]
            condition[rows] = np.argmax(is_at_end & has_window[rows], axis=1)
    results = {
        "pretension_from": low,
        "pretension_to": high,
        "windows": windows,
        "served": served,
        "from_condition": from_condition,
        "to_condition": to_condition,
    }
    return results, (covered.best_low, covered.best_high)


def _name_limits(problem: Problem, numbers: Numbers, ends: Ends, condition: Rows) -> Window:
    """Return windows with the limits that bind, each of a choice under one condition, (pairs,).

    Conditions are listed for all choices in turn, then for all choices again.
    """
    rows = np.arange(len(condition)) % len(ends.low)
    picked = {name: values[rows, condition] for name, values in vars(ends).items()}
    if isinstance(ends, Window):
        return Window(**picked)
    design = problem.paired(numbers, rows, condition)
    return window.with_binding_limits(
        Ends(**picked), design, problem.angles, problem.flexion, problem.bounds
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


def _within(problem: Problem, low: Array, high: Array) -> Array:
    """Return the pretension at which a choice is set in its window, N.

    It is the middle or, if the study says so, the lower end; twice the lower end is taken for the
    middle if nothing bounds the window above.
    """
    if not problem.middle:
        return low
    return np.where(np.isinf(high), 2.0 * low, 0.5 * (low + high))


# --- The worst at a pretension --------------------------------------------------------------------


def worst(problem: Problem, numbers: Numbers, pretension: Array, served: Flags) -> dict[str, Array]:
    """Return the columns `WORST`, each the worst value over the conditions that are served.

    Args:
        problem: The question.
        numbers: Numbers of the choices.
        pretension: Pretensions of the choices, (choices,), N.
        served: Conditions that count, (choices, conditions).

    Returns:
        Columns, (choices,) each; NaN for a choice that serves no condition.
    """
    largest = np.full((6, len(pretension)), np.nan)
    for rows, conditions, values in _quantities(problem, numbers, pretension):
        of_served = np.where(served[rows, conditions], values, np.nan)
        largest[:, rows] = np.fmax(largest[:, rows], np.fmax.reduce(of_served, axis=2))
    return worst_columns(largest)


def worst_columns(largest: Array) -> dict[str, Array]:
    """Return the columns `WORST` from the largest of the six quantities, (6, choices)."""
    tension, extension, forward, backward, softness, pressure = largest
    torque = np.where(backward > forward, -backward, forward)
    return dict(zip(WORST, (tension, extension, torque, -softness, pressure), strict=True))


def quantities_under_each(
    problem: Problem, numbers: Numbers, pretension: Array, served: Flags
) -> Array:
    """Return the six quantities of one choice under each condition, (6, conditions).

    They are -infinity under a condition that is not served.
    """
    largest = np.full((6, len(problem.conditions)), -np.inf)
    for rows, conditions, values in _quantities(problem, numbers, pretension):
        counts = served[rows, conditions] & ~np.isnan(values)
        largest[:, conditions] = np.where(counts, values, -np.inf)[:, 0]
    return largest


def severest_conditions(
    problem: Problem, numbers: Numbers, pretension: Array, served: Flags, most: int
) -> Rows:
    """Return the conditions that are the worst for one choice, `most` for each quantity."""
    largest = quantities_under_each(problem, numbers, pretension, served)
    return np.unique(np.argsort(-largest, axis=1, kind="stable")[:, :most])


def _quantities(
    problem: Problem, numbers: Numbers, pretension: Array
) -> Iterator[tuple[slice, slice, Array]]:
    """Yield choices, conditions and their six quantities, the larger the worse.

    The quantities, (6, choices, conditions), are the largest over all states of tension, spring
    extension, motor torque forward and backward, softness of the elbow, and strap pressure.
    """
    angles = problem.angles
    for rows, conditions, design in problem.chunks(numbers, len(pretension), pretension):
        shape = (rows.stop - rows.start, conditions.stop - conditions.start)
        values = extremes.begin(shape)
        state = State.of(design, angles, problem.flexion)
        states = (*shape, len(problem.flexion), angles.size)
        kernel.fold_extremes(values, state, angles.ravel(), states)
        tension = values["max_extensor_distal"][..., np.newaxis, np.newaxis]
        pressure = contact_pressure(design, tension)[..., 0, 0]
        quantities = (
            values["max_tension"],
            values["max_spring_extension"],
            values["highest_motor_torque"],
            -values["lowest_motor_torque"],
            -values["min_elbow_stiffness"],
            np.broadcast_to(pressure, shape),
        )
        yield rows, conditions, np.stack(quantities)
