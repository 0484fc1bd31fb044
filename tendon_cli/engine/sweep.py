"""A sweep: every design of the product into rows of designs and states."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.engine.folds import COUNTED, Folds, choices, feasible_choices, flags, noted
from tendon_cli.engine.plan import DESIGNS_AT_ONCE, Block, Plan
from tendon_cli.engine.table_columns import Tables
from tendon_cli.engine.task import Note, Task
from tendon_cli.say import share
from tendon_cli.studies.study import Study
from tendon_cli.tables.schema import Column, TableLayout
from tendon_cli.tables.write import Filler, Rows

Keys = Mapping[str, npt.NDArray[Any]]
"""The columns that say which design, or which state, a row is."""

_BLOCKS_AT_ONCE = 8
"""Blocks of a plan that compiled code best takes at once, together a part; the rows do not depend on it."""
_LEAST_BYTES = {"designs": 10, "states": 20}
"""Of a row."""


@dataclass(frozen=True, eq=False)
class Sweep(Task):
    """Every design of a plan, folded to the extremes of its states, and its states as rows."""

    plan: Plan
    stop: threading.Event = field(default_factory=threading.Event)
    every_column: Tables = field(init=False)
    folds: Folds = field(init=False)

    verb = "sweep"

    def __post_init__(self) -> None:
        object.__setattr__(self, "every_column", Tables(self.plan))
        object.__setattr__(self, "folds", Folds(self.plan))

    @classmethod
    def of(cls, study: Study, stop: threading.Event | None = None) -> Self:
        """That of a study; raises SizeError."""
        return cls(Plan(study), stop or threading.Event())

    @property
    def study(self) -> Study:
        """What is asked."""
        return self.plan.study

    @cached_property
    def tables(self) -> dict[str, int]:
        """Those that the study asks for, of as many parts as the plan."""
        return dict.fromkeys(map(str, self.study.output.tables), self.plan.parts)

    @property
    def parts(self) -> int:
        """How many parts the plan is cut into."""
        return self.plan.parts

    @property
    def least_bytes(self) -> int:
        """That its tables take on a disk at the very least."""
        every = range(self.plan.designs)
        return sum(self.plan.rows(table, every) * _LEAST_BYTES[table] for table in self.tables)

    def columns(self, table: str) -> tuple[Column, ...]:
        """Columns of a table."""
        return self.every_column.designs if table == "designs" else self.every_column.states

    def rows(self, table: str, index: int) -> int:
        """Rows of a part of a table."""
        return self.plan.rows(table, self.plan.part(index))

    def layout(self, table: str, index: int, rows: int | None = None) -> TableLayout:
        """The layout of a part of a table; more designs are collected at once, since they do not come in order."""
        layout = super().layout(table, index, rows)
        return replace(layout, at_once=DESIGNS_AT_ONCE) if table == "designs" else layout

    def fill(self, tables: Mapping[str, Rows], index: int) -> Note:
        """Evaluate a part into its tables; raises Stopped."""
        return self.fill_designs(tables, self.plan.part(index))

    def fill_designs(self, tables: Mapping[str, Rows], designs: range) -> Note:
        """Evaluate a range of designs into the tables that are given; counts them in any case. Raises Stopped."""
        states = self.plan.block_states * (_BLOCKS_AT_ONCE if kernel.kind() else 1)
        for block in self.plan.blocks(designs, states) if "states" in tables else ():
            self.go_on()
            tables["states"].fill(
                math.prod(block.shape), state_rows(self.plan, block, self.keys("states", block))
            )
        totals, feasible = dict.fromkeys(COUNTED, 0), np.zeros(len(designs), np.bool_)
        for block in self.plan.blocks_of_designs(designs):
            start = block.first_design - designs.start
            here = feasible[start : start + block.design_count].reshape(block.shape[:-2])
            write = self._design_rows(block, totals, here)
            if "designs" in tables:
                tables["designs"].fill(block.design_count, write)
            else:
                write({}, range(block.design_count))
        return {"totals": totals, "feasible": noted(feasible)}

    def _design_rows(
        self, block: Block, totals: dict[str, int], feasible: npt.NDArray[np.bool_]
    ) -> Filler:
        """What writes all rows of a block at once, for they come in another order; counts, and judges each design."""
        keys = self.keys("designs", block)

        def write(columns: Mapping[str, npt.NDArray[Any]], _rows: range) -> None:
            shaped = {name: column.reshape(feasible.shape) for name, column in columns.items()}
            for name in keys.keys() & shaped.keys():
                shaped[name][...] = np.broadcast_to(keys[name], block.shape)[..., 0, 0]
            for small in self.folds.small_blocks(block):
                self.go_on()
                results, within = self.folds.designs(small), small.within(block)
                for name in COUNTED:
                    totals[name] += int(results[name].sum())
                feasible[within] = results["feasible"]
                for name in shaped.keys() - keys.keys():
                    shaped[name][within] = results[name]

        return write

    def keys(self, table: str, block: Block) -> Keys:
        """The columns that say which design, or which state, a row of a block is."""
        keys = self.every_column.leading | (
            self.every_column.of_states if table == "states" else {}
        )
        return {
            column.name: np.asarray(values(block), dtype=column.dtype)
            for column, values in keys.items()
        }

    def is_note(self, index: int, note: Any) -> bool:
        """Whether the note of a part is as `fill` gives it."""
        try:
            counts, known = (
                note["totals"],
                flags(note["feasible"], len(self.plan.part(index))) is not None,
            )
            return (
                known
                and set(counts) == set(COUNTED)
                and all(type(n) is int and n >= 0 for n in counts.values())
            )
        except (KeyError, TypeError, AttributeError):
            return False

    def place(self, index: int) -> str:
        """A part by its designs and where on the axes it starts."""
        plan, designs = self.plan, self.plan.part(index)
        at = [
            f"{axis.key}={axis.names[position] if axis.names else format(axis.values[position], '.6g')}"
            for axis, position in zip(plan.axes, plan.coordinates(designs.start), strict=True)
        ]
        return f"designs {designs.start} to {designs.stop - 1}, from {', '.join(at) or 'the only design'}"

    def results(self, notes: Sequence[Note]) -> dict[str, Any]:
        """Designs, states and choices, counted."""
        return {
            "designs": self.plan.designs,
            "states": self.plan.states,
            **{name: sum(note["totals"][name] for note in notes) for name in COUNTED},
            "choices": choices(self.plan),
            "feasible_choices": feasible_choices(self.plan, (note["feasible"] for note in notes)),
        }

    def warnings(self, record: Mapping[str, Any]) -> list[str]:
        """What a reader of the tables has to know first."""
        study, warnings, states = self.study, super().warnings(record), record["states"]
        models = [study.model, *(getattr(case, "model", None) for case in study.cases)]
        warnings += [remark] if (remark := kernel.remark()) else []
        if record["no_equilibrium"]:
            warnings.append(
                f"{share(record['no_equilibrium'], states, 'state')} have no equilibrium: the flexor has "
                "passed the joint's centre (moment arm not above zero), where no tensions balance a positive elbow "
                "torque, and those that balance another need not be the only ones; their results are null"
            )
        if record["slack"] and any(
            getattr(model, "slack", None) == "bilateral" for model in models
        ):
            warnings.append(
                "the bilateral model lets tendons push: tensions in slack states are the paper's, not physics; "
                'slack = "unilateral" gives those of real tendons'
            )
        if record["unstable"]:
            warnings.append(
                f"{share(record['unstable'], states, 'state')} are unstable (negative elbow stiffness): the "
                "spool would have to turn back, and friction acts the other way there"
            )
        return warnings


def state_rows(plan: Plan, block: Block, keys: Keys) -> Filler:
    """What writes the rows of a block's states; `keys` are the columns that say which design and state a row is."""
    return kernel.row_writer(plan.state(block), block.shape, keys)
