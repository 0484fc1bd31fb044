"""The result of `tendon design`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from tendon_cli.answers.text import short_text
from tendon_cli.engine.results import (
    Result,
    along_own_axes,
    attributes_of,
    framed,
    variables_of,
    xarray_library,
)
from tendon_cli.engine.windows.question import Goal
from tendon_cli.verbs.answer_record import AnswerRecord, as_answer, holds, value_of
from tendon_cli.verbs.registry import load

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_MOST_WINDOWS = 10**7
"""Most windows, choices times conditions, that a dataset holds."""
_UNDER = (
    "pretension that keeps every limit under this condition alone; there is none if window_from is"
    " above window_to"
)


@dataclass(frozen=True, eq=False, repr=False)
class Answer(Result):
    """An answer: `record` as in `design.json`, its tables, and the answer as `text`."""

    drawn_by: ClassVar[str] = "tendon_cli.face.page_of_answer"
    documented: ClassVar[tuple[str, ...]] = (
        "best",
        "best_by",
        "choices",
        "conditions",
        "conflicts",
        "export",
        "feasible",
        "fixes",
        "front",
        "to_xarray",
    )

    @property
    def is_negative(self) -> bool:
        """True if the choice named first does not hold, or if there is none."""
        return not holds(self.answer)

    @cached_property
    def answer(self) -> AnswerRecord:
        """Record of `design.json` by its types."""
        return as_answer(self.record)

    @property
    def best(self) -> dict[str, Any] | None:
        """Best choice as a row of `choices`: with several goals the best compromise.

        None if no choice has a window.
        """
        best: dict[str, Any] | None = self.record["best"]
        return best

    @property
    def best_by(self) -> pd.DataFrame:
        """Best choice by each goal, a row per goal.

        A study that names no goals has the usual ones: tolerance, pretension and the costs.
        """
        import pandas as pd

        from tendon_cli.answers.tables import flat

        rows = dict(self.answer.best_by)
        best = self.answer.best
        candidates = self.answer.front or ([best] if best else [])
        goals = [Goal(goal.column, goal.maximise) for goal in self.answer.goals]
        if candidates:
            for goal in goals:
                column = [value_of(row, goal.column) for row in candidates]
                values = np.array(column, dtype=np.float64)
                rows[goal.column] = candidates[int(np.argmax(goal.score(values)))]
        flat_rows = {column: flat(row) for column, row in rows.items()}
        table = pd.DataFrame.from_dict(flat_rows, orient="index")
        in_memory = self.tables.get("choices")
        choices = self.kept("choices") if in_memory is None else in_memory
        table.attrs = attributes_of(choices.schema)
        return table.drop(columns=["from_under", "to_under"], errors="ignore")

    @property
    def feasible(self) -> int:
        """Number of choices that have a window."""
        return self.answer.feasible

    @property
    def front(self) -> list[dict[str, Any]]:
        """Rows of `choices` that no other beats in every goal."""
        return list(self.record["front"])

    @property
    def fixes(self) -> list[dict[str, Any]]:
        """Changes that would give a window if no choice has one, the least change first."""
        return list(self.record["fixes"])

    @property
    def conflicts(self) -> list[dict[str, Any]]:
        """Limits that leave choices without a window, in how many choices, and by how much."""
        return list(self.record["conflicts"])

    def __str__(self) -> str:
        return self.short

    @property
    def text(self) -> str:
        """The short answer, then the sections of the record as tables."""
        return self.answer.text

    @property
    def short(self) -> str:
        """The answer in at most 14 lines of 100 characters, blank ones not counted."""
        return short_text(self.answer)

    @cached_property
    def choices(self) -> pd.DataFrame:
        """Table with a row per choice."""
        return framed(self.table("choices"))

    @cached_property
    def persons(self) -> pd.DataFrame:
        """Table with a row per person under the choice that the answer names first.

        Raises:
            InputError: The question has no people.
        """
        return framed(self.table("persons"))

    @cached_property
    def conditions(self) -> pd.DataFrame:
        """Table with a row per condition."""
        return framed(self.table("conditions"))

    def export(
        self,
        to: str,
        out: str | PathLike[str],
        *,
        choice: int | None = None,
        overwrite: bool = False,
    ) -> Path:
        """Write a choice for the next tool, and return the path of the file.

        Args:
            to: "mujoco" for a model (.xml), "controller" for motor torque and spool angle over the
                elbow angle, "parameters" for a list of numbers (.csv).
            out: File to write.
            choice: Row of the choice; None for the one that the answer names first.
            overwrite: True to replace a file that tendon did not write.

        Raises:
            UsageError: There is no such form or choice, or tendon did not write the file.
            OutputError: The file cannot be written.
        """
        written: Path = load(self.kind.export)(self, to, out, choice=choice, overwrite=overwrite)
        return written

    def to_xarray(self) -> xr.Dataset:
        """Return the columns of choices over their axes, and their windows under each condition.

        `window_from` and `window_to`, the window under each condition alone, are worked out from
        the recorded study, for up to ten million windows.

        Raises:
            UsageError: The package xarray is missing.
        """
        from tendon_cli.answers.tables import choice_columns
        from tendon_cli.engine.windows.question import question_of
        from tendon_cli.engine.windows.solver import Solver
        from tendon_cli.quantities import unit_of_reading

        library = xarray_library()
        table = self.table("choices")
        question = question_of(self.study)
        sizes = {axis.column: len(axis) for axis in question.choices.axes}
        names = [column.name for column in choice_columns(question) if column.is_axis]
        choices = variables_of(table, sizes)
        conditions = variables_of(
            self.table("conditions"), {"condition": self.record["conditions"]}
        )
        if len(question.choices) * len(question.conditions) <= _MOST_WINDOWS:
            ends = Solver(question).ends(question.all_points())
            for name, values, which in (
                ("window_from", ends.low, "smallest"),
                ("window_to", ends.high, "largest"),
            ):
                attributes = {
                    "units": unit_of_reading(question.study.setting.read),
                    "long_name": f"{which} pretension",
                    "description": f"{which} {_UNDER}",
                }
                over_axes = values.reshape(*sizes.values(), -1)
                choices[name] = ((*sizes, "condition"), over_axes, attributes)
        coordinates = {name: along_own_axes(name, choices.pop(name)) for name in names}
        for name, variable in conditions.items():
            if name != "condition":
                coordinates[f"condition_{name}"] = variable
        facts = {name: self.record[name] for name in ("name", "title", "study_hash")}
        dataset: xr.Dataset = library.Dataset(choices, coordinates, facts)
        return dataset
