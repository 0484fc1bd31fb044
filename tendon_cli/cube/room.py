"""Room that a limit leaves at the rows of a table: from its columns, or worked out by the model."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.forms import DesignLimit
from tendon_cli.model.kinematics import Rows
from tendon_cli.model.limits import LIMITS
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import Study

Floats = npt.NDArray[np.float64]

_STATES_AT_ONCE = 2**18
"""Most states that are worked out at once."""


def bounded_column(name: str) -> str:
    """Return the column of designs that a limit bounds."""
    return LIMITS[name].column


def has_bounded_column(name: str, kind: str) -> bool:
    """Return True if rows of a kind of table may have the column that a limit bounds."""
    return kind != "states" or LIMITS[name].of_design is not None


def sign_of(name: str) -> str:
    """Return the sign of a limit as an inequality: ≥ if it bounds from below."""
    return "≥" if LIMITS[name].from_below else "≤"


def is_default(name: str, bound: float | None) -> bool:
    """Return True if a bound is that of a study that states none; None differs between designs."""
    return bound is not None and bound == LIMITS[name].default


def bound_of(name: str, values: Floats) -> Floats:
    """Return bounds of a limit, infinite where values are NaN and so set none."""
    return LIMITS[name].bound_of(values)


def room_to(name: str, values: Floats, bound: Floats) -> Floats:
    """Return the room that values leave to the bound of a limit, negative where they break it.

    Args:
        name: The limit.
        values: What it bounds in each row, SI.
        bound: Bound of each row, SI.
    """
    return LIMITS[name].room(values, bound)


def bounded_values(study: Study, kind: str, name: str, rows: Rows) -> Floats:
    """Work out what a limit bounds at some rows of a table, as the model does.

    Args:
        study: The study.
        kind: Kind of the table: designs, states or choices.
        name: The limit.
        rows: Row numbers.

    Returns:
        Values in the shape of `rows`, SI; NaN where there is none.

    Raises:
        UsageError: A row alone does not say what the limit bounds, and the table lacks its column.
    """
    limit = LIMITS[name]
    if limit.of_design is not None and kind != "choices":
        return _of_designs(study, kind, limit, rows)
    if limit.forms is not None and kind == "states":
        return _of_states(study, limit, rows)
    raise UsageError(f'the table has no column "{limit.column}", which limits.{name} bounds')


def _of_designs(study: Study, kind: str, limit: DesignLimit, rows: Rows) -> Floats:
    """Return the number of whole designs that a limit bounds, in the shape of `rows`."""
    if limit.of_design is None:
        raise TypeError(f"{limit.name} is not a limit on whole designs")
    space = space_of(study)
    shape = space.shape or (1,)
    values = np.broadcast_to(limit.of_design(space.design(space.whole)), (*shape, 1, 1))
    designs = rows // (_states_per_design(study) if kind == "states" else 1)
    return np.asarray(values[(*np.unravel_index(designs, shape), 0, 0)])


def _of_states(study: Study, limit: DesignLimit, rows: Rows) -> Floats:
    """Return the quantity of single states that a limit bounds, in the shape of `rows`."""
    per_design = _states_per_design(study)
    designs, inverse = np.unique(rows // per_design, return_inverse=True)
    values = np.empty((len(designs), per_design))
    step = max(1, _STATES_AT_ONCE // per_design)
    for start in range(0, len(designs), step):
        part = slice(start, start + step)
        values[part] = _state_values(study, limit, designs[part])
    return np.asarray(values[inverse.reshape(rows.shape), rows % per_design])


def _state_values(study: Study, limit: DesignLimit, designs: Rows) -> Floats:
    """Return the quantity that a limit bounds in all states of some designs, (designs, states)."""
    angles = study.angles.reshape(1, -1)
    state = _states_at(study, designs)
    speed = np.nan if study.motion.speed is None else study.motion.speed.single
    values = limit.value(state, speed)
    shape = (len(designs), *np.broadcast_shapes(angles.shape, study.flexion.shape))
    return np.broadcast_to(values, shape).reshape(len(designs), -1)


def _states_at(study: Study, designs: Rows) -> State:
    """Return all states of designs by number; along a trajectory those that hold."""
    at = designs_at(study, designs)
    if study.trajectory is None:
        return State.of(at, study.angles.reshape(1, -1), study.flexion)
    from tendon_cli.model.moving import Moving  # only a study of motion pays for its import

    return Moving.of(at, study.trajectory).state


def designs_at(study: Study, designs: Rows) -> Design:
    """Return designs by number, along one axis before those of directions and angles."""
    from tendon_cli.model.motor import select_points  # only states pay for its import

    space = space_of(study)
    shape = space.shape or (1,)
    places = np.unravel_index(designs, shape)
    return select_points(space.design(space.whole), (*shape, 1, 1), places)


def _states_per_design(study: Study) -> int:
    """Return the number of states of each design."""
    return int(np.prod(np.broadcast_shapes((1, len(study.angles)), study.flexion.shape)))
