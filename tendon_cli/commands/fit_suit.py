"""`tendon fit-suit`: a suit's numbers from its own log."""

from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import options
from tendon_cli.errors import UsageError
from tendon_cli.terminal import print_note, print_result

LogsArgument = Annotated[
    list[Path],
    typer.Argument(
        parser=options.read_path,
        metavar="LOG",
        help="logs of the suit: joint angle, spool angle, motor torque; several make one fit",
    ),
]
SuitFigureOption = Annotated[
    Path | None, options.output_option("draw loops and residuals: .png, .svg, .pdf")
]
SuitFragmentOption = Annotated[
    Path | None,
    options.out_option("write the numbers to a file for `fitted_from` of a study"),
]


def fit_suit(
    study: options.StudyArgument,
    logs: LogsArgument,
    settings: options.SettingsOption = None,
    plot: SuitFigureOption = None,
    out: SuitFragmentOption = None,
    overwrite: options.OverwriteFileOption = False,
    as_json: options.JsonOption = False,
) -> None:
    """Fit a suit's friction, pretension and stiffnesses to logs of its own motor and joint."""
    from tendon_cli import say
    from tendon_cli.files import check_output, is_figure
    from tendon_cli.fits.suit.suit_result import (
        is_suit_fragment,
        next_command,
        write_suit_fragment,
    )
    from tendon_cli.fits.written import said_of

    for option, file, is_ours in (("--plot", plot, is_figure), ("--out", out, is_suit_fragment)):
        if file is None:
            continue
        if any(file.absolute() == source.absolute() for source in (study, *logs)):
            problem = f"{file.name} is an input and would be overwritten"
            raise UsageError(problem, where=option, hint="choose another name")
        check_output(file, is_ours, overwrite=overwrite)
    from tendon_cli.fits.suit.suit_fitting import fit_suit as fit_logs
    from tendon_cli.studies.load import any_study

    fit = fit_logs(any_study(study, settings or ()), logs)
    # What stands there is read before it is replaced.
    sources = say.join_words([log.source for log in fit.selection.logs])
    said = [
        said_of(file, "fit.logs", sources, "the numbers")
        for file in (plot, out)
        if file is not None
    ]
    if plot is not None:
        fit.plot(out=plot, overwrite=overwrite)
    if out is not None:
        write_suit_fragment(fit, out, overwrite=overwrite)
        said.append(f"next: {next_command(fit, study, settings or (), out)}")
    print_result(fit.record if as_json else fit.text)
    for line in said:
        print_note(line)
