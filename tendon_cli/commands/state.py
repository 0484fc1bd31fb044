"""`tendon state`: one state, for a check by hand."""

from pathlib import Path
from typing import Annotated

import typer

import tendon_cli as tendon
from tendon_cli.commands import options
from tendon_cli.errors import EXIT_NOT_AS_HOPED
from tendon_cli.terminal import as_json_text, print_result


def state(
    study: options.StudyFile,
    settings: options.Settings = None,
    case: options.Case = None,
    person: options.Person = None,
    draw: options.Draw = None,
    reversal: Annotated[
        bool, typer.Option("--reversal", help="add what happens if the motion turns back there")
    ] = False,
    plot: Annotated[
        Path | None,
        typer.Option(
            parser=options.place, metavar="FILE", help="draw the motor over the cycle, and the turn with --reversal"
        ),
    ] = None,
    as_json: options.AsJson = False,
) -> None:
    """Work out one state line by line, with the numbers of every equation, to check by hand."""
    page = tendon.state(tendon.load_study(study, settings or ()), case, person, draw, reversal=reversal, plot=plot)
    print_result(as_json_text(page.record) if as_json else page.text)
    if not page.has_equilibrium:
        raise typer.Exit(EXIT_NOT_AS_HOPED)
