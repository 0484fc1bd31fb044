"""What a sweep gave: its record with its warnings, and its tables as pandas and xarray have them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.display import Displayed, face
from tendon_cli.engine.journal import Journal
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.records import lost, read_record
from tendon_cli.engine.states import WorkedOut
from tendon_cli.engine.table_columns import Tables
from tendon_cli.errors import FolderError, InputError, UsageError, install_hint
from tendon_cli.files import result_path
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.load import recorded_study
from tendon_cli.tables.read import RECORDS, TableFiles, open_table

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    import xarray as xr

_LONGEST_LABEL = 30
Variable = tuple[tuple[str, ...], npt.NDArray[Any], dict[str, str]]
"""Dimensions, values and attributes, as xarray takes them."""


@dataclass(frozen=True, eq=False, repr=False)
class Result(Displayed):
    """What a command gave: its record, and its tables by name."""

    record: dict[str, Any]
    folder: Path | None = None
    """Where it stands; None in memory."""
    up_to_date: bool = False
    """Whether it had stood there before."""
    note: str | None = None
    """Why there is no slack map, if one was asked for."""
    tables: Mapping[str, pa.Table] = field(default_factory=dict, repr=False)
    """Those that are in memory."""

    def table(self, name: str) -> pa.Table:
        """A table as Arrow has it, every byte verified; raises InputError."""
        if name in self.tables:
            return self.tables[name]
        return open_table(Path(self.folder or "") / f"{name}.parquet").read()


@dataclass(frozen=True, eq=False, repr=False)
class Run(Result):
    """A finished run: `record` as in `run.json`, `designs` and `states` as tables with their units in `attrs`."""

    @property
    def text(self) -> str:
        """The summary of the run."""
        return str(face().run_text(self))

    @cached_property
    def designs(self) -> pd.DataFrame:
        """One row per design; raises UsageError if the study leaves the table out, InputError for a damaged one."""
        return framed(self.table("designs"))

    @cached_property
    def states(self) -> pd.DataFrame:
        """One row per design, direction and elbow angle; raises as `designs` does."""
        return framed(self.table("states"))

    def to_xarray(self) -> xr.Dataset:
        """The tables as one dataset: the study's axes are its dimensions, every variable has its unit.

        Needs the package xarray; raises UsageError without.
        """
        return _dataset(self.record, self.table)

    def table(self, name: str) -> pa.Table:
        """A table as Arrow has it, every byte verified; raises UsageError if the study leaves it out, InputError."""
        if name == "states" and name not in self.record["study"]["output"]["tables"]:
            return WorkedOut(
                self.record, self.record["study_hash"], (self.folder or Path(),)
            ).read()
        return self.tables[name] if name in self.tables else self.kept(name).read()

    def kept(self, name: str) -> TableFiles:
        """A table on the disk, every byte verified; raises as `table` does."""
        where = str(self.folder or "in memory")
        if name not in self.record["study"]["output"]["tables"]:
            hint = f'[output] tables needs "{name}"'
            raise UsageError(f"the run has no table of {name}", where=where, hint=hint)
        return open_table(Path(where) / f"{name}.parquet")


def framed(table: pa.Table) -> pd.DataFrame:
    """A table as pandas has it, with its units in `attrs`."""
    frame: pd.DataFrame = table.to_pandas()
    frame.attrs = json.loads(table.schema.metadata[b"PANDAS_ATTRS"])
    return frame


def verified_record(path: Path) -> dict[str, Any]:
    """The record of the finished run or answer in a folder, every byte of its tables verified.

    Raises InputError if there is none or a file of it is damaged, FolderError if it is unfinished.
    """
    if not path.is_dir():
        message = "is a file, expected the folder of a run" if path.exists() else "no such folder"
        raise InputError(message, where=str(path))
    record = read_record(path)
    if record is None:
        if header := Journal.read(path).header:
            verb = header.get("verb", "sweep")
            hint = f"`tendon {verb} --resume` finishes it; in Python {verb}(..., resume=True)"
            raise FolderError("holds an unfinished run", where=str(path), hint=hint)
        hint = "`tendon sweep` or `tendon design` writes one"
        raise InputError(
            f"is no run folder, it holds no {' or '.join(RECORDS.values())}",
            where=str(path),
            hint=hint,
        )
    for name in lost(path, record):
        hint = f"`tendon {record['verb']} --resume` computes just this anew"
        raise InputError("is missing, or not as it was written", where=str(path / name), hint=hint)
    return record


AnyResult: TypeAlias = str | PathLike[str] | Result


def folder_of(result: AnyResult) -> Path:
    """The folder in which a result stands; raises UsageError for one in memory."""
    if not isinstance(result, Result):
        return result_path(result)
    if result.folder is None:
        raise UsageError(
            "this result is in memory, expected one in a folder", hint="name one: sweep(study, out)"
        )
    return result.folder


def open_run(path: str | PathLike[str]) -> Run:
    """A finished run from its folder; its record and every byte of its tables are verified.

    Raises InputError if there is none or a file of it is damaged, FolderError if it is unfinished.

    >>> import tendon_cli as tendon
    >>> done = tendon.sweep(tendon.load_study("study.toml"), "results/mine")
    >>> run = tendon.open_run("results/mine")
    >>> run.record["designs"], len(run.states)
    (1, 182)
    >>> run.to_xarray()["motor_torque"].dims
    ('direction', 'elbow_angle')
    """
    path = result_path(path)
    record = verified_record(path)
    if record["verb"] != "sweep":
        raise InputError("holds an answer, expected the run of a sweep", where=str(path))
    return Run(record, path, up_to_date=True)


def xarray_library() -> Any:
    """The package xarray; raises UsageError if it is not installed."""
    try:
        import xarray as xr  # an optional extra
    except ImportError:
        hint = install_hint("xarray")
        raise UsageError(
            "to_xarray needs the package xarray, which is not installed", hint=hint
        ) from None
    return xr


def _dataset(record: Mapping[str, Any], table_of: Callable[[str], pa.Table]) -> xr.Dataset:
    """Both tables of a run, as far as it has them, from its record and what gives a table by its name.

    Nulls are NaN, or None in text. Raises UsageError without xarray.
    """
    library = xarray_library()
    plan = Plan(recorded_study(record))
    sizes = {axis.column: len(axis) for axis in plan.axes}
    motion = {"direction": len(plan.directions), "elbow_angle": len(plan.elbow_angles)}
    if plan.study.trajectory is not None:
        motion = {"time": len(plan.elbow_angles)}
    keys = {column.name for column in Tables(plan).leading} - {"design"} | set(motion)
    coordinates, variables = dict[str, Variable](), dict[str, Variable]()
    for table in ("designs", "states"):
        if table == "states":
            sizes |= motion
        if table not in plan.study.output.tables:
            continue
        for name, variable in variables_of(table_of(table), sizes).items():
            if name in keys:
                coordinates[name] = along_own_axes(name, variable)
            else:
                variables.setdefault(name, variable)
    facts = {name: record[name] for name in ("name", "title", "study_hash")}
    dataset: xr.Dataset = library.Dataset(variables, coordinates, facts)
    return dataset


def variables_of(table: pa.Table, sizes: dict[str, int]) -> dict[str, Variable]:
    """Every column in the shape of the product; the first names stand for the axes, whose rows come in that order."""
    shape, dimensions = tuple(sizes.values()), tuple(sizes)
    if table.num_rows != math.prod(shape):
        raise UsageError(f"the table has {table.num_rows} rows, the study {math.prod(shape)}")
    frame = table.to_pandas()
    variables = {}
    for held in table.schema:
        values = frame[held.name]
        array = (
            values.astype(object).to_numpy() if values.dtype == "category" else values.to_numpy()
        )
        meaning = {key.decode(): text.decode() for key, text in (held.metadata or {}).items()}
        attributes = {
            "units": meaning.get("unit", "1"),
            "long_name": label_of(held.name, meaning.get("long_name", "")),
        }
        attributes["description"] = meaning.get("long_name", "")
        variables[held.name] = (dimensions, array.reshape(shape), attributes)
    return variables


def label_of(name: str, meaning: str) -> str:
    """A name of a column that is short enough for an axis: what it means if that is short, else its name in words."""
    of_its_own = name in QUANTITIES and meaning != QUANTITIES[name].long_name
    return (
        meaning if meaning and (of_its_own or len(meaning) <= _LONGEST_LABEL) else say.column(name)
    )


def along_own_axes(name: str, variable: Variable) -> Variable:
    """A coordinate along the axes that it varies with: that of an axis along itself, a constant along none."""
    dimensions, values, attributes = variable
    for dimension in dimensions:
        axis = dimensions.index(dimension)
        first = values.take([0], axis=axis)
        same = (values == first) | ((values != values) & (first != first))  # noqa: PLR0124 - NaN differs from itself
        if dimension != name and (name in dimensions or np.all(same)):
            values, dimensions = (
                values.take(0, axis=axis),
                dimensions[:axis] + dimensions[axis + 1 :],
            )
    return dimensions, np.asarray(values), attributes
