"""What both checks share; and which rows two runs have in common, if their studies may be compared at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.cube.axes import Ints
from tendon_cli.cube.cube import Cube
from tendon_cli.engine.records import differences
from tendon_cli.errors import UsageError
from tendon_cli.space.axis import Axis
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.schema import key_words
from tendon_cli.studies.study import Study, keys
from tendon_cli.tables.read import TableFiles, open_table
from tendon_cli.units import counted, shorten

_NOT_ASKED = ("name", "title", "output", "figure")
"""What a study says that changes no number."""


WORST = 10
"""How many breaches or flips are listed."""


@dataclass(frozen=True)
class Checked:
    """What came of it."""

    holds: bool
    text: str
    record: dict[str, Any]


def designs_in(folder: Path, record: Mapping[str, Any]) -> TableFiles:
    """The designs of a recorded run; raises UsageError, InputError."""
    if "designs" not in record["study"]["output"]["tables"]:
        hint = '[output] tables needs "designs"'
        raise UsageError("the run has no table of designs to check", where=str(folder), hint=hint)
    return open_table(folder / "designs.parquet")


@dataclass(frozen=True)
class Shared:
    """Rows that both tables have: positions on the axes of either, in the same order."""

    axes: tuple[Axis, ...]
    """Those that both have, slowest first."""
    here: Mapping[str, Ints]
    there: Mapping[str, Ints]
    left_out: Mapping[str, str] = field(default_factory=dict)
    """By the key of an axis, which of its values only one of them has."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of common values on each axis."""
        return tuple(len(self.here[axis.column]) for axis in self.axes)

    def where(self, row: int) -> dict[str, float | str]:
        """A common row by its axes."""
        place: dict[str, float | str] = {}
        for axis, at in zip(self.axes, np.unravel_index(row, self.shape), strict=True):
            value = axis.values[self.here[axis.column][at]]
            place[axis.column] = str(value) if axis.is_text else float(value)
        return place


def check_studies(ours: Study, theirs: Study, apart: Sequence[str]) -> None:
    """Raises UsageError where two studies differ in more than the values of axes and the keys `apart`."""
    known = {key.rsplit(".", depth)[0] for key in key_words() for depth in range(key.count(".") + 1)}
    if unknown := [key for key in apart if key not in known.union(Study.model_fields)]:
        hint = nearest(unknown[0], known) or "`tendon schema` lists every key"
        raise UsageError(f'a study has no key "{shorten(unknown[0])}"', where="--except", hint=hint)
    varied = {*ours.axes, *theirs.axes, "motion.elbow_angle", "motion.direction", "cases", *_NOT_ASKED, *apart}
    lines = [
        line
        for line in differences(theirs.document(), ours.document())
        if not any(f"{line.partition(' ')[0]}.".startswith(f"{key}.") for key in varied)
    ]
    if lines:
        hint = f"--except {lines[0].partition(' ')[0]} compares them all the same"
        raise UsageError(f"the baseline is of another study: {'; '.join(lines[:4])}", hint=hint)


def shared_rows(here: Cube, there: Cube, ours: Study, theirs: Study) -> Shared:
    """What two tables have in common, by the values of their axes; raises UsageError where that is nothing."""
    by_key = {axis.key: axis for axis in there.axes}
    at_here, at_there, axes, left_out = {}, {}, [], {}
    for axis in here.axes:
        other = by_key.pop(axis.key, None)
        if other is None:
            at_here[axis.column] = _single(axis, theirs)
        else:
            axes.append(axis)
            at_here[axis.column], at_there[other.column] = _common(axis, other)
        only = [axis.length - len(at_here[axis.column]), other.length - len(at_here[axis.column]) if other else 0]
        left_out[axis.key] = _only(axis, *only)
    for axis in by_key.values():
        at_there[axis.column] = _single(axis, ours)
        left_out[axis.key] = _only(axis, 0, axis.length - 1)
    return Shared(tuple(axes), at_here, at_there, {key: text for key, text in left_out.items() if text})


def _only(axis: Axis, here: int, there: int) -> str:
    """Which values of an axis one of the runs has alone; empty if both have the same."""
    parts = [f"{counted(here, 'value')} in this run only"] if here else []
    parts += [f"{counted(there, 'value')} in the baseline only"] if there else []
    return f"{axis.key}: {', '.join(parts)}" if parts else ""


def _common(axis: Axis, other: Axis) -> tuple[Ints, Ints]:
    places = {_token(value): at for at, value in enumerate(other.values)}
    pairs = [(at, places[_token(value)]) for at, value in enumerate(axis.values) if _token(value) in places]
    if not pairs:
        raise UsageError(f"the runs have no value of {axis.key} in common", hint="runs are compared by axis values")
    first, second = zip(*pairs, strict=True)
    return np.array(first, dtype=np.int64), np.array(second, dtype=np.int64)


def _single(axis: Axis, other: Study) -> Ints:
    """Where an axis has the one value that the other run has of it."""
    known = keys().get(axis.key)
    value = other.numbers[axis.key].single if known and axis.key in other.numbers else None
    places = [at for at, each in enumerate(axis.values) if value is not None and _token(each) == _token(value)]
    if places or len(axis.values) == 1:
        return np.array(places[:1] or [0], dtype=np.int64)
    raise UsageError(f"only one of the runs has the axis {axis.key}, and the other's value is not on it")


def _token(value: Any) -> str:
    return value if isinstance(value, str) else f"{float(value):.12g}"
