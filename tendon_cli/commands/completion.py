"""Candidates with which a shell completes values: words of tendon, and of tables and studies.

Typer (`tendon --install-completion`) calls the functions that return them with the context of the
command, parsed as far as the line goes. A candidate is a word, or a word with its meaning.
"""

import os
import re
from pathlib import Path
from typing import Any

import typer
import typer.completion

from tendon_cli.errors import TendonError

_MOST_NAMES = 1000
"""Largest number of persons of a study that are offered."""


def complete_in_bash() -> None:
    """Let typer complete in bash what has a "=" or a sign in it that bash would read as code.

    Bash takes a word apart at "=", and asks for the part behind it alone.
    """
    shells: Any = typer.completion.shell_completion  # type: ignore[attr-defined]

    class Bash(shells.get_completion_class("bash")):  # type: ignore[misc]  # untyped
        """Completion of bash, which is given only the part of each word behind its last "="."""

        def get_completion_args(self) -> tuple[list[str], str]:
            words = os.environ["COMP_WORDS"].split("\n")[: int(os.environ["COMP_CWORD"]) + 1]
            line = re.sub(r"\n?=\n?", "=", "\n".join(words))
            os.environ |= {"COMP_WORDS": line, "COMP_CWORD": str(line.count("\n"))}
            args, self.begun = super().get_completion_args()
            self.quote = words[-1][:1]
            return args, self.begun

        def get_completions(self, args: list[str], incomplete: str) -> list[Any]:
            found = super().get_completions(args, incomplete)
            found = [item for item in found if item.value != incomplete]
            if len(found) == 1 and found[0].value.endswith("="):
                # Bash puts a space behind the only word that it is given.
                found.append(type(found[0])(f"{found[0].value}..."))
            return found

        def format_completion(self, item: Any) -> str:
            before = ""
            if self.quote not in ("'", '"'):
                before = self.begun[: self.begun.rfind("=") + 1]
            return _for_bash(item.value.removeprefix(before), self.quote)

    shells.add_completion_class(Bash, "bash")


def _for_bash(word: str, quote: str) -> str:
    """Return a word escaped for bash, so that the line runs no part of it."""
    if quote == "'":
        return word.replace("'", "'\\''")
    if quote == '"':
        return re.sub(r'(["$`\\])', r"\\\1", word)
    return re.sub(r"([^\w@%+=:,./-])", r"\\\1", word)


def settings() -> list[Any]:
    """Return all keys of a study with `=`, and with each of their values if these are few words."""
    from tendon_cli.studies.json_schema import key_words

    return [
        (f"{key}={value}", meaning)
        for key, (meaning, values) in key_words().items()
        for value in ("", *values)
    ]


def keys() -> list[Any]:
    """Return all keys of a study that hold numbers."""
    from tendon_cli.studies.study import keys as number_keys

    return [(path, key.quantity.long_name) for path, key in number_keys().items()]


def templates() -> list[Any]:
    """Return the questions that a study can start from."""
    from tendon_cli.commands.starter import TEMPLATES

    return list(TEMPLATES.items())


def tables(ctx: typer.Context) -> list[Any]:
    """Return the tables of the folder or the study that the line names, or else of every kind."""
    from tendon_cli.verbs.registry import table_kinds, tables_of

    source = _source(ctx)
    if source is not None and source.suffix.lower() in (".toml", ".yaml", ".yml"):
        study = _study(ctx)
        return [table.key for table in study.row_tables] if study is not None else []
    if source is not None:
        found = tables_of(source)
        if found:
            return found
    return list(table_kinds())


def cases(ctx: typer.Context) -> list[Any]:
    """Return the cases of the study that the line names."""
    study = _study(ctx)
    return list(study.cases.names) if study is not None and study.cases else []


def rows(ctx: typer.Context) -> list[Any]:
    """Return the rows of the tables of the study that the line names, as TABLE=NAME."""
    study = _study(ctx)
    tables = study.row_tables if study is not None else ()
    return [f"{table.key}={name}" for table in tables for name in table.names[:_MOST_NAMES]]


def persons(ctx: typer.Context) -> list[Any]:
    """Return the standard persons, and those of the study that the line names."""
    from tendon_cli.studies.people.population import STANDARD_PERSONS

    study = _study(ctx)
    if study is None or study.people is None:
        return list(STANDARD_PERSONS)
    return [*STANDARD_PERSONS, *study.people.population.persons[:_MOST_NAMES]]


def columns(ctx: typer.Context, incomplete: str) -> list[Any]:
    """Return the columns of the table that the line names, or else all columns of tendon.

    Each has the other columns of a list before it.
    """
    before = incomplete[: incomplete.rfind(",") + 1]
    names = _columns_of_table(ctx) or _all_columns()
    return [(before + name, meaning) for name, meaning in names.items()]


def _source(ctx: typer.Context) -> Path | None:
    """Return the run, table or study that the line names first."""
    for parameter in ctx.command.params:
        if parameter.param_type_name == "argument":
            return ctx.params.get(parameter.name or "")
    return None


def _study(ctx: typer.Context) -> Any:
    """Return the study that the line names; None if it cannot be read."""
    source = _source(ctx)
    if source is None or str(source) == "-":
        return None
    from tendon_cli.studies.load import load_study

    try:
        return load_study(source)
    except TendonError:
        return None


def _columns_of_table(ctx: typer.Context) -> dict[str, str]:
    """Return the columns of the tables that the line means with their meanings, unverified.

    A figure takes its columns from any table of a folder. There are none if the line names no
    table.
    """
    source = _source(ctx)
    if source is None:
        return {}
    from tendon_cli.cube.source import file_of, table_in
    from tendon_cli.verbs.registry import tables_of

    table = ctx.params.get("table")
    names: list[Any] = [table]
    if ctx.info_name == "plot" and table is None and source.is_dir():
        names = tables_of(source)
    meanings: dict[str, str] = {}
    try:
        if source.suffix.lower() == ".csv":
            return dict.fromkeys(table_in(source).schema.names, "")
        for name in names:
            meanings |= _columns_of(file_of(source, name))
    except (TendonError, OSError, ValueError):  # errors of Arrow are among the latter two
        return {}
    return meanings


def _columns_of(file: Path) -> dict[str, str]:
    """Return the columns of a table's file with their meanings."""
    from tendon_cli.tables.read import TableFiles

    if file.is_dir():
        file = min(file.glob("part-*.parquet"))
    if not file.is_file():  # opening a pipe would wait
        return {}
    schema = TableFiles((file,)).schema
    meanings = {}
    for name in schema.names:
        metadata = schema.field(name).metadata or {}
        meanings[name] = metadata.get(b"long_name", b"").decode()
    return meanings


def _all_columns() -> dict[str, str]:
    """Return all columns that a table of tendon may have, with their meanings."""
    from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES, QUANTITIES
    from tendon_cli.studies.study import keys as number_keys

    results = {name: QUANTITIES[name].long_name for name in (*OF_DESIGNS, *OF_STATES, *OF_CYCLES)}
    numbers = {key.column: key.quantity.long_name for key in number_keys().values()}
    return results | numbers
