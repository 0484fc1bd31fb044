"""Rows of a table as text for a terminal."""

from __future__ import annotations

import math
import textwrap
from typing import Any

import pyarrow as pa

from tendon_cli import say
from tendon_cli.cube.rows import TableRows

_MOST_BLOCKS = 3
"""Most blocks of columns below each other, unless columns are asked for by name."""
_DETAILS = ("_condition", "_direction", "_elbow_angle", "_time")
"""Ends of the names of columns that say where a limit binds, which are shown last."""


def rows_text(
    rows: TableRows, shown: pa.Table, total: int, width: int, *, has_all: bool = False
) -> str:
    """Return rows as a table in the units that people read; columns that do not fit come below.

    Columns that have no room in three blocks are named below.

    Args:
        rows: Rows with their columns and units.
        shown: Rows that are shown.
        total: Number of all rows.
        width: Characters in a line.
        has_all: True to show all columns, in their order.
    """
    names = list(rows.names)
    if not has_all:
        names.sort(key=lambda name: name.endswith(_DETAILS))
    columns = [_column_text(rows, name, shown[name].to_pylist()) for name in names]
    lines: list[str] = []
    blocks = 0
    while columns and (has_all or blocks < _MOST_BLOCKS):
        fitting = _fitting_columns(columns, width)
        if lines:
            lines.append("")
        lines += ["  ".join(row).rstrip() for row in zip(*columns[:fitting], strict=True)]
        columns = columns[fitting:]
        blocks += 1
    lines += ["", head_words(shown.num_rows, total)]
    if columns:
        hidden = ", ".join(names[-len(columns) :])
        words = f"{say.counted(len(columns), 'more column')}, which --columns and --csv show: "
        lines += ["", *textwrap.wrap(f"{words}{hidden}", width, break_on_hyphens=False)]
    return "\n".join(lines)


def head_words(shown: int, total: int) -> str:
    """Say how many of all rows are shown, and the option that shows all if some are not."""
    words = f"{shown:,} of {say.counted(total, 'row')}"
    return words if shown == total else f"{words}; --head {total} shows all"


def _fitting_columns(columns: list[list[str]], width: int) -> int:
    """Return the number of first columns that fit beside each other, at least one."""
    used = len(columns[0][0])
    for count, column in enumerate(columns[1:], start=1):
        used += 2 + len(column[0])
        if used > width:
            return count
    return len(columns)


def _column_text(rows: TableRows, name: str, values: list[Any]) -> list[str]:
    """Return name, unit and cells of a column, all of one width."""
    quantity = rows.table_columns.quantities[name]
    unit = "1"
    factor = 1.0
    if quantity is not None:
        unit = quantity.shown_in
        factor = say.factor_of(quantity)
    texts = [name, "" if unit == "1" else unit, *(_cell_text(value, factor) for value in values)]
    width = max(map(len, texts))
    if quantity is None:
        return [text.ljust(width) for text in texts]
    return [text.rjust(width) for text in texts]


def _cell_text(value: Any, factor: float) -> str:
    """Return a value as text, a number divided by `factor`."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return str(value).lower()
    if not isinstance(value, float):
        return str(value)
    if math.isnan(value):
        return "-"
    if math.isinf(value):
        return "rigid"
    return f"{value / factor:.6g}"
