"""Curves of a study: which it has, how far they reach, and what is said of them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.model.kinematics import Spline
from tendon_cli.quantities import SIDES
from tendon_cli.studies.angle_curves import SIGN_OF_TASK, CurveTable
from tendon_cli.studies.parts import with_sides

FEWEST_BEYOND = 3
"""Rows of measured travels beyond the motion that keep the uncertain end of a spline away."""
_ROUNDING = 1e-9  # rad; angles that differ by less are the same


def curves_in(study: Any) -> dict[str, CurveTable]:
    """Return the curves of a study over the joint's angle or time, by dotted key.

    Those of files are among them once the files have been read.
    """
    stated = {
        "joint.torque": study.joint.torque,
        "joint.excursion": study.joint.excursion,
        "load.torque": study.load.torque,
    }
    for key, sheath in with_sides(study.sheath, "sheath").items():
        stated[f"{key}.bend_angle"] = sheath.bend_angle
    return {key: curve for key, curve in stated.items() if isinstance(curve, CurveTable)}


def curves_of(study: Any) -> dict[str, Spline]:
    """Return the splines of a study's curves, by the keys under which the model looks them up."""
    splines = {}
    for key, curve in curves_in(study).items():
        if key == "joint.excursion":
            smoothing = study.joint.smoothing
            noise = smoothing.single if smoothing is not None else 0.0
            for side in SIDES:
                splines[f"joint.{side}_excursion"] = curve.spline(side, noise)
        elif not curve.is_in_time:
            splines[key] = curve.spline([*curve.columns][1])
    return splines


def not_covered(study: Any, table: CurveTable, *, is_travel: bool) -> str | None:
    """Return the problem if a curve does not reach as far as the motion; None if it does.

    Args:
        study: The study.
        table: The curve.
        is_travel: True for travels, which are counted from the angle at which pretension is set.
    """
    if isinstance(study.motion.trajectory, str):  # not read yet
        return None
    if table.is_in_time:
        return _clock_not_covered(study.motion.trajectory, table)
    motion = "motion.elbow_angle" if study.trajectory is None else "motion.trajectory"
    asked = [(motion, study.angles.min()), (motion, study.angles.max())]
    if is_travel:
        asked += [("setting.angle", angle) for angle in study.setting.angle.extremes]
    low = table.angles[0]
    high = table.angles[-1]
    for key, angle in asked:
        if not low - _ROUNDING <= angle <= high + _ROUNDING:
            reach = f"{math.degrees(low):.6g} to {math.degrees(high):.6g} deg"
            return f"covers {reach}, but {key} needs {math.degrees(angle):.6g} deg"
    return None


def _clock_not_covered(trajectory: CurveTable | None, task: CurveTable) -> str | None:
    """Return the problem if a torque over time does not reach over the whole motion.

    A sample of the motion stands for half a step on either side, which is the tolerance. Without a
    motion in time there is no problem of the clock.
    """
    if trajectory is None:
        return None
    half_step = 0.5 * float(np.median(np.diff(trajectory.times)))
    first, last = trajectory.times[[0, -1]]
    if task.times[0] - half_step <= first and last <= task.times[-1] + half_step:
        return None
    reach = f"{task.times[0]:.6g} to {task.times[-1]:.6g} s"
    return (
        f"reaches from {reach}, but motion.trajectory from {first:.6g} to {last:.6g} s, "
        "on the same clock"
    )


def hint_to_cover(table: CurveTable) -> str:
    """Return the advice for a curve that does not reach as far as the motion."""
    if table.is_in_time:
        return "extend the torque, or shorten the motion"
    return "extend the table, or ask for fewer angles"


def task_note(columns: CurveTable) -> str:
    """Return a note on a torque over time: its range, its clock and the meaning of its sign."""
    torques = columns.columns["torque"]
    first, last = columns.times[[0, -1]]
    return (
        f"torque of a task from {min(torques):.4g} to {max(torques):.4g} N m at "
        f"{first:.4g} to {last:.4g} s, smoothed as the angle is; {SIGN_OF_TASK}"
    )


def warnings_of(study: Any, table: CurveTable, where: str) -> list[str]:
    """Return warnings on measured travels.

    States have no equilibrium where travels do not rise, and slopes are less certain if the table
    ends too soon beyond the motion.

    Args:
        study: The study.
        table: Travels of both tendons.
        where: Name of their file.

    Raises:
        InputError: The travel of a tendon falls throughout.
    """
    warnings = []
    low = study.angles.min()
    high = study.angles.max()
    for end, is_beyond in (
        (low, table.angles < low - _ROUNDING),
        (high, table.angles > high + _ROUNDING),
    ):
        if is_beyond.sum() < FEWEST_BEYOND:
            near = f"within {FEWEST_BEYOND} rows of the table's end, where slopes are less certain"
            warnings.append(f"{where}: the motion reaches {math.degrees(end):.4g} deg, {near}")
    for side in SIDES:
        slopes = table.spline(side)(table.angles, 1)
        if (slopes < 0.0).all():
            hint = f"is the sign of {side} reversed? Both travels increase with flexion"
            raise InputError(f"the travel of the {side} falls throughout", where=where, hint=hint)
        if (slopes <= 0.0).any():
            falling = np.degrees(table.angles[slopes <= 0.0])
            span = f"{falling.min():.4g} to {falling.max():.4g} deg"
            warnings.append(
                f"{where}: the {side}'s travel does not rise at {span}: no equilibrium there"
            )
    return warnings
