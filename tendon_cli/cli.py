"""The commands: parse, call, print. The only place that prints, and the only one that catches a `TendonError`."""

from __future__ import annotations

import json
import sys
import traceback
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from tendon_cli.errors import EXIT_NO_EQUILIBRIUM, OutputError, TendonError, UsageError
from tendon_cli.terminal import flush_results, prepare_streams, print_note, print_result, progress
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

StudyFile = Annotated[Path, typer.Argument(metavar="STUDY", help="study file, TOML or YAML")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="override a key, such as 'arm.b1=160 mm'; repeatable"),
]
AsJson = Annotated[bool, typer.Option("--json", help="print exactly one JSON object")]


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
def init(
    file: Annotated[Path, typer.Argument(metavar="[FILE]", help="TOML or YAML, by its ending")] = Path("study.toml"),
) -> None:
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
    study: StudyFile,
    settings: Settings = None,
    case: Annotated[str | None, typer.Option(help="which of the study's cases")] = None,
    as_json: AsJson = False,
) -> None:
    """Work one state out, with the equations' numbers, for a check by hand."""
    from tendon_cli.state_page import state_page
    from tendon_cli.study.load import load_study

    page = state_page(load_study(study, tuple(settings or ())), case)
    print_result(_json(page.record()) if as_json else page.text())


@app.command()
def sweep(
    study: StudyFile,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="run folder; default results/<name>")] = None,
    jobs: Annotated[int | None, typer.Option(min=1, help="parts computed at once; default all cores")] = None,
    settings: Settings = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="show size and cost, write nothing")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="finish an interrupted run")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace the run that stands in the folder")] = False,
    as_json: AsJson = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="print nothing but errors")] = False,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="draw no slack maps")] = False,
    allow_no_equilibrium: Annotated[
        bool, typer.Option("--allow-no-equilibrium", help="exit 0 although states have no equilibrium")
    ] = False,
    no_lock: Annotated[bool, typer.Option("--no-lock", help="for file systems that cannot lock")] = False,
    scheduler: Annotated[
        str | None, typer.Option(metavar="tcp://HOST:PORT", help="compute on this running Dask cluster")
    ] = None,
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
    _print_unless(quiet, _json(done.record) if as_json else done.text())
    if done.record["no_equilibrium"] and not allow_no_equilibrium:
        raise typer.Exit(EXIT_NO_EQUILIBRIUM)


@app.command()
def plot(
    source: Annotated[
        Path, typer.Argument(metavar="RUN_OR_TABLE", help="a run folder, or any one of its tables; a study with --arm")
    ],
    arm: Annotated[
        bool, typer.Option("--arm", help="draw the arm of a study to scale, and the route of its sheath")
    ] = False,
    table: Annotated[str | None, typer.Option(metavar="states|designs", help="which table of a run folder")] = None,
    quantity: Annotated[
        list[str] | None, typer.Option("--quantity", "-y", metavar="COLUMN", help="what to draw; repeatable")
    ] = None,
    x: Annotated[str | None, typer.Option("--x", "-x", metavar="COLUMN", help="what to draw it against")] = None,
    colour: Annotated[str | None, typer.Option(metavar="AXIS", help="axis with a colour per value")] = None,
    panels: Annotated[str | None, typer.Option(metavar="AXIS", help="axis with a panel per value")] = None,
    where: Annotated[
        list[str] | None, typer.Option(metavar="FILTER", help="such as 'load_mass = 5 kg'; repeatable")
    ] = None,
    unit: Annotated[list[str] | None, typer.Option(metavar="UNIT", help="show its dimension in it, such as cm")] = None,
    angle: Annotated[list[str] | None, typer.Option(metavar="ANGLE", help="with --arm: elbow angle to draw")] = None,
    settings: Settings = None,
    format_: Annotated[str, typer.Option("--format", metavar="png|svg|pdf", help="format of the figure")] = "png",
    size: Annotated[str, typer.Option(metavar="SIZE", help="column, page, '120 mm' or '120 x 80 mm'")] = "page",
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="file or folder to write to")] = None,
    as_json: AsJson = False,
) -> None:
    """Draw figures from a run folder, or from any one of its tables moved elsewhere."""
    from tendon_cli import plot_command
    from tendon_cli.figures.request import PlotRequest

    if arm:
        drawn = plot_command.draw_geometry(source, tuple(settings or ()), angle or (), out)
    else:
        request = PlotRequest(
            tuple(quantity or ()), x, colour, panels, tuple(where or ()), tuple(unit or ()), format_, size
        )
        drawn = plot_command.draw_table(source, table, request, out)
    written = [str(file) for file in drawn]
    print_result(_json({"figures": written}) if as_json else "\n".join(written))


@app.command("fit-friction")
def fit_friction(
    csv: Annotated[Path, typer.Argument(metavar="CSV", help="readings of two load cells, one at each end of a sheath")],
    bend_angle: Annotated[
        str | None,
        typer.Option(metavar="ANGLE", help="total bend of the sheath, such as '144 deg' or '144 deg +/- 2 deg'"),
    ] = None,
    cell_1: Annotated[str | None, typer.Option(metavar="COLUMN", help="column of the first load cell")] = None,
    cell_2: Annotated[str | None, typer.Option(metavar="COLUMN", help="column of the second load cell")] = None,
    motor: Annotated[str | None, typer.Option(metavar="1|2", help="which cell is at the motor's end")] = None,
    offset: Annotated[bool, typer.Option("--offset", help="fit a zero offset of each cell, too")] = False,
    robust: Annotated[bool, typer.Option("--robust", help="let outliers weigh less")] = False,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="draw readings and fit: .png, .svg, .pdf")] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="write a fragment for [sheath] friction_from")
    ] = None,
    as_json: AsJson = False,
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
    print_result(_json(friction.as_json(fit)) if as_json else friction.summary_lines(fit))


def _print_unless(quiet: bool, text: str) -> None:
    if not quiet or text.startswith("{"):
        print_result(text)


def _json(content: dict[str, Any]) -> str:
    return json.dumps(content, indent=2, ensure_ascii=False)


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run a command and leave with its exit code."""
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
        _print_error(fault, as_json="--json" in words)
        return fault.exit
    return code if isinstance(code, int) else 0


def _as_fault(error: Exception) -> TendonError:
    """Any exception as one of the errors that people are told of."""
    if isinstance(error, TendonError):
        return error
    if isinstance(error, _USAGE):
        return UsageError(error.format_message(), hint="tendon --help lists the commands")
    if isinstance(error, OSError):
        return OutputError(f"input or output failed: {error.strerror or error}")
    return TendonError(f"{type(error).__name__}: {error}", hint="this is a bug in tendon; --debug shows where")


# Typer's own class of a wrong call, wherever the installed version keeps it.
_USAGE: Any = typer.BadParameter.__mro__[2]


def _print_error(fault: TendonError, *, as_json: bool) -> None:
    names = ("exit", "kind", "message", "where", "hint")
    if as_json:
        try:
            print_result(_json({"error": {name: getattr(fault, name) for name in names}}))
        except OutputError:
            pass  # nobody takes it there, so it is told as a line
        else:
            return
    place = f"{fault.where}: " if fault.where else ""
    print_note(f"tendon: error: {place}{fault.message}" + (f"\n  hint: {fault.hint}" if fault.hint else ""))


if __name__ == "__main__":
    main()
