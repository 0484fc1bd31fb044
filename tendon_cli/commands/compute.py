"""`tendon sweep`, `tendon design` and `tendon paper`: what computes a folder of results."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import tendon_cli as tendon
from tendon_cli.commands import options
from tendon_cli.commands.results import note_stale_page
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


Prove = Annotated[
    list[str] | None,
    options.option(
        "CHOICE", "prove its window, too: a row of choices.parquet or values such as 'spool_ratio = 0.6'; repeatable",
        "--prove",
    ),
]  # fmt: skip


def design(
    study: options.StudyFile,
    out: options.OutFolder = None,
    jobs: options.Jobs = None,
    settings: options.Settings = None,
    prove: Prove = None,
    dry_run: options.DryRun = False,
    resume: options.Resume = False,
    overwrite: options.Overwrite = False,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
    no_figures: options.NoFigures = False,
    no_lock: options.NoLock = False,
    scheduler: options.Scheduler = None,
) -> None:
    """Find the window of pretension and the best choice, what limits them, and what would fix it."""
    options.exclude("--resume", resume, "--overwrite", overwrite)
    keep_freed_memory()
    with stopped_by_signals(str(out or "results")) as stop:
        asked = [f"design.prove={json.dumps(prove)}"] if prove else []
        loaded = tendon.load_study(study, [*(settings or ()), *asked])
        folder = out or Path("results", f"{loaded.name}-design")
        if dry_run:
            _print_question(loaded, as_json=as_json, quiet=quiet)
            return
        with progress(loaded.name, quiet=quiet or as_json) as show:
            answer = tendon.design(
                loaded, folder, jobs, not no_figures, resume=resume, overwrite=overwrite, lock=not no_lock,
                scheduler=scheduler, progress=show, stop=stop,
            )  # fmt: skip
    record = answer.record
    files = [*dict.fromkeys(entry["path"].split("/")[0] for entry in record["files"]), "design.json"]
    took = ", up to date" if answer.up_to_date else f" in {record['seconds']:.3g} s"
    lines = [answer.text, *(f"warning: {warning}" for warning in record["warnings"])]
    lines += [f"{loaded.name}{took}, in {folder}: {', '.join([*files, *record['figures']])}"]
    print_result(record if as_json else "\n".join(lines), unless=quiet and not as_json)
    note_stale_page(folder, quiet=quiet)
    if not answer.feasible:
        raise typer.Exit(EXIT_NEGATIVE)


def _print_question(study: "Study", *, as_json: bool, quiet: bool) -> None:
    """What a study asks, and how much work that is; nothing is written."""
    from tendon_cli.answers.question import question

    asked = question(study)
    windows = len(asked.choices) * len(asked.conditions)
    products = {"choices": asked.choices, "conditions": asked.conditions}
    record = {
        "name": study.name,
        **{name: {axis.key: len(axis) for axis in product.axes} for name, product in products.items()},
        "windows": windows,
        "states": windows * asked.states_per_design,
        "notes": list(asked.notes),
    }
    lines = [f"{study.name}: nothing is written by --dry-run"]
    for name, product in products.items():
        axes = ", ".join(f"{axis.key} {len(axis):,}" for axis in product.axes)
        lines.append(f"  {name:<12} {len(product):,}" + (f"  ({axes})" if axes else ""))
    lines += [f"  windows      {record['windows']:,}", f"  states       {record['states']:,}"]
    lines += [f"  note         {note}" for note in asked.notes]
    print_result(record if as_json else "\n".join(lines), unless=quiet and not as_json)


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
