"""For whom, and how sure: what one choice is to every person, or over draws of what is uncertain."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tendon_cli.answers import coverage
from tendon_cli.answers.candidates import Candidates, numbers_of
from tendon_cli.answers.coverage import ROUNDING, Curve, grouped
from tendon_cli.answers.problem import Flags, Problem
from tendon_cli.answers.sizes import Sizes, best_sizes
from tendon_cli.answers.uncertainty import Indices, indices
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES, Codes
from tendon_cli.space.axis import PERSON_AXIS, Numbers, Rows
from tendon_cli.studies.people.population import Population as People

MORE, LESS, NEITHER = 1, -1, 0
"""What someone who is not served would need: more pretension, less, or another suit."""

MOST_SIZES = 3
_MOST_ALONG = 16
"""Values of an axis among which sizes are chosen."""
_MOST_PERSONS = 1000
"""Persons by whom sizes are chosen: the first so many, as the search grows with their square."""


@dataclass(frozen=True, eq=False)
class GroupWindows:
    """The windows of groups, such as persons, of one choice over their other conditions, each of shape (groups,)."""

    low: Array
    """N; empty where low > high, NaN where no pretension could do."""
    high: Array
    low_by: Codes
    """Index into `LIMIT_NAMES`, or -1."""
    high_by: Codes
    low_condition: Rows
    """The row of conditions that binds."""
    high_condition: Rows

    def served(self, pretension: float) -> Flags:
        """Which of them a pretension serves."""
        return (self.low <= pretension * (1 + ROUNDING)) & (pretension <= self.high * (1 + ROUNDING))


@dataclass(frozen=True)
class Difference:
    """How those not served differ from everyone in one dimension of the body, SI."""

    dimension: str
    theirs: float
    """Their mean."""
    of_all: float
    deviations: float
    """By how many standard deviations of everyone theirs is larger."""


@dataclass(frozen=True, eq=False)
class Reason:
    """Some who are not served for the same reason."""

    needs: int
    """MORE, LESS or NEITHER."""
    limits: tuple[str, ...]
    """The limit that is not kept; if no pretension would do, both that conflict."""
    conditions: tuple[int, ...]
    """For each limit the condition under which most of them meet it, a row of conditions."""
    members: Rows
    """Their numbers, the farthest from being served first."""
    share: float
    """Of the weighting of all."""
    differences: tuple[Difference, ...] = ()
    """The dimensions in which they differ most, if they are persons."""


@dataclass(frozen=True, eq=False)
class AxisSizes:
    """With one, two and three suits that differ along one axis of the choices, which, and whom they serve."""

    column: str
    values: tuple[float | str, ...]
    """Those that the suits may have, SI."""
    best: tuple[Sizes, ...]
    """With one suit, two and three."""
    persons: int
    """How many were counted."""
    thinned: bool
    """Whether the axis has more values than were tried."""


@dataclass(frozen=True, eq=False)
class PopulationResult:
    """What one choice is to those who are served, or not, one by one."""

    problem: Problem
    chosen: Candidates
    """One choice."""
    people: People | None
    """None if the groups are draws."""
    windows: GroupWindows
    pretension: float
    """That of the choice, N."""
    share: float
    """Whom it serves."""
    reasons: tuple[Reason, ...]
    """Of those not served."""
    curve: Curve
    sizes: tuple[AxisSizes, ...]
    indices: tuple[Indices, ...]

    @property
    def best_share(self) -> float:
        """Whom the pretension that serves most serves."""
        return float(self.chosen.solutions.served[0])

    @property
    def kind(self) -> str:
        """What the groups are, in one word: "persons", "pairs" (of person and draw) or "draws"."""
        return self.problem.counted


def population(problem: Problem, chosen: Candidates, windows: GroupWindows) -> PopulationResult:
    """What a choice is to persons or draws, whose windows these are."""
    study = problem.study
    people = study.people.population if study.people is not None and PERSON_AXIS in study.axes else None
    numbers = numbers_of(problem, chosen.columns)
    pretension = float(chosen.solutions.pretension[0])
    return PopulationResult(
        problem, chosen, people, windows, pretension,
        share=float(chosen.solutions.served_at[0]),
        reasons=not_served(problem, windows, pretension, people),
        curve=coverage.curve(windows.low, windows.high, problem.weighting),
        sizes=tuple(_sizes(problem, chosen)) if people is not None else (),
        indices=tuple(indices(problem, numbers)),
    )  # fmt: skip


def windows_of(problem: Problem, numbers: Numbers) -> GroupWindows:
    """The windows of all groups of a question, for one choice."""
    windows = problem.windows(numbers, 1)
    shape = (int(problem.groups[-1]) + 1, -1)
    low, high = windows.low.reshape(shape), windows.high.reshape(shape)
    at_low, at_high = np.argmax(low, axis=1), np.argmin(high, axis=1)  # NaN counts as the first
    first, rows = np.arange(shape[0]) * low.shape[1], np.arange(shape[0])
    return GroupWindows(
        low[rows, at_low], high[rows, at_high],
        windows.low_by.reshape(shape)[rows, at_low], windows.high_by.reshape(shape)[rows, at_high],
        first + at_low, first + at_high,
    )  # fmt: skip


def not_served(problem: Problem, windows: GroupWindows, pretension: float, people: People | None) -> tuple[Reason, ...]:
    """Those whom a pretension (N) does not serve, by reason, the most frequent first."""
    out = np.flatnonzero(~windows.served(pretension))
    has_window = windows.low[out] <= windows.high[out]
    needs = np.where(~has_window, NEITHER, np.where(windows.low[out] > pretension, MORE, LESS))
    missing = np.fmax(windows.low[out] - pretension, pretension - windows.high[out])
    by_reason: dict[tuple[int, int, int], list[int]] = {}
    for at, person in enumerate(out.tolist()):
        low_by, high_by = int(windows.low_by[person]), int(windows.high_by[person])
        key = {MORE: (MORE, low_by, -1), LESS: (LESS, high_by, -1)}.get(int(needs[at]), (NEITHER, low_by, high_by))
        by_reason.setdefault(key, []).append(at)
    weights = coverage.normalised(problem.weighting)
    reasons = []
    for (need, first, second), places in by_reason.items():
        members = out[places][np.argsort(-missing[places], kind="stable")]
        limits = dict.fromkeys(LIMIT_NAMES[code] for code in (first, second) if code >= 0)
        ends = {MORE: ("low",), LESS: ("high",), NEITHER: ("low", "high")}[need]
        conditions = tuple(_usual(problem, getattr(windows, f"{end}_condition")[members]) for end in ends)
        differences = () if people is None else tuple(_differences(people, problem.person_of(members)))
        share = float(weights[members].sum())
        reasons.append(Reason(need, tuple(limits), conditions[: len(limits)], members, share, differences))
    return tuple(sorted(reasons, key=lambda reason: (-reason.share, -len(reason.members))))


def _usual(problem: Problem, conditions: Rows) -> int:
    """The condition that binds most of some groups, as that of the first group in which it does."""
    each = len(problem.conditions) // (int(problem.groups[-1]) + 1)
    within = conditions % each
    return int(conditions[np.argmax(within == np.bincount(within).argmax())])


def _differences(people: People, members: Rows) -> Iterator[Difference]:
    """The dimensions in which some persons differ most from everyone, the largest difference first."""
    weights = coverage.normalised(people.weighting)
    mean = weights @ people.values
    deviation = np.sqrt(weights @ np.square(people.values - mean))
    theirs = people.values[members].mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.where(deviation > 0.0, (theirs - mean) / deviation, 0.0)
    for at in np.argsort(-np.abs(apart), kind="stable"):
        yield Difference(DIMENSIONS[at], float(theirs[at]), float(mean[at]), float(apart[at]))


def _of_persons(low: Array, high: Array, draws: int, enough: float) -> tuple[Array, Array]:
    """The windows of persons, (choices, persons), from those of pairs with draws: of enough of a person's draws."""
    if draws == 1:
        return low, high
    each = (low.reshape(-1, draws), high.reshape(-1, draws))
    covered = coverage.share_served(*each, np.ones(draws), enough=enough)
    return covered.low.reshape(len(low), -1), covered.high.reshape(len(low), -1)


