"""Rows of the states table for a block: by compiled code, straight to where they are gathered, or by NumPy.

Both give the same bits; `evaluate` is what the compiled code in `kernel/rows.h` says again.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model import actuator, statics
from tendon_cli.model.kinematics import Array, kinematics
from tendon_cli.sweep import native
from tendon_cli.sweep.columns import STATE_RESULTS
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Block
from tendon_cli.tables.write import Filler, copied, has_nan

_ENDS = (
    "pretension", "flexor_pretension", "extensor_pretension", "flexor_capstan", "extensor_capstan", "flexor_tendon",
    "extensor_tendon", "flexor_spring", "extensor_spring", "flexor_radius", "moment_arm",
)  # fmt: skip


class _Block(ctypes.Structure):
    """`Block` in `kernel/rows.h`."""

    _fields_ = (
        *native.named_fields(*native.STATES, *_ENDS),
        *((name, ctypes.c_long) for name in ("designs", "directions", "angles", "any_bilateral")),
    )


class _Key(ctypes.Structure):
    """`Key` in `kernel/rows.h`."""

    _fields_ = (("from", native.Field), ("to", ctypes.c_void_p), ("bytes", ctypes.c_long))


class _Table(ctypes.Structure):
    """`Table` in `kernel/rows.h`."""

    _fields_ = (
        ("column", ctypes.c_void_p * len(STATE_RESULTS)),
        ("status", ctypes.c_void_p),
        ("key", ctypes.c_void_p),
        ("keys", ctypes.c_long),
    )


def blocks_of_rows() -> int:
    """How many blocks of a plan are best written at once; the rows do not depend on it."""
    return 4 if native.library() else 1


def state_rows(inputs: Inputs, block: Block, keys: Mapping[str, npt.ArrayLike]) -> Filler:
    """What writes the rows of a block; `keys` are the columns that say which design and state a row is."""
    code = native.library()
    if code:
        return BlockRows.of(inputs, block, keys, code).write
    from tendon_cli.sweep.evaluate import evaluate, state_columns  # not where nobody asks for it

    evaluated = evaluate(inputs, block)
    return copied({**keys, "status": evaluated.state.status, **state_columns(evaluated)}, block.shape)


@dataclass(frozen=True, eq=False)
class BlockRows:
    """What the compiled code needs to write the rows of a block."""

    code: ctypes.CDLL
    block: _Block
    arrays: list[Array]
    """What `block` points to."""
    keys: dict[str, npt.NDArray[Any]]

    @classmethod
    def of(cls, inputs: Inputs, block: Block, keys: Mapping[str, npt.ArrayLike], code: ctypes.CDLL) -> BlockRows:
        """Work out what varies less than the states do."""
        design, (elbow_angle, flexion) = inputs.design(block), inputs.motion(block)
        motion = kinematics(design.arm.anchors, elbow_angle, from_initial=design.from_initial)
        flexor, extensor = actuator.transmissions(design, flexion)
        inclination = np.add(elbow_angle, design.arm.upper_arm_angle)
        moment = actuator.gravity_moment(design.arm, design.load_mass)
        pretensions = design.flexor.pretension, design.extensor.pretension
        common = statics.common_pretension(design.ratio, flexor.compliance, extensor.compliance, *pretensions)
        values = (
            *native.states(design, motion, flexor, extensor, moment, inclination), common, *pretensions, flexor.capstan,
            extensor.capstan, flexor.tendon, extensor.tendon, flexor.spring, extensor.spring, design.flexor_radius,
            motion.flexor_moment_arm,
        )  # fmt: skip
        lengths = block.shape[:-2]
        arrays = [_by_row(np.asarray(each, dtype=np.float64), lengths) for each in values]
        shape = block.design_count, *block.shape[-2:]
        whole = _Block(*map(native.field, arrays), *shape, not np.all(design.unilateral))
        return cls(code, whole, arrays, {name: _by_row(np.asarray(key), lengths) for name, key in keys.items()})

    def write(self, columns: Mapping[str, npt.NDArray[Any]], rows: range) -> set[str]:
        """Write some of the block's rows into columns of that many rows; safe from several threads."""
        keys = {name: np.asarray(key, dtype=columns[name].dtype) for name, key in self.keys.items()}
        sources = (_Key * len(keys))(
            *(_Key(native.field(key), columns[name].ctypes.data, key.itemsize) for name, key in keys.items())
        )
        places = native.pointers([columns[name] for name in STATE_RESULTS])
        table = _Table(places, columns["status"].ctypes.data, ctypes.addressof(sources), len(sources))
        nulls = (ctypes.c_char * len(STATE_RESULTS))()
        first, count = ctypes.c_long(rows.start), ctypes.c_long(len(rows))
        self.code.tendon_rows(ctypes.byref(self.block), ctypes.byref(table), first, count, nulls)
        null_keys = {name for name, values in keys.items() if has_nan(values)}
        return null_keys | {name for name, found in zip(STATE_RESULTS, nulls.raw, strict=True) if found}


def _by_row(values: npt.NDArray[Any], lengths: tuple[int, ...]) -> npt.NDArray[Any]:
    """Values that broadcast to a block whose design axes have some lengths, over designs, directions and angles."""
    array = np.ascontiguousarray(values)
    array = array.reshape((1,) * (len(lengths) + 2 - array.ndim) + array.shape)
    if array.shape[:-2] not in (lengths, (1,) * len(lengths)):
        array = np.broadcast_to(array, (*lengths, *array.shape[-2:]))
    return array.reshape(-1, *array.shape[-2:])
