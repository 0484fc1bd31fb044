"""Some choices of a question, with what they come to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.answers.factors import Factor, Numbers
from tendon_cli.answers.problem import Flags, Problem, Rows
from tendon_cli.answers.rank import Goal
from tendon_cli.answers.solve import Solutions, solve
from tendon_cli.model.kinematics import Array

Columns = dict[str, npt.NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Candidates:
    """Choices, those of the grid and others between its points."""

    row: Rows
    """Their rows in `choices.parquet`; -1 for one between the points of the grid that has none yet."""
    columns: Columns
    """Their values of each axis: SI, or of linked values the position among their names."""
    solutions: Solutions

    def __len__(self) -> int:
        return len(self.row)

    def column(self, name: str) -> Array:
        """An axis or a result by its column's name."""
        if name in self.columns:
            return np.asarray(self.columns[name], dtype=np.float64)
        return self.solutions.column(name)

    def worth(self, goals: tuple[Goal, ...]) -> Array:
        """The worth of each by each goal, (choices, goals); one without a window is worth nothing."""
        worth = np.column_stack([goal.worth(self.column(goal.column)) for goal in goals])
        return np.where(self.solutions.feasible[:, np.newaxis], worth, -np.inf)

    def taken(self, rows: Rows | Flags) -> Candidates:
        """Some of them."""
        columns = {name: values[rows] for name, values in self.columns.items()}
        return Candidates(self.row[rows], columns, self.solutions.taken(rows))

    @classmethod
    def joined(cls, parts: list[Candidates]) -> Candidates:
        """Those of several, one after the other."""
        columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns}
        solutions = Solutions.joined([part.solutions for part in parts])
        return cls(np.concatenate([part.row for part in parts]), columns, solutions)


def of_rows(problem: Problem, rows: Rows) -> Candidates:
    """The choices of some rows, solved."""
    solutions = solve(problem, problem.choices.numbers(rows), len(rows))
    return Candidates(rows, problem.choices.columns(rows), solutions)


def of_columns(problem: Problem, columns: Columns, count: int) -> Candidates:
    """Choices anywhere, solved."""
    solutions = solve(problem, numbers_of(problem, columns), count)
    return Candidates(np.full(count, -1), columns, solutions)


def numbers_of(problem: Problem, columns: Columns) -> Numbers:
    """What choices, given by their columns, say of the study's numbers."""
    found: dict[str, Array] = {}
    for factor in problem.choices.factors:
        found |= _numbers_of(factor, columns[factor.column])
    return found


def _numbers_of(factor: Factor, values: npt.NDArray[Any]) -> Numbers:
    if factor.names:
        return {key: numbers[values] for key, numbers in factor.numbers.items()}
    return {factor.key: values}
