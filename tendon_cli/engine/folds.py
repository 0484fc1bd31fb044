"""The folds over the states of a plan's designs: rows of `designs`, and the windows of pretension in them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.engine.blocks import Block
from tendon_cli.engine.columns import of_limits
from tendon_cli.engine.plan import Plan, bounds_of
from tendon_cli.model import extremes, window
from tendon_cli.model.actuator import Situation
from tendon_cli.model.design import Design
from tendon_cli.model.extremes import Found
from tendon_cli.quantities import OF_CYCLES

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
        (whole, plan.states_per_design, plan.block_states),
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
            columns = {name: values[place] for name, values in self.known.items()}
        else:
            first = block.first_along(free)
            columns = self._columns(first, design if first.shape == block.shape else self.plan.design(first))
        return {name: np.broadcast_to(values, block.shape[:-2]) for name, values in columns.items()}

    @cached_property
    def known(self) -> Found | None:
        """The columns of the whole plan, where blocks share them and they are few."""
        plan, free = self.plan, self.plan.only_pretension
        designs = tuple(slice(0, 1 if axis in free else length) for axis, length in enumerate(plan.shape))
        every = Block(0, designs, slice(0, len(plan.directions)), slice(0, len(plan.elbow_angles)))
        states, most = math.prod(every.shape), _MOST_BEFORE if kernel.kind() else _MOST_BEFORE // 16
        if every.design_count == plan.designs or every.design_count > _MOST_KEPT or states > most:
            return None
        columns = {name: np.empty(every.shape[:-2]) for name in ("pretension_from", "pretension_to")}
        for block in small_blocks(self.plan, every):
            for name, values in self._columns(block, self.plan.design(block)).items():
                columns[name][block.designs] = values
        return columns

    def _columns(self, block: Block, design: Design) -> Found:
        bounds = bounds_of(self.plan.study)
        if bounds.of_motion:  # limits over several states at once
            from tendon_cli.model.motor_window import narrowed  # only these pay for its import

            motion = self.plan.motion(block)
            whole = window.window(design, *motion, bounds)
            ends: window.Ends = narrowed(whole, design, *motion, bounds).window
        else:
            ends = self._ends(block, design)
        ends = window.as_read(ends, design)
        return {"pretension_from": ends.low, "pretension_to": np.where(np.isinf(ends.high), np.nan, ends.high)}

    def _ends(self, block: Block, design: Design) -> window.Ends:
        folded, bounds = window.begin(block.shape[:-2]), bounds_of(self.plan.study)
        for stretch in block.by_angles(angles_at_once(self.plan)):
            situation, angles = Situation.of(design, *self.plan.motion(stretch)), len(self.plan.elbow_angles)
            kernel.fold_window(folded, situation, bounds, stretch.shape, stretch.angles.start, angles)
        return window.finished(folded, design, bounds)


@dataclass(frozen=True)
class Totals:
    """What the designs of a part, or of a whole run, come to."""

    taut: int = 0
    """Designs whose every state is taut."""
    stable: int = 0
    """Designs without a state of less than the least elbow stiffness."""
    feasible: int = 0
    """Designs that are taut, stable and within every limit."""
    slack: int = 0
    """States with a slack tendon."""
    no_equilibrium: int = 0
    """States in which the flexor cannot balance anything."""
    unstable: int = 0
    """States with negative elbow stiffness."""

    def __add__(self, other: Totals) -> Totals:
        return Totals(*(getattr(self, name) + getattr(other, name) for name in vars(self)))


@dataclass(eq=False)
class DesignRows:
    """The rows of a block of designs, worked out when they are written."""

    windows: PlanWindows
    block: Block
    keys: Mapping[str, npt.NDArray[Any]]
    """The columns that say which design a row is."""
    go_on: Callable[[], None]
    """Called before each smaller block; raises where the work shall stop."""
    totals: Totals = Totals()
    """Of the designs written so far."""

    def __post_init__(self) -> None:
        self.plan = self.windows.plan
        self._of_forms = of_limits(self.plan.study)
        self.feasible = np.zeros(self.block.shape[:-2], np.bool_)

    def write(self, columns: Mapping[str, npt.NDArray[Any]], _rows: range) -> None:
        """Write the block's rows into columns of that many rows; all at once, for they come in another order."""
        shaped = {name: column.reshape(self.block.shape[:-2]) for name, column in columns.items()}
        for name in self.keys.keys() & shaped.keys():
            shaped[name][...] = np.broadcast_to(self.keys[name], self.block.shape)[..., 0, 0]
        plan = self.plan
        for block in small_blocks(self.plan, self.block):
            self.go_on()
            design = self.plan.design(block)
            folded = self._folded(block, design)
            results = extremes.as_read(extremes.finished(folded, plan.states_per_design), design)
            results |= _by_numpy(self.plan, block, self._of_forms)
            results |= extremes.of_design(design, folded) | self.windows.columns(block, design)
            judged = extremes.judged(results, plan.study.limits)
            counts = {**{name: folded[name] for name in extremes.COUNTS}, **judged}
            self.totals += Totals(**{name: int(values.sum()) for name, values in counts.items()})
            places = zip(block.designs, self.block.designs, strict=True)
            within = tuple(slice(part.start - whole.start, part.stop - whole.start) for part, whole in places)
            self.feasible[within] = judged["feasible"]
            for name in shaped.keys() - self.keys.keys():
                shaped[name][within] = judged[name] if name in judged else results[name]

    def _folded(self, block: Block, design: Design) -> Found:
        """What the designs of a block come to, over all their states."""
        folded = extremes.begin(block.shape[:-2])
        for stretch in block.by_angles(angles_at_once(self.plan)):
            angles = self.plan.elbow_angles[stretch.angles]
            kernel.fold_extremes(folded, Situation.of(design, *self.plan.motion(stretch)), angles, stretch.shape)
        return folded


def _by_numpy(plan: Plan, block: Block, of_forms: tuple[str, ...]) -> Found:
    """What compiled code does not know: the columns that a speed of the elbow adds, and those of forms of states.

    In the shape of the block's designs. States are taken `VALUES_AT_ONCE` at once; a cycle has some more between two
    elbow angles.
    """
    speed, shape = plan.study.motion.speed, block.shape[:-2]
    if speed is None and not of_forms:
        return {}
    long = max(range(len(shape)), key=lambda axis: shape[axis], default=None)
    if long is not None and shape[long] > 1 and block.design_count * plan.states_per_design > VALUES_AT_ONCE:
        halves = [_by_numpy(plan, half, of_forms) for half in block.halves(long)]
        return {name: np.concatenate([half[name] for half in halves], axis=long) for name in halves[0]}
    columns = extremes.of_forms(of_forms, plan.situation(block)) if of_forms else {}
    if speed is not None:
        from tendon_cli.model.motor import cycle  # only a study of motion pays for its import

        motor = cycle(plan.design(block), *plan.motion(block), speed.single)
        columns |= {name: getattr(motor, name) for name in OF_CYCLES}
    return {name: np.broadcast_to(values, shape) for name, values in columns.items()}
