"""A look at all states of a tile by compiled code: the arithmetic of `lines`, to the same bits, but much faster."""

from __future__ import annotations

import ctypes

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array
from tendon_cli.sweep import native
from tendon_cli.sweep.tile import Range, Seen, Side, Tile

_FOUND, _ASIDE = 10, 10


class _Tile(ctypes.Structure):
    """`Tile` in `kernel/look.h`."""

    _fields_ = (
        *native.named_fields(*native.STATES, "pretension"),
        ("angle", ctypes.c_void_p),
        *((name, ctypes.c_long) for name in ("angles", "directions", "designs", "pretensions", "any_bilateral")),
    )


class _Seen(ctypes.Structure):
    """`Seen` in `kernel/look.h`."""

    _fields_ = (("found", ctypes.c_void_p * _FOUND), ("aside", ctypes.c_void_p * _ASIDE))


def look(tile: Tile, code: ctypes.CDLL) -> Seen:
    """Look at all states of a tile, once for each pretension, by what `library` gave; safe from several threads."""
    states = native.states(tile.design, tile.motion, tile.flexor, tile.extensor, tile.moment, tile.inclination)
    whole = tile.pretensions, *tile.shape[1:]
    arrays = [_laid_out(values) for values in (*states, tile.pretension)]
    angle = np.ascontiguousarray(tile.elbow_angle)
    found, aside = np.empty((_FOUND, *whole)), np.empty((_ASIDE, *whole[1:]))
    lengths = *tile.shape, tile.pretensions
    given = _Tile(*map(native.field, arrays), angle.ctypes.data, *lengths, not np.all(tile.design.unilateral))
    seen = _Seen(native.pointers(list(found)), native.pointers(list(aside)))
    if code.tendon_look(ctypes.byref(given), ctypes.byref(seen)):
        raise MemoryError("no memory for the states of a tile")
    return _seen(found, aside)


def _laid_out(values: npt.ArrayLike) -> Array:
    """Over three axes, row by row: along the designs the compiled code takes steps of one or none.

    Pretensions that differ between cases come with the axes in another order.
    """
    array = np.ascontiguousarray(values, dtype=np.float64)
    return array.reshape((1,) * (3 - array.ndim) + array.shape)


def _seen(found: Array, aside: Array) -> Seen:
    """What was found, by name."""
    low_x, high_x, low_y, high_y, low_motor, high_motor, stiffness, unstable, slack, first = found
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
