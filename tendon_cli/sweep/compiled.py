"""A look at all states of a tile by compiled code: the arithmetic of `lines`, to the same bits, but much faster.

`look.c` is compiled when tendon is installed, where a C compiler is at hand; nothing else depends on whether it was.
"""

from __future__ import annotations

import ctypes
import os
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array
from tendon_cli.sweep.tile import Range, Seen, Side, Tile

UNWANTED = "TENDON_NO_COMPILED"
"""Environment variable that, set to anything, has NumPy do it all."""

_VERSION = 1
"""Of `look.c`: raised there and here with every change of it, so that what an older one left behind is not used."""
_BY_PRETENSION, _ASIDE = 10, 10


class _Field(ctypes.Structure):
    _fields_ = (("at", ctypes.c_void_p), ("step", ctypes.c_long * 3))


_FIELDS = (
    "arm", "per_arm", "arm_slope", "flexor_travel", "extensor_travel", "sine", "cosine", "flexor_compliance",
    "extensor_compliance", "flexor_arm", "extensor_arm", "ratio", "radius", "moment", "unilateral", "pretension",
)  # fmt: skip


class _Tile(ctypes.Structure):
    _fields_ = (
        *((name, _Field) for name in _FIELDS),
        ("angle", ctypes.c_void_p),
        *((name, ctypes.c_long) for name in ("angles", "directions", "designs", "pretensions", "any_bilateral")),
    )


class _Seen(ctypes.Structure):
    _fields_ = (("by_pretension", ctypes.c_void_p * _BY_PRETENSION), ("aside", ctypes.c_void_p * _ASIDE))


@cache
def library() -> ctypes.CDLL | None:
    """The compiled code; None where there is none of this version, or none is wanted."""
    return None if os.environ.get(UNWANTED) else _load(Path(__file__).parent)


def _load(folder: Path) -> ctypes.CDLL | None:
    """The first of what is compiled in a folder that this machine can run and that is of this version."""
    for path in sorted(folder.glob("_look.*")):
        try:
            code = ctypes.CDLL(str(path))
            if ctypes.c_int.in_dll(code, "tendon_look_version").value == _VERSION:
                return code
        except (OSError, ValueError):  # made for another machine, or before versions
            continue
    return None


def look(tile: Tile, code: ctypes.CDLL) -> Seen:
    """Look at all states of a tile, once for each pretension, by what `library` gave; safe from several threads."""
    motion, design = tile.motion, tile.design
    arm = np.where(motion.flexor_moment_arm > 0.0, motion.flexor_moment_arm, np.nan)
    fields = (
        arm, 1.0 / arm, motion.flexor_moment_arm_slope, motion.flexor_travel, motion.extensor_travel,
        np.sin(tile.inclination), np.cos(tile.inclination), tile.flexor.compliance, tile.extensor.compliance,
        *tile.motor_arms, design.ratio, design.arm.anchors.elbow_radius, tile.moment,
    )  # fmt: skip
    unilateral = np.asarray(design.unilateral, dtype=np.float64)
    whole = tile.pretensions, *tile.shape[1:]
    arrays = [_spread(values, tile.shape) for values in (*fields, unilateral)]
    arrays.append(_spread(tile.pretension, whole))
    angle = np.ascontiguousarray(tile.elbow_angle)
    by_pretension, aside = np.empty((_BY_PRETENSION, *whole)), np.empty((_ASIDE, *whole[1:]))
    given = _Tile(*map(_field, arrays), angle.ctypes.data, *tile.shape, tile.pretensions, not unilateral.all())
    found = _Seen(_pointers(by_pretension), _pointers(aside))
    if code.tendon_look(ctypes.byref(given), ctypes.byref(found)):
        raise MemoryError("no memory for the states of a tile")
    return _seen(by_pretension, aside)


def _spread(values: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    """Broadcast without a copy, but first laid out row by row: along the designs `look.c` takes steps of one or none.

    Pretensions that differ between cases come with the axes in another order.
    """
    return np.broadcast_to(np.ascontiguousarray(values, dtype=np.float64), shape)


def _field(array: Array) -> _Field:
    """Where an array is and its steps; the array itself has to outlive what is made here."""
    return _Field(array.ctypes.data, (ctypes.c_long * 3)(*(step // array.itemsize for step in array.strides)))


def _pointers(arrays: Array) -> ctypes.Array[ctypes.c_void_p]:
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))


def _seen(by_pretension: Array, aside: Array) -> Seen:
    """What was found. It leaves the compiled code infinite where there was nothing to find; no true result is."""
    low_x, high_x, low_y, high_y, low_motor, high_motor, stiffness, unstable, slack, first = by_pretension
    (
        shortfall,
        flexor_shortfall,
        flexor_limit,
        extensor_shortfall,
        extensor_limit,
        one_sided,
        both,
        nowhere,
        low_torque,
        high_torque,
    ) = aside
    for values in (low_x, high_x, low_y, high_y, low_motor, high_motor, stiffness, first, shortfall, low_torque,
                   high_torque):  # fmt: skip
        values[np.isinf(values)] = np.nan
    return Seen(
        flexor=Range(low_x, high_x),
        extensor=Range(low_y, high_y),
        motor=Range(low_motor, high_motor),
        stiffness=stiffness,
        unstable=unstable,
        slack=slack,
        first_slack_angle=first,
        elbow_torque=Range(low_torque, high_torque),
        shortfall=shortfall,
        sides=(Side(flexor_shortfall, flexor_limit), Side(extensor_shortfall, extensor_limit)),
        one_sided=one_sided > 0.0,
        both_limit=both,
        no_equilibrium=nowhere,
    )
