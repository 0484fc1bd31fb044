"""All choices of a question, part by part: solved at once in threads, written as they come, and only the best kept."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tendon_cli.answers.answer import Findings, Summary, summarise
from tendon_cli.answers.candidates import Candidates, part_of
from tendon_cli.answers.front import goals_of
from tendon_cli.answers.problem import Flags, Problem
from tendon_cli.answers.tables import ROW_GROUP, choice_columns, choice_rows, table_schema
from tendon_cli.engine.part import file_name
from tendon_cli.engine.run import Progress
from tendon_cli.errors import Stopped
from tendon_cli.kernel import copied
from tendon_cli.tables.write import TableFile, WrittenFile

CHOICES_PER_PART = 2**17
WINDOWS_PER_PART = 2**19

Solve = Callable[["Choices", threading.Event], Iterator[Candidates]]
"""Solves all parts of choices elsewhere, in their order."""


@dataclass(frozen=True, eq=False)
class Choices:
    """The choices of a question, in parts whose length follows from the question alone."""

    problem: Problem

    @property
    def length(self) -> int:
        """Choices in each part but the last."""
        return max(1, min(CHOICES_PER_PART, WINDOWS_PER_PART // len(self.problem.conditions)))

    @property
    def parts(self) -> int:
        """Number of parts."""
        return -(-len(self.problem.choices) // self.length)

    @cached_property
    def only(self) -> Candidates:
        """All choices, where they are one part."""
        return self.part(0)

    def part(self, index: int) -> Candidates:
        """The choices of a part, solved."""
        stop = min(len(self.problem.choices), (index + 1) * self.length)
        return part_of(self.problem, np.arange(index * self.length, stop))

    def file_name(self, index: int) -> str:
        """Where a part stands in the folder of the answer."""
        return file_name("choices", index, self.parts)

    def summary(
        self, folder: Path | None, jobs: int, stop: threading.Event, progress: Progress, solve: Solve | None = None
    ) -> Summary:
        """What matters of all choices; several parts are written into a folder, if there is one, as they are solved.

        By `solve` where it is given, else in threads. Raises Stopped where `stop` is set, OutputError where a part
        cannot be written.
        """
        goals = goals_of(self.problem.study)
        elsewhere = None if solve is None or self.parts == 1 else solve(self, stop)

        def one(index: int) -> Summary:
            if stop.is_set():
                raise Stopped
            if self.parts == 1:
                return summarise(self.only, goals)
            solved = self.part(index) if elsewhere is None else next(elsewhere)
            if folder is not None:
                self._write(folder, index, solved, np.zeros(len(solved), np.bool_))
            return summarise(solved, goals)

        progress(0, self.parts)
        whole: Summary | None = None
        for done, found in enumerate(_in_order(one, self.parts, jobs if elsewhere is None else 1), start=1):
            whole = found if whole is None else whole + found
            progress(done, self.parts)
        if whole is None or stop.is_set():
            raise Stopped
        return whole

    def finish(self, folder: Path, found: Findings) -> dict[str, WrittenFile]:
        """Write what only the whole answer knows: which choices are on the front, and those between the grid's points.

        Returns the files that were written anew, by their names.
        """
        front = found.front.row if found.front is not None else _rows_of_best(found)
        front = front[front >= 0]
        last = self.parts - 1
        anew = {int(row) // self.length for row in front} | ({last} if len(found.between) or last == 0 else set())
        written = {}
        for index in sorted(anew):
            solved = self.only if self.parts == 1 else self.part(index)
            refined = np.zeros(len(solved), dtype=np.bool_)
            on_front = np.isin(solved.row, front)
            if index == last and len(found.between):
                solved = Candidates.joined([solved, found.between])
                refined = np.concatenate([refined, np.ones(len(found.between), np.bool_)])
                on_front = np.concatenate([on_front, np.full(len(found.between), bool(found.goals))])
            written[self.file_name(index)] = self._write(folder, index, solved, on_front, refined)
        return written

    def _write(
        self, folder: Path, index: int, solved: Candidates, on_front: Flags, refined: Flags | None = None
    ) -> WrittenFile:
        path = folder / self.file_name(index)
        path.parent.mkdir(exist_ok=True)
        schema = table_schema(self.problem, "choices", index, self.parts)
        columns, count = choice_columns(self.problem), len(solved)
        between = np.zeros(count, np.bool_) if refined is None else refined
        rows = choice_rows(self.problem, solved, between, on_front)
        with TableFile(path, columns, schema, row_group=ROW_GROUP, rows=count) as file:
            file.fill(count, copied(rows, (count,)))
            return file.finish()


def _rows_of_best(found: Findings) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """The best row by a single goal is the whole front; without a goal there is none."""
    if not found.goals or found.chosen is None:
        return np.empty(0, dtype=np.int64)
    return found.chosen.row


def _in_order(one: Callable[[int], Summary], parts: int, jobs: int) -> Iterator[Summary]:
    """Results of parts in their order, as many at once as there are jobs."""
    if jobs == 1 or parts == 1:
        yield from map(one, range(parts))
        return
    from joblib import Parallel, delayed

    pool = Parallel(n_jobs=jobs, backend="threading", return_as="generator", pre_dispatch="2*n_jobs")
    yield from pool(delayed(one)(index) for index in range(parts))
