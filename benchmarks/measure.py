"""Running commands as whole processes and asking the system what they took."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from benchmarks.machine import ROOT


@dataclass(frozen=True)
class Took:
    """Seconds by the clock, and of processors: user and system, of a process and of those that it waited for."""

    seconds: float
    processor: float


@dataclass(frozen=True)
class Cost(Took):
    """What a whole process took, with its peak of resident bytes; tendon starts no other processes."""

    memory: int


@dataclass(frozen=True)
class Times:
    """The runs of one side, in turn."""

    runs: tuple[Took, ...]

    @property
    def seconds(self) -> list[float]:
        """By the clock."""
        return [each.seconds for each in self.runs]

    @property
    def processor(self) -> list[float]:
        """Of processors."""
        return [each.processor for each in self.runs]


def run(command: Sequence[str]) -> Cost:
    """Run a command once; raises RuntimeError with its error output where it fails.

    Linux begins the peak of a process with that of the one which starts it, so this one imports nothing large.
    """
    started = time.perf_counter()
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=ROOT
    ) as process:
        errors = process.stderr.read() if process.stderr else ""
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - started
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{' '.join(command)} failed:\n{errors}")
    memory = usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    return Cost(seconds, usage.ru_utime + usage.ru_stime, memory)


def interleaved(times: int, *sides: Callable[[], Took]) -> list[Times]:
    """What each side takes, run in turn, so that a machine that slows down does so for all.

    What is unwritten is flushed before each run, lest one side waits for the disk on behalf of another.
    """
    taken: list[list[Took]] = [[] for _ in sides]
    for _ in range(times):
        for side, found in zip(sides, taken, strict=True):
            os.sync()
            found.append(side())
    return [Times(tuple(found)) for found in taken]


def in_threads(calls: Iterable[Callable[[], object]]) -> Took:
    """What some calls take, each in a thread of its own; processor time is that of this whole process."""
    workers = [threading.Thread(target=call) for call in calls]
    started, worked = time.perf_counter(), time.process_time()
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return Took(time.perf_counter() - started, time.process_time() - worked)


def ratios(above: Sequence[float], below: Sequence[float]) -> list[float]:
    """The ratios of runs made next to each other, the smallest first."""
    return sorted(one / other for one, other in zip(above, below, strict=True))
