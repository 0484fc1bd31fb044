"""What may stand for the value of an option, as typer asks: words of tendon, and those of the tables and studies named.

Each function gives words and what each means, for the command of a context that typer has read as far as it goes.
"""

from pathlib import Path
from typing import Any

import typer

from tendon_cli.errors import TendonError

_MOST_NAMES = 1000


def settings() -> list[Any]:
    """Every key of a study with `=`, and with each of its values if these are few words."""
    from tendon_cli.studies.schema import key_words

    return [(f"{key}={value}", meaning) for key, (meaning, values) in key_words().items() for value in ("", *values)]


def keys() -> list[Any]:
    """Every key of a study that holds numbers."""
    from tendon_cli.studies.study import keys as numbers

    return [(path, key.number.quantity.long_name) for path, key in numbers().items()]


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
    return [*NAMED, *names[:_MOST_NAMES]]


def columns(ctx: typer.Context, incomplete: str) -> list[Any]:
    """Columns of the table that the line names, else every one that there may be, after those of a list or a sign."""
    before = incomplete[: incomplete.rfind(",") + 1] or ("-" if incomplete.startswith("-") else "")
    return [(before + name, meaning) for name, meaning in (_held(ctx) or _possible()).items()]


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


def _held(ctx: typer.Context) -> dict[str, str]:
    """Columns of the table that the line names with their meanings, unverified; empty if there is none."""
    source = _source(ctx)
    if source is None:
        return {}
    from tendon_cli.cube.source import file_of, table_in
    from tendon_cli.tables.read import TableFiles

    try:
        if source.suffix.lower() == ".csv":
            schema = table_in(source).schema
        else:
            file = file_of(source, ctx.params.get("table"))
            file = min(file.glob("part-*.parquet")) if file.is_dir() else file
            if not file.is_file():  # a pipe would be waited for
                return {}
            schema = TableFiles((file,)).schema
    except (TendonError, OSError, ValueError):  # an error of Arrow is one of the latter two
        return {}
    return {name: (schema.field(name).metadata or {}).get(b"long_name", b"").decode() for name in schema.names}


def _possible() -> dict[str, str]:
    """Every column that a table of tendon may have, with its meaning."""
    from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES, QUANTITIES
    from tendon_cli.studies.study import keys as numbers

    results = {name: QUANTITIES[name].long_name for name in (*OF_DESIGNS, *OF_STATES, *OF_CYCLES)}
    return results | {key.column: key.number.quantity.long_name for key in numbers().values()}
