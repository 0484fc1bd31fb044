"""Script that a good researcher would write instead of tendon: all states at once in NumPy.

    python expert.py OUT.parquet PRETENSIONS SPRINGS RATIOS

It knows nothing of tendon: the closed form of the model, on arrays whose axes are pretension,
spring, spool ratio, load, direction and elbow angle, then one write by pyarrow. Each quantity is
computed on just the axes that it depends on, and broadcasts to the rest. All columns of the states
table are written, not the designs table. Bilateral tendons, cases and resuming are not for it.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

# Anchors of the flexor, and radius of the elbow, m
A1 = 0.040
B1 = 0.150
A2 = 0.020
B2 = 0.150
ELBOW = 0.045

WEIGHT = 1.54  # of the forearm, kg
WEIGHT_AT = 0.174  # m
LOAD_AT = 0.320  # m
GRAVITY = 9.81  # m/s^2

MU = 0.07
PHI = np.pi  # bend of the sheath, rad
LENGTH = 2.0  # of a tendon, m
DIAMETER = 1.5e-3  # m
YOUNG = 145e9  # Pa
SPOOL = 0.030  # radius, m

STATUS = ["taut", "flexor slack", "extensor slack", "both slack", "no equilibrium"]
# Positions in STATUS
FLEXOR = 1
EXTENSOR = 2
BOTH = 3
NONE = 4

Array = Any  # arrays of whatever shape they broadcast to


def axes(pretensions: int, springs: int, ratios: int) -> list[Array]:
    """Return pretension, stiffness, ratio, load, direction and angle, each along its own axis.

    A direction is +1 in flexion and -1 in extension.
    """
    values = [
        np.linspace(20.0, 260.0, pretensions),
        np.linspace(1000.0, 8000.0, springs),
        np.linspace(0.6, 1.2, ratios),
        np.array([0.0, 3.0, 5.0, 10.0]),
        np.array([1.0, -1.0]),
        np.radians(np.arange(91.0)),
    ]
    return [
        column.reshape([-1 if at == axis else 1 for at in range(6)])
        for axis, column in enumerate(values)
    ]


def geometry(angle: Array) -> tuple[Array, Array, Array, Array]:
    """Return the travels of flexor and extensor, the moment arm and its slope.

    The flexor runs between two anchors, the vectors q and r.
    """
    q1 = B2 * np.sin(angle) + A2 * np.cos(angle)
    q2 = A2 * np.sin(angle) - B2 * np.cos(angle)
    path = np.hypot(q1 - A1, q2 - B1)
    moment_arm = (A1 * -q2 + B1 * q1) / path
    slope = (moment_arm**2 - (A1 * q1 + B1 * q2)) / path
    return B1 + B2 - path, ELBOW * angle, moment_arm, slope


def sheath(toward: Array, friction: Array = MU) -> tuple[Array, Array]:
    """Return distal over proximal tension, and stretch of the tendon per distal newton.

    `toward` is -1 toward the motor, else +1.
    """
    z = toward * friction * PHI
    return np.exp(z), LENGTH / (np.pi / 4 * DIAMETER**2 * YOUNG) * -np.expm1(-z) / z


def balance(
    pretension: Array,
    ratio: Array,
    arm: Array,
    torque: Array,
    c_f: Array,
    c_e: Array,
    mismatch: Array,
) -> tuple[Array, Array, Array, Array]:
    """Return the status, both tensions at the elbow, and the loose path.

    Two equations give the tensions while both are taut. A negative one is slack, and the other
    holds the load alone.
    """
    stretch = (ratio * c_f + c_e) * pretension + mismatch
    determinant = arm * c_e + ratio * c_f * ELBOW
    x = (torque * c_e + ELBOW * stretch) / determinant
    y = (arm * stretch - ratio * c_f * torque) / determinant
    no_flexor = (x < 0) & (torque <= 0)
    no_extensor = (y < 0) & (torque >= 0)
    slack = FLEXOR * no_flexor + EXTENSOR * no_extensor
    status = np.where(np.isnan(x), NONE, slack).astype(np.int8)
    x = np.where(no_flexor, 0.0, np.where(no_extensor, torque / arm, x))
    y = np.where(no_extensor, 0.0, np.where(no_flexor, -torque / ELBOW, y))
    loose = np.where(no_flexor | no_extensor, ratio * c_f * x + c_e * y - stretch, 0.0 * x)
    loose[status == BOTH] = np.nan
    return status, x, y, loose


def states(
    pretension: Array, stiffness: Array, ratio: Array, load: Array, direction: Array, angle: Array
) -> Array:
    """Return the columns of results by name, each with the axes that it depends on."""
    flexor_travel, extensor_travel, moment_arm, slope = geometry(angle)
    arm = np.where(moment_arm > 0, moment_arm, np.nan)
    weight = GRAVITY * (WEIGHT * WEIGHT_AT + load * LOAD_AT)
    torque = weight * np.sin(angle)
    capstan_f, tendon_f = sheath(-direction)
    capstan_e, tendon_e = sheath(direction)
    c_f = tendon_f + 1 / stiffness
    c_e = tendon_e + 1 / stiffness
    mismatch = extensor_travel - ratio * flexor_travel
    status, x, y, loose = balance(pretension, ratio, arm, torque, c_f, c_e, mismatch)

    stretch_f = x - pretension
    stretch_e = y - pretension
    by_flexor = flexor_travel + c_f * stretch_f
    by_extensor = (extensor_travel - c_e * stretch_e) / ratio
    spool_angle = np.where(status == FLEXOR, by_extensor, by_flexor) / SPOOL
    spool_angle[status == BOTH] = np.nan
    flexor_pulls = (status & FLEXOR) == 0
    extensor_pulls = (status & EXTENSOR) == 0
    by_tendons = flexor_pulls * (arm**2 / c_f) + extensor_pulls * (ELBOW**2 / c_e)
    return {
        "status": status,
        "flexor_tension_proximal": x / capstan_f,
        "flexor_tension_distal": x,
        "extensor_tension_proximal": y / capstan_e,
        "extensor_tension_distal": y,
        "flexor_tendon_stretch": tendon_f * stretch_f,
        "extensor_tendon_stretch": tendon_e * stretch_e,
        "flexor_spring_stretch": stretch_f / stiffness,
        "extensor_spring_stretch": stretch_e / stiffness,
        "flexor_slack": np.where(status == FLEXOR, loose / ratio, 0.0 * loose),
        "extensor_slack": np.where(status == FLEXOR, 0.0, loose),
        "elbow_torque": torque + 0.0 * arm,
        "motor_torque": (x / capstan_f - ratio * (y / capstan_e)) * SPOOL,
        "spool_angle": spool_angle,
        "elbow_stiffness": by_tendons + weight * np.cos(angle) - x * slope,
        "flexor_moment_arm": moment_arm,
        "flexor_travel": flexor_travel,
        "extensor_travel": extensor_travel,
    }


def table(*counts: int) -> pa.Table:
    """Return the states table of the whole product."""
    grid = axes(*counts)
    shape = np.broadcast_shapes(*(axis.shape for axis in grid))
    pretension, stiffness, ratio, load, direction, angle = grid

    def column(values: Array) -> pa.Array:
        whole = np.broadcast_to(values, shape).ravel()
        return pa.array(whole, from_pandas=True)  # NaN becomes null

    def words(positions: Array, choices: list[str]) -> pa.Array:
        return pa.DictionaryArray.from_arrays(column(positions.astype(np.int8)), choices)

    results = states(*grid)
    columns = {
        "design": column(np.arange(np.prod(shape[:4])).reshape(*shape[:4], 1, 1)),
        "pretension": column(pretension),
        "spring_stiffness": column(stiffness),
        "spool_ratio": column(ratio),
        "load_mass": column(load),
        "friction": column(MU),
        "bend_angle": column(PHI),
        "direction": words(direction < 0, ["flexion", "extension"]),
        "elbow_angle": column(angle),
        "status": words(results.pop("status"), STATUS),
    }
    return pa.table(columns | {name: column(values) for name, values in results.items()})


if __name__ == "__main__":
    pq.write_table(table(*map(int, sys.argv[2:])), sys.argv[1])
