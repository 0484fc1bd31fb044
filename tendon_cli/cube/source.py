"""Finding the table that a path means: a file, one in a folder, a CSV of people, or states."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from tendon_cli.cube.columns import TableColumns, column_named
from tendon_cli.cube.cube import study_of
from tendon_cli.engine.states import WorkedOut
from tendon_cli.engine.sweep_kind import SWEEP
from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import read_input
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.figures import OF_STATES
from tendon_cli.studies.file_content import MAX_BYTES as MAX_PEOPLE_BYTES
from tendon_cli.studies.load import load_study
from tendon_cli.studies.model_words import WORDS_OF
from tendon_cli.studies.people.persons_csv import read_persons
from tendon_cli.studies.row_table import NAME, RowTable, carried_cells
from tendon_cli.studies.space.axis import split_side
from tendon_cli.studies.study import Study, keys
from tendon_cli.tables.read import AnyTable, TableInMemory, open_table, records_in
from tendon_cli.tables.schema import Column
from tendon_cli.units import SI_UNIT, shorten
from tendon_cli.verbs.registry import record_names, table_kinds, tables_of
from tendon_cli.version import RESULTS_VERSION

STUDY_FILES = (".toml", ".yaml", ".yml")
"""Endings of the files of studies."""
_DRAWN = SWEEP.table_names[::-1]
"""Tables of a sweep, the one first that is drawn if it has what is asked for."""
_ONLY_IN_STATES = {"direction", "elbow_angle", "status", *OF_STATES}


def table_in(
    path: Path,
    wanted: str | None = None,
    asked: Collection[str] = (),
    *,
    is_drawn: bool = False,
    study: Study | None = None,
    records: Mapping[str, Any] | None = None,
) -> AnyTable:
    """Open the table that a path means, every byte verified.

    States that a run did not keep are worked out. A `[[table]]` of a study is read by its name,
    from the study's file or from the folder of its run.

    Args:
        path: A table, the folder of a run or an answer, a CSV file of people, or a study.
        wanted: Name of the table in the folder; None for the first that has `asked`.
        asked: Columns that the table must have.
        is_drawn: True for a table of designs or states alone, to be drawn.
        study: Its study, if the caller has it already.
        records: Records in its folder by the names of their files, if the caller has them already.

    Raises:
        InputError: There is no table.
        UsageError: The folder does not have the wanted table.
    """
    if not is_drawn and path.suffix.lower() == ".csv":
        return _people_in(path)
    if not is_drawn and wanted is not None and wanted not in table_kinds():
        rows = _rows_in(path, wanted)
        if rows is not None:
            return rows
    order = _DRAWN if is_drawn else None
    is_folder = _is_folder(path)
    if not is_folder:
        file_of(path, wanted)
    elif is_drawn and not tables_of(path, order):
        raise _nothing_to_draw(path)
    if records is None:
        records = records_in(path if is_folder else path.parent)
    asked = {column_named(name) for name in asked}
    if wanted == "states" or (wanted is None and asked & _ONLY_IN_STATES):
        states = _states_in(path, asked, records, study)
        if states is not None:
            return states
    elif is_folder and wanted is None and asked:
        for name in tables_of(path, order):
            table = open_table(path / f"{name}.parquet", records)
            if asked <= set(TableColumns.of(table.schema).quantities):
                return table
    return open_table(file_of(path, wanted, order=order), records)


def _nothing_to_draw(path: Path) -> InputError:
    """Return the error of a folder without designs and states."""
    hint = "run `tendon sweep`"
    if any((path / name).exists() for name in record_names() if name != SWEEP.record):
        hint = (
            f"`tendon plot {path}` draws its figures, with --between its window over the angle;"
            f" `tendon report {path}` writes a page with all"
        )
    problem = "holds neither designs.parquet nor states.parquet"
    return InputError(problem, where=str(path), hint=hint)


def file_of(path: Path, wanted: str | None = None, *, order: Sequence[str] | None = None) -> Path:
    """Return the path of the table that a path means.

    Args:
        path: A table, or the folder of a run or an answer.
        wanted: Name of the table in the folder; None for the first in `order`.
        order: Names of tables, preferred ones first; None for all, in the order of their kinds.

    Raises:
        InputError: The folder holds no table.
        UsageError: The path is that of a study, or of another table than the wanted one.
    """
    if path.suffix.lower() in STUDY_FILES:
        hint = (
            f"`tendon sweep {path}` runs it, `tendon plot --arm {path}` draws its arm, and"
            " --table NAME means the rows of one of its [[table]]"
        )
        raise UsageError(
            "is a study, expected a table or the folder of a run", where=str(path), hint=hint
        )
    if not _is_folder(path):
        if wanted is not None and wanted != path.stem and path.exists():
            hint = "without --table, or the folder that the table lies in"
            raise UsageError(f'is one table, not "{shorten(wanted)}"', where=str(path), hint=hint)
        return path
    names = tables_of(path, order)
    if not names:
        raise InputError(
            "holds no table written by tendon", where=str(path), hint="run `tendon sweep` first"
        )
    if wanted is not None and wanted not in names:
        hint = hint_at_nearest(wanted, names) or f"there is {', '.join(names)}"
        raise UsageError(f'there is no table "{shorten(wanted)}"', where=str(path), hint=hint)
    return path / f"{wanted or names[0]}.parquet"


def _is_folder(path: Path) -> bool:
    """Return True if a path is a folder other than that of a table's parts."""
    return path.is_dir() and path.suffix != ".parquet"


