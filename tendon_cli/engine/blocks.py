"""Blocks of a product of axes: what the model is given at once."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cached_property


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
