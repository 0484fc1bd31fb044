"""The axes of a study's tables, and positions chosen evenly on them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Rows
from tendon_cli.studies.contents import column_of
from tendon_cli.studies.model_words import WORDS_OF
from tendon_cli.studies.space.axis import Axis, evenly_spaced, split_side
from tendon_cli.studies.space.space import Space
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import Study

LOAD = "load_mass"
DIRECTION = "direction"
ANGLE = "elbow_angle"
TIME = "time"


def thin_axes(lengths: Sequence[int], most: int) -> list[Rows]:
    """Choose positions on each axis evenly, so that few points are left; long axes lose most.

    Args:
        lengths: Number of values on each axis.
        most: Most points, the product of the numbers of positions.

    Returns:
        Positions on each axis, with both ends; only the first if one position is left.
    """
    counts = list(lengths)
    while math.prod(counts) > max(1, most):
        longest = max(range(len(counts)), key=lambda axis: counts[axis])
        fewer = counts[longest] - 1
        counts[longest] = min(fewer, math.ceil(counts[longest] * 0.75))
    first = np.zeros(1, dtype=np.int64)
    return [
        evenly_spaced(length, count) if count > 1 else first
        for length, count in zip(lengths, counts, strict=True)
    ]


def columns_of_names(
    axes: Sequence[Axis], single: Mapping[str, Any]
) -> dict[str, tuple[Axis, Axis]]:
    """Return the columns whose numbers or words follow from one named axis alone.

    Args:
        axes: Axes of a table.
        single: Numbers that all rows share, by dotted key.

    Returns:
        The named axis, and the same axis with the values of the column in place of its names.
    """
    space = Space(tuple(axes), single)
    columns: dict[str, tuple[Axis, Axis]] = {}
    for key, number in space.set_by_names.items():
        if len(number.axes) > 1 or key in space.keys_of_sides:
            continue
        values = np.ravel(number.within(space.whole))  # (len(axis),)
        words = WORDS_OF.get(split_side(key)[0])
        names = () if words is None else tuple(words[int(value)] for value in values)
        column = column_of(key)
        columns[column] = (axes[number.axes[0]], Axis(key, column, {key: values}, names))
    return columns


def axis_values(axes: Sequence[Axis], study: Study) -> dict[str, npt.NDArray[Any]]:
    """Return the values that axes give columns, by column, in SI or as words.

    These are the columns of the axes, and those that follow from one named axis.

    Args:
        axes: Axes of a table.
        study: Its study.
    """
    of_names = columns_of_names(axes, space_of(study).single)
    values = {column: axis.values for column, (_, axis) in of_names.items()}
    return values | {axis.column: axis.values for axis in axes}


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
