"""A study as a product: its axes, its designs and states, and the parts the work is cut into.

Designs are numbered in the order of the product, the last axis fastest. A *part* is a range of
designs that becomes one file per table; its length follows from the study alone. The work goes over
*blocks* of a part, hyper-rectangles of the product, so that each factor of the model is computed
once for the axes that it depends on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from decimal import Decimal
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tendon_cli.errors import SizeError
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Real
from tendon_cli.model.limits import ADDED, LIMITS
from tendon_cli.quantities import OF_CYCLES, OF_TRAJECTORIES
from tendon_cli.studies.checks import is_stated
from tendon_cli.studies.space.axis import Axis
from tendon_cli.studies.space.space import Space
from tendon_cli.studies.spaces import lengths_of, space_of
from tendon_cli.studies.study import Study

if TYPE_CHECKING:
    from tendon_cli.model.moving import Moving

STATES_PER_FILE = 2**21
"""Most states of a study whose tables are single files."""
STATES_PER_PART = 2**19
"""Most states in a part if the study has a table of states."""
DESIGNS_PER_PART = 2**18
"""Most designs in a part."""
STATES_PER_PART_WITHOUT_TABLE = 2**27
"""Most states in a part if the study has no table of states."""
STATES_PER_BLOCK = 2**16
"""Most states in a block."""
DESIGNS_AT_ONCE = 2**18
"""Rows of designs that are collected before they are written, since they come out of order."""

_MOST_STATES = 2**63 - 1


@dataclass(frozen=True)
class Block:
    """Hyper-rectangle of the product: a slice per design axis, the directions, the elbow angles."""

    first_design: int
    designs: tuple[slice, ...]
    directions: slice
    angles: slice

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each design axis, then directions, then angles."""
        slices = (*self.designs, self.directions, self.angles)
        return tuple(part.stop - part.start for part in slices)

    @property
    def design_count(self) -> int:
        """Number of consecutive designs that the block covers."""
        return math.prod(self.shape[:-2])

    def within(self, whole: Block) -> tuple[slice, ...]:
        """Return the place of this block's designs among those of a larger block."""
        pairs = zip(self.designs, whole.designs, strict=True)
        return tuple(
            slice(part.start - larger.start, part.stop - larger.start) for part, larger in pairs
        )

    def first_along(self, axes: Collection[int]) -> Block:
        """Return the block with only the first value along some design axes."""
        designs = tuple(
            slice(part.start, part.start + 1) if axis in axes else part
            for axis, part in enumerate(self.designs)
        )
        return replace(self, designs=designs)

    def cut(self, axis_to_cut: Callable[[Block], int | None]) -> Iterator[Block]:
        """Yield the block, or its halves, or halves of these.

        Cut along the first axis that varies, blocks come in the order of the rows; cut along
        another, their rows interlock.

        Args:
            axis_to_cut: Returns the axis along which a block is to be halved; None if it may stay.
        """
        axis = axis_to_cut(self)
        if axis is None:
            yield self
            return
        slices = [*self.designs, self.directions, self.angles]
        whole = slices[axis]
        middle = (whole.start + whole.stop) // 2
        first_design = self.first_design
        for part in (slice(whole.start, middle), slice(middle, whole.stop)):
            slices[axis] = part
            half = Block(first_design, tuple(slices[:-2]), *slices[-2:])
            yield from half.cut(axis_to_cut)
            if axis < len(self.designs):
                first_design += half.design_count


