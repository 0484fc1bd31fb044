"""Rows of a table, chosen by filters and read in stretches: a table of any size fits in memory."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from tendon_cli import say
from tendon_cli.cube.columns import DERIVED, ColumnArray, TableColumns
from tendon_cli.cube.cube import axis_values_of
from tendon_cli.cube.source import table_in
from tendon_cli.engine.states import WorkedOut
from tendon_cli.errors import UsageError
from tendon_cli.files import FORMULA, not_replaced, output_errors, output_file
from tendon_cli.quantities import (
    OF_CYCLES,
    OF_DESIGNS,
    OF_STATES,
    OF_TRAJECTORIES,
    QUANTITIES,
    Quantity,
)
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.filters import Condition, read_filter
from tendon_cli.tables.read import AnyTable
from tendon_cli.tables.schema import Column, array_of, as_numpy
from tendon_cli.units import shorten


@dataclass(frozen=True)
class TableRows:
    """Some rows and columns of a table; raises UsageError for columns that it does not have."""

    table: AnyTable
    where: tuple[str, ...] = ()
    """Filters, all of which a row must meet."""
    columns: tuple[str, ...] = ()
    """Names of the columns in their order; empty for all."""

    @cached_property
    def table_columns(self) -> TableColumns:
        """Columns of the table."""
        return TableColumns.of(self.table.schema)

    @cached_property
    def names(self) -> list[str]:
        """Names of the columns of the rows, in their order; raises UsageError."""
        names = [self.table_columns.find(name, "--columns") for name in self.columns]
        for name in names:
            if names.count(name) > 1:
                raise UsageError(
                    f"{name} is in the list twice, expected each column once", where="--columns"
                )
        return names or list(self.table.schema.names)

    @cached_property
    def conditions(self) -> list[Condition]:
        """Conditions that the filters set."""
        if not self.where:
            return []
        return self.table_columns.conditions(self.where, axis_values_of(self.table))

    def unit(self, column: str) -> str:
        """Return the unit of a column; "1" for one without."""
        quantity = self.table_columns.quantities[column]
        return "1" if quantity is None else quantity.unit

    def batches(self, also: Sequence[str] = ()) -> Iterator[pa.Table]:
        """Yield the rows that the filters leave, in their order, a stretch at a time.

        Args:
            also: Further columns, after those in `names`.
        """
        wanted = list(dict.fromkeys([*self.names, *also]))
        filtered = [condition.column for condition in self.conditions]
        derived = [name for name in dict.fromkeys([*wanted, *filtered]) if name in DERIVED]
        as_numbers = self.table_columns.stored([*filtered, *derived])
        for batch in self.table.stretches(self.table_columns.stored([*wanted, *filtered])):
            read = {name: as_numpy(batch[name]) for name in as_numbers}
            read |= self.table_columns.compute(derived, read)
            is_kept = np.ones(batch.num_rows, dtype=np.bool_)
            for condition in self.conditions:
                is_kept &= condition.holds(read[condition.column])
            arrays = [
                _derived(name, read[name]) if name in derived else batch[name] for name in wanted
            ]
            fields = [_field(name, batch.schema) for name in wanted]
            rows = pa.Table.from_arrays(arrays, schema=pa.schema(fields))
            yield rows if is_kept.all() else rows.filter(pa.array(is_kept))

    def head(self, count: int, sort: str | None = None) -> tuple[pa.Table, int]:
        """Return the first rows, and the number of all rows that the filters leave.

        Args:
            count: Most rows to return.
            sort: Column by which rows are sorted, with - before it in descending order; None for
                the order of the table.
        """
        by = None
        order = "ascending"
        if sort is not None:
            by = self.table_columns.find(sort.removeprefix("-"), "--sort")
            if sort.startswith("-"):
                order = "descending"
        first = None
        total = 0
        for batch in self.batches((by,) if by else ()):
            total += batch.num_rows
            is_full = first is not None and first.num_rows >= count
            if by is None and is_full:
                continue
            rows = batch if first is None else pa.concat_tables([first, batch]).unify_dictionaries()
            if by is not None:
                rows = rows.take(_sorted(rows[by], order)[:count])
            first = rows.slice(0, count)
        if first is None:
            schema = pa.schema([_field(name, self.table.schema) for name in self.names])
            return schema.empty_table(), 0
        return first.select(self.names), total


def _sorted(column: pa.ChunkedArray, order: str) -> pa.Array:
    """Return row numbers that sort a column, ascending or descending."""
    if pa.types.is_dictionary(column.type):
        column = column.cast(pa.string())
    return pc.sort_indices(pa.table({"by": column}), sort_keys=[("by", order)])


_WITH_POINT = ("en", "zh", "ja", "ko")
_WITH_COMMA = ("de", "fr", "es", "it", "nl", "pl", "pt", "ru", "sv", "da", "fi", "cs", "tr")
_LOCALES = (*_WITH_POINT, *_WITH_COMMA)
_UNITS = ("si", "study")


@dataclass(frozen=True)
class CsvForm:
    """Form of the numbers in a CSV file; raises UsageError for a form that is not known."""

    locale: str = "en"
    """Language that decides on the decimal sign and on the sign between columns."""
    units: str = "si"
    """si, or study: the units in which studies are written and people read, such as mm and deg."""
    digits: int | None = None
    """Significant digits; None for all."""

    def __post_init__(self) -> None:
        _check_known(self.locale, _LOCALES, "--locale")
        _check_known(self.units, _UNITS, "--units")

    @property
    def separator(self) -> str:
        """Sign between columns."""
        return ";" if self._has_comma else ","

    @property
    def _has_comma(self) -> bool:
        """True if the decimal sign is a comma."""
        return self.locale in _WITH_COMMA

    def header(self, name: str, quantity: Quantity | None) -> str:
        """Return a column's name with its unit, such as "pretension (N)"."""
        if quantity is None:
            return name
        unit = quantity.shown_in if self.units == "study" else quantity.unit
        return name if unit == "1" else f"{name} ({unit})"

    def column(
        self, column: pa.ChunkedArray, quantity: Quantity | None, *, is_rigid: bool
    ) -> pa.ChunkedArray:
        """Return a column as it is written to the file.

        Text that a spreadsheet would run has a ' before it.

        Args:
            column: The column, SI.
            quantity: Its quantity; None for words and truths.
            is_rigid: True if infinite values are to be written as "rigid".
        """
        if pa.types.is_dictionary(column.type):
            column = column.cast(pa.string())
        if pa.types.is_string(column.type):
            return pc.replace_substring_regex(column, pattern=FORMULA, replacement=r"'\1")
        if not pa.types.is_floating(column.type):
            return column
        if self.units == "study" and quantity is not None and say.factor_of(quantity) != 1.0:
            column = pc.divide(column, say.factor_of(quantity))
        if self.digits is not None:
            column = pa.chunked_array([_rounded(column, self.digits)], type=pa.float64())
        if not (self._has_comma or is_rigid):
            return column
        texts = pc.replace_substring(column.cast(pa.string()), "inf", "rigid")
        return pc.replace_substring(texts, ".", ",") if self._has_comma else texts


