"""Motions in closed form, and the suit and the values against which they were checked.

The values are those of an independent rig of 96 elastic links, and of another implementation of the
same rule, both built from descriptions alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.model.moving import Moving, motion_columns
from tendon_cli.model.trajectory import Trajectory

from .designs import baseline, design

TURN = 2.0 * np.pi
INERTIA = 0.08  # kg m²


@dataclass(frozen=True)
class Wave:
    """Motion θ = middle - amplitude cos 2πft, with a task of torque sin 2πgt."""

    middle: float  # deg
    amplitude: float  # deg
    frequency: float  # Hz
    task: float = 0.0  # N m
    task_frequency: float = 0.0  # Hz

    @property
    def fastest(self):
        """Highest frequency of the motion, Hz."""
        return max(self.frequency, self.task_frequency)

    def angle(self, time):
        """Return the angle and its first three derivatives, (4, times)."""
        pulse = TURN * self.frequency
        sine = np.sin(pulse * time)
        cosine = np.cos(pulse * time)
        scaled = [-cosine, pulse * sine, pulse**2 * cosine, -(pulse**3) * sine]
        moved = np.radians(self.amplitude) * np.array(scaled)
        moved[0] += np.radians(self.middle)
        return moved

    def torque(self, time):
        """Return the task and its rate, (2, times), N m and N m/s."""
        pulse = TURN * self.task_frequency
        return self.task * np.array([np.sin(pulse * time), pulse * np.cos(pulse * time)])

    def trajectory(self, time, margin=0.0):
        """Return the motion with exact derivatives at times."""
        angle, *derivatives = self.angle(time)
        task = self.torque(time) if self.task else None
        return Trajectory(time, angle, np.array(derivatives), task=task, margin=margin)


@dataclass(frozen=True)
class Checked:
    """Values of a cycle: torques in N m, rad/s, W, J, and the share against the joint."""

    wave: Wave
    peak_motor_torque: float
    rms_motor_torque: float
    peak_motor_speed: float
    peak_motor_power: float
    peak_braking_power: float
    friction_loss: float
    turn_loss: float
    opposite_fraction: float
    turns: tuple[float, ...]


CHECKED = {
    "A": Checked(
        Wave(45, 35, 0.75), 7.527, 3.474, 6.899, 22.382, 4.446, 8.389, 0.014, 0.0, (0.0, 0.5)
    ),
    "B": Checked(
        Wave(50, 10, 2.0),
        *(7.275, 3.405, 0.981, 6.166, 2.145, 0.500, 0.031, 0.502),
        (0.0, 0.251, 0.5, 0.749),
    ),
    "C": Checked(
        Wave(50, 30, 1.3),
        *(10.160, 4.457, 8.225, 23.421, 5.358, 4.900, 0.039, 0.222),
        (0.0, 0.111, 0.5, 0.889),
    ),
    "D": Checked(
        Wave(45, 30, 0.5, 4.0, 2.0),
        *(7.855, 3.019, 6.909, 28.847, 9.522, 10.953, 0.030, 0.185),
        (0.068, 0.158, 0.540, 0.945),
    ),
}


def checked_suit(trajectory, **changes):
    """Return the suit of the check values along a trajectory."""
    stated = {"ratio": 0.6, "load_mass": 2.0, "spring_stiffness": 5e3, "pretension": 150.0}
    numbers = stated | changes
    made = design(baseline(**numbers))
    return replace(made, trajectory=trajectory, arm=replace(made.arm, inertia=INERTIA))


def moving(made):
    """Return a design along its trajectory."""
    return Moving.of(made, made.trajectory)


def results(along):
    """Return the results of one design by name, with the peak torque of both candidates."""
    counted = along.trajectory.counted
    torque = along.state.motor_torque[0, counted]
    other = along.state.sliding.torque_while_turning.ravel()[counted]
    columns = {name: float(value) for name, value in motion_columns(along).items()}
    return columns | {"peak_motor_torque": np.nanmax(np.abs([torque, other]))}
