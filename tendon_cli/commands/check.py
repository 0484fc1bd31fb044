"""`tendon check`: is every design within its limits, or what changed."""

from pathlib import Path
from typing import Annotated

import typer

import tendon_cli as tendon
from tendon_cli.commands import options, values
from tendon_cli.commands.report import note_stale_page
from tendon_cli.errors import EXIT_NEGATIVE, UsageError
from tendon_cli.terminal import print_result

Baseline = Annotated[Path | None, options.written("report only what changed since this run", "RUN")]
Tolerance = Annotated[
    float | None, options.option("SHARE", "largest difference allowed, as a share of a column's scale; default 1e-9")
]
Apart = Annotated[
    list[str] | None,
    options.option("KEY", "key in which the studies may differ; repeatable", "--except", among=values.keys),
]
Worst = Annotated[int, typer.Option(metavar="N", min=1, help="how many designs to list, the worst first")]
Markdown = Annotated[bool, typer.Option("--markdown", help="print Markdown, for the summary of a CI job")]


def check(
    run: options.RunFolder,
    baseline: Baseline = None,
    tolerance: Tolerance = None,
    apart: Apart = None,
    worst: Worst = 10,
    markdown: Markdown = False,
    as_json: options.AsJson = False,
) -> None:
    """Check that every design of a run is within its limits, or compare it with another run; exit 4 if not.

    An answer of `tendon design` passes if at least one choice has a window of pretension.
    """
    from tendon_cli.checks.compare import TOLERANCE
    from tendon_cli.checks.text import as_markdown

    if tolerance is not None and not 0.0 <= tolerance < float("inf"):
        raise UsageError("--tolerance is a share of a column's scale, 0 or more", hint="such as 1e-9")
    options.exclude("--json", as_json, "--markdown", markdown)
    if baseline is None and (apart or tolerance is not None):
        given = "--except" if tolerance is None else "--tolerance"
        raise UsageError(f"{given} is for a comparison", hint="--baseline names the other run")
    tolerance = TOLERANCE if tolerance is None else tolerance
    checked = tendon.check(run, baseline, tolerance=tolerance, apart=apart or (), worst=worst)
    text = as_markdown(checked.text, holds=checked.holds) if markdown else checked.text
    print_result(checked.record if as_json else text)
    note_stale_page(run)
    if not checked.holds:
        raise typer.Exit(EXIT_NEGATIVE)
