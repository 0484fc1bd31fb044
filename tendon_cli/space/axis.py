"""One axis of a study: its values, and what each of them says of the study's numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array, Real

SIDES = ("flexor", "extensor")
CASE_AXIS, PERSON_AXIS, DRAW_AXIS = "case", "person", "draw"
NAMED_AXES = (CASE_AXIS, PERSON_AXIS, DRAW_AXIS)
"""Axes whose values have names, and set several numbers at once."""
PRETENSION = "tendon.pretension"
REFERENCE, SLACK, SPRING_AT = "model.reference", "model.slack", "spring.at"
AFTER, READ = "setting.after", "setting.read"
"""Words as numbers: 1 if the flexor's travel is measured from the initial path; if tendons cannot push; if a spring
sits at the motor; if the pretension is set after flexion; and the place of how it is read among `READINGS`."""
WORDS = (REFERENCE, SLACK, SPRING_AT, AFTER, READ)

Role = Literal["choice", "condition", "pretension"]
Numbers = Mapping[str, Array]
"""Numbers of some rows by dotted key, or by `scale_of` a key, (rows,), SI; NaN where a row says nothing of it."""
Rows = npt.NDArray[np.int64]
Box = tuple[slice, ...]
"""A slice of each axis."""
_SCALE = "scale of "


def split_side(path: str) -> tuple[str, str | None]:
    """`tendon.flexor.length` into `tendon.length` and `flexor`; a common key has no side."""
    parts = path.split(".")
    if len(parts) == 3 and parts[1] in SIDES:
        return f"{parts[0]}.{parts[2]}", parts[1]
    return path, None


@cache
def of_side(key: str, side: str) -> str:
    """`tendon.length` on a side: `tendon.flexor.length`."""
    table, _, name = key.rpartition(".")
    return f"{table}.{side}.{name}"


@cache
def scale_of(key: str) -> str:
    """The key under which a row says by what a number is multiplied, such as an anchor on a larger arm."""
    return _SCALE + key


def over(below: Numbers, above: Numbers) -> dict[str, Array]:
    """What rows say above, and where they say nothing, what they say below."""
    both = {
        key: np.where(np.isnan(above[key]), below[key], above[key])
        for key in below.keys() & above.keys()
    }
    return {**below, **above, **both}


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis: its dotted key (`case`, `person` or `draw`), its column, and what its values say of numbers.

    A list of points is an axis, too: each of its values sets some numbers.
    """

    key: str
    column: str
    numbers: Numbers
    """What each value sets, and by what it scales: (len,) each."""
    names: tuple[str, ...] = ()
    """Of its values; those of a number have none."""
    role: Role = "choice"
    is_range: bool = False
    """A grid, between whose points others may be chosen; a list is a catalogue."""
    is_log: bool = False
    is_interval: bool = False
    """Every value between the two that it has is meant; a condition."""
    weighting: Array | None = None
    """How much each value counts in a share; None where all count the same."""

    def __len__(self) -> int:
        return len(self.names) or len(self.numbers[self.key])

    @classmethod
    def of_points(cls, numbers: Numbers, count: int | None = None) -> Axis:
        """Points anywhere, by what they say of the numbers; `count` is needed where they may say nothing."""
        length = max(map(len, numbers.values()), default=1) if count is None else count
        return cls("", "", numbers, ("",) * length)

    @cached_property
    def values(self) -> npt.NDArray[Any]:
        """The values of a number in SI, else their names."""
        return np.array(self.names, dtype=object) if self.names else self.numbers[self.key]

    @property
    def length(self) -> int:
        """Number of values."""
        return len(self)

    @property
    def is_text(self) -> bool:
        """Whether its values are names."""
        return bool(self.names)

    @property
    def meaning(self) -> str:
        """What the column of its names holds."""
        return f"name of the {self.key}" if self.key in NAMED_AXES else self.words

    def named(self, name: str) -> str:
        """One of its names in a sentence: of a case the name alone, else "spring at the motor"."""
        common, side = split_side(self.key)
        whose = f"the {side}'s " if side else ""
        return name if self.key in NAMED_AXES else f"{whose}{common.replace('.', ' ')} the {name}"

    @property
    def words(self) -> str:
        """Its column in a sentence."""
        return self.column.replace("_", " ")

    @property
    def keys(self) -> frozenset[str]:
        """The numbers that its values set or scale."""
        return frozenset(key.removeprefix(_SCALE) for key in self.numbers)

    def without(self, *common: str) -> Axis:
        """The same axis, saying nothing of some numbers and of those on either side."""
        kept = {
            key: values for key, values in self.numbers.items() if split_side(key)[0] not in common
        }
        return replace(self, numbers=kept)


@dataclass(frozen=True, eq=False)
class Varying:
    """What a number is for each design: a value, or values along the axes that it depends on."""

    value: Any
    """Where no axis sets it; NaN where nothing does. A curve, or None for none, is what no axis sets."""
    sets: tuple[tuple[int, Array], ...] = ()
    """Axes with what they set, the later over the earlier, which counts where the later is NaN."""
    scales: tuple[tuple[int, Array], ...] = ()

    @property
    def axes(self) -> tuple[int, ...]:
        """The axes that it depends on, ascending."""
        return tuple(sorted({axis for axis, _ in (*self.sets, *self.scales)}))

    def within(self, box: Box) -> Real:
        """Its values in a box, shaped to broadcast over the box's designs, directions and angles."""
        values: Real = self.value
        for at, (axis, along) in enumerate(self.sets):
            given = _along(axis, along, box)
            values = given if at == 0 else np.where(np.isnan(given), values, given)
        for axis, along in self.scales:
            values = values * _along(axis, along, box)
        return values


def _along(axis: int, values: Array, box: Box) -> Array:
    shape = [1] * (len(box) + 2)
    shape[axis] = -1
    return values[box[axis]].reshape(shape)
