"""The axes that a study spans, as its tables and its figures know them, and positions chosen evenly on them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tendon_cli.space.axis import Axis
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import Study

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


def axes_of(study: Study, kind: str) -> tuple[Axis, ...]:
    """The axes that a study spans in a table of designs, states or choices, slowest first."""
    space = space_of(study)
    if kind == "choices":
        return space.unset().choices.axes
    if kind == "designs":
        return space.axes
    if study.trajectory is not None:
        return (*space.axes, Axis(TIME, TIME, {TIME: study.trajectory.time}))
    angles, key = study.motion.elbow_angle, "motion.elbow_angle"
    angle = Axis(key, ANGLE, {key: study.angles}, is_log=getattr(angles.source, "log", False))
    return (*space.axes, Axis(DIRECTION, DIRECTION, {}, study.motion.direction), angle)
