"""Marks of fields that hold a reading of a gauge: a tension, or the torque of the motor.

The unit says which; whether it is that of the gauge that the study names is checked once the whole
study is known.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from tendon_cli.studies.fields import SingleField, fault
from tendon_cli.studies.number import ErrorField, NumberField, parts_of_text
from tendon_cli.studies.values import StudyNumber
from tendon_cli.units import Measure, UnitError, parse_measure

DIMENSIONS = ("force", "torque")
"""Dimensions of readings."""


def dimension_of(text: object) -> str | None:
    """Return the dimension of a reading as a text states it; None if it states none."""
    if not isinstance(text, str):
        return None
    for dimension in DIMENSIONS:
        try:
            parse_measure(text, dimension)
        except UnitError:
            continue
        return dimension
    return None


def _dimensions_in(value: object) -> Iterator[str]:
    """Yield the dimensions of all readings in what a study states for one key."""
    if isinstance(value, Mapping):
        for inner in value.values():
            yield from _dimensions_in(inner)
    elif isinstance(value, (list, tuple)):
        for inner in value:
            yield from _dimensions_in(inner)
    elif isinstance(value, str):
        for part in parts_of_text(value):
            dimension = dimension_of(part)
            if dimension is not None:
                yield dimension


class _ReadingMark(SingleField):
    """Mark of a field that is a tension or a torque."""

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Dimensions that the number may have."""
        return DIMENSIONS

    def read(self, value: object) -> Any:
        """Return what the file says, a number with the dimension in which it is stated.

        Raises:
            PydanticCustomError: The value is not possible, or it mixes tensions and torques.
        """
        number = super().read(value)
        if not isinstance(number, StudyNumber) or isinstance(value, StudyNumber):
            return number
        stated = set(_dimensions_in(value))
        if len(stated) > 1:
            raise fault("mixes tensions and torques, expected one of both")
        return replace(number, dimension=next(iter(stated), None))

    def measure(self, value: object, dimension: str | None = None) -> Measure:
        """Return one number with its unit, in N or N m.

        Raises:
            PydanticCustomError: The value is not a finite number of one of these dimensions.
        """
        return super().measure(value, dimension or dimension_of(value))


@dataclass(frozen=True)
class SingleReadingField(_ReadingMark, SingleField):
    """Mark of a field that is one reading."""


@dataclass(frozen=True)
class ReadingField(_ReadingMark, NumberField):
    """Mark of a field that is a reading and may be an axis."""


@dataclass(frozen=True)
class ReadingErrorField(_ReadingMark, ErrorField):
    """Mark of a field that is the standard deviation of a reading's error."""
