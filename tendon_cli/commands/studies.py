"""Commands on studies: `tendon init`, `schema`, `state`, `sweep`, `design` and `paper`."""

import contextlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import tendon_cli as tendon
from tendon_cli.commands import completion, options
from tendon_cli.errors import EXIT_NEGATIVE
from tendon_cli.startup import keep_freed_memory, stopped_by_signals
from tendon_cli.terminal import print_note, print_result, progress

if TYPE_CHECKING:
    from tendon_cli.answers.answer import Answer
    from tendon_cli.engine.results import Run
    from tendon_cli.studies.study import Study

StarterArgument = Annotated[
    Path | None,
    typer.Argument(
        parser=options.results_path,
        metavar="FILE",
        help="TOML or YAML, by its ending; default study.toml",
    ),
]
TemplateOption = Annotated[
    str,
    options.option(
        "NAME",
        "question to start from: sweep, design, robust, people, motor or friction",
        "--for",
        "--template",
        completer=completion.templates,
    ),
]
ExampleOption = Annotated[
    str | None,
    options.option("NAME", "copy this study or CSV from the documentation instead", "--from"),
]
ListOption = Annotated[
    bool,
    typer.Option(
        "--list", help="list the questions and the files that --from copies, write nothing"
    ),
]


def init(
    file: StarterArgument = None,
    template: TemplateOption = "sweep",
    example: ExampleOption = None,
    listed: ListOption = False,
) -> None:
    """Write a commented study to start from, or copy one from the documentation."""
    from tendon_cli.studies.starter import TEMPLATES, examples, write_example, write_starter

    if listed:
        questions = [f"  {name:<10} {question}" for name, question in TEMPLATES.items()]
        files = [f"  {name}" for name in examples()]
        print_result("\n".join(["--for", *questions, "--from", *files]))
        return
    options.refuse_both("--for", template != "sweep", "--from", example is not None)
    if example is not None:
        file, name = write_example(example, file)
        verb = "design" if name.startswith("design/") else "sweep"
        if file.suffix == ".csv":
            verb = "fit-friction"
    else:
        file = file or Path("study.toml")
        write_starter(file, template)
        verb = "sweep" if template in ("sweep", "motor") else "design"
    print_result(f"{file} written; next: tendon {verb} {file}")


def schema() -> None:
    """Print the JSON Schema of the study file, for editors."""
    from tendon_cli.studies.json_schema import schema_text

    print_result(schema_text())


PersonOption = Annotated[
    str | None,
    options.option(
        "NAME", "one of the study's people, or mean-man, mean-woman", completer=completion.persons
    ),
]
DrawOption = Annotated[
    int | None,
    options.option("N", "number of a draw of the uncertain numbers; default: nominal numbers"),
]
ReversalOption = Annotated[
    bool, typer.Option("--reversal", help="add what happens if the motion reverses there")
]
PlotOption = Annotated[
    Path | None,
    options.output_option("draw the motor over the cycle, and the reversal with --reversal"),
]


