"""What may stand for the value of an option, as typer asks: words of tendon, and those of the tables and studies named.

Each function gives words and what each means, for the command of a context that typer has read as far as it goes.
"""

import re
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from tendon_cli.errors import TendonError

if TYPE_CHECKING:
    from tendon_cli.cube.rows import TableRows

_RELATION = re.compile(r"\s*([A-Za-z_][\w.]*)\s*(?:<=|>=|!=|==|=|<|>|\bin\b)\s*(?:.*,\s*)?")
_MOST_VALUES = 50
_MOST_STRETCHES = 16
_MOST_NAMES = 1000


def settings() -> list[Any]:
    """Every key of a study with `=`, and with each of its values if these are few words."""
    from tendon_cli.studies.schema import key_words

    return [(f"{key}={value}", meaning) for key, (meaning, values) in key_words().items() for value in ("", *values)]


def keys() -> list[Any]:
    """Every key of a study that holds numbers."""
    from tendon_cli.studies.study import keys as numbers

    return [(path, key.number.quantity.long_name) for path, key in numbers().items()]


def columns(ctx: typer.Context, incomplete: str) -> list[Any]:
    """Columns of the table that the line names, else every one that there may be, after those of a list or a sign."""
    before = incomplete[: incomplete.rfind(",") + 1] or ("-" if incomplete.startswith("-") else "")
    return [(before + name, meaning) for name, meaning in _columns(_rows(ctx))]


def filters(ctx: typer.Context, incomplete: str) -> list[Any]:
    """Columns, and after a relation the values that the column has."""
    match, rows = _RELATION.match(incomplete), _rows(ctx)
    if match is None or rows is None:
        return _columns(rows)
    return [match[0] + value for value in _values_of(rows, match[1])]


def units() -> list[Any]:
    """Every unit with its dimension."""
    from tendon_cli.units import UNITS

    return [(unit.symbol, unit.dimension) for unit in UNITS.values()]


def sizes() -> list[Any]:
    """The sizes of figures that have a name."""
    return [("column", "85 mm"), ("page", "175 mm")]


def templates() -> list[Any]:
    """The questions that a study can start from."""
    from tendon_cli.studies.starter import TEMPLATES

    return list(TEMPLATES.items())


def tables(ctx: typer.Context) -> list[Any]:
    """The tables of the folder that the line names, else all that there may be."""
    from tendon_cli.cube.source import TABLES

    source = _source(ctx)
    return [name for name in TABLES if source is not None and (source / f"{name}.parquet").exists()] or list(TABLES)


def cases(ctx: typer.Context) -> list[Any]:
    """Those of the study that the line names."""
    study = _study(ctx)
    return [case.name for case in study.cases] if study is not None else []


def persons(ctx: typer.Context) -> list[Any]:
    """Those of every survey, and those of the study that the line names."""
    from tendon_cli.studies.people.population import NAMED

    study = _study(ctx)
    names = study.people.population.names if study is not None and study.people is not None else ()
    return [name for name in (*NAMED, *names[:_MOST_NAMES]) if name.isprintable()]


def _source(ctx: typer.Context) -> Path | None:
    """The run, table or study that the line names first."""
    first = next((each.name for each in ctx.command.params if each.param_type_name == "argument"), "")
    return ctx.params.get(first or "")


def _study(ctx: typer.Context) -> Any:
    """The study that the line names; None if it cannot be read."""
    source = _source(ctx)
    if source is None or str(source) == "-":
        return None
    from tendon_cli.studies.load import load_study

    try:
        return load_study(source)
    except TendonError:
        return None


def _columns(rows: "TableRows | None") -> list[tuple[str, str]]:
    """Columns of a table, or without one every column that a table of tendon may have."""
    if rows is not None:
        held = rows.table.schema
        meanings = {name: (held.field(name).metadata or {}).get(b"long_name", b"").decode() for name in held.names}
        return [(name, meaning) for name, meaning in meanings.items() if name.isprintable()]
    from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES, QUANTITIES
    from tendon_cli.studies.study import keys as numbers

    results = {name: QUANTITIES[name].long_name for name in (*OF_DESIGNS, *OF_STATES, *OF_CYCLES)}
    return list((results | {key.column: key.number.quantity.long_name for key in numbers().values()}).items())


def _values_of(rows: "TableRows", name: str) -> list[str]:
    """What a column holds, as a filter takes it, if these are few values."""
    from tendon_cli import say

    try:
        column = rows.of.find(name, "--where")
    except TendonError:
        return []
    values: dict[Any, None] = {}
    for stretch in islice(rows.table.stretches([column]), _MOST_STRETCHES):
        values |= dict.fromkeys(stretch[column].unique().drop_null().to_pylist())
        if len(values) > _MOST_VALUES:
            return []
    quantity = rows.of.held[column]
    if quantity is not None:
        return [say.quantity(quantity, value, 6).replace(",", "") for value in values]
    words = [str(value).lower() if isinstance(value, bool) else str(value) for value in values]
    return [word for word in words if word.isprintable()]


def _rows(ctx: typer.Context) -> "TableRows | None":
    """The table that the line names, unverified; None if there is none."""
    source = _source(ctx)
    if source is None:
        return None
    from tendon_cli.cube.rows import TableRows
    from tendon_cli.cube.source import file_of, table_in
    from tendon_cli.tables.read import TableFiles

    try:
        if source.suffix.lower() == ".csv":
            return TableRows(table_in(source))
        file = file_of(source, ctx.params.get("table"))
        files = sorted(file.glob("part-*.parquet")) if file.is_dir() else [file]
        if not all(each.is_file() for each in files):  # a pipe would be waited for
            return None
        rows = TableRows(TableFiles(tuple(files)))
        rows.table.schema  # noqa: B018 - what cannot be read shows here
    except (TendonError, OSError, ValueError, IndexError):  # an error of Arrow is a ValueError or an OSError
        return None
    return rows
