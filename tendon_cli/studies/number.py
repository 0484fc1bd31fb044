"""Mark of a number that may be an axis: one value, a list, a grid, or an uncertain number."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

from pydantic import GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError

from tendon_cli.studies.fields import (
    LONGEST,
    PLUS_MINUS,
    TO,
    SingleField,
    fault,
    fault_inside,
    two_numbers,
)
from tendon_cli.studies.magnitude import Slip, spread_slip
from tendon_cli.studies.values import MAX_AXIS_LENGTH, Grid, StudyNumber, Uncertain, si_document
from tendon_cli.units import Measure, described, terminating, to_float

_UNIFORM = ("value", "tolerance")
"""Keys of an uncertain number with a uniform distribution."""
_NORMAL = ("mean", "std")
"""Keys of an uncertain number with a normal distribution."""


@dataclass(frozen=True)
class NumberField(SingleField):
    """Mark of a field that is a number and may be an axis."""

    uncertain: bool = True
    """True if the number may be an interval, or have a distribution."""

    def form(self, value: object) -> StudyNumber:
        """Return what the file says: one value, a list, a grid, or an uncertain number."""
        if isinstance(value, dict):
            return self._table(value)
        if isinstance(value, (list, tuple)):
            return self._list(value)
        if isinstance(value, str) and len(value) <= LONGEST:
            middle_and_spread = two_numbers(value, PLUS_MINUS)
            if middle_and_spread is not None:
                return self._plus_minus(*middle_and_spread)
            ends = two_numbers(value, TO)
            if ends is not None:
                return self._between(*ends)
        return super().form(value)

    def _table(self, table: dict[Any, Any]) -> StudyNumber:
        """Return a grid, an interval or an uncertain number."""
        for names in (_UNIFORM, _NORMAL):
            if table.keys() & set(names):
                return self._uncertain(table, names)
        if self.uncertain and table.keys() == {"from", "to"}:
            ends = self._interval(table)
            slips = self._slips_of_ends(table, ends)
            return StudyNumber(ends, is_axis=True, is_interval=True, slips=slips)
        grid = self._grid(table)
        return StudyNumber(grid, is_axis=True, slips=self._slips_of_ends(table, grid))

    def _slips_of_ends(self, table: dict[Any, Any], grid: Grid) -> tuple[Slip, ...]:
        """Return the slips of both ends of a grid or an interval."""
        return self.slips(
            ("from", table["from"], grid.start),
            ("to", table["to"], grid.stop),
        )

    # --- Lists and grids -------------------------------------------------------------------------

    def _list(self, items: list[Any] | tuple[Any, ...]) -> StudyNumber:
        """Return the values of a list, with the slips among them."""
        if not items:
            raise fault("an empty list, expected at least one value")
        if any(isinstance(item, (list, tuple, dict)) for item in items):
            raise fault("a list inside a list, expected a list of single values")
        numbers: list[float] = []
        slips: list[Slip] = []
        for at, item in enumerate(items):
            value, slips_of_item = self.number(item, f"item {at + 1}")
            numbers.append(value)
            slips += slips_of_item
        if len(set(numbers)) < len(numbers):
            twice = next(item for at, item in enumerate(items) if numbers[at] in numbers[:at])
            raise fault(f"{described(twice)} is in the list twice, expected each value once")
        return StudyNumber(tuple(numbers), is_axis=True, slips=tuple(slips))

    def _grid(self, table: dict[Any, Any]) -> Grid:
        """Return the grid of a table with from, to, num or step, and optionally spacing."""
        length = "step" if "step" in table and "num" not in table else "num"
        expected = "in a grid, expected from, to, num or step, and optionally spacing"
        hint = None if "from" in table else f"a single value is {self.wanted}"
        _check_keys(table, ("from", "to", length), expected, hint, optional="spacing")
        spacing = table.get("spacing", "linear")
        if spacing not in ("linear", "log"):
            raise fault(f'spacing = {described(spacing)}, expected "linear" or "log"')
        num = _count(table["num"]) if length == "num" else None
        first, last = self._ends(table)
        if num is None:
            num = self._num_from_step(first, last, table["step"], spacing)
        grid = Grid(first, last, num, log=spacing == "log")
        if grid.log and min(first.si, last.si) <= 0.0:
            raise fault("a log grid that reaches zero, expected from and to above zero")
        if grid.num > 1 and first.si == last.si:
            raise fault(
                "a grid of several values with equal from and to, expected two different ends"
            )
        return grid

    def _num_from_step(self, first: Measure, last: Measure, step: object, spacing: str) -> int:
        """Return the number of values of a grid with a step.

        The range is divided in rational numbers, and a step that misses its end is refused.
        """
        if spacing == "log":
            hint = "a log grid grows by a factor, not by a step"
            raise fault("a step in a log grid, expected num", hint)
        try:
            size = self.measure(step).exact
        except PydanticCustomError as error:
            raise fault_inside("step", error) from None
        if size <= 0:
            raise fault(f"step: {described(step)} is not a size, expected one above zero")
        steps = abs(last.exact - first.exact) / size
        if steps.denominator > 1 and steps < MAX_AXIS_LENGTH:
            holds = f"which holds {to_float(steps):.6g} steps"
            problem = f"step: {described(step)} does not divide the range, {holds}"
            raise fault(
                problem, f"num = {max(2, round(steps) + 1)} instead of step reaches both ends"
            )
        return _count(int(steps) + 1)

    def _ends(self, table: dict[Any, Any]) -> tuple[Measure, Measure]:
        """Return both ends of a grid or an interval."""
        return self._inner(table, "from"), self._inner(table, "to")

    def _inner(self, table: dict[Any, Any], name: str) -> Measure:
        """Return the value at a key of a grid or an uncertain number; a fault names this key."""
        try:
            measure = self.measure(table[name])
            self.bounded(measure)
        except PydanticCustomError as error:
            raise fault_inside(name, error) from None
        return measure

    # --- Intervals and uncertain numbers ---------------------------------------------------------

    def _interval(self, table: dict[Any, Any]) -> Grid:
        """Return the two ends of `{ from, to }`, which means every value between them."""
        low, high = self._ends(table)
        if low.exact == high.exact:
            hint = f"write {low.quoted} for this one value"
            raise fault("an interval with equal ends", hint)
        if low.exact > high.exact:
            hint = f"write {{ from = {high.quoted}, to = {low.quoted} }}, or a single value"
            raise fault("an interval whose from is not below its to", hint)
        return Grid(low, high, 2)

    def _uncertain(self, table: dict[Any, Any], names: tuple[str, str]) -> StudyNumber:
        """Return `{ value, tolerance }`, which is uniform, or `{ mean, std }`, which is normal."""
        expected = "in an uncertain number, expected value and tolerance, or mean and std"
        _check_keys(table, names, expected)
        middle_name, spread_name = names
        is_uniform = names == _UNIFORM
        middle = self._inner(table, middle_name)
        try:
            spread, stated_spread = self._spread(
                table[spread_name], middle, may_be_share=is_uniform
            )
        except PydanticCustomError as error:
            raise fault_inside(spread_name, error) from None
        if is_uniform:
            self._check_reach(middle, spread)
        document = {
            middle_name: si_document(middle.si, self.quantity.dimension),
            spread_name: stated_spread,
        }
        kind: Literal["uniform", "normal"] = "uniform" if is_uniform else "normal"
        slips = self.slips((middle_name, table[middle_name], middle))
        slips += self._spread_slips(spread_name, table[spread_name])
        return self._distributed(kind, middle.exact, spread, document, slips)

    def _spread_slips(self, name: str, value: object) -> tuple[Slip, ...]:
        """Return the slip of a tolerance or a standard deviation, if it is one."""
        is_share = isinstance(value, str) and value.strip().endswith("%")
        if is_share:
            return ()
        slip = spread_slip(self.name, self.measure(value), value, name)
        return () if slip is None else (slip,)

    def _check_reach(self, middle: Measure, tolerance: Fraction) -> None:
        """Raise PydanticCustomError if a tolerance reaches beyond the bounds of the number."""
        for end in (middle.exact - tolerance, middle.exact + tolerance):
            if not self.low <= to_float(end) <= self.high:
                value = to_float(end / middle.unit.factor)
                reached = f"{value:.6g} {middle.unit.symbol}".removesuffix(" 1")
                problem = f"tolerance: it reaches {reached}, which is impossible"
                raise fault(problem, "make it narrower")

    def _plus_minus(self, middle: str, spread: str) -> StudyNumber:
        """Return `a +/- b`, which is normal with the standard deviation b."""
        if spread.endswith("%") and not middle.endswith("%"):
            problem = f"{described(spread)} may be a share of the value or of 1"
            raise fault(problem, "write the standard deviation in the unit of the value")
        return self._uncertain({"mean": middle, "std": spread}, _NORMAL)

    def _between(self, low: str, high: str) -> StudyNumber:
        """Return `a to b`, which is uniform between the two."""
        first, last = self._ends({"from": low, "to": high})
        if first.exact > last.exact:
            given = described(f"{low} to {high}")
            hint = f'write "{high} to {low}"'
            raise fault(f"{given} goes from high to low, expected the lower end first", hint)
        middle = (first.exact + last.exact) / 2
        spread = (last.exact - first.exact) / 2
        document = f"{first.document()} to {last.document()}"
        slips = self.slips(("from", low, first), ("to", high, last))
        return self._distributed("uniform", middle, spread, document, slips)

    def _distributed(
        self,
        kind: Literal["uniform", "normal"],
        middle: Fraction,
        spread: Fraction,
        document: dict[str, Any] | str,
        slips: tuple[Slip, ...],
    ) -> StudyNumber:
        """Return an uncertain number; without any spread it is a number like any other."""
        if not self.uncertain:
            raise fault("the number cannot be uncertain here, expected one value, a list or a grid")
        if not spread:
            return StudyNumber.of(to_float(middle), slips)
        distribution = Uncertain(
            kind, to_float(middle), to_float(spread), self.low, self.high, document
        )
        return StudyNumber(
            (distribution.middle,), is_axis=False, uncertain=distribution, slips=slips
        )

    def _spread(
        self, value: object, middle: Measure, *, may_be_share: bool
    ) -> tuple[Fraction, float | str]:
        """Return a tolerance or a standard deviation, exact in SI, and as a study says it.

        A tolerance is a share of the value, such as "10 %", or has the dimension of the number. A
        bare number is refused as a tolerance: it may be meant as either.
        """
        dimension = self.quantity.dimension
        if may_be_share and isinstance(value, str) and value.strip().endswith("%"):
            share = self.measure(value, "number").exact
            if not 0 <= share <= 1:
                raise fault(f"{described(value)} is not possible, expected 0 % to 100 %")
            if share and not middle.exact:
                raise fault(f"{described(value)} of zero is zero, expected {self.wanted}")
            return abs(middle.exact) * share, f"{terminating(share * 100)} %"
        if may_be_share and (dimension == "number" or not isinstance(value, str)):
            raise fault(
                f'{described(value)} is not a share of the value, expected one such as "10 %"'
            )
        measure = self.measure(value)
        if measure.exact < 0:
            raise fault(f"{described(value)} is negative, expected 0 or more")
        return measure.exact, measure.document()

    # --- JSON schema -----------------------------------------------------------------------------

    def _json_choices(self) -> list[dict[str, Any]]:
        """Return the schemas of all forms that the number takes."""
        value = self._json_one()
        finite = self._json_finite()
        share = {
            "type": "string",
            "pattern": r"^\s*\+?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?\s*%\s*$",
        }
        count = {"type": "integer", "minimum": 1, "maximum": MAX_AXIS_LENGTH}
        spacing = {"enum": ["linear", "log"], "default": "linear"}
        exact = [
            value,
            {"type": "array", "items": value, "minItems": 1, "uniqueItems": True},
            schema_table({"from": finite, "to": finite, "num": count, "spacing": spacing}, 3),
            schema_table({"from": finite, "to": finite, "step": finite}, 3),
        ]
        if not self.uncertain:
            return exact
        quantity = finite["anyOf"][-1]["pattern"].removeprefix("^").removesuffix("$")
        return [
            *exact,
            schema_table({"value": finite, "tolerance": {"anyOf": [share, finite]}}, 2),
            schema_table({"mean": finite, "std": finite}, 2),
            schema_table({"from": finite, "to": finite}, 2),
            {"type": "string", "pattern": rf"^{quantity}(\+/-|\+-|±|\s+to\s+){quantity}$"},
        ]


@dataclass(frozen=True)
class ErrorField(NumberField):
    """Mark of a field that is an error around 0, of which a study states the standard deviation."""

    def form(self, value: object) -> StudyNumber:
        """Return the error as an uncertain number, from one standard deviation."""
        deviation = SingleField.form(self, value)
        if not deviation.single:
            return deviation
        spread = deviation.single
        document = si_document(spread, self.quantity.dimension)
        distribution = Uncertain("normal", 0.0, spread, -math.inf, math.inf, document)
        return StudyNumber((0.0,), is_axis=False, uncertain=distribution)

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the JSON schema of the standard deviation."""
        schema = super().__get_pydantic_json_schema__(core, handler)
        meaning = f"Standard deviation, drawn around 0, of {schema['description']}"
        return {**schema, "description": meaning, "anyOf": [self._json_one()]}


