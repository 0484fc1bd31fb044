"""A number that may be an axis: one value, a list, a grid, or one that is uncertain."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

from pydantic_core import PydanticCustomError

from tendon_cli.studies.fields import Single, fault, within
from tendon_cli.studies.values import MAX_AXIS_LENGTH, Grid, Uncertain, Values, in_si
from tendon_cli.units import Measure, described, terminating, to_float

_UNIFORM, _NORMAL = ("value", "tolerance"), ("mean", "std")
_PLUS_MINUS, _TO = re.compile(r"\+/-|\+-|±"), re.compile(r"\s+to\s+")
_LONGEST, _SIGNS = 400, "+-.0123456789eE"
"""Of text with two numbers; and what numbers are made of. One unit behind both is that of both."""


@dataclass(frozen=True)
class Number(Single):
    """Marks a field as a number that may be an axis; and where `uncertain`, that may have a distribution instead."""

    uncertain: bool = True

    def read(self, value: object) -> Values | None:
        """What the file says, as `Values`; None (a key not given) stays None. Raises PydanticCustomError."""
        if isinstance(value, dict):
            return self._table(value)
        if isinstance(value, (list, tuple)):
            return Values(self._list(value), is_axis=True)
        if isinstance(value, str) and len(value) <= _LONGEST:
            for pattern, distribution in ((_PLUS_MINUS, self._plus_minus), (_TO, self._between)):
                if len(parts := pattern.split(value, maxsplit=1)) > 1:
                    first, second = (part.strip() for part in parts)
                    unit = second.lstrip(_SIGNS).strip() if not first.strip(_SIGNS) else ""
                    return distribution(first if unit in ("", "%") else f"{first} {unit}", second)
        return super().read(value)

    def _table(self, table: dict[Any, Any]) -> Values:
        """A grid, an interval or an uncertain number."""
        for names in (_UNIFORM, _NORMAL):
            if table.keys() & set(names):
                return self._uncertain(table, names)
        if self.uncertain and table.keys() == {"from", "to"}:
            return Values(self._interval(table), is_axis=True, is_interval=True)
        return Values(self._grid(table), is_axis=True)

    def _list(self, items: list[Any] | tuple[Any, ...]) -> tuple[float, ...]:
        if not items:
            raise fault("an empty list, expected at least one value")
        if any(isinstance(item, (list, tuple, dict)) for item in items):
            raise fault("a list inside a list, expected a list of single values")
        numbers = tuple(self.number(item) for item in items)
        if len(set(numbers)) < len(numbers):
            twice = next(item for at, item in enumerate(items) if numbers[at] in numbers[:at])
            raise fault(f"{described(twice)} stands in the list twice, expected each value once")
        return numbers

    def _grid(self, table: dict[Any, Any]) -> Grid:
        length = ("num",) if "num" in table or "step" not in table else ("step",)
        expected = "in a grid, expected from, to, num or step, and optionally spacing"
        hint = None if "from" in table else f"a single value is {self.wanted}"
        _check_keys(table, ("from", "to", *length), expected, hint, optional="spacing")
        spacing = table.get("spacing", "linear")
        if spacing not in ("linear", "log"):
            raise fault(f'spacing = {described(spacing)}, expected "linear" or "log"')
        num = _count(table["num"]) if "num" in table else 0
        first, last = self._inner(table, "from"), self._inner(table, "to")
        grid = Grid(
            first,
            last,
            num or self._steps(first, last, table["step"], spacing),
            log=spacing == "log",
        )
        if grid.log and min(first.si, last.si) <= 0.0:
            raise fault("a log grid that reaches zero, expected from and to above zero")
        if grid.num > 1 and first.si == last.si:
            raise fault(
                "a grid of several values whose from and to are equal, expected two different ends"
            )
        return grid

    def _interval(self, table: dict[Any, Any]) -> Grid:
        """`{ from, to }`: every value between two ends."""
        low, high = self._inner(table, "from"), self._inner(table, "to")
        if low.exact >= high.exact:
            hint = f"write {{ from = {high.quoted}, to = {low.quoted} }}, or a single value"
            raise fault("an interval that does not go up, expected from below to", hint)
        return Grid(low, high, 2)

    def _inner(self, table: dict[Any, Any], name: str) -> Measure:
        """A value inside a grid or an uncertain number; its faults say which it is."""
        try:
            measure = self.measure(table[name])
            self.bounded(measure)
        except PydanticCustomError as error:
            raise within(name, error) from None
        return measure

    def _steps(self, first: Measure, last: Measure, step: object, spacing: str) -> int:
        """How many values a grid of this step has; in rational numbers, so that a step that misses the end shows."""
        if spacing == "log":
            raise fault(
                "a step in a log grid, expected num",
                "a log grid goes on by a factor, not by a step",
            )
        try:
            size = self.measure(step).exact
        except PydanticCustomError as error:
            raise within("step", error) from None
        if size <= 0:
            raise fault(f"step: {described(step)} is not a size, expected one above zero")
        steps = abs(last.exact - first.exact) / size
        if steps.denominator > 1 and steps < MAX_AXIS_LENGTH:
            problem = f"step: {described(step)} does not divide the range, it goes {to_float(steps):.6g} times into it"
            raise fault(problem, f"num = {max(2, round(steps) + 1)} instead of step ends at both")
        return _count(int(steps) + 1)

    def _uncertain(self, table: dict[Any, Any], names: tuple[str, str]) -> Values:
        """`{ value, tolerance }`, uniform, or `{ mean, std }`, normal."""
        _check_keys(
            table, names, "in an uncertain number, expected value and tolerance, or mean and std"
        )
        is_uniform, middle = names == _UNIFORM, self._inner(table, names[0])
        try:
            spread, width = self._spread(table[names[1]], middle, may_be_share=is_uniform)
        except PydanticCustomError as error:
            raise within(names[1], error) from None
        for end in (middle.exact - spread, middle.exact + spread) if is_uniform else ():
            if not self.low <= to_float(end) <= self.high:
                reached = (
                    f"{to_float(end / middle.unit.factor):.6g} {middle.unit.symbol}".removesuffix(
                        " 1"
                    )
                )
                raise fault(
                    f"tolerance: it reaches {reached}, which is impossible", "make it narrower"
                )
        document = dict(zip(names, (in_si(middle.si, self.quantity.dimension), width), strict=True))
        return self._distributed(
            "uniform" if is_uniform else "normal", middle.exact, spread, document
        )

    def _distributed(
        self,
        kind: Literal["uniform", "normal"],
        middle: Fraction,
        spread: Fraction,
        document: dict[str, Any] | str,
    ) -> Values:
        """An uncertain number; one of no width is a number like any other."""
        if not self.uncertain:
            raise fault(
                "an uncertain number cannot stand here, expected one value, a list or a grid"
            )
        if not spread:
            return Values.of(to_float(middle))
        known = Uncertain(kind, to_float(middle), to_float(spread), self.low, self.high, document)
        return Values((known.middle,), is_axis=False, uncertain=known)

    def _plus_minus(self, middle: str, spread: str) -> Values:
        """`a +/- b`: normal with the standard deviation b."""
        if spread.endswith("%") and not middle.endswith("%"):
            problem = f"{described(spread)} may be a share of the value or of 1"
            raise fault(problem, "write the standard deviation in the unit of the value")
        return self._uncertain({"mean": middle, "std": spread}, _NORMAL)

    def _between(self, low: str, high: str) -> Values:
        """`a to b`: uniform between the two."""
        first, last = (self._inner({"from": low, "to": high}, name) for name in ("from", "to"))
        if first.exact > last.exact:
            hint = f'write "{high} to {low}"'
            raise fault(
                f"{described(f'{low} to {high}')} goes down, expected the lower end first", hint
            )
        ends = " to ".join(str(end.document()) for end in (first, last))
        return self._distributed(
            "uniform", (first.exact + last.exact) / 2, (last.exact - first.exact) / 2, ends
        )

    def _spread(
        self, value: object, middle: Measure, *, may_be_share: bool
    ) -> tuple[Fraction, float | str]:
        """A tolerance or a standard deviation, exact and in SI, and as a study says it.

        A tolerance is a share of the value, "10 %", or has its dimension; a bare number could be meant as either.
        """
        dimension = self.quantity.dimension
        if may_be_share and isinstance(value, str) and value.strip().endswith("%"):
            share = self.measure(value, "number").exact
            if not 0 <= share <= 1:
                raise fault(f"{described(value)} is not possible, expected 0 % to 100 %")
            if share and not middle.exact:
                raise fault(f"{described(value)} of zero is nothing, expected {self.wanted}")
            return abs(middle.exact) * share, f"{terminating(share * 100)} %"
        if may_be_share and (dimension == "number" or not isinstance(value, str)):
            raise fault(
                f'{described(value)} is not a share of the value, expected one such as "10 %"'
            )
        measure = self.measure(value)
        if measure.exact < 0:
            raise fault(f"{described(value)} is negative, expected 0 or more")
        return measure.exact, measure.document()

    def _json_choices(self) -> list[dict[str, Any]]:
        one, single = self._json_scalar(), self._json_one()
        share = {
            "type": "string",
            "pattern": r"^\s*\+?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?\s*%\s*$",
        }
        count = {"type": "integer", "minimum": 1, "maximum": MAX_AXIS_LENGTH}
        spacing = {"enum": ["linear", "log"], "default": "linear"}
        choices = [
            single,
            {"type": "array", "items": single, "minItems": 1, "uniqueItems": True},
            schema_table({"from": one, "to": one, "num": count, "spacing": spacing}, 3),
            schema_table({"from": one, "to": one, "step": one}, 3),
        ]
        if not self.uncertain:
            return choices
        inner = one["anyOf"][-1]["pattern"].removeprefix("^").removesuffix("$")
        return [
            *choices,
            schema_table({"value": one, "tolerance": {"anyOf": [share, one]}}, 2),
            schema_table({"mean": one, "std": one}, 2),
            schema_table({"from": one, "to": one}, 2),
            {"type": "string", "pattern": rf"^{inner}(\+/-|\+-|±|\s+to\s+){inner}$"},
        ]


def _check_keys(
    table: dict[Any, Any],
    required: tuple[str, ...],
    expected: str,
    hint: str | None = None,
    optional: str = "",
) -> None:
    """Raises PydanticCustomError for a table that has not just these keys."""
    wrong = [f"unknown {described(key)}" for key in table if key not in (*required, optional)]
    wrong += [f'"{name}" is missing' for name in required if name not in table]
    if wrong:
        raise fault(f"{wrong[0]} {expected}", hint)


def schema_table(properties: dict[str, Any], required: int) -> dict[str, Any]:
    """The schema of a table of which the first few keys are required."""
    names = list(properties)[:required]
    return {
        "type": "object",
        "properties": properties,
        "required": names,
        "additionalProperties": False,
    }


def _count(num: object) -> int:
    """How many values a grid has."""
    if isinstance(num, bool) or not isinstance(num, int) or num < 1:
        raise fault(f"num = {described(num)} is not a count, expected a whole number of at least 1")
    if num > MAX_AXIS_LENGTH:
        count = f"{num:,}" if num < 10**15 else described(num)
        raise fault(
            f"num = {count} is too many, expected {MAX_AXIS_LENGTH:,} values in an axis at most"
        )
    return num
