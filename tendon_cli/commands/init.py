"""`tendon init`: a starter study."""

from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.terminal import print_result

StarterFile = Annotated[Path, typer.Argument(metavar="[FILE]", help="TOML or YAML, by its ending")]


def init(file: StarterFile = Path("study.toml")) -> None:
    """Write a commented starter study."""
    from tendon_cli.study.starter import write_starter

    write_starter(file)
    print_result(f"{file} written; next: tendon sweep {file}")
