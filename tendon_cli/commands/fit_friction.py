"""`tendon fit-friction`: the friction coefficient from load-cell readings."""

import contextlib
import itertools
from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import options
from tendon_cli.errors import InputError, UsageError
from tendon_cli.terminal import print_note, print_result

ReadingsArgument = Annotated[
    list[Path],
    typer.Argument(
        parser=options.read_path,
        metavar="CSV",
        help="readings of two load cells, one at each end; several files make one fit",
    ),
]
BendAngleOption = Annotated[
    str | None,
    options.option("ANGLE", "total bend of the sheath: '144 deg' or '144 deg +/- 2 deg'"),
]
RouteOption = Annotated[
    Path | None,
    options.option(
        "FILE",
        "way-points x, y, z of the sheath, instead of --bend-angle",
        parser=options.read_path,
    ),
]
PathSmoothingOption = Annotated[
    str | None, options.option("LENGTH", "noise of the way-points of --route, such as '0.5 mm'")
]
FirstCellOption = Annotated[str | None, options.option("COLUMN", "column of the first load cell")]
SecondCellOption = Annotated[str | None, options.option("COLUMN", "column of the second load cell")]
MotorCellOption = Annotated[str | None, options.option("1|2", "which cell is at the motor's end")]
DirectionOption = Annotated[
    str | None, options.option("COLUMN", "column that says pull, release and rest")
]
PositionOption = Annotated[
    str | None,
    options.option("COLUMN", "column of the motor's position, travel, speed or encoder counts"),
]
ZeroMotorOption = Annotated[
    str | None, options.option("FORCE", "reading of the motor's cell without load")
]
ZeroLoadOption = Annotated[
    str | None, options.option("FORCE", "reading of the load's cell without load")
]
CellUncertaintyOption = Annotated[
    str | None,
    options.option(
        "TEXT",
        "standard uncertainty of a cell's zero, gain and delay: '0.2 N, 0.5 %, 5 ms'; without it "
        "and --zero-motor, 2 % of the force is assumed for a zero that the readings cannot tell "
        "from friction, and 10 ms or a row for a delay",
    ),
]
StrokesOption = Annotated[Path | None, options.output_option("write a table of the strokes: .csv")]
FitFigureOption = Annotated[
    Path | None, options.output_option("draw readings and fit: .png, .svg, .pdf")
]
FragmentOption = Annotated[
    Path | None,
    options.out_option("write the coefficient to a file for [sheath] friction_from"),
]


def fit_friction(
    csv: ReadingsArgument,
    bend_angle: BendAngleOption = None,
    route: RouteOption = None,
    path_smoothing: PathSmoothingOption = None,
    cell_1: FirstCellOption = None,
    cell_2: SecondCellOption = None,
    motor: MotorCellOption = None,
    direction: DirectionOption = None,
    position: PositionOption = None,
    zero_motor: ZeroMotorOption = None,
    zero_load: ZeroLoadOption = None,
    cell_uncertainty: CellUncertaintyOption = None,
    strokes: StrokesOption = None,
    plot: FitFigureOption = None,
    out: FragmentOption = None,
    overwrite: options.OverwriteFileOption = False,
    as_json: options.JsonOption = False,
) -> None:
    """Fit the friction coefficient, with its uncertainty, to the readings of two load cells."""
    _check_outputs((*csv, route), plot, out, strokes, overwrite=overwrite)
    from tendon_cli.fits.friction.fit import fit_friction as fit_readings

    fit = fit_readings(
        csv,
        bend_angle,
        route=route,
        path_smoothing=path_smoothing,
        cell_1=cell_1,
        cell_2=cell_2,
        motor=motor,
        direction=direction,
        position=position,
        zero_motor=zero_motor,
        zero_load=zero_load,
        cell_uncertainty=cell_uncertainty,
    )
    from tendon_cli.fits.friction.fit_result import write_fragment, write_strokes
    from tendon_cli.fits.written import said_of

    # What stands there is read before it is replaced.
    is_refused = out is not None and fit.is_doubtful
    files = (plot, None if is_refused else out, strokes)
    said = [
        said_of(file, "friction.source", fit.source, "the coefficient")
        for file in files
        if file is not None
    ]
    if plot is not None:
        from tendon_cli.figures.friction import draw

        draw(fit, plot, overwrite=overwrite)
    if out is not None and not is_refused:
        write_fragment(fit, out, overwrite=overwrite)
    if strokes is not None:
        write_strokes(fit, strokes, overwrite=overwrite)
    print_result(fit.record if as_json else fit.text)
    for line in said:
        print_note(line)
    if is_refused and out is not None:
        problem = f"{out.name} is not written, because the number should not be used"
        raise InputError(problem, where="--out", hint="the first warning says why")


def _check_outputs(
    inputs: tuple[Path | None, ...],
    plot: Path | None,
    out: Path | None,
    strokes: Path | None,
    *,
    overwrite: bool,
) -> None:
    """Raise UsageError if an output would overwrite an input or a file of somebody else.

    Args:
        inputs: Readings and route.
        plot: Figure to write.
        out: File of the coefficient to write.
        strokes: Table of strokes to write.
        overwrite: True to replace files that tendon did not write.
    """
    from tendon_cli.files import check_output, is_figure
    from tendon_cli.fits.friction.fit_result import is_fragment, is_strokes

    outputs = [
        ("--plot", plot, is_figure),
        ("--out", out, is_fragment),
        ("--strokes", strokes, is_strokes),
    ]
    given = [(option, file, is_ours) for option, file, is_ours in outputs if file]
    for (first, file, _), (second, other_file, _) in itertools.combinations(given, 2):
        if file.absolute() == other_file.absolute():
            raise UsageError(f"{first} and {second} name the same file", where=f"{first}, {second}")
    for option, file, is_ours in given:
        for source in filter(None, inputs):
            with contextlib.suppress(OSError, ValueError):
                if file.samefile(source):
                    problem = f"{source.name} is an input and would be overwritten"
                    raise UsageError(problem, where=option, hint="choose another name")
        check_output(file, is_ours, overwrite=overwrite)
