"""Where the header of a readings file stands, below comments, titles and the names of cases side by side."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

from tendon_cli.errors import InputError, UsageError
from tendon_cli.friction.reading.header import CellPair, Heading, named_pair, pair_cells, read_column
from tendon_cli.friction.reading.text import LogFile
from tendon_cli.units import shorten

_HEADER_WITHIN = 200


@dataclass(frozen=True)
class Layout:
    """Where the header stands and which columns are read."""

    line: int
    width: int
    pairs: list[CellPair]
    columns: list[Heading]

    def find(self, role: str, place: str) -> Heading | None:
        """The one column of a role; refused where there are two."""
        found = [column for column in self.columns if column.role == role]
        if len(found) > 1:
            raise InputError(f"two columns give the {role}", where=place)
        return found[0] if found else None


def find_header(rows: Iterator[tuple[int, list[str]]], source: LogFile, names: tuple[str, str] | None) -> Layout:
    """The first of the lines that names both cells, by the options' names or by the obvious ones."""
    above: list[str] = []
    widest: tuple[int, list[str]] = (1, [])
    for number, cells in itertools.islice(rows, _HEADER_WITHIN):
        columns = [read_column(index, cell) for index, cell in enumerate(cells)]
        pairs = named_pair(columns, *names) if names else pair_cells(columns, above, source.place(number))
        if pairs:
            while cells and not cells[-1]:
                cells.pop()
            return Layout(number, len(cells), pairs, columns)
        if sum(map(bool, cells)) > sum(map(bool, widest[1])):
            widest = number, cells
        above = cells
    shown = ", ".join(f'"{shorten(cell, 30)}"' for cell in widest[1][:12])
    if names:
        raise UsageError(
            f'no line of {source.name} has one column "{shorten(names[0])}" and one "{shorten(names[1])}"',
            where="--cell-1, --cell-2",
            hint=f"line {widest[0]} has {shown}",
        )
    raise InputError(
        f"no header names the two load cells; this line has {shown}",
        where=source.place(widest[0]),
        hint='call them "load cell 1" and "load cell 2", or name them with --cell-1 and --cell-2',
    )
