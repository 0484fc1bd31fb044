"""For whom, and how sure: what one choice is to a crowd of persons, or over draws of what is uncertain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.answers import shares
from tendon_cli.answers.candidates import Candidates, numbers_of
from tendon_cli.answers.coverage import grouped
from tendon_cli.answers.doubt import Indices, indices
from tendon_cli.answers.left_out import Reason, Windows, left_out, windows_of
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.shares import Curve
from tendon_cli.answers.sizes import Sizes, best_sizes
from tendon_cli.studies.people.population import Population
from tendon_cli.studies.study import PERSON_AXIS

MOST_SIZES = 3
_MOST_ALONG = 16
"""Values of an axis among which sizes are chosen."""
_MOST_PERSONS = 1000
"""Persons by whom sizes are chosen: the first so many, as the search grows with their square."""


@dataclass(frozen=True, eq=False)
class AxisSizes:
    """With one, two and three suits that differ along one axis of the choices, which, and whom they serve."""

    column: str
    values: tuple[float | str, ...]
    """Those that the suits may have, SI."""
    found: tuple[Sizes, ...]
    """With one suit, two and three."""
    persons: int
    """How many were counted."""
    thinned: bool
    """Whether the axis has more values than were tried."""


@dataclass(frozen=True, eq=False)
class Crowd:
    """What one choice is to those who are served, or not, one by one."""

    problem: Problem
    chosen: Candidates
    """One choice."""
    people: Population | None
    """None where the groups are draws."""
    windows: Windows
    pretension: float
    """That of the choice, N."""
    share: float
    """Whom it serves."""
    error: float
    """Its standard error."""
    best_share: float
    """Whom the pretension that serves most serves."""
    reasons: tuple[Reason, ...]
    """Of those left out."""
    curve: Curve
    sizes: tuple[AxisSizes, ...]
    indices: tuple[Indices, ...]

    @property
    def kind(self) -> str:
        """What the groups are, in one word."""
        return "persons" if self.people is not None else "draws"


def crowd(problem: Problem, chosen: Candidates) -> Crowd | None:
    """What a choice is to persons or draws; None where a question has neither."""
    if problem.conditions.groups is None:
        return None
    study = problem.study
    people = study.people.population if study.people is not None and PERSON_AXIS in study.axes else None
    numbers = numbers_of(problem, chosen.columns)
    windows = windows_of(problem, numbers)
    weighting = problem.weighting
    pretension = float(chosen.solutions.pretension[0])
    share = float(weighting[windows.held(pretension)].sum() / weighting.sum())
    return Crowd(
        problem, chosen, people, windows, pretension, share,
        error=float(shares.standard_error(share, weighting)),
        best_share=float(chosen.solutions.served[0]),
        reasons=left_out(problem, windows, pretension, people),
        curve=shares.curve(windows.low, windows.high, weighting),
        sizes=tuple(_sizes(problem, chosen)) if people is not None else (),
        indices=tuple(indices(problem, numbers)),
    )  # fmt: skip


def _sizes(problem: Problem, chosen: Candidates) -> list[AxisSizes]:
    """For each axis of the choices the best few suits along it, all else as in the one chosen."""
    found = []
    persons = min(len(problem.weighting), _MOST_PERSONS)
    each = len(problem.conditions) // len(problem.weighting)
    some = problem.under(np.arange(persons * each))
    for factor in problem.choices.factors:
        along = np.unique(np.linspace(0, len(factor) - 1, min(len(factor), _MOST_ALONG)).round().astype(np.int64))
        if len(along) < 2:
            continue
        columns = {name: np.repeat(values[:1], len(along)) for name, values in chosen.columns.items()}
        columns[factor.column] = along if factor.names else factor.values[along]
        windows = some.ends(numbers_of(problem, columns), len(along))
        ends = grouped(windows.low, windows.high, problem.groups[: persons * each])
        sizes = tuple(
            best_sizes(*ends, problem.weighting[:persons], most, problem.heed) for most in range(1, MOST_SIZES + 1)
        )
        values = tuple(factor.names[at] if factor.names else float(factor.values[at]) for at in along.tolist())
        found.append(AxisSizes(factor.column, values, sizes, persons, thinned=len(along) < len(factor)))
    return found
