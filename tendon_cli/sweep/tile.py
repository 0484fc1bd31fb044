"""A tile: the designs whose states are looked at together, and what such a look finds.

A tile has P pretensions for each of B designs that have all else in common, in D directions at K elbow angles. What
does not depend on pretension is worked out once for all of these: here, whatever comes before the balance of a state.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model import actuator, statics
from tendon_cli.model.actuator import Design, Transmission
from tendon_cli.model.kinematics import Array, Kinematics, kinematics
from tendon_cli.model.statics import Coupling

Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Tile:
    """What a tile's states know before any pretension. Arrays broadcast to (K, D, B) but for `pretension`."""

    design: Design
    elbow_angle: Array
    """(K,), rad."""
    motion: Kinematics
    flexor: Transmission
    extensor: Transmission
    moment: Array
    """Of gravity about the elbow where the forearm is level, N m."""
    inclination: Array
    """Of the forearm from the vertical, rad."""
    pretensions: int
    """P."""
    shape: tuple[int, int, int]
    """K, D, B."""

    @classmethod
    def of(cls, design: Design, elbow_angle: Array, flexion: Flags) -> Tile:
        """From arrays that broadcast to (K, D, B): elbow angles (K, 1, 1), directions (1, D, 1), and designs.

        The design's pretensions have another axis in front, (P, 1, 1, B).
        """
        motion = kinematics(design.arm.anchors, elbow_angle, from_initial=design.from_initial)
        flexor, extensor = actuator.transmissions(design, flexion)
        moment = actuator.gravity_moment(design.arm, design.load_mass)
        inclination = np.add(elbow_angle, design.arm.upper_arm_angle)
        sides = [np.asarray(side.pretension) for side in (design.flexor, design.extensor)]
        arrays = (
            motion.flexor_moment_arm, motion.flexor_travel, motion.extensor_travel, flexor.compliance,
            extensor.compliance, flexor.capstan, extensor.capstan, moment, inclination, design.ratio,
            design.flexor_radius, design.unilateral, *sides,
        )  # fmt: skip
        return cls(
            design=design,
            elbow_angle=elbow_angle.reshape(-1),
            motion=motion,
            flexor=flexor,
            extensor=extensor,
            moment=moment,
            inclination=inclination,
            pretensions=max(len(side) if side.ndim > 3 else 1 for side in sides),
            shape=(len(elbow_angle), flexion.shape[1], max(np.shape(array)[-1] for array in arrays if np.ndim(array))),
        )

    @cached_property
    def coupling(self) -> Coupling:
        """What ties the tensions of a state together."""
        torque = np.asarray(self.moment * np.sin(self.inclination))
        return actuator.tie(self.design, self.motion, self.flexor, self.extensor, torque)

    @cached_property
    def pretension(self) -> Array:
        """Common to both sides; broadcasts to (P, D, B), N."""
        sides = self.design.flexor.pretension, self.design.extensor.pretension
        compliances = self.flexor.compliance, self.extensor.compliance
        common = np.asarray(statics.common_pretension(self.design.ratio, *compliances, *sides))
        return common.reshape(-1, *common.shape[-2:]) if common.ndim else common.reshape(1, 1, 1)

    @property
    def looseness(self) -> Array:
        """Path that comes loose per newton below a state's shortfall, η c_f + c_e, (1 or D, B), m/N."""
        common: Array = self.design.ratio * self.flexor.compliance + self.extensor.compliance
        return np.asarray(common[0])


@dataclass(frozen=True, eq=False)
class Range:
    """Smallest and largest value over the elbow angles, (P, D, B) if nothing else is said."""

    lowest: Array
    highest: Array

    @classmethod
    def empty(cls, shape: tuple[int, ...]) -> Range:
        """To be filled in."""
        return cls(np.empty(shape), np.empty(shape))


@dataclass(frozen=True, eq=False)
class Side:
    """Those states in which one side alone goes slack, (D, B); minus infinity where there is none."""

    shortfall: Array
    """The largest, N."""
    limit: Array
    """Pretension below which one of them counts as slack, N."""


@dataclass(frozen=True, eq=False)
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
    elbow_torque: Range
    """τ_a, (D, B), N m."""
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
            elbow_torque=Range.empty(columns),
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
