"""The commands by their names, and the only place that catches a `TendonError`."""

# No `from __future__ import annotations`: typer would compile each annotation at every start.

import os
import sys
import traceback
from collections.abc import Callable
from typing import Annotated, Any, NoReturn

import typer
import typer.core

from tendon_cli.commands.completion import complete_in_bash
from tendon_cli.commands.compute import command_of
from tendon_cli.commands.fit_friction import fit_friction
from tendon_cli.commands.fit_suit import fit_suit
from tendon_cli.commands.options import STUDY, hint_at_study
from tendon_cli.commands.read_results import check, compare, export, plot, report, show
from tendon_cli.commands.startup import end_on_signals, exit_code
from tendon_cli.commands.studies import init, state
from tendon_cli.errors import (
    MemoryShortError,
    OutputError,
    TendonError,
    UsageError,
    is_memory_short,
)
from tendon_cli.terminal import (
    as_output_error,
    flush_results,
    give_up_stdout,
    prepare_streams,
    print_error,
    print_result,
)
from tendon_cli.verbs.registry import kinds
from tendon_cli.version import __version__

app = typer.Typer(
    name="tendon",
    help="Parameter studies of tendon-driven exosuits: one motor, two tendons, one elbow.",
    epilog="Exit codes: 0 done, 1 bug in tendon, 2 usage or study, 3 input file, "
    "4 negative result, 5 output, 6 workers lost, 7 folder in use, unfinished, or holding "
    "something else; 130, 143, 129 stopped by a signal.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


_COMPLETES = "_TENDON_COMPLETE"
"""Variable of the environment by which a shell asks for completions."""
GONE = {
    "paper": "`make paper` in the repository reproduces the paper",
    "schema": "`tendon init --schema` prints it",
    "completion": "`tendon --install-completion` sets it up",
    "--no-lock": "leave it out: a file system without locks is noticed, and told",
    "--frictionloss": "leave it out: the model says in a comment which friction it lacks",
    "--template": "`tendon init --for` takes the question",
}
"""Commands and options of earlier versions, each with what to use instead."""
_NO_BRACES = str.maketrans("", "", "{}")


class _Command(typer.core.TyperCommand):
    """Command that is parsed while it is typed, and described without braces or cut sentences."""

    def get_short_help_str(self, limit: int = 45) -> str:  # noqa: ARG002 - never cut
        return " ".join((self.help or "").split("\n\n")[0].split())

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if ctx.resilient_parsing and args and args[-1].startswith("-"):
            args = args[:-1]  # whose value is completed; without one, nothing would be parsed
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        from tendon_cli.files import guard_inputs  # neither help nor completion pays for it

        guard_inputs()
        return super().invoke(ctx)

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        return [piece.translate(_NO_BRACES) for piece in super().collect_usage_pieces(ctx)]


def _print_version(value: bool) -> None:
    if value:
        print_result(f"tendon {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", "-V", callback=_print_version, is_eager=True, help="print the version"
        ),
    ] = False,
    debug: Annotated[
        bool,
        typer.Option("--debug", help="show the traceback of an error; works anywhere in the line"),
    ] = False,
) -> None:
    """Options of every command."""


_COMMANDS: tuple[Callable[..., None], ...] = (
    init,
    state,
    *map(command_of, kinds().values()),
    check,
    compare,
    plot,
    show,
    export,
    report,
)
for _command in _COMMANDS:
    app.command(cls=_Command)(_command)
app.command("fit-friction", cls=_Command)(fit_friction)
app.command("fit-suit", cls=_Command)(fit_suit)


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run a command and leave with its exit code."""
    prepare_streams()
    given = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in given
    words = [word for word in given if word != "--debug"]
    sys.exit(_run(words or ["--help"], debug))


def _run(words: list[str], debug: bool) -> int:
    """Run a command and return its exit code; every error becomes one message here."""
    try:
        end_on_signals()
        command = typer.main.get_command(app)
        if _COMPLETES in os.environ:
            complete_in_bash()
        code = command(words, prog_name="tendon", standalone_mode=False)
        flush_results()
    except (typer.Abort, KeyboardInterrupt):
        return exit_code()
    except SystemExit as end:  # of typer's completion, or of a help page whose reader has left
        if _COMPLETES in os.environ or not end.code:
            return int(end.code or 0)
        give_up_stdout()
        return OutputError.exit
    except Exception as error:  # noqa: BLE001 - whatever it is, it ends in one message and a code
        fault = _as_fault(error, words)
        if debug:
            traceback.print_exception(error)
        print_error(fault, as_json="--json" in words)
        return fault.exit
    return exit_code(code if isinstance(code, int) else 0)


def _as_fault(error: Exception, words: list[str]) -> TendonError:
    """Return any exception of a command as an error with an exit code and a message."""
    if isinstance(error, TendonError):
        return error
    if is_memory_short(error):
        hint = "fewer --jobs need less; what was finished of a sweep is kept, --resume continues"
        problem = f"there is not enough memory: {str(error) or type(error).__name__}"
        return MemoryShortError(problem, hint=hint)
    message = getattr(error, "format_message", None)
    if callable(message):  # typer's errors of a wrong call
        option = getattr(error, "option_name", None)
        command = next((word for word in words if not word.startswith("-")), "")
        if (option or command) in GONE:
            problem = f"no such option: {option}" if option else f"no such command: {command}"
            return UsageError(problem, hint=GONE[option or command])
        similar = getattr(error, "possibilities", None)
        if option and similar:
            hint = f"did you mean {' or '.join(similar)}?"
            return UsageError(f"no such option: {option}", hint=hint)
        hint = "tendon --help lists the commands"
        missing = getattr(error, "param", None)
        if type(error).__name__ == "MissingParameter" and getattr(missing, "metavar", "") == STUDY:
            hint = hint_at_study(command)
        elif command == "export":
            hint = "tendon export TABLE FILE.csv; tendon export ANSWER --to parts parts.csv"
        return UsageError(str(message()), hint=hint)
    if isinstance(error, OSError):
        return as_output_error(error)
    hint = "this is a bug in tendon; --debug shows where"
    return TendonError(f"{type(error).__name__}: {error}", hint=hint)
