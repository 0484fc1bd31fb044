"""Choices of a sweep: what a designer picks, each feasible if its designs are so under all conditions at once.

A choice is a combination of the axes that are no condition; its designs may be spread over the whole run. Each part
notes which of its choices have only feasible designs in it, a bit each, packed; a choice is feasible if every part says
so. That takes a bit of memory for each, and is the same after an interruption and on a cluster.
"""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.engine.blocks import Block
from tendon_cli.engine.plan import Plan

Flags = npt.NDArray[np.bool_]


def _chosen(plan: Plan) -> list[int]:
    """The design axes that are no conditions."""
    return [at for at, key in enumerate(plan.study.axes) if key not in plan.study.conditions]


def choices(plan: Plan) -> int:
    """How many choices a study has."""
    return math.prod(plan.shape[axis] for axis in _chosen(plan))


def choices_of(plan: Plan, block: Block) -> range:
    """The choices of a block of consecutive designs, which are consecutive, too."""
    chosen, first = _chosen(plan), 0
    for axis in chosen:
        first = first * plan.shape[axis] + block.designs[axis].start
    return range(first, first + math.prod(block.shape[axis] for axis in chosen))


def noted(plan: Plan, blocks: Sequence[tuple[Block, Flags]]) -> str:
    """Which choices of a part have only feasible designs in it, from the designs of its blocks; as text."""
    conditions = tuple(set(range(len(plan.shape))) - set(_chosen(plan)))
    bits = [np.logical_and.reduce(feasible, axis=conditions).ravel() for _, feasible in blocks]
    packed = np.packbits(np.concatenate(bits)) if bits else np.zeros(0, np.uint8)
    return base64.b64encode(zlib.compress(packed.tobytes(), 6)).decode()


def is_flags(plan: Plan, designs: range, note: Any) -> bool:
    """Whether a text says of each choice of a part whether it is feasible."""
    return _flags(note, sum(len(choices_of(plan, block)) for block in plan.blocks_of_designs(designs))) is not None


def feasible_choices(plan: Plan, notes: Iterable[str]) -> int:
    """How many choices are feasible in a run, from what all its parts say of theirs, in their order."""
    still = np.packbits(np.ones(choices(plan), np.bool_))
    for index, note in enumerate(notes):
        ranges = [choices_of(plan, block) for block in plan.blocks_of_designs(plan.part(index))]
        flags = _flags(note, sum(map(len, ranges)))
        if flags is None:
            raise ValueError(f"part {index} does not say which choices are feasible")
        for here in ranges:
            whole = slice(here.start // 8, -(-here.stop // 8))
            bits = np.unpackbits(still[whole])
            bits[here.start - 8 * whole.start : here.stop - 8 * whole.start] &= flags[: len(here)]
            still[whole], flags = np.packbits(bits), flags[len(here) :]
    return int(np.bitwise_count(still).sum())


def _flags(note: Any, count: int) -> npt.NDArray[np.uint8] | None:
    """The flags of a text, zero or one; nothing where it does not hold just so many."""
    size = -(-count // 8)
    try:
        packed = zlib.decompressobj().decompress(base64.b64decode(note, validate=True), size + 1)
    except (zlib.error, binascii.Error, ValueError, TypeError):
        return None
    return np.unpackbits(np.frombuffer(packed, np.uint8))[:count] if len(packed) == size else None
