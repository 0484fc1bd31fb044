"""Table A.1 as people type it."""

from __future__ import annotations

from tests.readers.files import Written

TABLE = """case,load_cell_1_kg,load_cell_2_kg
1,1.236,1.028
1,1.236,1.027
1,1.236,1.028
2,0.858,1.036
2,0.858,1.036
2,0.857,1.036
"""
GERMAN = TABLE.replace(",", ";").replace(".", ",")
WRITTEN = Written(
    ("case", "load_cell_1", "load_cell_2"),
    ("", "kg", "kg"),
    [line.split(",") for line in TABLE.splitlines()[1:]],
)
BARE_ROWS = TABLE.split("\n", 1)[1]


def changed(text: str, *pairs: tuple[str, str]) -> str:
    """Return the text with the first of each pair replaced by the second."""
    for old, new in pairs:
        text = text.replace(old, new)
    return text


def called(first: str, second: str, text: str = TABLE) -> str:
    """Return the table with other headers of the two cells."""
    return changed(text, ("load_cell_1_kg", first), ("load_cell_2_kg", second))


def added(*cells: str) -> str:
    """Return the table with a further column."""
    rows = zip(TABLE.splitlines(), cells, strict=True)
    return "".join(f"{line},{cell}\n" for line, cell in rows)


NAMED = changed(TABLE, ("case", "direction"), ("\n1,", "\nup,"), ("\n2,", "\ndown,"))
