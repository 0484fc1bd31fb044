"""One axis of a study: its values, and the numbers of the study that each value sets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, Literal, Self

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array, Real, Rows
from tendon_cli.quantities import SIDES
from tendon_cli.units import UNITS

CASE_AXIS = "case"
PERSON_AXIS = "person"
DRAW_AXIS = "draw"
NAMED_AXES = (CASE_AXIS, PERSON_AXIS, DRAW_AXIS)
"""Keys of the named axes that a study may have, slowest first."""
SAMPLE_AXES = (PERSON_AXIS, DRAW_AXIS)
"""Axes of the persons and draws that a study draws itself."""
PRETENSION = "tendon.pretension"

# Keys of settings that a study gives as words, and the model takes as numbers
REFERENCE = "model.reference"
"""1 if the flexor's travel is measured from the initial path."""
SLACK = "model.slack"
"""1 if tendons cannot push."""
SPRING_AT = "spring.at"
"""1 if a spring sits at the motor."""
AFTER = "setting.after"
"""1 if the pretension is set after flexion."""
READ = "setting.read"
"""Index into `READINGS`: how the pretension is read."""
READING_ERROR = "setting.reading_error"
"""Error of the gauge by which the pretension is read, in the unit of the reading."""
WORDS = (REFERENCE, SLACK, SPRING_AT, AFTER, READ)

LIMIT = "limits."
"""Beginning of the key of a limit, followed by its name."""

Role = Literal["choice", "condition", "draw", "pretension"]
"""A draw is a condition that belongs to a sample: a person, or a draw of the uncertain numbers."""
Numbers = Mapping[str, Array]
"""Numbers of some rows, (rows,) each, by dotted key, SI, or factors on them by `scale_of` the key.

A value is NaN if its row does not set the number.
"""
Box = tuple[slice, ...]
"""A slice of each axis."""
_SCALE = "scale of "
_FACTOR = "factor of "
_SHIFT = "shift of "
_SPRING = "spring."
_MOST_TOLD = 2
"""Most numbers by which a row of a named axis is told from the others."""


def split_side(path: str) -> tuple[str, str | None]:
    """Split `tendon.flexor.length` into `tendon.length` and `flexor`; a common key has no side."""
    parts = path.split(".")
    if len(parts) == 3 and parts[1] in SIDES:
        return f"{parts[0]}.{parts[2]}", parts[1]
    return path, None


def limit_of(key: str) -> str | None:
    """Return the name of the limit whose key is `limits.` and this name; None for another key."""
    return key.removeprefix(LIMIT) if key.startswith(LIMIT) else None