def _check_keys(
    table: dict[Any, Any],
    required: tuple[str, ...],
    expected: str,
    hint: str | None = None,
    optional: str = "",
) -> None:
    """Raise PydanticCustomError if a table has an unknown key, or lacks a required one."""
    wrong = [f"unknown {described(key)}" for key in table if key not in (*required, optional)]
    wrong += [f'"{name}" is missing' for name in required if name not in table]
    if wrong:
        raise fault(f"{wrong[0]} {expected}", hint)


def schema_table(properties: dict[str, Any], required: int) -> dict[str, Any]:
    """Return the JSON schema of a table.

    Args:
        properties: Schema of each key.
        required: Number of keys, from the first on, that must be given.
    """
    names = list(properties)[:required]
    return {
        "type": "object",
        "properties": properties,
        "required": names,
        "additionalProperties": False,
    }


def _count(num: object) -> int:
    """Return the number of values of a grid; raise PydanticCustomError if it is not possible."""
    if isinstance(num, bool) or not isinstance(num, int) or num < 1:
        raise fault(f"num = {described(num)} is not a count, expected a whole number of at least 1")
    if num > MAX_AXIS_LENGTH:
        count = f"{num:,}" if num < 10**15 else described(num)
        raise fault(
            f"num = {count} is too many, expected {MAX_AXIS_LENGTH:,} values in an axis at most"
        )
    return num
