"""What each choice comes to: its window, what binds, who is served, and the worst at its pretension."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.answers.coverage import ROUNDING, grouped, normalised, serves, share_served
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question import Columns, Flags, Goal, select_numbers
from tendon_cli.model import extremes, window
from tendon_cli.model.actuator import State
from tendon_cli.model.kinematics import Array
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
"""Columns of a choice at its pretension: the worst over all conditions that this serves."""

_WINDOWS_AT_ONCE = 2**19


@dataclass(frozen=True, eq=False)
class Solutions:
    """Choices and what they come to: columns as `choices.parquet` has them, (choices,); NaN where there is none.

    `pretension_to` is infinite where nothing bounds the window, which is empty where from > to, and NaN where no
    pretension could do. `from_by` and `to_by` are indices into `limits.LIMIT_NAMES`, or NOTHING; `from_state` and
    `to_state` places among directions and angles, -1 if the limit belongs to none; `from_angle` and `to_angle` the
    elbow angles that bind, rad, next to those of the states. Without `has_worst` the worst is NaN, or a bound.
    """

    results: Columns
    row: Rows  # their rows in `choices.parquet`; -1 for one between the points of the grid that has none yet
    columns: (
        Columns  # their values of each axis: SI, or of named values the position among their names
    )

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """An axis or a result by its column's name."""
        return self.columns[name] if name in self.columns else self.results[name]

    def __len__(self) -> int:
        return len(self.row)

    def one(self, name: str) -> float:
        """A result of the first."""
        return float(self[name][0])

    @property
    def has_window(self) -> Flags:
        """Whether there is a pretension that serves enough."""
        return np.asarray(self["pretension_from"] <= self["pretension_to"])

    def scores(self, goals: tuple[Goal, ...]) -> Array:
        """The score of each by each goal, (choices, goals); one without a window has the least."""
        scores = np.column_stack([goal.score(self[goal.column]) for goal in goals])
        return np.where(self["feasible"][:, np.newaxis], scores, -np.inf)

    def with_worst(
        self, rows: Rows | slice, values: dict[str, Array], *, has_worst: bool = True
    ) -> Solutions:
        """The same, some of the choices with the worst at their pretension."""
        whole = {name: self[name].copy() for name in (*WORST, "has_worst")}
        for name, column in {**values, "has_worst": has_worst}.items():
            whole[name][rows] = column
        return replace(self, results=self.results | whole)

    def select(self, rows: Rows | Flags | list[int]) -> Solutions:
        """Some of them."""
        results, columns = (
            {name: each[rows] for name, each in of.items()} for of in (self.results, self.columns)
        )
        return Solutions(results, self.row[rows], columns)

    @classmethod
    def concatenate(cls, parts: list[Solutions]) -> Solutions:
        """Those of several, one after the other."""
        first = parts[0]
        results = {
            name: np.concatenate([part.results[name] for part in parts]) for name in first.results
        }
        columns = {
            name: np.concatenate([part.columns[name] for part in parts]) for name in first.columns
        }
        return cls(results, np.concatenate([part.row for part in parts]), columns)


def of_rows(problem: Problem, rows: Rows) -> Solutions:
    """The choices of some rows, solved."""
    return replace(of_columns(problem, problem.choices.columns(rows), len(rows)), row=rows)


def of_columns(
    problem: Problem, columns: Columns, count: int, *, with_worst: bool = True
) -> Solutions:
    """Choices anywhere, solved."""
    return replace(
        solve(problem, problem.numbers_of(columns), count, with_worst=with_worst), columns=columns
    )