@dataclass(frozen=True)
class Plan:
    """A study as a product.

    Raises:
        SizeError: The study has over 2^63 states.
    """

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
        """Design axes of the study, and the value of every number for a design."""
        return space_of(self.study)

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Design axes, slowest first."""
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
        """Directions of motion in the order of the rows; along a trajectory that of its start."""
        if self.study.trajectory is not None:
            return ("flexion" if self.study.flexion[0, 0] else "extension",)
        return self.study.motion.direction

    @cached_property
    def elbow_angles(self) -> Array:
        """Elbow angles in the order of the rows, rad."""
        return self.study.angles

    @cached_property
    def of_forms(self) -> tuple[str, ...]:
        """Columns of `designs` that limits on forms of states add, each an extreme of its form.

        A limit adds its column if the study states all that it needs.
        """
        return tuple(
            limit.column
            for limit in ADDED
            if all(is_stated(self.study, need.key) for need in limit.needs)
        )

    @property
    def of_motion(self) -> tuple[str, ...]:
        """Columns of `designs` that a speed of the joint, or a trajectory, adds."""
        return columns_of_motion(self.study)

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
        """Designs in each part but the last.

        A multiple of as many whole inner axes as fit, and more than half of what a part may have:
        so a part is one block, or a few.
        """
        if self.states <= STATES_PER_FILE:
            return self.designs
        has_states_table = "states" in self.study.output.tables
        most_states = STATES_PER_PART if has_states_table else STATES_PER_PART_WITHOUT_TABLE
        most = max(1, min(DESIGNS_PER_PART, most_states // self.states_per_design))
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
        """Return the designs of a part."""
        return part_range(self.designs, self.part_designs, index)

    def rows(self, table: str, designs: range) -> int:
        """Return the number of rows that a range of designs has in a table."""
        rows_per_design = self.states_per_design if table == "states" else 1
        return len(designs) * rows_per_design

    def blocks(self, designs: range, states: int | None = None) -> Iterator[Block]:
        """Yield a range of designs as blocks, in the order of the rows.

        Args:
            designs: Consecutive designs.
            states: Most states in a block; None for no bound.
        """

        def axis_to_cut(block: Block) -> int | None:
            if states is None or math.prod(block.shape) <= states:
                return None
            return next(axis for axis, length in enumerate(block.shape) if length > 1)

        first = designs.start
        while first < designs.stop:
            block = self._block_from(first, designs.stop - first)
            yield from block.cut(axis_to_cut)
            first += block.design_count

    def blocks_of_designs(self, designs: range) -> Iterator[Block]:
        """Yield a range of designs as the fewest blocks, each of which can be collected at once."""
        for start in range(0, len(designs), DESIGNS_AT_ONCE):
            yield from self.blocks(designs[start : start + DESIGNS_AT_ONCE])

    def coordinates(self, design: int) -> tuple[int, ...]:
        """Return the position of a design on each axis."""
        return tuple(map(int, np.unravel_index(design, self.shape)))

    def motion(self, block: Block) -> tuple[Array, Flags]:
        """Return the elbow angles and directions of a block.

        Returns:
            Elbow angles (1, angles), rad, and True where the elbow flexes: (directions, 1), or
            along a trajectory, where tendons may slide the other way, (1, angles).
        """
        angles = self.elbow_angles[block.angles].reshape(1, -1)
        flexion = self.study.flexion[block.directions]
        if self.study.trajectory is not None:
            flexion = flexion[:, block.angles]
        return angles, flexion

    def design(self, block: Block) -> Design:
        """Return the designs of a block, as the model takes them."""
        return self.space.design(block.designs)

    def state(self, block: Block, design: Design | None = None) -> State:
        """Return the states of a block, whose results the model computes when they are asked for.

        Args:
            block: The states.
            design: Designs of the block, if the caller has them already.
        """
        if self.study.trajectory is None:
            return State.of(design or self.design(block), *self.motion(block))
        from tendon_cli.model.moving import at_samples  # only a study of motion pays for its import

        state = self.moving(block, design).state
        is_whole = block.shape[-1] == len(self.elbow_angles)
        return state if is_whole else at_samples(state, block.angles, len(self.elbow_angles))

    def moving(self, block: Block, design: Design | None = None) -> Moving:
        """Return the designs of a block along the whole trajectory of the study.

        Args:
            block: The designs.
            design: The same designs, if the caller has them already.
        """
        from tendon_cli.model.moving import Moving  # only a study of motion pays for its import

        trajectory = self.study.trajectory
        if trajectory is None:
            raise ValueError("the study has no trajectory")
        return Moving.of(design or self.design(block), trajectory)

    def _block_from(self, design: int, most: int) -> Block:
        """Return the largest block of consecutive designs from one on, at most `most` of them."""
        position = self.coordinates(design)
        axis = len(self.shape)  # from this axis on the block covers axes whole
        whole = 1  # designs along these
        while axis > 0 and position[axis - 1] == 0 and whole * self.shape[axis - 1] <= most:
            axis -= 1
            whole *= self.shape[axis]
        slices = [slice(place, place + 1) for place in position[:axis]]
        slices += [slice(0, length) for length in self.shape[axis:]]
        if axis > 0:
            start = position[axis - 1]
            length = min(self.shape[axis - 1] - start, most // whole)
            slices[axis - 1] = slice(start, start + length)
        directions = slice(0, len(self.directions))
        angles = slice(0, len(self.elbow_angles))
        return Block(design, tuple(slices), directions, angles)


def part_range(count: int, length: int, index: int) -> range:
    """Return one part of `count` designs or choices, each part but the last of one length."""
    return range(count)[index * length : (index + 1) * length]


def columns_of_motion(study: Study) -> tuple[str, ...]:
    """Return the columns of a design that a speed of the joint, or a trajectory, adds."""
    if study.trajectory is not None:
        return (*OF_CYCLES, *OF_TRAJECTORIES)
    return OF_CYCLES if study.motion.speed is not None else ()


def bounds_of(study: Study, space: Space) -> Bounds:
    """Return the limits of a study as the model takes them, with the speed of the elbow.

    A limit that differs between designs has all of its values, (values,): they say that it is
    asked for, and `Bounds.of` gives each design its own.

    Args:
        study: The study.
        space: Its space, or one with the same limits.
    """
    speed = study.motion.speed
    of_axes: dict[str, Real] = {
        name: LIMITS[name].bound_of(np.ravel(limit.within(space.whole)))
        for name, limit in space.limits.items()
    }
    return Bounds(speed=math.nan if speed is None else speed.single, **{**study.limits, **of_axes})
