"""Everything that a comparison of two results says; texts, JSON and figures follow from it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, Self, TypeAlias

import numpy as np

from tendon_cli.checks.check_text import finite
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.engine.results import Result
from tendon_cli.engine.study_differences import Difference
from tendon_cli.model.kinematics import Array

Judgement: TypeAlias = Literal["better", "worse", "no difference"]
"""Judgement on the second result beside the first."""
Value: TypeAlias = float | str | bool | None
"""Value of a result, SI; None if it has none."""
Interval: TypeAlias = Sequence[float]
"""Ends of a 95 % interval."""

ROUNDING = 1e-9
"""Share of a number by which two numbers may differ by rounding."""
MOST_NAMES = 5
"""Most persons, draws or designs that are named."""
_BETTER = {
    "contact_width": -1,
    "efficiency": 1,
    "friction_loss": -1,
    "margin": 1,
    "motor_work_in": -1,
    "peak_elbow_torque": 0,  # follows from the task, not from the suit
    "required_pretension": -1,
    "rms_motor_torque": -1,
    "spool_travel": -1,
    "tolerance_length": 1,
}
"""Quantities whose names do not say it: 1 if more is better, -1 if less is."""
_BY_PREFIX = {"min_": 1, "max_": -1, "peak_": -1}


def better_of(name: str) -> int:
    """Return 1 if more of a quantity is better, -1 if less is, 0 if neither is."""
    if name in _BETTER:
        return _BETTER[name]
    return next((better for prefix, better in _BY_PREFIX.items() if name.startswith(prefix)), 0)


def judge(better: int, before: float | None, now: float | None) -> Judgement | None:
    """Judge a number beside another one, apart from rounding.

    Args:
        better: 1 if more is better, -1 if less is, 0 if neither is.
        before: Number of the first result.
        now: Number of the second.

    Returns:
        The judgement; None if neither is better, or if a result has no number.
    """
    if not better or before is None or now is None:
        return None
    if before == now or math.isclose(before, now, rel_tol=ROUNDING):
        return "no difference"
    return "better" if (now > before) == (better > 0) else "worse"


def difference(first: ColumnArray, second: ColumnArray, *, is_flag: bool) -> Array:
    """Return the difference in each row: for flags 0 or 1; infinite if only one value is null."""
    if is_flag:
        return np.asarray(first != second, dtype=np.float64)
    one_is_null = np.isnan(first) != np.isnan(second)
    with np.errstate(invalid="ignore"):  # two infinite values do not differ
        return np.where(one_is_null, np.inf, np.abs(np.nan_to_num(first - second)))


@dataclass(frozen=True)
class ComparedResult:
    """One of the results that are compared."""

    label: str
    """Name by which texts tell it from the other."""
    folder: str | None
    """Its folder; None in memory."""
    name: str
    title: str
    verb: str
    study_hash: str
    sentence: str
    """Its answer in a sentence or two."""
    unit: str
    """Unit of what is read, "N" or "N m"; that of pretensions."""

    @classmethod
    def of(cls, result: Result, label: str, sentence: str, unit: str) -> ComparedResult:
        """Return a result of a comparison, with what its texts say of it."""
        folder = None if result.folder is None else str(result.folder)
        facts = {name: result.record[name] for name in ("name", "title", "verb", "study_hash")}
        return cls(label, folder, **facts, sentence=sentence, unit=unit)

    @property
    def place(self) -> str:
        """Its folder, or its name."""
        return self.folder or self.name


@dataclass(frozen=True)
class Number:
    """A column of both results."""

    name: str
    """Its name among the quantities of tendon."""
    label: str
    """Meaning in words."""
    unit: str | None
    """SI unit; None for words and truths."""
    a: Value
    """Value of the first result: of an answer that of its choice, of a run the worst of all designs
    in both; where no direction is worse, the one that differs most."""
    b: Value
    """Value of the second result."""
    verdict: Judgement | None = None
    """Judgement on the second beside the first; None where neither is better by itself."""
    interval: Interval | None = None
    """95 % interval of the difference; None if it has none."""
    spans: tuple[Interval | None, Interval | None] = (None, None)
    """95 % interval of each value."""
    table: str = "choices"
    change: float = 0.0
    """Largest difference in any row, as a share of the largest magnitude; infinite if only one is
    null, or if words or truths differ."""
    most: float | None = None
    """The same difference, SI; None of words and truths."""
    rows: int = 0
    """Number of rows that differ."""
    where: Mapping[str, Value] = field(default_factory=dict)
    """Values on the axes of the row that differs most; of an answer those of both choices."""
    at: str = ""
    """The same in words."""

    @property
    def values(self) -> tuple[Value, Value]:
        """Both values."""
        return self.a, self.b

    @staticmethod
    def changes(
        size: Array, first: ColumnArray, second: ColumnArray, *, is_flag: bool
    ) -> dict[str, Any]:
        """Return `change`, `most` and `rows` of a column of both results, (rows,) each.

        Args:
            size: What `difference` says of them.
            first: The column of the first result.
            second: That of the second.
            is_flag: True for words, and for true or false.
        """
        most = float(size.max())
        rows = int((size > 0.0).sum())
        if is_flag:
            return {"change": math.inf if most else 0.0, "most": None, "rows": rows}
        finite_values = [values[np.isfinite(values)] for values in (first, second)]
        scale = max(float(np.abs(values).max(initial=0.0)) for values in finite_values)
        return {"change": most / (scale or 1.0), "most": most, "rows": rows}


@dataclass(frozen=True)
class BindingLimits:
    """Limits that set the window of an answer."""

    lower: str | None
    upper: str | None
    words: Sequence[str]
    """Both ends in words."""
    fresh: Sequence[float | None] | None
    """Window of the fresh sample; None without one."""


@dataclass(frozen=True)
class Unserved:
    """A person, a draw or a design that one of two results serves and the other does not."""

    name: str
    """Its name; of a fresh sample its numbers."""
    why: str
    """Name of the limit by which the other one loses it."""


@dataclass(frozen=True)
class Move:
    """Persons, draws or designs that one of two results alone serves."""

    kind: str
    """Noun for what is counted, in the plural."""
    count: int
    of: int
    """Number of those that both results judge."""
    share: float
    """Share of these, by weight."""
    names: Sequence[str] = ()
    """The first of them by name, of those that have one."""
    named: int = 0
    """Number of those that have a name: of the study's own sample, or of the designs."""
    named_kind: str = ""
    """Noun for those that have a name, in the plural."""
    named_of: int = 0
    """Number of persons, draws or designs that have a name."""
    why: Sequence[Unserved] = ()
    """The first of them with the limit that the other result breaks for each."""

    @classmethod
    def named_ones(cls, kind: str, count: int, of: int, why: Sequence[Unserved]) -> Self:
        """Return members that all have names, the first of them with their reasons."""
        names = [one.name for one in why]
        return cls(kind, count, of, count / (of or 1), names, count, kind, of, why)


