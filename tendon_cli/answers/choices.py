"""The task of a design question: every choice solved, part by part, and the answer."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, Self

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.answers import tables as answer_tables
from tendon_cli.answers.choose import choose
from tendon_cli.answers.design_kind import DESIGN
from tendon_cli.answers.people import GroupWindows, people_of, population
from tendon_cli.answers.record import explain, named_rows
from tendon_cli.answers.solved_parts import solutions_from, solved_columns, solved_rows
from tendon_cli.answers.text import answer_blocks, answer_text
from tendon_cli.engine.plan import part_range
from tendon_cli.engine.task import FinalFile, Note, Task
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import (
    Question,
    affords_motion,
    cost_per_design,
    group_axis,
    is_sought,
    question_of,
    rows_to_prove,
)
from tendon_cli.engine.windows.solutions import Solutions, solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.errors import SizeError
from tendon_cli.kernel import columns_writer
from tendon_cli.studies.space.axis import PERSON_AXIS, Axis
from tendon_cli.studies.study import Study
from tendon_cli.tables.schema import Column
from tendon_cli.tables.write import RowTarget
from tendon_cli.verbs.answer_record import ChoiceRecord, PopulationRecord, as_answer
from tendon_cli.verbs.registry import UNFINISHED
from tendon_cli.verbs.typed_record import to_json

CHOICES_PER_PART = 2**17
WINDOWS_PER_PART = 2**19
MOST_IN_MEMORY = 2**21
"""Choices of an answer without a folder."""
_SECONDS_PER_STATE = 4e-8
"""Time of the processor for a state whose window is computed, s, measured on a core of 2024."""
_SECONDS_PER_SEARCH = 1.5e-3
"""The same for a window that is sought pretension by pretension, beside its states."""
_LEAST_BYTES = 40
"""Bytes of a choice on a disk at the very least."""


class Choices(Task):
    """Task that solves every choice of a question under its conditions, and records the answer."""

    kind = DESIGN
    completed = "choices"

    def __init__(self, question: Question, stop: threading.Event | None = None) -> None:
        self.question = question
        self.stop = stop or threading.Event()
        with_motion = affords_motion(question, len(question.choices))
        self.solver = Solver(question, self.stop, with_motion=with_motion)
        self.persons = group_axis(question)
        """Axis of persons or draws, which have a table; None if there are neither."""
        self._windows_of: dict[int, GroupWindows] = {}
        if question.states >= 2**63:
            raise SizeError("more than 2^63 states", hint="fewer values on an axis")
        rows_to_prove(question)  # a fault in it is raised before anything is solved

    @classmethod
    def of(cls, study: Study, stop: threading.Event | None = None) -> Self:
        """Return the task of a study.

        Raises:
            TendonError: The study asks no question that can be answered.
        """
        return cls(question_of(study), stop)

    @property
    def study(self) -> Study:
        """Study that asks the question."""
        return self.question.stated or self.question.study

    @cached_property
    def tables(self) -> dict[str, int]:
        """Tables, and the number of files of each.

        Parts of choices follow from the question alone; conditions are one part.
        """
        parts = -(-len(self.question.choices) // self.length)
        tables = {UNFINISHED: parts, "choices": parts, "conditions": 1}
        if self.persons is not None:
            tables[_table_of(self.persons)] = 1
        return tables

    @property
    def last_tables(self) -> tuple[str, ...]:
        """Choices, and persons or draws, which follow from the record."""
        return tuple(table for table in self.tables if table not in (UNFINISHED, "conditions"))

    @property
    def length(self) -> int:
        """Number of choices in each part but the last."""
        return max(1, min(CHOICES_PER_PART, WINDOWS_PER_PART // len(self.question.conditions)))

    def part(self, index: int) -> range:
        """Return the choices of a part."""
        return part_range(len(self.question.choices), self.length, index)

    @property
    def least_bytes(self) -> int:
        """Bytes that the tables, and the parts of an unfinished run, take at the very least."""
        return 2 * _LEAST_BYTES * len(self.question.choices)

    @property
    def seconds(self) -> float:
        """Expected time of the processor for the windows of all choices, s."""
        windows = len(self.question.choices) * len(self.question.conditions)
        seconds = cost_per_design(self.question) * _SECONDS_PER_STATE
        if is_sought(self.question):
            seconds += _SECONDS_PER_SEARCH
        return windows * seconds

    def check_memory(self) -> None:
        """Raise SizeError if there are too many choices for memory."""
        count = len(self.question.choices)
        if count > MOST_IN_MEMORY:
            raise SizeError(f"{count:,} choices do not fit into memory", hint="name a folder")

    def columns(self, table: str) -> tuple[Column, ...]:
        """Return the columns of a table."""
        if table == UNFINISHED:
            return solved_columns(self.solver.columns_of_motion)
        if table == "choices":
            return answer_tables.choice_columns(self.question)
        if table == "conditions" or self.persons is None:
            return answer_tables.condition_columns(self.question)
        return answer_tables.person_columns(self.question, self.persons)

    def rows(self, table: str, index: int) -> int:
        """Return the number of rows of a part of a table."""
        if table in (UNFINISHED, "choices"):
            return len(self.part(index))
        if table == "conditions" or self.persons is None:
            return len(self.question.conditions)
        people = people_of(self.question)
        return len(self.persons if people is None else people.persons)

    def fill(self, tables: Mapping[str, RowTarget], index: int) -> Note:
        """Solve the choices of a part, and write them as they were solved.

        Raises:
            Stopped: The run was cancelled.
        """
        self.check_stopped()
        rows = {UNFINISHED: solved_rows(solve(self.solver, self._points(index)))}
        if "conditions" in tables:
            rows["conditions"] = answer_tables.condition_rows(self.question)
        for table, target in tables.items():
            count = self.rows(table, index)
            target.fill(count, columns_writer(rows[table], (count,)))
        return {}

    def _points(self, index: int) -> Points:
        """Return the choices of a part."""
        part = self.part(index)
        return self.question.points(np.arange(part.start, part.stop))

    def _solved(self, index: int, finished: Callable[[int], pa.Table]) -> Solutions:
        """Return the solved choices of a part."""
        return solutions_from(finished(index), self._points(index), self.solver.columns_of_motion)

    def is_note(self, index: int, note: Any) -> bool:  # noqa: ARG002
        """Return True if a note is empty: parts hold all that the whole answer needs."""
        return bool(note == {})

    def _group_windows(self, row: int) -> GroupWindows:
        """Return the windows of all groups for the choice in a row, worked out once."""
        if row not in self._windows_of:
            self._windows_of[row] = GroupWindows.of(
                self.solver, self.question.points(np.array([row]))
            )
        return self._windows_of[row]

    def place(self, index: int) -> str:
        """Say which choices a part has."""
        part = self.part(index)
        return f"choices {part.start} to {part.stop - 1}"

    def results(
        self,
        notes: Sequence[Note],
        finished: Callable[[int], pa.Table],
        proving: Callable[[int, int], None],
    ) -> dict[str, Any]:
        """Return the record of the answer, from the solved choices of all parts."""
        parts = [self._solved(index, finished) for index in range(len(notes))]
        solved = parts[0] if len(parts) == 1 else Solutions.concatenate(parts)
        chosen = choose(self.solver, solved, proving)
        record = explain(self.solver, solved, chosen)
        if self.persons is not None:
            (row,) = chosen.records(chosen.first)
            windows = self._group_windows(row.choice)
            record.population = population(self.solver, chosen.first, row, windows, chosen.judged)
        return {**to_json(record), "blocks": [*answer_blocks(record)], "text": answer_text(record)}

    def warnings(self, record: Mapping[str, Any]) -> list[str]:  # noqa: ARG002
        """Return no warnings: the record has its notes."""
        return []

    def final_files(
        self, record: Mapping[str, Any], finished: Callable[[int], pa.Table]
    ) -> Iterator[FinalFile]:
        """Yield choices, with what the record says of those that it names, and persons or draws.

        Args:
            record: The record.
            finished: Reads the solved choices of a part.
        """
        answer = as_answer(record)
        named = named_rows(answer)
        for index in range(self.tables["choices"]):
            yield self._choices_file(index, finished, named)
        population = answer.population
        if self.persons is not None and population is not None:
            yield self._persons_file(self.persons, population)

    def _choices_file(
        self, index: int, finished: Callable[[int], pa.Table], named: Sequence[ChoiceRecord]
    ) -> FinalFile:
        """Return a file of choices; its part is read when the file is written."""
        part = self.part(index)
        of_part = [row for row in named if row.choice in part]

        def write(targets: Mapping[str, npt.NDArray[Any]], rows: range) -> None:
            solved = self._solved(index, finished)
            values = answer_tables.completed_rows(self.question, solved, of_part, part)
            columns_writer(values, (len(part),))(targets, rows)

        return self.file("choices", index), self.layout("choices", index), write

    def _persons_file(self, axis: Axis, population: PopulationRecord) -> FinalFile:
        """Return the file of persons or draws under the choice that the record names first."""
        table = _table_of(axis)
        chosen = self.question.points(np.array([population.choice]))
        pretension = np.nan if population.pretension is None else population.pretension
        windows = self._group_windows(population.choice)
        rows = answer_tables.person_rows(self.question, axis, windows, chosen, pretension)
        return (
            f"{table}.parquet",
            self.layout(table, 0),
            columns_writer(rows, (self.rows(table, 0),)),
        )


def _table_of(axis: Axis) -> str:
    """Return the name of the table of persons, or of draws and drawn rows."""
    return "persons" if axis.key == PERSON_AXIS else "draws"
