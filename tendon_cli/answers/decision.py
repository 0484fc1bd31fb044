"""The rule by which an answer names one choice before all others, and what ties with it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from tendon_cli.answers.question_facts import choice_values
from tendon_cli.engine.windows.candidates import without_effect
from tendon_cli.engine.windows.order import MOST_TIED, Order, last_stage
from tendon_cli.engine.windows.question import Question
from tendon_cli.engine.windows.solutions import NEEDED, Solutions
from tendon_cli.model.kinematics import Rows
from tendon_cli.studies.space.axis import split_side
from tendon_cli.studies.study import Study
from tendon_cli.verbs.answer_record import DecisionRecord

_CHOSEN = ("spool.ratio", "spring.stiffness")
"""Keys of the numbers that decide most how wide a window is."""


def decision_record(
    question: Question, solved: Solutions, choices: Solutions, best: Solutions, accuracy: float
) -> DecisionRecord:
    """Return the rule by which a choice is named first.

    Args:
        question: The question.
        solved: All choices, as its own sample has them.
        choices: Choices that may be named, before any proof.
        best: The choice.
        accuracy: Accuracy of setting as a length of both tendons, m.
    """
    order = Order.of(question)
    with_window = choices.select(choices.feasible)
    counted = with_window
    if not question.sample.sets_by_sample:
        counted = solved.select(solved.feasible)
    left = [len(counted), *map(len, order.left(counted))]
    rules: list[str] = [*order.rules[:-1]]
    if order.is_front:
        rules = [*order.rules[: -1 - len(order.goals)], "front"]
        left = [*left[: len(rules)], 1]
    deciding = [place for place, (before, after) in enumerate(pairwise(left)) if after < before]
    decided_by = deciding[-1] if deciding else None
    record = DecisionRecord(
        rule=None if decided_by is None else rules[decided_by],
        choices=left[0] if decided_by is None else left[decided_by],
        after=[rules[place] for place in deciding[:-1]],
        left=left[-1],
        is_settable=bool(best.settable[0] >= 1.0),
        can_be_set=bool(best.can_be_set[0]),
        by_default=_by_default(question),
        needed=NEEDED * accuracy,
        ties=1,
        tied=[],
        broken_by=[],
        no_effect=without_effect(question, solved),
    )
    if left[-1] > 1:
        tied = order.left(with_window)[-1]
        rank = order.rank(with_window.points, tied)
        in_order = tied[np.argsort(rank)]
        record.ties = left[-1]
        record.tied = [
            choice_values(question, with_window.points, row) for row in in_order[:MOST_TIED]
        ]
        record.broken_by = _broken_by(order, with_window, tied)
    return record


def _by_default(question: Question) -> dict[str, float]:
    """Return the numbers that a designer chooses and that have their default values, SI."""
    axes = (*question.choices.axes, *question.conditions.axes)
    varied = {split_side(key)[0] for axis in axes for key in axis.keys}
    of_sides = {split_side(key)[0] for key in question.choices.keys_of_sides}
    stated = question.study.numbers
    default = Study().numbers
    return {
        key: float(default[key].array[0])
        for key in _CHOSEN
        if key not in varied | of_sides and np.array_equal(stated[key].array, default[key].array)
    }


def _broken_by(order: Order, choices: Solutions, tied: Rows) -> list[str]:
    """Return what breaks a tie: goals such as the motor torque, then the axes."""
    least = tied
    broken_by = []
    for goal in order.tie_breakers:
        scores = choices.select(least).scores((goal,))
        left = least[last_stage(scores, order.question.sample.tie)]
        if len(left) < len(least):
            broken_by.append(goal.column)
        least = left
    if len(least) > 1:
        columns = choices.points.columns
        axes = sorted(order.question.choices.axes, key=lambda axis: axis.key)
        broken_by += [axis.key for axis in axes if len(np.unique(columns[axis.column][least])) > 1]
    return broken_by