@dataclass(frozen=True)
class Compared:
    """Second result beside the first."""

    a: ComparedResult
    b: ComparedResult
    differences: Sequence[Difference]
    """Keys in which the studies differ."""
    quantities: Sequence[Number]
    binds: tuple[BindingLimits | None, BindingLimits | None] = (None, None)
    """Limits that set the window of each answer; None for a run, or without a window."""
    gained: Move | None = None
    """Members whom the second alone serves; None if it cannot be told."""
    lost: Move | None = None
    """Members whom the first alone serves."""
    paired: bool = False
    """True if both shares are of the same members of a fresh sample, computed again for this."""
    compared: str = ""
    """Columns and rows, or quantities, that are compared, in words."""
    left_out: Mapping[str, str] = field(default_factory=dict)
    """Tables, columns and values of one result alone, in words, by name or key of their axis."""
    notes: Sequence[str] = ()
    """Sentences on what is compared, and what cannot be."""

    @property
    def sides(self) -> tuple[ComparedResult, ComparedResult]:
        """Both results."""
        return self.a, self.b

    @property
    def moves(self) -> list[Move]:
        """Members that are gained, and those that are lost; empty if it cannot be told."""
        return [move for move in (self.gained, self.lost) if move is not None]

    @property
    def is_equal(self) -> bool:
        """True if nothing differs."""
        is_changed = any(number.change for number in self.quantities)
        is_moved = any(move.count for move in self.moves)
        return not (is_moved or is_changed or self.differences or self.left_out)

    def number(self, name: str) -> Number | None:
        """Return a quantity of both results; None if neither has it."""
        return next((found for found in self.quantities if found.name == name), None)

    def record(self) -> dict[str, Any]:
        """Return the comparison as `tendon compare --json` prints it."""
        record: dict[str, Any] = finite(asdict(self))
        for found in record["differences"]:
            del found["shown"]
        record["binds"] = dict(zip(("a", "b"), record["binds"], strict=True))
        for name in ("gained", "lost"):
            move = record[name]
            record[f"why_{name}"] = [] if move is None else move.pop("why")
        return {"is_equal": self.is_equal, **record}
