"""What `tendon design` gives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from tendon_cli.answers.question import Goal
from tendon_cli.engine.results import Result, along_own_axes, framed, variables_of, xarray_library
from tendon_cli.studies.load import recorded_study

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_MOST_WINDOWS = 10**7
_UNDER = "pretension that keeps every limit under this condition alone; there is none if from is above to"


@dataclass(frozen=True, eq=False, repr=False)
class Answer(Result):
    """An answer: `record` as in `design.json`, its tables, and the answer as `text`."""

    @property
    def best(self) -> dict[str, Any] | None:
        """The best choice as a row of `choices`: the compromise of several goals; None if no choice has a window."""
        best: dict[str, Any] | None = self.record["best"]
        return best

    @property
    def best_by(self) -> pd.DataFrame:
        """The best choice by each goal, a row per goal; without goals by those that every study has."""
        import pandas as pd

        rows = dict(self.record["best_by"])
        known = self.front or ([self.best] if self.best else [])
        for goal in (Goal(**each) for each in self.record["goals"] if known):
            scores = goal.score(np.array([row[goal.column] for row in known], dtype=np.float64))
            rows[goal.column] = known[int(np.argmax(scores))]
        return pd.DataFrame.from_dict(rows, orient="index")

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
    def persons(self) -> pd.DataFrame:
        """A row per person under the choice named first; raises InputError if the question has no people."""
        return framed(self.table("persons"))

    @cached_property
    def conditions(self) -> pd.DataFrame:
        """A row per condition."""
        return framed(self.table("conditions"))

    def to_xarray(self) -> xr.Dataset:
        """The columns of choices over their axes, less refined ones, and the window of each under each condition alone.

        `window_from` and `window_to` are worked out from the recorded study, for up to ten million windows. Needs the
        package xarray; raises UsageError without.
        """
        import pyarrow.compute as pc  # only who asks for this pays for its import

        from tendon_cli.answers.problem import question

        library = xarray_library()
        table = self.table("choices")
        grid = table.filter(pc.invert(table.column("refined")))
        names = grid.column_names[: grid.column_names.index("refined")]
        sizes = {name: len(grid.column(name).unique()) for name in names}
        choices = variables_of(grid, sizes)
        conditions = variables_of(
            self.table("conditions"), {"condition": self.record["conditions"]}
        )
        problem = question(recorded_study(self.record))
        if len(problem.choices) * len(problem.conditions) <= _MOST_WINDOWS:
            count = len(problem.choices)
            ends = problem.ends(problem.choices.numbers(np.arange(count)), count)
            for name, values, which in (
                ("window_from", ends.low, "smallest"),
                ("window_to", ends.high, "largest"),
            ):
                attributes = {
                    "units": "N",
                    "long_name": f"{which} pretension",
                    "description": f"{which} {_UNDER}",
                }
                choices[name] = (
                    (*sizes, "condition"),
                    values.reshape(*sizes.values(), -1),
                    attributes,
                )
        coordinates = {name: along_own_axes(name, choices.pop(name)) for name in names}
        coordinates |= {
            f"condition_{name}": variable
            for name, variable in conditions.items()
            if name != "condition"
        }
        facts = {name: self.record[name] for name in ("name", "title", "study_hash")}
        dataset: xr.Dataset = library.Dataset(choices, coordinates, facts)
        return dataset
