"""`tendon fit-friction`: the friction coefficient from load-cell readings."""

import contextlib
import itertools
from pathlib import Path
from typing import Annotated

import typer

import tendon_cli as tendon
from tendon_cli.commands import options
from tendon_cli.errors import UsageError
from tendon_cli.terminal import print_result

Readings = Annotated[
    list[Path],
    typer.Argument(
        parser=options.source,
        metavar="CSV",
        help="readings of two load cells, one at each end; several are one fit",
    ),
]
BendAngle = Annotated[
    str | None,
    options.option("ANGLE", "total bend of the sheath: '144 deg' or '144 deg +/- 2 deg'"),
]
Route = Annotated[
    Path | None,
    options.option(
        "FILE", "way-points x, y, z of the sheath, instead of --bend-angle", parser=options.source
    ),
]
PathSmoothing = Annotated[
    str | None, options.option("LENGTH", "noise of the route's way-points, such as '0.5 mm'")
]
FirstCell = Annotated[str | None, options.option("COLUMN", "column of the first load cell")]
SecondCell = Annotated[str | None, options.option("COLUMN", "column of the second load cell")]
MotorCell = Annotated[str | None, options.option("1|2", "which cell is at the motor's end")]
Position = Annotated[
    str | None,
    options.option("COLUMN", "column of the motor's position, travel, speed or encoder counts"),
]
ZeroMotor = Annotated[
    str | None, options.option("FORCE", "what the motor's cell reads without load")
]
ZeroLoad = Annotated[str | None, options.option("FORCE", "what the load's cell reads without load")]
CellUncertainty = Annotated[
    str | None,
    options.option("TEXT", "standard uncertainty of a cell's zero and gain: '0.2 N, 0.5 %'"),
]
StrokesFile = Annotated[Path | None, options.written("write a table of the strokes: .csv")]
FitFigure = Annotated[Path | None, options.written("draw readings and fit: .png, .svg, .pdf")]
Fragment = Annotated[Path | None, options.written("write a file for [sheath] friction_from")]


def fit_friction(
    csv: Readings,
    bend_angle: BendAngle = None,
    route: Route = None,
    path_smoothing: PathSmoothing = None,
    cell_1: FirstCell = None,
    cell_2: SecondCell = None,
    motor: MotorCell = None,
    position: Position = None,
    zero_motor: ZeroMotor = None,
    zero_load: ZeroLoad = None,
    cell_uncertainty: CellUncertainty = None,
    strokes: StrokesFile = None,
    plot: FitFigure = None,
    out: Fragment = None,
    as_json: options.AsJson = False,
) -> None:
    """Fit the friction coefficient, with its uncertainty, to the readings of two load cells."""
    _check_places((*csv, route), plot, out, strokes)
    fit = tendon.fit_friction(
        csv,
        bend_angle,
        route=route,
        path_smoothing=path_smoothing,
        cell_1=cell_1,
        cell_2=cell_2,
        motor=motor,
        position=position,
        zero_motor=zero_motor,
        zero_load=zero_load,
        cell_uncertainty=cell_uncertainty,
    )
    if plot is not None:
        from tendon_cli.figures.friction import draw

        draw(fit, plot)
    from tendon_cli import friction

    if out is not None:
        friction.write_fragment(fit, out)
    if strokes is not None:
        friction.write_strokes(fit, strokes)
    print_result(fit.record if as_json else fit.text)


def _check_places(
    read: tuple[Path | None, ...], plot: Path | None, out: Path | None, strokes: Path | None
) -> None:
    """Refuse to write over the readings or the route, over what tendon did not write, or both over each other."""
    from tendon_cli.files import check_ours

    given = [
        (option, place)
        for option, place in (("--plot", plot), ("--out", out), ("--strokes", strokes))
        if place
    ]
    for (one, place), (other, place_of_other) in itertools.combinations(given, 2):
        if place.absolute() == place_of_other.absolute():
            raise UsageError(f"{one} and {other} name the same file", where=f"{one}, {other}")
    for option, place in given:
        mark = "`tendon fit-friction`" if option == "--out" else "tendon fit-friction"
        for source in filter(None, read):
            with contextlib.suppress(OSError, ValueError):
                if place.samefile(source):
                    problem = f"{source.name}, which is read, would be written over"
                    raise UsageError(problem, where=option, hint="choose another name")
        check_ours(place, mark, option)
