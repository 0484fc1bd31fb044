"""`tendon init`, `schema` and `state`: a study to start from, what editors need of one, and one state of it."""

from pathlib import Path
from typing import Annotated

import typer

import tendon_cli as tendon
from tendon_cli.commands import options, values
from tendon_cli.errors import EXIT_NEGATIVE
from tendon_cli.terminal import print_result

StarterFile = Annotated[
    Path | None,
    typer.Argument(parser=options.place, metavar="FILE", help="TOML or YAML, by its ending; default study.toml"),
]
Template = Annotated[
    str,
    options.option(
        "NAME",
        "question: sweep, design, robust, people, motor or friction",
        "--for",
        "--template",
        among=values.templates,
    ),
]
Example = Annotated[
    str | None, options.option("NAME", "copy this study or CSV from the documentation instead", "--from")
]
IsListed = Annotated[
    bool, typer.Option("--list", help="list the questions and the files that --from copies, write nothing")
]


def init(
    file: StarterFile = None, template: Template = "sweep", example: Example = None, listed: IsListed = False
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
        verb = "fit-friction" if file.suffix == ".csv" else "design" if name.startswith("design/") else "sweep"
    else:
        file = file or Path("study.toml")
        write_starter(file, template)
        verb = "sweep" if template in ("sweep", "motor") else "design"
    print_result(f"{file} written; next: tendon {verb} {file}")


def schema() -> None:
    """Print the JSON Schema of the study file, for editors."""
    from tendon_cli.studies.schema import schema_text

    print_result(schema_text())


Person = Annotated[
    str | None, options.option("NAME", "one of the study's people, or mean-man, mean-woman", among=values.persons)
]
Draw = Annotated[int | None, options.option("N", "a draw of the uncertain numbers; default: nominal numbers")]
Reversal = Annotated[bool, typer.Option("--reversal", help="add what happens if the motion turns back there")]
Plot = Annotated[Path | None, options.written("draw the motor over the cycle, and the turn with --reversal")]


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
    page = tendon.state(tendon.load_study(study, settings or ()), case, person, draw, reversal=reversal, plot=plot)
    print_result(page.record if as_json else page.text)
    if not page.has_equilibrium:
        raise typer.Exit(EXIT_NEGATIVE)
