"""Table A.1 as people type it."""

from __future__ import annotations

TABLE = """case,load_cell_1_kg,load_cell_2_kg
1,1.236,1.028
1,1.236,1.027
1,1.236,1.028
2,0.858,1.036
2,0.858,1.036
2,0.857,1.036
"""
GERMAN = TABLE.replace(",", ";").replace(".", ",")
BARE_ROWS = TABLE.split("\n", 1)[1]


def changed(text: str, *pairs: tuple[str, str]) -> str:
    """With each first text replaced by its second."""
    for old, new in pairs:
        text = text.replace(old, new)
    return text


def called(one: str, two: str, text: str = TABLE) -> str:
    """With other headers of the two cells."""
    return changed(text, ("load_cell_1_kg", one), ("load_cell_2_kg", two))


def added(*cells: str) -> str:
    """With a further column."""
    return "".join(f"{line},{cell}\n" for line, cell in zip(TABLE.splitlines(), cells, strict=True))


NAMED = changed(TABLE, ("case", "direction"), ("\n1,", "\nup,"), ("\n2,", "\ndown,"))
