"""What a table's columns are: their names, types, units and meaning, as Arrow and pandas understand them."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
import pyarrow as pa

from tendon_cli.quantities import Quantity
from tendon_cli.version import __version__

Kind = Literal["number", "text", "count", "truth"]

ROW_GROUP = 2**17
"""Rows in a row group of every table."""


@dataclass(frozen=True)
class Column:
    """A column of a table. A text column holds positions in `choices`; `is_axis` marks what few values repeat in.

    A column of numbers that cannot be null in its table is not `nullable`: it is smaller, and sooner written.

    `quantity` is the name of what it holds in `quantities`; what is none goes by the column's name.
    """

    name: str
    kind: Kind
    unit: str
    long_name: str
    is_axis: bool = False
    choices: tuple[str, ...] = ()
    quantity: str = ""
    nullable: bool = True

    @classmethod
    def of(cls, quantity: Quantity, name: str | None = None, *, is_axis: bool = False, nullable: bool = True) -> Column:
        """A column of numbers of a quantity, under its name or another."""
        named = name or quantity.name
        meaning = quantity.unit, quantity.long_name
        return cls(named, "number", *meaning, is_axis=is_axis, quantity=quantity.name, nullable=nullable)

    @cached_property
    def type(self) -> pa.DataType:
        """The Arrow type; text is a dictionary, which pandas reads as a categorical."""
        if self.kind == "text":
            return pa.dictionary(pa.int8() if self.dtype == np.int8 else pa.int32(), pa.string())
        return {"number": pa.float64(), "count": pa.int64(), "truth": pa.bool_()}[self.kind]

    @cached_property
    def dtype(self) -> np.dtype[Any]:
        """What its values are collected as; text by its place in `choices`."""
        place = np.int8 if len(self.choices) < 128 else np.int32
        return np.dtype({"number": np.float64, "text": place, "count": np.int64, "truth": np.bool_}[self.kind])

    @cached_property
    def words(self) -> pa.StringArray:
        """Its choices as Arrow has them; built from buffers, because the library's conversions import pandas."""
        encoded = [word.encode() for word in self.choices]
        ends = np.cumsum([0, *map(len, encoded)], dtype=np.int32)
        return pa.StringArray.from_buffers(len(encoded), pa.py_buffer(ends), pa.py_buffer(b"".join(encoded)))

    @property
    def field(self) -> pa.Field:
        """The Arrow field with its unit and meaning as metadata."""
        meaning = {"unit": self.unit, "long_name": self.long_name, "quantity": self.quantity or self.name}
        return pa.field(self.name, self.type, nullable=self.nullable and self.kind == "number", metadata=meaning)


@dataclass(frozen=True)
class TableLayout:
    """The layout of a file of a table: its columns, its schema with what it says of itself, and how many rows."""

    columns: tuple[Column, ...]
    schema: pa.Schema
    rows: int
    at_once: int = ROW_GROUP
    """How many rows are collected before they are written: a multiple of `row_group`."""
    row_group: int = ROW_GROUP


def schema_of(columns: Sequence[Column], facts: Mapping[str, Any]) -> pa.Schema:
    """The Arrow schema of a table; each fact becomes a JSON text under `tendon.<name>` in the file's metadata.

    The key that pandas keeps its attributes under is set too, so that `DataFrame.attrs["units"]` has the units.
    """
    attributes = {
        "units": {column.name: column.unit for column in columns},
        "long_names": {column.name: column.long_name for column in columns},
        "study_hash": facts.get("study_hash"),
    }
    metadata = {f"tendon.{name}": json.dumps(fact, sort_keys=True) for name, fact in facts.items()}
    metadata["PANDAS_ATTRS"] = json.dumps(attributes, sort_keys=True)
    return pa.schema([column.field for column in columns], metadata=metadata)


def versions() -> dict[str, str]:
    """The versions that the bytes of a table may depend on."""
    return {
        "tendon": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "pyarrow": pa.__version__,
    }
