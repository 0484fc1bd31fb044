"""The ratios with their targets: as lines for people, and as a record for the history."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

HISTORY = Path(__file__).with_name("history.jsonl")


@dataclass(frozen=True)
class Ratio:
    """A ratio, or the reason why there is none; `target` is what it should be at most or at least."""

    name: str
    value: float | None
    target: float | None = None
    bound: Literal["at most", "at least"] = "at most"
    note: str = ""

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None where there is none, or nothing was measured."""
        if self.value is None or self.target is None:
            return None
        return self.value <= self.target if self.bound == "at most" else self.value >= self.target

    def line(self) -> str:
        """The ratio, its target, the verdict, and what it comes from."""
        value = "      -" if self.value is None else f"{self.value:7.3f}" if self.value < 10 else f"{self.value:7.1f}"
        target = "" if self.target is None else f"{self.bound} {self.target:g}"
        verdict = {True: "met", False: "MISSED", None: ""}[self.met]
        return f"  {self.name:<50} {value}  {target:<14} {verdict:<7} {self.note}".rstrip()


@dataclass
class Report:
    """Everything that one run of the benchmark measured."""

    ratios: list[Ratio] = field(default_factory=list)
    seconds: dict[str, list[float]] = field(default_factory=dict)
    """Raw wall-clock seconds of every run, by what ran."""
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
        ratios = {ratio.name: {**asdict(ratio), "met": ratio.met} for ratio in self.ratios}
        for entry in ratios.values():
            del entry["name"]
        seconds = {name: [round(each, 4) for each in taken] for name, taken in self.seconds.items()}
        memory = {name: round(peak, 1) for name, peak in self.memory.items()}
        return {**what, "machine": machine, "ratios": ratios, "seconds": seconds, "peak_mb": memory}


def append(record: dict[str, Any], history: Path) -> None:
    """Put a record at the end of the history, a line of JSON."""
    with history.open("a", encoding="utf-8") as file:
        file.write(json.dumps(record, ensure_ascii=False) + "\n")
