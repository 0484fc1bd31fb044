"""Run a task in memory, or into a folder that is locked, recorded and verified."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from tendon_cli.engine.folder import FolderContents, RunFolder, look
from tendon_cli.engine.records import damaged_files
from tendon_cli.engine.results import Result
from tendon_cli.engine.task import InMemory, PartMaker, PartResult, Task
from tendon_cli.engine.threads import (
    Runner,
    available_cores,
    ended_by_keyboard,
    in_threads,
    make_parts,
)
from tendon_cli.errors import FolderError, OutputError, Stopped, UsageError
from tendon_cli.files import check_unlocked, locked
from tendon_cli.studies.study import Study
from tendon_cli.tables.schema import versions
from tendon_cli.tables.write import WrittenFile
from tendon_cli.version import RESULTS_VERSION

Draw: TypeAlias = Callable[
    [Study, Path, Path, dict[str, Any]], tuple[list[str], list[str], str | None]
]
"""Draws the figures of a run: takes the study, the run folder, a folder for figures and the record.

Returns the names of the figures, warnings on those that could not be drawn, and why there is no
slack map.
"""
Progress: TypeAlias = Callable[[int, int], None]
"""Called with the number of finished parts and of all parts."""
_NOT_LOCKED = (
    "the folder is on a file system without locks: make sure that no other run writes there"
)
ResultType = TypeVar("ResultType", bound=Result)


@dataclass(frozen=True)
class RunOptions:
    """Options for running a task."""

    jobs: int | None = None
    """Parts made at once; None for as many as there are cores."""
    resume: bool = False
    """True to finish an unfinished run, or to make damaged files of a finished one again."""
    overwrite: bool = False
    """True to replace the run in the folder."""
    scheduler: str | None = None
    """Address of a Dask cluster whose workers make the parts."""
    draw: Draw | None = None
    """Draws the figures of the run; None for no figures."""
    progress: Progress = lambda _done, _all: None
    """Called after each part."""
    proving: Progress = lambda _cells, _most: None
    """Called with the numbers of cells examined and of most cells while a window is proved."""
    confirm: Callable[[Task], None] = lambda _task: None
    """Called once before a run is begun, when nothing is written yet; may raise."""
    stop: threading.Event | None = None
    """Event that ends the run with Stopped; if None, Ctrl-C ends it with KeyboardInterrupt."""


def run_task(
    task: type[Task],
    kind: type[ResultType],
    study: Study,
    out: Path | None = None,
    how: RunOptions | None = None,
) -> ResultType:
    """Run a task and return its result, when everything is written and recorded.

    Args:
        task: Type of the task.
        kind: Type of the result.
        study: The study.
        out: Folder of the run; None for a result in memory.
        how: Options.

    Raises:
        TendonError: The task cannot be run, or its result cannot be written.
    """
    how = how or RunOptions()
    with ended_by_keyboard(how.stop) as ended:
        if ended.is_set():
            raise Stopped
        if out is None:
            if how.scheduler is not None:
                raise UsageError("a cluster needs a folder to write to", hint="name one")
            return _in_memory(task.of(study, ended), kind, how)
        folder = RunFolder(out, task.of(study, ended))
        check_unlocked(out)
        # Looked at before it is locked: a folder that is refused stays as it was.
        contents = look(out)
        folder.check(contents, resume=how.resume, overwrite=how.overwrite)
        standing = _standing_record(folder, contents, how)
        if standing is not None:
            return kind(standing, out, up_to_date=True, validated=folder.task.study)
        folder.check_space(contents)
        if contents.run is None or how.overwrite:
            how.confirm(folder.task)
        with _runner(how, folder.task.parts) as runner, locked(out) as is_locked:
            record, up_to_date = compute_parts(folder, how, runner)
            note = None
            if not up_to_date or (how.draw is not None and _wants_figures(folder, record)):
                note = _with_figures(folder, record, how.draw)
                folder.finish(record)
            if not is_locked:
                record = {**record, "warnings": [*record["warnings"], _NOT_LOCKED]}
            return kind(record, out, up_to_date=up_to_date, note=note, validated=folder.task.study)


def _standing_record(
    folder: RunFolder, contents: FolderContents, how: RunOptions
) -> dict[str, Any] | None:
    """Return the record of a finished run to which nothing is to be added; else None.

    Nothing is written for it, so that the folder may be one in which nothing can be.

    Args:
        folder: The folder, which was checked.
        contents: Contents of the folder.
        how: Options.
    """
    record = contents.record
    if record is None or how.overwrite:
        return None
    wants_figures = how.draw is not None and _wants_figures(folder, record)
    is_writable = os.access(folder.path, os.W_OK)
    has_unfinished = not folder.task.unfinished.isdisjoint(contents.of_run)
    is_asked_to_write = (wants_figures or has_unfinished) and is_writable
    if is_asked_to_write or any(damaged_files(folder.path, record)):
        return None
    if wants_figures:
        warning = "figures are not drawn: nothing can be written into the folder"
        return {**record, "warnings": [*record["warnings"], warning]}
    return record


def _in_memory(task: Task, kind: type[ResultType], how: RunOptions) -> ResultType:
    """Run a task without a folder; return its result with the tables in memory."""
    task.check_memory()
    maker = InMemory(task, Path())
    with _runner(how, task.parts) as runner:
        record = _recorded(maker, {}, runner, how)
    return kind({**record, "files": []}, tables=maker.tables(), validated=task.study)


@contextmanager
def _runner(how: RunOptions, parts: int) -> Iterator[Runner]:
    """Yield the runner that makes parts, here or on a cluster.

    Raises:
        UsageError: The address of the cluster is malformed, or a package is missing.
        WorkersLostError: The cluster cannot be reached, has no workers, or one is unfit.
    """
    if how.scheduler is None:
        yield in_threads(min(how.jobs or available_cores(), parts))
        return
    # Only a run on a cluster pays for this import.
    from tendon_cli.engine.cluster.flight import connected

    with connected(how.scheduler, how.jobs) as runner:
        yield runner


def compute_parts(
    folder: RunFolder, how: RunOptions, runner: Runner
) -> tuple[dict[str, Any], bool]:
    """Make the missing parts of a task in its locked folder.

    Whatever was finished before an exception is kept and can be resumed.

    Returns:
        The record, and True if the folder holds it already; else the caller must write it there.

    Raises:
        FolderError: The folder holds something else.
        SizeError: The study is too large.
        OutputError: A file could not be written.
        WorkersLostError: Parts failed.
        Stopped: The run was stopped.
    """
    contents = look(folder.path)
    folder.check(contents, resume=how.resume, overwrite=how.overwrite)
    maker = PartMaker(folder.task, folder.path)
    maker.tidy()
    done: dict[int, PartResult] = {}
    if how.overwrite:
        folder.clear(contents)
    elif contents.record is not None:
        folder.drop_unfinished()
        return _repaired(folder, contents.record, maker, runner if how.resume else None)
    else:
        done = folder.standing(contents)
    folder.prepare()
    return _recorded(maker, done, runner, how), False


def _recorded(
    maker: PartMaker, done: dict[int, PartResult], runner: Runner, how: RunOptions
) -> dict[str, Any]:
    """Make the missing parts of a task, then the files that need all parts; return the record.

    Args:
        maker: Makes a part.
        done: Parts that are made already, by their indices; the others are added.
        runner: Has the maker make parts.
        how: Options, of which `progress` and `proving` are called.
    """
    started = time.monotonic()
    task = maker.task
    study = task.study
    resumed = len(done)

    def take(result: PartResult) -> None:
        done[result.index] = result
        how.progress(len(done), task.parts)

    how.progress(resumed, task.parts)
    missing = [index for index in range(task.parts) if index not in done]
    make_parts(maker, runner, missing, take)
    parts = [done[index] for index in range(task.parts)]
    record = {
        "name": study.name,
        "title": study.title,
        "verb": task.kind.verb,
        "study_hash": study.hash,
        "results_version": RESULTS_VERSION,
        **{key: value for key, value in study.record.items() if key != "study"},
        **task.results([part.note for part in parts], maker.finished, how.proving),
        "parts": task.parts,
        "resumed_parts": resumed,
        "seconds": 0.0,
        "versions": versions(),
        "study": study.document(),
        "figures": [],
        "figure_seconds": 0.0,
    }
    record["warnings"] = task.warnings(record)
    files = {name: file for part in parts for name, file in part.files.items()}
    files |= _written_last(maker, record)
    kept = [name for name in task.names if name not in task.unfinished]
    entries = [{"path": name, **asdict(files[name])} for name in kept]
    return record | {"files": entries, "seconds": round(time.monotonic() - started, 3)}


def _written_last(
    maker: PartMaker, record: Mapping[str, Any], only: Collection[str] | None = None
) -> dict[str, WrittenFile]:
    """Write the files that follow from the whole record; return their sizes and checksums by name.

    Args:
        maker: Writes a file.
        record: The record.
        only: Names of the files to write; None for all.
    """
    written = {}
    for file in maker.task.final_files(record, maker.finished):
        name = file[0]
        if only is None or name in only:
            maker.task.check_stopped()
            written[name] = maker.write(file)
    return written


def _repaired(
    folder: RunFolder, record: dict[str, Any], maker: PartMaker, runner: Runner | None
) -> tuple[dict[str, Any], bool]:
    """Make damaged files of a finished run again; the same parts give the same bytes.

    Args:
        folder: The folder.
        record: The record in the folder.
        maker: Makes a part.
        runner: Has the maker make parts; None if damaged files are to be refused.

    Returns:
        The record, and True if it is in the folder already.
    """
    entries = {entry["path"]: entry for entry in record["files"]}
    damaged = list(damaged_files(folder.path, record))
    if not damaged:
        return record, True
    if runner is None:
        raise FolderError(
            f"{len(damaged)} of {len(entries)} files are missing or damaged, "
            f"the first is {damaged[0]}",
            where=str(folder.path),
            hint="--resume computes just these files again",
        )

    def take(result: PartResult) -> None:
        for name in result.files.keys() & entries.keys():
            entries[name].update(asdict(result.files[name]))

    folder.prepare()
    missing = [
        index
        for index in range(folder.task.parts)
        if not folder.task.needed_by(index).isdisjoint(damaged)
    ]
    make_parts(maker, runner, missing, take)
    for name, file in _written_last(maker, record, only=damaged).items():
        entries[name].update(asdict(file))
    return {**record, "repaired": damaged}, False


# --- Figures --------------------------------------------------------------------------------------


def _with_figures(folder: RunFolder, record: dict[str, Any], draw: Draw | None) -> str | None:
    """Draw the figures into a folder of their own, then put them in place.

    Each says which study it is of, whenever the process ends.

    Args:
        folder: The folder.
        record: The record, whose figures and warnings are set.
        draw: Draws the figures; None for no new ones.

    Returns:
        Why there is no slack map; None if there is one, or nobody asked for it.
    """
    before = list(record["figures"])
    started = time.monotonic()
    names = before
    faults: list[str] = []
    note = None
    try:
        drawing = folder.figures() if draw is not None else nullcontext(folder.path)
        with drawing as drawn:
            if draw is not None:
                names, faults, note = draw(folder.task.study, folder.path, drawn, record)
                faults += folder.place_figures(drawn, names, before)
    except (OSError, OutputError) as error:
        names = []
        faults = [*faults, f"the figures cannot be drawn: {error}"]
    record["figures"] = names
    record["warnings"] = [*folder.task.warnings(record), *faults]
    record["figure_seconds"] = round(time.monotonic() - started, 3) if draw is not None else 0.0
    return note


def _wants_figures(folder: RunFolder, record: dict[str, Any]) -> bool:
    """Return True if figures of a finished run are missing, or the study declares figures.

    Declared figures are drawn again, since they may have changed: they do not count for the hash
    of the study.
    """
    drawn = record["figures"]
    declared = bool(folder.task.kind.check_figures and folder.task.study.figure)
    return declared or not drawn or any(not (folder.path / name).exists() for name in drawn)
