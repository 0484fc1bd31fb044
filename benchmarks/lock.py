"""How long a part of a sweep holds Python's lock, which caps how many cores one process can use.

    python -m benchmarks.lock STUDY FOLDER PARTS

Makes parts in one thread, as a sweep does, and takes from the processor time of each that of the calls which let go of
the lock: the kernel, the writer (but for what it calls back, and the copy that this takes), hashing, files. What NumPy
lets go of for a moment counts as held. Prints medians of a part as JSON, in seconds.
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
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.sweep import Sweep
from tendon_cli.engine.task import PartMaker
from tendon_cli.startup import keep_freed_memory
from tendon_cli.studies.load import load_study
from tendon_cli.tables import digest, write

WARM = 2
"""Parts that are not counted, since they work out what all need."""


class Released:
    """The processor time of calls that let go of the lock."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def counted(self, call: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, counted."""

        def timed(*arguments: Any, **options: Any) -> Any:
            started = time.thread_time()
            try:
                return call(*arguments, **options)
            finally:
                self.seconds += time.thread_time() - started

        return timed

    def within(self, whole: object, *names: str) -> Some:
        """The same object, with some methods counted."""
        return Some(whole, {name: self.counted(getattr(whole, name)) for name in names})

    def sha256(self, made: Any) -> Some:
        """A hash that is counted, and its copies."""
        methods = {"update": self.counted(made.update), "copy": lambda: self.sha256(made.copy())}
        return Some(made, methods)


class Some:
    """An object, some of whose methods are others."""

    def __init__(self, whole: object, methods: dict[str, Callable[..., Any]]) -> None:
        self._whole, self._methods = whole, methods

    def __getattr__(self, name: str) -> Any:
        return self._methods[name] if name in self._methods else getattr(self._whole, name)


def watch() -> Released:
    """Count what this process calls from now on; it is there for nothing else."""
    released = Released()
    if kernel.kind() is not None:
        native = released.within(kernel.native(), "rows", "extremes", "window")
        kernel.native = lambda: native
    digest.hashlib = Some(hashlib, {"sha256": lambda *data: released.sha256(hashlib.sha256(*data))})

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

    write.StampedSink, write.pq.ParquetWriter = Sink, Writer
    os.fsync = released.counted(os.fsync)
    return released


def main(study: str, folder: str, parts: str) -> None:
    keep_freed_memory()
    plan = Plan(load_study(Path(study)))
    for table in plan.study.output.tables:
        (Path(folder) / f"{table}.parquet").mkdir(parents=True)
    maker, released = PartMaker(Sweep(plan), Path(folder)), watch()
    held, all_of_it = [], []
    for index in range(min(plan.parts, WARM + int(parts))):
        before, started = released.seconds, time.thread_time()
        maker.make(index)
        all_of_it.append(time.thread_time() - started)
        held.append(all_of_it[-1] - (released.seconds - before))
    states = len(plan.part(0)) * plan.states_per_design
    print(
        json.dumps(
            {"held": median(held[WARM:]), "processor": median(all_of_it[WARM:]), "states": states}
        )
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
