"""Blocks of a plan, and how they are cut so that what is worked out for each takes little memory."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

from tendon_cli import kernel

if TYPE_CHECKING:
    from tendon_cli.engine.plan import Plan

VALUES_AT_ONCE = 2**18
"""In an array that compiled code is given."""
_DESIGNS, _STATES = 2**15, 2**24
"""That are worked out at once."""


@dataclass(frozen=True)
class Block:
    """A hyper-rectangle of the product: a slice per design axis, the directions, and the elbow angles."""

    first_design: int
    designs: tuple[slice, ...]
    directions: slice
    angles: slice

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each design axis, then directions, then angles."""
        return tuple(part.stop - part.start for part in (*self.designs, self.directions, self.angles))

    @property
    def design_count(self) -> int:
        """How many consecutive designs the block covers."""
        return math.prod(self.shape[:-2])

    @property
    def numbers(self) -> range:
        """The designs of the block by their numbers."""
        return range(self.first_design, self.first_design + self.design_count)

    def halves(self, axis: int) -> tuple[Block, Block]:
        """The block cut in two along a design axis; unless it is the first that varies, the halves interlock."""
        whole = self.designs[axis]
        middle = (whole.start + whole.stop) // 2
        first, second = (
            replace(self, designs=(*self.designs[:axis], part, *self.designs[axis + 1 :]))
            for part in (slice(whole.start, middle), slice(middle, whole.stop))
        )
        return first, second

    def first_along(self, axes: Collection[int]) -> Block:
        """The designs of the block that stand first along some axes."""
        designs = (
            slice(part.start, part.start + 1) if axis in axes else part for axis, part in enumerate(self.designs)
        )
        return replace(self, designs=tuple(designs))

    def by_angles(self, most: int) -> Iterator[Block]:
        """The block in stretches of at most so many elbow angles."""
        for start in range(self.angles.start, self.angles.stop, most):
            yield replace(self, angles=slice(start, min(start + most, self.angles.stop)))


def angles_at_once(plan: Plan) -> int:
    """How many elbow angles of a design are best taken at once; the results do not depend on it."""
    return VALUES_AT_ONCE if kernel.kind() else plan.block_states


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
    lengths, free, arm = block.shape[:-2], plan.only_pretension, plan.of_the_arm
    whole = frozenset(range(len(lengths)))
    most_of = [
        (whole, 1, _DESIGNS),
        (whole - free, plan.states_per_design, plan.block_states),
    ]
    if kernel.kind():
        per_arm, states = len(plan.elbow_angles), plan.states_per_design
        most_of = [
            (whole, 1, _DESIGNS),
            (whole, states, _STATES),
            (arm, per_arm, VALUES_AT_ONCE),
            (whole - free, 2, VALUES_AT_ONCE),
        ]
    for axes, each, most in most_of:
        long = [axis for axis in axes if lengths[axis] > 1]
        if long and each * math.prod(lengths[axis] for axis in long) > most:
            return max(long, key=lambda axis: (axis not in free, lengths[axis]))
    return None
