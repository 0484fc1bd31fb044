"""Commands on studies: `tendon init` and `tendon state`."""

from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import completion, options
from tendon_cli.errors import EXIT_NEGATIVE
from tendon_cli.terminal import print_result

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
SchemaOption = Annotated[
    bool,
    typer.Option(
        "--schema", help="print the JSON Schema of the study file, for editors, write nothing"
    ),
]


def init(
    file: StarterArgument = None,
    template: TemplateOption = "sweep",
    example: ExampleOption = None,
    listed: ListOption = False,
    schema: SchemaOption = False,
) -> None:
    """Write a commented study to start from, or copy one from the documentation."""
    from tendon_cli.commands import starter

    if listed:
        questions = [f"  {name:<10} {question}" for name, question in starter.TEMPLATES.items()]
        files = [f"  {name}" for name in starter.examples()]
        print_result("\n".join(["--for", *questions, "--from", *files]))
        return
    if schema:
        from tendon_cli.studies.json_schema import schema_text

        print_result(schema_text())
        return
    options.refuse_both("--for", template != "sweep", "--from", example is not None)
    if example is not None:
        file, name = starter.write_example(example, file)
        step = starter.next_step_of_example(name, file)
    else:
        file = file or Path("study.toml")
        starter.write_starter(file, template)
        step = starter.next_step(template, file)
    print_result(f"{file} written; {step}")


PersonOption = Annotated[
    str | None,
    options.option(
        "NAME", "one of the study's people, or mean-man, mean-woman", completer=completion.persons
    ),
]
DrawOption = Annotated[
    int | None,
    options.option(
        "N",
        "number of a draw of the uncertain numbers; default: nominal numbers",
        parser=options.number_parser("--draw", 1),
    ),
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
    row: options.RowOption = None,
    person: PersonOption = None,
    draw: DrawOption = None,
    reversal: ReversalOption = False,
    plot: PlotOption = None,
    overwrite: options.OverwriteFileOption = False,
    as_json: options.JsonOption = False,
) -> None:
    """Work out one state line by line, with the numbers of every equation, to check by hand."""
    from tendon_cli.state_page.page import state_page
    from tendon_cli.studies.load import any_study

    loaded = any_study(study, settings or ())
    page = state_page(
        loaded,
        case,
        person,
        draw,
        rows=options.rows_by_table(row),
        reversal=reversal,
        plot=plot,
        overwrite=overwrite,
    )
    print_result(page.record if as_json else page.text)
    if not page.has_equilibrium:
        raise typer.Exit(EXIT_NEGATIVE)
