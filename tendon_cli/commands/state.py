"""`tendon state`: one state, for a check by hand."""

from pathlib import Path
from typing import Annotated

import typer

import tendon_cli as tendon
from tendon_cli.commands import options, values
from tendon_cli.errors import EXIT_NEGATIVE
from tendon_cli.terminal import print_result

Person = Annotated[
    str | None, options.option("NAME", "one of the study's people, or mean-man, mean-woman", among=values.persons)
]
Draw = Annotated[int | None, options.option("N", "a draw of the uncertain numbers; default: nominal numbers")]
Reversal = Annotated[bool, typer.Option("--reversal", help="add what happens if the motion turns back there")]
Plot = Annotated[Path | None, options.written("draw the motor over the cycle, and the turn with --reversal")]


def state(
    study: options.StudyFile,
    settings: options.Settings = None,
    case: options.Case = None,
    person: Person = None,
    draw: Draw = None,
    reversal: Reversal = False,
    plot: Plot = None,
    as_json: options.AsJson = False,
) -> None:
    """Work out one state line by line, with the numbers of every equation, to check by hand."""
    page = tendon.state(tendon.load_study(study, settings or ()), case, person, draw, reversal=reversal, plot=plot)
    print_result(page.record if as_json else page.text)
    if not page.has_equilibrium:
        raise typer.Exit(EXIT_NEGATIVE)
