"""The tables of reference in the pages, from the code itself: `python docs/reference.py` writes them anew.

They stand between `<!-- from the code: NAME -->` and `<!-- until here -->`; a test holds them to what is written here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES, QUANTITIES
from tendon_cli.study.study import keys, split_side
from tendon_cli.units import UNITS

MARKED = re.compile(r"(<!-- from the code: (\w+) -->\n).*?(<!-- until here -->)", re.DOTALL)


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [_row(heads), "|" + "---|" * len(heads), *(_row(row) for row in rows)]
    return "\n".join(lines)


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def key_table() -> str:
    """Every number of a study."""
    rows = []
    for path, key in keys().items():
        if split_side(path)[1] is None:
            number, quantity = key.number, key.number.quantity
            unit = "" if quantity.unit == "1" else f" {quantity.unit}"
            possible = f"{number.low:g} to {number.high:g}{unit}"
            rows.append((f"`{path}`", quantity.symbol, quantity.long_name, possible, f"`{key.column}`"))
    return table(("key", "symbol", "meaning", "possible", "column"), rows)


def unit_table() -> str:
    """Every unit that a quantity may have."""
    by_dimension: dict[str, list[str]] = {}
    for unit in UNITS.values():
        by_dimension.setdefault(unit.dimension, []).append(f"`{unit.symbol}`")
    return table(("dimension", "units"), ((name, ", ".join(symbols)) for name, symbols in by_dimension.items()))


def column_table(columns: Iterable[str]) -> str:
    """Results of a table."""
    found = [QUANTITIES[column] for column in columns]
    rows = ((f"`{each.name}`", each.unit, each.symbol, each.long_name) for each in found)
    return table(("column", "unit", "symbol", "meaning"), rows)


TABLES: dict[str, Callable[[], str]] = {
    "keys": key_table,
    "units": unit_table,
    "states": lambda: column_table(OF_STATES),
    "designs": lambda: column_table(OF_DESIGNS),
    "cycles": lambda: column_table(OF_CYCLES),
}


def renewed(page: str) -> str:
    """A page with its tables as the code has them now."""
    return MARKED.sub(lambda match: f"{match[1]}{TABLES[match[2]]()}\n{match[3]}", page)


if __name__ == "__main__":
    for page in Path(__file__).parent.glob("*.md"):
        page.write_text(renewed(page.read_text(encoding="utf-8")), encoding="utf-8")
