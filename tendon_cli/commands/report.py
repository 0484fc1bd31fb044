"""`tendon report`: one page of a run."""

from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import options
from tendon_cli.terminal import as_json_text, print_note, print_result

RunFolder = Annotated[
    Path, typer.Argument(parser=options.place, metavar="RUN", help="folder of a sweep, a design or the paper")
]
Page = Annotated[
    Path | None,
    typer.Option(parser=options.place, metavar="FILE", help="file to write; default: report.html in the run's folder"),
]


def report(run: RunFolder, out: Page = None, as_json: options.AsJson = False) -> None:
    """Write one HTML page with everything that a run or an answer holds."""
    from tendon_cli.reports.report import write_report

    written = str(write_report(run, out))
    print_result(as_json_text({"report": written}) if as_json else written)


def tell_of_stale_page(folder: Path) -> None:
    """Say where the page in a run's folder is of earlier results."""
    from tendon_cli.reports.stale import stale_note

    if said := stale_note(folder):
        print_note(said)
