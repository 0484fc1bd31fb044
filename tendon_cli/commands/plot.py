"""`tendon plot`: figures of a run or a table, or of the arm of a study."""

from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import options, values
from tendon_cli.errors import UsageError
from tendon_cli.terminal import print_result

Source = Annotated[
    Path,
    typer.Argument(
        parser=options.source, metavar="RUN_OR_TABLE", help="a run folder, or any one of its tables; a study with --arm"
    ),
]
Between = Annotated[
    bool, typer.Option("--between", help="of an answer: what each limit asks for over the angle, and what binds where")
]
DrawsArm = Annotated[bool, typer.Option("--arm", help="draw the arm of a study to scale, and the route of its sheath")]
TableName = Annotated[str | None, options.option("states|designs", "table of a run folder")]
Quantities = Annotated[
    list[str] | None, options.option("COLUMN", "what to draw; repeatable", "--quantity", "-y", among=values.columns)
]
Against = Annotated[str | None, options.option("COLUMN", "the horizontal axis", "--x", "-x", among=values.columns)]
Colour = Annotated[str | None, options.option("AXIS", "a colour for each value of this axis", among=values.columns)]
Panels = Annotated[str | None, options.option("AXIS", "a panel for each value of this axis", among=values.columns)]
Units = Annotated[
    list[str] | None,
    options.option("UNIT", "unit to show a dimension in, such as cm; repeatable", among=values.units),
]
Angles = Annotated[
    list[str] | None, options.option("ANGLE", "with --arm: elbow angle to draw, such as 45 deg; repeatable")
]
Format = Annotated[str, options.option("png|svg|pdf", "format of the figure", "--format")]
Size = Annotated[str, options.option("SIZE", "column, page, '120 mm' or '120 x 80 mm'", among=values.sizes)]


def plot(
    source: Source,
    arm: DrawsArm = False,
    between: Between = False,
    table: TableName = None,
    quantity: Quantities = None,
    x: Against = None,
    colour: Colour = None,
    panels: Panels = None,
    where: options.Where = None,
    unit: Units = None,
    angle: Angles = None,
    case: options.Case = None,
    settings: options.Settings = None,
    format_: Format = "png",
    size: Size = "page",
    out: options.OutFile = None,
    as_json: options.AsJson = False,
) -> None:
    """Draw figures of a run, of any table, of an answer, or of the arm of a study."""
    if str(source) == "-":
        raise UsageError("a figure needs a file or a folder, not standard input", hint="tendon plot --arm study.toml")
    if arm:
        from tendon_cli.figures.route import draw_geometry

        drawn = draw_geometry(source, tuple(settings or ()), [_angle(text) for text in angle or ()], out, case)
    elif between:
        from tendon_cli.engine.results import verified_record
        from tendon_cli.figures.answer import draw_between_samples

        record = verified_record(source)
        if record["verb"] != "design":
            hint = "tendon design STUDY writes one"
            raise UsageError("is not an answer, and only answers have a window to draw", where=str(source), hint=hint)
        drawn = [draw_between_samples(source, record, out)]
    else:
        from tendon_cli.figures.draw import plot as draw
        from tendon_cli.figures.draw import table_of
        from tendon_cli.studies.figures import figure_spec

        asked = {"quantity": quantity, "x": x, "colour": colour, "panels": panels, "where": where, "unit": unit}
        given = {name: value for name, value in asked.items() if value is not None}
        spec = figure_spec(**given, format=format_, size=size)
        drawn = draw(table_of(source, spec, table), spec, out)
    written = [str(file) for file in drawn]
    print_result({"figures": written} if as_json else "\n".join(written))


def _angle(text: str) -> float:
    from tendon_cli.units import UnitError, parse_measure

    try:
        return parse_measure(text, "angle").si
    except UnitError as error:
        raise UsageError(error.problem, where="--angle", hint=error.hint) from None
