"""`make bench`: how fast a sweep is and how much memory it takes, as ratios measured in one run.

Rates depend on the machine, so each stands beside something measured on it a moment before or
after: the machine's own limit (the same tables, ready in memory, written by bare pyarrow), what an
expert would write (`expert.py`), a fused loop in C (`fused.c`), the imports that cannot be done
without. Beside the ratio by the clock stands that of processor time, which says more on a machine
that others use, and the spread of the rounds. A full run is put at the end of `history.jsonl`.
"""

from __future__ import annotations

import argparse
import compileall
import os
import tempfile
import time
from pathlib import Path

from benchmarks import sections, starts, studies
from benchmarks.machine import ROOT, machine, when_and_what
from benchmarks.report import HISTORY, Report, append
from benchmarks.setting import Bench

QUIET = 0.5
"""Largest load of a machine that counts as quiet."""

_SECTIONS = {
    "states": sections.states_sweep,
    "kept": sections.kept_columns,
    "motion": sections.motion_in_time,
    "designs": sections.designs_sweep,
    "kernel": sections.kernel_share,
    "lock": sections.lock,
    "memory": sections.memory,
    "start": starts.start_up,
    "figures": starts.figures,
    "verify": starts.fresh_sample,
    "suit": starts.suit_logs,
    "joblib": sections.plain_script,
}


def full(scratch: Path) -> Bench:
    """Return the sizes that the targets are for."""
    return Bench(
        scratch,
        Report(),
        rounds=3,
        small_rounds=15,
        states=(50, 25, 22),
        designs=(50, 25, 20, 20),
        kernel=(64, 32, 16, 4),
        windows=(64, 64, 32),
        motion=(40, 25),
        many_parts=(50, 25, 22),
        lock_parts=30,
        growing={
            "10^6, both tables": studies.states_study(25, 11, 5),
            studies.MANY_PARTS: studies.states_study(25, 25, 22),
            "10^8, designs only": studies.designs_study(50, 25, 11, 10),
            "10^9, designs only": studies.designs_study(50, 50, 25, 22),
        },
    )


def quick(scratch: Path) -> Bench:
    """Return a tenth of the sizes, for a look while working."""
    bench = full(scratch)
    bench.rounds = 2
    bench.small_rounds = 5
    bench.lock_parts = 8
    bench.states = (25, 10, 11)
    bench.motion = (10, 20)
    bench.designs = (25, 20, 10, 10)
    bench.growing = {size: text for size, text in bench.growing.items() if "10^9" not in size}
    return bench


def _options() -> argparse.Namespace:
    """Read the options of the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.bench", description="measure tendon in ratios"
    )
    parser.add_argument(
        "--quick", action="store_true", help="smaller sizes, under a minute, nothing recorded"
    )
    parser.add_argument(
        "--only", choices=_SECTIONS, action="append", help="just this section, nothing recorded"
    )
    parser.add_argument(
        "--history", type=Path, default=HISTORY, help="where a full run is recorded"
    )
    return parser.parse_args()


def main() -> None:
    """Measure, print, record."""
    options = _options()
    started = time.monotonic()
    compileall.compile_dir(ROOT / "tendon_cli", quiet=1)  # as pip does with what it installs
    measured = when_and_what()
    computer = machine()
    commit = measured["commit"] or "no commit"
    changed = ", with uncommitted changes" if measured["uncommitted_changes"] else ""
    print(f"tendon {measured['version']} ({commit}{changed}), {measured['date']}")
    print(", ".join(f"{name} {value}" for name, value in computer.items()))
    load = float(str(measured["load_before"]))
    if load > QUIET:
        print(f"the machine is in use (load {load}), and ratios are worse than on a quiet one")
    if options.quick:
        print("quick: a tenth of the sizes that the targets are for")
    with tempfile.TemporaryDirectory(prefix="tendon-bench-") as name:
        scratch = Path(name)
        bench = quick(scratch) if options.quick else full(scratch)
        for section in options.only or _SECTIONS:
            if hasattr(os, "sync"):
                os.sync()  # what the section before left to be written would hold up this one
            _SECTIONS[section](bench)
    print(f"\n{time.monotonic() - started:.0f} s in all")
    if not (options.quick or options.only):
        append(bench.report.record(measured, computer), options.history)
        print(f"recorded in {options.history.name}")


if __name__ == "__main__":
    main()
