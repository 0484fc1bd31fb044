"""`tendon sweep`: a study over every combination."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import tendon_cli as tendon
from tendon_cli.commands import options
from tendon_cli.commands.report import tell_of_stale_page
from tendon_cli.errors import EXIT_NOT_AS_HOPED, UsageError
from tendon_cli.startup import keep_freed_memory, stopped_by_signals
from tendon_cli.terminal import as_json_text, print_result, progress

if TYPE_CHECKING:
    from tendon_cli.studies.study import Study

RunFolderName = Annotated[
    Path | None, typer.Option(parser=options.place, metavar="DIR", help="run folder; default results/<name>")
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="show size and cost, write nothing")]
Resume = Annotated[bool, typer.Option("--resume", help="finish an interrupted run")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace the run in the folder")]
NoFigures = Annotated[bool, typer.Option("--no-figures", help="draw nothing")]
AllowNoEquilibrium = Annotated[
    bool, typer.Option("--allow-no-equilibrium", help="exit 0 even if states have no equilibrium")
]


def sweep(
    study: options.StudyFile,
    out: RunFolderName = None,
    jobs: options.Jobs = None,
    settings: options.Settings = None,
    dry_run: DryRun = False,
    resume: Resume = False,
    overwrite: Overwrite = False,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
    no_figures: NoFigures = False,
    allow_no_equilibrium: AllowNoEquilibrium = False,
    no_lock: options.NoLock = False,
    scheduler: options.Scheduler = None,
) -> None:
    """Run every combination of a study's values; write Parquet tables and slack maps."""
    if resume and overwrite:
        raise UsageError("--resume and --overwrite exclude each other", hint="--resume keeps what is done")
    keep_freed_memory()
    if dry_run:
        loaded = tendon.load_study(study, settings or ())
        folder = out if out is not None else Path("results") / loaded.name
        _tell_cost(loaded, folder, jobs, figures=not no_figures, as_json=as_json, quiet=quiet)
        return
    with stopped_by_signals(str(out or "results")) as stop:
        loaded = tendon.load_study(study, settings or ())
        folder = out if out is not None else Path("results") / loaded.name
        with progress(loaded.name, quiet=quiet or as_json) as show:
            run = tendon.sweep(
                loaded, folder, jobs, not no_figures, resume=resume, overwrite=overwrite, lock=not no_lock,
                scheduler=scheduler, progress=show, stop=stop,
            )  # fmt: skip
    from tendon_cli.summary import run_text

    print_result(as_json_text(run.record) if as_json else run_text(run), unless=quiet and not as_json)
    if not quiet:
        tell_of_stale_page(folder)
    if run.record["no_equilibrium"] and not allow_no_equilibrium:
        raise typer.Exit(EXIT_NOT_AS_HOPED)


def _tell_cost(study: "Study", folder: Path, jobs: int | None, *, figures: bool, as_json: bool, quiet: bool) -> None:
    """The size and cost of a sweep; nothing is written."""
    from tendon_cli.engine.folder import free_bytes
    from tendon_cli.summary import estimate_text

    found, free = tendon.estimate(study, jobs, figures), free_bytes(folder)
    record = {"name": study.name, **found.record(), "free_bytes": free}
    text = as_json_text(record) if as_json else estimate_text(found, study.name, free)
    print_result(text, unless=quiet and not as_json)
