"""What may be asked of `tendon plot`, and its words turned into columns, units and sizes."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from tendon_cli.errors import UsageError
from tendon_cli.figures.product import Product
from tendon_cli.figures.style import COLUMN_WIDTH, PAGE_WIDTH
from tendon_cli.units import UNITS, UnitError, parse_measure, shorten

_NAMED_WIDTHS = {"column": COLUMN_WIDTH, "page": PAGE_WIDTH}
_SMALLEST, _LARGEST = 40.0, 1000.0
_SIZE = re.compile(r"([\d.]+)(?:\s*[x×]\s*([\d.]+))?\s*(mm|cm|in)?")


@dataclass(frozen=True)
class PlotRequest:
    """A figure as it is asked for; whatever is left out follows from the table."""

    quantities: tuple[str, ...] = ()
    """Columns to draw."""
    x: str | None = None
    """Column along x: an axis of the study, or in `states` any column of numbers."""
    colour: str | None = None
    """Axis with one colour per value."""
    panels: str | None = None
    """Axis with one panel per value."""
    where: tuple[str, ...] = ()
    """Filters, such as "load_mass = 5 kg"."""
    units: tuple[str, ...] = ()
    """Units to show, each for its dimension, such as "cm"."""
    format: str = "png"
    """png, svg or pdf."""
    size: str = "page"
    """"column" (85 mm), "page" (175 mm), a width, or width x height, such as "120 x 80 mm"."""

    @property
    def is_plain(self) -> bool:
        """Whether it leaves the choice of what to draw to the table."""
        return not (self.quantities or self.x or self.colour or self.panels)


def read_units(symbols: tuple[str, ...]) -> Mapping[str, str]:
    """The unit to show for each dimension; raises UsageError."""
    chosen: dict[str, str] = {}
    for symbol in symbols:
        unit = UNITS.get(symbol)
        if unit is None:
            near = difflib.get_close_matches(symbol, UNITS, n=1)
            hint = f'did you mean "{near[0]}"?' if near else f"known units: {', '.join(UNITS)}"
            raise UsageError(f'unknown unit "{shorten(symbol)}"', where="--unit", hint=hint)
        chosen[unit.dimension] = symbol
    return chosen


def read_size(text: str) -> tuple[float, float | None]:
    """Width and perhaps height of a figure in mm; raises UsageError."""
    if text in _NAMED_WIDTHS:
        return _NAMED_WIDTHS[text], None
    match = _SIZE.fullmatch(text.strip()) if len(text) < 60 else None
    unit = (match[3] or "mm") if match else "mm"
    try:
        sides = (
            [parse_measure(f"{side} {unit}", "length").si * 1e3 for side in match.groups()[:2] if side] if match else []
        )
    except UnitError:
        sides = []
    if not sides:
        hint = '"column", "page", "120 mm" or "120 x 80 mm"'
        raise UsageError(f'"{shorten(text)}" is not a size', where="--size", hint=hint)
    if not all(_SMALLEST <= side <= _LARGEST and math.isfinite(side) for side in sides):
        raise UsageError(f'"{shorten(text)}" is out of range', where="--size", hint="a side has 40 mm to 1000 mm")
    return sides[0], sides[1] if len(sides) > 1 else None


def find_column(product: Product, name: str, where: str) -> str:
    """A column by its name or by the dotted key of its axis; raises UsageError with the nearest name."""
    by_key = {axis.key: axis.column for axis in product.axes}
    known = product.table.schema.names
    if name in known:
        return name
    if name in by_key:
        return by_key[name]
    near = difflib.get_close_matches(name, [*known, *by_key], n=1, cutoff=0.5)
    hint = f'did you mean "{near[0]}"?' if near else f"columns: {', '.join(known)}"
    raise UsageError(f'the table has no column "{shorten(name)}"', where=where, hint=hint)


def find_numbers(product: Product, name: str, where: str) -> str:
    """A column of numbers by its name; raises UsageError."""
    column = find_column(product, name, where)
    if product.is_text(column):
        raise UsageError(f"{column} holds words, expected a column of numbers", where=where)
    return column
