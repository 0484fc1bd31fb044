"""Results of tasks: record, tables as pandas and xarray have them, and text; those of a sweep."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.engine.folder import look
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.records import damaged_files
from tendon_cli.engine.states import WorkedOut
from tendon_cli.engine.table_columns import PlanColumns
from tendon_cli.errors import FolderError, InputError, UsageError, install_hint
from tendon_cli.files import STUDIES, kind_of_file, result_path
from tendon_cli.quantities import QUANTITIES
from tendon_cli.say.display import Displayed
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.study import Study, keys
from tendon_cli.tables.read import TableFiles, check_version, open_table
from tendon_cli.verbs.answer_record import ChecksRecord
from tendon_cli.verbs.registry import TaskKind, by_name, kind_of, kinds, load, record_names

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    import xarray as xr

_MOST_PICTURED_DESIGNS = 10**5
"""Most designs of a run that a notebook draws without being asked."""
_LONGEST_LABEL = 30
"""Most characters of a meaning that labels an axis."""
Variable: TypeAlias = tuple[tuple[str, ...], npt.NDArray[Any], dict[str, str]]
"""Dimensions, values and attributes, as xarray takes them."""


@dataclass(frozen=True, eq=False, repr=False)
class Result(Displayed):
    """Result of a command: its record, and its tables by name."""

    record: dict[str, Any]
    folder: Path | None = None
    """Folder of the result; None in memory."""
    up_to_date: bool = False
    """True if it was in the folder already, and nothing was computed."""
    note: str | None = None
    """Why there is no slack map, if one was asked for."""
    tables: Mapping[str, pa.Table] = field(default_factory=dict, repr=False)
    """Tables that are in memory."""
    validated: Study | None = field(default=None, repr=False)
    """Study that was computed; None to read it from the record."""

    @property
    def kind(self) -> TaskKind:
        """Kind of the task whose result this is."""
        return kind_of(self.record)

    @cached_property
    def study(self) -> Study:
        """The study, validated once."""
        return recorded_study(self.record) if self.validated is None else self.validated

    @property
    def is_negative(self) -> bool:
        """True if the command exits with the code of a negative result."""
        return False

    def printed(self, *, whole: bool = False) -> str:
        """Return the text of the command: the result, its warnings, and where it is written.

        Args:
            whole: True for all that there is to say of the result.
        """
        record = self.record
        took = ", up to date" if self.up_to_date else f" in {say.number(record['seconds'], 3)} s"
        warnings = [f"warning: {warning}" for warning in record["warnings"]]
        files = ", ".join([*self.table_files, self.kind.record, *record["figures"]])
        option = self.kind.whole
        more = ""
        if option is not None and not whole:
            more = f"; {option.flag} prints the whole answer"
        text = self.text if whole else self.short
        written = f"{record['name']}{took}, in {self.folder}: {files}{more}"
        return "\n".join([text, *warnings, written])

    @property
    def table_files(self) -> list[str]:
        """Names of the files of tables, or of folders of their parts."""
        return list(dict.fromkeys(entry["path"].split("/")[0] for entry in self.record["files"]))

    def table(self, name: str) -> pa.Table:
        """Return a table as Arrow has it, every byte verified; raises InputError."""
        return self.tables[name] if name in self.tables else self.kept(name).read()

    def kept(self, name: str) -> TableFiles:
        """Return a table in the folder of the result, every byte verified; raises InputError."""
        return open_table(Path(self.folder or "") / f"{name}.parquet", by_name(self.record))


@dataclass(frozen=True, eq=False, repr=False)
class Run(Result):
    """Finished run of a sweep.

    `record` is that of `run.json`; `designs` and `states` are tables with units in `attrs`.
    """

    drawn_by: ClassVar[str] = "tendon_cli.face.page_of_run"
    documented: ClassVar[tuple[str, ...]] = ("designs", "states", "to_xarray")

    @property
    def is_pictured(self) -> bool:
        """True if a notebook draws the run without being asked."""
        return bool(self.record["designs"] <= _MOST_PICTURED_DESIGNS)

    @property
    def is_negative(self) -> bool:
        """True if states have no equilibrium."""
        return bool(self.record["no_equilibrium"])

    @property
    def text(self) -> str:
        """Summary of the run."""
        record = self.record
        lines = [*self.facts(), *(("warning", warning) for warning in record["warnings"])]
        if self.folder is not None:
            written = ", ".join([*self.table_files, *record["figures"]])
            lines.append(("written to", f"{self.folder}: {written}"))
        return "\n".join([self.head(), *(f"  {name:<14} {text}" for name, text in lines)])

    def printed(self, *, whole: bool = False) -> str:
        """Return the text of the command, which is the summary."""
        return self.text if whole else self.short

    def head(self) -> str:
        """Return the size of the run and how long it took, in a line."""
        record = self.record
        designs = say.counted(record["designs"], "design")
        states = say.counted(record["states"], "state")
        head = f"{record['name']}: {designs}, {states}"
        if self.up_to_date:
            return f"{head}, up to date"
        drawing = ""
        if record.get("figure_seconds"):
            drawing = f", figures in {say.number(record['figure_seconds'], 2)} s"
        return f"{head} in {say.number(record['seconds'], 3)} s{drawing}"

    def facts(self) -> list[tuple[str, str]]:
        """Return the results of the run, each with its name."""
        record = self.record
        designs = record["designs"]
        feasible = say.share(record["feasible"], designs, "design")
        checks = None
        if "checks" in record:
            checks = ChecksRecord.from_json(record["checks"])
        decided = say.cutoff_words(checks)
        facts = [("note", decided)] if decided else []
        facts += [
            ("feasible", f"{feasible}: taut, stable and within every limit"),
            ("  taut", say.share(record["taut"], designs, "design")),
            ("  stable", say.share(record["stable"], designs, "design")),
        ]
        if record["choices"] != designs:
            share = say.share(record["feasible_choices"], record["choices"], "choice")
            conditions = [_condition(key) for key in self.study.conditions]
            every = f"at every {say.join_words(conditions)}"
            if len(conditions) > 1:
                every = f"for every {say.join_words(conditions)} at once"
            facts.append(("choices", f"{share} feasible {every}"))
        facts.append(("slack", say.share(record["slack"], record["states"], "state")))
        if self.note:
            facts.append(("no slack map", self.note))
        return facts

    @cached_property
    def designs(self) -> pd.DataFrame:
        """One row per design.

        Raises UsageError if the study leaves the table out, InputError if the table is damaged.
        """
        return framed(self.table("designs"))

    @cached_property
    def states(self) -> pd.DataFrame:
        """One row per design, direction and elbow angle; raises as `designs` does."""
        return framed(self.table("states"))

    def to_xarray(self) -> xr.Dataset:
        """Return the tables as one dataset.

        The study's axes are its dimensions; every variable has its unit.

        Raises:
            UsageError: The package xarray is not installed.
        """
        return _dataset(self.record, self.study, self.table)

    def table(self, name: str) -> pa.Table:
        """Return a table as Arrow has it, every byte verified.

        States that the study does not keep are worked out.

        Raises:
            UsageError: The study leaves the table out.
            InputError: The table is damaged.
        """
        if name == "states" and not self._is_kept(name):
            return WorkedOut(self.study, (self.folder or Path(),)).read()
        return super().table(name)

    def kept(self, name: str) -> TableFiles:
        """Return a table in the run folder, every byte verified; raises as `table` does."""
        if not self._is_kept(name):
            where = str(self.folder or "in memory")
            hint = f'[output] tables needs "{name}"'
            raise UsageError(f"the run has no table of {name}", where=where, hint=hint)
        return super().kept(name)

    def _is_kept(self, name: str) -> bool:
        """Return True if the study keeps a table."""
        return name in self.record["study"]["output"]["tables"]


def to_pandas(table: pa.Table) -> pd.DataFrame:
    """Return a table as pandas has it.

    It starts no thread of Arrow's, under which the process might end.
    """
    frame: pd.DataFrame = table.to_pandas(use_threads=False)
    return frame


def framed(table: pa.Table) -> pd.DataFrame:
    """Return a table as pandas has it, with its units in `attrs`."""
    frame = to_pandas(table)
    frame.attrs = attributes_of(table.schema)
    return frame


def attributes_of(schema: pa.Schema) -> Any:
    """Return the `attrs` of a frame: units and meanings by column, and the hash of the study."""
    return json.loads(schema.metadata[b"PANDAS_ATTRS"])


def _condition(key: str) -> str:
    """Return the word for an axis of conditions."""
    if key == "load.mass":
        return "load"
    if key in keys():
        return say.column(keys()[key].quantity.name)
    return key


def open_result(path: Path) -> Result:
    """Open the finished result in a folder, of whatever task, and verify all its tables.

    Raises:
        InputError: There is none, or a file of it is damaged.
        FolderError: The run is unfinished.
    """
    record = _verified_record(path)
    result: Result = load(kind_of(record).result)(record, path, up_to_date=True)
    return result


def _verified_record(path: Path) -> dict[str, Any]:
    """Return the record of the finished run or answer in a folder, its tables verified.

    Raises:
        InputError: There is none, or a file of it is damaged.
        FolderError: The run is unfinished.
    """
    if not path.is_dir():
        raise _not_a_folder(path)
    contents = look(path)
    record = contents.record
    if record is None:
        if contents.run is not None:
            verb, _, version = contents.run
            check_version(path, {"verb": verb, "results_version": version})
            hint = f"`tendon {verb} --resume` finishes it; in Python {verb}(..., resume=True)"
            raise FolderError("holds an unfinished run", where=str(path), hint=hint)
        message = f"is not a run folder: it holds no {' or '.join(record_names())}"
        hint = " or ".join(f"`tendon {verb}`" for verb in kinds()) + " writes one"
        raise InputError(message, where=str(path), hint=hint)
    check_version(path, record)
    for name in damaged_files(path, record):
        hint = f"`tendon {record['verb']} --resume` computes just this file again"
        raise InputError("is missing, or not as it was written", where=str(path / name), hint=hint)
    return record


def _not_a_folder(path: Path) -> InputError:
    """Return the error for a path that is no folder; it says what a file is, and what to name."""
    if not path.exists():
        return InputError("no such folder", where=str(path))
    kind = kind_of_file(path)
    hint = None
    if kind in STUDIES:
        hint = f"`tendon sweep {path}` runs it"
    elif any((path.parent / name).exists() for name in record_names()):
        hint = f"name its folder: {path.parent}"
    problem = f"this is {kind or 'a file'}, expected the folder of a run"
    return InputError(problem, where=str(path), hint=hint)


AnyResult: TypeAlias = str | PathLike[str] | Result
"""A result, or the path of its folder."""


def folder_of(result: AnyResult) -> Path:
    """Return the folder of a result; raises UsageError for one in memory."""
    if not isinstance(result, Result):
        return result_path(result)
    if result.folder is None:
        raise UsageError(
            "this result is in memory, expected one in a folder", hint="name one: sweep(study, out)"
        )
    return result.folder


def xarray_library() -> Any:
    """Return the package xarray; raises UsageError if it is not installed."""
    try:
        import xarray as xr  # an optional extra
    except ImportError:
        hint = install_hint("xarray")
        raise UsageError(
            "to_xarray needs the package xarray, which is not installed", hint=hint
        ) from None
    return xr


def _dataset(
    record: Mapping[str, Any], study: Study, table_of: Callable[[str], pa.Table]
) -> xr.Dataset:
    """Return the tables that a run keeps as one dataset; null becomes NaN, or None in text.

    Args:
        record: Record of the run.
        study: Its study.
        table_of: Returns a table by its name.

    Raises:
        UsageError: The package xarray is not installed.
    """
    library = xarray_library()
    plan = Plan(study)
    sizes = {axis.column: len(axis) for axis in plan.axes}
    if plan.study.trajectory is None:
        motion = {"direction": len(plan.directions), "elbow_angle": len(plan.elbow_angles)}
    else:
        motion = {"time": len(plan.elbow_angles)}
    axis_columns = {column.name for column in PlanColumns(plan).leading} - {"design"}
    axis_columns |= set(motion)
    coordinates: dict[str, Variable] = {}
    variables: dict[str, Variable] = {}
    for table in ("designs", "states"):
        if table == "states":
            sizes |= motion
        if table not in plan.study.output.tables:
            continue
        for name, variable in variables_of(table_of(table), sizes).items():
            if name in axis_columns:
                coordinates[name] = along_own_axes(name, variable)
            else:
                variables.setdefault(name, variable)
    facts = {name: record[name] for name in ("name", "title", "study_hash")}
    dataset: xr.Dataset = library.Dataset(variables, coordinates, facts)
    return dataset


def variables_of(table: pa.Table, sizes: dict[str, int]) -> dict[str, Variable]:
    """Return every column of a table in the shape of the product.

    Args:
        table: The table, its rows in the order of the product.
        sizes: Number of values on each axis by its name, slowest first.

    Raises:
        UsageError: The table does not have as many rows as the product.
    """
    dimensions = tuple(sizes)
    shape = tuple(sizes.values())
    if table.num_rows != math.prod(shape):
        raise UsageError(f"the table has {table.num_rows} rows, the study {math.prod(shape)}")
    frame = to_pandas(table)
    variables = {}
    for column in table.schema:
        series = frame[column.name]
        if series.dtype == "category":
            series = series.astype(object)
        metadata = {key.decode(): text.decode() for key, text in (column.metadata or {}).items()}
        meaning = metadata.get("long_name", "")
        attributes = {
            "units": metadata.get("unit", "1"),
            "long_name": label_of(column.name, meaning),
            "description": meaning,
        }
        values = series.to_numpy().reshape(shape)
        variables[column.name] = (dimensions, values, attributes)
    return variables


def label_of(name: str, meaning: str) -> str:
    """Return the label of a column for an axis.

    It is the column's meaning if that is short, or if it differs from the meaning of the quantity
    (as "pretension, read as ..." does), else the column's name in words.
    """
    if not meaning:
        return say.column(name)
    has_own_meaning = name in QUANTITIES and meaning != QUANTITIES[name].long_name
    if has_own_meaning or len(meaning) <= _LONGEST_LABEL:
        return meaning
    return say.column(name)


def along_own_axes(name: str, variable: Variable) -> Variable:
    """Return a coordinate without the dimensions along which it does not vary.

    The coordinate of an axis keeps that axis alone, a constant keeps none.
    """
    dimensions, values, attributes = variable
    for dimension in dimensions:
        if dimension == name:
            continue
        axis = dimensions.index(dimension)
        first = values.take([0], axis=axis)
        is_same = values == first
        both_nan = (values != values) & (first != first)  # noqa: PLR0124 - NaN differs from itself
        if name in dimensions or np.all(is_same | both_nan):
            values = values.take(0, axis=axis)
            dimensions = dimensions[:axis] + dimensions[axis + 1 :]
    return dimensions, np.asarray(values), attributes
