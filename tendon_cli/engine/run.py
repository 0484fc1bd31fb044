"""Carrying a task out: into a folder that is locked, written, recorded and verified, or in memory."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

from tendon_cli.engine.folder import RunFolder
from tendon_cli.engine.journal import Journal
from tendon_cli.engine.records import lost, read_record, write_record
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

Draw = Callable[[Study, Path, Path, dict[str, Any]], tuple[list[str], list[str], str | None]]
"""Draws figures of a run folder into another: their names, what could not be drawn, why there is no map."""
Progress = Callable[[int, int], None]
"""Called with the number of finished parts and of all parts."""
Kind = TypeVar("Kind", bound=Result)


@dataclass(frozen=True)
class How:
    """How a task is carried out; everything has its default."""

    jobs: int | None = None
    """Parts made at once; None for one for each core."""
    resume: bool = False
    """Finish an unfinished run, and make damaged files of a finished one anew."""
    overwrite: bool = False
    """Replace the run that stands in the folder."""
    lock: bool = True
    scheduler: str | None = None
    """The address of a Dask cluster whose workers make the parts."""
    draw: Draw | None = None
    progress: Progress = lambda _done, _all: None
    stop: threading.Event | None = None
    """Ends the run with Stopped; without it Ctrl-C does, which is then raised as KeyboardInterrupt."""


def run_task(
    task: type[Task],
    kind: type[Kind],
    study: Study,
    out: Path | None = None,
    how: How | None = None,
) -> Kind:
    """Carry a task out into the folder `out`, or without one in memory; returns when all stands and is recorded.

    Raises TendonError.
    """
    how = how or How()
    with ended_by_keyboard(how.stop) as ended:
        if ended.is_set():
            raise Stopped
        if out is None:
            if how.scheduler is not None:
                raise UsageError("a cluster writes into a run folder", hint="name one")
            return _in_memory(task.of(study, ended), kind, how)
        folder = RunFolder(out, task.of(study, ended))
        if how.lock:
            check_unlocked(out)
        folder.check(
            resume=how.resume, overwrite=how.overwrite
        )  # before the lock: a refused one stays as it was
        folder.check_space()
        with _runner(how, folder.task.parts) as runner, locked(out, use_lock=how.lock):
            record, stands = compute_parts(folder, how, runner)
            note = None
            if not stands or (how.draw is not None and _wants_figures(folder, record)):
                note = _with_figures(folder, record, how.draw, up_to_date=stands)
                folder.finish(record)
            return kind(record, out, up_to_date=stands, note=note)


def _in_memory(task: Task, kind: type[Kind], how: How) -> Kind:
    task.check_memory()
    maker = InMemory(task, Path())
    with _runner(how, task.parts) as runner:
        record = _recorded(maker, Journal(Path(), in_memory=True), runner, how.progress)
    return kind({**record, "files": []}, tables=maker.tables())


@contextmanager
def _runner(how: How, parts: int) -> Iterator[Runner]:
    """What makes parts, here or on a cluster; raises UsageError, WorkersLostError."""
    if how.scheduler is None:
        yield in_threads(min(how.jobs or available_cores(), parts))
        return
    from tendon_cli.engine.cluster.flight import (
        connected,
    )  # only who has a cluster pays for its import

    with connected(how.scheduler, how.jobs) as runner:
        yield runner


def compute_parts(folder: RunFolder, how: How, runner: Runner) -> tuple[dict[str, Any], bool]:
    """The record of a task whose tables stand in its locked folder, to be written there, and whether it stands already.

    Raises FolderError if something else stands there, SizeError, OutputError, WorkersLostError for parts that failed,
    Stopped; whatever was finished until then is kept and can be resumed.
    """
    folder.check(resume=how.resume, overwrite=how.overwrite)
    replaces = how.overwrite and folder.clear()
    record, maker = read_record(folder.path), PartMaker(folder.task, folder.path)
    maker.tidy()
    if record is not None:
        return _repaired(folder, record, maker, runner if how.resume else None)
    journal = Journal.read(folder.path)
    journal.parts = {} if replaces else folder.intact(journal)
    journal.figures = () if replaces else journal.figures
    journal.start(folder.header())
    folder.prepare()
    return _recorded(maker, journal, runner, how.progress), False


def _recorded(
    maker: PartMaker, journal: Journal, runner: Runner, progress: Progress
) -> dict[str, Any]:
    """The record of a task whose missing parts are made, and then what only the whole gives."""
    started, task, study, resumed = (
        time.monotonic(),
        maker.task,
        maker.task.study,
        len(journal.parts),
    )

    def take(result: PartResult) -> None:
        journal.add(result)
        progress(len(journal.parts), task.parts)

    progress(resumed, task.parts)
    make_parts(
        maker, runner, (index for index in range(task.parts) if index not in journal.parts), take
    )
    parts = [journal.parts[index] for index in range(task.parts)]
    record = {
        "name": study.name,
        "title": study.title,
        **{key: value for key, value in task.identity.items() if key != "study"},
        **task.results([part.note for part in parts]),
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
    files |= _written_last(maker, record, journal.announce_last)
    entries = [{"path": name, **asdict(file)} for name, file in files.items()]
    return record | {"files": entries, "seconds": round(time.monotonic() - started, 3)}


def _written_last(
    maker: PartMaker,
    record: Mapping[str, Any],
    announce: Callable[[str, WrittenFile], None] = lambda _name, _file: None,
    only: Collection[str] | None = None,
) -> dict[str, WrittenFile]:
    """Write the files that follow from the whole record, or some of these; each is in the journal beforehand."""
    written = {}
    for file in maker.task.last(record, maker.read):
        if only is None or file[0] in only:
            maker.task.go_on()
            written[file[0]] = maker.write(file, announce)
    return written


def _repaired(
    folder: RunFolder, record: dict[str, Any], maker: PartMaker, runner: Runner | None
) -> tuple[dict[str, Any], bool]:
    """A finished run whose damaged files are made anew, if they may be; the same parts give the same bytes."""
    entries = {entry["path"]: entry for entry in record["files"]}
    damaged = list(lost(folder.path, record))
    if not damaged:
        return record, True
    if runner is None:
        raise FolderError(
            f"{len(damaged)} of {len(entries)} files are missing or damaged, the first is {damaged[0]}",
            where=str(folder.path),
            hint="--resume computes just these anew",
        )
    anew = set(damaged)

    def take(result: PartResult) -> None:
        for name, file in result.files.items():
            anew.add(name)
            entries[name].update(asdict(file))

    folder.prepare()
    missing = [
        index
        for index in range(folder.task.parts)
        if not anew.isdisjoint(folder.task.files(index).values())
    ]
    make_parts(maker, runner, missing, take)
    for name, file in _written_last(maker, record, only=anew).items():
        entries[name].update(asdict(file))
    return {**record, "repaired": damaged}, False


# --- Figures ---------------------------------------------------------------------------------------------------------


def _with_figures(
    folder: RunFolder, record: dict[str, Any], draw: Draw | None, *, up_to_date: bool
) -> str | None:
    """Draw next to the folder's files, then put the figures in place, their names first; returns why there is no map.

    So whoever ends this process at any moment, each figure in the folder is one that a record or a journal lists.
    """
    journal = Journal.read(folder.path)
    before = list(dict.fromkeys([*record.get("figures", ()), *journal.figures]))
    started, faults, note = time.monotonic(), list[str](), None
    names = list(record.get("figures", ()))
    try:
        with folder.figures() if draw is not None else nullcontext(folder.path) as place:
            if draw is not None:
                names, faults, note = draw(folder.task.study, folder.path, place, record)
            if up_to_date:
                write_record(
                    folder.path, {**record, "figures": list(dict.fromkeys([*before, *names]))}
                )
            if draw is not None or not record.get("figures"):
                faults += folder.place_figures(
                    place, names, before, None if up_to_date else journal
                )
    except (OSError, OutputError) as error:
        names, faults = [], [*faults, f"the figures cannot be drawn: {error}"]
    record["figures"], record["warnings"] = names, [*folder.task.warnings(record), *faults]
    record["figure_seconds"] = round(time.monotonic() - started, 3) if draw is not None else 0.0
    return note


def _wants_figures(folder: RunFolder, record: dict[str, Any]) -> bool:
    """Whether figures of a run that stands are missing; those that the study declares may have changed, too."""
    drawn = record["figures"]
    declared = folder.task.verb == "sweep" and bool(folder.task.study.figure)
    return declared or not drawn or any(not (folder.path / name).exists() for name in drawn)
