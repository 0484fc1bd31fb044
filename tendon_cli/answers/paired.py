"""Two answers judged by one fresh sample: whom one suit serves and the other does not.

A share of a sample is known within a few percent, the difference of two shares among the same
members far better: only members whom one suit alone serves add to its variance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tendon_cli.answers.people import GroupWindows
from tendon_cli.engine.windows.coverage import normalise
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import Placement, question_of
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.verification import Verified, Verifier
from tendon_cli.model.kinematics import Flags
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.studies.answer_draws import for_answer
from tendon_cli.studies.study import Study
from tendon_cli.verbs.answer_record import ChoiceRecord

_TWO_SIDED_95 = 1.959963984540054
"""Quantile of the normal distribution for an interval of 95 %."""
_HALVINGS = 60
"""Steps in which the end of an interval is found."""


@dataclass(frozen=True)
class PairedShares:
    """Shares that two suits serve among the same members of a fresh sample."""

    first: float
    """Share that the first suit serves at its pretension."""
    second: float
    """Share that the second one serves."""
    interval: tuple[float, float]
    """95 % interval of the second share less the first among all who could have been drawn."""
    of_first: tuple[float, float]
    """95 % interval of the first share alone."""
    of_second: tuple[float, float]
    """95 % interval of the second share alone."""
    members: int
    """Number of members."""
    kind: Literal["persons", "draws"]
    """Noun for the members."""
    moved: tuple[MovedMembers, MovedMembers]
    """Members whom the second alone serves, and those whom the first alone serves."""


@dataclass(frozen=True)
class MovedMembers:
    """Members of a fresh sample whom one of two suits alone serves."""

    share: float
    """Share of all, by weight."""
    members: int
    """Number of them."""
    farthest: UnservedMember | None
    """The one whom the other suit misses by most."""


@dataclass(frozen=True)
class UnservedMember:
    """A member of a fresh sample whom one of two suits alone serves."""

    numbers: dict[str, float]
    """Numbers of the member by key, SI."""
    limit: str
    """Name of the limit by which the other suit does not serve the member."""


def paired_shares(
    studies: tuple[Study, Study], choices: tuple[ChoiceRecord, ChoiceRecord]
) -> PairedShares | str:
    """Judge a choice of each of two answers, at its pretension, by the fresh sample of both.

    Args:
        studies: Studies of both answers.
        choices: Choice of each.

    Returns:
        The shares; or the reason in words why the answers have no sample in common.
    """
    questions = (question_of(studies[0]), question_of(studies[1]))
    judges = [Verifier.of(Solver(question)) for question in questions]
    first, second = judges
    if first is None or second is None:
        return "no fresh sample judges both of them"
    if any(choice.pretension is None for choice in choices):
        return "one of them has no pretension"
    reason = _why_other_sample(questions[0].study, questions[1].study)
    if reason is not None:
        return reason
    # A suit that takes longer to judge asks fewer of the same members.
    members = min(len(first.sample), len(second.sample))
    first = first.thinned(members)
    second = second.thinned(members)
    pretensions = [float(choice.pretension or 0.0) for choice in choices]
    points = [
        question.points(np.array([choice.choice]))
        for question, choice in zip(questions, choices, strict=True)
    ]
    (before,) = first.judge(points[0], np.array(pretensions[:1]))
    (now,) = second.judge(points[1], np.array(pretensions[1:]))
    sample = before.sample
    weights = normalise(sample.weighting)
    moved = []
    for judge, choice, judged, pretension in (
        (first, points[0], before, pretensions[0]),
        (second, points[1], now, pretensions[1]),
    ):
        is_moved = ~judged.is_served & (before.is_served | now.is_served)
        farthest = _farthest(judge, choice, judged, is_moved, pretension)
        moved.append(MovedMembers(float(weights @ is_moved), int(is_moved.sum()), farthest))
    gained, lost = moved
    # A sample of n members whose strata weigh W and have n_s members counts as 1 / Σ W²/n_s.
    size = np.bincount(sample.strata)
    weight = np.bincount(sample.strata, weights)
    count = 1.0 / float(np.sum(np.square(weight) / size))
    return PairedShares(
        first=before.value,
        second=now.value,
        interval=paired_interval(gained.share, lost.share, count),
        of_first=before.interval,
        of_second=now.interval,
        members=len(sample),
        kind="persons" if sample.draws_persons else "draws",
        moved=(gained, lost),
    )


def _why_other_sample(first: Study, second: Study) -> str | None:
    """Say why two studies have different fresh samples; None if the members are the same."""
    if first.design.verify != second.design.verify:
        return "their fresh samples differ in size (design.verify)"
    if (first.people is None) != (second.people is None):
        return "only one of them has people"
    if first.people is not None and second.people is not None:
        bodies = first.people.fresh(first.design.verify)
        others = second.people.fresh(second.design.verify)
        is_same = np.array_equal(bodies.values, others.values)
        if not is_same or not np.array_equal(bodies.weighting, others.weighting):
            return "they draw different persons"
    return why_other_draws(first, second)


def why_other_draws(first: Study, second: Study) -> str | None:
    """Say why a draw of one study is not that of the other by the same name; None if it is."""
    first = for_answer(first)
    second = for_answer(second)
    if list(first.to_draw) != list(second.to_draw):
        return "they draw different numbers"
    seeds = [None if study.drawing is None else study.drawing.seed for study in (first, second)]
    if seeds[0] != seeds[1]:
        return "their draws have different seeds"
    return None


def _farthest(
    judge: Verifier, choice: Points, judged: Verified, is_meant: Flags, pretension: float
) -> UnservedMember | None:
    """Return the member, of some that are not served, whose window lies farthest from a pretension.

    Args:
        judge: Judge of the suit that does not serve them.
        choice: The suit.
        judged: Judgement on it.
        is_meant: True for these members, (members,).
        pretension: Pretension of the suit, N.
    """
    if not is_meant.any():
        return None
    low, high = judged.windows
    missing = np.fmax(low - pretension, pretension - high)  # (members,), N
    missing = np.where(np.isnan(missing), np.inf, missing)
    member = int(np.argmax(np.where(is_meant, missing, -np.inf)))
    question = judge.solver.question
    of_member = question.within_groups(question.groups.conditions_of(np.array([member])))
    placement = Placement(given=pretension)
    solver = judge.solver.for_question(replace(of_member, placement=placement))
    windows = GroupWindows.of(solver, choice)
    is_low = np.isnan(windows.low[0]) or windows.low[0] > pretension
    code = (windows.low_by if is_low else windows.high_by)[0]
    numbers = judged.sample.axis.numbers
    return UnservedMember(
        {key: float(values[member]) for key, values in numbers.items()}, LIMIT_NAMES[code]
    )


def paired_interval(gained: float, lost: float, count: float) -> tuple[float, float]:
    """Return the 95 % interval of the difference of two shares among the same members.

    It holds the differences that a score test does not refute (Tango 1998, Stat Med 17, 891), and
    has room where nobody is gained or lost.

    Args:
        gained: Share that the second alone serves.
        lost: Share that the first alone serves.
        count: Effective size of the sample.
    """
    middle = gained - lost
    ends = []
    for farthest in (-1.0, 1.0):
        inside = middle
        outside = farthest
        for _ in range(_HALVINGS):
            between = 0.5 * (inside + outside)
            if abs(_score(between, gained, lost, count)) <= _TWO_SIDED_95:
                inside = between
            else:
                outside = between
        ends.append(inside)
    return ends[0], ends[1]


def _score(difference: float, gained: float, lost: float, count: float) -> float:
    """Return the score of a difference of shares: its distance in standard deviations.

    The standard deviation is that of the likeliest shares with this difference: of those lost it is
    the larger root of 2q² + Bq + C = 0.
    """
    linear = (2.0 - gained + lost) * difference - gained - lost
    constant = -lost * difference * (1.0 - difference)
    root = math.sqrt(max(linear**2 - 8.0 * constant, 0.0))
    likeliest = max((root - linear) / 4.0, 0.0)
    variance = (2.0 * likeliest + difference * (1.0 - difference)) / count
    distance = gained - lost - difference
    if variance <= 0.0:
        return 0.0 if distance == 0.0 else math.copysign(math.inf, distance)
    return distance / math.sqrt(variance)


def unpaired_interval(
    first: float,
    first_interval: Sequence[float],
    second: float,
    second_interval: Sequence[float],
) -> tuple[float, float]:
    """Return the 95 % interval of the difference of two shares of independent samples.

    It follows from the interval of each (Newcombe 1998, Stat Med 17, 873, method 10).
    """
    low_first, high_first = first_interval
    low_second, high_second = second_interval
    difference = second - first
    below = math.hypot(second - low_second, high_first - first)
    above = math.hypot(high_second - second, first - low_first)
    return difference - below, difference + above
