"""What a study means as a product: its axes, how many designs and states, and how the work is cut.

Designs are numbered in the order of the product, the last axis fastest. A *part* is a range of designs that becomes one
file per table; its length follows from the study alone. The work goes over *blocks* of it, hyper-rectangles of the
product, so that each factor of the model is computed once for the axes that it depends on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from decimal import Decimal
from functools import cached_property

import numpy as np

from tendon_cli.errors import SizeError
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import ADDED
from tendon_cli.quantities import OF_CYCLES, OF_TRAJECTORIES
from tendon_cli.space.axis import Axis
from tendon_cli.space.space import Space
from tendon_cli.studies.checks import is_stated
from tendon_cli.studies.spaces import lengths_of, space_of
from tendon_cli.studies.study import Study

STATES_PER_FILE = 2**21
"""Most states of a study whose tables are single files."""
STATES_PER_PART = 2**19
DESIGNS_PER_PART = 2**18
STATES_PER_PART_WITHOUT_TABLE = 2**27
STATES_PER_BLOCK = 2**16
DESIGNS_AT_ONCE = 2**18
"""Rows of designs that are collected before they are written, since designs do not come in their order."""

_MOST_STATES = 2**63 - 1


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
        return tuple(
            part.stop - part.start for part in (*self.designs, self.directions, self.angles)
        )

    @property
    def design_count(self) -> int:
        """How many consecutive designs the block covers."""
        return math.prod(self.shape[:-2])

    def within(self, whole: Block) -> tuple[slice, ...]:
        """Where its designs stand in those of a larger block."""
        pairs = zip(self.designs, whole.designs, strict=True)
        return tuple(slice(part.start - of.start, part.stop - of.start) for part, of in pairs)

    def first_along(self, axes: Collection[int]) -> Block:
        """The designs of the block that stand first along some axes."""
        first = (
            slice(part.start, part.start + 1) if at in axes else part
            for at, part in enumerate(self.designs)
        )
        return replace(self, designs=tuple(first))

    def cut(self, where: Callable[[Block], int | None]) -> Iterator[Block]:
        """The block, or halves of it and of these: `where` says along which axis one is cut, if at all.

        Along the first axis that varies they come in the order of the rows; else they interlock.
        """
        axis = where(self)
        if axis is None:
            yield self
            return
        slices = [*self.designs, self.directions, self.angles]
        whole, first = slices[axis], self.first_design
        middle = (whole.start + whole.stop) // 2
        for part in (slice(whole.start, middle), slice(middle, whole.stop)):
            slices[axis] = part
            half = Block(first, tuple(slices[:-2]), *slices[-2:])
            yield from half.cut(where)
            first += half.design_count if axis < len(self.designs) else 0


@dataclass(frozen=True)
class Plan:
    """A study as a product. Raises SizeError where it cannot be: over 2^63 states."""

    study: Study
    block_states: int = STATES_PER_BLOCK
    """Most states in a block; the results do not depend on it."""

    def __post_init__(self) -> None:
        if self.states > _MOST_STATES:
            raise SizeError(
                f"{Decimal(self.designs):.3g} designs of {self.states_per_design} states are "
                f"{Decimal(self.states):.3g} states, more than the 2^63 that can be numbered",
                hint="fewer values on an axis, or fewer axes: " + ", ".join(self.study.axes),
            )

    @cached_property
    def space(self) -> Space:
        """Its design axes, and what every number is for a design."""
        return space_of(self.study)

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The design axes, slowest first."""
        return self.space.axes

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each design axis."""
        return lengths_of(self.study)

    @property
    def designs(self) -> int:
        """Number of designs."""
        return math.prod(self.shape)

    @cached_property
    def directions(self) -> tuple[str, ...]:
        """The directions of motion, in the order of the rows; along a trajectory that of its first sample."""
        if self.study.trajectory is not None:
            return ("flexion" if self.study.flexion[0, 0] else "extension",)
        return self.study.motion.direction

    @cached_property
    def elbow_angles(self) -> Array:
        """The elbow angles in rad, in the order of the rows."""
        return self.study.angles

    @cached_property
    def of_forms(self) -> tuple[str, ...]:
        """Columns of `designs` that limits on forms add, each an extreme of its form, if the study states its needs."""
        return tuple(
            each.column for each in ADDED if all(is_stated(self.study, need) for need in each.needs)
        )

    @property
    def of_motion(self) -> tuple[str, ...]:
        """Columns of `designs` that are there as the joint moves at a speed, or along a trajectory."""
        if self.study.trajectory is not None:
            return (*OF_CYCLES, *OF_TRAJECTORIES)
        return OF_CYCLES if self.study.motion.speed is not None else ()

    @property
    def states_per_design(self) -> int:
        """Directions times elbow angles."""
        return len(self.directions) * len(self.elbow_angles)

    @property
    def states(self) -> int:
        """Number of states of all designs."""
        return self.designs * self.states_per_design

    @property
    def part_designs(self) -> int:
        """Designs in each part but the last: more than half of what may be, so that it is a block, or a few."""
        if self.states <= STATES_PER_FILE:
            return self.designs
        with_states = "states" in self.study.output.tables
        states = STATES_PER_PART if with_states else STATES_PER_PART_WITHOUT_TABLE
        most = max(1, min(DESIGNS_PER_PART, states // self.states_per_design))
        whole = 1
        for length in reversed(self.shape):
            if whole * length > most:
                break
            whole *= length
        return most // whole * whole

    @property
    def parts(self) -> int:
        """Number of parts."""
        return -(-self.designs // self.part_designs)

    def part(self, index: int) -> range:
        """The designs of a part."""
        return part_of(self.designs, self.part_designs, index)

    def rows(self, table: str, designs: range) -> int:
        """Rows that a range of designs has in a table."""
        return len(designs) * (self.states_per_design if table == "states" else 1)

    def blocks(self, designs: range, states: int | None = None) -> Iterator[Block]:
        """Cut a range of designs into blocks, in the order of the rows, of at most `states` states each."""

        def where(block: Block) -> int | None:
            too_many = states is not None and math.prod(block.shape) > states
            return (
                next(axis for axis, length in enumerate(block.shape) if length > 1)
                if too_many
                else None
            )

        at = designs.start
        while at < designs.stop:
            block = self._block_from(at, designs.stop - at)
            yield from block.cut(where)
            at += block.design_count

    def blocks_of_designs(self, designs: range) -> Iterator[Block]:
        """Cut a range of designs into the fewest blocks, none of which goes beyond what is collected at once."""
        for start in range(0, len(designs), DESIGNS_AT_ONCE):
            yield from self.blocks(designs[start : start + DESIGNS_AT_ONCE])

    def coordinates(self, design: int) -> tuple[int, ...]:
        """Position of a design on each axis."""
        return tuple(map(int, np.unravel_index(design, self.shape)))

    def motion(self, block: Block) -> tuple[Array, Flags]:
        """Elbow angles (1, K) and whether it is flexion, (D, 1) or along a trajectory (1, K)."""
        flexion = self.study.flexion[block.directions]
        at = self.elbow_angles[block.angles].reshape(1, -1)
        return at, flexion if self.study.trajectory is None else flexion[:, block.angles]

    def design(self, block: Block) -> Design:
        """The designs of a block, as the model takes them."""
        return self.space.design(block.designs)

    def state(self, block: Block, design: Design | None = None) -> State:
        """What the states of a block depend on; `design` if it is known."""
        return State.of(design or self.design(block), *self.motion(block))

    def _block_from(self, design: int, most: int) -> Block:
        """The largest block of at most `most` designs that starts at a design and covers consecutive ones."""
        position = self.coordinates(design)
        whole, axis = 1, len(self.shape)  # from `axis` on axes are covered whole
        while axis > 0 and position[axis - 1] == 0 and whole * self.shape[axis - 1] <= most:
            axis -= 1
            whole *= self.shape[axis]
        slices = [slice(at, at + 1) for at in position[:axis]] + [
            slice(0, length) for length in self.shape[axis:]
        ]
        if axis > 0:
            along = min(self.shape[axis - 1] - position[axis - 1], most // whole)
            slices[axis - 1] = slice(position[axis - 1], position[axis - 1] + along)
        return Block(
            design, tuple(slices), slice(0, len(self.directions)), slice(0, len(self.elbow_angles))
        )


def part_of(count: int, length: int, index: int) -> range:
    """One of the parts of so many designs or choices, each but the last of one length."""
    return range(count)[index * length : (index + 1) * length]


def bounds_of(study: Study) -> Bounds:
    """The limits of a study, as the model holds states to them."""
    speed = study.motion.speed
    return Bounds(speed=math.nan if speed is None else speed.single, **study.limits)
