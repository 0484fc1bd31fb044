"""`tendon sweep` without its printing: a study into its run folder, tables first, then slack maps, then the record."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from tendon_cli.errors import InterruptError
from tendon_cli.startup import keep_freed_memory
from tendon_cli.study.study import Study
from tendon_cli.summary import estimate_text, run_text, warnings_of
from tendon_cli.sweep.part import Runner, Stopped
from tendon_cli.sweep.plan import Plan
from tendon_cli.sweep.run import Progress, available_cores, run
from tendon_cli.sweep.run_folder import RunFolder

if TYPE_CHECKING:
    from tendon_cli.paper.reproduce import Reproduction


@dataclass(frozen=True)
class Request:
    """What a sweep was asked to do."""

    study: Study
    out: Path | None
    jobs: int | None
    resume: bool = False
    overwrite: bool = False
    figures: bool = True
    lock: bool = True
    scheduler: str | None = None
    """Address of a Dask cluster that computes the parts; without one they are computed here."""

    @property
    def folder(self) -> Path:
        """The run folder."""
        return self.out if self.out is not None else Path("results") / self.study.name

    @property
    def workers(self) -> int:
        """How many parts are computed at once."""
        return self.jobs or available_cores()


@dataclass(frozen=True)
class Done:
    """A finished run."""

    record: dict[str, Any]
    folder: Path
    up_to_date: bool
    note: str | None = None
    """Why there is no slack map, where one was asked for."""

    def text(self) -> str:
        """Its summary."""
        return run_text(self.record, str(self.folder), up_to_date=self.up_to_date, note=self.note)


@dataclass
class Stop:
    """Set by the first signal that asks the run to end; `number` is the signal's."""

    event: threading.Event = field(default_factory=threading.Event)
    number: int = 0


@contextlib.contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """End cleanly on SIGINT, SIGTERM and SIGHUP: no part is begun any more; a second SIGINT ends at once."""
    stop = Stop()

    def ask(number: int, _frame: FrameType | None) -> None:
        if stop.number and number == signal.SIGINT:
            os._exit(128 + number)
        stop.number = stop.number or number
        stop.event.set()

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    signals = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    heard = [number for number in signals if signal.getsignal(number) is not signal.SIG_IGN]  # nohup stays nohup
    before = [signal.signal(number, ask) for number in heard]
    try:
        yield stop
    finally:
        for number, handler in zip(heard, before, strict=True):
            signal.signal(number, handler)


def dry_run(request: Request, *, as_json: bool) -> str:
    """The size and cost of a sweep as text; nothing is written."""
    from tendon_cli.sweep.estimate import estimate

    keep_freed_memory()
    folder = RunFolder(request.folder, Plan(request.study))
    found = estimate(folder.plan, request.workers, figures=request.figures)
    free = folder.free_bytes
    if as_json:
        return json.dumps({"name": request.study.name, **found.record(), "free_bytes": free}, indent=2)
    return estimate_text(found, request.study.name, free)


def sweep(request: Request, stop: Stop, progress: Progress) -> Done:
    """Run a study; raises TendonError, with exit code 130, 143 or 129 where a signal stopped it."""
    keep_freed_memory()
    folder = RunFolder(request.folder, Plan(request.study))
    folder.check_space()
    with _runner(request) as runner, folder.locked(use_lock=request.lock):
        try:
            outcome = run(
                folder,
                jobs=request.workers,
                stop=stop.event,
                progress=progress,
                resume=request.resume,
                overwrite=request.overwrite,
                runner=runner,
            )
        except Stopped:
            raise InterruptError(stop.number, where=str(request.folder)) from None
        record = outcome.record
        if outcome.up_to_date:
            lost = any(not (folder.path / name).exists() for name in record["figures"])
            if request.figures and (lost or request.study.figure):  # declared figures may have changed, too
                record["figures"], _ = _figures(request, record)
                folder.write_record(record)
            return Done(record, request.folder, up_to_date=True)
        record["warnings"] = _warnings(request.study, record)
        record["figures"], note = _figures(request, record) if request.figures else ([], None)
        folder.write_record(record)
    return Done(record, request.folder, up_to_date=False, note=note)


def paper(out: Path, jobs: int | None, stop: Stop, progress: Progress) -> Reproduction:
    """Reproduce the paper into a folder; raises TendonError, as `sweep` does where a signal stopped it."""
    from tendon_cli.paper.reproduce import reproduce

    try:
        return reproduce(out, jobs=jobs or available_cores(), progress=progress, stop=stop.event)
    except Stopped:
        raise InterruptError(stop.number, where=str(out)) from None


@contextlib.contextmanager
def _runner(request: Request) -> Iterator[Runner | None]:
    """What computes the parts, where that is not this process."""
    if request.scheduler is None:
        yield None
        return
    from tendon_cli.sweep.cluster import connected

    with connected(request.scheduler, request.jobs) as cluster:
        yield cluster.results


def _warnings(study: Study, record: dict[str, Any]) -> list[str]:
    models = [study.model, *(getattr(case, "model", None) for case in study.cases)]
    bilateral = any(getattr(model, "slack", None) == "bilateral" for model in models)
    return warnings_of(record, bilateral=bilateral, sources=study.sources)


def _figures(request: Request, record: dict[str, Any]) -> tuple[list[str], str | None]:
    """Slack maps where the study has axes for one, else why there are none; and the figures that it declares."""
    files: list[Path] = []
    reason = None
    if "designs" in request.study.output.tables and record["designs"] > 1:
        from tendon_cli.figures.slack_map import draw_slack_maps
        from tendon_cli.tables.read import open_table

        maps = draw_slack_maps(open_table(request.folder / "designs.parquet"), request.folder)
        files += maps.files
        reason = None if request.study.figure else maps.reason
    if request.study.figure:
        from tendon_cli.figures.declared import draw_declared

        files += draw_declared(request.study, request.folder)
    return [file.name for file in files], reason
