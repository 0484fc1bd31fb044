"""Rows of a table, chosen by filters and read in stretches, so that tables of any size take the same memory."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import read_file, whole_file
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.filters import Condition, read_filter
from tendon_cli.studies.people.asked import MAX_BYTES as MAX_PEOPLE_BYTES
from tendon_cli.studies.people.reading import read_listed
from tendon_cli.studies.study import keys
from tendon_cli.tables.read import TableFiles, open_table
from tendon_cli.tables.schema import Column
from tendon_cli.units import shorten

TABLES = ("designs", "choices", "states", "conditions")
_FORMULA = r"^([=+\-@\t\r])"
"""How text begins that a spreadsheet would run."""


@dataclass(frozen=True)
class TableHeld:
    """A table in memory, to be read as those on the disk are."""

    whole: pa.Table

    @property
    def schema(self) -> pa.Schema:
        """Columns with units and meaning."""
        return self.whole.schema

    def stretches(self, columns: Sequence[str], rows: int = 1 << 14) -> Iterator[pa.Table]:
        """Some columns, so many rows at a time, in the order of the rows."""
        for batch in self.whole.select(list(columns)).to_batches(rows):
            yield pa.Table.from_batches([batch])


def table_in(path: Path, wanted: str | None = None) -> TableFiles | TableHeld:
    """A table, of the folder of a run or an answer the one that is wanted, or a file of people; every byte verified.

    Raises InputError where there is none, UsageError for one that the folder has not.
    """
    file = file_of(path, wanted)
    return _people_in(file) if file.suffix.lower() == ".csv" else open_table(file)


def file_of(path: Path, wanted: str | None = None) -> Path:
    """Where the table lies that a path means; raises InputError, UsageError."""
    if path.suffix.lower() in (".toml", ".yaml", ".yml"):
        hint = f"`tendon sweep {path}` runs it"
        raise UsageError("is a study, expected a table or the folder of a run", where=str(path), hint=hint)
    if not path.is_dir() or path.suffix == ".parquet":
        if wanted is not None and wanted != path.stem:
            hint = "without --table, or the folder that the table lies in"
            raise UsageError(f'is one table, not "{shorten(wanted)}"', where=str(path), hint=hint)
        return path
    found = [name for name in TABLES if (path / f"{name}.parquet").exists()]
    if not found:
        raise InputError("holds no table of tendon's", where=str(path), hint="`tendon sweep` writes some")
    if wanted is not None and wanted not in found:
        hint = nearest(wanted, found) or f"there is {', '.join(found)}"
        raise UsageError(f'there is no table "{shorten(wanted)}"', where=str(path), hint=hint)
    return path / f"{wanted or found[0]}.parquet"


def _people_in(path: Path) -> TableHeld:
    """A CSV of people as tendon reads it, in SI; raises InputError."""
    where = shorten(str(path), 1000)
    try:
        content = read_file(path, MAX_PEOPLE_BYTES)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=where) from None
    listed = read_listed(content, where)
    words = {"name": listed.names, "sex": listed.sexes}
    fields, values = [], []
    for name in listed.columns:
        if name in words:
            fields.append(pa.field(name, pa.string()))
            values.append(pa.array(words[name]))
            continue
        column = (
            Column.of(QUANTITIES[name]) if name in DIMENSIONS else Column(name, "number", "1", "how much each counts")
        )
        fields.append(column.field)
        numbers = listed.values[:, DIMENSIONS.index(name)] if name in DIMENSIONS else listed.weighting
        values.append(pa.array(numbers, from_pandas=True))
    return TableHeld(pa.table(values, schema=pa.schema(fields)))


@dataclass(frozen=True)
class TableRows:
    """Some rows and columns of a table; raises UsageError for columns that it has not."""

    table: TableFiles | TableHeld
    where: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    """In this order; all without any."""

    @cached_property
    def names(self) -> list[str]:
        """The columns that are given."""
        return [self.find(name, "--columns") for name in self.columns] or list(self.table.schema.names)

    @cached_property
    def conditions(self) -> list[Condition]:
        """What the filters ask."""
        found = []
        for text in self.where:
            asked = read_filter(text)
            column = self.find(asked.name, "--where")
            found.append(asked.on(column, self.quantity(column)))
        return found

    def find(self, name: str, option: str) -> str:
        """A column by its name or by its key in a study; raises UsageError with the nearest name."""
        known = self.table.schema.names
        column = keys()[name].column if name in keys() else name
        if column in known:
            return column
        hint = nearest(name, known) or f"columns: {', '.join(known)}"
        raise UsageError(f'the table has no column "{shorten(name)}"', where=option, hint=hint)

    def quantity(self, column: str) -> Quantity | None:
        """What a column of numbers holds; None for words and truths."""
        field = self.table.schema.field(column)
        if not (pa.types.is_floating(field.type) or pa.types.is_integer(field.type)):
            return None
        name = (field.metadata or {}).get(b"quantity", b"").decode()
        return QUANTITIES.get(name) or Quantity(column, "", "number", self.unit(column), self.unit(column), column)

    def unit(self, column: str) -> str:
        """The unit of a column's values, "1" for what has none."""
        metadata = self.table.schema.field(column).metadata or {}
        return str(metadata.get(b"unit", b"1").decode())

    def batches(self, also: Sequence[str] = ()) -> Iterator[pa.Table]:
        """The rows that the filters leave, in their order, a stretch at a time; with some columns besides."""
        needed = dict.fromkeys([*self.names, *also, *(condition.column for condition in self.conditions)])
        for batch in self.table.stretches(list(needed)):
            held = np.ones(batch.num_rows, dtype=np.bool_)
            for condition in self.conditions:
                held &= condition.holds(_values(batch[condition.column]))
            kept = batch if held.all() else batch.filter(pa.array(held))
            yield kept.select(list(dict.fromkeys([*self.names, *also])))

    def head(self, count: int, sort: str | None = None) -> tuple[pa.Table, int]:
        """The first rows, by a column where `sort` names one (with a - before it falling), and how many there are."""
        falling = sort is not None and sort.startswith("-")
        by = self.find(sort.removeprefix("-"), "--sort") if sort is not None else None
        kept, total = None, 0
        for batch in self.batches((by,) if by else ()):
            total += batch.num_rows
            if by is None and kept is not None and kept.num_rows >= count:
                continue
            kept = batch if kept is None else pa.concat_tables([kept, batch]).unify_dictionaries()
            if by is not None:
                column = kept[by].cast(pa.string()) if pa.types.is_dictionary(kept[by].type) else kept[by]
                order = "descending" if falling else "ascending"
                kept = kept.take(pc.sort_indices(pa.table({"by": column}), sort_keys=[("by", order)])[:count])
            kept = kept.slice(0, count)
        if kept is None:
            kept = self.table.schema.empty_table()
        return kept.select(self.names), total

    def headers(self) -> list[str]:
        """The columns' names with their units, such as "pretension (N)"."""
        units = [self.unit(name) for name in self.names]
        return [name if unit == "1" else f"{name} ({unit})" for name, unit in zip(self.names, units, strict=True)]


