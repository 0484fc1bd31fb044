"""Options that several commands have."""

# No `from __future__ import annotations` in the commands: typer would compile each annotation anew, at every start.

from pathlib import Path
from typing import Annotated

import typer


def source(text: str | Path) -> Path:
    """A file or folder to read; raises UsageError for what cannot be a name. A default is a path already."""
    from tendon_cli.files import path_of

    return path_of(text)


def place(text: str | Path) -> Path:
    """A file or folder of results; raises UsageError for what cannot be a name."""
    from tendon_cli.files import result_path

    return result_path(text)


StudyFile = Annotated[
    Path,
    typer.Argument(parser=source, metavar="STUDY", help="study file, TOML or YAML; - reads it from standard input"),
]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="override a key, such as 'arm.b1=160 mm'; repeatable"),
]
Case = Annotated[str | None, typer.Option(metavar="NAME", help="one of the study's cases")]
Person = Annotated[str | None, typer.Option(metavar="NAME", help="one of the study's people, or mean-man, mean-woman")]
Draw = Annotated[
    int | None, typer.Option(metavar="N", help="a draw of the uncertain numbers; default: nominal numbers")
]
AsJson = Annotated[bool, typer.Option("--json", help="print exactly one JSON object")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="print nothing but errors")]
Jobs = Annotated[
    int | None, typer.Option(metavar="N", min=1, help="how many parts are computed at once; default: all cores")
]
OutFile = Annotated[Path | None, typer.Option(parser=place, metavar="FILE", help="file or folder to write to")]

# show, export
Table = Annotated[
    Path,
    typer.Argument(
        parser=place, metavar="TABLE_OR_RUN", help="a table, the folder of a run or an answer, or a CSV of people"
    ),
]
TableName = Annotated[str | None, typer.Option("--table", metavar="NAME", help="which table of the folder")]
Where = Annotated[
    list[str] | None, typer.Option(metavar="FILTER", help="keep only some rows, such as 'load_mass = 5 kg'; repeatable")
]
Columns = Annotated[list[str] | None, typer.Option(metavar="NAMES", help="which columns, separated by commas")]


def listed(names: list[str] | None) -> tuple[str, ...]:
    """Names that are separated by commas, or given one by one."""
    return tuple(name.strip() for text in names or () for name in text.split(",") if name.strip())


NoLock = Annotated[bool, typer.Option("--no-lock", help="do not lock the folder, for file systems that cannot")]
Scheduler = Annotated[str | None, typer.Option(metavar="tcp://HOST:PORT", help="compute on this running Dask cluster")]
