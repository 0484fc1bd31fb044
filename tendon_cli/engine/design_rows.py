"""Rows of the designs table: what designs come to over all their states, and what all of them come to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.engine.columns import of_limits
from tendon_cli.engine.plan import Block, Plan
from tendon_cli.engine.windows import VALUES_AT_ONCE, PlanWindows, angles_at_once, small_blocks
from tendon_cli.model import extremes
from tendon_cli.model.actuator import Situation
from tendon_cli.model.design import Design
from tendon_cli.quantities import OF_CYCLES


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
            found = self._found(block, design)
            results = extremes.finished(found, plan.states_per_design) | _by_numpy(self.plan, block, self._of_forms)
            results |= extremes.of_design(design, found) | self.windows.columns(block, design)
            judged = extremes.judged(results, plan.study.limits)
            counts = {**{name: found[name] for name in extremes.COUNTS}, **judged}
            self.totals += Totals(**{name: int(values.sum()) for name, values in counts.items()})
            places = zip(block.designs, self.block.designs, strict=True)
            within = tuple(slice(part.start - whole.start, part.stop - whole.start) for part, whole in places)
            self.feasible[within] = judged["feasible"]
            for name in shaped.keys() - self.keys.keys():
                shaped[name][within] = judged[name] if name in judged else results[name]

    def _found(self, block: Block, design: Design) -> extremes.Found:
        """What the designs of a block come to, over all their states."""
        found = extremes.begin(block.shape[:-2])
        for stretch in block.by_angles(angles_at_once(self.plan)):
            angles = self.plan.elbow_angles[stretch.angles]
            kernel.fold_extremes(found, Situation.of(design, *self.plan.motion(stretch)), angles, stretch.shape)
        return found


def _by_numpy(plan: Plan, block: Block, of_forms: tuple[str, ...]) -> extremes.Found:
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
        from tendon_cli.model.cycle import cycle  # only a study of motion pays for its import

        found = cycle(plan.design(block), *plan.motion(block), speed.single)
        columns |= {name: getattr(found, name) for name in OF_CYCLES}
    return {name: np.broadcast_to(values, shape) for name, values in columns.items()}