def solve(problem: Problem, numbers: Numbers, count: int, *, with_worst: bool = True) -> Solutions:
    """Solve `count` choices, whose numbers have the shape (count,). Without the worst it takes a third of the time."""
    parts = []
    for rows in problem.cut(count, max(1, _WINDOWS_AT_ONCE // len(problem.conditions))):
        some = select_numbers(numbers, rows)
        solved, held = without_worst(problem, some, rows.stop - rows.start)
        worsts = worst(problem, some, solved["pretension"], held) if with_worst else {}
        parts.append(solved.with_worst(slice(None), worsts, has_worst=with_worst))
    return parts[0] if len(parts) == 1 else Solutions.concatenate(parts)


def without_worst(
    problem: Problem, numbers: Numbers, count: int, ends: Ends | None = None
) -> tuple[Solutions, Flags]:
    """Choices solved but for the worst at their pretensions, and which conditions each serves; by ends, if known."""
    ends = problem.ends(numbers, count) if ends is None else ends
    of_groups = grouped(ends.low, ends.high, problem.groups)
    results, best = _common(problem, ends, *of_groups)
    low, high = results["pretension_from"], results["pretension_to"]
    pretension = np.where(low <= high, _within(problem, low, high), _within(problem, *best))
    if problem.given is not None:
        pretension = np.full(count, problem.given)
    held = serves(*of_groups, pretension[:, np.newaxis])
    # Exactly 1 if all groups are served.
    served = np.where(held.all(axis=1), 1.0, np.minimum(held @ normalised(problem.weighting), 1.0))
    named = _named(
        problem, numbers, ends, np.concatenate([results["from_condition"], results["to_condition"]])
    )
    results |= {"from_by": named.low_by[:count], "to_by": named.high_by[count:]}
    for end, name in (("from", "low"), ("to", "high")):
        condition = results[f"{end}_condition"]
        results[f"{end}_state"] = _taken(getattr(ends, f"{name}_state"), condition)
        results[f"{end}_angle"] = _taken(getattr(ends, f"{name}_angle"), condition)
    results |= {"tolerance": _tolerance(low, high), "served_at": served, "pretension": pretension}
    results |= {
        **dict.fromkeys(WORST, np.full(count, np.nan)),
        "has_worst": np.zeros(count, dtype=np.bool_),
    }
    results["between_samples"] = np.zeros(count, dtype=np.int64)
    results["feasible"] = (
        low <= high if problem.given is None else served >= problem.enough - ROUNDING
    )
    return Solutions(results, np.full(count, -1), {}), held[:, problem.groups]


def _common(
    problem: Problem, ends: Ends, of_low: Array, of_high: Array
) -> tuple[Columns, tuple[Array, Array]]:
    """The widest interval that serves enough, its binding conditions, how many there are, and what is best served.

    `of_low` and `of_high` are the ends of groups. If there is none, its ends are those over all conditions, and it is
    empty.
    """
    # A condition that no pretension suits leaves no window at all, and is the reason: argmax takes the first NaN.
    from_condition, to_condition = np.argmax(ends.low, axis=1), np.argmin(ends.high, axis=1)
    low, high = _taken(ends.low, from_condition), _taken(ends.high, to_condition)
    covered = share_served(of_low, of_high, problem.weighting, enough=problem.enough)
    windows, served = (low <= high).astype(np.int64), np.where(low <= high, 1.0, covered.served)
    if problem.enough < 1.0:
        windows, some = covered.windows, np.flatnonzero(~np.isnan(covered.low))
        has_window = (of_low <= of_high)[:, problem.groups]
        for end, of_conditions, value, condition in (
            (low, ends.low, covered.low, from_condition),
            (high, ends.high, covered.high, to_condition),
        ):
            end[some] = value[some]
            binds = (of_conditions[some] == value[some, np.newaxis]) & has_window[some]
            condition[some] = np.argmax(binds, axis=1)
    results = {"pretension_from": low, "pretension_to": high, "windows": windows, "served": served}
    return {**results, "from_condition": from_condition, "to_condition": to_condition}, (
        covered.best_low,
        covered.best_high,
    )


def _named(problem: Problem, numbers: Numbers, ends: Ends, condition: Rows) -> Window:
    """Of the ends of choices the windows, each under one condition; all choices as often as there are conditions."""
    rows = np.arange(len(condition)) % len(ends.low)
    picked = {name: values[rows, condition] for name, values in vars(ends).items()}
    if isinstance(ends, Window):
        return Window(**picked)
    design = problem.paired(numbers, rows, condition)
    return window.named(Ends(**picked), design, problem.angles, problem.flexion, problem.bounds)


def _taken(values: npt.NDArray[Any], condition: Rows) -> npt.NDArray[Any]:
    taken: npt.NDArray[Any] = np.take_along_axis(values, condition[:, np.newaxis], axis=1)[:, 0]
    return taken


def _tolerance(low: Array, high: Array) -> Array:
    """(to - from)/(to + from), the share by which the pretension may be off; 1 if nothing bounds it above."""
    with np.errstate(invalid="ignore", divide="ignore"):
        share = (high - low) / (high + low)
    # A window from 0 to 0 tolerates nothing.
    return np.where(
        low <= high, np.where(np.isinf(high), 1.0, np.where(high == 0.0, 0.0, share)), np.nan
    )


def _within(problem: Problem, low: Array, high: Array) -> Array:
    """Where in its window a choice is set; twice the least pretension if nothing bounds it above."""
    if not problem.middle:
        return low
    return np.where(np.isinf(high), 2.0 * low, 0.5 * (low + high))


# --- The worst at a pretension ---------------------------------------------------------------------------------------


def worst(problem: Problem, numbers: Numbers, pretension: Array, served: Flags) -> dict[str, Array]:
    """The worst over the conditions that a pretension serves, (choices,); NaN if it serves none."""
    largest = np.full((6, len(pretension)), np.nan)
    for rows, conditions, values in _quantities(problem, numbers, pretension):
        here = np.fmax.reduce(np.where(served[rows, conditions], values, np.nan), axis=2)
        largest[:, rows] = np.fmax(largest[:, rows], here)
    return worst_columns(largest)


def worst_columns(largest: Array) -> dict[str, Array]:
    """Columns of the largest of the six quantities, (6, choices)."""
    tension, extension, forward, backward, softness, pressure = largest
    torque = np.where(backward > forward, -backward, forward)
    return dict(zip(WORST, (tension, extension, torque, -softness, pressure), strict=True))


def under_each(problem: Problem, numbers: Numbers, pretension: Array, served: Flags) -> Array:
    """The six quantities of one choice under each condition, (6, conditions); those that are not served have least."""
    whole = np.full((6, len(problem.conditions)), -np.inf)
    for rows, conditions, values in _quantities(problem, numbers, pretension):
        whole[:, conditions] = np.where(
            served[rows, conditions] & ~np.isnan(values), values, -np.inf
        )[:, 0]
    return whole


def severest(
    problem: Problem, numbers: Numbers, pretension: Array, served: Flags, most: int
) -> Rows:
    """The conditions, `most` for each quantity, that are the worst for one choice."""
    whole = under_each(problem, numbers, pretension, served)
    return np.unique(np.argsort(-whole, axis=1, kind="stable")[:, :most])


def _quantities(
    problem: Problem, numbers: Numbers, pretension: Array
) -> Iterator[tuple[slice, slice, Array]]:
    """Six quantities of choices under conditions, the larger the worse, (6, choices, conditions)."""
    for rows, conditions, design in problem.chunks(numbers, len(pretension), pretension):
        shape = rows.stop - rows.start, conditions.stop - conditions.start
        values, at = extremes.begin(shape), State.of(design, problem.angles, problem.flexion)
        kernel.fold_extremes(
            values, at, problem.angles.ravel(), (*shape, len(problem.flexion), problem.angles.size)
        )
        pressure = contact_pressure(
            design, values["max_extensor_distal"][..., np.newaxis, np.newaxis]
        )[..., 0, 0]
        yield (
            rows,
            conditions,
            np.stack(
                (
                    values["max_tension"],
                    values["max_spring_extension"],
                    values["highest_motor_torque"],
                    -values["lowest_motor_torque"],
                    -values["min_elbow_stiffness"],
                    np.broadcast_to(pressure, shape),
                )
            ),
        )