def _rounded(column: pa.ChunkedArray, digits: int) -> list[float | None]:
    """Return numbers to some significant digits."""
    values: list[float | None] = column.to_pylist()
    return [None if value is None else float(f"{value:.{digits}g}") for value in values]


@cache
def _headers_of_results() -> frozenset[str]:
    """Return every header under which an export has a result, in each unit and without one."""
    names = (*OF_STATES, *OF_DESIGNS, *OF_CYCLES, *OF_TRAJECTORIES)
    forms = [CsvForm(units=units) for units in _UNITS]
    return frozenset(form.header(name, QUANTITIES[name]) for name in names for form in forms)


_LONGEST_LINE = 10**6
"""Length up to which the first line of a file is read, bytes."""


def _check_known(value: str, known: Sequence[str], option: str) -> None:
    """Raise UsageError if a value of an option is none of the known ones."""
    if value not in known:
        hint = hint_at_nearest(value, known) or ", ".join(known)
        raise UsageError(f'"{shorten(value)}" is not known', where=option, hint=hint)


def _field(name: str, schema: pa.Schema) -> pa.Field:
    """Return the field of a column, which may be a derived quantity."""
    return Column.of(DERIVED[name].quantity).field if name in DERIVED else schema.field(name)


def _derived(name: str, values: ColumnArray) -> pa.Array:
    """Return the values of a derived quantity as an Arrow array; NaN becomes null."""
    return array_of(Column.of(DERIVED[name].quantity), values, nulls=bool(np.isnan(values).any()))


def rows_in(
    path: Path,
    table: str | None = None,
    where: Sequence[str] = (),
    columns: Sequence[str] = (),
    sort: str | None = None,
) -> TableRows:
    """Return rows of the table that a path means; it has all columns that are asked for.

    Args:
        path: As in `table_in`.
        table: Name of the table in a folder.
        where: Filters.
        columns: Names of the columns; empty for all.
        sort: Column by which rows will be sorted, maybe with - before it.

    Raises:
        UsageError: A column or a table is not there.
        InputError: There is no table.
    """
    asked = [*columns, *(read_filter(text).name for text in where)]
    if sort:
        asked.append(sort.removeprefix("-"))
    return TableRows(table_in(path, table, asked), tuple(where), tuple(columns))


