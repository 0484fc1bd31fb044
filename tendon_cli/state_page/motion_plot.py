"""Panels of a motor's figure along a motion in time: torque over time and against speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli.figures.backend import Axes, Line2D
from tendon_cli.figures.motion_marks import (
    band_key,
    cell_edges,
    draw_band,
    ends_key,
    hatch_ends,
    shade_turning,
    turning_key,
)
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.moving import Moving

MOTOR_STYLE: dict[str, Any] = {"color": OKABE_ITO[0]}
"""Style of the motor along a motion in time."""
_JOINT: dict[str, Any] = {"color": FAINT, "linewidth": 0.9, "gid": "joint"}


@dataclass(frozen=True, eq=False)
class MotorMotion:
    """Motor of a design along a motion in time, (samples,) each."""

    time: Array
    """Times, s."""
    motor_torque: Array
    """Torque of the motor, N m."""
    other_torque: Array
    """Torque with friction the other way while the sheath turns, N m; NaN elsewhere."""
    joint_torque: Array
    """Torque that the joint asks for, N m."""
    motor_speed: Array
    """Speed of the motor, rad/s; NaN where slack passes from side to side."""
    turning: Flags
    """True where the sheath turns."""
    is_at_end: Flags
    """True at the ends of the record."""

    @classmethod
    def of(cls, moving: Moving) -> MotorMotion:
        """Evaluate a single design along its trajectory."""
        trajectory = moving.trajectory

        def along(values: Any) -> Any:
            """Return values of all samples, (samples,)."""
            return np.broadcast_to(np.ravel(values), len(trajectory.time))

        sliding = moving.sliding
        turning = along(sliding.turning)
        passing = along(sliding.passing)
        return cls(
            time=trajectory.time,
            motor_torque=along(moving.state.motor_torque),
            other_torque=np.where(turning, along(sliding.other_torque), np.nan),
            joint_torque=along(moving.state.elbow_torque),
            motor_speed=np.where(passing, np.nan, along(moving.motor_rates.spool_speed)),
            turning=turning,
            is_at_end=trajectory.is_at_end,
        )

    @property
    def speed_and_torque(self) -> tuple[Array, Array]:
        """Speeds, rad/s, and torques, N m, of the samples that count; NaN for the others."""
        return np.where(self.counts, self.motor_speed, np.nan), self.motor_torque

    @property
    def counts(self) -> Flags:
        """True for the samples that count in peaks."""
        return ~self.is_at_end


def draw_torque_over_time(axes: Axes, motion: MotorMotion, torque_limit: float | None) -> None:
    """Draw the torque of motor and joint over time, with turns, their range and the record's ends.

    Args:
        axes: The panel.
        motion: The motor along the motion.
        torque_limit: Largest torque of the motor that the study allows, N m; None without a limit.
    """
    edges = cell_edges(motion.time)
    shade_turning(axes, motion.turning & motion.counts, edges)
    hatch_ends(axes, motion.is_at_end, edges)
    axes.plot(motion.time, motion.joint_torque, **_JOINT)
    axes.plot(motion.time, motion.motor_torque, gid="curve", **MOTOR_STYLE)
    other = np.where(motion.counts, motion.other_torque, np.nan)
    draw_band(axes, motion.time, motion.motor_torque, other, MOTOR_STYLE["color"])
    axes.axhline(0.0, color=FAINT, linewidth=0.5)
    if torque_limit is not None:
        for sign in (1.0, -1.0):
            axes.axhline(sign * torque_limit, **limit_style())
    axes.set_xlim(motion.time[0], motion.time[-1])
    axes.set(title="Torque over time", xlabel="time (s)")


def limit_style() -> dict[str, Any]:
    """Return the style of a line that shows a limit of the motor."""
    return {"color": INK, "linewidth": 0.8, "linestyle": (0, (1.0, 1.2)), "gid": "limit"}


def motion_key(motion: MotorMotion) -> list[Any]:
    """Return the entries of the key of a figure along a motion in time."""
    key: list[Any] = [
        Line2D([], [], label="motor", color=MOTOR_STYLE["color"]),
        Line2D([], [], label="joint", color=_JOINT["color"], linewidth=_JOINT["linewidth"]),
    ]
    if (motion.turning & motion.counts).any():
        key += [turning_key(), band_key()]
    return [*key, ends_key()]
