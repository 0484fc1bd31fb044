"""Run commands as whole processes, and ask the system what they took."""

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
    """Time of a run, s: by the clock, and of processors.

    Processor time is user and system time of a process and of those that it waited for.
    """

    seconds: float
    processor: float


@dataclass(frozen=True)
class Cost(Took):
    """Time and memory of a whole process; tendon starts no other processes."""

    memory: int
    """Peak of resident bytes."""


@dataclass(frozen=True)
class Times:
    """The runs of one side, in turn."""

    runs: tuple[Took, ...]

    @property
    def seconds(self) -> list[float]:
        """Time of each run by the clock, s."""
        return [took.seconds for took in self.runs]

    @property
    def processor(self) -> list[float]:
        """Processor time of each run, s."""
        return [took.processor for took in self.runs]


def run(command: Sequence[str]) -> Cost:
    """Run a command once; raise RuntimeError with its error output if it fails.

    Linux begins the peak of a process with that of the one which starts it, so this one imports
    nothing large.
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
    """Run some sides in turn, so that a machine that slows down does so for all.

    What is unwritten is flushed before each run, lest one side waits for the disk on behalf of
    another.

    Returns:
        Times of each side.
    """
    runs_of_sides: list[list[Took]] = [[] for _ in sides]
    for _ in range(times):
        for side, runs in zip(sides, runs_of_sides, strict=True):
            os.sync()
            runs.append(side())
    return [Times(tuple(runs)) for runs in runs_of_sides]


def in_threads(calls: Iterable[Callable[[], object]]) -> Took:
    """Make some calls, each in a thread of its own; processor time is that of the whole process."""
    workers = [threading.Thread(target=call) for call in calls]
    started = time.perf_counter()
    worked = time.process_time()
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return Took(time.perf_counter() - started, time.process_time() - worked)


def ratios(above: Sequence[float], below: Sequence[float]) -> list[float]:
    """Return the ratios of runs made next to each other, the smallest first."""
    return sorted(ours / theirs for ours, theirs in zip(above, below, strict=True))
