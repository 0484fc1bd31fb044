"""The study's own arm, on which a suit is set, and the tension that a length of tendon is worth.

With people it is the mean man's, or that of the wearer on whom the anchors were measured.
"""

from __future__ import annotations

import numpy as np

from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import Question
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.setting import Reading, reading_per_length
from tendon_cli.studies.space.axis import Axis


def study_arm(question: Question, points: Points, whom: Axis | None = None) -> Design:
    """Return choices on the study's own arm, or on the bodies of all persons.

    Args:
        question: The question.
        points: The choices; at their pretensions if these matter.
        whom: Axis of the persons or draws; None for the study's own arm.
    """
    if whom is None:
        return question.designs(points, question.arm)
    under = {key: np.repeat(values, len(whom)) for key, values in question.arm.items()}
    return question.designs(points, {**under, **whom.numbers})


def of_designs(values: Array, count: int) -> Array:
    """Return values that broadcast to `count` designs as one for each, (count,)."""
    return np.broadcast_to(np.asarray(values).reshape(-1), (count,)).copy()


def tension_per_length(question: Question, points: Points) -> Array:
    """Return the tension that is read of a length taken from both tendons, (choices,), N/m."""
    return of_designs(reading_per_length(study_arm(question, points)), len(points))


def own_f0(question: Question, points: Points, readings: Array) -> Array:
    """Return readings of choices as columns of pretension have them, (..., choices), N.

    Where the gauge is the answer's own, they are F0 of the study's own arm.
    """
    if not question.sample.shows_own_f0:
        return readings
    return _own_reading(question, points).pretension(readings)


def given_pretensions(question: Question, points: Points) -> Array:
    """Return the given pretension as the question reads it, (choices,), N; NaN if none is given."""
    given = question.placement.given
    of_choices = np.full(len(points), np.nan if given is None else given)
    return as_read(question, points, of_choices) if question.placement.given_as_f0 else of_choices


def as_read(question: Question, points: Points, pretensions: Array) -> Array:
    """Return pretensions as columns have them as the question reads them, (choices,), N."""
    if not question.sample.shows_own_f0:
        return pretensions
    return _own_reading(question, points).shown(pretensions)


def _own_reading(question: Question, points: Points) -> Reading:
    """Return the reading of choices on the study's own arm, (choices,)."""
    reading = Reading.of(study_arm(question, points))
    count = len(points)
    return Reading(
        of_designs(reading.floor, count),
        of_designs(reading.gain, count),
        of_designs(reading.required, count),
        of_designs(reading.lowest, count),
    )
