"""Readings of a pretension: tensions that gauges show in the posture in which a suit is set.

F0 is a number of the model that no gauge shows. In the posture of the setting, at rest after a
direction of motion, the forearm's weight, the joint's torque and the load of the setting act, and
both tensions are lines in F0 with one kink (`response`), at the joint and, by the capstan's factor,
at the motor. Arguments broadcast as in `actuator`; SI units.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.model.actuator import State
from tendon_cli.model.design import F0, MOTOR_TORQUE, TENSIONS, Design
from tendon_cli.model.kinematics import Array, Real


def setting_of(design: Design) -> State:
    """Return the state of a design in the posture in which its pretension is set."""
    posture = design.setting
    arm = replace(design.arm, upper_arm_angle=posture.upper_arm_angle)
    still = design.at_rest(arm=arm, load_mass=posture.load_mass, load_torque=None)
    return State.of(still, posture.angle, posture.after_flexion)


def pretension_per_length(design: Design) -> Array:
    """Return the growth of F0 per length taken from both tendons, (1 + η)/(η c_f + c_e), N/m."""
    compliance = setting_of(design).coupling.common_compliance
    return np.asarray((1.0 + np.asarray(design.ratio)) / compliance)


def reading_per_length(design: Design) -> Array:
    """Return the growth of what is read per length taken from both tendons, its unit per metre.

    It is that of F0, (1 + η)/(η c_f + c_e), times the gain of the reading while the tendon that is
    read is taut.
    """
    return np.asarray(Reading.of(design).gain * pretension_per_length(design))


@dataclass(frozen=True, eq=False)
class Reading:
    """Reading of a gauge at F0: floor + gain max(F0 - F*, lowest).

    It is a tension, N, or the torque of the motor, R_f (x / e_f - η y / e_e), N m.
    """

    floor: Array
    """Reading at F*, N or N m."""
    gain: Array
    """Growth of the reading with F0 above F*, 1 or m; a torque may fall."""
    required: Array
    """F*, the smallest pretension that keeps the posture taut, N."""
    lowest: Array
    """Least value of F0 - F* that the reading follows, N."""

    @classmethod
    def of(cls, design: Design, read: str | None = None) -> Reading:
        """Return a reading of a design.

        Args:
            design: Designs.
            read: A reading (`design.READINGS`), as it is without an error of the gauge; by default
                the design's own, with its error. F0 shows itself.
        """
        error = design.setting.reading_error if read is None else 0.0
        read = design.read if read is None else read
        if read == F0:
            return cls(np.asarray(error), np.ones(()), np.zeros(()), np.full((), -np.inf))
        state = setting_of(design)
        if read == MOTOR_TORQUE:
            return cls._of_torque(state, error)
        side, _, end = read.partition(" at ")
        response = state.response
        capstan = getattr(state, side).capstan if end == "motor" else 1.0
        floor = getattr(response, f"{side}_floor")
        gain = getattr(response, f"{side}_gain")
        shown_floor = np.asarray(floor / capstan + error)
        return cls(shown_floor, gain / capstan, response.required, response.lowest)

    @classmethod
    def _of_torque(cls, state: State, error: Real) -> Reading:
        """Return the torque of the motor in a state, with an error of its gauge, N m."""
        response = state.response
        flexor_arm, extensor_arm = state.motor_arms
        floor = response.flexor_floor * flexor_arm - response.extensor_floor * extensor_arm
        gain = response.flexor_gain * flexor_arm - response.extensor_gain * extensor_arm
        return cls(np.asarray(floor + error), gain, response.required, response.lowest)

    def shown(self, pretension: Real) -> Array:
        """Return the reading at F0, N or N m.

        Args:
            pretension: F0, N.
        """
        surplus = np.maximum(pretension - self.required, self.lowest)
        return np.asarray(self.floor + self.gain * surplus)

    def while_taut(self, pretension: Real) -> Array:
        """Return the reading at F0 of tendons that could push, N or N m: `shown` if they are taut.

        Args:
            pretension: F0, N.
        """
        return np.asarray(self.floor + self.gain * (pretension - self.required))

    def pretension(self, shown: Real) -> Array:
        """Return the F0 of a reading, N.

        Below what a slack tendon shows there is no such F0, and the result is too low.

        Args:
            shown: Reading, N or N m.
        """
        return np.asarray(self.required + (shown - self.floor) / self.gain)


def all_readings(design: Design, pretension: Real) -> dict[str, Array]:
    """Return the tensions that gauges show at F0, by the names of TENSIONS, N.

    Args:
        design: Designs.
        pretension: F0, N.
    """
    return {read: Reading.of(design, read).shown(pretension) for read in TENSIONS}


def reading_at(design: Design, pretension: Real) -> Array:
    """Return the reading at F0, of the kind in which the design's pretension is given.

    Args:
        design: Designs.
        pretension: F0, N.
    """
    return Reading.of(design).shown(pretension)


def pretension_of(design: Design, reading: Real) -> Array:
    """Return F0 from a reading of the kind in which the design's pretension is given, N.

    Args:
        design: Designs.
        reading: Tension or torque that the gauge shows, N or N m.
    """
    return Reading.of(design).pretension(reading)


def with_set_pretension(design: Design) -> Design:
    """Return a design whose pretension, given as a reading, is converted to F0; `read` stays."""
    if design.shows_f0:
        return design
    return design.with_pretension(pretension_of(design, design.flexor.pretension))
