"""Measure the kernel of tendon and the loop in C, over the same states and in as many threads.

    python -m benchmarks.kernel STUDY FOLDER THREADS TIMES

For a study without an axis of pretension both compute windows. Runs in one process, in turn, and
prints seconds as JSON. tendon computes parts as a sweep does, into rows that are discarded.
"""

from __future__ import annotations

import json
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path

from benchmarks.fused import OPTIONS, Fused
from benchmarks.measure import Took, in_threads, interleaved
from tendon_cli.commands.startup import keep_freed_memory
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.sweep import Sweep
from tendon_cli.studies.load import load_study
from tendon_cli.tables.write import Filler


class Discarded:
    """Table whose rows are forgotten."""

    def fill(self, count: int, write: Filler) -> None:
        """Have rows worked out, and forget them."""
        write({}, range(count))


def tendon(task: Sweep, threads: int) -> Took:
    """Compute all parts of a plan in some threads."""
    work = _designs if "tendon.pretension" in task.plan.study.axes else _windows
    parts = iter(range(task.plan.parts))
    lock = threading.Lock()
    return in_threads([lambda: _parts(work, task, parts, lock)] * threads)


def _parts(
    work: Callable[[Sweep, range], None], task: Sweep, parts: Iterator[int], lock: threading.Lock
) -> None:
    """Compute one part after the other until none is left."""
    while True:
        with lock:
            index = next(parts, None)
        if index is None:
            return
        work(task, task.plan.part(index))


def _designs(task: Sweep, designs: range) -> None:
    """Compute the rows of a part."""
    task.fill_designs({"designs": Discarded()}, designs)


def _windows(task: Sweep, designs: range) -> None:
    """Compute the windows of a part."""
    for whole in task.plan.blocks_of_designs(designs):
        for block in task.folds.small_blocks(whole):
            task.folds.windows(block, task.plan.design(block))


def main(study: str, folder: str, threads: str, times: str) -> None:
    """Measure, and print the runs of both sides."""
    keep_freed_memory()
    plan = Plan(load_study(Path(study)))
    fused = Fused(plan, Path(folder))
    count = int(threads)
    fused.run(count)  # its results take their memory once
    ours, theirs = interleaved(
        int(times), lambda: tendon(Sweep(plan), count), lambda: fused.run(count)
    )
    record = {
        "tendon": asdict(ours)["runs"],
        "c": asdict(theirs)["runs"],
        "states": plan.states,
        "options": " ".join(OPTIONS),
    }
    print(json.dumps(record))


if __name__ == "__main__":
    main(*sys.argv[1:])
