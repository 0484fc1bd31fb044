"""`tendon plot`: figures of a run or a table, or of the arm of a study."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tendon_cli.commands import options
from tendon_cli.errors import InputError, UsageError
from tendon_cli.terminal import as_json_text, print_result

if TYPE_CHECKING:
    from tendon_cli.figures.request import PlotRequest
    from tendon_cli.tables.read import TableFiles

Source = Annotated[
    Path, typer.Argument(metavar="RUN_OR_TABLE", help="a run folder, or any one of its tables; a study with --arm")
]
DrawsArm = Annotated[bool, typer.Option("--arm", help="draw the arm of a study to scale, and the route of its sheath")]
TableName = Annotated[str | None, typer.Option(metavar="states|designs", help="which table of a run folder")]
Quantities = Annotated[
    list[str] | None, typer.Option("--quantity", "-y", metavar="COLUMN", help="what to draw; repeatable")
]
Against = Annotated[str | None, typer.Option("--x", "-x", metavar="COLUMN", help="what to draw it against")]
Colour = Annotated[str | None, typer.Option(metavar="AXIS", help="axis with a colour per value")]
Panels = Annotated[str | None, typer.Option(metavar="AXIS", help="axis with a panel per value")]
Where = Annotated[list[str] | None, typer.Option(metavar="FILTER", help="such as 'load_mass = 5 kg'; repeatable")]
Units = Annotated[list[str] | None, typer.Option(metavar="UNIT", help="show its dimension in it, such as cm")]
Angles = Annotated[list[str] | None, typer.Option(metavar="ANGLE", help="with --arm: elbow angle to draw")]
Format = Annotated[str, typer.Option("--format", metavar="png|svg|pdf", help="format of the figure")]
Size = Annotated[str, typer.Option(metavar="SIZE", help="column, page, '120 mm' or '120 x 80 mm'")]


def plot(
    source: Source,
    arm: DrawsArm = False,
    table: TableName = None,
    quantity: Quantities = None,
    x: Against = None,
    colour: Colour = None,
    panels: Panels = None,
    where: Where = None,
    unit: Units = None,
    angle: Angles = None,
    settings: options.Settings = None,
    format_: Format = "png",
    size: Size = "page",
    out: options.OutFile = None,
    as_json: options.AsJson = False,
) -> None:
    """Draw figures from a run folder, or from any one of its tables moved elsewhere."""
    from tendon_cli.figures.plot import plot as draw
    from tendon_cli.figures.request import PlotRequest

    if arm:
        drawn = draw_geometry(source, tuple(settings or ()), angle or (), out)
    else:
        several = (tuple(quantity or ()), x, colour, panels, tuple(where or ()), tuple(unit or ()))
        request = PlotRequest(*several, format_, size)
        drawn = draw(table_of(source, table, request), request, out)
    written = [str(file) for file in drawn]
    print_result(as_json_text({"figures": written}) if as_json else "\n".join(written))


def table_of(path: Path, wanted: str | None, request: "PlotRequest") -> "TableFiles":
    """The table that a path means: a table, or of a run folder the one that has what is asked for.

    Raises InputError where there is none, UsageError for a table that the run does not have.
    """
    from tendon_cli.sweep.run_folder import RECORD
    from tendon_cli.tables.read import open_table

    if not (path / RECORD).exists() and not (path.is_dir() and path.suffix != ".parquet"):
        return open_table(path)
    found = {name: path / f"{name}.parquet" for name in ("states", "designs") if (path / f"{name}.parquet").exists()}
    if not found:
        raise InputError("holds neither designs.parquet nor states.parquet", where=str(path), hint="run `tendon sweep`")
    if wanted is not None:
        if wanted not in found:
            raise UsageError(f'the run has no table "{wanted}"', where=str(path), hint=f"it has {', '.join(found)}")
        return open_table(found[wanted])
    tables = [open_table(file) for file in found.values()]
    asked = {*request.quantities, *(name for name in (request.x,) if name)}
    return next((table for table in tables if asked <= set(table.schema.names)), tables[0])


def draw_geometry(study_file: Path, settings: tuple[str, ...], angles: Sequence[str], out: Path | None) -> list[Path]:
    """The arm of a study to scale; and the route of its sheath, where it names one."""
    from tendon_cli.figures.arm import draw_arm
    from tendon_cli.figures.route import draw_route
    from tendon_cli.study.load import load_study
    from tendon_cli.study.reading import read_document
    from tendon_cli.study.route import MAX_BYTES, read_route

    study = load_study(study_file, settings)
    target = out or Path(f"{study.name}-arm.png")
    drawn = [draw_arm(study, [_angle(text) for text in angles], target)]
    sheath = read_document(study_file).content.get("sheath")
    name = sheath.get("path") if isinstance(sheath, dict) else None
    if isinstance(name, str):
        with (study_file.parent / name).open("rb") as file:
            points = read_route(file.read(MAX_BYTES), name)
        drawn.append(draw_route(points, target.with_stem(f"{target.stem}-route")))
    return drawn


def _angle(text: str) -> float:
    from tendon_cli.units import UnitError, parse_measure

    try:
        return parse_measure(text, "angle").si
    except UnitError as error:
        raise UsageError(error.problem, where="--angle", hint=error.hint) from None
