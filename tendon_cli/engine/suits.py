"""Suits: what a designer chooses, each feasible where its designs are so under all conditions at once.

A suit is a combination of the axes that are no condition; its designs may be spread over the whole run. Each part notes
which of its suits have only feasible designs in it, a bit a suit, packed; a run is feasible for those that every part
says so of. That takes a bit of memory for each suit, and is the same after an interruption and on a cluster.
"""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from tendon_cli.engine.plan import Block, Plan

Flags = npt.NDArray[np.bool_]


def _choices(plan: Plan) -> list[int]:
    """The design axes that are no conditions."""
    return [at for at, key in enumerate(plan.study.axes) if key not in plan.study.conditions]


def suits(plan: Plan) -> int:
    """How many suits a study has."""
    return math.prod(plan.shape[axis] for axis in _choices(plan))


def suits_of(plan: Plan, block: Block) -> range:
    """The suits of a block of consecutive designs, which are consecutive, too."""
    choices = _choices(plan)
    first = 0
    for axis in choices:
        first = first * plan.shape[axis] + block.designs[axis].start
    return range(first, first + math.prod(block.shape[axis] for axis in choices))


def noted(plan: Plan, blocks: Sequence[tuple[Block, Flags]]) -> str:
    """Which suits of a part have only feasible designs in it, from the designs of its blocks; as text."""
    conditions = tuple(set(range(len(plan.shape))) - set(_choices(plan)))
    bits = [np.logical_and.reduce(feasible, axis=conditions).ravel() for _, feasible in blocks]
    packed = np.packbits(np.concatenate(bits)) if bits else np.zeros(0, np.uint8)
    return base64.b64encode(zlib.compress(packed.tobytes(), 6)).decode()


def is_note(plan: Plan, designs: range, note: str) -> bool:
    """Whether a note of a part is as `noted` made it."""
    return _read(note, sum(len(suits_of(plan, block)) for block in plan.blocks_of_designs(designs))) is not None


def feasible_suits(plan: Plan, notes: Iterable[tuple[int, str]]) -> int:
    """How many suits are feasible in a run, from the notes of all its parts by their numbers."""
    count = suits(plan)
    still = np.packbits(np.ones(count, np.bool_))
    for index, note in notes:
        ranges = [suits_of(plan, block) for block in plan.blocks_of_designs(plan.part(index))]
        flags = _read(note, sum(map(len, ranges)))
        if flags is None:
            raise ValueError(f"part {index} does not say which suits are feasible")
        for here in ranges:
            whole = slice(here.start // 8, -(-here.stop // 8))
            bits = np.unpackbits(still[whole])
            bits[here.start - 8 * whole.start : here.stop - 8 * whole.start] &= flags[: len(here)]
            still[whole], flags = np.packbits(bits), flags[len(here) :]
    return int(np.bitwise_count(still).sum())


def _read(note: str, count: int) -> npt.NDArray[np.uint8] | None:
    """The flags of a note, zero or one; nothing where it does not hold just so many."""
    size = -(-count // 8)
    try:
        packed = zlib.decompressobj().decompress(base64.b64decode(note, validate=True), size + 1)
    except (zlib.error, binascii.Error, ValueError):
        return None
    return np.unpackbits(np.frombuffer(packed, np.uint8))[:count] if len(packed) == size else None
