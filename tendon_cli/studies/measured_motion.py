"""A measured motion in time: on equal steps, without noise, with derivatives and direction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tendon_cli.errors import Fault
from tendon_cli.model.kinematics import Array
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.studies.angle_curves import CurveTable, task_note
from tendon_cli.units import shorten

CUTOFF = 6.0
"""Cutoff of the low-pass if a study states none, Hz: voluntary motion of the elbow lies below."""
REVERSAL = math.radians(1.0)
"""Smallest turn back that counts as a reversal if a study states none, rad: noise is smaller."""
_ORDER = 2  # of the low-pass
_MOST_PARTS = 50
"""Most parts of a step of the motion in which a torque over time is smoothed."""
_ROUNDING = 1e-6  # of a ratio of steps
_LARGEST_GAP = 5.0  # median steps; a longer one between samples is a warning


def sampled(time: Array) -> Array:
    """Return times in equal steps of about the median step, from the first to the last, s."""
    median = float(np.median(np.diff(time)))
    steps = round((time[-1] - time[0]) / median)
    return np.linspace(time[0], time[-1], steps + 1)


def trajectory_of(motion: Any) -> Trajectory | None:
    """Return the trajectory of a study's `[motion]`, smoothed.

    Return None if there is no trajectory, or if its file has not been read yet.

    A Butterworth low-pass of second order filters the angles forward and backward, so that it adds
    no delay; derivatives are central differences of the filtered angles.
    """
    table = motion.trajectory
    if not isinstance(table, CurveTable):
        return None
    from scipy import signal  # only a trajectory pays for its import

    measured = np.array(table.columns["time"])
    time = sampled(measured)
    step = float(time[1] - time[0])
    low_pass = signal.butter(_ORDER, cutoff_of(motion), fs=1.0 / step)
    angle = signal.filtfilt(*low_pass, np.interp(time, measured, table.columns["angle"]))
    speed = np.gradient(angle, step)
    acceleration = np.gradient(speed, step)
    jerk = np.gradient(acceleration, step)
    reversal = REVERSAL if motion.reversal is None else float(motion.reversal.single)
    return Trajectory(time, angle, np.array([speed, acceleration, jerk]), reversal)


def torque_at_samples(task: CurveTable, time: Array, cutoff: float) -> Array:
    """Return the torque of a task at the samples of a motion (K,), smoothed as its angles are, N m.

    The torque is a straight line between its rows. It is smoothed on steps at least as short as its
    own, so that a force plate that is read faster than the joint adds nothing false, and keeps its
    first and last value beyond them.

    Args:
        task: The torque over time, on the clock of the motion.
        time: Equally spaced times of the samples, (K,), s.
        cutoff: Cutoff of the low-pass, Hz.
    """
    from scipy import signal  # only a torque over time pays for its import

    step = float(time[1] - time[0])
    own_step = float(np.median(np.diff(task.times)))
    parts = min(max(1, math.ceil(step / own_step - _ROUNDING)), _MOST_PARTS)
    fine = np.linspace(time[0], time[-1], parts * (len(time) - 1) + 1)
    torque = np.interp(fine, task.times, task.columns["torque"])
    low_pass = signal.butter(_ORDER, cutoff, fs=parts / step)
    return np.asarray(signal.filtfilt(*low_pass, torque)[::parts])


def at_times(trajectory: Trajectory, time: Array) -> Trajectory:
    """Return the same motion at other times, by cubic splines through its samples.

    Args:
        trajectory: The motion.
        time: Times between its first and its last, s.
    """
    from scipy.interpolate import CubicSpline  # only times between samples pay for its import

    through = CubicSpline(trajectory.time, [trajectory.angle, *trajectory.derivatives], axis=1)
    angle, *derivatives = through(time)
    return Trajectory(time, angle, np.array(derivatives), trajectory.reversal)


def cutoff_of(motion: Any) -> float:
    """Return the cutoff of the low-pass, Hz."""
    return CUTOFF if motion.cutoff is None else float(motion.cutoff.single)


def trajectory_fault(motion: Any) -> Fault | None:
    """Return a fault if the samples of a trajectory are too far apart for the cutoff."""
    if not isinstance(motion.trajectory, CurveTable):
        return None
    time = sampled(np.array(motion.trajectory.columns["time"]))
    fastest = 0.5 / float(time[1] - time[0])
    cutoff = cutoff_of(motion)
    if cutoff < fastest:
        return None
    problem = (
        f"is {cutoff:.4g} Hz, expected less than {fastest:.4g} Hz, half the samples per second"
    )
    return Fault(
        "motion.cutoff",
        problem,
        "choose at most half of that, so that there is something to smooth",
    )


def facts_of(motion: Any, where: str) -> dict[str, Any]:
    """Return facts on a trajectory's file: rows, smoothing, its effect, and gaps that were bridged.

    Args:
        motion: The study's `[motion]`.
        where: Name of the file.
    """
    trajectory = trajectory_of(motion)
    if trajectory is None:
        return {}
    table = motion.trajectory
    time = np.array(table.columns["time"])
    steps = np.diff(table.columns["time"])
    cutoff = cutoff_of(motion)
    measured = np.interp(trajectory.time, time, table.columns["angle"])
    residual = np.degrees(np.std(measured - trajectory.angle))
    rate = 1.0 / float(trajectory.time[1] - trajectory.time[0])
    speed = np.degrees(np.abs(trajectory.speed).max())
    acceleration = np.abs(trajectory.acceleration).max()
    note = (
        f"{shorten(where, 200)}: {len(time):,} samples at {rate:.4g} Hz, low-pass of {cutoff:.4g} "
        f"Hz (Butterworth, second order, forward and back), which removes {residual:.2g} deg "
        f"(rms); the largest speed is {speed:.4g} deg/s, "
        f"the largest acceleration {acceleration:.4g} rad/s²"
    )
    if "torque" in table.columns:
        note += f"; {task_note(table)}"
    warnings = []
    gap = int(np.argmax(steps))
    if steps[gap] > _LARGEST_GAP * np.median(steps):
        warnings.append(
            f"{where}: no samples from {time[gap]:.6g} to {time[gap + 1]:.6g} s, bridged by a "
            "straight line"
        )
    return {"rows": len(time), "cutoff": cutoff, "note": note, "warnings": warnings}
