"""The verb: a study into its answer, in a folder that appears whole or not at all, or in memory."""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tendon_cli.answers.answer import findings
from tendon_cli.answers.folder import made_whole, standing, write_record
from tendon_cli.answers.parts import Choices, Solve
from tendon_cli.answers.population import population
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question import question
from tendon_cli.answers.record import record_of
from tendon_cli.answers.tables import ROW_GROUP, condition_columns, condition_rows, table_schema
from tendon_cli.answers.text import text_of
from tendon_cli.display import Displayed
from tendon_cli.engine.cluster import cluster_at
from tendon_cli.engine.results import framed
from tendon_cli.engine.run import Progress, available_cores
from tendon_cli.errors import InputError, SizeError
from tendon_cli.kernel import copied
from tendon_cli.studies.study import Study
from tendon_cli.tables.digest import file_sha256
from tendon_cli.tables.read import open_table
from tendon_cli.tables.write import TableFile, WrittenFile

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

Draw = Callable[[Path, dict[str, Any]], tuple[list[str], list[str]]]
"""Draws the figures of an answer into its folder, whose tables stand; returns the files, and what was not drawn."""

MOST_IN_MEMORY = 2**21
"""Choices of an answer without a folder."""


@dataclass(frozen=True, eq=False, repr=False)
class Answer(Displayed):
    """What `tendon design` found: `record` as in `design.json`, its tables, and the answer as `text`."""

    record: dict[str, Any]
    folder: Path | None = None
    """Where it stands; None in memory."""
    up_to_date: bool = False
    """Whether it had stood there before."""
    tables: dict[str, pa.Table] = field(default_factory=dict, repr=False)
    """Those that are in memory."""

    @property
    def best(self) -> dict[str, Any] | None:
        """The best choice as a row of `choices`, or without goals such rows by goal; None where none has a window."""
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
        """What would give a window, where no choice has one, the least change first."""
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
        return self._frame("choices")

    @cached_property
    def conditions(self) -> pd.DataFrame:
        """A row per condition."""
        return self._frame("conditions")

    def _frame(self, name: str) -> pd.DataFrame:
        if name in self.tables:
            return framed(self.tables[name])
        return framed(open_table(Path(self.folder or "") / f"{name}.parquet").read())


def design(
    study: Study,
    out: Path | None = None,
    *,
    jobs: int | None = None,
    overwrite: bool = False,
    scheduler: str | None = None,
    draw: Draw | None = None,
    progress: Progress = lambda _done, _all: None,
    stop: threading.Event | None = None,
) -> Answer:
    """Answer the question of a study into the folder `out`, or without one in memory; raises TendonError, Stopped."""
    ended = stop or threading.Event()
    choices = Choices(replace(question(study), stop=ended))
    _check_size(choices.problem)
    go = partial(_answer, choices, jobs, scheduler, ended, progress, draw)
    if out is None:
        if len(choices.problem.choices) > MOST_IN_MEMORY:
            raise SizeError(f"{len(choices.problem.choices):,} choices are too many for memory", hint="name a folder")
        with tempfile.TemporaryDirectory(prefix="tendon-") as making:
            record, folder = go(Path(making)), Path(making)
            tables = {name: open_table(folder / f"{name}.parquet").read() for name in ("choices", "conditions")}
        return Answer(record | {"files": [], "figures": []}, tables=tables)
    found = standing(out, choices.problem, overwrite=overwrite)
    if found is not None and (draw is None or found["figures"]):
        return Answer(found, out, up_to_date=True)
    with made_whole(out) as folder:
        return Answer(go(folder), out)


def _answer(
    choices: Choices, jobs: int | None, scheduler: str | None, stop: threading.Event, progress: Progress,
    draw: Draw | None, folder: Path,
) -> dict[str, Any]:  # fmt: skip
    """Work the answer out, its files into a folder; returns its record."""
    started = time.monotonic()
    with cluster_at(scheduler, jobs) as cluster:
        solve: Solve | None = None
        if cluster is not None:
            from tendon_cli.answers.cluster import solved  # only who has a cluster pays for its import

            solve = partial(solved, cluster)
        summary = choices.summary(folder, jobs or available_cores(), stop, progress, solve)
    answer = findings(choices.problem, summary)
    written = choices.finish(folder, answer)
    written["conditions.parquet"] = _write_conditions(choices.problem, folder)
    whom = population(choices.problem, answer.most_universal)
    record = record_of(answer, whom)
    record["text"] = text_of(choices.problem, record)
    record["seconds"] = round(time.monotonic() - started, 3)
    record["files"] = _files(folder, choices, written)
    record["figures"], warnings = draw(folder, record) if draw is not None else ([], [])
    if draw is not None and whom is not None:
        from tendon_cli.answers.population_figures import draw_population  # only who draws pays for its import

        record["figures"] += draw_population(whom, record, folder)
    record["notes"] += warnings
    write_record(folder, record)
    return record


def _check_size(problem: Problem) -> None:
    """Raises SizeError for more states than can be."""
    if len(problem.choices) * len(problem.conditions) * problem.states_per_design >= 2**63:
        raise SizeError("more than 2^63 states", hint="fewer values on an axis")


def _write_conditions(problem: Problem, folder: Path) -> WrittenFile:
    columns, count = condition_columns(problem), len(problem.conditions)
    schema = table_schema(problem, "conditions", 0, 1)
    with TableFile(folder / "conditions.parquet", columns, schema, row_group=ROW_GROUP, rows=count) as file:
        file.fill(count, copied(condition_rows(problem), (count,)))
        return file.finish()


def _files(folder: Path, choices: Choices, written: dict[str, WrittenFile]) -> list[dict[str, Any]]:
    """Every table file by its name, as it stands."""
    entries = []
    for name in [*(choices.file_name(index) for index in range(choices.parts)), "conditions.parquet"]:
        path = folder / name
        if not path.is_file():
            raise InputError("has gone missing", where=str(path))
        known = {"size": path.stat().st_size, "sha256": file_sha256(path)}
        entries.append({"path": name, **(asdict(written[name]) if name in written else known)})
    return entries
