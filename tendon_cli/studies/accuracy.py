"""Accuracy with which a suit can be set: a length of tendon, or a tension that is read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import GetJsonSchemaHandler
from pydantic_core import CoreSchema

from tendon_cli.studies.fields import (
    BARE_NUMBER,
    FieldMark,
    SingleField,
    dimension_of,
    fault,
    hint_to_write,
)
from tendon_cli.units import SI_UNIT, UnitError, described, parse_measure

_EXPECTED = 'a length of tendon such as "2 mm", or a tension such as "5 N"'
_LENGTH = SingleField("tolerance_length", 0.0, 0.1)
_TENSION = SingleField("pretension", 0.0, 1e4, is_reading=True)


@dataclass(frozen=True)
class Accuracy:
    """Accuracy of setting: a length of both tendons or a tension; the other one is None."""

    length: float | None
    """Length of both tendons, m."""
    tension: float | None
    """Tension of the kind that the study reads, N, or torque, N m."""
    dimension: str = "force"
    """Dimension of what is read: "force" or "torque"."""

    def document(self) -> str:
        """Return the accuracy as a study file would say it, in SI, exactly."""
        if self.length is not None:
            return f"{self.length!r} m"
        return f"{self.tension!r} {SI_UNIT[self.dimension]}"


class AccuracyField(FieldMark):
    """Mark of a field that is a length or a tension; the unit says which."""

    def read(self, value: object) -> Accuracy:
        """Return what the file says as `Accuracy`.

        Raises:
            PydanticCustomError: The value is neither a length nor a tension within the bounds.
        """
        if isinstance(value, Accuracy):
            return value
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if is_number and value == 0:
            return Accuracy(length=0.0, tension=None)
        number = repr(value) if is_number else ""
        hint = None
        if isinstance(value, str):
            dimension = dimension_of(value)
            if dimension is not None:
                tension = _TENSION.bounded(parse_measure(value, dimension))
                return Accuracy(None, tension, dimension)
            try:
                return Accuracy(_LENGTH.bounded(parse_measure(value, "length")), None)
            except UnitError as error:
                hint = error.hint
            number = value.strip()
        if BARE_NUMBER.fullmatch(number):
            hint = hint_to_write([*_LENGTH.in_units(number), *_TENSION.in_units(number)])
        problem = f"{described(value)} is neither a length nor a tension, expected {_EXPECTED}"
        raise fault(problem, hint)

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        of_length = _LENGTH.text_schema()
        of_tension = _TENSION.text_schema()
        return {"anyOf": [of_length, of_tension, {"const": 0}]}
