"""A tile: the designs whose states are looked at together, and what such a look finds.

A tile has P pretensions for each of B designs that have all else in common, in D directions at K elbow angles. What
does not depend on pretension is worked out once for all of these: here, whatever comes before the balance of a state.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model import actuator, statics
from tendon_cli.model.actuator import Design, Transmission
from tendon_cli.model.kinematics import Array
from tendon_cli.model.statics import Coupling

Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Tile:
    """What a tile's states know before any pretension. Arrays broadcast to (K, D, B) but for `pretension`."""

    design: Design
    elbow_angle: Array
    """(K,), rad."""
    flexor: Transmission
    extensor: Transmission
    coupling: Coupling
    arm_slope: Array
    """dJ/dθ, m/rad."""
    torque_slope: Array
    """dτ_a/dθ, N m/rad."""
    pretension: Array
    """Common to both sides; broadcasts to (P, D, B), N."""
    shape: tuple[int, int, int]
    """K, D, B."""

    @classmethod
    def of(cls, design: Design, elbow_angle: Array, flexion: Flags) -> Tile:
        """From arrays that broadcast to (K, D, B): elbow angles (K, 1, 1), directions (1, D, 1), and designs.

        The design's pretensions have another axis in front, (P, 1, 1, B).
        """
        motion, flexor, extensor, coupling = actuator.couple(design, elbow_angle, flexion)
        common = np.asarray(statics.common_pretension(coupling, design.flexor.pretension, design.extensor.pretension))
        torque_slope = actuator.gravity_torque(design.arm, design.load_mass, elbow_angle)[1]
        arrays = (coupling.mismatch, coupling.elbow_torque, flexor.compliance, extensor.compliance, flexor.capstan,
                  extensor.capstan, design.flexor_radius, design.unilateral, common)  # fmt: skip
        return cls(
            design=design,
            elbow_angle=elbow_angle.reshape(-1),
            flexor=flexor,
            extensor=extensor,
            coupling=coupling,
            arm_slope=motion.flexor_moment_arm_slope,
            torque_slope=torque_slope,
            pretension=common.reshape(-1, *common.shape[-2:]) if common.ndim else common.reshape(1, 1, 1),
            shape=(len(elbow_angle), flexion.shape[1], max(np.shape(array)[-1] for array in arrays if np.ndim(array))),
        )

    @property
    def motor_arms(self) -> tuple[Array, Array]:
        """τ_m per distal newton of the flexor and, against it, of the extensor (Eq. 17), m."""
        radius = self.design.flexor_radius
        return radius / self.flexor.capstan, self.design.ratio * radius / self.extensor.capstan


@dataclass(frozen=True)
class Range:
    """Smallest and largest value over the elbow angles, (P, D, B)."""

    lowest: Array
    highest: Array

    @classmethod
    def empty(cls, shape: tuple[int, ...]) -> Range:
        """To be filled in."""
        return cls(np.empty(shape), np.empty(shape))


@dataclass(frozen=True)
class Side:
    """Those states in which one side alone goes slack, (D, B); minus infinity where there is none."""

    shortfall: Array
    """The largest, N."""
    limit: Array
    """Pretension below which one of them counts as slack, N."""


@dataclass(frozen=True)
class Seen:
    """What a look at all states of a tile finds; not a number where no state has an equilibrium."""

    flexor: Range
    """x, distal flexor tension, N."""
    extensor: Range
    """y, distal extensor tension, N."""
    motor: Range
    """τ_m, N m."""
    stiffness: Array
    """The least elbow stiffness, (P, D, B), N m/rad."""
    unstable: Array
    """How many states have less than none, (P, D, B)."""
    slack: Array
    """How many states are slack, (P, D, B)."""
    first_slack_angle: Array
    """The smallest angle with a slack state, (P, D, B), rad."""
    shortfall: Array
    """The largest, (D, B), N."""
    sides: tuple[Side, Side]
    """Flexor and extensor."""
    one_sided: Flags
    """Whether any state has a side that goes slack first, (D, B)."""
    both_limit: Array
    """Pretension at or above which a state that has none is taut, (D, B), N; infinite where there is no such state."""
    no_equilibrium: Array
    """How many states have no equilibrium, (D, B)."""

    @classmethod
    def empty(cls, pretensions: int, shape: tuple[int, int, int]) -> Seen:
        """To be filled in."""
        by_pretension, columns = (pretensions, *shape[1:]), shape[1:]
        return cls(
            flexor=Range.empty(by_pretension),
            extensor=Range.empty(by_pretension),
            motor=Range.empty(by_pretension),
            stiffness=np.empty(by_pretension),
            unstable=np.empty(by_pretension),
            slack=np.empty(by_pretension),
            first_slack_angle=np.empty(by_pretension),
            shortfall=np.empty(columns),
            sides=(Side(np.empty(columns), np.empty(columns)), Side(np.empty(columns), np.empty(columns))),
            one_sided=np.empty(columns, dtype=np.bool_),
            both_limit=np.empty(columns),
            no_equilibrium=np.empty(columns),
        )


def only_designs(values: Any) -> npt.NDArray[Any]:
    """An array that depends on no state, without the states' axes: scalar, or of the shape (B,)."""
    array = np.asarray(values)
    return np.asarray(array if array.ndim == 0 else array[0, 0])
