"""Which table a path means: a file, one of a folder's, a CSV of people, or states that are worked out."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa

from tendon_cli.cube.columns import Columns, column_named
from tendon_cli.engine.states import WorkedOut
from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import read_file
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.figures import OF_STATES
from tendon_cli.studies.people.people_section import MAX_BYTES as MAX_PEOPLE_BYTES
from tendon_cli.studies.people.persons_csv import read_listed
from tendon_cli.tables.read import AnyTable, TableInMemory, open_table
from tendon_cli.tables.schema import Column
from tendon_cli.units import shorten
from tendon_cli.version import RESULTS_VERSION

TABLES = ("designs", "choices", "states", "conditions", "persons", "draws")
_OF_A_RUN = ("designs", "states")
_ONLY_IN_STATES = {"direction", "elbow_angle", "status", *OF_STATES}


def table_in(
    path: Path,
    wanted: str | None = None,
    asked: Collection[str] = (),
    *,
    order: Sequence[str] = TABLES,
) -> AnyTable:
    """A table, of the folder of a run or an answer the one that is wanted, or a file of people; every byte verified.

    Without a wish it is the first in `order` that has the columns `asked` for; states that a run did not keep are
    worked out. Raises InputError if there is none, UsageError for one that the folder has not.
    """
    return (
        _people_in(path)
        if path.suffix.lower() == ".csv"
        else table_at(path, wanted, asked, order=order)
    )


def table_at(
    path: Path,
    wanted: str | None = None,
    asked: Collection[str] = (),
    *,
    order: Sequence[str] = TABLES,
) -> AnyTable:
    """As `table_in`, of tables alone."""
    asked = {column_named(name) for name in asked}
    is_folder = path.is_dir() and path.suffix != ".parquet"
    if not is_folder:
        file_of(path, wanted)
    if wanted == "states" or (wanted is None and asked & _ONLY_IN_STATES):
        states = _states_in(path, asked)
        if states is not None:
            return states
    elif is_folder and wanted is None and asked:
        for name in _tables_of(path, order):
            table = open_table(path / f"{name}.parquet")
            if asked <= set(Columns.of(table.schema).held):
                return table
    return open_table(file_of(path, wanted, order=order))


def table_of_study(path: Path, wanted: str | None = None, asked: Collection[str] = ()) -> AnyTable:
    """A table of designs or states, to be drawn; raises as `table_in` does."""
    if path.is_dir() and path.suffix != ".parquet" and not _tables_of(path, _OF_A_RUN):
        hint = "run `tendon sweep`"
        raise InputError(
            "holds neither designs.parquet nor states.parquet", where=str(path), hint=hint
        )
    return table_at(path, wanted, asked, order=("states", "designs"))


def file_of(path: Path, wanted: str | None = None, *, order: Sequence[str] = TABLES) -> Path:
    """Where the table lies that a path means; raises InputError, UsageError."""
    if path.suffix.lower() in (".toml", ".yaml", ".yml"):
        hint = f"`tendon sweep {path}` runs it, `tendon plot --arm {path}` draws its arm"
        raise UsageError(
            "is a study, expected a table or the folder of a run", where=str(path), hint=hint
        )
    if not path.is_dir() or path.suffix == ".parquet":
        if wanted is not None and wanted != path.stem:
            hint = "without --table, or the folder that the table lies in"
            raise UsageError(f'is one table, not "{shorten(wanted)}"', where=str(path), hint=hint)
        return path
    names = _tables_of(path, order)
    if not names:
        raise InputError(
            "holds no table of tendon's", where=str(path), hint="`tendon sweep` writes some"
        )
    if wanted is not None and wanted not in names:
        hint = nearest(wanted, names) or f"there is {', '.join(names)}"
        raise UsageError(f'there is no table "{shorten(wanted)}"', where=str(path), hint=hint)
    return path / f"{wanted or names[0]}.parquet"


def _tables_of(folder: Path, order: Sequence[str]) -> list[str]:
    return [name for name in order if (folder / f"{name}.parquet").exists()]


def _states_in(path: Path, asked: Collection[str]) -> AnyTable | None:
    """The states of a run or of the study of a table, worked out unless they are kept; None if there are none."""
    if path.is_dir() and path.suffix != ".parquet":
        names = _tables_of(path, ("states", "designs"))
        table = open_table(path / f"{names[0]}.parquet") if names else None
    else:
        table = open_table(path) if path.suffix == ".parquet" and path.exists() else None
    if table is None or table.facts["table"] not in _OF_A_RUN:
        return None
    if table.facts["table"] == "states" and set(asked) <= set(Columns.of(table.schema).held):
        return table
    if not set(asked) <= set(Columns.of(table.schema).held) | _ONLY_IN_STATES:
        return None
    if table.facts["results_version"] != RESULTS_VERSION:
        hint = "`tendon sweep --overwrite` runs the study anew"
        raise InputError(
            "is of a version with other results, its states cannot be worked out",
            where=str(path),
            hint=hint,
        )
    return WorkedOut(table.facts["study"], str(table.facts["study_hash"]), table.files)


def _people_in(path: Path) -> TableInMemory:
    """A CSV of people as tendon reads it, in SI; raises InputError."""
    where = shorten(str(path), 1000)
    try:
        content = read_file(path, MAX_PEOPLE_BYTES)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=where) from None
    listed = read_listed(content, where)
    words: dict[str, Any] = {"name": listed.names, "sex": listed.sexes}
    fields, values = [], []
    for name in listed.columns:
        if name in words:
            fields.append(pa.field(name, pa.string()))
            values.append(pa.array(words[name]))
            continue
        is_body = name in DIMENSIONS
        column = (
            Column.of(QUANTITIES[name])
            if is_body
            else Column(name, "number", "1", "how much each counts")
        )
        fields.append(column.field)
        numbers = listed.values[:, DIMENSIONS.index(name)] if is_body else listed.weighting
        values.append(pa.array(numbers, from_pandas=True))
    return TableInMemory(pa.table(values, schema=pa.schema(fields)))
