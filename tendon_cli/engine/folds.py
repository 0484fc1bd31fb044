"""The folds over the states of a plan's designs: rows of `designs` with their windows; and over these: choices."""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.engine.plan import Block, Flags, Plan
from tendon_cli.model import extremes, window
from tendon_cli.model.design import Design
from tendon_cli.model.extremes import Found
from tendon_cli.quantities import OF_CYCLES

VALUES_AT_ONCE = 2**18
"""In an array that compiled code is given, and states of which NumPy has several arrays."""
_DESIGNS, _STATES = 2**15, 2**24
"""That are worked out at once."""
_MOST_KEPT, _MOST_BEFORE = 2**17, 2**25
"""Windows of all designs that are kept in memory, and states that are gone over before any part, if no more."""

COUNTED = ("taut", "stable", "feasible", "slack", "no_equilibrium", "unstable")
"""What the record counts: designs with each judgement, states that are slack, without equilibrium or unstable."""


def small_blocks(plan: Plan, block: Block) -> Iterator[Block]:
    """The block, or halves of it and of these, so that what is worked out for it takes little memory."""
    axis = _to_cut(plan, block)
    if axis is None:
        yield block
        return
    for half in block.halves(axis):
        yield from small_blocks(plan, half)


def _to_cut(plan: Plan, block: Block) -> int | None:
    """Where a block has to be cut in two, if at all: best where pretension goes on along all its values."""
    lengths, free, states = block.shape[:-2], plan.only_pretension, plan.states_per_design
    whole = frozenset(range(len(lengths)))
    most_of = [(whole, 1, _DESIGNS)]
    if kernel.kind():
        per_arm = len(plan.elbow_angles)
        most_of += [(whole, states, _STATES), (plan.of_the_arm, per_arm, VALUES_AT_ONCE)]
        most_of += [(whole - free, 2, VALUES_AT_ONCE)]
    else:
        most_of += [(whole, states, plan.block_states)]
    if plan.of_forms or plan.of_motion:  # NumPy has arrays of all states
        most_of += [(whole, states, VALUES_AT_ONCE)]
    for axes, each, most in most_of:
        long = [axis for axis in axes if lengths[axis] > 1]
        if long and each * math.prod(lengths[axis] for axis in long) > most:
            return max(long, key=lambda axis: (axis not in free, lengths[axis]))
    return None


@dataclass(frozen=True, eq=False)
class Folds:
    """What the designs of a plan come to."""

    plan: Plan

    def designs(self, block: Block) -> dict[str, npt.NDArray[Any]]:
        """Results and judgements of the designs of a small block, and how many of their states are what is counted."""
        plan, design = self.plan, self.plan.design(block)
        folded = extremes.begin(block.shape[:-2])
        for stretch in self._stretches(block):
            kernel.fold_extremes(folded, plan.inputs(stretch, design), plan.elbow_angles[stretch.angles], stretch.shape)
        results = extremes.as_read(extremes.finished(folded, plan.states_per_design), design)
        results |= self._by_numpy(block, design) | extremes.of_design(design, folded) | self.windows(block, design)
        return results | extremes.judged(results, plan.study.limits) | {name: folded[name] for name in extremes.COUNTS}

    def windows(self, block: Block, design: Design) -> Found:
        """The windows of a block, worked out once for all designs that differ in pretension alone."""
        free = self.plan.only_pretension
        if self.known_windows is not None:
            place = tuple(slice(0, 1) if axis in free else part for axis, part in enumerate(block.designs))
            columns = {name: values[place] for name, values in self.known_windows.items()}
        else:
            first = block.first_along(free)
            columns = self._windows(first, design if first.shape == block.shape else self.plan.design(first))
        return {name: np.broadcast_to(values, block.shape[:-2]) for name, values in columns.items()}

    @cached_property
    def known_windows(self) -> Found | None:
        """Those of the whole plan, if blocks share them and they are few."""
        plan, free = self.plan, self.plan.only_pretension
        designs = tuple(slice(0, 1 if axis in free else length) for axis, length in enumerate(plan.shape))
        every = Block(0, designs, slice(0, len(plan.directions)), slice(0, len(plan.elbow_angles)))
        states, most = math.prod(every.shape), _MOST_BEFORE if kernel.kind() else _MOST_BEFORE // 16
        if every.design_count == plan.designs or every.design_count > _MOST_KEPT or states > most:
            return None
        columns = {name: np.empty(every.shape[:-2]) for name in ("pretension_from", "pretension_to")}
        for block in small_blocks(plan, every):
            for name, values in self._windows(block, plan.design(block)).items():
                columns[name][block.designs] = values
        return columns

    def _windows(self, block: Block, design: Design) -> Found:
        plan, bounds = self.plan, self.plan.bounds
        if bounds.of_motion:  # limits over several states at once
            from tendon_cli.model.motor_window import narrowed  # only these pay for its import

            motion = plan.motion(block)
            ends: window.Ends = narrowed(window.window(design, *motion, bounds), design, *motion, bounds).window
        else:
            folded = window.begin(block.shape[:-2])
            for stretch in self._stretches(block):
                at, count = plan.inputs(stretch, design), len(plan.elbow_angles)
                kernel.fold_window(folded, at, bounds, stretch.shape, stretch.angles.start, count)
            ends = window.finished(folded, design, bounds)
        ends = window.as_read(ends, design)
        return {"pretension_from": ends.low, "pretension_to": np.where(np.isinf(ends.high), np.nan, ends.high)}

    def _stretches(self, block: Block) -> Iterator[Block]:
        """The block in what is best taken at once; the results do not depend on it."""
        return block.by_angles(VALUES_AT_ONCE if kernel.kind() else self.plan.block_states)

    def _by_numpy(self, block: Block, design: Design) -> Found:
        """What compiled code does not know: columns that a speed of the elbow adds, and those of forms of states."""
        plan, speed = self.plan, self.plan.study.motion.speed
        columns = extremes.of_forms(plan.of_forms, plan.inputs(block, design)) if plan.of_forms else {}
        if plan.study.trajectory is not None:
            from tendon_cli.model.motor import along  # only a study of motion pays for its import

            columns |= along(design, plan.study.trajectory)
        elif speed is not None:
            from tendon_cli.model.motor import cycle

            motor = cycle(design, *plan.motion(block), speed.single)
            columns |= {name: getattr(motor, name) for name in OF_CYCLES}
        return {name: np.broadcast_to(values, block.shape[:-2]) for name, values in columns.items()}


# --- Choices ---------------------------------------------------------------------------------------------------------
#
# A choice is a combination of the axes that are no condition, feasible if its designs are so under all conditions at
# once; these may be spread over the whole run. Each part notes which of its choices have only feasible designs in it, a
# bit each, packed; a choice is feasible if every part says so. That takes a bit of memory for each, and is the same
# after an interruption and on a cluster.


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
