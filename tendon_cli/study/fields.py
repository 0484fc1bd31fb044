"""The kinds of field that a study has: a number with a unit, which may be an axis, and tables that few studies have.

Each number field has one validator, which turns whatever the file says into `Values` or into one fault.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.study.values import MAX_AXIS_LENGTH, Grid, Values
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
)

_LARGEST_INTEGER = 1000  # bits; a float64 has room for 1023
_GRID_KEYS = ("from", "to", "num", "spacing")


def fault(problem: str, hint: str | None = None) -> PydanticCustomError:
    """A fault of one field, in our words; `study.load` gives it its place."""
    return PydanticCustomError("tendon", "{problem}", {"problem": problem, "hint": hint})


def nearest(name: str, known: Iterable[str], cutoff: float = 0.5) -> str | None:
    """A hint with the known name most like one that is not known."""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=cutoff)
    return f'did you mean "{near[0]}"?' if near else None


@dataclass(frozen=True)
class Number:
    """Marks a field as a number of the quantity `name`, within [low, high]; without `axis` it takes one value only."""

    name: str
    low: float
    high: float
    axis: bool = True

    @property
    def quantity(self) -> Quantity:
        """The quantity that this number is one of."""
        return QUANTITIES[self.name]

    def single_valued(self) -> Number:
        """The same number where no list and no grid may stand."""
        return replace(self, axis=False)

    def read(self, value: object) -> Values | None:
        """What the file says, as `Values`; None (a key not given) stays None. Raises PydanticCustomError."""
        if value is None or isinstance(value, Values):
            return value
        if isinstance(value, (list, tuple, dict)) and not self.axis:
            raise fault(f"a list or grid cannot stand here, expected one value, {self._wanted}")
        if isinstance(value, dict):
            return Values(self._grid(value), is_axis=True)
        if isinstance(value, (list, tuple)):
            return Values(self._list(value), is_axis=True)
        return Values.of(self._bounded(self._measure(value)))

    @property
    def _wanted(self) -> str:
        return wanted(self.quantity.dimension)

    def _measure(self, value: object) -> Measure:
        dimension = self.quantity.dimension
        if isinstance(value, str):
            try:
                return parse_measure(value, dimension)
            except UnitError as error:
                raise fault(error.problem, error.hint) from None
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise fault(f"{described(value)} is not a number, expected {self._wanted}")
        if isinstance(value, int) and value.bit_length() > _LARGEST_INTEGER:
            raise fault(f"{described(value)} is out of range, expected {self._wanted}")
        if not math.isfinite(value):
            raise fault(f"{value} is not a finite number, expected {self._wanted}")
        return measure_of_number(float(value), dimension)

    def _bounded(self, measure: Measure) -> float:
        value = measure.si
        if self.low <= value <= self.high:
            return value
        unit = f" {measure.unit.symbol}".removesuffix(" 1")
        number = to_float(Fraction(measure.text))
        given = f"{number:.6g}{unit}" if math.isfinite(number) else f"{shorten(measure.text)}{unit}"
        low, high = (to_float(Fraction(bound) / measure.unit.factor) for bound in (self.low, self.high))
        if value < self.low == 0.0:
            raise fault(f"{given} is negative, expected 0{unit} or more")
        if value <= 0.0 < self.low:
            raise fault(f"{given} is impossible, expected a value above 0{unit}")
        raise fault(f"{given} is out of range, expected {low:.6g} to {high:.6g}{unit}")

    def _list(self, items: list[Any] | tuple[Any, ...]) -> tuple[float, ...]:
        if not items:
            raise fault("an empty list, expected at least one value")
        if any(isinstance(item, (list, tuple, dict)) for item in items):
            raise fault("a list inside a list, expected a list of single values")
        numbers = tuple(self._bounded(self._measure(item)) for item in items)
        seen: set[float] = set()
        for item, number in zip(items, numbers, strict=True):
            if number in seen:
                raise fault(f"{described(item)} stands in the list twice, expected each value once")
            seen.add(number)
        return numbers

    def _grid(self, table: dict[Any, Any]) -> Grid:
        unknown = [described(key) for key in table if key not in _GRID_KEYS]
        missing = [key for key in _GRID_KEYS[:3] if key not in table]
        if unknown or missing:
            found = f"unknown {unknown[0]}" if unknown else f'"{missing[0]}" is missing'
            problem = f"{found} in a grid, expected from, to, num and optionally spacing"
            raise fault(problem, None if "from" in table else f"a single value is {self._wanted}")
        num, spacing = _count(table["num"]), table.get("spacing", "linear")
        if not isinstance(spacing, str) or spacing not in ("linear", "log"):
            raise fault(f'spacing = {described(spacing)}, expected "linear" or "log"')
        grid = Grid(self._end(table, "from"), self._end(table, "to"), num, log=spacing == "log")
        start, stop = grid.start.si, grid.stop.si
        if grid.log and min(start, stop) <= 0.0:
            raise fault("a log grid that reaches zero, expected from and to above zero")
        if num > 1 and start == stop:
            raise fault("a grid of several values whose from and to are equal, expected two different ends")
        return grid

    def _end(self, table: dict[Any, Any], name: str) -> Measure:
        """One end of a grid; its faults say which end it is."""
        try:
            measure = self._measure(table[name])
            self._bounded(measure)
        except PydanticCustomError as error:
            context = error.context or {}
            raise fault(f"{name}: {context['problem']}", context["hint"]) from None
        return measure

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """One plain validator: one fault gives one error."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """What an editor may complete and check."""
        one = self._json_scalar()
        grid = {
            "type": "object",
            "properties": {
                "from": one,
                "to": one,
                "num": {"type": "integer", "minimum": 1, "maximum": MAX_AXIS_LENGTH},
                "spacing": {"enum": ["linear", "log"], "default": "linear"},
            },
            "required": ["from", "to", "num"],
            "additionalProperties": False,
        }
        several = {"type": "array", "items": one, "minItems": 1, "uniqueItems": True}
        quantity = self.quantity
        unit = "" if quantity.unit == "1" else f" A bare number is in {quantity.unit}."
        return {
            "description": f"{quantity.symbol}: {quantity.long_name}.{unit}",
            "x-unit": quantity.unit,
            "anyOf": [one, several, grid] if self.axis else [one],
        }

    def _json_scalar(self) -> dict[str, Any]:
        units = "|".join(re.escape(unit) for unit in known_units(self.quantity.dimension))
        optional = "?" if self.quantity.dimension == "number" else ""
        pattern = rf"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{{1,3}})?\s*({units}){optional}\s*$"
        number = {"type": "number", "minimum": self.low, "maximum": self.high}
        return {"anyOf": [number, {"type": "string", "pattern": pattern}]}


def _count(num: object) -> int:
    """How many values a grid has."""
    if isinstance(num, bool) or not isinstance(num, int) or num < 1:
        raise fault(f"num = {described(num)} is not a count, expected a whole number of at least 1")
    if num > MAX_AXIS_LENGTH:
        count = f"{num:,}" if num < 10**15 else described(num)
        raise fault(f"num = {count} is too many, expected {MAX_AXIS_LENGTH:,} values in an axis at most")
    return num


@dataclass(frozen=True)
class Later:
    """Marks a list of tables that few studies have: `kind` builds its type, for those and for the schema only."""

    kind: Callable[[], Any]

    @cached_property
    def _adapter(self) -> TypeAdapter[Any]:
        return TypeAdapter(self.kind())

    def read(self, value: object) -> Any:
        """What the file says, as the type has it; raises ValidationError."""
        return value if value == () else self._adapter.validate_python(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return handler(self._adapter.core_schema)
