"""Kinds of tasks: what a verb that computes writes, and who runs, checks and draws it.

A task says what it is in a `TaskKind`, in a small module of its own room. `KINDS` names these
modules. Every other room asks here: so a new verb touches its own room and one line of `KINDS`.

A kind names functions and classes by their full dotted names, and `load` imports them when they are
used. So `tendon --help` knows every verb and imports none of their rooms, and no room imports one
that lies above it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

KINDS: tuple[str, ...] = (
    "tendon_cli.engine.sweep_kind.SWEEP",
    "tendon_cli.answers.design_kind.DESIGN",
)
"""Names of the kinds of tasks, in the order in which they are listed."""


UNFINISHED = "unfinished"
"""Table that holds the finished parts of an unfinished run, of a task that completes their rows
when it knows the whole; it goes as soon as the run is recorded."""


_OF_EARLIER_VERSIONS = ("named",)
"""Tables that earlier versions wrote, by which a folder of theirs is known and can be replaced."""


class TableKind(NamedTuple):
    """A table that a task writes."""

    name: str
    """Its name, which is also that of its file."""
    axes: str = ""
    """Function that returns the axes of a study in the table, slowest first.

    Empty if the rows are no product of axes.
    """
    always: tuple[str, ...] = ()
    """Columns that every such table has, besides those of its axes."""


class SettingOption(NamedTuple):
    """Option of a command that sets a key of the study to a list of texts."""

    flag: str
    metavar: str
    help: str
    key: str
    """The key, such as `design.prove`."""


class FlagOption(NamedTuple):
    """Option of a command that is given or not."""

    flag: str
    help: str


class TaskKind(NamedTuple):
    """A verb that computes: its command, its record, its tables, and what reads its results.

    Functions and classes are given by their full dotted names; empty where there is none.
    """

    verb: str
    """Name of the command and of the function of the library."""
    help: str
    """One sentence on what the command does."""
    noun: str
    """Its result in messages, such as "an answer"."""
    record: str
    """File of the record."""
    counts: tuple[str, ...]
    """Counts that every record has."""
    tables: tuple[TableKind, ...]
    """Tables that it may write, the one that is shown by default first."""
    task: str
    """Class of the task, a `Task` of the engine."""
    result: str
    """Class of the result, a `Result` of the engine."""
    reads: str = ""
    """Function that reads a record of this version by its types, and raises ValueError if an entry
    does not fit. Empty if the record has no types of its own."""
    suffix: str = ""
    """End of the name of its default folder, after the name of the study."""
    size: str = ""
    """Function that returns the size of a task for --dry-run, as a record and as text.

    It takes the study, the folder, the number of jobs, and True if figures are drawn. The record
    has the size of the tables on the disk under `bytes`. Without a function the rows of each table
    are counted.
    """
    draw: str = ""
    """Function that draws the figures of a run, a `Draw` of the engine."""
    check_figures: str = ""
    """Function that raises an error if a figure that a study declares can have nothing to draw.

    Empty if the figures that a study declares are not drawn.
    """
    check: str = ""
    """Function that checks a result, for `tendon check`.

    It takes the result and the number of faults to list, and returns a `CheckResult`.
    """
    compare: str = ""
    """Function that compares a result with another one, for `tendon compare` and `check`.

    It takes both, the first one first, a label for each, the keys in which their studies differ,
    and the row of a choice or None; it returns a `Compared`.
    """
    export: str = ""
    """Function that writes a result for another tool, for `tendon export --to`.

    It takes the result, the name of a form and a path, and the options `choice` and
    `overwrite`; it returns the path.
    """
    page: str = ""
    """Function that returns the HTML page of a result, for `tendon report`."""
    setting: SettingOption | None = None
    """Its own option that sets a key of the study."""
    allow_negative: FlagOption | None = None
    """Its option with which the command exits with 0 although the result is negative."""
    whole: FlagOption | None = None
    """Its option with which the command prints all that there is to say of the result."""

    @property
    def table_names(self) -> tuple[str, ...]:
        """Names of its tables."""
        return tuple(table.name for table in self.tables)


def kinds() -> Mapping[str, TaskKind]:
    """Return the kinds of tasks by their verbs."""
    return _kinds(KINDS)


@lru_cache(maxsize=4)
def _kinds(names: tuple[str, ...]) -> dict[str, TaskKind]:
    """Import kinds of tasks by their names."""
    loaded: list[TaskKind] = [load(name) for name in names]
    return {kind.verb: kind for kind in loaded}


def kind_of(record: Mapping[str, Any]) -> TaskKind:
    """Return the kind of the task whose record this is."""
    return kinds()[record["verb"]]


def by_name(record: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Return a record by the name of its file, as `tables.read.records_in` reads it."""
    return {kind_of(record).record: record}


def record_names() -> tuple[str, ...]:
    """Return the names of the records of all verbs."""
    return tuple(kind.record for kind in kinds().values())


def table_kinds() -> Mapping[str, TableKind]:
    """Return the tables of all verbs by their names."""
    return _table_kinds(KINDS)


@lru_cache(maxsize=4)
def _table_kinds(names: tuple[str, ...]) -> dict[str, TableKind]:
    """Collect the tables of kinds of tasks by their names."""
    return {table.name: table for kind in _kinds(names).values() for table in kind.tables}


def tables_of(folder: Path, order: Sequence[str] | None = None) -> list[str]:
    """Return the names of the tables that a folder holds, in this order or that of their kinds."""
    return [name for name in order or table_kinds() if (folder / f"{name}.parquet").exists()]


def tables_in_folders() -> tuple[str, ...]:
    """Return the names of all tables that a run may have in its folder, finished or not."""
    return (*table_kinds(), UNFINISHED, *_OF_EARLIER_VERSIONS)


def load(name: str) -> Any:
    """Import what a full dotted name means, such as `tendon_cli.engine.sweep.Sweep`."""
    module, _, attribute = name.rpartition(".")
    return getattr(import_module(module), attribute)
