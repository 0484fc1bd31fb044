"""Measure the time for which a part of a sweep holds Python's lock.

    python -m benchmarks.lock STUDY FOLDER PARTS

That time caps how many cores one process can use. Makes parts in one thread, as a sweep does, and
takes from the processor time of each that of the calls which let go of the lock: the kernel, the
writer (but for what it calls back, and the copy that this takes), hashing, files. What NumPy lets
go of for a moment counts as held. Prints medians of a part as JSON, in seconds.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import pyarrow.parquet as pq

from tendon_cli import kernel
from tendon_cli.commands.startup import keep_freed_memory
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.sweep import Sweep
from tendon_cli.engine.task import PartMaker
from tendon_cli.studies.load import load_study
from tendon_cli.tables import digest, write

WARM = 2
"""Parts that are not counted, since they work out what all parts need."""


class Released:
    """Processor time of calls that let go of the lock, s."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def counted(self, call: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that does the same, and is counted."""

        def timed(*arguments: Any, **options: Any) -> Any:
            started = time.thread_time()
            try:
                return call(*arguments, **options)
            finally:
                self.seconds += time.thread_time() - started

        return timed

    def within(self, target: object, *names: str) -> Proxy:
        """Return an object that does the same, with some methods counted."""
        return Proxy(target, {name: self.counted(getattr(target, name)) for name in names})

    def sha256(self, made: Any) -> Proxy:
        """Return a hash that does the same, counted like its copies."""
        methods = {"update": self.counted(made.update), "copy": lambda: self.sha256(made.copy())}
        return Proxy(made, methods)


class Proxy:
    """An object with some of its methods replaced."""

    def __init__(self, target: object, methods: dict[str, Callable[..., Any]]) -> None:
        self._target = target
        self._methods = methods

    def __getattr__(self, name: str) -> Any:
        return self._methods[name] if name in self._methods else getattr(self._target, name)


def watch() -> Released:
    """Count the calls of this process from now on; it serves nothing else."""
    released = Released()
    if kernel.native() is not None:
        native = released.within(kernel.native(), "rows", "extremes", "window")
        kernel.native = lambda: native
    sha256 = lambda *data: released.sha256(hashlib.sha256(*data))  # noqa: E731
    digest.hashlib = Proxy(hashlib, {"sha256": sha256})

    class Sink(digest.StampedSink):
        def __init__(self, file: Any) -> None:
            super().__init__(released.within(file, "write"))

        def write(self, data: bytes) -> int:
            started = time.thread_time()
            bytes(memoryview(data))  # as the writer has copied them, holding the lock
            written = super().write(data)
            released.seconds -= time.thread_time() - started
            return written

    class Writer(pq.ParquetWriter):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            self.writer = released.within(self.writer, "write_table", "close")

    write.StampedSink = Sink
    write.pq.ParquetWriter = Writer
    os.fsync = released.counted(os.fsync)
    return released


def main(study: str, folder: str, parts: str) -> None:
    """Make parts, and print the medians."""
    keep_freed_memory()
    plan = Plan(load_study(Path(study)))
    for table in plan.study.output.tables:
        (Path(folder) / f"{table}.parquet").mkdir(parents=True)
    maker = PartMaker(Sweep(plan), Path(folder))
    released = watch()
    held = []
    processor = []
    for index in range(min(plan.parts, WARM + int(parts))):
        released_before = released.seconds
        started = time.thread_time()
        maker.make(index)
        seconds = time.thread_time() - started
        processor.append(seconds)
        held.append(seconds - (released.seconds - released_before))
    record = {
        "held": median(held[WARM:]),
        "processor": median(processor[WARM:]),
        "states": len(plan.part(0)) * plan.states_per_design,
    }
    print(json.dumps(record))


if __name__ == "__main__":
    main(*sys.argv[1:])
