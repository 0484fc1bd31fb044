"""The kinds of field that a study has: one number with a unit, tables that few studies have, and the words of a fault.

What a number that may be an axis can say beyond one value stands in `number`.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    TypeAdapter,
    WithJsonSchema,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.studies.values import Values
from tendon_cli.units import (
    Measure,
    UnitError,
    described,
    known_units,
    measure_of_number,
    parse_measure,
    shorten,
    to_float,
    wanted,
    with_unit,
)


def fault(problem: str, hint: str | None = None) -> PydanticCustomError:
    """A fault of one field, in our words; `study.load` gives it its place."""
    return PydanticCustomError("tendon", "{problem}", {"problem": problem, "hint": hint})


def within(name: str, error: PydanticCustomError) -> PydanticCustomError:
    """The fault of something inside a field, which says what it is of."""
    context = error.context or {}
    return fault(f"{name}: {context['problem']}", context["hint"])


def nearest(name: str, known: Iterable[str], cutoff: float = 0.5) -> str | None:
    """A hint with the known name most like one that is not known."""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=cutoff)
    return f'did you mean "{near[0]}"?' if near else None


def one_or_many(
    item: dict[str, Any], most: int | None = None, *, least: int = 1, each_once: bool = False
) -> tuple[Any, ...]:
    """What makes a field of a tuple take one word where a list of them may stand, with the schema of an `item`."""
    bounds = (
        {"minItems": least}
        | ({"maxItems": most} if most else {})
        | ({"uniqueItems": True} if each_once else {})
    )
    schema = {"anyOf": [item, {"type": "array", "items": item, **bounds}]}
    once = (AfterValidator(_each_once),) if each_once else ()
    return (
        BeforeValidator(lambda value: [value] if isinstance(value, str) else value),
        *once,
        WithJsonSchema(schema),
    )


def _each_once(words: tuple[str, ...]) -> tuple[str, ...]:
    twice = [word for word in words if words.count(word) > 1]
    if twice:
        raise fault(f'"{twice[0]}" stands in the list twice, expected each word once')
    return words


class Mark:
    """Marks a field whose one validator, `read`, says whatever is wrong in one fault."""

    def read(self, value: object) -> Any:
        """What the file says, as the study has it; raises PydanticCustomError."""
        raise NotImplementedError

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)


@dataclass(frozen=True)
class OneOf(Mark):
    """Marks a field as one of some words, or a list of several: an axis, unless the field `is_list` in any case."""

    words: tuple[str, ...]
    is_list: bool = False

    def read(self, value: object) -> str | tuple[str, ...] | None:
        """A word as it is, a list as a tuple; raises PydanticCustomError."""
        several = (
            list(value) if isinstance(value, (list, tuple)) else [] if value is None else [value]
        )
        wrong = [word for word in several if not isinstance(word, str) or word not in self.words]
        if wrong:
            given = " and ".join(map(described, wrong[:9])) + (" are" if wrong[1:] else " is")
            expected = " or ".join(f'"{each}"' for each in self.words)
            raise fault(
                f"{given} not possible, expected {expected}", nearest(str(wrong[0]), self.words)
            )
        if not several and value is not None:
            raise fault("an empty list, expected at least one value")
        words = _each_once(tuple(map(str, several)))
        return (
            words
            if self.is_list or isinstance(value, (list, tuple))
            else words[0]
            if words
            else None
        )

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        one = {"enum": list(self.words)}
        return {"anyOf": [one, {"type": "array", "items": one, "minItems": 1, "uniqueItems": True}]}


def whole(low: int, high: int) -> tuple[Any, ...]:
    """What makes a field take a whole number from low to high, or its digits as the command line has it."""

    def read(value: object) -> int:
        if isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 20:
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            raise fault(f"{described(value)} is not a whole number")
        if not low <= value <= high:
            raise fault(f"{described(value)} is out of range, expected {low:,} to {high:,}")
        return value

    return BeforeValidator(read), WithJsonSchema(
        {"type": "integer", "minimum": low, "maximum": high}
    )


@dataclass(frozen=True)
class Single(Mark):
    """Marks a field as one number of the quantity `name`, within [low, high]."""

    name: str
    low: float
    high: float
    word: str | None = None
    """A word that stands for infinity, if it may be one."""

    @property
    def quantity(self) -> Quantity:
        """The quantity that this number is one of."""
        return QUANTITIES[self.name]

    @property
    def wanted(self) -> str:
        """What an error says was expected."""
        return wanted(self.quantity.dimension)

    def read(self, value: object) -> Values | None:
        """What the file says, as `Values`; None (a key not given) stays None. Raises PydanticCustomError."""
        if value is None or isinstance(value, Values):
            return value
        if isinstance(value, (list, tuple, dict)):
            raise fault(f"{described(value)} cannot stand here, expected one value, {self.wanted}")
        return Values.of(self.number(value))

    def number(self, value: object) -> float:
        """One value in SI, infinity where the word for it stands; raises PydanticCustomError."""
        return (
            math.inf
            if value is not None and value == self.word
            else self.bounded(self.measure(value))
        )

    def measure(self, value: object, dimension: str | None = None) -> Measure:
        """One number and its unit; raises PydanticCustomError for anything else, a bare angle but 0 included."""
        dimension = dimension or self.quantity.dimension
        if isinstance(value, str):
            try:
                return parse_measure(value, dimension)
            except UnitError as error:
                raise fault(error.problem, error.hint) from None
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise fault(f"{described(value)} is not a number, expected {self.wanted}")
        if not abs(value) < 1e300:
            raise fault(f"{described(value)} is not a finite number, expected {self.wanted}")
        if dimension == "angle" and value != 0:
            problem = f"{value!r} may be degrees or radians, expected {self.wanted}"
            raise fault(problem, f"write {with_unit(repr(value), dimension)}")
        return measure_of_number(float(value), dimension)

    def bounded(self, measure: Measure) -> float:
        """The value in SI; raises PydanticCustomError outside of the bounds."""
        value = measure.si
        if self.low <= value <= self.high:
            return value
        unit = f" {measure.unit.symbol}".removesuffix(" 1")
        number = to_float(Fraction(measure.text))
        given = f"{number:.6g}{unit}" if math.isfinite(number) else f"{shorten(measure.text)}{unit}"
        low, high = (
            to_float(Fraction(bound) / measure.unit.factor) for bound in (self.low, self.high)
        )
        kind = (
            "negative"
            if value < self.low == 0.0
            else "impossible"
            if value <= 0.0 < self.low
            else "out of range"
        )
        raise fault(f"{given} is {kind}, expected {low:.6g} to {high:.6g}{unit}")

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """What an editor may complete and check."""
        quantity = self.quantity
        unit = "" if quantity.unit == "1" else f" A bare number is in {quantity.unit}."
        unit = " An angle has a unit." if quantity.dimension == "angle" else unit
        meaning = f"{quantity.symbol}: {quantity.long_name}.{unit}"
        return {"description": meaning, "x-unit": quantity.unit, "anyOf": self._json_choices()}

    def _json_choices(self) -> list[dict[str, Any]]:
        return [self._json_one()]

    def _json_one(self) -> dict[str, Any]:
        scalar = self._json_scalar()
        return scalar if self.word is None else {"anyOf": [*scalar["anyOf"], {"const": self.word}]}

    def _json_scalar(self) -> dict[str, Any]:
        units = "|".join(re.escape(unit) for unit in known_units(self.quantity.dimension))
        optional = "?" if self.quantity.dimension == "number" else ""
        pattern = rf"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{{1,3}})?\s*({units}){optional}\s*$"
        number = {"type": "number", "minimum": self.low, "maximum": self.high}
        if self.quantity.dimension == "angle":
            number = {"const": 0}
        return {"anyOf": [number, {"type": "string", "pattern": pattern}]}


@dataclass(frozen=True)
class Later(Mark):
    """Marks a list of tables that few studies have: `kind` builds its type, for those and for the schema only."""

    kind: Callable[[], Any]

    @cached_property
    def _adapter(self) -> TypeAdapter[Any]:
        return TypeAdapter(self.kind())

    def read(self, value: object) -> Any:
        """What the file says, as the type has it; raises ValidationError."""
        return value if value == () else self._adapter.validate_python(value)

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return handler(self._adapter.core_schema)
