"""Rows of a study that each set several numbers: cases, catalogues, prototypes, samples."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np

from tendon_cli.model.kinematics import Array
from tendon_cli.studies.contents import keys
from tendon_cli.studies.magnitude import Slip
from tendon_cli.studies.model_words import WORDS_OF
from tendon_cli.studies.space.axis import CASE_AXIS, CarriedColumn, NamedAxis, split_side
from tendon_cli.studies.values import RIGID, si_document
from tendon_cli.units import shorten

StatedRole = Literal["choice", "condition", "draw"]
"""Role of the rows of a table for a designer, as a study states it."""
_LONGEST_LIST = 200
"""Most characters of the rows that a warning lists."""
NAME = "name"
"""Header of the column with the names of the rows."""


@dataclass(frozen=True, eq=False)
class RowTable(NamedAxis):
    """Axis of the rows that a study states, in a file or as a sample; its role may be left open."""

    stated_role: StatedRole | None = None
    """Role as the study states it; None if it leaves it open."""
    readings: Mapping[str, str] = field(default_factory=dict)
    """Dimension in which the pretensions of the table are stated, by dotted key."""
    slips: Mapping[str, Sequence[Slip]] = field(default_factory=dict)
    """Values that are far from any arm, by the place of the table, or of a case's key."""
    where: str = ""
    """Place of the table, for errors: "springs.csv", "table.0"."""

    @property
    def is_of_cases(self) -> bool:
        """True for the cases of a study."""
        return self.key == CASE_AXIS

    @property
    def places(self) -> dict[str, str]:
        """Place of each number that its rows set, by key, for errors; of cases the first."""
        if not self.is_of_cases:
            return {key: f"{self.where}: {key}" for key in self.numbers}
        rows = {key: int(np.argmin(np.isnan(values))) for key, values in self.numbers.items()}
        return {key: f"{self.where}.{row}.{key}" for key, row in rows.items()}

    @property
    def warnings(self) -> Iterator[str]:
        """Sentences on cells that are no number in a column that has some: sums are null there."""
        for column in self.carried:
            if column.numbers is None:
                continue
            words = [column.words[place] for place in column.values.tolist()]
            unknown = [
                f'{name} ("{shorten(word)}")' if word else name
                for name, word, number in zip(self.names, words, column.numbers, strict=True)
                if math.isnan(number)
            ]
            yield (
                f"table {self.key}: {column.name} is no number in {len(unknown)} of {len(self)}"
                f" rows, where sums of it are null: {shorten(', '.join(unknown), _LONGEST_LIST)}"
            )

    def document(self) -> Any:
        """Return the table as a record has it, in SI.

        It has columns, each behind its header; cases are rows, whose keys are nested.
        """
        return self._cases_document() if self.is_of_cases else self._document

    def _cases_document(self) -> list[dict[str, Any]]:
        rows: list[dict[str, Any]] = [{NAME: name} for name in self.names]
        for key, values in self.numbers.items():
            *tables, name = key.split(".")
            for row, value in zip(rows, values.tolist(), strict=True):
                if math.isnan(value):
                    continue
                inner = row
                for table in tables:
                    inner = inner.setdefault(table, {})
                words = WORDS_OF.get(split_side(key)[0])
                dimension = "" if words else keys()[key].number.quantity.dimension
                inner[name] = words[int(value)] if words else si_document(value, dimension)
        return rows

    @cached_property
    def _document(self) -> dict[str, Any]:
        columns: dict[str, Any] = {NAME: list(self.names)}
        for key, values in self.numbers.items():
            header, cells = _cells_of(key, values, self.readings.get(key))
            columns[header] = cells
        for column in self.carried:
            columns[carried_header(column)] = carried_cells(column)
        role = {} if self.stated_role is None else {"role": self.stated_role}
        # A record sorts keys, which would lose the order of the columns.
        lists = [[header, *cells] for header, cells in columns.items()]
        return {"name": self.key, **role, "rows": lists}


def _cells_of(key: str, values: Array, reading: str | None) -> tuple[str, list[Any]]:
    """Return the header and the cells of a column of numbers or words, in SI.

    Args:
        key: Dotted key of the number.
        values: Its values.
        reading: Dimension in which a pretension is stated; None for any other number.
    """
    words = WORDS_OF.get(split_side(key)[0])
    if words is not None:
        return key, [None if np.isnan(value) else words[int(value)] for value in values]
    cells: list[Any] = values.tolist()
    if not np.isfinite(values).all():
        cells = [RIGID if value == np.inf else _or_none(value) for value in cells]
    unit = {"force": "N", "torque": "N m"}.get(reading or "")
    if key in keys() and keys()[key].number.quantity.dimension == "angle":
        unit = "rad"
    return (key if unit is None else f"{key} ({unit})"), cells


def carried_header(column: CarriedColumn) -> str:
    """Return the header of a carried column, with its unit if it has one."""
    return f"{column.name} ({column.unit})" if column.unit else column.name


def carried_cells(column: CarriedColumn) -> list[Any]:
    """Return the cells of a carried column; None for a cell without a number."""
    if column.words:
        return [column.words[place] for place in column.values.tolist()]
    return [_or_none(value) for value in column.values.tolist()]


def _or_none(value: float) -> float | None:
    """Return a number; None if it is not one."""
    return None if math.isnan(value) else value
