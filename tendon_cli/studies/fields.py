"""Marks of the fields of a study: one number with a unit, words, and tables that few studies have.

`number` has the mark of a number that may be an axis, and so say more than one value.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from pydantic import (
    AfterValidator,
    BeforeValidator,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    WithJsonSchema,
)
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from tendon_cli.quantities import PLAUSIBLE, QUANTITIES, Quantity
from tendon_cli.studies.magnitude import Slip, hint_at_units, slip_of, units_that_fit
from tendon_cli.studies.values import StudyNumber
from tendon_cli.units import (
    UNITS,
    Measure,
    UnitError,
    described,
    known_units,
    measure_of_number,
    parse_measure,
    shorten,
    to_float,
    usual_units,
    wanted,
)

_MOST_NAMED = 9
"""Largest number of wrong words that a fault names."""
_EXTREMES = {"max", "min", "peak"}
"""Words of names that are easily taken for each other."""
_MOST_MEANT = 4
"""Largest number of names that one unknown name may mean, in a hint."""
_LARGEST = 1e300
"""Bound below which a bare number counts as finite."""

READINGS = ("force", "torque")
"""Dimensions of what a gauge may show: a tension, or the torque of the motor."""
PLUS_MINUS = re.compile(r"\+/-|\+-|±")
TO = re.compile(r"\s+to\s+")
LONGEST = 400
"""Length of the longest text that is searched for two numbers."""
_NUMBER_CHARACTERS = "+-.0123456789eE"
"""Characters that numbers consist of; a unit follows them."""
BARE_NUMBER = re.compile(r"[+-]?(\d{1,20}\.?\d{0,20}|\.\d{1,20})([eE][+-]?\d{1,2})?")
"""Pattern of a number without a unit."""

# --- Faults --------------------------------------------------------------------------------------


def fault(problem: str, hint: str | None = None) -> PydanticCustomError:
    """Return the fault of one field, in our words; `load.study_from` adds its place."""
    return PydanticCustomError("tendon", "{problem}", {"problem": problem, "hint": hint})


def fault_inside(name: str, error: PydanticCustomError) -> PydanticCustomError:
    """Return the fault of a value inside a field, with the name of this value before it."""
    context = error.context or {}
    return fault(f"{name}: {context['problem']}", context["hint"])


def hint_to_write(values: Sequence[str]) -> str | None:
    """Return the advice to write one of some values; None if there are none."""
    listed = " or ".join(f'"{value}"' for value in values)
    return f"write {listed}" if listed else None


def hint_at_nearest(name: str, known: Iterable[str], cutoff: float = 0.5) -> str | None:
    """Return a hint with the known name most like an unknown one; None if none is like it.

    If known names say the unknown one with more words, it may be any of them. What a name is of
    stands last in it: if some of them end in the same word, it is one of these.

    Args:
        name: The unknown name.
        known: Names to choose from.
        cutoff: Smallest similarity, 0 to 1, as `difflib.get_close_matches` takes it.
    """
    names = list(known)
    words = set(name.split("_")) - _EXTREMES
    longer = [known_name for known_name in names if words and words < set(known_name.split("_"))]
    same_noun = [known_name for known_name in longer if known_name.split("_")[-1] in words]
    is_any_of_them = 1 < len(longer) <= _MOST_MEANT
    if name not in names and (is_any_of_them or len(same_noun) == 1):
        longer = same_noun or longer
        listed = " or ".join(f'"{known_name}"' for known_name in longer)
        return f"did you mean {listed}?"
    near = difflib.get_close_matches(name, names, n=1, cutoff=cutoff)
    return f'did you mean "{near[0]}"?' if near else None


def two_numbers(text: str, separator: re.Pattern[str]) -> tuple[str, str] | None:
    """Split a text into two numbers; None if it does not hold the separator.

    A unit after the second number alone is that of both. A percent sign is not: it may mean a
    share of the first.
    """
    parts = separator.split(text, maxsplit=1)
    if len(parts) == 1:
        return None
    first, second = (part.strip() for part in parts)
    has_unit = first.strip(_NUMBER_CHARACTERS) != ""
    if not has_unit:
        unit = second.lstrip(_NUMBER_CHARACTERS).strip()
        if unit not in ("", "%"):
            first = f"{first} {unit}"
    return first, second


def parts_of_text(text: str) -> tuple[str, ...]:
    """Return the numbers of a text with one number, or with two as "a +/- b" or "a to b"."""
    if len(text) > LONGEST:
        return ()
    return two_numbers(text, PLUS_MINUS) or two_numbers(text, TO) or (text,)


def dimension_of(text: object) -> str | None:
    """Return the dimension of a reading as a text states it; None if it states none."""
    if isinstance(text, str):
        for dimension in READINGS:
            with suppress(UnitError):
                return parse_measure(text, dimension).unit.dimension
    return None


def _dimensions_in(value: object) -> Iterator[str]:
    """Yield the dimensions of all readings in what a study states for one key."""
    if isinstance(value, str):
        yield from filter(None, map(dimension_of, parts_of_text(value)))
    elif isinstance(value, Mapping):
        yield from _dimensions_in([*value.values()])
    elif isinstance(value, (list, tuple)):
        for inner in value:
            yield from _dimensions_in(inner)


# --- Words and whole numbers ---------------------------------------------------------------------


def one_or_many(
    item: dict[str, Any], most: int | None = None, *, least: int = 1, each_once: bool = False
) -> tuple[Any, ...]:
    """Return annotations of a tuple field that also takes one word in place of a list.

    Args:
        item: JSON schema of one word.
        most: Largest length of a list; None for no bound.
        least: Smallest length of a list.
        each_once: True if a list must not repeat a word.
    """
    array: dict[str, Any] = {"type": "array", "items": item, "minItems": least}
    if most is not None:
        array["maxItems"] = most
    if each_once:
        array["uniqueItems"] = True
    listed = BeforeValidator(lambda value: [value] if isinstance(value, str) else value)
    schema = WithJsonSchema({"anyOf": [item, array]})
    if each_once:
        return listed, AfterValidator(_check_each_once), schema
    return listed, schema


def _check_each_once(words: tuple[str, ...]) -> tuple[str, ...]:
    """Return the words; raise PydanticCustomError if one is repeated."""
    for word in words:
        if words.count(word) > 1:
            raise fault(f'"{word}" is in the list twice, expected each word once')
    return words


def whole_number(low: int, high: int) -> tuple[Any, ...]:
    """Return annotations of a field that takes a whole number in [low, high].

    The field also takes its digits as text, as they come from the command line.
    """

    def read(value: object) -> int:
        if isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 20:
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            raise fault(f"{described(value)} is not a whole number")
        if not low <= value <= high:
            raise fault(f"{described(value)} is out of range, expected {low:,} to {high:,}")
        return value

    schema = {"type": "integer", "minimum": low, "maximum": high}
    return BeforeValidator(read), WithJsonSchema(schema)


# --- Marks ---------------------------------------------------------------------------------------


class FieldMark:
    """Mark of a field whose one validator, `read`, puts all that is wrong into one fault."""

    def read(self, value: object) -> Any:
        """Return what the file says as the study holds it.

        Raises:
            PydanticCustomError: The value is not possible.
        """
        raise NotImplementedError

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)


@dataclass(frozen=True)
class WordField(FieldMark):
    """Mark of a field that is one of some words, or a list of several.

    A list is an axis, unless `is_list`.
    """

    words: tuple[str, ...]
    """The possible words."""
    is_list: bool = False
    """True if the field is a list even of one word, and so no axis."""

    def read(self, value: object) -> str | tuple[str, ...] | None:
        """Return a word as it is and a list as a tuple.

        Raises:
            PydanticCustomError: A word is unknown or repeated, or the list is empty.
        """
        if value is None:
            return () if self.is_list else None
        items = list(value) if isinstance(value, (list, tuple)) else [value]
        wrong = [item for item in items if not isinstance(item, str) or item not in self.words]
        if wrong:
            verb = "are" if len(wrong) > 1 else "is"
            given = " and ".join(map(described, wrong[:_MOST_NAMED]))
            expected = " or ".join(f'"{word}"' for word in self.words)
            hint = hint_at_nearest(str(wrong[0]), self.words)
            raise fault(f"{given} {verb} not possible, expected {expected}", hint)
        if not items:
            raise fault("an empty list, expected at least one value")
        words = _check_each_once(tuple(map(str, items)))
        if self.is_list or isinstance(value, (list, tuple)):
            return words
        return words[0]

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        word = {"enum": list(self.words)}
        several = {"type": "array", "items": word, "minItems": 1, "uniqueItems": True}
        return {"anyOf": [word, several]}


@dataclass(frozen=True)
class SingleField(FieldMark):
    """Mark of a field that is one number of a quantity, within bounds."""

    name: str
    """Name of the quantity."""
    low: float
    """Smallest value, SI."""
    high: float
    """Largest value, SI."""
    word: str | None = None
    """Word for infinity; None if the number must be finite."""
    is_reading: bool = False
    """True for the reading of a gauge, whose unit says whether it is a tension or a torque.

    Whether it is that of the gauge that the study names is checked once the whole study is known.
    """

    @property
    def quantity(self) -> Quantity:
        """Quantity of the number, with its dimension, unit and symbol."""
        return QUANTITIES[self.name]

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Dimensions that the number may have."""
        return READINGS if self.is_reading else (self.quantity.dimension,)

    @property
    def wanted(self) -> str:
        """Phrase for what an error expected, such as "a length such as 40 mm"."""
        return wanted(self.quantity.dimension)

    def read(self, value: object) -> StudyNumber | None:
        """Return what the file says as `StudyNumber`; None for a key that is not given.

        A reading has the dimension in which it is stated.

        Raises:
            PydanticCustomError: The value is none of the forms of the field, out of bounds, or
                mixes tensions and torques.
        """
        if value is None or isinstance(value, StudyNumber):
            return value
        number = self.form(value)
        if not self.is_reading:
            return number
        stated = set(_dimensions_in(value))
        if len(stated) > 1:
            raise fault("mixes tensions and torques, expected one of both")
        return replace(number, dimension=next(iter(stated), None))

    def form(self, value: object) -> StudyNumber:
        """Return what the file says by one of the forms that the field takes: one value."""
        if isinstance(value, (list, tuple, dict)):
            raise fault(
                f"{described(value)} is not possible here, expected one value, {self.wanted}"
            )
        return StudyNumber.of(*self.number(value))

    def number(self, value: object, place: str = "") -> tuple[float, tuple[Slip, ...]]:
        """Return one value in SI, infinity for the word that means it, and its slip if it is one.

        Args:
            value: The value as the study has it.
            place: Place in the value of the key, for its slip.

        Raises:
            PydanticCustomError: The value is not a number within the bounds.
        """
        if value is not None and value == self.word:
            return math.inf, ()
        measure = self.measure(value)
        return self.bounded(measure), self.slips((place, value, measure))

    def slips(self, *values: tuple[str, object, Measure]) -> tuple[Slip, ...]:
        """Return the slips among values, each with its place, as written, and as understood."""
        found = (
            slip_of(self.name, measure, value, place, self.word) for place, value, measure in values
        )
        return tuple(slip for slip in found if slip is not None)

    def measure(self, value: object, dimension: str | None = None) -> Measure:
        """Return one number with its unit.

        Args:
            value: A quantity as text, or a bare number in SI; a bare angle must be 0.
            dimension: Dimension of the number; None for that of the field.

        Raises:
            PydanticCustomError: The value is not a finite number of this dimension.
        """
        if dimension is None and self.is_reading:
            dimension = dimension_of(value)
        dimension = dimension or self.quantity.dimension
        if isinstance(value, str):
            try:
                return parse_measure(value, dimension)
            except UnitError as error:
                hint = error.hint
                if dimension == self.quantity.dimension and BARE_NUMBER.fullmatch(value.strip()):
                    hint = hint_to_write(self.in_units(value.strip()))
                raise fault(error.problem, hint) from None
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise fault(f"{described(value)} is not a number, expected {self.wanted}")
        if not abs(value) < _LARGEST:
            raise fault(f"{described(value)} is not a finite number, expected {self.wanted}")
        if dimension == "angle" and value != 0:
            problem = f"{value!r} may be degrees or radians, expected {self.wanted}"
            raise fault(problem, hint_to_write(self.in_units(repr(value))))
        return measure_of_number(float(value), dimension)

    def bounded(self, measure: Measure) -> float:
        """Return the value of a measure in SI, if it is within the bounds.

        Raises:
            PydanticCustomError: The value is outside of the bounds.
        """
        value = measure.si
        if self.low <= value <= self.high:
            return value
        if value < self.low == 0.0:
            kind = "negative"
        elif value <= 0.0 < self.low:
            kind = "impossible"
        else:
            kind = "out of range"
        unit = f" {measure.unit.symbol}".removesuffix(" 1")
        number = to_float(Fraction(measure.text))
        given = f"{number:.6g}" if math.isfinite(number) else shorten(measure.text)
        low = to_float(Fraction(self.low) / measure.unit.factor)
        high = to_float(Fraction(self.high) / measure.unit.factor)
        problem = f"{given}{unit} is {kind}, expected {low:.6g} to {high:.6g}{unit}"
        meant = units_that_fit(measure, *self.plausible)
        if self.word is not None and value > self.high:
            meant.append(self.word)
        raise fault(problem, hint_at_units(meant))

    @property
    def plausible(self) -> tuple[float, float]:
        """Smallest and largest plausible value, SI: all that is possible if no range is known."""
        return PLAUSIBLE.get(self.name, (self.low, self.high))

    def in_units(self, number: str) -> list[str]:
        """Return a bare number in the units in which it is possible, for a hint; none if in none.

        It is in the usual unit of the field, or else in one in which it is plausible. An angle may
        be in either of its units.
        """
        dimension = self.quantity.dimension
        if dimension in ("angle", "angular speed"):
            measures = [Measure(number, UNITS[symbol]) for symbol in usual_units(dimension)]
            possible = [one for one in measures if self.low <= one.si <= self.high]
            return [f"{number} {one.unit.symbol}" for one in possible]
        low, high = self.plausible
        usual = self.quantity.shown_in
        measure = Measure(number, UNITS[usual])
        if low <= measure.si <= high:
            return [f"{number} {usual}"]
        return units_that_fit(measure, max(low, self.low), min(high, self.high))[:1]

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the JSON schema by which an editor completes and checks the number."""
        quantity = self.quantity
        if quantity.dimension == "angle":
            unit = " An angle has a unit."
        elif quantity.unit == "1":
            unit = ""
        else:
            unit = f" A bare number is in {quantity.unit}."
        meaning = f"{quantity.symbol}: {quantity.long_name}.{unit}"
        return {"description": meaning, "x-unit": quantity.unit, "anyOf": self._json_choices()}

    def _json_choices(self) -> list[dict[str, Any]]:
        """Return the schemas of all forms that the field takes."""
        return [self._json_one()]

    def _json_one(self) -> dict[str, Any]:
        """Return the schema of one value: a finite number, or the word for infinity."""
        finite = self._json_finite()
        if self.word is None:
            return finite
        return {"anyOf": [*finite["anyOf"], {"const": self.word}]}

    def _json_finite(self) -> dict[str, Any]:
        """Return the schema of one finite number: bare, or text with a unit."""
        number: dict[str, Any] = {"type": "number", "minimum": self.low, "maximum": self.high}
        if self.quantity.dimension == "angle":
            number = {"const": 0}
        return {"anyOf": [number, self.text_schema()]}

    def text_schema(self) -> dict[str, Any]:
        """Return the schema of one finite number as text with a unit."""
        units = "|".join(
            re.escape(unit) for dimension in self.dimensions for unit in known_units(dimension)
        )
        optional = "?" if self.quantity.dimension == "number" else ""
        pattern = rf"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{{1,3}})?\s*({units}){optional}\s*$"
        return {"type": "string", "pattern": pattern}
