"""Choices of an answer joined with what the whole answer says of those that it names.

A part of the choices is written once, before anything is known of the whole. What only the whole
knows, such as the front, and what a proof changed, stands in `named.parquet`, a row per named
choice, and takes the place of the choice's own values here.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.errors import InputError
from tendon_cli.say import SAMPLED
from tendon_cli.tables.read import AnyTable, open_table
from tendon_cli.tables.schema import Column, array_of, as_numpy

CHOICES = "choices.parquet"
NAMED = "named.parquet"
_ROW = "choice"
"""Column of named choices: row of the choice."""
_ELSEWHERE = {"between_samples": SAMPLED}
"""Words of choices that an answer does not name; numbers are null there, truths false."""


def open_choices(path: Path, records: Mapping[str, Any] | None = None) -> AnyTable:
    """Open the choices of an answer, every byte verified, with what the whole says of them.

    Args:
        path: `choices.parquet` of the answer. Without `named.parquet` beside it, it is all there
            is.
        records: Records in its folder by the names of their files; they are read if None.

    Raises:
        InputError: A table is damaged, or they are of two answers.
    """
    choices = open_table(path, records)
    beside = path.with_name(NAMED)
    if not beside.exists():
        return choices
    named = open_table(beside, records)
    if named.facts.get("study_hash") != choices.facts.get("study_hash"):
        hint = "each answer has its own; move it away"
        raise InputError("belongs to another answer", where=str(beside), hint=hint)
    return ChoicesTable(choices, named)


@dataclass(frozen=True)
class ChoicesTable(AnyTable):
    """Rows of choices, with those of the named choices in their places."""

    choices: AnyTable
    named: AnyTable

    @property
    def files(self) -> tuple[Path, ...]:  # type: ignore[override]
        """Files of both tables."""
        return (*self.choices.files, *self.named.files)

    @cached_property
    def schema(self) -> pa.Schema:
        """Columns of the choices alone, then those of which a named choice has its own values."""
        own = self.choices.schema
        of_named = [field for field in self.named.schema if field.name != _ROW]
        names = {field.name for field in of_named}
        fields = [field for field in own if field.name not in names] + of_named
        attributes = json.loads(own.metadata[b"PANDAS_ATTRS"])
        for key, of_columns in json.loads(self.named.schema.metadata[b"PANDAS_ATTRS"]).items():
            if isinstance(of_columns, dict):
                attributes[key] |= {
                    name: text for name, text in of_columns.items() if name in names
                }
        metadata = {**own.metadata, b"PANDAS_ATTRS": json.dumps(attributes, sort_keys=True)}
        return pa.schema(fields, metadata)

    @property
    def rows(self) -> int:
        """Number of choices."""
        return self.choices.rows

    def parts(
        self, columns: Sequence[str] | None = None, wanted: npt.NDArray[np.int64] | None = None
    ) -> Iterator[tuple[int, pa.Table]]:
        """Yield each part of the choices with the number of its first row."""
        names = list(columns) if columns else self.schema.names
        held = set(self.choices.schema.names)
        stored = [name for name in names if name in held] or self.choices.schema.names[:1]
        for first, part in self.choices.parts(stored, wanted):
            yield first, self._joined(first, part, names)

    def _joined(self, first: int, part: pa.Table, names: Sequence[str]) -> pa.Table:
        """Return some columns of a part with named choices in their places.

        Args:
            first: Row of its first choice.
            part: Columns of the part that the choices have.
            names: Columns to return.
        """
        rows, named = self._named_rows
        schema = pa.schema([self.schema.field(name) for name in names], self.schema.metadata)
        low, high = np.searchsorted(rows, (first, first + part.num_rows))
        own = _with_columns(part, schema)
        pieces = []
        start = 0
        for place in range(low, high):
            row = int(rows[place]) - first
            pieces.append(own.slice(start, row - start))
            pieces.append(_replaced(own.slice(row, 1), named.slice(place, 1)))
            start = row + 1
        pieces.append(own.slice(start))
        return pa.concat_tables(pieces).combine_chunks()

    @cached_property
    def _named_rows(self) -> tuple[npt.NDArray[np.int64], pa.Table]:
        """Rows of the named choices, ascending, and their values."""
        named = self.named.read()
        return as_numpy(named.column(_ROW)).astype(np.int64), named


def _replaced(own: pa.Table, named: pa.Table) -> pa.Table:
    """Return rows with the values of another table in the columns that it has."""
    held = set(named.schema.names)
    arrays = [(named if name in held else own).column(name) for name in own.schema.names]
    return pa.Table.from_arrays(arrays, schema=own.schema)


def _with_columns(part: pa.Table, schema: pa.Schema) -> pa.Table:
    """Return a part with the columns of a schema; those that it lacks say nothing."""
    arrays = []
    for field in schema:
        if field.name in part.schema.names:
            arrays.append(part.column(field.name))
        else:
            arrays.append(_nothing(field, part.num_rows))
    return pa.Table.from_arrays(arrays, schema=schema)


def _nothing(field: pa.Field, rows: int) -> pa.Array:
    """Return values of a column for choices that are not named."""
    if pa.types.is_dictionary(field.type):
        words = Column(field.name, "text", "1", "", choices=(_ELSEWHERE.get(field.name, ""),))
        return array_of(words, np.zeros(rows, words.dtype))
    if field.type == pa.bool_():
        return array_of(Column(field.name, "truth", "1", ""), np.zeros(rows, np.bool_))
    return pa.nulls(rows, field.type)
