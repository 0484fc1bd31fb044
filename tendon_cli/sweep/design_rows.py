"""Rows of the designs table: what the designs of a rectangle of the product come to, tile by tile."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.sweep.columns import JUDGEMENTS
from tendon_cli.sweep.extremes import COUNTS, Extremes, blocks_at_once, extremes, finished, merge
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Block
from tendon_cli.tables.write import copied, has_nan


@dataclass(frozen=True)
class Totals:
    """What the designs of a part, or of a whole run, come to."""

    taut: int = 0
    """Designs whose every state is taut."""
    stable: int = 0
    """Designs without a state of less than the least elbow stiffness."""
    feasible: int = 0
    """Designs that are taut and stable."""
    slack: int = 0
    """States with a slack tendon."""
    no_equilibrium: int = 0
    """States in which the flexor cannot balance anything."""
    unstable: int = 0
    """States with negative elbow stiffness."""

    def __add__(self, other: Totals) -> Totals:
        return Totals(*(getattr(self, name) + getattr(other, name) for name in asdict(self)))


@dataclass(eq=False)
class DesignRows:
    """The rows of a rectangle, worked out when they are written."""

    inputs: Inputs
    rectangle: Block
    keys: Mapping[str, npt.ArrayLike]
    """The columns that say which design a row is."""
    go_on: Callable[[], None]
    """Called before each tile; raises where the work shall stop."""
    totals: Totals = Totals()
    """Of the designs written so far."""

    def write(self, columns: Mapping[str, npt.NDArray[Any]], rows: range) -> set[str]:
        """Write the rectangle's rows into columns of that many rows; all at once, for they come in another order."""
        shape = self.rectangle.shape[:-2]
        keys = {name: self.keys[name] for name in columns if name in self.keys}
        nulls = copied(keys, (*shape, 1, 1))(columns, rows)
        results = {name: column for name, column in columns.items() if name not in keys}
        return nulls | self._evaluate({name: column.reshape(shape) for name, column in results.items()})

    def _evaluate(self, columns: Mapping[str, npt.NDArray[Any]]) -> set[str]:
        """Put the results of all designs into columns of the rectangle's shape; returns those with nulls."""
        nulls: set[str] = set()
        for block, found in self._found():
            places = zip(block.designs, self.rectangle.designs, strict=True)
            within = tuple(slice(part.start - whole.start, part.stop - whole.start) for part, whole in places)
            results = finished(
                found, self.inputs.plan.states_per_design, self.inputs.plan.study.limits["min_elbow_stiffness"]
            )
            counts = {name: found[name] for name in COUNTS} | {name: results[name] for name in JUDGEMENTS}
            self.totals += Totals(**{name: self._total(block, values) for name, values in counts.items()})
            for name, column in columns.items():
                column[within] = self.inputs.arranged(block, results[name])
            nulls.update(name for name in columns if has_nan(results[name]))
        return nulls

    def _found(self) -> Iterator[tuple[Block, Extremes]]:
        """What designs come to, in pieces that suit the model best; one by one where each has very many states."""
        plan = self.inputs.plan
        if plan.states_per_design <= plan.block_states:
            for within in plan.tiles(self.rectangle, self.inputs.loops, blocks_at_once()):
                piece = self.rectangle.piece(within)
                yield piece, self._extremes(piece)
            return
        found = None
        for block in plan.blocks(self.rectangle.numbers):
            here = self._extremes(block)
            found = here if found is None else merge(found, here)
            if plan.completes_designs(block):
                yield block, found
                found = None

    def _extremes(self, block: Block) -> Extremes:
        self.go_on()
        return extremes(*self.inputs.tile(block))

    def _total(self, block: Block, values: npt.NDArray[Any]) -> int:
        return int(np.broadcast_to(self.inputs.arranged(block, values), block.shape[:-2]).sum())
