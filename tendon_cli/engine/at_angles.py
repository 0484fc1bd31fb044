"""States of one study at elbow angles that a program gives, as arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.engine.results import Run
from tendon_cli.engine.run import carried_out
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import UsageError
from tendon_cli.studies.load import AnyStudy, any_study, varied_study

_MOVES = ("flexion", "extension")
_LEADING = ("design", "direction", "elbow_angle")


def states(design: AnyStudy, angle: npt.ArrayLike, flexion: npt.ArrayLike = True) -> dict[str, Any]:
    """The results of a study's states at elbow angles in rad, moving in flexion or extension, as arrays.

    `angle` and `flexion` broadcast against each other. Every result has their shape, after one dimension for each axis
    of the study, and SI units; `status` is text. Raises UsageError for what is no angle, StudyError for one out of
    range.

    >>> import numpy as np
    >>> import tendon_cli as tendon
    >>> results = tendon.states({}, np.radians([0.0, 45.0, 90.0]))
    >>> results["motor_torque"].round(3)
    array([2.59 , 0.392, 0.72 ])
    """
    try:
        angles, moves = np.broadcast_arrays(np.asarray(angle, dtype=np.float64), np.asarray(flexion, dtype=np.bool_))
    except (TypeError, ValueError) as error:
        raise UsageError(f"angle and flexion are not arrays of one shape: {error}") from None
    if not angles.size:
        raise UsageError("angle is empty, expected at least one")
    different, at = np.unique(angles, return_inverse=True)
    asked = varied_study(any_study(design), {
        "motion.elbow_angle": [f"{value!r} rad" for value in different.tolist()], "motion.direction": list(_MOVES),
        "output": {"tables": ["states"]},
    })  # fmt: skip
    table = carried_out(Sweep, Run, asked).table("states")
    sizes = [len(asked.numbers[key]) if key in asked.numbers else -1 for key in asked.axes]
    rows = np.where(moves, 0, 1).ravel() * len(different) + at.ravel()
    found = {}
    for name in table.column_names:
        if name not in _LEADING:
            column = table.column(name).to_pandas().to_numpy()
            by_state = column.reshape(-1, len(_MOVES) * len(different))[:, rows]
            found[name] = by_state.reshape(*(sizes or ()), *angles.shape)
    return found