def state(
    study: options.StudyArgument,
    settings: options.SettingsOption = None,
    case: options.CaseOption = None,
    person: PersonOption = None,
    draw: DrawOption = None,
    reversal: ReversalOption = False,
    plot: PlotOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Work out one state line by line, with the numbers of every equation, to check by hand."""
    loaded = tendon.load_study(study, settings or ())
    page = tendon.state(loaded, case, person, draw, reversal=reversal, plot=plot)
    print_result(page.record if as_json else page.text)
    if not page.has_equilibrium:
        raise typer.Exit(EXIT_NEGATIVE)


ProveOption = Annotated[
    list[str] | None,
    options.option(
        "CHOICE",
        "prove the window of this choice, too: its row in choices.parquet; repeatable",
        "--prove",
    ),
]
AllowNoEquilibriumOption = Annotated[
    bool, typer.Option("--allow-no-equilibrium", help="exit 0 even if states have no equilibrium")
]


def sweep(
    study: options.StudyArgument,
    out: options.OutFolderOption = None,
    jobs: options.JobsOption = None,
    settings: options.SettingsOption = None,
    dry_run: options.DryRunOption = False,
    resume: options.ResumeOption = False,
    overwrite: options.OverwriteOption = False,
    as_json: options.JsonOption = False,
    quiet: options.QuietOption = False,
    no_figures: options.NoFiguresOption = False,
    allow_no_equilibrium: AllowNoEquilibriumOption = False,
    no_lock: options.NoLockOption = False,
    scheduler: options.SchedulerOption = None,
) -> None:
    """Run every combination of a study's values; write Parquet tables and slack maps."""
    options.refuse_both("--resume", resume, "--overwrite", overwrite)
    keep_freed_memory()
    with stopped_by_signals(str(out or "results")) as stop:
        loaded = tendon.load_study(study, settings or ())
        folder = out or Path("results", loaded.name)
        if dry_run:
            record, text = _cost_of_sweep(loaded, folder, jobs, figures=not no_figures)
            print_result(record if as_json else text, unless=quiet and not as_json)
            return
        with progress(loaded.name, quiet=quiet or as_json) as show:
            run = tendon.sweep(
                loaded,
                folder,
                jobs,
                not no_figures,
                resume=resume,
                overwrite=overwrite,
                lock=not no_lock,
                scheduler=scheduler,
                progress=show,
                stop=stop,
            )
    _print_results(run, run.text, folder, as_json=as_json, quiet=quiet)
    if run.record["no_equilibrium"] and not allow_no_equilibrium:
        raise typer.Exit(EXIT_NEGATIVE)


def design(
    study: options.StudyArgument,
    out: options.OutFolderOption = None,
    jobs: options.JobsOption = None,
    settings: options.SettingsOption = None,
    prove: ProveOption = None,
    dry_run: options.DryRunOption = False,
    resume: options.ResumeOption = False,
    overwrite: options.OverwriteOption = False,
    as_json: options.JsonOption = False,
    quiet: options.QuietOption = False,
    no_figures: options.NoFiguresOption = False,
    no_lock: options.NoLockOption = False,
    scheduler: options.SchedulerOption = None,
) -> None:
    """Find the window of pretension and the best choice, what limits them and what would fix it."""
    options.refuse_both("--resume", resume, "--overwrite", overwrite)
    keep_freed_memory()
    with stopped_by_signals(str(out or "results")) as stop:
        all_settings = list(settings or ())
        if prove:
            all_settings.append(f"design.prove={json.dumps(prove)}")
        loaded = tendon.load_study(study, all_settings)
        folder = out or Path("results", f"{loaded.name}-design")
        if dry_run:
            record, text = _size_of_design(loaded)
            print_result(record if as_json else text, unless=quiet and not as_json)
            return
        with progress(loaded.name, quiet=quiet or as_json) as show:
            answer = tendon.design(
                loaded,
                folder,
                jobs,
                not no_figures,
                resume=resume,
                overwrite=overwrite,
                lock=not no_lock,
                scheduler=scheduler,
                progress=show,
                stop=stop,
            )
    _print_results(answer, _answer_text(answer), folder, as_json=as_json, quiet=quiet)
    if not answer.feasible:
        raise typer.Exit(EXIT_NEGATIVE)


def _cost_of_sweep(
    study: "Study", folder: Path, jobs: int | None, *, figures: bool
) -> tuple[dict[str, Any], str]:
    """Return the size and cost of a sweep, as a record and as text."""
    from tendon_cli.engine.folder import free_bytes
    from tendon_cli.summary import estimate_text

    cost = tendon.estimate(study, jobs, figures)
    free = free_bytes(folder)
    record = {"name": study.name, **cost.record(), "free_bytes": free}
    return record, estimate_text(cost, study.name, free)


def _size_of_design(study: "Study") -> tuple[dict[str, Any], str]:
    """Return the size of the question that a study asks, as a record and as text."""
    from tendon_cli.answers.question_facts import notes_of
    from tendon_cli.windows.question import question_of

    question = question_of(study)
    notes = notes_of(question)
    record: dict[str, Any] = {"name": study.name}
    lines = [f"{study.name}: nothing is written by --dry-run"]
    for name, product in (("choices", question.choices), ("conditions", question.conditions)):
        record[name] = {axis.key: len(axis) for axis in product.axes}
        axes = ", ".join(f"{key} {count:,}" for key, count in record[name].items())
        lines.append(f"  {name:<12} {len(product):,}" + (f"  ({axes})" if axes else ""))
    record["windows"] = len(question.choices) * len(question.conditions)
    record["states"] = record["windows"] * question.states_per_design
    record["notes"] = notes
    lines += [f"  {name:<12} {record[name]:,}" for name in ("windows", "states")]
    lines += [f"  note         {note}" for note in notes]
    return record, "\n".join(lines)


def _print_results(
    result: "Run | Answer", text: str, folder: Path, *, as_json: bool, quiet: bool
) -> None:
    """Print a run or an answer, and a note if the page in its folder is out of date."""
    print_result(result.record if as_json else text, unless=quiet and not as_json)
    if not quiet:
        _note_stale_page(folder, result.record)


def _note_stale_page(folder: Path, record: dict[str, Any]) -> None:
    """Print a note if the page in a folder shows other results than its record."""
    from tendon_cli.files import read_file
    from tendon_cli.reports.html import MARK

    with contextlib.suppress(OSError):
        page = read_file(folder / "report.html", 10**7).decode(errors="replace")
        sums = [record["study_hash"], *(entry["sha256"] for entry in record["files"])]
        is_current = all(checksum in page for checksum in sums)
        if MARK in page[:4096] and not is_current:
            print_note(
                f"{folder}/report.html is of earlier results; "
                f"`tendon report {folder}` writes a new one"
            )


def _answer_text(answer: "Answer") -> str:
    """Return the text of an answer with its warnings, and the names of its files."""
    record = answer.record
    files = dict.fromkeys(entry["path"].split("/")[0] for entry in record["files"])
    written = ", ".join([*files, "design.json", *record["figures"]])
    took = ", up to date" if answer.up_to_date else f" in {record['seconds']:.3g} s"
    warnings = [f"warning: {warning}" for warning in record["warnings"]]
    last = f"{record['name']}{took}, in {answer.folder}: {written}"
    return "\n".join([answer.text, *warnings, last])


PaperFolderOption = Annotated[Path, options.output_option("folder to write to", "DIR")]


def paper(
    out: PaperFolderOption = Path("results/paper"),
    jobs: options.JobsOption = None,
    quiet: options.QuietOption = False,
    as_json: options.JsonOption = False,
) -> None:
    """Reproduce the paper: every figure, and a check of every finding and claim."""
    with stopped_by_signals(str(out)) as stop, progress("paper", quiet=quiet or as_json) as show:
        from tendon_cli.paper.reproduce import reproduce

        done = reproduce(out, jobs=jobs, progress=show, stop=stop)
    print_result(done.record() if as_json else done.text(), unless=quiet and not as_json)
    if not done.holds:
        raise typer.Exit(EXIT_NEGATIVE)
