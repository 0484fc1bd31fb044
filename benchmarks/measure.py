"""Running a command as a whole process and asking the system what it took."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Cost:
    """What a process took: wall-clock seconds and its peak resident memory in bytes."""

    seconds: float
    memory: int


def run(command: Sequence[str], *, environment: dict[str, str] | None = None) -> Cost:
    """Run a command once; raises RuntimeError with its error output where it fails."""
    started = time.perf_counter()
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env={**os.environ, **(environment or {})}
    )
    errors = process.stderr.read() if process.stderr else ""
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{' '.join(command)} failed:\n{errors}")
    unit = 1 if sys.platform == "darwin" else 1024
    return Cost(seconds, usage.ru_maxrss * unit)


def median(command: Sequence[str], times: int = 3) -> Cost:
    """The median of several runs, after one that is not counted."""
    run(command)
    costs = [run(command) for _ in range(times)]
    return Cost(statistics.median(cost.seconds for cost in costs), max(cost.memory for cost in costs))