def _states_in(
    path: Path, asked: Collection[str], records: Mapping[str, Any], study: Study | None
) -> AnyTable | None:
    """Open the states of a run, or of a table's study; None if there are none with such columns.

    States that were not kept, or not with all columns, are worked out.

    Args:
        path: A table, or the folder of a run.
        asked: Columns that the states must have.
        records: Records in the folder, by the names of their files.
        study: The study, if the caller has it already.
    """
    file = path
    if _is_folder(path):
        names = tables_of(path, _DRAWN)
        if not names:
            return None
        file = path / f"{names[0]}.parquet"
    table = open_table(file, records)
    if table.facts["table"] not in _DRAWN:
        return None
    held = set(TableColumns.of(table.schema).quantities)
    if table.facts["table"] == "states" and set(asked) <= held:
        return table
    if not set(asked) <= held | _ONLY_IN_STATES:
        return None
    if table.facts["results_version"] != RESULTS_VERSION:
        hint = "`tendon sweep --overwrite` runs the study again"
        raise InputError(
            "was written by a version with other results, so its states cannot be computed",
            where=str(path),
            hint=hint,
        )
    return WorkedOut(study_of(table) if study is None else study, table.files)


def _rows_in(path: Path, wanted: str) -> TableInMemory | None:
    """Return a `[[table]]` of a study by its name; None if the run in a folder has none of it.

    Args:
        path: File of the study, or the folder of its run or its answer.
        wanted: Name of the table.

    Raises:
        UsageError: The study has no such table.
    """
    is_study = path.suffix.lower() in STUDY_FILES
    study = load_study(path) if is_study else study_of(table_in(path))
    tables = {rows.key: rows for rows in study.row_tables}
    if wanted in tables:
        return _table_of_rows(tables[wanted])
    if not is_study:
        return None
    hint = hint_at_nearest(wanted, tables) or f"its tables: {', '.join(tables) or 'none'}"
    problem = f'the study has no table "{shorten(wanted)}"'
    raise UsageError(problem, where=str(path), hint=hint)


def _table_of_rows(rows: RowTable) -> TableInMemory:
    """Return the rows of a study's table, SI, under headers by which a study reads them again."""
    fields = [pa.field(NAME, pa.string())]
    arrays = [pa.array(rows.names)]
    for key, values in rows.numbers.items():
        words = WORDS_OF.get(split_side(key)[0])
        if words is not None:
            texts = [None if np.isnan(value) else words[int(value)] for value in values]
            fields.append(pa.field(key, pa.string()))
            arrays.append(pa.array(texts, pa.string()))
            continue
        column = Column.of(keys()[key].number.quantity, key)
        if key in rows.readings:
            column = replace(column, unit=SI_UNIT[rows.readings[key]])
        fields.append(column.field)
        arrays.append(pa.array(values, from_pandas=True))
    for carried in rows.carried:
        if carried.words:
            fields.append(pa.field(carried.name, pa.string()))
            arrays.append(pa.array(carried_cells(carried), pa.string()))
            continue
        column = Column(carried.name, "number", carried.unit or "1", carried.name)
        fields.append(column.field)
        arrays.append(pa.array(carried.values, from_pandas=True))
    return TableInMemory(pa.table(arrays, schema=pa.schema(fields)))


def _people_in(path: Path) -> TableInMemory:
    """Read a CSV file of people as tendon understands it, SI; raises InputError."""
    where = shorten(str(path), 1000)
    try:
        content = read_input(path, MAX_PEOPLE_BYTES)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=where) from None
    listed = read_persons(content, where)
    words: dict[str, Any] = {"name": listed.names, "sex": listed.sexes}
    fields = []
    arrays = []
    for name in listed.columns:
        if name in words:
            field = pa.field(name, pa.string())
            array = pa.array(words[name])
        elif name in DIMENSIONS:
            field = Column.of(QUANTITIES[name]).field
            array = pa.array(listed.values[:, DIMENSIONS.index(name)], from_pandas=True)
        else:
            field = Column(name, "number", "1", "how much each counts").field
            array = pa.array(listed.weighting, from_pandas=True)
        fields.append(field)
        arrays.append(array)
    return TableInMemory(pa.table(arrays, schema=pa.schema(fields)), tuple(listed.ignored))
