"""`tendon paper`: the paper reproduced."""

from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import options
from tendon_cli.errors import EXIT_NEGATIVE
from tendon_cli.startup import stopped_by_signals
from tendon_cli.terminal import print_result, progress

PaperFolder = Annotated[Path, options.written("folder to write to", "DIR")]


def paper(
    out: PaperFolder = Path("results/paper"),
    jobs: options.Jobs = None,
    quiet: options.Quiet = False,
    as_json: options.AsJson = False,
) -> None:
    """Reproduce the paper: every figure, and a check of every finding and claim."""
    with stopped_by_signals(str(out)) as stop, progress("paper", quiet=quiet or as_json) as show:
        from tendon_cli.paper.reproduce import reproduce

        done = reproduce(out, jobs=jobs, progress=show, stop=stop)
    print_result(done.record() if as_json else done.text(), unless=quiet and not as_json)
    if not done.holds:
        raise typer.Exit(EXIT_NEGATIVE)
