"""The axes of a study's tables, and positions chosen evenly on them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tendon_cli.space.axis import Axis
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import Study

Ints = npt.NDArray[np.int64]

LOAD = "load_mass"
DIRECTION = "direction"
ANGLE = "elbow_angle"
TIME = "time"


def evenly_spaced(count: int, most: int) -> Ints:
    """Choose at most `most` of `count` positions evenly, with both ends.

    If `most` is 1, choose the middle.
    """
    if count <= most:
        return np.arange(count, dtype=np.int64)
    if most == 1:
        return np.array([count // 2], dtype=np.int64)
    return np.unique(np.round(np.linspace(0, count - 1, most)).astype(np.int64))


def thin_axes(lengths: Sequence[int], most: int) -> list[Ints]:
    """Choose positions on each axis evenly, so that few points are left; long axes lose most.

    Args:
        lengths: Number of values on each axis.
        most: Most points, the product of the numbers of positions.

    Returns:
        Positions on each axis, with both ends; only the first if one position is left.
    """
    counts = list(lengths)
    while math.prod(counts) > most:
        longest = max(range(len(counts)), key=lambda axis: counts[axis])
        if counts[longest] > 2:
            counts[longest] = max(2, math.ceil(counts[longest] * 0.75))
        else:
            counts[longest] = 1
    first = np.zeros(1, dtype=np.int64)
    return [
        evenly_spaced(length, count) if count > 1 else first
        for length, count in zip(lengths, counts, strict=True)
    ]


def choice_axes(study: Study) -> tuple[Axis, ...]:
    """Return the axes of a table of choices, slowest first."""
    return space_of(study).without_pretension().choices.axes


def design_axes(study: Study) -> tuple[Axis, ...]:
    """Return the axes of a table of designs, slowest first."""
    return space_of(study).axes


def state_axes(study: Study) -> tuple[Axis, ...]:
    """Return the axes of a table of states, slowest first."""
    space = space_of(study)
    if study.trajectory is not None:
        return (*space.axes, Axis(TIME, TIME, {TIME: study.trajectory.time}))
    direction = Axis(DIRECTION, DIRECTION, {}, study.motion.direction)
    key = "motion.elbow_angle"
    is_log = getattr(study.motion.elbow_angle.source, "log", False)
    angle = Axis(key, ANGLE, {key: study.angles}, is_log=is_log)
    return (*space.axes, direction, angle)
