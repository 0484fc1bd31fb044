"""The axes that a study spans, as its tables and its figures know them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.studies.study import CASE_AXIS, keys

Ints = npt.NDArray[np.int64]

LOAD, DIRECTION, ANGLE = "load_mass", "direction", "elbow_angle"


@dataclass(frozen=True)
class RowAxis:
    """One axis of a table's rows."""

    key: str
    column: str
    values: npt.NDArray[Any] = field(compare=False)
    """In SI, or names."""
    stride: int
    """Rows from one value to the next."""
    is_log: bool

    @property
    def length(self) -> int:
        """Number of values."""
        return len(self.values)

    @property
    def is_text(self) -> bool:
        """Whether its values are names."""
        return self.values.dtype == object


def evenly(count: int, most: int) -> Ints:
    """At most `most` of `count` positions, evenly chosen, both ends among them; of one, the middle."""
    if count <= most:
        return np.arange(count, dtype=np.int64)
    if most == 1:
        return np.array([count // 2], dtype=np.int64)
    return np.unique(np.round(np.linspace(0, count - 1, most)).astype(np.int64))


def axes_of(
    record: Mapping[str, Any], kind: str, columns: Mapping[str, object], linked: Callable[[str], Sequence[str]]
) -> tuple[RowAxis, ...]:
    """The axes that a recorded study spans, slowest first; `linked` gives the names of those that no number gives."""
    study = record["study"]
    names = [*record["axes"], *((DIRECTION, "motion.elbow_angle") if kind == "states" else ())]
    values = [
        _values(study, key)
        if key in keys()
        else (np.array(list(_names(study, key) or linked(key)), dtype=object), False)
        for key in names
    ]
    found: list[RowAxis] = []
    stride = 1
    for key, (array, is_log) in reversed(list(zip(names, values, strict=True))):
        known = keys()[key].column if key in keys() else key
        column = next(name for name in (known, key.rpartition(".")[2]) if name in columns)
        found.append(RowAxis(key, column, array, stride, is_log))
        stride *= len(array)
    return tuple(reversed(found))


def _names(study: Mapping[str, Any], key: str) -> list[str]:
    """The names along an axis, where the study says them."""
    if key == DIRECTION:
        return [str(way) for way in study["motion"]["direction"]]
    return [str(case["name"]) for case in study["cases"]] if key == CASE_AXIS else []


def _values(study: Mapping[str, Any], key: str) -> tuple[npt.NDArray[Any], bool]:
    """The values of an axis in SI, and whether they are spaced by factors."""
    said: Any = study
    for name in key.split("."):
        said = said[name]
    values = keys()[key].number.read(said)
    if values is None:
        raise ValueError(key)
    return values.array, isinstance(said, Mapping) and said.get("spacing") == "log"