def evenly_spaced(count: int, most: int) -> Rows:
    """Choose at most `most` of `count` positions evenly, with both ends.

    If `most` is 1, choose the middle.
    """
    if count <= most:
        return np.arange(count, dtype=np.int64)
    if most == 1:
        return np.array([count // 2], dtype=np.int64)
    return np.unique(np.round(np.linspace(0, count - 1, most)).astype(np.int64))


@cache
def of_side(key: str, side: str) -> str:
    """Return the key of one side: `tendon.flexor.length` for `tendon.length`."""
    table, _, name = key.rpartition(".")
    return f"{table}.{side}.{name}"


@cache
def scale_of(key: str) -> str:
    """Return the key of the factor on a number, such as on an anchor for a larger arm."""
    return _SCALE + key


@cache
def factor_of(key: str) -> str:
    """Return the key of the factor by which a number deviates, whatever its value."""
    return _FACTOR + key


@cache
def shift_of(key: str) -> str:
    """Return the key of the amount by which a number deviates, whatever its value."""
    return _SHIFT + key


def overlay(below: Numbers, above: Numbers) -> dict[str, Array]:
    """Overlay numbers of the same rows: those of `above` replace those of `below` unless NaN."""
    both = {
        key: np.where(np.isnan(above[key]), below[key], above[key])
        for key in below.keys() & above.keys()
    }
    return {**below, **above, **both}


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of a product: its key, its column in tables, and the numbers that each value sets.

    A list of points is an axis, too, without a key and a column.
    """

    key: str
    """Dotted key of the number, or one of NAMED_AXES."""
    column: str
    """Name of its column in tables."""
    numbers: Numbers
    """Numbers that each value sets or scales, (len,) each."""
    names: tuple[str, ...] = ()
    """Names of its values; empty for an axis of a number."""
    role: Role = "choice"
    is_range: bool = False
    """True for a grid, which may be finer or wider; a list is a catalogue."""
    is_log: bool = False
    """True for a grid of equal ratios."""
    is_interval: bool = False
    """True for a condition of two values that means every value between them, too."""
    weighting: Array | None = None
    """Weight of each value in a share, (len,); None if all count the same."""

    def __len__(self) -> int:
        return len(self.names) or len(self.numbers[self.key])

    @classmethod
    def of_points(cls, numbers: Numbers, count: int | None = None) -> Axis:
        """Return the axis of a list of points, which need not lie on a grid.

        Args:
            numbers: Numbers that the points set, (points,) each.
            count: Number of points; needed if they may set no number.
        """
        length = max(map(len, numbers.values()), default=1) if count is None else count
        return cls("", "", numbers, ("",) * length)

    @cached_property
    def values(self) -> npt.NDArray[Any]:
        """Values in SI, or their names if they have names, (len,)."""
        return np.array(self.names, dtype=object) if self.names else self.numbers[self.key]

    @cached_property
    def rank(self) -> Rows:
        """Place of each value in ascending order, (len,), whatever the order of the values.

        Rows with names are ordered by the numbers that they set, the numbers in the order of their
        keys, and then by their names; cases by their names alone.
        """
        by_name = np.argsort(np.argsort(self.values, kind="stable"))
        if not self.names or self.key == CASE_AXIS:
            return by_name
        columns = [by_name, *(self.numbers[key] for key in sorted(self.numbers, reverse=True))]
        ranks = np.empty(len(self), dtype=np.int64)
        ranks[np.lexsort(columns)] = np.arange(len(self))
        return ranks

    @property
    def length(self) -> int:
        """Number of values."""
        return len(self)

    @property
    def is_text(self) -> bool:
        """True if the values are names."""
        return bool(self.names)

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of the numbers that its values set or scale, each once, without deviations."""
        own = (key for key in self.numbers if not key.startswith((_FACTOR, _SHIFT)))
        return tuple(dict.fromkeys(key.removeprefix(_SCALE) for key in own))

    def without(self, *common: str) -> Axis:
        """Return the same axis without the numbers of some common keys, for both sides or one."""
        numbers = {
            key: values for key, values in self.numbers.items() if split_side(key)[0] not in common
        }
        return replace(self, numbers=numbers)


@dataclass(frozen=True, eq=False)
class CarriedColumn:
    """Column of named rows that sets no number of a study, such as a price or a supplier."""

    name: str
    """Name of the column, without a unit."""
    unit: str
    """Unit as the header of the column has it; empty if it has none."""
    values: npt.NDArray[Any]
    """Numbers, NaN in a row without one, or places in `words`, (rows,)."""
    words: tuple[str, ...] = ()
    """Words of a column of text; empty for a column of numbers."""
    numbers: Array | None = None
    """Numbers among the words of a column of text, (rows,), NaN for every other word; None if
    there are none."""

    @property
    def addends(self) -> Array | None:
        """Numbers to add to those of other tables, (rows,); None for a column without any."""
        return self.numbers if self.words else self.values

    def text(self, row: int) -> str:
        """Return the value of a row in words: "14 EUR", "mass 390 g", "A"; empty if it has none.

        A price says by its unit what it is; of a length, a mass or a bare number only its name can.
        """
        if self.words:
            return self.words[int(self.values[row])]
        value = float(self.values[row])
        if np.isnan(value):
            return ""
        number = f"{value:.12g}"
        name = self.name.replace("_", " ")
        if not self.unit:
            return f"{name} {number}"
        return f"{name} {number} {self.unit}" if self.unit in UNITS else f"{number} {self.unit}"


@dataclass(frozen=True, eq=False)
class NamedAxis(Axis):
    """Axis of rows with names, each of which sets several numbers together.

    Cases, tables of a study, persons and draws of the uncertain numbers are such axes; its key is
    its column, too. A number is NaN in a row that does not set it: there the study's own value
    holds.
    """

    carried: tuple[CarriedColumn, ...] = ()
    """Columns that the rows carry along, and that set nothing."""

    @classmethod
    def of(
        cls,
        key: str,
        names: tuple[str, ...],
        sets: Numbers,
        role: Role,
        weighting: Array | None = None,
    ) -> Self:
        """Return the axis of some rows.

        Args:
            key: Name of the axis.
            names: Names of the rows.
            sets: Numbers that the rows set or scale, (rows,) each.
            role: What the rows are to a designer.
            weighting: Weight of each row in a share, (rows,); None if all count the same.
        """
        return cls(key, key, sets, names, role, weighting=weighting)

    @property
    def pieces(self) -> int:
        """Number of parts that a row stands for: 2 of a table of single springs, one a side."""
        of_parts = [key for key in self.keys if limit_of(key) is None]
        are_springs = all(key.startswith(_SPRING) for key in of_parts)
        is_of_both = all(split_side(key)[1] is None for key in of_parts)
        return 2 if of_parts and are_springs and is_of_both and self.role == "choice" else 1

    @cached_property
    def _places(self) -> dict[str, int]:
        """Place of each name."""
        return {name: place for place, name in enumerate(self.names)}

    def place(self, name: str) -> int:
        """Return the place of a name. Raises KeyError if it has none."""
        return self._places[name]

    @cached_property
    def _differing(self) -> tuple[str, ...]:
        """Keys of the numbers that are not the same in all rows; of a single row all keys."""
        return tuple(
            key
            for key, values in self.numbers.items()
            if len(values) == 1 or (values[1:] != values[0]).any()
        )

    def told_by(self, row: int) -> dict[str, float]:
        """Return the numbers that a row sets and others do not; none if they are many.

        A member of a sample is known by its name alone.
        """
        if self.role == "draw":
            return {}
        numbers = {
            key: float(self.numbers[key][row])
            for key in self._differing
            if not np.isnan(self.numbers[key][row])
        }
        return numbers if len(numbers) <= _MOST_TOLD else {}

    def carried_by(self, row: int) -> tuple[str, ...]:
        """Return what a row carries in words, texts first; the first columns only."""
        columns = sorted(self.carried, key=lambda column: not column.words)
        texts = (column.text(row) for column in columns)
        return tuple(text for text in texts if text)[:_MOST_TOLD]


@dataclass(frozen=True, eq=False)
class Varying:
    """A number of designs: one value, or values along the axes that it depends on."""

    value: Any
    """Value where no axis sets one; NaN if nothing gives the number. A curve, or None for no curve,
    is never set by an axis."""
    sets: tuple[tuple[int, Array], ...] = ()
    """Places of axes, with the values that they set. A later axis overrules an earlier one except
    where it is NaN."""
    scales: tuple[tuple[int, Array], ...] = ()
    """Places of axes, with the factors by which they scale it."""
    shifts: tuple[tuple[int, Array], ...] = ()
    """Places of axes, with the amounts by which it deviates."""
    least: float = -np.inf
    """Smallest possible value of a number that deviates."""

    @property
    def axes(self) -> tuple[int, ...]:
        """Places of the axes that it depends on, ascending."""
        return tuple(sorted({axis for axis, _ in (*self.sets, *self.scales, *self.shifts)}))

    def within(self, box: Box) -> Real:
        """Return its values in a box, shaped to broadcast over designs, directions and angles."""
        values: Real = self.value
        for order, (axis, along) in enumerate(self.sets):
            given = along_axis(axis, along, box)
            values = given if order == 0 else np.where(np.isnan(given), values, given)
        for axis, along in self.scales:
            values = values * along_axis(axis, along, box)
        for axis, along in self.shifts:
            shifted = values + along_axis(axis, along, box)
            values = np.where(np.real(shifted) < self.least, self.least, shifted)
        return values


def along_axis(axis: int, values: Array, box: Box) -> Array:
    """Return the values along an axis that lie in a box, (1, ..., values, ..., 1)."""
    shape = [1] * (len(box) + 2)
    shape[axis] = -1
    return values[box[axis]].reshape(shape)
