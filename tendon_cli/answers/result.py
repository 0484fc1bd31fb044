"""What `tendon design` gives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from tendon_cli.engine.results import Result, framed

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, repr=False)
class Answer(Result):
    """An answer: `record` as in `design.json`, its tables, and the answer as `text`."""

    @property
    def best(self) -> dict[str, Any] | None:
        """The best choice as a row of `choices`, or without goals such rows by goal; None if none has a window."""
        best: dict[str, Any] | None = self.record["best"]
        return best

    @property
    def feasible(self) -> int:
        """How many choices have a window."""
        return int(self.record["feasible"])

    @property
    def front(self) -> list[dict[str, Any]]:
        """Rows of `choices` that no other beats in every goal."""
        return list(self.record["front"])

    @property
    def fixes(self) -> list[dict[str, Any]]:
        """What would give a window if no choice has one, the least change first."""
        return list(self.record["fixes"])

    @property
    def conflicts(self) -> list[dict[str, Any]]:
        """Which limits leave choices without a window, in how many, and by how much."""
        return list(self.record["conflicts"])

    @property
    def text(self) -> str:
        """The answer in 80 columns."""
        return str(self.record["text"])

    @cached_property
    def choices(self) -> pd.DataFrame:
        """A row per choice."""
        return framed(self.table("choices"))

    @cached_property
    def conditions(self) -> pd.DataFrame:
        """A row per condition."""
        return framed(self.table("conditions"))
