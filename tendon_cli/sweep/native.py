"""The compiled code: found, and handed arrays to work on without a copy.

What is in `kernel/` is compiled when tendon is installed, where a C compiler is at hand. NumPy does all it does, to the
same bits: `compiled` and `rows` say what it is asked for, and nothing else depends on whether it is there.
"""

from __future__ import annotations

import ctypes
import os
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tendon_cli.model import actuator
from tendon_cli.model.actuator import Design, Transmission
from tendon_cli.model.kinematics import Array, Kinematics

UNWANTED = "TENDON_NO_COMPILED"
"""Environment variable that, set to anything, has NumPy do it all."""

_VERSION = 3
"""Of `kernel/native.c`: raised there and here with every change, so that what an older tendon left is not used."""

_Steps = ctypes.c_long * 3


class Field(ctypes.Structure):
    """An array over three axes: where it is, and its steps."""

    _fields_ = (("at", ctypes.c_void_p), ("step", _Steps))


STATES = (
    "arm", "per_arm", "arm_slope", "flexor_travel", "extensor_travel", "sine", "cosine", "flexor_compliance",
    "extensor_compliance", "flexor_arm", "extensor_arm", "ratio", "radius", "moment", "unilateral",
)  # fmt: skip
"""What states know before any pretension: the arrays that both calls start with."""


@cache
def library() -> ctypes.CDLL | None:
    """The compiled code; None where there is none of this version, or none is wanted."""
    return None if os.environ.get(UNWANTED) else load(Path(__file__).parent)


def load(folder: Path) -> ctypes.CDLL | None:
    """The first of what is compiled in a folder that this machine can run and that is of this version."""
    for path in sorted(folder.glob("_native.*")):
        try:
            code = ctypes.CDLL(str(path))
            if ctypes.c_int.in_dll(code, "tendon_native_version").value == _VERSION:
                return code
        except (OSError, ValueError):  # made for another machine, or before versions
            continue
    return None


def field(array: Array) -> Field:
    """Where an array over three axes is, and its steps: none where it is one long, so that it broadcasts.

    The array itself has to outlive what is made here.
    """
    steps = (
        step // array.itemsize if length > 1 else 0 for length, step in zip(array.shape, array.strides, strict=True)
    )
    return Field(array.ctypes.data, _Steps(*steps))


def named_fields(*names: str) -> tuple[tuple[str, type[Field]], ...]:
    """Arrays as members of a structure."""
    return tuple((name, Field) for name in names)


def pointers(arrays: list[Array]) -> ctypes.Array[ctypes.c_void_p]:
    """Where some arrays are."""
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))


def states(
    design: Design, motion: Kinematics, flexor: Transmission, extensor: Transmission, moment: Array, inclination: Array
) -> tuple[npt.ArrayLike, ...]:
    """The arrays of `STATES`, as the model has them; gravity's moment and the forearm's inclination as in `Tile`."""
    arm = motion.pulling_arm
    return (
        arm, 1.0 / arm, motion.flexor_moment_arm_slope, motion.flexor_travel, motion.extensor_travel,
        np.sin(inclination), np.cos(inclination), flexor.compliance, extensor.compliance,
        *actuator.motor_arms(design, flexor, extensor), design.ratio, design.arm.anchors.elbow_radius,
        moment, design.unilateral,
    )  # fmt: skip
