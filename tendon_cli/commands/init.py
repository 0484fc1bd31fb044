"""`tendon init`: a starter study."""

from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import options
from tendon_cli.terminal import print_result

StarterFile = Annotated[Path, typer.Argument(parser=options.place, metavar="FILE", help="TOML or YAML, by its ending")]
Template = Annotated[
    str, typer.Option(metavar="NAME", help="of which question: sweep, design, people, motor or friction")
]
IsListed = Annotated[bool, typer.Option("--list", help="list the templates, each with its question; write nothing")]


def init(file: StarterFile = Path("study.toml"), template: Template = "sweep", listed: IsListed = False) -> None:
    """Write a commented starter study, of the question that you have."""
    from tendon_cli.studies.starter import TEMPLATES, write_starter

    if listed:
        print_result("\n".join(f"{name:<10} {question}" for name, question in TEMPLATES.items()))
        return
    write_starter(file, template)
    print_result(f"{file} written; next: tendon {'sweep' if template in ('sweep', 'motor') else 'design'} {file}")
