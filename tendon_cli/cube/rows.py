"""Rows of a table, chosen by filters and read in stretches, so that tables of any size take the same memory."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from tendon_cli.cube.columns import DERIVED, Columns, Values
from tendon_cli.cube.source import table_in
from tendon_cli.errors import UsageError
from tendon_cli.files import output_errors, whole_file
from tendon_cli.quantities import Quantity
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.filters import Condition, read_filter
from tendon_cli.tables.read import AnyTable
from tendon_cli.tables.schema import Column, array_of, as_numpy
from tendon_cli.units import factor_of, shorten

_FORMULA = r"^([=+\-@\t\r])"
"""How text begins that a spreadsheet would run."""


@dataclass(frozen=True)
class TableRows:
    """Some rows and columns of a table; raises UsageError for columns that it has not."""

    table: AnyTable
    where: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    """In this order; all without any."""

    @cached_property
    def of(self) -> Columns:
        """What the columns of the table hold."""
        return Columns.of(self.table.schema)

    @cached_property
    def names(self) -> list[str]:
        """The columns that are given."""
        names = [self.of.find(name, "--columns") for name in self.columns]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise UsageError(
                f"{twice} stands in the list twice, expected each column once", where="--columns"
            )
        return names or list(self.table.schema.names)

    @cached_property
    def conditions(self) -> list[Condition]:
        """What the filters ask."""
        return self.of.conditions(self.where)

    def unit(self, column: str) -> str:
        """The unit of a column's values, "1" for what has none."""
        quantity = self.of.held[column]
        return "1" if quantity is None else quantity.unit

    def batches(self, also: Sequence[str] = ()) -> Iterator[pa.Table]:
        """The rows that the filters leave, in their order, a stretch at a time; with some columns besides."""
        wanted = list(dict.fromkeys([*self.names, *also]))
        asked = [condition.column for condition in self.conditions]
        derived = [name for name in dict.fromkeys([*wanted, *asked]) if name in DERIVED]
        numbers = self.of.stored([*asked, *derived])
        for batch in self.table.stretches(self.of.stored([*wanted, *asked])):
            read = {name: as_numpy(batch[name]) for name in numbers}
            read |= self.of.work_out(derived, read)
            held = np.ones(batch.num_rows, dtype=np.bool_)
            for condition in self.conditions:
                held &= condition.holds(read[condition.column])
            arrays = [
                _derived(name, read[name]) if name in derived else batch[name] for name in wanted
            ]
            fields = [_field(name, batch.schema) for name in wanted]
            rows = pa.Table.from_arrays(arrays, schema=pa.schema(fields))
            yield rows if held.all() else rows.filter(pa.array(held))

    def head(self, count: int, sort: str | None = None) -> tuple[pa.Table, int]:
        """The first rows, by a column where `sort` names one (with a - before it falling), and how many there are."""
        falling = sort is not None and sort.startswith("-")
        by = self.of.find(sort.removeprefix("-"), "--sort") if sort is not None else None
        kept, total = None, 0
        for batch in self.batches((by,) if by else ()):
            total += batch.num_rows
            if by is None and kept is not None and kept.num_rows >= count:
                continue
            kept = batch if kept is None else pa.concat_tables([kept, batch]).unify_dictionaries()
            if by is not None:
                column = (
                    kept[by].cast(pa.string())
                    if pa.types.is_dictionary(kept[by].type)
                    else kept[by]
                )
                order = "descending" if falling else "ascending"
                kept = kept.take(
                    pc.sort_indices(pa.table({"by": column}), sort_keys=[("by", order)])[:count]
                )
            kept = kept.slice(0, count)
        if kept is None:
            return pa.schema(
                [_field(name, self.table.schema) for name in self.names]
            ).empty_table(), 0
        return kept.select(self.names), total