def _sizes(problem: Problem, chosen: Candidates) -> Iterator[AxisSizes]:
    """For each axis of the choices the best few suits along it, all else as in the one chosen."""
    draws = len(problem.weighting) // problem.counts[PERSON_AXIS]
    persons = min(problem.counts[PERSON_AXIS], _MOST_PERSONS)
    each = len(problem.conditions) // len(problem.weighting)
    some = problem.under(np.arange(persons * each * draws))
    for factor in problem.choices.axes:
        along = np.unique(np.linspace(0, len(factor) - 1, min(len(factor), _MOST_ALONG)).round().astype(np.int64))
        if len(along) < 2:
            continue
        columns = {name: np.repeat(values[:1], len(along)) for name, values in chosen.columns.items()}
        columns[factor.column] = along if factor.names else factor.values[along]
        windows = some.ends(numbers_of(problem, columns), len(along))
        of_groups = grouped(windows.low, windows.high, problem.groups[: persons * each * draws])
        ends = _of_persons(*of_groups, draws, problem.enough)
        best = best_sizes(*ends, problem.weighting[: persons * draws : draws], MOST_SIZES, problem.heed)
        values = tuple(factor.names[at] if factor.names else float(factor.values[at]) for at in along.tolist())
        yield AxisSizes(factor.column, values, best, persons, thinned=len(along) < len(factor))
