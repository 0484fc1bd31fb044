"""The commands: parse, call, print. The only place that prints, and the only one that catches a `TendonError`."""

# No `from __future__ import annotations` here: typer would compile each annotation anew, at every start.

import sys
import traceback
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from tendon_cli import options
from tendon_cli.errors import EXIT_NOT_AS_HOPED, TendonError, UsageError
from tendon_cli.startup import spare_time
from tendon_cli.terminal import (
    as_json_text,
    as_output_error,
    flush_results,
    prepare_streams,
    print_error,
    print_result,
    progress,
)
from tendon_cli.version import __version__

app = typer.Typer(
    name="tendon",
    help="Parameter studies of tendon-driven exosuits: one motor, two tendons, one elbow.",
    epilog="Exit codes: 0 done, 1 bug, 2 usage or study, 3 input, 4 no equilibrium, 5 output, 6 workers, 7 folder.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(value: bool) -> None:
    if value:
        print_result(f"tendon {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="print the version")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="show the traceback of an error; may stand anywhere")] = False,
) -> None:
    """Options of every command."""


@app.command()
def init(file: options.StarterFile = Path("study.toml")) -> None:
    """Write a commented starter study."""
    from tendon_cli.study.starter import write_starter

    write_starter(file)
    print_result(f"{file} written; next: tendon sweep {file}")


@app.command()
def schema() -> None:
    """Print the JSON Schema of the study file, for editors."""
    from tendon_cli.study.schema import schema_text

    print_result(schema_text())


@app.command()
def state(
    study: options.StudyFile,
    settings: options.Settings = None,
    case: options.Case = None,
    as_json: options.AsJson = False,
) -> None:
    """Work one state out, with the equations' numbers, for a check by hand."""
    from tendon_cli.state_page import state_page
    from tendon_cli.study.load import load_study

    page = state_page(load_study(study, tuple(settings or ())), case)
    print_result(as_json_text(page.record()) if as_json else page.text())


@app.command()
def sweep(
    study: options.StudyFile,
    out: options.RunFolderName = None,
    jobs: options.Jobs = None,
    settings: options.Settings = None,
    dry_run: options.DryRun = False,
    resume: options.Resume = False,
    overwrite: options.Overwrite = False,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
    no_figures: options.NoFigures = False,
    allow_no_equilibrium: options.AllowNoEquilibrium = False,
    no_lock: options.NoLock = False,
    scheduler: options.Scheduler = None,
) -> None:
    """Run a study over every combination: Parquet tables and slack maps."""
    from tendon_cli import sweep_command
    from tendon_cli.study.load import load_study

    if resume and overwrite:
        raise UsageError("--resume and --overwrite exclude each other", hint="--resume keeps what is done")
    loaded = load_study(study, tuple(settings or ()))
    request = sweep_command.Request(
        loaded,
        out,
        jobs,
        resume=resume,
        overwrite=overwrite,
        figures=not no_figures,
        lock=not no_lock,
        scheduler=scheduler,
    )
    if dry_run:
        _print_unless(quiet, sweep_command.dry_run(request, as_json=as_json))
        return
    with progress(loaded.name, quiet=quiet or as_json) as show, sweep_command.stop_on_signals() as stop:
        done = sweep_command.sweep(request, stop, show)
    _print_unless(quiet, as_json_text(done.record) if as_json else done.text())
    if done.record["no_equilibrium"] and not allow_no_equilibrium:
        raise typer.Exit(EXIT_NOT_AS_HOPED)


@app.command()
def plot(
    source: options.Source,
    arm: options.DrawsArm = False,
    table: options.TableName = None,
    quantity: options.Quantities = None,
    x: options.Against = None,
    colour: options.Colour = None,
    panels: options.Panels = None,
    where: options.Where = None,
    unit: options.Units = None,
    angle: options.Angles = None,
    settings: options.Settings = None,
    format_: options.Format = "png",
    size: options.Size = "page",
    out: options.OutFile = None,
    as_json: options.AsJson = False,
) -> None:
    """Draw figures from a run folder, or from any one of its tables moved elsewhere."""
    from tendon_cli import plot_command
    from tendon_cli.figures.request import PlotRequest

    if arm:
        drawn = plot_command.draw_geometry(source, tuple(settings or ()), angle or (), out)
    else:
        several = (tuple(quantity or ()), x, colour, panels, tuple(where or ()), tuple(unit or ()))
        drawn = plot_command.draw_table(source, table, PlotRequest(*several, format_, size), out)
    written = [str(file) for file in drawn]
    print_result(as_json_text({"figures": written}) if as_json else "\n".join(written))


@app.command("fit-friction")
def fit_friction(
    csv: options.Readings,
    bend_angle: options.BendAngle = None,
    cell_1: options.FirstCell = None,
    cell_2: options.SecondCell = None,
    motor: options.MotorCell = None,
    offset: options.FitsOffset = False,
    robust: options.IsRobust = False,
    plot: options.FitFigure = None,
    out: options.Fragment = None,
    as_json: options.AsJson = False,
) -> None:
    """Fit the friction coefficient to load-cell readings, with its uncertainty."""
    from tendon_cli import friction

    fit = friction.fit_file(
        csv, bend_angle=bend_angle, cell_1=cell_1, cell_2=cell_2, motor=motor, offset=offset, robust=robust
    )
    if plot is not None:
        from tendon_cli.figures.friction import draw

        draw(fit, plot)
    if out is not None:
        friction.write_fragment(fit, out)
    print_result(as_json_text(friction.as_json(fit)) if as_json else friction.summary_lines(fit))


@app.command()
def paper(
    out: options.PaperFolder = Path("results/paper"),
    jobs: options.Jobs = None,
    quiet: options.Quiet = False,
    as_json: options.AsJson = False,
) -> None:
    """Reproduce the paper: every figure, and a ledger of every finding and claim."""
    from tendon_cli import sweep_command

    with progress("paper", quiet=quiet or as_json) as show, sweep_command.stop_on_signals() as stop:
        done = sweep_command.paper(out, jobs, stop, show)
    _print_unless(quiet, as_json_text(done.record()) if as_json else done.text())
    if not done.holds:
        raise typer.Exit(EXIT_NOT_AS_HOPED)


def _print_unless(quiet: bool, text: str) -> None:
    if not quiet or text.startswith("{"):
        print_result(text)


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run a command and leave with its exit code."""
    spare_time()
    prepare_streams()
    given = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in given
    words = [word for word in given if word != "--debug"]
    sys.exit(_run(words or ["--help"], debug))


def _run(words: list[str], debug: bool) -> int:
    """The exit code of a command; every error becomes one message here."""
    try:
        code = app(words, prog_name="tendon", standalone_mode=False)
        flush_results()
    except (typer.Abort, KeyboardInterrupt):
        return 130
    except Exception as error:  # noqa: BLE001 - whatever it is, it ends in one message and a code
        fault = _as_fault(error)
        if debug:
            traceback.print_exception(error)
        print_error(fault, as_json="--json" in words)
        return fault.exit
    return code if isinstance(code, int) else 0


def _as_fault(error: Exception) -> TendonError:
    """Any exception as one of the errors that people are told of."""
    if isinstance(error, TendonError):
        return error
    if isinstance(error, _USAGE):
        return UsageError(error.format_message(), hint="tendon --help lists the commands")
    if isinstance(error, OSError):
        return as_output_error(error)
    return TendonError(f"{type(error).__name__}: {error}", hint="this is a bug in tendon; --debug shows where")


# Typer's own class of a wrong call, wherever the installed version keeps it.
_USAGE: Any = typer.BadParameter.__mro__[2]
