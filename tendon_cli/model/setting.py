"""How a pretension is set and read: what gauges show in the posture in which the suit is set, and back.

F0 is a number of the model that no gauge shows. In the posture of the setting, at rest after a direction of motion, the
forearm's weight, the joint's torque and the load of the setting act, and both tensions are lines in F0 with one
kink (`response`), at the joint and, by the capstan's factor, at the motor. Arguments broadcast as in `actuator`; SI.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.model.actuator import State
from tendon_cli.model.design import F0, READINGS, Design
from tendon_cli.model.kinematics import Array, Real


def setting_of(design: Design) -> State:
    """A design in the posture in which its pretension is set."""
    posture = design.setting
    arm = replace(design.arm, upper_arm_angle=posture.upper_arm_angle)
    still = replace(design, arm=arm, load_mass=posture.load_mass, load_torque=None, trajectory=None)
    return State.of(still, posture.angle, posture.after_flexion)


def per_length(design: Design) -> Array:
    """By how much F0 grows per length taken from both tendons, (1 + η)/(η c_f + c_e), N/m."""
    return np.asarray((1.0 + np.asarray(design.ratio)) / setting_of(design).coupling.compliance)


@dataclass(frozen=True, eq=False)
class Reading:
    """What a gauge shows of F0: floor + gain max(F0 - F*, lowest), N."""

    floor: Array
    gain: Array
    required: Array
    lowest: Array

    @classmethod
    def of(cls, design: Design, read: str | None = None) -> Reading:
        """One of `READINGS`, by default as the design's pretension is read; F0 shows itself."""
        read = design.read if read is None else read
        if read == F0:
            return cls(np.zeros(()), np.ones(()), np.zeros(()), np.full((), -np.inf))
        at = setting_of(design)
        side, _, end = read.partition(" at ")
        response, capstan = at.response, getattr(at, side).capstan if end == "motor" else 1.0
        floor, gain = getattr(response, f"{side}_floor"), getattr(response, f"{side}_gain")
        return cls(floor / capstan, gain / capstan, response.required, response.lowest)

    def shown(self, pretension: Real) -> Array:
        """The reading at F0."""
        return np.asarray(
            self.floor + self.gain * np.maximum(pretension - self.required, self.lowest)
        )

    def pretension(self, shown: Real) -> Array:
        """The F0 of a reading; below what a slack tendon shows there is none, and it is then too low."""
        return np.asarray(self.required + (shown - self.floor) / self.gain)


def all_readings(design: Design, pretension: Real) -> dict[str, Array]:
    """What each gauge shows at F0, by the names of `READINGS`, N."""
    return {read: Reading.of(design, read).shown(pretension) for read in READINGS if read != F0}


def shown(design: Design, pretension: Real) -> Array:
    """F0 as the design's pretension is read, N."""
    return Reading.of(design).shown(pretension)


def pretension_of(design: Design, reading: Real) -> Array:
    """The F0 of a reading as the design takes it, N."""
    return Reading.of(design).pretension(reading)


def set_by(design: Design) -> Design:
    """A design whose pretension is given as it is read, with its F0 in the place of that."""
    if design.read == F0:
        return design
    given = pretension_of(design, design.flexor.pretension)
    flexor, extensor = (
        replace(side, pretension=given) for side in (design.flexor, design.extensor)
    )
    return replace(design, flexor=flexor, extensor=extensor)
