"""Options that several commands have."""

# No `from __future__ import annotations` in the commands: typer would compile each annotation anew, at every start.

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from tendon_cli.commands import completion
from tendon_cli.errors import UsageError


def option(
    metavar: str, text: str, *names: str, among: Callable[..., list[Any]] | None = None, **more: Any
) -> Any:
    """An option with a value, completed from what `among` gives, or from the words of `metavar`."""
    words = metavar.split("|")
    return typer.Option(
        *names,
        metavar=metavar,
        help=text,
        autocompletion=(lambda: words) if words[1:] else among,
        **more,
    )


def source(text: str | Path) -> Path:
    """A file or folder to read; raises UsageError for what cannot be a name. A default is a path already."""
    from tendon_cli.files import path_of

    return path_of(text)


def place(text: str | Path) -> Path:
    """A file or folder of results; raises UsageError for what cannot be a name."""
    from tendon_cli.files import result_path

    return result_path(text)


def listed(names: list[str] | None) -> tuple[str, ...]:
    """Names that are separated by commas, or given one by one."""
    return tuple(name.strip() for text in names or () for name in text.split(",") if name.strip())


def exclude(one: str, is_one: bool, other: str, is_other: bool) -> None:
    """Refuse two options at once; raises UsageError."""
    if is_one and is_other:
        raise UsageError(f"{one} and {other} exclude each other")


def written(text: str, metavar: str = "FILE") -> Any:
    """An option that names a file or folder to write."""
    return option(metavar, text, parser=place)


StudyFile = Annotated[
    Path,
    typer.Argument(
        parser=source,
        metavar="STUDY",
        help="study file, TOML or YAML; - reads it from standard input",
    ),
]
RunFolder = Annotated[
    Path,
    typer.Argument(parser=place, metavar="RUN", help="folder of a sweep, a design or the paper"),
]
Settings = Annotated[
    list[str] | None,
    option(
        "KEY=VALUE",
        "override a key, such as 'arm.b1=160 mm'; repeatable",
        "--set",
        among=completion.settings,
    ),
]
Case = Annotated[str | None, option("NAME", "one of the study's cases", among=completion.cases)]
OutFile = Annotated[Path | None, written("file to write")]
AsJson = Annotated[bool, typer.Option("--json", help="print exactly one JSON object")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="print nothing but errors")]

# What computes a folder of results
OutFolder = Annotated[
    Path | None,
    written(
        "folder to write to; default results/<name>, results/<name>-design for an answer", "DIR"
    ),
]
Jobs = Annotated[int | None, option("N", "compute N parts at once; default: one per core", min=1)]
DryRun = Annotated[bool, typer.Option("--dry-run", help="show the size and cost, write nothing")]
Resume = Annotated[bool, typer.Option("--resume", help="finish what was interrupted")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace the results in the folder")]
NoFigures = Annotated[bool, typer.Option("--no-figures", help="draw nothing")]
NoLock = Annotated[
    bool, typer.Option("--no-lock", help="do not lock the folder, for file systems without locks")
]
Scheduler = Annotated[str | None, option("tcp://HOST:PORT", "compute on this running Dask cluster")]

# Rows of tables
Table = Annotated[
    Path,
    typer.Argument(
        parser=place,
        metavar="TABLE_OR_RUN",
        help="a table, the folder of a run or an answer, or a CSV of people",
    ),
]
TableName = Annotated[
    str | None, option("NAME", "table of the folder", "--table", among=completion.tables)
]
Where = Annotated[
    list[str] | None,
    option(
        "FILTER",
        "keep only some rows, such as 'load_mass = 5 kg'; repeatable",
        among=completion.columns,
    ),
]
Columns = Annotated[
    list[str] | None,
    option("NAMES", "columns to show, separated by commas", among=completion.columns),
]
