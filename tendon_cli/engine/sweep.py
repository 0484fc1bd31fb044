"""The verb: a study into its run, in a folder that is locked, written, recorded and verified, or in memory."""

from __future__ import annotations

import contextlib
import io
import shutil
import signal
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import FrameType
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from tendon_cli.engine.cluster import cluster_at
from tendon_cli.engine.ownership import check_folder
from tendon_cli.engine.part import PartMaker, PartResult, WrittenPart
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.record import Journal, write_record
from tendon_cli.engine.results import Run, record_of, warnings_of
from tendon_cli.engine.run import Progress, available_cores, compute, in_threads, run
from tendon_cli.engine.run_folder import FIGURES, RunFolder
from tendon_cli.errors import OutputError, Stopped, UsageError
from tendon_cli.studies.study import Study

Draw = Callable[[Study, Path, Path, dict[str, Any]], tuple[list[str], list[str], str | None]]
"""Draws figures of a run folder into another: their names, what could not be drawn, why there is no map."""


def sweep(
    study: Study,
    out: Path | None = None,
    *,
    jobs: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    lock: bool = True,
    scheduler: str | None = None,
    draw: Draw | None = None,
    progress: Progress = lambda _done, _all: None,
    stop: threading.Event | None = None,
) -> Run:
    """Run a study into the folder `out`, or without one in memory; returns when every table stands and is recorded.

    Ctrl-C ends it cleanly, and is then raised as KeyboardInterrupt; where `stop` is given, that event ends it instead,
    and Stopped is raised. Raises TendonError otherwise.
    """
    plan = Plan(study)
    with _ended_by_keyboard(stop) as ended:
        if ended.is_set():
            raise Stopped
        if out is None:
            if scheduler is not None:
                raise UsageError("a cluster writes into a run folder", hint="name one")
            return _in_memory(plan, jobs or available_cores(), ended, progress)
        folder = RunFolder(out, plan)
        if lock:
            folder.check_free()
        check_folder(folder, resume=resume, overwrite=overwrite)  # before the lock: a refused folder stays as it was
        folder.check_space()
        with cluster_at(scheduler, jobs) as cluster, folder.locked(use_lock=lock):
            found = run(
                folder, jobs=jobs or available_cores(), stop=ended, progress=progress, resume=resume,
                overwrite=overwrite, runner=None if cluster is None else cluster.results,
            )  # fmt: skip
            return _finished(folder, found, draw)


def _finished(folder: RunFolder, found: Run, draw: Draw | None) -> Run:
    """The run with its figures, where they are missing; it is recorded last of all."""
    record, stands = found.record, found.up_to_date
    if stands and not (draw is not None and _wants_figures(folder.plan.study, folder.path, record)):
        return found
    note = _with_figures(folder, record, draw, up_to_date=stands)
    folder.finish(record)
    return replace(found, note=note)


def _with_figures(folder: RunFolder, record: dict[str, Any], draw: Draw | None, *, up_to_date: bool) -> str | None:
    """Draw beside the folder's files, then put the figures in place, their names first; returns why there is no map.

    So whoever ends this process at any moment, each figure in the folder is one that a record or a journal lists.
    """
    journal = Journal.read(folder.path)
    before = list(dict.fromkeys([*record.get("figures", ()), *journal.figures]))
    started, study, faults, note = time.monotonic(), folder.plan.study, list[str](), None
    names = list(record.get("figures", ()))
    place = folder.path / FIGURES
    shutil.rmtree(place, ignore_errors=True)
    try:
        if draw is not None:
            place.mkdir()
            names, faults, note = draw(study, folder.path, place, record)
        if up_to_date:
            write_record(folder.path, {**record, "figures": list(dict.fromkeys([*before, *names]))})
        if draw is not None or not record.get("figures"):
            faults += folder.place_figures(names, before, None if up_to_date else journal)
    except (OSError, OutputError) as error:
        names, faults = [], [*faults, f"the figures cannot be drawn: {error}"]
    finally:
        shutil.rmtree(place, ignore_errors=True)
    record["figures"], record["warnings"] = names, [*warnings_of(study, record), *faults]
    record["figure_seconds"] = round(time.monotonic() - started, 3) if draw is not None else 0.0
    return note


def _wants_figures(study: Study, out: Path, record: dict[str, Any]) -> bool:
    """Whether figures of a run that stands are missing; those that the study declares may have changed, too."""
    drawn = record["figures"]
    return bool(study.figure) or not drawn or any(not (out / name).exists() for name in drawn)


def _in_memory(plan: Plan, jobs: int, stop: threading.Event, progress: Progress) -> Run:
    """Every part computed into memory."""
    started = time.monotonic()
    maker = _InMemory(plan, Path(), stop)
    parts: list[PartResult] = []

    def take(result: PartResult) -> None:
        parts.append(result)
        progress(len(parts), plan.parts)

    compute(maker, in_threads(min(jobs, plan.parts)), range(plan.parts), take)
    record = record_of(RunFolder(Path(), plan), parts, 0, time.monotonic() - started)
    record |= {"files": [], "warnings": warnings_of(plan.study, record)}
    return Run(record, None, tables=maker.tables_read())


@dataclass(frozen=True)
class _InMemory(PartMaker):
    """Makes parts whose files never reach the disk."""

    files: dict[str, dict[int, bytes]] = field(default_factory=lambda: defaultdict(dict), kw_only=True)
    """Of each table, by the number of the part."""

    def compute(self, index: int) -> WrittenPart:
        designs = self.plan.part(index)
        kept = {str(table): io.BytesIO() for table in self.plan.study.output.tables}
        tables = {table: self.groups(table, index, file, len(designs)) for table, file in kept.items()}
        totals, suits = self.fill(tables, designs)
        for table, groups in tables.items():
            groups.close()
            self.files[table][index] = kept[table].getvalue()
        return WrittenPart(index, totals, suits, {}, contextlib.ExitStack())

    def tables_read(self) -> dict[str, pa.Table]:
        """The tables, each of all its parts; the files are let go of."""
        return {
            table: pa.concat_tables(pq.read_table(pa.BufferReader(files.pop(index))) for index in sorted(files))
            for table, files in self.files.items()
        }


@contextlib.contextmanager
def _ended_by_keyboard(stop: threading.Event | None) -> Iterator[threading.Event]:
    """The event that ends a run: the caller's own, or one that Ctrl-C sets; a second Ctrl-C does not wait."""
    heard = stop is None and threading.current_thread() is threading.main_thread()
    if stop is not None or not heard or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield stop or threading.Event()
        return
    ended = threading.Event()

    def ask(_number: int, _frame: FrameType | None) -> None:
        if ended.is_set():
            raise KeyboardInterrupt
        ended.set()

    before = signal.signal(signal.SIGINT, ask)
    try:
        yield ended
    except Stopped:
        raise KeyboardInterrupt from None
    finally:
        signal.signal(signal.SIGINT, before)
