"""`tendon report`: one page of a run."""

from pathlib import Path
from typing import Annotated

import tendon_cli as tendon
from tendon_cli.commands import options
from tendon_cli.terminal import print_note, print_result

Page = Annotated[Path | None, options.written("file to write; default: report.html in the run's folder")]


def report(run: options.RunFolder, out: Page = None, as_json: options.AsJson = False) -> None:
    """Write one HTML page with everything that a run or an answer holds."""
    written = str(tendon.report(run, out))
    print_result({"report": written} if as_json else written)


def note_stale_page(folder: Path, *, quiet: bool = False) -> None:
    """Print a note if the page in a run's folder shows earlier results."""
    from tendon_cli.reports.stale import stale_note

    if not quiet and (note := stale_note(folder)):
        print_note(note)
