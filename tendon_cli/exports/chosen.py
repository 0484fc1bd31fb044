"""A choice of an answer as the designs that are exported: on the study's own arm, under loads."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from tendon_cli.answers.answer import Answer
from tendon_cli.answers.choice_rows import choice_in_row
from tendon_cli.answers.text_bench import suit_words
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import Question, question_of
from tendon_cli.engine.windows.study_arm import as_read
from tendon_cli.errors import UsageError
from tendon_cli.model.design import Design
from tendon_cli.studies.space.axis import SAMPLE_AXES, Numbers
from tendon_cli.studies.space.space import Space
from tendon_cli.verbs.answer_record import AnswerRecord, ChoiceRecord, named_first

LOAD = "load.mass"


@dataclass(frozen=True, eq=False)
class ChosenSuit:
    """A choice of an answer at its pretension."""

    record: AnswerRecord
    question: Question
    choice: ChoiceRecord

    @classmethod
    def of(cls, answer: Answer, row: int | None) -> Self:
        """Return a choice of an answer.

        Args:
            answer: The answer.
            row: Its row in `choices.parquet`; None for the choice that the answer names first.

        Raises:
            UsageError: There is no such choice, or it has no pretension.
            InputError: A table is damaged.
        """
        record = answer.answer
        choice = named_first(record) if row is None else choice_in_row(answer, row)
        if choice is None or choice.pretension is None:
            raise UsageError(
                f"{record.name}: this choice has no pretension, so there is nothing to export",
                where="--choice",
                hint="`tendon show` lists the choices of an answer",
            )
        return cls(record, question_of(answer.study), choice)

    @property
    def words(self) -> str:
        """Name of the study with the choice: "suit: springs of 5 kN/m"."""
        return f"{self.record.name}: {suit_words(self.record.question, self.choice).words}"

    @cached_property
    def points(self) -> Points:
        """The choice at its pretension."""
        pretension = np.array([float(self.choice.pretension or 0.0)])
        points = self.question.points(np.array([self.choice.choice]))
        return points.at_pretension(as_read(self.question, points, pretension))

    @cached_property
    def space(self) -> Space:
        """All numbers of the suit on the study's own arm."""
        return self.question.choices.at(self.points.numbers, self.question.arm)

    @cached_property
    def conditions(self) -> Space:
        """Conditions without persons and draws: loads, postures, cases."""
        axes = [axis for axis in self.question.conditions.axes if axis.key not in SAMPLE_AXES]
        return Space(tuple(axes))

    @property
    def largest_load(self) -> float | None:
        """Largest load of the conditions, kg; None if none of them sets it."""
        loads = self.question.condition_numbers.get(LOAD)
        return None if loads is None else float(np.max(loads))

    def design(self, numbers: Numbers | None = None) -> Design:
        """Return the design on the study's own arm.

        Args:
            numbers: Numbers of conditions that take precedence, (conditions,) each; by default the
                least of each, as where the suit is set.

        Returns:
            Designs that broadcast to (1, conditions, 1, 1).
        """
        given = {} if numbers is None else numbers
        count = max((len(values) for values in given.values()), default=1)
        under = {key: np.repeat(values, count) for key, values in self.question.arm.items()}
        return self.question.designs(self.points, {**under, **given})


def without_friction(design: Design) -> Design:
    """Return a design whose sheaths have no friction, at the same pretension F0."""
    return replace(
        design,
        flexor=replace(design.flexor, friction=0.0),
        extensor=replace(design.extensor, friction=0.0),
    )


def scalar(value: Any) -> float:
    """Return a number of a single design."""
    return float(np.asarray(value).reshape(-1)[0])
