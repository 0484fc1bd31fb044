"""The same cases answered by tendon, all in one call, under the names of the engine's answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model import actuator, statics
from tendon_cli.model.design import Design, Limb, Side
from tendon_cli.model.kinematics import Anchors
from verification.cases import Case, Line

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class ToolAnswers:
    """Answers of tendon, one entry per case."""

    values: dict[str, Array]
    """Values by the names of `rig.Answer`; NaN where tendon leaves a value undetermined."""
    status: npt.NDArray[np.int8]
    """Index into `statics.STATUS_NAMES`."""


def answers(cases: list[Case]) -> ToolAnswers:
    """Evaluate the cases as one array of unilateral designs without friction."""
    arm = Limb(
        joint=Anchors(**_columns(cases, "a1", "b1", "a2", "b2", "elbow_radius", "from_initial")),
        **_columns(cases, "forearm_mass", "forearm_com", "load_distance", "upper_arm_angle"),
    )
    design = Design(
        arm=arm,
        flexor=_side([case.flexor for case in cases]),
        extensor=_side([case.extensor for case in cases]),
        **_columns(cases, "flexor_radius", "ratio", "load_mass"),
        unilateral=True,
    )
    state = actuator.evaluate(design, **_columns(cases, "elbow_angle", "flexion"))
    return ToolAnswers(_values(state), state.status)


def _values(state: actuator.State) -> dict[str, Array]:
    """Return the values of a state by the names of `rig.Answer`."""
    radius = state.coupling.extensor_arm
    return {
        "flexor_path": state.motion.flexor_path,
        "flexor_moment_arm": state.motion.flexor_moment_arm,
        "extensor_travel": state.motion.extensor_travel,
        "extensor_moment_arm": np.asarray(radius),
        "elbow_torque": state.elbow_torque,
        "flexor_tension": state.balance.flexor,
        "extensor_tension": state.balance.extensor,
        "loose": state.balance.loose,
        "flexor_slack": state.flexor_slack,
        "extensor_slack": state.extensor_slack,
        "spool_angle": state.spool_angle,
        "motor_torque": state.motor_torque,
        "elbow_stiffness": state.elbow_stiffness,
    }


def _side(lines: list[Line]) -> Side:
    """Return the lines of one side of all cases, without friction."""
    names = ("bend_angle", "length", "diameter", "youngs_modulus", "spring_stiffness", "pretension")
    return Side(friction=0.0, **_columns(lines, *names))


def _columns(rows: list[Case] | list[Line], *names: str) -> dict[str, Any]:
    """Return some numbers of all rows as arrays, by name."""
    return {name: np.array([getattr(row, name) for row in rows]) for name in names}


def side_is_slack(
    status: npt.NDArray[np.int8],
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Return masks of the states in which flexor and extensor are slack."""
    both = status == statics.BOTH_SLACK
    return (status == statics.FLEXOR_SLACK) | both, (status == statics.EXTENSOR_SLACK) | both
