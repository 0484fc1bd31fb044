"""`tendon sweep`: a study over every combination."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import tendon_cli as tendon
from tendon_cli.commands import options
from tendon_cli.commands.report import note_stale_page
from tendon_cli.errors import EXIT_NEGATIVE
from tendon_cli.startup import keep_freed_memory, stopped_by_signals
from tendon_cli.terminal import print_result, progress

if TYPE_CHECKING:
    from tendon_cli.studies.study import Study

AllowNoEquilibrium = Annotated[
    bool, typer.Option("--allow-no-equilibrium", help="exit 0 even if states have no equilibrium")
]


def sweep(
    study: options.StudyFile,
    out: options.OutFolder = None,
    jobs: options.Jobs = None,
    settings: options.Settings = None,
    dry_run: options.DryRun = False,
    resume: options.Resume = False,
    overwrite: options.Overwrite = False,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
    no_figures: options.NoFigures = False,
    allow_no_equilibrium: AllowNoEquilibrium = False,
    no_lock: options.NoLock = False,
    scheduler: options.Scheduler = None,
) -> None:
    """Run every combination of a study's values; write Parquet tables and slack maps."""
    options.exclude("--resume", resume, "--overwrite", overwrite)
    keep_freed_memory()
    with stopped_by_signals(str(out or "results")) as stop:
        loaded = tendon.load_study(study, settings or ())
        folder = out or Path("results", loaded.name)
        if dry_run:
            _print_cost(loaded, folder, jobs, figures=not no_figures, as_json=as_json, quiet=quiet)
            return
        with progress(loaded.name, quiet=quiet or as_json) as show:
            run = tendon.sweep(
                loaded, folder, jobs, not no_figures, resume=resume, overwrite=overwrite, lock=not no_lock,
                scheduler=scheduler, progress=show, stop=stop,
            )  # fmt: skip
    print_result(run.record if as_json else run.text, unless=quiet and not as_json)
    note_stale_page(folder, quiet=quiet)
    if run.record["no_equilibrium"] and not allow_no_equilibrium:
        raise typer.Exit(EXIT_NEGATIVE)


def _print_cost(study: "Study", folder: Path, jobs: int | None, *, figures: bool, as_json: bool, quiet: bool) -> None:
    """The size and cost of a sweep; nothing is written."""
    from tendon_cli.engine.folder import free_bytes
    from tendon_cli.summary import estimate_text

    cost, free = tendon.estimate(study, jobs, figures), free_bytes(folder)
    record = {"name": study.name, **cost.record(), "free_bytes": free}
    print_result(record if as_json else estimate_text(cost, study.name, free), unless=quiet and not as_json)
