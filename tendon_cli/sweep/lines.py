"""The states of many designs as straight lines in pretension, laid out for passes over whole arrays.

A *tile* is a set of designs: P pretensions for each of B designs that have all else in common. Every result of a state
is a line in v = max(F - shortfall, lowest), as `statics.respond` derives. All that does not depend on the pretension F
is worked out here, once for all pretensions of the tile.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model import actuator, statics
from tendon_cli.model.actuator import Design, Transmission
from tendon_cli.model.kinematics import Array
from tendon_cli.model.statics import Coupling, Response

Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Line:
    """floor + gain v, for every state."""

    floor: Array | None
    """None for nothing."""
    gain: Array

    def __call__(self, v: Array, out: Array) -> Array:
        """The values at v, written into `out`."""
        np.multiply(self.gain, v, out=out)
        if self.floor is not None:
            np.add(out, self.floor, out=out)
        return out


@dataclass(frozen=True)
class Lines:
    """The states of a tile: one row for each elbow angle, one column for each direction of each design, (K, D B)."""

    shortfall: Array
    lowest: Array
    limit: Array
    """Pretension below which a state counts as slack, N."""
    flexor: Line
    """x, distal flexor tension, N."""
    extensor: Line
    """y, distal extensor tension, N."""
    motor: Line
    """τ_m (Eq. 17), N m."""
    stiffness: Line
    """Elbow stiffness as `statics.elbow_stiffness` has it while both tendons pull, N m/rad."""
    slack_stiffness: Array
    """Elbow stiffness where the state is slack, N m/rad; infinite in the bilateral model, which loses nothing."""
    pretension: Array
    """(P, 1), or (P, D B) where it differs between columns, N."""


@dataclass(frozen=True)
class Tile:
    """What a tile comes to before any of its pretensions is looked at. Arrays broadcast to (K, D, B) but for one."""

    design: Design
    flexor: Transmission
    extensor: Transmission
    coupling: Coupling
    response: Response
    elbow_torque: Array
    """τ_a where there is an equilibrium, N m."""
    pretension: Array
    """Common to both sides; broadcasts to (P, D, B), N."""
    shape: tuple[int, int, int]
    """K, D, B."""
    lines: Lines


def tile(design: Design, elbow_angle: Array, flexion: Flags) -> Tile:
    """Work out a tile from arrays that broadcast to (K, D, B): elbow angles (K, 1, 1), directions (1, D, 1), designs.

    The design's pretensions have another axis in front, (P, 1, 1, B).
    """
    motion, flexor, extensor, coupling = actuator.couple(design, elbow_angle, flexion)
    response = statics.respond(coupling, unilateral=design.unilateral)
    common = np.asarray(statics.common_pretension(coupling, design.flexor.pretension, design.extensor.pretension))
    pretension = common.reshape(-1, *common.shape[-2:]) if common.ndim else common.reshape(1, 1, 1)
    torque, torque_slope = actuator.gravity_torque(design.arm, design.load_mass, elbow_angle)
    motor = _motor(design, response, flexor, extensor)
    stiffness, slack_stiffness = _stiffness(design, coupling, response, motion.flexor_moment_arm_slope, torque_slope)
    arrays = (response.limit, motor[1], stiffness[0], pretension[0])
    shape = len(elbow_angle), flexion.shape[1], max(array.shape[-1] for array in arrays)
    lines = Lines(
        shortfall=_flat(response.shortfall, shape),
        lowest=_flat(response.lowest, shape),
        limit=_flat(response.limit, shape),
        flexor=_line(response.flexor_floor, response.flexor_gain, shape),
        extensor=_line(response.extensor_floor, response.extensor_gain, shape),
        motor=_line(*motor, shape),
        stiffness=_line(*stiffness, shape),
        slack_stiffness=_flat(slack_stiffness, shape),
        pretension=pretension[:, 0] if pretension[0].size == 1 else _flat(pretension, (len(pretension), *shape[1:])),
    )
    torque = np.where(np.isnan(coupling.moment_arm), np.nan, torque)
    return Tile(design, flexor, extensor, coupling, response, torque, pretension, shape, lines)


def only_designs(values: Any) -> npt.NDArray[Any]:
    """An array that depends on no state, without the states' axes: scalar, or of the shape (B,)."""
    array = np.asarray(values)
    return np.asarray(array if array.ndim == 0 else array[0, 0])


def _flat(values: Array, shape: tuple[int, ...]) -> Array:
    return np.ascontiguousarray(np.broadcast_to(values, shape)).reshape(shape[0], -1)


def _line(floor: Array, gain: Array, shape: tuple[int, ...]) -> Line:
    return Line(_flat(floor, shape) if floor.any() else None, _flat(gain, shape))


def _motor(design: Design, response: Response, flexor: Transmission, extensor: Transmission) -> tuple[Array, Array]:
    """τ_m = (x_prox - η y_prox) R_f (Eq. 17) is a line in v, too: its floor and gain."""
    flexor_arm = design.flexor_radius / flexor.capstan
    extensor_arm = design.ratio * design.flexor_radius / extensor.capstan
    return (
        response.flexor_floor * flexor_arm - response.extensor_floor * extensor_arm,
        response.flexor_gain * flexor_arm - response.extensor_gain * extensor_arm,
    )


def _stiffness(
    design: Design, tied: Coupling, response: Response, arm_slope: Array, torque_slope: Array
) -> tuple[tuple[Array, Array], Array]:
    """Elbow stiffness while taut, floor and gain of a line in v, and what is left of it where the state is slack."""
    flexor = np.square(tied.moment_arm) / tied.flexor_compliance
    extensor = np.square(tied.elbow_radius) / tied.extensor_compliance
    floor = flexor + extensor + (torque_slope - arm_slope * response.flexor_floor)
    backward = tied.elbow_torque < 0.0
    lost = statics.by_side(backward, flexor, extensor) + response.idle * statics.by_side(backward, extensor, flexor)
    left = floor - lost
    if not np.all(design.unilateral):
        left = np.where(design.unilateral, left, np.inf)
    return (floor, -arm_slope * response.flexor_gain), left
