"""Where and at which sizes it is measured, and how tendon and its rivals are called."""

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
    """Where it is measured, what goes into the report, and the sizes."""

    scratch: Path
    report: Report
    rounds: int
    small_rounds: int
    states: tuple[int, int, int]
    """Values on the axes of `studies.states_study`."""
    designs: tuple[int, int, int, int]
    """Values on the axes of `studies.designs_study`."""
    kernel: tuple[int, int, int, int]
    windows: tuple[int, int, int]
    many_parts: tuple[int, int, int]
    """Values on the axes of `studies.states_study`, with more parts than `lock_parts`."""
    lock_parts: int
    growing: dict[str, str]
    """Studies of growing size, by their number of states."""
    threads: int = field(default_factory=cores)
    _numbers: Iterator[int] = field(default_factory=itertools.count)

    def fresh(self, name: str) -> Path:
        """A path in the scratch folder where nothing stands yet."""
        stem, dot, ending = name.partition(".")
        return self.scratch / f"{stem}-{next(self._numbers)}{dot}{ending}"

    def study(self, text: str) -> Path:
        """A study as a file of its own."""
        return studies.written(text, self.fresh("study.toml"))

    def sweep(
        self, study: Path, *, keep: Path | None = None, figures: bool = False
    ) -> tuple[Cost, float]:
        """Run a study into a fresh folder, as a whole process; its cost, and the seconds that its record says."""
        folder = keep or self.fresh("run")
        words = ["sweep", str(study), "--out", str(folder), "--quiet", "--jobs", str(self.threads)]
        words += [] if figures else ["--no-figures"]
        cost = run([*TENDON, *words])
        inside = float(json.loads((folder / "run.json").read_text(encoding="utf-8"))["seconds"])
        if keep is None:
            shutil.rmtree(folder)
        return cost, inside

    @contextmanager
    def bare_writer(self, run_folder: Path) -> Iterator[Callable[[], dict[str, float]]]:
        """A process that keeps the tables of a run in memory and writes them whenever asked."""
        command = _python("rivals", "bare_write", run_folder, self.fresh("bare"), self.threads)
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT
        ) as process:
            into, out = process.stdin, process.stdout
            if into is None or out is None or out.readline().strip() != "ready":
                raise RuntimeError("the tables could not be read into memory")

            def write() -> dict[str, float]:
                into.write("\n")
                into.flush()
                taken: dict[str, float] = json.loads(out.readline())
                return taken

            yield write
            into.close()


def said_by(module: str, *arguments: object, **environment: str) -> dict[str, Any]:
    """What a module of the benchmark prints as JSON when it is run as a process, with more in its environment."""
    command, around = _python(module, *arguments), os.environ | environment
    ended = subprocess.run(
        command, check=True, cwd=ROOT, stdout=subprocess.PIPE, text=True, env=around
    )
    said: dict[str, Any] = json.loads(ended.stdout)
    return said


def designs_in(counts: tuple[int, ...]) -> int:
    """Designs of a study with so many values on its axes, and four loads."""
    return 4 * math.prod(counts)


def _python(module: str, *arguments: object) -> list[str]:
    return [sys.executable, "-m", f"benchmarks.{module}", *map(str, arguments)]
