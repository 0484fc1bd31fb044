"""Commands that compute a folder of results, one for each verb: `tendon sweep`, `tendon design`."""

import contextlib
import inspect
import json
import shlex
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tendon_cli.commands import options
from tendon_cli.commands.startup import keep_freed_memory, stopped_by_signals
from tendon_cli.errors import EXIT_NEGATIVE, UsageError
from tendon_cli.terminal import can_ask, is_confirmed, print_note, print_result, progress
from tendon_cli.verbs.registry import TaskKind

if TYPE_CHECKING:
    from tendon_cli.engine.task import Task

_LONG = 30.0
"""Expected time of the processor from which on it is said before, s."""
_WORTH_A_NOTE = 100 * 10**6
"""Size of results above which it is said before they are written, bytes."""
_WORTH_A_QUESTION = 10**9
"""Size of results above which a terminal is asked, bytes."""


def command_of(kind: TaskKind) -> Callable[..., None]:
    """Return the command of a verb, with the options of all verbs and with its own.

    Typer reads the arguments of a command from its signature, so the command is given that of
    `_compute`, in which the options that only some verbs have are described as this verb has them,
    or left out.
    """

    def command(**given: Any) -> None:
        _compute(kind, **given)

    own: dict[str, Any] = {"texts": None, "allow_negative": None, "whole": None}
    if kind.setting is not None:
        setting = kind.setting
        option = options.option(setting.metavar, setting.help, setting.flag)
        own["texts"] = Annotated[list[str] | None, option]
    if kind.allow_negative is not None:
        allow = kind.allow_negative
        own["allow_negative"] = Annotated[bool, typer.Option(allow.flag, help=allow.help)]
    if kind.whole is not None:
        whole = kind.whole
        own["whole"] = Annotated[bool, typer.Option(whole.flag, help=whole.help)]
    parameters = []
    for name, parameter in inspect.signature(_compute).parameters.items():
        if name == "kind":
            continue
        if name not in own:
            parameters.append(parameter)
        elif own[name] is not None:
            parameters.append(parameter.replace(annotation=own[name]))
    command.__name__ = kind.verb
    command.__doc__ = kind.help
    command.__annotations__ = {each.name: each.annotation for each in parameters}
    command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return command


def _compute(
    kind: TaskKind,
    study: options.StudyArgument,
    out: options.OutFolderOption = None,
    jobs: options.JobsOption = None,
    settings: options.SettingsOption = None,
    texts: list[str] | None = None,
    whole: bool = False,
    dry_run: options.DryRunOption = False,
    resume: options.ResumeOption = False,
    overwrite: options.OverwriteOption = False,
    yes: options.YesOption = False,
    as_json: options.JsonOption = False,
    quiet: options.QuietOption = False,
    no_figures: options.NoFiguresOption = False,
    allow_negative: bool = False,
    scheduler: options.SchedulerOption = None,
) -> None:
    """Run the task of a verb into a folder, and print its result.

    Args:
        kind: Kind of the task.
        study: The study file.
        out: Folder of the results.
        jobs: See `tendon.sweep`.
        settings: Settings KEY=VALUE that override the file.
        texts: Texts of the verb's own setting.
        whole: True to print all that there is to say of the result.
        dry_run: True to print the size instead.
        resume: See `tendon.sweep`.
        overwrite: See `tendon.sweep`.
        yes: True to write much without asking.
        as_json: True to print JSON.
        quiet: True to print nothing but errors.
        no_figures: True to draw nothing.
        allow_negative: True to exit with 0 although the result is negative.
        scheduler: See `tendon.sweep`.
    """
    from tendon_cli import face

    options.refuse_both("--resume", resume, "--overwrite", overwrite)
    keep_freed_memory()
    all_settings = list(settings or ())
    if kind.setting is not None and texts:
        all_settings.append(f"{kind.setting.key}={json.dumps(texts)}")
    from tendon_cli.studies.load import any_study

    loaded = any_study(study, all_settings)
    folder = out or Path("results", f"{loaded.name}{kind.suffix}")
    if dry_run:
        record, text = face.size(kind.verb, loaded, folder, jobs, not no_figures)
        print_result(record if as_json else text, unless=quiet and not as_json)
        return
    words = [
        "tendon",
        kind.verb,
        str(study),
        *(word for one in all_settings for word in ("--set", one)),
    ]
    if out is not None:
        words += ["--out", str(out)]
    with stopped_by_signals(str(folder), shlex.join([*words, "--resume"])) as stop:

        def confirm(task: "Task") -> None:
            if task.seconds > _LONG and not quiet:
                print_note(f"{loaded.name}: about {_duration(task.seconds)} of processor time")
            if task.most_bytes <= _WORTH_A_NOTE:
                return  # an estimate takes a moment
            size = face.size(kind.verb, loaded, folder, jobs)[0].get("bytes", task.most_bytes)
            _announce(folder, size, is_asked=not yes, is_told=not quiet, stop=stop)

        with progress(loaded.name, quiet=quiet or as_json) as show:
            result = face.compute(
                kind.verb,
                loaded,
                folder,
                jobs,
                not no_figures,
                resume=resume,
                overwrite=overwrite,
                scheduler=scheduler,
                progress=show.parts,
                proving=show.cells,
                confirm=confirm,
                stop=stop,
            )
    printed = result.record if as_json else result.printed(whole=whole)
    print_result(printed, unless=quiet and not as_json)
    if not quiet:
        _note_stale_page(folder, result.record)
    if result.is_negative and not allow_negative:
        raise typer.Exit(EXIT_NEGATIVE)


def _duration(seconds: float) -> str:
    """Say a duration to one digit: "40 s", "3 min", "2 h"."""
    from tendon_cli import say

    unit, size = next(
        (unit, size) for unit, size in (("h", 3600), ("min", 60), ("s", 1)) if seconds >= 1.5 * size
    )
    count = seconds / size
    return f"{say.number(count, 1) if count < 10 else say.number(round(count))} {unit}"


def _announce(
    folder: Path, size: int, *, is_asked: bool, is_told: bool, stop: threading.Event
) -> None:
    """Say how much will be written if that is much, and ask on a terminal if it is very much.

    Args:
        folder: Folder of the results.
        size: Expected size of the tables, bytes.
        is_asked: True to ask on a terminal.
        is_told: True to say it if it is not asked.
        stop: Event that a signal sets.

    Raises:
        UsageError: The answer was no.
        Stopped: A signal came before the answer.
    """
    from tendon_cli import say

    if size <= _WORTH_A_NOTE:
        return
    text = f"{folder}: about {say.byte_size(size)} will be written"
    if not is_asked or size <= _WORTH_A_QUESTION or not can_ask():
        if is_told:
            print_note(text)
        return
    if not is_confirmed(f"{text}. Go on?", stop):
        hint = (
            '[output] tables = ["designs"] writes less; --dry-run shows the size, '
            "--yes goes on without asking"
        )
        raise UsageError("nothing is written", where=str(folder), hint=hint)


def _note_stale_page(folder: Path, record: dict[str, Any]) -> None:
    """Print a note if the page in a folder shows other results than its record."""
    from tendon_cli.files import read_file
    from tendon_cli.reports.html import MARK

    with contextlib.suppress(OSError):
        page = read_file(folder / "report.html", 10**7).decode(errors="replace")
        sums = [record["study_hash"], *(entry["sha256"] for entry in record["files"])]
        is_current = all(checksum in page for checksum in sums)
        if MARK in page[:4096] and not is_current:
            print_note(
                f"{folder}/report.html shows earlier results; "
                f"`tendon report {folder}` writes a new one"
            )
