"""`make bench`: how fast a sweep is and how much memory it takes, as ratios measured in one run.

Rates depend on the machine, so each stands beside the machine's own limit (the same tables, ready in memory, written by
bare pyarrow) and beside what a user would write instead (joblib over designs).
"""

from __future__ import annotations

import json
import os
import platform
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from benchmarks.measure import Cost, median, run

ROOT = Path(__file__).parent.parent
TENDON = [sys.executable, "-m", "tendon_cli"]

STATES_STUDY = """
name = "states"
[tendon]
pretension = { from = "20 N", to = "260 N", num = 25 }
[spring]
stiffness = { from = "1 kN/m", to = "8 kN/m", num = 10 }
[spool]
ratio = { from = 0.6, to = 1.2, num = 10 }
[load]
mass = ["0 kg", "3 kg", "5 kg", "10 kg"]
"""


@dataclass(frozen=True)
class Measured:
    """A study run by tendon and by its rivals."""

    name: str
    designs: int
    states: int
    tendon: Cost
    bare_write: float
    per_design_rate: float

    def lines(self) -> list[str]:
        """The figures, one a line."""
        seconds, memory = self.tendon.seconds, self.tendon.memory / 1e6
        designs, states = self.designs / seconds, self.states / seconds / 1e6
        limit, plain = seconds / self.bare_write, self.designs / self.per_design_rate
        return [
            f"{self.name}: {self.designs:,} designs, {self.states:,} states",
            f"  tendon, whole process    {seconds:9.2f} s  {designs:,.0f} designs/s, {states:.1f} M states/s",
            f"  its peak memory          {memory:9.0f} MB",
            f"  bare write of its tables {self.bare_write:9.2f} s  tendon takes {limit:.2f} x that",
            f"  joblib over designs      {plain:9.2f} s  tendon is {plain / seconds:.0f} x as fast",
        ]


def measure(study: Path, scratch: Path, sample: int) -> Measured:
    """Run a study by tendon, then its rivals on what tendon wrote."""
    folder = scratch / study.stem
    cost = median([*TENDON, "sweep", str(study), "--out", str(folder), "--overwrite", "--no-figures", "--quiet"])
    record = json.loads((folder / "run.json").read_text())
    bare = _rival("bare_write", str(folder), str(scratch / "bare"), scratch)
    plain = _rival("joblib_per_design", str(study), str(scratch / "plain"), str(sample), scratch)
    return Measured(
        study.stem, record["designs"], record["states"], cost, bare["seconds"], plain["designs"] / plain["seconds"]
    )


def _rival(name: str, *arguments: object) -> dict[str, float]:
    *given, scratch = arguments
    result = Path(str(scratch)) / f"{name}.json"
    run([sys.executable, "-m", "benchmarks.rivals", name, *map(str, given), str(result)])
    measured: dict[str, float] = json.loads(result.read_text())
    return measured


def main() -> None:
    """Measure and print."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    print(f"{platform.machine()}, {cores} cores, Python {platform.python_version()}, {platform.system()}")
    with tempfile.TemporaryDirectory(prefix="tendon-bench-") as name:
        scratch = Path(name)
        states = scratch / "states.toml"
        states.write_text(STATES_STUDY)
        for study, sample in ((states, 2000), (ROOT / "configs" / "large.toml", 2000)):
            print("\n".join(measure(study, scratch, sample).lines()), flush=True)


if __name__ == "__main__":
    main()
