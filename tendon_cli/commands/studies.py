"""`tendon init`, `schema`, `state`, `sweep`, `design` and `paper`: a study to start from, and what follows from one."""

import contextlib
import inspect
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
    from tendon_cli.studies.study import Study

StarterFile = Annotated[
    Path | None,
    typer.Argument(
        parser=options.place, metavar="FILE", help="TOML or YAML, by its ending; default study.toml"
    ),
]
Template = Annotated[
    str,
    options.option(
        "NAME",
        "question: sweep, design, robust, people, motor or friction",
        "--for",
        "--template",
        among=completion.templates,
    ),
]
Example = Annotated[
    str | None,
    options.option("NAME", "copy this study or CSV from the documentation instead", "--from"),
]
IsListed = Annotated[
    bool,
    typer.Option(
        "--list", help="list the questions and the files that --from copies, write nothing"
    ),
]


def init(
    file: StarterFile = None,
    template: Template = "sweep",
    example: Example = None,
    listed: IsListed = False,
) -> None:
    """Write a commented study to start from, or copy one from the documentation."""
    from tendon_cli.studies.starter import TEMPLATES, examples, write_example, write_starter

    if listed:
        lines = [f"  {name:<10} {question}" for name, question in TEMPLATES.items()]
        print_result("\n".join(["--for", *lines, "--from", *(f"  {name}" for name in examples())]))
        return
    options.exclude("--for", template != "sweep", "--from", example is not None)
    if example is not None:
        file, name = write_example(example, file)
        verb = (
            "fit-friction"
            if file.suffix == ".csv"
            else "design"
            if name.startswith("design/")
            else "sweep"
        )
    else:
        file = file or Path("study.toml")
        write_starter(file, template)
        verb = "sweep" if template in ("sweep", "motor") else "design"
    print_result(f"{file} written; next: tendon {verb} {file}")


def schema() -> None:
    """Print the JSON Schema of the study file, for editors."""
    from tendon_cli.studies.json_schema import schema_text

    print_result(schema_text())


Person = Annotated[
    str | None,
    options.option(
        "NAME", "one of the study's people, or mean-man, mean-woman", among=completion.persons
    ),
]
Draw = Annotated[
    int | None, options.option("N", "a draw of the uncertain numbers; default: nominal numbers")
]
Reversal = Annotated[
    bool, typer.Option("--reversal", help="add what happens if the motion turns back there")
]
Plot = Annotated[
    Path | None, options.written("draw the motor over the cycle, and the turn with --reversal")
]


def state(
    study: options.StudyFile,
    settings: options.Settings = None,
    case: options.Case = None,
    person: Person = None,
    draw: Draw = None,
    reversal: Reversal = False,
    plot: Plot = None,
    as_json: options.AsJson = False,
) -> None:
    """Work out one state line by line, with the numbers of every equation, to check by hand."""
    page = tendon.state(
        tendon.load_study(study, settings or ()), case, person, draw, reversal=reversal, plot=plot
    )
    print_result(page.record if as_json else page.text)
    if not page.has_equilibrium:
        raise typer.Exit(EXIT_NEGATIVE)


Prove = Annotated[
    list[str] | None,
    options.option(
        "CHOICE", "prove its window, too: a row of choices.parquet; repeatable", "--prove"
    ),
]
AllowNoEquilibrium = Annotated[
    bool, typer.Option("--allow-no-equilibrium", help="exit 0 even if states have no equilibrium")
]


def sweep(**given: Any) -> None:
    """Run every combination of a study's values; write Parquet tables and slack maps."""
    _compute(**given, is_design=False)


def design(**given: Any) -> None:
    """Find the window of pretension and the best choice, what limits them, and what would fix it."""
    _compute(**given, is_design=True)


