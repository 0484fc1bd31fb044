"""Whom a pretension does not serve, and why: which limit, under which condition, and how their bodies differ."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tendon_cli.answers.coverage import ROUNDING
from tendon_cli.answers.factors import Numbers
from tendon_cli.answers.problem import Problem, Rows
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES, Codes
from tendon_cli.studies.people.population import Population

MORE, LESS, NEITHER = 1, -1, 0
"""What someone who is not served would need: more pretension, less, or another suit."""


@dataclass(frozen=True, eq=False)
class Windows:
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

    def held(self, pretension: float) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Which of them a pretension serves."""
        return (self.low <= pretension * (1 + ROUNDING)) & (pretension <= self.high * (1 + ROUNDING))


@dataclass(frozen=True)
class Difference:
    """How those left out differ from everyone in one dimension of the body, SI."""

    dimension: str
    theirs: float
    """Their mean."""
    of_all: float
    deviations: float
    """By how many standard deviations of everyone theirs is larger."""


@dataclass(frozen=True, eq=False)
class Reason:
    """Some who are left out for the same reason."""

    needs: int
    """MORE, LESS or NEITHER."""
    limits: tuple[str, ...]
    """The limit that is not kept; where no pretension would do, both that conflict."""
    conditions: tuple[int, ...]
    """For each limit the condition under which most of them meet it, a row of conditions."""
    members: Rows
    """Their numbers, the farthest from being served first."""
    share: float
    """Of the weighting of all."""
    differences: tuple[Difference, ...] = ()
    """The dimensions in which they differ most, where they are persons."""


def windows_of(problem: Problem, numbers: Numbers) -> Windows:
    """The windows of all groups of a question, for one choice."""
    found = problem.windows(numbers, 1)
    shape = (int(problem.groups[-1]) + 1, -1)
    low, high = found.low.reshape(shape), found.high.reshape(shape)
    at_low, at_high = np.argmax(low, axis=1), np.argmin(high, axis=1)  # of NaN the first
    first, rows = np.arange(shape[0]) * low.shape[1], np.arange(shape[0])
    return Windows(
        low[rows, at_low], high[rows, at_high],
        found.low_by.reshape(shape)[rows, at_low], found.high_by.reshape(shape)[rows, at_high],
        first + at_low, first + at_high,
    )  # fmt: skip


def left_out(problem: Problem, windows: Windows, pretension: float, people: Population | None) -> tuple[Reason, ...]:
    """Those whom a pretension (N) does not serve, by reason, the most frequent first."""
    out = np.flatnonzero(~windows.held(pretension))
    open_ones = windows.low[out] <= windows.high[out]
    needs = np.where(~open_ones, NEITHER, np.where(windows.low[out] > pretension, MORE, LESS))
    missing = np.fmax(windows.low[out] - pretension, pretension - windows.high[out])
    by_reason: dict[tuple[int, int, int], list[int]] = {}
    for at, person in enumerate(out.tolist()):
        low_by, high_by = int(windows.low_by[person]), int(windows.high_by[person])
        key = {MORE: (MORE, low_by, -1), LESS: (LESS, high_by, -1)}.get(int(needs[at]), (NEITHER, low_by, high_by))
        by_reason.setdefault(key, []).append(at)
    weights = problem.weighting / problem.weighting.sum()
    reasons = []
    for (need, first, second), places in by_reason.items():
        members = out[places][np.argsort(-missing[places], kind="stable")]
        limits = dict.fromkeys(LIMIT_NAMES[code] for code in (first, second) if code >= 0)
        ends = {MORE: ("low",), LESS: ("high",), NEITHER: ("low", "high")}[need]
        conditions = tuple(_usual(problem, getattr(windows, f"{end}_condition")[members]) for end in ends)
        differences = () if people is None else tuple(_differences(people, members))
        share = float(weights[members].sum())
        reasons.append(Reason(need, tuple(limits), conditions[: len(limits)], members, share, differences))
    return tuple(sorted(reasons, key=lambda reason: (-reason.share, -len(reason.members))))


def _usual(problem: Problem, conditions: Rows) -> int:
    """The condition that binds most of some groups, as that of the first group in which it does."""
    each = len(problem.conditions) // (int(problem.groups[-1]) + 1)
    within = conditions % each
    return int(conditions[np.argmax(within == np.bincount(within).argmax())])


def _differences(people: Population, members: Rows) -> Iterator[Difference]:
    """The dimensions in which some persons differ most from everyone, the largest difference first."""
    weights = people.weighting / people.weighting.sum()
    mean = weights @ people.values
    deviation = np.sqrt(weights @ np.square(people.values - mean))
    theirs = people.values[members].mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.where(deviation > 0.0, (theirs - mean) / deviation, 0.0)
    for at in np.argsort(-np.abs(apart), kind="stable"):
        yield Difference(DIMENSIONS[at], float(theirs[at]), float(mean[at]), float(apart[at]))
