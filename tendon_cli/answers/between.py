"""What holds between the angles and loads that were taken: of the choices that an answer names."""

from __future__ import annotations

from typing import Any

import numpy as np

from tendon_cli.answers.candidates import numbers_of
from tendon_cli.answers.question import Problem
from tendon_cli.answers.solve import Solutions
from tendon_cli.model.between import end_curves
from tendon_cli.model.kinematics import Array


def curves_of(problem: Problem, choice: Solutions) -> dict[str, Any]:
    """One choice over the elbow angle (rad): what each limit asks for, N, over all conditions and both directions.

    `lower` and `upper` have by limit the least and the largest pretensions, null where it asks for nothing; `samples`
    are the study's angles. Limits on the whole motion have no curve.
    """
    lower, upper = dict[str, Array](), dict[str, Array]()
    numbers = numbers_of(problem, choice.columns)
    for _, _, design in problem.chunks(numbers, 1):
        some = end_curves(design, problem.angles, problem.flexion, problem.bounds)
        for whole, part, tighter in zip((lower, upper), some, (np.maximum, np.minimum), strict=True):
            whole |= {name: tighter(values, whole.get(name, values)) for name, values in part.items()}
    return {
        "elbow_angle": problem.angles.ravel().tolist(),
        "samples": np.unique(problem.study.angles).tolist(),
        "lower": {name: _listed(values) for name, values in lower.items()},
        "upper": {name: _listed(values) for name, values in upper.items()},
    }


def _listed(values: Array) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]