def _is_rigid(table: AnyTable, name: str, quantity: Quantity | None) -> bool:
    """Return True if a column of springs or anchors has a rigid one anywhere."""
    if quantity is None or quantity.dimension != "stiffness":
        return False
    return any(
        bool(np.isposinf(as_numpy(stretch[name])).any())
        for stretch in table.stretches([name], 1 << 16)
    )


def write_csv(
    rows: TableRows,
    file: Any,
    stretches: Iterator[pa.Table] | None = None,
    form: CsvForm | None = None,
) -> int:
    """Write rows as CSV, units in the header; return their number.

    Args:
        rows: The rows.
        file: A file of bytes.
        stretches: The rows in stretches; None for all of `rows`.
        form: Form of the numbers; None for SI with decimal points.
    """
    from pyarrow import csv

    form = form or CsvForm()
    quantities = [rows.table_columns.quantities[name] for name in rows.names]
    is_rigid = [
        _is_rigid(rows.table, name, quantity)
        for name, quantity in zip(rows.names, quantities, strict=True)
    ]
    file.write(_first_line(rows, form))
    options = csv.WriteOptions(
        include_header=False, quoting_style="needed", delimiter=form.separator
    )
    count = 0
    for stretch in stretches or rows.batches():
        columns = [
            form.column(column, quantity, is_rigid=rigid)
            for column, quantity, rigid in zip(stretch.columns, quantities, is_rigid, strict=True)
        ]
        written = pa.BufferOutputStream()
        csv.write_csv(pa.table(columns, names=stretch.column_names), written, options)
        file.write(written.getvalue())
        count += stretch.num_rows
    return count


def _first_line(rows: TableRows, form: CsvForm) -> bytes:
    """Return the first line of the CSV of rows: each column with its unit, in quotes."""
    headers = [f'"{form.header(name, rows.table_columns.quantities[name])}"' for name in rows.names]
    return (form.separator.join(headers) + "\n").encode()


def _is_export(line: bytes, first_line: bytes) -> bool:
    """Return True if tendon wrote a CSV file that begins with this line.

    An export has all its columns in quotes and, unless it begins with just the line that is to be
    written, a result that tendon alone works out, with its unit.
    """
    text = line.decode(errors="replace")
    if line == first_line:
        return True
    if not (text.startswith('"') and text.endswith('"\n')):
        return False
    headers = re.split('"[,;]"', text[1:-2])
    has_strange_sign = any('"' in header for header in headers)
    return not has_strange_sign and not _headers_of_results().isdisjoint(headers)


def _sums_of_sources(rows: TableRows) -> set[str]:
    """Return the checksums of the files that the study of rows read; none for a CSV of people."""
    if isinstance(rows.table, WorkedOut):
        sources = rows.table.study.sources
    else:
        sources = rows.table.facts.get("study", {}).get("sources", {})
    return {source["sha256"] for source in sources.values() if "sha256" in source}


def _checksum(file: BinaryIO) -> str:
    """Return the SHA-256 of what is left of a file."""
    digest = hashlib.sha256()
    while block := file.read(1 << 20):
        digest.update(block)
    return digest.hexdigest()


def export(
    rows: TableRows, path: Path, form: CsvForm | None = None, *, overwrite: bool = False
) -> int:
    """Write rows to a CSV file, the whole file or none; return their number.

    Args:
        rows: The rows.
        path: The file.
        form: Form of the numbers; None for SI with decimal points.
        overwrite: True to replace a file that tendon did not write, or that the study reads.

    Raises:
        UsageError: The name does not end with .csv, tendon did not write the file, or the study
            reads it.
        OutputError: The file could not be written.
    """
    if path.suffix.lower() != ".csv":
        raise UsageError(
            f'"{shorten(path.name)}" is not the name of a CSV file',
            hint="end it with .csv; the folder of a run or an answer has its tables as Parquet",
        )
    first_line = _first_line(rows, form or CsvForm())
    sums = _sums_of_sources(rows)

    def is_ours(file: BinaryIO) -> bool:
        if not _is_export(file.readline(_LONGEST_LINE), first_line):
            return False
        file.seek(0)
        if sums and _checksum(file) in sums:
            raise not_replaced(path, "the study reads it")
        return True

    with (
        output_file(path, is_ours, overwrite=overwrite) as temporary,
        output_errors(path),
        temporary.open("xb") as file,
    ):
        count = write_csv(rows, file, form=form)
        file.flush()
        os.fsync(file.fileno())
    return count
