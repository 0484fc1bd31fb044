"""Numbers that a study takes as exact: what a usual error of each would do to the window.

A derivative of an end of the window (`sensitivity.py`) times the usual standard deviation of the
number is the standard deviation of that end, to first order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tendon_cli import say
from tendon_cli.answer_record import ExactRecord, SensitivityRecord
from tendon_cli.space.axis import split_side
from tendon_cli.studies.study import keys
from tendon_cli.windows.question import Question

_MEASURED = "usual with a tape and scales on a wearer"
_CATALOGUE = "usual tolerance of a part"
_BODY = "scatter between persons"


@dataclass(frozen=True)
class UsualDeviation:
    """Usual standard deviation of a number."""

    size: float
    """Deviation in SI, or as a share of the number."""
    source: str
    """Origin of the number that deviates."""
    is_share: bool = True
    """True for a share of the number."""
    words: str = ""
    """The deviation in words, if they are not its size with a unit."""

    def of(self, value: float) -> float:
        """Return the deviation of a number from its value, both SI."""
        return self.size * abs(value) if self.is_share else self.size

    def text(self, key: str) -> str:
        """Return the deviation in words: "5 mm", "20 %", "a factor of 2"."""
        if self.words:
            return self.words
        if self.is_share:
            return say.percent(self.size)
        return say.quantity(keys()[key].quantity, self.size)


_ANCHOR = UsualDeviation(5e-3, _MEASURED, is_share=False)
_MASS = UsualDeviation(0.05, _MEASURED)
_LENGTH = UsualDeviation(0.02, _MEASURED)

USUAL_DEVIATIONS = {
    "arm.a1": _ANCHOR,
    "arm.b1": _ANCHOR,
    "arm.a2": _ANCHOR,
    "arm.b2": _ANCHOR,
    "arm.elbow_radius": UsualDeviation(3e-3, _MEASURED, is_share=False),
    "arm.forearm_mass": _MASS,
    "load.mass": _MASS,
    "arm.forearm_com": _LENGTH,
    "arm.load_distance": _LENGTH,
    "tendon.length": _LENGTH,
    "tendon.youngs_modulus": UsualDeviation(0.1, _CATALOGUE),
    "spring.stiffness": UsualDeviation(0.05, _CATALOGUE),
    "sheath.friction": UsualDeviation(0.2, _CATALOGUE),
    "spool.ratio": UsualDeviation(0.01, _CATALOGUE),
    "anchor.stiffness": UsualDeviation(math.log(2.0), _BODY, words="a factor of 2"),
    "joint.stiffness": UsualDeviation(0.4, _BODY, is_share=False),
    "joint.rest_angle": UsualDeviation(math.radians(10.0), _BODY, is_share=False),
}
"""Usual standard deviations by the common keys of numbers."""


def exact_numbers(
    question: Question, sensitivities: Sequence[SensitivityRecord]
) -> list[ExactRecord]:
    """Return the effect of usual errors of the numbers that a question takes as exact.

    Numbers that the study does not state, and those that it draws, takes from a body or varies as
    conditions, are left out.

    Args:
        question: The question.
        sensitivities: Derivatives of the ends of the window of the choice named first.

    Returns:
        A record of each number, the one that moves an end most first.
    """
    stated = {split_side(key)[0] for key in question.study.numbers}
    varied = {
        key
        for axis in question.conditions.axes
        if axis.role == "draw" or axis.key in axis.numbers
        for key in axis.numbers
    }
    records: dict[str, ExactRecord] = {}
    for slope in sensitivities:
        key = slope.key
        common = split_side(key)[0]
        if common not in USUAL_DEVIATIONS or common not in stated or key in varied:
            continue
        usual = USUAL_DEVIATIONS[common]
        deviation = usual.of(slope.value)
        if key not in records:
            records[key] = ExactRecord(
                key=key,
                value=slope.value,
                deviation=deviation,
                deviation_words=usual.text(common),
                source=usual.source,
                moves_from=None,
                moves_to=None,
            )
        change = slope.slope * deviation
        if slope.end == "from":
            records[key].moves_from = change
        else:
            records[key].moves_to = change
    moving = [record for record in records.values() if largest_move(record) > 0.0]
    return sorted(moving, key=lambda record: -largest_move(record))


def largest_move(record: ExactRecord) -> float:
    """Return the larger change of either end by the usual error of a number, by magnitude, N."""
    return max(abs(record.moves_from or 0.0), abs(record.moves_to or 0.0))
