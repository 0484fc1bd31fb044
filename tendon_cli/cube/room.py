"""Room that a limit leaves at the rows of a table: from its columns, or worked out by the model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import Ints
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.forms import DesignLimit
from tendon_cli.model.limits import LIMITS
from tendon_cli.studies.spaces import space_of

if TYPE_CHECKING:
    from tendon_cli.cube.cube import Cube

Floats = npt.NDArray[np.float64]

_STATES_AT_ONCE = 2**18
"""Most states that are worked out at once."""


def room_left(cube: Cube, name: str, rows: Ints) -> Floats:
    """Return the room that a limit leaves at some rows, SI; positive where it is kept.

    Args:
        cube: Designs, states or choices.
        name: A limit that the study states, or that has a default.
        rows: Row numbers.

    Returns:
        Room in the shape of `rows`; NaN where there is nothing to compare.

    Raises:
        ValueError: The table has no column for the limit, and its rows are no designs or states
            that could be judged alone.
    """
    limit = LIMITS[name]
    if _has_column(cube, limit):
        values = cube.gather(rows, [limit.column])[limit.column]
    elif limit.of_design is not None and cube.kind != "choices":
        values = _of_designs(cube, limit, rows)
    elif limit.forms is not None and cube.kind == "states":
        values = _of_states(cube, limit, rows)
    else:
        raise ValueError(f"a row of {cube.kind} alone does not say what {name} leaves")
    return limit.room(values, cube.limits[name])


def _has_column(cube: Cube, limit: DesignLimit) -> bool:
    """Return True if the table has what a limit bounds; not if the two sides have a column each."""
    column = limit.column
    is_bounded_there = cube.kind != "states" or limit.of_design is not None
    return is_bounded_there and column in cube.columns and cube.with_sides(column) == [column]


def _of_designs(cube: Cube, limit: DesignLimit, rows: Ints) -> Floats:
    """Return the number of whole designs that a limit bounds, in the shape of `rows`."""
    if limit.of_design is None:
        raise TypeError(f"{limit.name} is not a limit on whole designs")
    space = space_of(cube.study)
    shape = space.shape or (1,)
    values = np.broadcast_to(limit.of_design(space.design(space.whole)), (*shape, 1, 1))
    designs = rows // _states_per_design(cube)
    return np.asarray(values[(*np.unravel_index(designs, shape), 0, 0)])


def _of_states(cube: Cube, limit: DesignLimit, rows: Ints) -> Floats:
    """Return the quantity of single states that a limit bounds, in the shape of `rows`."""
    per_design = _states_per_design(cube)
    designs, inverse = np.unique(rows // per_design, return_inverse=True)
    values = np.empty((len(designs), per_design))
    step = max(1, _STATES_AT_ONCE // per_design)
    for start in range(0, len(designs), step):
        part = slice(start, start + step)
        values[part] = _state_values(cube, limit, designs[part])
    return np.asarray(values[inverse.reshape(rows.shape), rows % per_design])


def _state_values(cube: Cube, limit: DesignLimit, designs: Ints) -> Floats:
    """Return the quantity that a limit bounds in all states of some designs, (designs, states)."""
    study = cube.study
    angles = study.angles.reshape(1, -1)
    state = State.of(_designs_at(cube, designs), angles, study.flexion)
    speed = np.nan if study.motion.speed is None else study.motion.speed.single
    values = limit.value(state, speed)
    shape = (len(designs), *np.broadcast_shapes(angles.shape, study.flexion.shape))
    return np.broadcast_to(values, shape).reshape(len(designs), -1)


def _designs_at(cube: Cube, designs: Ints) -> Design:
    """Return designs by number, along one axis before those of directions and angles."""
    from tendon_cli.model.motor import select_points  # only states pay for its import

    space = space_of(cube.study)
    shape = space.shape or (1,)
    places = np.unravel_index(designs, shape)
    return select_points(space.design(space.whole), (*shape, 1, 1), places)


def _states_per_design(cube: Cube) -> int:
    """Return the rows of each design: 1 in a table of designs."""
    if cube.kind != "states":
        return 1
    study = cube.study
    return int(np.prod(np.broadcast_shapes((1, len(study.angles)), study.flexion.shape)))