@dataclass(frozen=True)
class CsvForm:
    """How numbers stand in a CSV; raises UsageError for what is not known."""

    locale: str = "en"
    """Of the decimal sign, and with it of what separates columns."""
    units: str = "si"
    """si, or study: the units in which studies are written and people read, such as mm and deg."""

    def __post_init__(self) -> None:
        for value, known, option in (
            (self.locale, _LOCALES, "--locale"),
            (self.units, _UNITS, "--units"),
        ):
            if value not in known:
                hint = nearest(value, known) or ", ".join(known)
                raise UsageError(f'"{shorten(value)}" is not known', where=option, hint=hint)

    @property
    def separator(self) -> str:
        """Between columns."""
        return ";" if self._has_comma else ","

    @property
    def _has_comma(self) -> bool:
        return self.locale not in _WITH_POINT

    def header(self, name: str, quantity: Quantity | None) -> str:
        """A column's name with its unit, such as "pretension (N)"."""
        unit = (
            "1"
            if quantity is None
            else quantity.shown_in
            if self.units == "study"
            else quantity.unit
        )
        return name if unit == "1" else f"{name} ({unit})"

    def column(
        self, column: pa.ChunkedArray, quantity: Quantity | None, *, is_rigid: bool
    ) -> pa.ChunkedArray:
        """A column as it is written; text that a spreadsheet would run has a ' before it, an endless number "rigid"."""
        if pa.types.is_dictionary(column.type):
            column = column.cast(pa.string())
        if pa.types.is_string(column.type):
            return pc.replace_substring_regex(column, pattern=_FORMULA, replacement=r"'\1")
        if not pa.types.is_floating(column.type):
            return column
        if self.units == "study" and quantity is not None and factor_of(quantity.shown_in) != 1.0:
            column = pc.divide(column, factor_of(quantity.shown_in))
        if not (self._has_comma or is_rigid):
            return column
        texts = pc.replace_substring(column.cast(pa.string()), "inf", "rigid")
        return pc.replace_substring(texts, ".", ",") if self._has_comma else texts


_WITH_POINT = ("en", "zh", "ja", "ko")
_LOCALES = (
    *_WITH_POINT,
    "de",
    "fr",
    "es",
    "it",
    "nl",
    "pl",
    "pt",
    "ru",
    "sv",
    "da",
    "fi",
    "cs",
    "tr",
)
_UNITS = ("si", "study")


def _field(name: str, schema: pa.Schema) -> pa.Field:
    return Column.of(DERIVED[name].quantity).field if name in DERIVED else schema.field(name)


def _derived(name: str, values: Values) -> pa.Array:
    return array_of(Column.of(DERIVED[name].quantity), values, nulls=bool(np.isnan(values).any()))


def rows_in(
    path: Path,
    table: str | None = None,
    where: Sequence[str] = (),
    columns: Sequence[str] = (),
    sort: str | None = None,
) -> TableRows:
    """Rows of the table that a path means, which has all that is asked for; raises UsageError, InputError."""
    asked = [
        *columns,
        *(read_filter(text).name for text in where),
        *([sort.removeprefix("-")] if sort else []),
    ]
    return TableRows(table_in(path, table, asked), tuple(where), tuple(columns))


def _is_rigid(table: AnyTable, name: str, quantity: Quantity | None) -> bool:
    """Whether a column of springs or anchors has a rigid one anywhere."""
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
    """Rows as CSV, by default in SI, units in the header; returns how many."""
    from pyarrow import csv

    form = form or CsvForm()
    held = [rows.of.held[name] for name in rows.names]
    is_rigid = [
        _is_rigid(rows.table, name, quantity)
        for name, quantity in zip(rows.names, held, strict=True)
    ]
    heads = [
        f'"{form.header(name, quantity)}"' for name, quantity in zip(rows.names, held, strict=True)
    ]
    file.write((form.separator.join(heads) + "\n").encode())
    how, count = (
        csv.WriteOptions(include_header=False, quoting_style="needed", delimiter=form.separator),
        0,
    )
    for stretch in stretches or rows.batches():
        columns = [
            form.column(column, quantity, is_rigid=rigid)
            for column, quantity, rigid in zip(stretch.columns, held, is_rigid, strict=True)
        ]
        written = pa.BufferOutputStream()
        csv.write_csv(pa.table(columns, names=stretch.column_names), written, how)
        file.write(written.getvalue())
        count += stretch.num_rows
    return count


def export(rows: TableRows, path: Path, form: CsvForm | None = None) -> int:
    """Write rows as CSV, the whole file or none; returns how many. Raises UsageError, OutputError."""
    if path.suffix.lower() != ".csv":
        raise UsageError(
            f'"{shorten(path.name)}" is no name of a CSV file', hint="end it with .csv"
        )
    with whole_file(path) as temporary, output_errors(path), temporary.open("xb") as file:
        count = write_csv(rows, file, form=form)
        file.flush()
        os.fsync(file.fileno())
    return count
