"""The folder and the sizes of a benchmark, and the calls of tendon and its rivals."""

from __future__ import annotations

import itertools
import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks import studies
from benchmarks.machine import ROOT, cores
from benchmarks.measure import Cost, run
from benchmarks.report import Report

_SCRIPT = Path(sys.executable).with_name("tendon")
TENDON = [str(_SCRIPT)] if _SCRIPT.exists() else [sys.executable, "-m", "tendon_cli"]


@dataclass
class Bench:
    """Folder, report and sizes of one run of the benchmark."""

    scratch: Path
    report: Report
    rounds: int
    small_rounds: int
    states: tuple[int, int, int]
    """Values on the axes of `studies.states_study`."""
    designs: tuple[int, int, int, int]
    """Values on the axes of `studies.designs_study`."""
    kernel: tuple[int, int, int, int]
    """Values on the axes of `studies.designs_study`, for the kernel alone."""
    windows: tuple[int, int, int]
    """Values on the axes of `studies.windows_study`."""
    motion: tuple[int, int]
    """Values on the axes of `studies.motion_study`."""
    many_parts: tuple[int, int, int]
    """Values on the axes of `studies.states_study`, with more parts than `lock_parts`."""
    lock_parts: int
    growing: dict[str, str]
    """Studies of growing size, by their number of states."""
    threads: int = field(default_factory=cores)
    _numbers: Iterator[int] = field(default_factory=itertools.count)

    def fresh(self, name: str) -> Path:
        """Return a new path in the scratch folder."""
        stem, dot, ending = name.partition(".")
        return self.scratch / f"{stem}-{next(self._numbers)}{dot}{ending}"

    def study(self, text: str) -> Path:
        """Write a study to a file of its own, and return its path."""
        return studies.written(text, self.fresh("study.toml"))

    def sweep(
        self, study: Path, *, keep: Path | None = None, figures: bool = False
    ) -> tuple[Cost, float]:
        """Run a study as a whole process.

        Args:
            study: Study file.
            keep: Folder that stays; by default a new one, which is removed.
            figures: True to draw figures.

        Returns:
            Cost of the process, and seconds by its own record.
        """
        folder = keep or self.fresh("run")
        words = ["sweep", str(study), "--out", str(folder), "--quiet", "--jobs", str(self.threads)]
        if not figures:
            words.append("--no-figures")
        cost = run([*TENDON, *words])
        record = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        if keep is None:
            shutil.rmtree(folder)
        return cost, float(record["seconds"])

    @contextmanager
    def bare_writer(self, run_folder: Path) -> Iterator[Callable[[], dict[str, float]]]:
        """Yield a function that writes the tables of a run, which a process keeps in memory."""
        command = _python("rivals", "bare_write", run_folder, self.fresh("bare"), self.threads)
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT
        ) as process:
            into = process.stdin
            out = process.stdout
            if into is None or out is None or out.readline().strip() != "ready":
                raise RuntimeError("the tables could not be read into memory")

            def write() -> dict[str, float]:
                into.write("\n")
                into.flush()
                times: dict[str, float] = json.loads(out.readline())
                return times

            yield write
            into.close()


def record_of(module: str, *arguments: object, **environment: str) -> dict[str, Any]:
    """Run a module of the benchmark as a process, and return the JSON that it prints.

    Args:
        module: Name of the module.
        arguments: Arguments of its command line.
        environment: Variables to set in its environment.
    """
    done = subprocess.run(
        _python(module, *arguments),
        check=True,
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | environment,
    )
    record: dict[str, Any] = json.loads(done.stdout)
    return record


def designs_in(counts: tuple[int, ...]) -> int:
    """Return the number of designs of a study with so many values on its axes, and four loads."""
    return 4 * math.prod(counts)


def _python(module: str, *arguments: object) -> list[str]:
    """Return the command that runs a module of the benchmark."""
    return [sys.executable, "-m", f"benchmarks.{module}", *map(str, arguments)]