def _compute(
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
    allow_no_equilibrium: AllowNoEquilibrium = False,
    no_lock: options.NoLock = False,
    scheduler: options.Scheduler = None,
    *,
    is_design: bool,
) -> None:
    options.exclude("--resume", resume, "--overwrite", overwrite)
    keep_freed_memory()
    with stopped_by_signals(str(out or "results")) as stop:
        proofs = [f"design.prove={json.dumps(prove)}"] if prove else []
        loaded = tendon.load_study(study, [*(settings or ()), *proofs])
        folder = out or Path("results", f"{loaded.name}-design" if is_design else loaded.name)
        if dry_run:
            record, text = (
                _question(loaded)
                if is_design
                else _cost(loaded, folder, jobs, figures=not no_figures)
            )
            print_result(record if as_json else text, unless=quiet and not as_json)
            return
        verb = tendon.design if is_design else tendon.sweep
        with progress(loaded.name, quiet=quiet or as_json) as show:
            done: Any = verb(
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
    text = _answer_text(done) if is_design else done.text
    print_result(done.record if as_json else text, unless=quiet and not as_json)
    if not quiet:
        _note_stale_page(folder, done.record)
    if (
        not done.feasible
        if is_design
        else done.record["no_equilibrium"] and not allow_no_equilibrium
    ):
        raise typer.Exit(EXIT_NEGATIVE)


for _command, _foreign in ((sweep, "prove"), (design, "allow_no_equilibrium")):
    _options = inspect.signature(_compute).parameters.values()
    _command.__signature__ = inspect.Signature(  # type: ignore[attr-defined]  # which typer reads
        [each for each in _options if each.name not in (_foreign, "is_design")]
    )


def _cost(
    study: "Study", folder: Path, jobs: int | None, *, figures: bool
) -> tuple[dict[str, Any], str]:
    """The size and cost of a sweep, as a record and as text."""
    from tendon_cli.engine.folder import free_bytes
    from tendon_cli.summary import estimate_text

    cost, free = tendon.estimate(study, jobs, figures), free_bytes(folder)
    return {"name": study.name, **cost.record(), "free_bytes": free}, estimate_text(
        cost, study.name, free
    )


def _question(study: "Study") -> tuple[dict[str, Any], str]:
    """What a study asks, and how much work that is, as a record and as text."""
    from tendon_cli.answers.problem import question

    asked = question(study)
    record: dict[str, Any] = {"name": study.name}
    lines = [f"{study.name}: nothing is written by --dry-run"]
    for name, product in (("choices", asked.choices), ("conditions", asked.conditions)):
        record[name] = {axis.key: len(axis) for axis in product.axes}
        axes = ", ".join(f"{key} {count:,}" for key, count in record[name].items())
        lines.append(f"  {name:<12} {len(product):,}" + (f"  ({axes})" if axes else ""))
    record["windows"] = len(asked.choices) * len(asked.conditions)
    record["states"] = record["windows"] * asked.states_per_design
    record["notes"] = list(asked.notes)
    lines += [f"  {name:<12} {record[name]:,}" for name in ("windows", "states")]
    return record, "\n".join([*lines, *(f"  note         {note}" for note in asked.notes)])


def _note_stale_page(folder: Path, record: dict[str, Any]) -> None:
    """Print a note if the page in a folder is of other results than its record."""
    from tendon_cli.files import read_file
    from tendon_cli.reports.html import MARK

    with contextlib.suppress(OSError):
        page = read_file(folder / "report.html", 10**7).decode(errors="replace")
        sums = [record["study_hash"], *(entry["sha256"] for entry in record["files"])]
        if MARK in page[:4096] and not all(each in page for each in sums):
            print_note(
                f"{folder}/report.html is of earlier results; `tendon report {folder}` writes it anew"
            )


def _answer_text(answer: "Answer") -> str:
    """An answer with its warnings, and what was written where."""
    record = answer.record
    files = dict.fromkeys(entry["path"].split("/")[0] for entry in record["files"])
    took = ", up to date" if answer.up_to_date else f" in {record['seconds']:.3g} s"
    written = ", ".join([*files, "design.json", *record["figures"]])
    warnings = (f"warning: {warning}" for warning in record["warnings"])
    return "\n".join(
        [answer.text, *warnings, f"{record['name']}{took}, in {answer.folder}: {written}"]
    )


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
