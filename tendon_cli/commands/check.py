"""`tendon check`: is every design within its limits, or what changed."""

from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import options
from tendon_cli.commands.report import tell_of_stale_page
from tendon_cli.errors import EXIT_NOT_AS_HOPED, UsageError
from tendon_cli.terminal import as_json_text, print_result

RunFolder = Annotated[Path, typer.Argument(parser=options.place, metavar="RUN", help="folder of a sweep or a design")]
Baseline = Annotated[
    Path | None, typer.Option(parser=options.place, metavar="RUN", help="report only what changed since this run")
]
Tolerance = Annotated[
    float | None,
    typer.Option(metavar="SHARE", help="largest difference allowed, as a share of a column's scale; default 1e-9"),
]
Apart = Annotated[
    list[str] | None, typer.Option("--except", metavar="KEY", help="key of the study that may differ; repeatable")
]
Worst = Annotated[int, typer.Option(metavar="N", min=1, help="how many designs to list, the worst first")]
Markdown = Annotated[bool, typer.Option("--markdown", help="print Markdown, for the summary of a CI job")]


def check(
    run: RunFolder,
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
    from tendon_cli.checks.check import check as check_run
    from tendon_cli.checks.check import compare
    from tendon_cli.checks.text import as_markdown

    if tolerance is not None and not 0.0 <= tolerance < float("inf"):
        raise UsageError("--tolerance is a share of a column's scale, 0 or more", hint="such as 1e-9")
    if markdown and as_json:
        raise UsageError("--json and --markdown exclude each other")
    if baseline is None:
        if tolerance is not None or apart:
            given = "--except" if tolerance is None else "--tolerance"
            raise UsageError(f"{given} is of a comparison", hint="--baseline names the other run")
        found = check_run(run, worst=worst)
    else:
        found = compare(
            run, baseline, tolerance=1e-9 if tolerance is None else tolerance, apart=apart or (), worst=worst
        )
    text = as_markdown(found.text, holds=found.holds) if markdown else found.text
    print_result(as_json_text(found.record) if as_json else text)
    tell_of_stale_page(run)
    if not found.holds:
        raise typer.Exit(EXIT_NOT_AS_HOPED)
