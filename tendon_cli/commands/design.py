"""`tendon design`: which pretension, which choice, what binds, and what would fix it."""

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

AnswerFolder = Annotated[
    Path | None, typer.Option(parser=options.place, metavar="DIR", help="folder; default results/<name>-design")
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="show the question and its size, write nothing")]
Resume = Annotated[bool, typer.Option("--resume", help="finish an interrupted answer")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace the answer in the folder")]
NoFigures = Annotated[bool, typer.Option("--no-figures", help="draw nothing")]


def design(
    study: options.StudyFile,
    out: AnswerFolder = None,
    jobs: options.Jobs = None,
    settings: options.Settings = None,
    dry_run: DryRun = False,
    resume: Resume = False,
    overwrite: Overwrite = False,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
    no_figures: NoFigures = False,
    no_lock: options.NoLock = False,
    scheduler: options.Scheduler = None,
) -> None:
    """Find the window of pretension and the best choice, what limits them, and what would fix it."""
    if resume and overwrite:
        raise UsageError("--resume and --overwrite exclude each other", hint="--resume keeps what is done")
    with stopped_by_signals(str(out or "results")) as stop:
        loaded = tendon.load_study(study, settings or ())
        folder = out if out is not None else Path("results") / f"{loaded.name}-design"
        if dry_run:
            _tell_question(loaded, as_json=as_json, quiet=quiet)
            return
        keep_freed_memory()
        with progress(loaded.name, quiet=quiet or as_json) as show:
            answer = tendon.design(
                loaded, folder, jobs, not no_figures, resume=resume, overwrite=overwrite, lock=not no_lock,
                scheduler=scheduler, progress=show, stop=stop,
            )  # fmt: skip
    files = [*dict.fromkeys(entry["path"].split("/")[0] for entry in answer.record["files"]), "design.json"]
    said = ", up to date" if answer.up_to_date else f" in {answer.record['seconds']:.3g} s"
    end = "".join(f"\nwarning: {warning}" for warning in answer.record["warnings"])
    end += f"\n{loaded.name}{said}, in {folder}: {', '.join([*files, *answer.record['figures']])}"
    print_result(as_json_text(answer.record) if as_json else answer.text + end, unless=quiet and not as_json)
    if not quiet:
        tell_of_stale_page(folder)
    if not answer.feasible:
        raise typer.Exit(EXIT_NOT_AS_HOPED)


def _tell_question(study: "Study", *, as_json: bool, quiet: bool) -> None:
    """What a study asks, and how much work that is; nothing is written."""
    from tendon_cli.answers.question import question

    asked = question(study)
    record = {
        "name": study.name,
        "choices": {factor.key: len(factor) for factor in asked.choices.axes},
        "conditions": {factor.key: len(factor) for factor in asked.conditions.axes},
        "windows": len(asked.choices) * len(asked.conditions),
        "states": len(asked.choices) * len(asked.conditions) * asked.states_per_design,
        "notes": list(asked.notes),
    }
    lines = [f"{study.name}: nothing is written by --dry-run"]
    for name, product in (("choices", asked.choices), ("conditions", asked.conditions)):
        axes = ", ".join(f"{factor.key} {len(factor):,}" for factor in product.axes)
        lines.append(f"  {name:<12} {len(product):,}" + (f"  ({axes})" if axes else ""))
    lines += [f"  windows      {record['windows']:,}", f"  states       {record['states']:,}"]
    lines += [f"  note         {note}" for note in asked.notes]
    print_result(as_json_text(record) if as_json else "\n".join(lines), unless=quiet and not as_json)
