"""What each choice comes to: its window, what binds, who is served, and the worst at its pretension."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from tendon_cli.answers.coverage import ROUNDING, grouped, share_served
from tendon_cli.answers.factors import Numbers
from tendon_cli.answers.problem import Flags, Problem, Rows
from tendon_cli.answers.worst import WORST, worst
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import Codes
from tendon_cli.model.window import Ends

Kind = TypeVar("Kind", bound=np.generic)

_DESIGNS_AT_ONCE = 2**20
"""Windows of choices under conditions that are held at once."""


@dataclass(frozen=True, eq=False)
class Solutions:
    """Results of choices, (choices,), as `choices.parquet` has them; NaN where there is none."""

    pretension_from: Array
    """N; over all conditions, or where enough is served. Empty where from > to, NaN where no pretension could do."""
    pretension_to: Array
    """N; infinite where nothing bounds it."""
    windows: npt.NDArray[np.int64]
    """How many intervals serve enough; the widest is told."""
    from_by: Codes
    """Index into `limits.LIMIT_NAMES`, or NOTHING."""
    to_by: Codes
    from_condition: Rows
    to_condition: Rows
    from_state: Rows
    """The state that binds, by its place among directions and angles; -1 where the limit belongs to none."""
    to_state: Rows
    served: Array
    """The largest share that one pretension serves."""
    pretension: Array
    """In the window, or where that is empty, one that serves most, N."""
    max_tension: Array
    max_spring_extension: Array
    peak_motor_torque: Array
    min_elbow_stiffness: Array
    max_contact_pressure: Array
    worked_out: Flags
    """Whether the worst at the pretension, these last five, is: else they are NaN, or bounds."""

    @property
    def feasible(self) -> Flags:
        """Whether a choice has a window."""
        return np.asarray(self.pretension_from <= self.pretension_to)

    @property
    def tolerance(self) -> Array:
        """(to - from)/(to + from), the share by which the pretension may be off; 1 where nothing bounds it above."""
        with np.errstate(invalid="ignore", divide="ignore"):
            share = (self.pretension_to - self.pretension_from) / (self.pretension_to + self.pretension_from)
        # Of a window from 0 to 0 nothing may be off.
        share = np.where(np.isinf(self.pretension_to), 1.0, np.where(self.pretension_to == 0.0, 0.0, share))
        return np.where(self.feasible, share, np.nan)

    def column(self, name: str) -> Array:
        """A result by its name, as numbers."""
        return np.asarray(getattr(self, name), dtype=np.float64)

    def with_worst(self, rows: Rows | slice, found: dict[str, Array], *, worked_out: bool = True) -> Solutions:
        """The same, some of the choices with the worst at their pretension."""
        whole = {name: getattr(self, name).copy() for name in (*WORST, "worked_out")}
        for name, values in found.items():
            whole[name][rows] = values
        whole["worked_out"][rows] = worked_out
        return replace(self, **whole)

    def taken(self, rows: Rows | slice | Flags) -> Solutions:
        """Some of the choices."""
        return Solutions(**{each.name: getattr(self, each.name)[rows] for each in fields(self)})

    @classmethod
    def joined(cls, parts: list[Solutions]) -> Solutions:
        """The choices of several, one after the other."""
        return cls(**{each.name: np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(cls)})


def solve(problem: Problem, numbers: Numbers, count: int, *, with_worst: bool = True) -> Solutions:
    """Solve `count` choices, whose numbers have the shape (count,). Without the worst it takes a third of the time."""
    step = max(1, _DESIGNS_AT_ONCE // len(problem.conditions))
    parts = []
    for at in range(0, max(count, 1), step):
        some = {key: values[at : at + step] for key, values in numbers.items()}
        found, held = without_worst(problem, some, min(step, count - at))
        if with_worst:
            found = found.with_worst(slice(None), worst(problem, some, found.pretension, held))
        parts.append(found)
    return Solutions.joined(parts)


def without_worst(problem: Problem, numbers: Numbers, count: int) -> tuple[Solutions, Flags]:
    """Choices solved but for the worst at their pretensions, and which conditions each serves."""
    found = problem.ends(numbers, count)
    low, high, from_condition, to_condition, windows, served, best = _common(problem, found)
    pretension = np.where(low <= high, _within(problem, low, high), _within(problem, *best))
    solutions = Solutions(
        pretension_from=low,
        pretension_to=high,
        windows=windows,
        from_by=problem.named(numbers, found, from_condition).low_by,
        to_by=problem.named(numbers, found, to_condition).high_by,
        from_condition=from_condition,
        to_condition=to_condition,
        from_state=_taken(found.low_state, from_condition),
        to_state=_taken(found.high_state, to_condition),
        served=served,
        pretension=pretension,
        **dict.fromkeys(WORST, np.full(count, np.nan)),
        worked_out=np.zeros(count, dtype=np.bool_),
    )
    return solutions, _held(problem, found, pretension)


def _common(
    problem: Problem, found: Ends
) -> tuple[Array, Array, Rows, Rows, npt.NDArray[np.int64], Array, tuple[Array, Array]]:
    """The window over all conditions, or where enough is served; its binding conditions; and what is best served."""
    groups, weighting = problem.groups, problem.weighting
    # A condition that no pretension suits leaves no window at all, and is the reason: argmax takes the first NaN.
    from_condition, to_condition = np.argmax(found.low, axis=1), np.argmin(found.high, axis=1)
    low, high = _taken(found.low, from_condition), _taken(found.high, to_condition)
    is_open = low <= high
    windows, served = is_open.astype(np.int64), np.where(is_open, 1.0, 0.0)
    best_low, best_high = np.where(is_open, low, np.nan), np.where(is_open, high, np.nan)
    rest = np.flatnonzero(~is_open)
    if not rest.size:
        return low, high, from_condition, to_condition, windows, served, (best_low, best_high)
    of_groups = grouped(found.low[rest], found.high[rest], groups)
    covered = share_served(*of_groups, weighting, enough=problem.enough)
    served[rest], best_low[rest], best_high[rest] = covered.served, covered.best_low, covered.best_high
    if problem.enough < 1.0:
        windows[rest] = covered.windows
        for end, ends, value, condition in (
            (low, found.low, covered.low, from_condition),
            (high, found.high, covered.high, to_condition),
        ):
            some = ~np.isnan(value)
            end[rest[some]] = value[some]
            served_group = np.repeat(of_groups[0] <= of_groups[1], np.bincount(groups), axis=1)
            binds = (ends[rest] == value[:, np.newaxis]) & served_group
            condition[rest[some]] = np.argmax(binds[some], axis=1)
    return low, high, from_condition, to_condition, windows, served, (best_low, best_high)


def _taken(values: npt.NDArray[Kind], condition: Rows) -> npt.NDArray[Kind]:
    taken: npt.NDArray[Kind] = np.take_along_axis(values, condition[:, np.newaxis], axis=1)[:, 0]
    return taken


def _within(problem: Problem, low: Array, high: Array) -> Array:
    """Where in its window a choice is set; twice the least pretension where nothing bounds it above."""
    if not problem.middle:
        return low
    return np.where(np.isinf(high), 2.0 * low, 0.5 * (low + high))


def _held(problem: Problem, found: Ends, pretension: Array) -> Flags:
    """Which conditions a pretension serves, (choices, conditions): those of the groups that it serves altogether."""
    at = pretension[:, np.newaxis]
    with np.errstate(invalid="ignore"):
        held = (found.low <= at * (1 + ROUNDING)) & (at <= found.high * (1 + ROUNDING))
    if len(problem.weighting) == held.shape[1]:
        return held
    firsts = np.flatnonzero(np.diff(problem.groups, prepend=-1))
    return np.repeat(np.logical_and.reduceat(held, firsts, axis=1), np.bincount(problem.groups), axis=1)
