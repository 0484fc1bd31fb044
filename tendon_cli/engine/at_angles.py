"""States of one study at elbow angles that a program gives, as arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.engine.results import Run
from tendon_cli.engine.run import carried_out
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import UsageError
from tendon_cli.studies.load import varied_study
from tendon_cli.studies.study import Study

_MOVES = ("flexion", "extension")
_LEADING = ("design", "direction", "elbow_angle")


def states_at(study: Study, angle: npt.ArrayLike, flexion: npt.ArrayLike) -> dict[str, Any]:
    """Every result of the states at angles in rad, of the shape (axes of the study..., *shape of angle and flexion).

    Each different angle is worked out once. Raises UsageError for what is no angle, StudyError for one out of range.
    """
    try:
        angles, moves = np.broadcast_arrays(np.asarray(angle, dtype=np.float64), np.asarray(flexion, dtype=np.bool_))
    except (TypeError, ValueError) as error:
        raise UsageError(f"angle and flexion are not arrays of one shape: {error}") from None
    if not angles.size:
        raise UsageError("angle is empty, expected at least one")
    different, at = np.unique(angles, return_inverse=True)
    asked = varied_study(study, {
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
