"""A measured motion in time: on equal steps, without noise, with derivatives."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tendon_cli.errors import Fault
from tendon_cli.model.kinematics import Array
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.studies.angle_curves import CurveTable
from tendon_cli.studies.study_curves import task_note
from tendon_cli.units import shorten

CUTOFF = 6.0
"""Cutoff of the low-pass if a study states none, Hz: voluntary motion of the elbow lies below."""
ENDS = 2.0
"""Time at either end of a record, times the cutoff, in which the derivatives of smoothed angles are
off: with 1 the largest power is off by up to 45 %, with 1.5 by 4 %."""
SHORTEST = 6.0
"""Least length of a record, times the cutoff: a third of it then counts."""
LOWER = 0.7
"""Share of the cutoff at which peaks are worked out again, to show what it decides."""
_ORDER = 2  # of the low-pass
_MOST_PARTS = 50
"""Most parts of a step of the motion in which a torque over time is smoothed."""
_ROUNDING = 1e-6  # of a ratio of steps
_SAME_LENGTH = 1e-9  # share of a record's length, for rounding
_LARGEST_GAP = 5.0  # median steps; a longer one between samples is a warning


def sampled(time: Array) -> Array:
    """Return times in equal steps of about the median step, from the first to the last, s."""
    median = float(np.median(np.diff(time)))
    steps = round((time[-1] - time[0]) / median)
    return np.linspace(time[0], time[-1], steps + 1)


def trajectory_of(motion: Any, task: Any = None, share: float = 1.0) -> Trajectory | None:
    """Return the trajectory of a study's `[motion]`, smoothed, with the torque of its task.

    Return None if there is no trajectory, or if its file has not been read yet.

    Args:
        motion: The study's `[motion]`.
        task: The study's `load.torque`; it counts here if it is over time.
        share: Share of the cutoff at which the motion is smoothed; what counts stays the same.
    """
    table = motion.trajectory
    if not isinstance(table, CurveTable):
        return None
    measured = np.array(table.columns["time"])
    time = sampled(measured)
    cutoff = cutoff_of(motion)
    angles = np.interp(time, measured, table.columns["angle"])
    angle, *derivatives = smoothed(time, angles, share * cutoff, derivatives=3)
    torque = None
    if isinstance(task, CurveTable) and task.is_in_time:
        torque = task_at_samples(task, time, share * cutoff)
    return Trajectory(time, angle, np.array(derivatives), task=torque, margin=ENDS / cutoff)


def smoothed(time: Array, values: Array, cutoff: float, *, derivatives: int) -> list[Array]:
    """Return smoothed values and their first derivatives by time.

    A Butterworth low-pass of second order filters forward and backward, so that it adds no delay;
    derivatives are central differences of the filtered values, of fourth order: those of second
    order lose 0.8 % of the third derivative of 2 Hz sampled at 100 Hz, and near the frequency at
    which inertia balances the elbow's stiffness the motor's speed is off by several times that.

    Args:
        time: Times in equal steps, s.
        values: Values at these times.
        cutoff: Cutoff of the low-pass, Hz.
        derivatives: Number of derivatives.
    """
    from scipy import signal  # only a trajectory pays for its import

    step = float(time[1] - time[0])
    low_pass = signal.butter(_ORDER, cutoff, fs=1.0 / step)
    signals = [np.asarray(signal.filtfilt(*low_pass, values))]
    for _ in range(derivatives):
        signals.append(_difference(signals[-1], step))
    return signals


def _difference(values: Array, step: float) -> Array:
    """Return the central differences of values, of fourth order but for two values at either end.

    Args:
        values: Values in equal steps.
        step: The step.
    """
    slopes = np.gradient(values, step)
    narrow = values[3:-1] - values[1:-3]
    wide = values[4:] - values[:-4]
    slopes[2:-2] = (8.0 * narrow - wide) / (12.0 * step)
    return np.asarray(slopes)


def task_at_samples(task: CurveTable, time: Array, cutoff: float) -> Array:
    """Return the torque of a task and its rate at the samples of a motion, (2, K), N m and N m/s.

    The torque is a straight line between its rows, and smoothed as the angles are. It is smoothed
    on steps as short as its own, so that a force plate that is read faster than the joint adds
    nothing false; beyond its rows it keeps the value of the first or the last.

    Args:
        task: The torque over time, on the clock of the motion.
        time: Equally spaced times of the samples, (K,), s.
        cutoff: Cutoff of the low-pass, Hz.
    """
    step = float(time[1] - time[0])
    own_step = float(np.median(np.diff(task.times)))
    parts = min(max(1, math.ceil(step / own_step - _ROUNDING)), _MOST_PARTS)
    fine = np.linspace(time[0], time[-1], parts * (len(time) - 1) + 1)
    torque = np.interp(fine, task.times, task.columns["torque"])
    signals = smoothed(fine, torque, cutoff, derivatives=1)
    return np.array([signal[::parts] for signal in signals])


def at_times(trajectory: Trajectory, time: Array) -> Trajectory:
    """Return the same motion at other times, by cubic splines through its samples.

    Args:
        trajectory: The motion.
        time: Times between its first and its last, s.
    """
    from scipy.interpolate import CubicSpline  # only times between samples pay for its import

    task = np.empty((0, len(trajectory.time))) if trajectory.task is None else trajectory.task
    signals = [trajectory.angle, *trajectory.derivatives, *task]
    values = CubicSpline(trajectory.time, signals, axis=1)(time)
    return Trajectory(
        time,
        values[0],
        values[1:4],
        task=values[4:] if trajectory.task is not None else None,
        margin=trajectory.margin,
    )


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


def short_record(motion: Any) -> Fault | None:
    """Return a fault if the record of a trajectory is too short for the cutoff."""
    if not isinstance(motion.trajectory, CurveTable):
        return None
    time = motion.trajectory.columns["time"]
    cutoff = cutoff_of(motion)
    length = float(time[-1] - time[0])
    shortest = SHORTEST / cutoff
    if length >= shortest * (1.0 - _SAME_LENGTH):
        return None
    problem = (
        f"lasts {length:.4g} s, expected at least {shortest:.4g} s, six periods of the cutoff of "
        f"{cutoff:.4g} Hz: smoothing spoils {ENDS / cutoff:.3g} s at either end"
    )
    hint = (
        "record longer, before and after the motion (standing still will do), or raise "
        f"motion.cutoff to {SHORTEST / length:.3g} Hz at least"
    )
    return Fault("motion.trajectory", problem, hint)


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
    counted = trajectory.counted
    speed = np.degrees(np.abs(trajectory.speed[counted]).max())
    acceleration = np.abs(trajectory.acceleration[counted]).max()
    note = (
        f"{shorten(where, 200)}: {len(time):,} samples at {rate:.4g} Hz, low-pass of {cutoff:.4g} "
        f"Hz (Butterworth, second order, forward and back), which removes {residual:.2g} deg "
        f"(rms); the first and last {trajectory.margin:.3g} s do not count; between them the "
        f"largest speed is {speed:.4g} deg/s, the largest acceleration {acceleration:.4g} rad/s²"
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
