"""The axes that a study spans, as its tables and its figures know them, and positions chosen evenly on them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.space.axis import CASE_AXIS, Axis
from tendon_cli.studies.contents import column_of
from tendon_cli.studies.study import keys
from tendon_cli.studies.trajectory import sampled

Ints = npt.NDArray[np.int64]

LOAD, DIRECTION, ANGLE, TIME = "load_mass", "direction", "elbow_angle", "time"


def evenly(count: int, most: int) -> Ints:
    """At most `most` of `count` positions, evenly chosen, both ends among them; of one, the middle."""
    if count <= most:
        return np.arange(count, dtype=np.int64)
    if most == 1:
        return np.array([count // 2], dtype=np.int64)
    return np.unique(np.round(np.linspace(0, count - 1, most)).astype(np.int64))


def thinned(lengths: Sequence[int], most: int) -> list[Ints]:
    """Positions on each axis, evenly chosen with both ends, so that their product is at most `most`."""
    kept = list(lengths)
    while math.prod(kept) > most:
        longest = max(range(len(kept)), key=lambda axis: kept[axis])
        kept[longest] = max(2, math.ceil(kept[longest] * 0.75)) if kept[longest] > 2 else 1
    return [
        evenly(length, count) if count > 1 else np.zeros(1, dtype=np.int64)
        for length, count in zip(lengths, kept, strict=True)
    ]


def axes_of(
    record: Mapping[str, Any], kind: str, columns: Mapping[str, object], named: Callable[[str], Sequence[str]]
) -> tuple[Axis, ...]:
    """The axes that a recorded study spans, slowest first; `named` gives the names of those that no number gives."""
    study, axes = record["study"], list[Axis]()
    moves = (TIME,) if "trajectory" in study["motion"] else (DIRECTION, "motion.elbow_angle")
    for key in (*record["axes"], *(moves if kind == "states" else ())):
        if key == TIME:
            axes.append(Axis(key, TIME, {key: sampled(np.array(study["motion"]["trajectory"]["time"]))}))
            continue
        column = next(name for name in (column_of(key), key.rpartition(".")[2]) if name in columns)
        if key in keys():
            values, is_log = _values(study, key)
            axes.append(Axis(key, column, {key: values}, is_log=is_log))
        else:
            axes.append(Axis(key, column, {}, tuple(_names(study, key) or named(key))))
    return tuple(axes)


def _names(study: Mapping[str, Any], key: str) -> list[str]:
    """The names along an axis, if the study says them."""
    if key == DIRECTION:
        return [str(way) for way in study["motion"]["direction"]]
    if key == CASE_AXIS:
        return [str(case["name"]) for case in study["cases"]]
    return [str(word) for word in _given(study, key)] if "." in key else []


def _given(study: Mapping[str, Any], key: str) -> Any:
    """What a study says at a dotted key."""
    for name in key.split("."):
        study = study[name]
    return study


def _values(study: Mapping[str, Any], key: str) -> tuple[npt.NDArray[np.float64], bool]:
    """The values of an axis in SI, and whether they are spaced by factors."""
    given = _given(study, key)
    values = keys()[key].number.read(given)
    if values is None:
        raise ValueError(key)
    return values.array, isinstance(given, Mapping) and given.get("spacing") == "log"
