"""A design question: every choice solved, part by part, and the answer that all of them give."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import pyarrow as pa

from tendon_cli import say
from tendon_cli.answers import tables as answered
from tendon_cli.answers.candidates import solved_part, summarised
from tendon_cli.answers.people import GroupWindows, people_of, population
from tendon_cli.answers.problem import Problem, question, rows_to_prove
from tendon_cli.answers.question import goals_of
from tendon_cli.answers.record import findings, named_rows
from tendon_cli.answers.text import blocks_of
from tendon_cli.engine.plan import part_of
from tendon_cli.engine.task import LastFile, Note, Task
from tendon_cli.errors import SizeError
from tendon_cli.kernel import writer_of
from tendon_cli.space.axis import Axis
from tendon_cli.studies.study import Study
from tendon_cli.tables.schema import Column, arrays_of
from tendon_cli.tables.write import Rows

CHOICES_PER_PART = 2**17
WINDOWS_PER_PART = 2**19
MOST_IN_MEMORY = 2**21  # choices of an answer without a folder
_LEAST_BYTES = 40  # of a choice


class Choices(Task):
    """Every choice of a question, folded to the window of its conditions."""

    verb = "design"

    def __init__(self, problem: Problem) -> None:
        self.problem, self.stop = problem, problem.stop
        self.persons = problem.group_axis
        """The axis of persons or draws, each of whom has a row of a table that is written last."""
        if len(problem.choices) * len(problem.conditions) * problem.states_per_design >= 2**63:
            raise SizeError("more than 2^63 states", hint="fewer values on an axis")
        rows_to_prove(problem)  # what names none is a fault before anything is solved

    @classmethod
    def of(cls, study: Study, stop: threading.Event | None = None) -> Self:
        """That of a study; raises TendonError."""
        return cls(replace(question(study), stop=stop or threading.Event()))

    @property
    def study(self) -> Study:
        """What is asked."""
        return self.problem.study

    @cached_property
    def tables(self) -> dict[str, int]:
        """Choices in parts, whose length follows from the question alone; conditions in one."""
        parts = {"choices": -(-len(self.problem.choices) // self.length), "conditions": 1}
        return parts if self.persons is None else {**parts, f"{self.persons.key}s": 0}

    @property
    def length(self) -> int:
        """Choices in each part but the last."""
        return max(1, min(CHOICES_PER_PART, WINDOWS_PER_PART // len(self.problem.conditions)))

    def part(self, index: int) -> range:
        """The choices of a part."""
        return part_of(len(self.problem.choices), self.length, index)

    @property
    def least_bytes(self) -> int:
        """That its tables take on a disk at the very least."""
        return _LEAST_BYTES * len(self.problem.choices)

    def check_memory(self) -> None:
        """Raises SizeError for too many choices."""
        if (count := len(self.problem.choices)) > MOST_IN_MEMORY:
            raise SizeError(f"{count:,} choices are too many for memory", hint="name a folder")

    def columns(self, table: str) -> tuple[Column, ...]:
        """Columns of a table."""
        if table == "choices":
            return answered.choice_columns(self.problem)
        axis = self.persons if table != "conditions" else None
        return (
            answered.condition_columns(self.problem)
            if axis is None
            else answered.person_columns(self.problem, axis)
        )

    def rows(self, table: str, index: int) -> int:
        """Rows of a part of a table."""
        if table == "choices":
            return len(self.part(index))
        if table == "conditions" or self.persons is None:
            return len(self.problem.conditions)
        people = people_of(self.problem)
        return len(self.persons if people is None else people.persons)

    def fill(self, tables: Mapping[str, Rows], index: int) -> Note:
        """Solve the choices of a part; raises Stopped."""
        self.go_on()
        part = self.part(index)
        candidates = solved_part(self.problem, np.arange(part.start, part.stop))
        known = {
            "choices": answered.choice_rows(
                self.problem, candidates, *np.zeros((2, len(part)), np.bool_)
            )
        }
        if "conditions" in tables:
            known["conditions"] = answered.condition_rows(self.problem)
        for table, sink in tables.items():
            count = self.rows(table, index)
            sink.fill(count, writer_of(known[table], (count,)))
        return summarised(candidates, goals_of(self.study))

    def is_note(self, index: int, note: Any) -> bool:
        """Whether the note of a part is as `fill` gives it."""
        part = self.part(index)
        try:
            counts = [note["feasible"], *(count for _, count in note["conflicts"])]
            texts = [name for names, _ in note["conflicts"] for name in names]
            return (
                note["choices"] == len(part)
                and all(type(count) is int and 0 <= count <= len(part) for count in counts)
                and all(isinstance(text, str) for text in texts)
                and isinstance(note["rows"], list)
                and all(type(row) is int and row in part for row in note["rows"])
            )
        except (KeyError, TypeError, ValueError):
            return False

    def place(self, index: int) -> str:
        """The choices of a part."""
        part = self.part(index)
        return f"choices {part.start} to {part.stop - 1}"

    def results(self, notes: Sequence[Note]) -> dict[str, Any]:
        """The answer, from the choices that may matter."""
        record, chosen, row = findings(self.problem, notes)
        if self.persons is not None:
            windows = GroupWindows.of(self.problem, chosen.columns)
            record["population"] = population(self.problem, chosen, row, windows)
        blocks = [*blocks_of(self.problem, record)]
        return record | {"blocks": blocks, "text": say.as_text(blocks, self.study)}

    def warnings(self, record: Mapping[str, Any]) -> list[str]:  # noqa: ARG002
        """None besides the notes of the record."""
        return []

    def last(
        self, record: Mapping[str, Any], read: Callable[[str], pa.Table]
    ) -> Iterator[LastFile]:
        """Parts with choices on the front, and the last one, to which those between the grid's points are added."""
        named, refined = named_rows(record)
        final = self.parts - 1
        for index in sorted({choice // self.length for choice in named} | {final}):
            name, columns = self.files(index)["choices"], self.columns("choices")
            part, values = self.part(index), arrays_of(columns, read(name))
            values = {
                column: those[: len(part)] for column, those in values.items()
            }  # without what was added before
            at = [choice - part.start for choice in named if choice in part]
            for column in columns:
                mine = [
                    answered.as_value(column, named[part.start + row][column.name]) for row in at
                ]
                added = (
                    [answered.as_value(column, row[column.name]) for row in refined]
                    if index == final
                    else []
                )
                every = np.concatenate([values[column.name], np.array(added, dtype=column.dtype)])
                every[at] = mine
                values[column.name] = every
            count = len(values["on_front"])
            yield name, self.layout("choices", index, count), writer_of(values, (count,))

        if self.persons is not None:
            yield self._persons_file(self.persons, record["population"])

    def _persons_file(self, axis: Axis, of_record: Mapping[str, Any]) -> LastFile:
        """The table of persons under the choice that the record names first."""
        table, axes = (
            f"{axis.key}s",
            (column for column in self.columns("choices") if column.is_axis),
        )
        chosen = {
            each.name: np.array([answered.as_value(each, of_record["values"][each.name])])
            for each in axes
        }
        pretension = np.nan if of_record["pretension"] is None else of_record["pretension"]
        windows = GroupWindows.of(self.problem, chosen)
        rows = answered.person_rows(self.problem, axis, windows, chosen, pretension)
        return f"{table}.parquet", self.layout(table, 0), writer_of(rows, (self.rows(table, 0),))