def write_csv(rows: TableRows, file: Any, stretches: Iterator[pa.Table] | None = None) -> int:
    """Rows as CSV in SI, units in the header; text that a spreadsheet would run has a ' before it. Returns how many."""
    from pyarrow import csv

    file.write((",".join(f'"{header}"' for header in rows.headers()) + "\n").encode())
    writer, count = None, 0
    for stretch in stretches or rows.batches():
        table = pa.table([_guarded(column) for column in stretch.columns], names=stretch.column_names)
        if writer is None:
            options = csv.WriteOptions(include_header=False, quoting_style="needed")
            writer = csv.CSVWriter(pa.PythonFile(file, mode="w"), table.schema, write_options=options)
        writer.write_table(table)
        count += table.num_rows
    if writer is not None:
        writer.close()
    return count


def export(rows: TableRows, path: Path) -> int:
    """Write rows as CSV, the whole file or none; returns how many. Raises UsageError, OutputError."""
    if path.suffix.lower() != ".csv":
        raise UsageError(f'"{shorten(path.name)}" is no name of a CSV file', hint="end it with .csv")
    with whole_file(path) as temporary, temporary.open("xb") as file:
        count = write_csv(rows, _Unclosed(file))
        file.flush()
        os.fsync(file.fileno())
    return count


class _Unclosed:
    """A file that the writer of CSV may not close."""

    closed = False

    def __init__(self, file: Any) -> None:
        self.write, self.flush = file.write, file.flush

    def close(self) -> None:
        """Whoever opened it closes it."""


def _guarded(column: pa.ChunkedArray) -> pa.ChunkedArray:
    if pa.types.is_dictionary(column.type):
        column = column.cast(pa.string())
    if not pa.types.is_string(column.type):
        return column
    return pc.replace_substring_regex(column, pattern=_FORMULA, replacement=r"'\1")


def _values(column: pa.ChunkedArray) -> npt.NDArray[Any]:
    """A column as a filter takes it: numbers with NaN for null, words with "" for null, truths as words."""
    if pa.types.is_boolean(column.type) or pa.types.is_dictionary(column.type) or pa.types.is_string(column.type):
        return np.asarray(pc.fill_null(column.cast(pa.string()), "").to_pylist(), dtype=object)
    return np.asarray(pc.fill_null(column.cast(pa.float64()), np.nan).to_numpy())
