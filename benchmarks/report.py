"""Ratios with their targets: as lines for people, and as a record for the history."""

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
    """A ratio, or the reason why there is none."""

    name: str
    value: float | None
    target: float | None = None
    """Value that the ratio should have, at most or at least; None without a target."""
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
        """Return the median of the ratios of runs made next to each other.

        Args:
            name: Name of the ratio.
            above: Runs of one side.
            below: Runs of the other side, of the same number.
            target: Value that the ratio should have.
            bound: The sense of the target.
            note: Note after the shortest times of both sides.
        """
        by_clock = ratios(above.seconds, below.seconds)
        of_processor = ratios(above.processor, below.processor)
        notes = [f"{min(above.seconds):.3g} s, {min(below.seconds):.3g} s"]
        if note:
            notes.append(note)
        return cls(
            name,
            median(by_clock),
            target,
            bound,
            note="; ".join(notes),
            spread=(by_clock[0], by_clock[-1]),
            processor=median(of_processor),
        )

    @property
    def met(self) -> bool | None:
        """True if the target is met; None without a target, or if nothing was measured."""
        if self.value is None or self.target is None:
            return None
        if self.bound == "at most":
            return self.value <= self.target
        return self.value >= self.target

    def line(self) -> str:
        """Return the ratio, its target, the verdict, and what it comes from."""
        value = "-"
        if self.value is not None:
            value = f"{self.value:.3f}" if self.value < 10 else f"{self.value:.1f}"
        target = "" if self.target is None else f"{self.bound} {self.target:g}"
        verdict = {True: "met", False: "MISSED", None: ""}[self.met]
        spread = "" if self.spread is None else "{:.3g} to {:.3g}".format(*self.spread)
        processor = "" if self.processor is None else f"processor {self.processor:.3g}"
        cells = (
            f"{self.name:<50}",
            f"{value:>7} ",
            f"{target:<14}",
            f"{verdict:<7}",
            f"{spread:<15}",
            f"{processor:<16}",
            self.note,
        )
        return f"  {' '.join(cells)}".rstrip()


@dataclass
class Report:
    """All that one run of the benchmark measured."""

    ratios: list[Ratio] = field(default_factory=list)
    times: dict[str, Times] = field(default_factory=dict)
    """Times of all runs, by what ran."""
    memory: dict[str, float] = field(default_factory=dict)
    """Peak of memory, MB, by what ran."""

    def heading(self, text: str) -> None:
        """Print a heading."""
        print(f"\n{text}", flush=True)

    def add(self, *ratios: Ratio) -> None:
        """Add ratios, and print them at once."""
        self.ratios += ratios
        for ratio in ratios:
            print(ratio.line(), flush=True)

    def record(self, measured: dict[str, object], machine: dict[str, object]) -> dict[str, Any]:
        """Return the run as one object, after what was measured and on which machine."""
        ratios = {}
        for ratio in self.ratios:
            entry = asdict(ratio) | {"met": ratio.met}
            del entry["name"]
            ratios[ratio.name] = entry
        seconds = {}
        processor_seconds = {}
        for name, times in self.times.items():
            seconds[name] = [round(value, 4) for value in times.seconds]
            processor_seconds[name] = [round(value, 4) for value in times.processor]
        return {
            **measured,
            "machine": machine,
            "ratios": ratios,
            "seconds": seconds,
            "processor_seconds": processor_seconds,
            "peak_mb": {name: round(peak, 1) for name, peak in self.memory.items()},
        }


def append(record: dict[str, Any], history: Path) -> None:
    """Append a record to the history, a line of JSON."""
    with history.open("a", encoding="utf-8") as file:
        file.write(json.dumps(record, ensure_ascii=False) + "\n")
