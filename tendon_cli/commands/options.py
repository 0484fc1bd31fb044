"""Arguments and options that several commands have, and functions that make and read them."""

# No `from __future__ import annotations` in the commands: typer would compile each annotation
# anew, at every start.

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from tendon_cli.commands import completion
from tendon_cli.errors import UsageError


def option(
    metavar: str,
    text: str,
    *names: str,
    completer: Callable[..., list[Any]] | None = None,
    **more: Any,
) -> Any:
    """Make an option with a value.

    Args:
        metavar: Name of the value in the help; with "|" in it, the words that the value may be.
        text: Help.
        names: Names of the option; by default that of its parameter.
        completer: Function that completes the value, unless `metavar` lists the words.
        more: Further arguments of `typer.Option`.
    """
    words = metavar.split("|")
    complete = completer
    if len(words) > 1:
        complete = lambda: words  # noqa: E731 - typer asks for a function
    return typer.Option(*names, metavar=metavar, help=text, autocompletion=complete, **more)


def read_path(text: str | Path) -> Path:
    """Return the path of a file or folder to read; raise UsageError for a text that cannot be one.

    A default is a path already.
    """
    from tendon_cli.files import path_of

    return path_of(text)


def results_path(text: str | Path) -> Path:
    """Return the path of a folder of results or a file to write; its name must be UTF-8.

    Raise UsageError for a text that cannot be one.
    """
    from tendon_cli.files import result_path

    return result_path(text)


def split_names(texts: list[str] | None) -> tuple[str, ...]:
    """Return names that are separated by commas, or given one by one."""
    names = [name.strip() for text in texts or () for name in text.split(",")]
    return tuple(name for name in names if name)


def rows_by_table(texts: list[str] | None) -> dict[str, str]:
    """Return the rows that are chosen as TABLE=NAME, by their tables; raise UsageError."""
    rows: dict[str, str] = {}
    for text in texts or ():
        table, equals, name = (part.strip() for part in text.partition("="))
        if not table or not equals or not name:
            from tendon_cli.units import shorten

            problem = f'"{shorten(text)}" is not TABLE=NAME'
            raise UsageError(problem, where="--row", hint="such as --row spring=S5")
        if table in rows:
            problem = f"{table} is given twice, expected one row of each table"
            raise UsageError(problem, where="--row")
        rows[table] = name
    return rows


def number_parser(name: str, least: int) -> Callable[[str | int], int]:
    """Return a function that reads the whole number of an option, or raises UsageError.

    Args:
        name: Name of the option.
        least: Smallest number that is possible.
    """

    def read_number(text: str | int) -> int:
        try:
            number = int(text)
        except ValueError:
            number = least - 1
        if number < least:
            from tendon_cli.units import shorten

            problem = f'"{shorten(str(text))}" is not possible, expected a whole number, '
            raise UsageError(f"{problem}{least} or more", where=name)
        return number

    return read_number


def refuse_both(first: str, has_first: bool, second: str, has_second: bool) -> None:
    """Raise UsageError if two options that exclude each other are both given."""
    if has_first and has_second:
        raise UsageError(f"{first} and {second} conflict", hint="give only one of them")


def output_option(text: str, metavar: str = "FILE", *names: str) -> Any:
    """Make an option that names a file or folder to write."""
    return option(metavar, text, *names, parser=results_path)


def out_option(text: str, metavar: str = "FILE") -> Any:
    """Make the option for what a command is there to write, `--out`."""
    return output_option(text, metavar, "--out", "-o")


def hint_at_study(command: str) -> str:
    """Return a hint for a command without a study: the one here, or a way to a first one."""
    from tendon_cli.studies.load import studies_in
    from tendon_cli.units import shorten

    names = [file.name for file in studies_in(Path())]
    if len(names) == 1:
        return f"this folder has one: {shlex.join(['tendon', command, *names])}"
    if names:
        return f"studies here: {', '.join(map(shorten, names[:3]))}"
    return "`tendon init` writes a study to start from"


STUDY = "STUDY"
"""Name of the argument that is a study."""
StudyArgument = Annotated[
    Path,
    typer.Argument(
        parser=read_path,
        metavar=STUDY,
        help="study file, TOML or YAML; - reads it from standard input",
    ),
]
RunArgument = Annotated[
    Path,
    typer.Argument(parser=results_path, metavar="RUN", help="folder of a sweep or a design"),
]
SettingsOption = Annotated[
    list[str] | None,
    option(
        "KEY=VALUE",
        "override a key, such as 'arm.b1=160 mm'; repeatable",
        "--set",
        completer=completion.settings,
    ),
]
CaseOption = Annotated[
    str | None, option("NAME", "one of the study's cases", completer=completion.cases)
]
RowOption = Annotated[
    list[str] | None,
    option(
        "TABLE=NAME", "take this row of a table; repeatable", "--row", completer=completion.rows
    ),
]
OutFileOption = Annotated[Path | None, out_option("file to write")]
JsonOption = Annotated[bool, typer.Option("--json", help="print exactly one JSON object")]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="print nothing but errors")]

# Commands that compute a folder of results

OutFolderOption = Annotated[
    Path | None,
    out_option(
        "folder to write to; default: results/<name>, or results/<name>-design for an answer", "DIR"
    ),
]
JobsOption = Annotated[
    int | None,
    option(
        "N", "compute N parts at once; default: one per core", parser=number_parser("--jobs", 1)
    ),
]
DryRunOption = Annotated[
    bool, typer.Option("--dry-run", help="show the size and cost, write nothing")
]
ResumeOption = Annotated[bool, typer.Option("--resume", help="finish an interrupted run")]
OverwriteOption = Annotated[
    bool, typer.Option("--overwrite", help="replace the results in the folder")
]
OverwriteFileOption = Annotated[
    bool, typer.Option("--overwrite", help="replace a file, even one that tendon did not write")
]
YesOption = Annotated[bool, typer.Option("--yes", "-y", help="write more than 1 GB without asking")]
NoFiguresOption = Annotated[bool, typer.Option("--no-figures", help="draw no figures")]
SchedulerOption = Annotated[
    str | None, option("tcp://HOST:PORT", "compute on this running Dask cluster")
]

# Commands that read rows of tables

TableArgument = Annotated[
    Path,
    typer.Argument(
        parser=results_path,
        metavar="TABLE_OR_RUN",
        help="a table, the folder of a run or an answer, or a CSV of people",
    ),
]
TableOption = Annotated[
    str | None, option("NAME", "table of the folder", "--table", completer=completion.tables)
]
WhereOption = Annotated[
    list[str] | None,
    option(
        "FILTER",
        "keep only some rows, such as 'load_mass = 5 kg'; repeatable",
        completer=completion.columns,
    ),
]
ColumnsOption = Annotated[
    list[str] | None,
    option("NAMES", "columns to show, separated by commas", completer=completion.columns),
]
