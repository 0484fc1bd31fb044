"""The windows of pretension of a plan's designs, as the columns of designs have them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tendon_cli import kernel
from tendon_cli.model import window
from tendon_cli.model.actuator import Situation
from tendon_cli.model.design import Design
from tendon_cli.model.extremes import Found
from tendon_cli.sweep.inputs import Inputs, bounds_of, motor_bounds_of
from tendon_cli.sweep.plan import Block, Plan

VALUES_AT_ONCE = 2**18
"""In an array that compiled code is given."""
_STATES_AT_ONCE = 2**20
_MOST_KEPT = 2**17
"""PlanWindows of all designs that are kept in memory, if there are no more."""


def angles_at_once(plan: Plan) -> int:
    """How many elbow angles of a design are best taken at once; the results do not depend on it."""
    return VALUES_AT_ONCE if kernel.kind() else plan.block_states


@dataclass(frozen=True, eq=False)
class PlanWindows:
    """Worked out once for all designs that differ in pretension alone."""

    inputs: Inputs

    def columns(self, block: Block, design: Design) -> Found:
        """The columns of a block of designs."""
        free = self.inputs.only_pretension
        if self.known is not None:
            place = tuple(slice(0, 1) if axis in free else part for axis, part in enumerate(block.designs))
            found = {name: values[place] for name, values in self.known.items()}
        else:
            first = block.first_along(free)
            found = self._columns(first, design if first.shape == block.shape else self.inputs.design(first))
        return {name: np.broadcast_to(values, block.shape[:-2]) for name, values in found.items()}

    @cached_property
    def known(self) -> Found | None:
        """The columns of the whole plan, where blocks share them and they are few."""
        plan, free = self.inputs.plan, self.inputs.only_pretension
        designs = tuple(slice(0, 1 if axis in free else length) for axis, length in enumerate(plan.shape))
        every = Block(0, designs, slice(0, len(plan.directions)), slice(0, len(plan.elbow_angles)))
        if every.design_count == plan.designs or every.design_count > _MOST_KEPT:
            return None
        found = {name: np.empty(every.shape[:-2]) for name in ("pretension_from", "pretension_to")}
        for block in self._small(every):
            for name, values in self._columns(block, self.inputs.design(block)).items():
                found[name][block.designs] = values
        return found

    def _small(self, block: Block) -> Iterator[Block]:
        """The block, or halves of it and of these."""
        states, most = math.prod(block.shape), _STATES_AT_ONCE if kernel.kind() else self.inputs.plan.block_states
        longest = max(range(len(block.designs)), key=lambda axis: block.shape[axis])
        if states <= most or block.shape[longest] == 1:
            yield block
            return
        for half in block.halves(longest):
            yield from self._small(half)

    def _columns(self, block: Block, design: Design) -> Found:
        study = self.inputs.plan.study
        if (motor := motor_bounds_of(study)) is not None:  # limits over several states at once
            from tendon_cli.model.motor_window import narrowed  # only these pay for its import

            motion = self.inputs.motion(block)
            whole = window.window(design, *motion, bounds_of(study))
            ends: window.Ends = narrowed(whole, design, *motion, motor).window
        else:
            ends = self._ends(block, design)
        return {"pretension_from": ends.low, "pretension_to": np.where(np.isinf(ends.high), np.nan, ends.high)}

    def _ends(self, block: Block, design: Design) -> window.Ends:
        found, bounds = window.begin(block.shape[:-2]), bounds_of(self.inputs.plan.study)
        for stretch in block.by_angles(angles_at_once(self.inputs.plan)):
            situation, angles = Situation.of(design, *self.inputs.motion(stretch)), len(self.inputs.plan.elbow_angles)
            kernel.fold_window(found, situation, bounds, stretch.shape, stretch.angles.start, angles)
        return window.finished(found, design, bounds)
