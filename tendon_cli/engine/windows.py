"""The windows of pretension of a plan's designs, and how much is best worked out at once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tendon_cli import kernel
from tendon_cli.engine.plan import Block, Plan, bounds_of
from tendon_cli.model import window
from tendon_cli.model.actuator import Situation
from tendon_cli.model.design import Design
from tendon_cli.model.extremes import Found

VALUES_AT_ONCE = 2**18
"""In an array that compiled code is given."""
_DESIGNS, _STATES = 2**15, 2**24
"""That are worked out at once."""
_MOST_KEPT, _MOST_BEFORE = 2**17, 2**25
"""Windows of all designs that are kept in memory, and states that are gone over before any part, if no more."""


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


@dataclass(frozen=True, eq=False)
class PlanWindows:
    """Worked out once for all designs that differ in pretension alone."""

    plan: Plan

    def columns(self, block: Block, design: Design) -> Found:
        """The columns of a block of designs."""
        free = self.plan.only_pretension
        if self.known is not None:
            place = tuple(slice(0, 1) if axis in free else part for axis, part in enumerate(block.designs))
            found = {name: values[place] for name, values in self.known.items()}
        else:
            first = block.first_along(free)
            found = self._columns(first, design if first.shape == block.shape else self.plan.design(first))
        return {name: np.broadcast_to(values, block.shape[:-2]) for name, values in found.items()}

    @cached_property
    def known(self) -> Found | None:
        """The columns of the whole plan, where blocks share them and they are few."""
        plan, free = self.plan, self.plan.only_pretension
        designs = tuple(slice(0, 1 if axis in free else length) for axis, length in enumerate(plan.shape))
        every = Block(0, designs, slice(0, len(plan.directions)), slice(0, len(plan.elbow_angles)))
        states, most = math.prod(every.shape), _MOST_BEFORE if kernel.kind() else _MOST_BEFORE // 16
        if every.design_count == plan.designs or every.design_count > _MOST_KEPT or states > most:
            return None
        found = {name: np.empty(every.shape[:-2]) for name in ("pretension_from", "pretension_to")}
        for block in small_blocks(self.plan, every):
            for name, values in self._columns(block, self.plan.design(block)).items():
                found[name][block.designs] = values
        return found

    def _columns(self, block: Block, design: Design) -> Found:
        bounds = bounds_of(self.plan.study)
        if bounds.of_motion:  # limits over several states at once
            from tendon_cli.model.motor_window import narrowed  # only these pay for its import

            motion = self.plan.motion(block)
            whole = window.window(design, *motion, bounds)
            ends: window.Ends = narrowed(whole, design, *motion, bounds).window
        else:
            ends = self._ends(block, design)
        return {"pretension_from": ends.low, "pretension_to": np.where(np.isinf(ends.high), np.nan, ends.high)}

    def _ends(self, block: Block, design: Design) -> window.Ends:
        found, bounds = window.begin(block.shape[:-2]), bounds_of(self.plan.study)
        for stretch in block.by_angles(angles_at_once(self.plan)):
            situation, angles = Situation.of(design, *self.plan.motion(stretch)), len(self.plan.elbow_angles)
            kernel.fold_window(found, situation, bounds, stretch.shape, stretch.angles.start, angles)
        return window.finished(found, design, bounds)
