"""Options that several commands have."""

# No `from __future__ import annotations` in the commands: typer would compile each annotation anew, at every start.

from pathlib import Path
from typing import Annotated

import typer

StudyFile = Annotated[Path, typer.Argument(metavar="STUDY", help="study file, TOML or YAML")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="override a key, such as 'arm.b1=160 mm'; repeatable"),
]
Case = Annotated[str | None, typer.Option(help="which of the study's cases")]
Person = Annotated[str | None, typer.Option(help="which of the study's people, or mean-man, mean-woman")]
AsJson = Annotated[bool, typer.Option("--json", help="print exactly one JSON object")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="print nothing but errors")]
Jobs = Annotated[int | None, typer.Option(min=1, help="parts computed at once; default all cores")]
OutFile = Annotated[Path | None, typer.Option(metavar="FILE", help="file or folder to write to")]
