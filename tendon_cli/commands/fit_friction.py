"""`tendon fit-friction`: the friction coefficient from load-cell readings."""

import contextlib
from pathlib import Path
from typing import Annotated

import typer

import tendon_cli as tendon
from tendon_cli.commands import options
from tendon_cli.errors import UsageError
from tendon_cli.terminal import as_json_text, print_result

Readings = Annotated[
    Path,
    typer.Argument(
        parser=options.source, metavar="CSV", help="readings of two load cells, one at each end of a sheath"
    ),
]
BendAngle = Annotated[
    str | None, typer.Option(metavar="ANGLE", help="total bend of the sheath: '144 deg' or '144 deg +/- 2 deg'")
]
Route = Annotated[
    Path | None,
    typer.Option(
        parser=options.source, metavar="FILE", help="way-points x, y, z of the sheath instead: its bend, with its error"
    ),
]
PathSmoothing = Annotated[
    str | None, typer.Option(metavar="LENGTH", help="noise of the route's way-points, such as '0.5 mm'")
]
FirstCell = Annotated[str | None, typer.Option(metavar="COLUMN", help="column of the first load cell")]
SecondCell = Annotated[str | None, typer.Option(metavar="COLUMN", help="column of the second load cell")]
MotorCell = Annotated[str | None, typer.Option(metavar="1|2", help="which cell is at the motor's end")]
FitFigure = Annotated[
    Path | None, typer.Option(parser=options.place, metavar="FILE", help="draw readings and fit: .png, .svg, .pdf")
]
Fragment = Annotated[
    Path | None, typer.Option(parser=options.place, metavar="FILE", help="write a fragment for [sheath] friction_from")
]


def fit_friction(
    csv: Readings,
    bend_angle: BendAngle = None,
    route: Route = None,
    path_smoothing: PathSmoothing = None,
    cell_1: FirstCell = None,
    cell_2: SecondCell = None,
    motor: MotorCell = None,
    plot: FitFigure = None,
    out: Fragment = None,
    as_json: options.AsJson = False,
) -> None:
    """Fit the friction coefficient, with its uncertainty, to the readings of two load cells."""
    _check_places((csv, route), plot, out)
    fit = tendon.fit_friction(
        csv,
        bend_angle,
        route=route,
        path_smoothing=path_smoothing,
        cell_1=cell_1,
        cell_2=cell_2,
        motor=motor,
    )
    if plot is not None:
        from tendon_cli.figures.friction import draw

        draw(fit, plot)
    from tendon_cli import friction

    if out is not None:
        friction.write_fragment(fit, out)
    print_result(as_json_text(friction.as_json(fit)) if as_json else friction.summary_lines(fit))


def _check_places(read: tuple[Path | None, ...], plot: Path | None, out: Path | None) -> None:
    """Refuse to write over the readings or the route, over what tendon did not write, or both over each other."""
    from tendon_cli.files import check_ours

    if plot is not None and out is not None and plot.absolute() == out.absolute():
        raise UsageError("--plot and --out name the same file", where="--plot, --out")
    for place, mark, option in ((plot, "tendon fit-friction", "--plot"), (out, "`tendon fit-friction`", "--out")):
        if place is None:
            continue
        for source in filter(None, read):
            with contextlib.suppress(OSError, ValueError):
                if place.samefile(source):
                    problem = f"{source.name}, which is read, would be written over"
                    raise UsageError(problem, where=option, hint="choose another name")
        check_ours(place, mark, option)
