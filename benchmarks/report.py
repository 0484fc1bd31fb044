"""The ratios with their targets: as lines for people, and as a record for the history."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import median
from typing import Any, Literal, Self

from benchmarks.measure import Times, ratios

HISTORY = Path(__file__).with_name("history.jsonl")


@dataclass(frozen=True)
class Ratio:
    """A ratio, or the reason why there is none; `target` is what it should be at most or at least."""

    name: str
    value: float | None
    target: float | None = None
    bound: Literal["at most", "at least"] = "at most"
    note: str = ""
    spread: tuple[float, float] | None = None
    """The smallest and the largest of the pairs that the ratio is the median of."""
    processor: float | None = None
    """The same ratio of processor time, which other work on the machine disturbs less."""

    @classmethod
    def of(
        cls,
        name: str,
        above: Times,
        below: Times,
        target: float | None = None,
        bound: Literal["at most", "at least"] = "at most",
        note: str = "",
    ) -> Self:
        """The median of the ratios of runs made next to each other, by the clock and of processor time."""
        found = ratios(above.seconds, below.seconds)
        worked = median(ratios(above.processor, below.processor))
        what = f"{min(above.seconds):.3g} s, {min(below.seconds):.3g} s{note and '; '}{note}"
        return cls(name, median(found), target, bound, what, (found[0], found[-1]), worked)

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None where there is none, or nothing was measured."""
        if self.value is None or self.target is None:
            return None
        return self.value <= self.target if self.bound == "at most" else self.value >= self.target

    def line(self) -> str:
        """The ratio, its target, the verdict, and what it comes from."""
        value = (
            "      -"
            if self.value is None
            else f"{self.value:7.3f}"
            if self.value < 10
            else f"{self.value:7.1f}"
        )
        target = "" if self.target is None else f"{self.bound} {self.target:g}"
        verdict = {True: "met", False: "MISSED", None: ""}[self.met]
        spread = "" if self.spread is None else "{:.3g} to {:.3g}".format(*self.spread)
        worked = "" if self.processor is None else f"processor {self.processor:.3g}"
        return f"  {self.name:<50} {value}  {target:<14} {verdict:<7} {spread:<15} {worked:<16} {self.note}".rstrip()


@dataclass
class Report:
    """Everything that one run of the benchmark measured."""

    ratios: list[Ratio] = field(default_factory=list)
    times: dict[str, Times] = field(default_factory=dict)
    """Every run, by what ran."""
    memory: dict[str, float] = field(default_factory=dict)
    """Peak MB by what ran."""

    def heading(self, text: str) -> None:
        """Print what comes next."""
        print(f"\n{text}", flush=True)

    def add(self, *ratios: Ratio) -> None:
        """Take ratios, and print them at once."""
        self.ratios += ratios
        for ratio in ratios:
            print(ratio.line(), flush=True)

    def record(self, what: dict[str, object], machine: dict[str, object]) -> dict[str, Any]:
        """The run as one object."""
        told = {ratio.name: {**asdict(ratio), "met": ratio.met} for ratio in self.ratios}
        for entry in told.values():
            del entry["name"]
        seconds = {
            name: [round(each, 4) for each in taken.seconds] for name, taken in self.times.items()
        }
        processor = {
            name: [round(each, 4) for each in taken.processor] for name, taken in self.times.items()
        }
        memory = {name: round(peak, 1) for name, peak in self.memory.items()}
        times = {"seconds": seconds, "processor_seconds": processor}
        return {**what, "machine": machine, "ratios": told, **times, "peak_mb": memory}


def append(record: dict[str, Any], history: Path) -> None:
    """Put a record at the end of the history, a line of JSON."""
    with history.open("a", encoding="utf-8") as file:
        file.write(json.dumps(record, ensure_ascii=False) + "\n")
