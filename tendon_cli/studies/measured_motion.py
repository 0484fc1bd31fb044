"""A motion in time as measured: on equal steps, without noise, with its derivatives and the direction of friction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tendon_cli.errors import Fault
from tendon_cli.model.kinematics import Array
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.studies.angle_curves import CurveTable
from tendon_cli.units import shorten

CUTOFF, REVERSAL = 6.0, math.radians(1.0)
"""Hz and rad, where a study says nothing: voluntary motion of the elbow lies below, and noise does not come back."""
_ORDER, _LARGEST_GAP = 2, 5.0


def sampled(time: Array) -> Array:
    """Equal steps from the first time to the last, as long as the median step."""
    return np.linspace(
        time[0], time[-1], round((time[-1] - time[0]) / float(np.median(np.diff(time)))) + 1
    )


def trajectory_of(motion: Any) -> Trajectory | None:
    """The trajectory of a study's `[motion]`, smoothed; None without one whose rows are known.

    A Butterworth low-pass of second order goes over the angles forward and back, so that nothing is late; derivatives
    are central differences of what it leaves.
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
    derivatives = [angle]
    for _ in range(3):
        derivatives.append(np.gradient(derivatives[-1], step))
    reversal = REVERSAL if motion.reversal is None else float(motion.reversal.single)
    return Trajectory(time, angle, np.array(derivatives[1:]), reversal)


def at_times(trajectory: Trajectory, time: Array) -> Trajectory:
    """The same motion at other times between its first and its last, by cubic splines through its samples."""
    from scipy.interpolate import CubicSpline  # only what looks between samples pays for its import

    through = CubicSpline(trajectory.time, [trajectory.angle, *trajectory.derivatives], axis=1)
    angle, *derivatives = through(time)
    return Trajectory(time, angle, np.array(derivatives), trajectory.reversal)


def cutoff_of(motion: Any) -> float:
    """The cutoff of the low-pass, Hz."""
    return CUTOFF if motion.cutoff is None else float(motion.cutoff.single)


def trajectory_fault(motion: Any) -> Fault | None:
    """A cutoff that the samples of a trajectory cannot have."""
    if not isinstance(motion.trajectory, CurveTable):
        return None
    time = sampled(np.array(motion.trajectory.columns["time"]))
    fastest = 0.5 / float(time[1] - time[0])
    if cutoff_of(motion) < fastest:
        return None
    problem = f"is {cutoff_of(motion):.4g} Hz, expected less than {fastest:.4g} Hz, half the samples per second"
    return Fault("motion.cutoff", problem, "half of that at most leaves something to smooth")


def facts_of(motion: Any, where: str) -> dict[str, Any]:
    """What is noted of a trajectory's file: how it was smoothed, what that took, and gaps that were bridged."""
    trajectory, table = trajectory_of(motion), motion.trajectory
    if trajectory is None:
        return {}
    time, steps = np.array(table.columns["time"]), np.diff(table.columns["time"])
    off = np.degrees(
        np.std(np.interp(trajectory.time, time, table.columns["angle"]) - trajectory.angle)
    )
    rate = 1.0 / float(trajectory.time[1] - trajectory.time[0])
    note = (
        f"{shorten(where, 200)}: {len(time):,} samples at {rate:.4g} Hz, low-pass of {cutoff_of(motion):.4g} Hz "
        f"(Butterworth, second order, forward and back), which takes {off:.2g} deg (rms); the largest speed is "
        f"{np.degrees(np.abs(trajectory.speed).max()):.4g} deg/s, the largest acceleration "
        f"{np.abs(trajectory.acceleration).max():.4g} rad/s²"
    )
    gap = int(np.argmax(steps))
    warnings = []
    if steps[gap] > _LARGEST_GAP * np.median(steps):
        warnings = [
            f"{where}: no samples from {time[gap]:.6g} to {time[gap + 1]:.6g} s, bridged by a straight line"
        ]
    return {"rows": len(time), "cutoff": cutoff_of(motion), "note": note, "warnings": warnings}
