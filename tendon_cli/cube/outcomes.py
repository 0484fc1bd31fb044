"""The one legend of designs, for figures and pages: what comes out, its letter and its colour."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.columns import ColumnArray

_SLACK = 1e-6
"""Tension up to which a tendon counts as slack, N; that of a slack one is 0, but for rounding."""


class Outcome(NamedTuple):
    """Outcome of a design, as legends name it."""

    label: str
    letter: str
    """Tells it apart where colours cannot."""
    colour: str


TAUT = Outcome("feasible", "F", "#0072b2")
BEYOND = Outcome("beyond a limit", "L", "#56b4e9")
UNSTABLE = Outcome("unstable", "U", "#8a9097")
EXTENSOR_SLACK = Outcome("extensor slack", "S", "#d55e00")
FLEXOR_SLACK = Outcome("flexor slack", "Sf", "#a3123f")
NO_EQUILIBRIUM = Outcome("no equilibrium", "N", "#d9dbdd")
OUTCOMES = (TAUT, BEYOND, UNSTABLE, EXTENSOR_SLACK, FLEXOR_SLACK, NO_EQUILIBRIUM)
"""Outcomes of a design, the best first."""
OF_OUTCOMES = (
    "feasible",
    "stable",
    "taut",
    "min_flexor_tension",
    "min_extensor_tension",
    "slack_fraction",
    "min_elbow_stiffness",
)
"""Columns of designs that `outcomes` reads, as far as the table has them."""


def outcomes(columns: Mapping[str, ColumnArray]) -> npt.NDArray[np.int64]:
    """Return the outcome of each design, as its place in OUTCOMES.

    A design in which both tendons go slack counts as one with a slack extensor.
    """
    worst = np.where(columns["feasible"] == 1.0, 0, 1)
    worst = np.where(columns["stable"] == 1.0, worst, 2)
    is_flexor = is_flexor_slack(columns)
    worst = np.where(columns["taut"] == 1.0, worst, np.where(is_flexor, 4, 3))
    is_lost = np.isnan(columns["min_elbow_stiffness"]) & (columns["slack_fraction"] > 0.0)
    return np.where(is_lost, 5, worst)


def is_flexor_slack(columns: Mapping[str, ColumnArray]) -> npt.NDArray[np.bool_]:
    """Return True where the flexor alone goes slack."""
    flexor: Any = columns["min_flexor_tension"]
    extensor: Any = columns["min_extensor_tension"]
    return np.asarray((flexor <= _SLACK) & (extensor > _SLACK))
