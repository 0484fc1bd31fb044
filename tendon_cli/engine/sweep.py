"""The task of a sweep: every design of the product as rows of designs and states."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self, TypeAlias

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.engine.cutoff_check import check_of_sweep
from tendon_cli.engine.folds import (
    COUNTED,
    Folds,
    count_choices,
    count_feasible_choices,
    decode_feasible,
    encode_feasible,
)
from tendon_cli.engine.plan import DESIGNS_AT_ONCE, Block, Plan
from tendon_cli.engine.records import is_count
from tendon_cli.engine.sweep_kind import SWEEP
from tendon_cli.engine.table_columns import PlanColumns
from tendon_cli.engine.task import Note, Task
from tendon_cli.say import few, share
from tendon_cli.studies.checks import without_intervals
from tendon_cli.studies.space.axis import SLACK
from tendon_cli.studies.study import Study
from tendon_cli.tables.schema import Column, TableLayout
from tendon_cli.tables.write import Filler, RowTarget
from tendon_cli.verbs.typed_record import to_json

LeadingValues: TypeAlias = Mapping[str, npt.NDArray[Any]]
"""Values of the columns that say which design, or which state, a row is."""

_BLOCKS_AT_ONCE = 8
"""Blocks of a plan that compiled code is given as one, for speed; the rows do not depend on it."""
_LEAST_BYTES = {"designs": 10, "states": 20}
"""Least size of a row on the disk, by table."""


@dataclass(frozen=True, eq=False)
class Sweep(Task):
    """Task that folds every design of a plan to the extremes of its states and writes its states.

    Raises:
        SizeError: The study has too many states.
    """

    plan: Plan
    stop: threading.Event = field(default_factory=threading.Event)
    every_column: PlanColumns = field(init=False)
    """Columns of both tables, also of one that the study does not ask for."""
    folds: Folds = field(init=False)

    kind = SWEEP

    def __post_init__(self) -> None:
        object.__setattr__(self, "every_column", PlanColumns(self.plan))
        object.__setattr__(self, "folds", Folds(self.plan))

    @classmethod
    def of(cls, study: Study, stop: threading.Event | None = None) -> Self:
        """Return the task of a study; raises StudyError for intervals, SizeError."""
        return cls(Plan(without_intervals(study)), stop or threading.Event())

    @property
    def study(self) -> Study:
        """The study to be swept."""
        return self.plan.study

    @cached_property
    def tables(self) -> dict[str, int]:
        """Tables that the study asks for, each of as many parts as the plan."""
        return dict.fromkeys(map(str, self.study.output.tables), self.plan.parts)

    @property
    def parts(self) -> int:
        """Number of parts of the plan."""
        return self.plan.parts

    @property
    def least_bytes(self) -> int:
        """Least size of the tables on the disk."""
        every_design = range(self.plan.designs)
        return sum(
            self.plan.rows(table, every_design) * _LEAST_BYTES[table] for table in self.tables
        )

    def columns(self, table: str) -> tuple[Column, ...]:
        """Return the columns of a table."""
        return self.every_column.designs if table == "designs" else self.every_column.states

    def rows(self, table: str, index: int) -> int:
        """Return the number of rows in a part of a table."""
        return self.plan.rows(table, self.plan.part(index))

    def layout(self, table: str, index: int, rows: int | None = None) -> TableLayout:
        """Return the layout of a part of a table.

        More rows of designs than of states are collected at once, since they come out of order.
        """
        layout = super().layout(table, index, rows)
        return replace(layout, at_once=DESIGNS_AT_ONCE) if table == "designs" else layout

    def fill(self, tables: Mapping[str, RowTarget], index: int) -> Note:
        """Evaluate a part, write its rows into the tables, return its note; raises Stopped."""
        return self.fill_designs(tables, self.plan.part(index))

    def fill_designs(self, tables: Mapping[str, RowTarget], designs: range) -> Note:
        """Evaluate a range of designs and write their rows into the tables; raises Stopped.

        Returns:
            Note with the counts of COUNTED under `totals` and the feasible designs under
            `feasible`, also if no table is given.
        """
        if "states" in tables:
            self._fill_states(tables["states"], designs)
        totals = dict.fromkeys(COUNTED, 0)
        feasible = np.zeros(len(designs), np.bool_)
        for block in self.plan.blocks_of_designs(designs):
            start = block.first_design - designs.start
            stop = start + block.design_count
            of_block = feasible[start:stop].reshape(block.shape[:-2])
            write = self._design_rows(block, totals, of_block)
            if "designs" in tables:
                tables["designs"].fill(block.design_count, write)
            else:
                write({}, range(block.design_count))
        return {"totals": totals, "feasible": encode_feasible(feasible)}

    def _fill_states(self, table: RowTarget, designs: range) -> None:
        """Evaluate the states of a range of designs, write them into a table; raises Stopped."""
        states_at_once = self.plan.block_states
        if kernel.native() and self.study.trajectory is None:
            states_at_once *= _BLOCKS_AT_ONCE
        for block in self.plan.blocks(designs, states_at_once):
            self.check_stopped()
            write = state_rows(self.plan, block, self.keys("states", block))
            table.fill(math.prod(block.shape), write)

    def _design_rows(
        self, block: Block, totals: dict[str, int], feasible: npt.NDArray[np.bool_]
    ) -> Filler:
        """Return the function that writes all rows of a block; rows of its pieces interlock.

        Args:
            block: The designs.
            totals: Counts of COUNTED, to which those of the block are added.
            feasible: Filled with True where a design is feasible, in the shape of the block's
                design axes.
        """
        keys = self.keys("designs", block)

        def write(columns: Mapping[str, npt.NDArray[Any]], _rows: range) -> None:
            shaped = {name: column.reshape(feasible.shape) for name, column in columns.items()}
            for name in keys.keys() & shaped.keys():
                shaped[name][...] = np.broadcast_to(keys[name], block.shape)[..., 0, 0]
            for small in self.folds.small_blocks(block):
                self.check_stopped()
                results = self.folds.designs(small)
                place = small.within(block)
                for name in COUNTED:
                    totals[name] += int(results[name].sum())
                feasible[place] = results["feasible"]
                for name in shaped.keys() - keys.keys():
                    shaped[name][place] = results[name]

        return write

    def keys(self, table: str, block: Block) -> LeadingValues:
        """Return the values of the leading columns of a block, by the columns' names."""
        columns = self.every_column.leading
        if table == "states":
            columns = columns | self.every_column.of_states
        return {
            column.name: np.asarray(values(block), dtype=column.dtype)
            for column, values in columns.items()
        }

    def is_note(self, index: int, note: Any) -> bool:
        """Return True if a note that was read has the form of those that `fill` returns."""
        designs = len(self.plan.part(index))
        try:
            counts = note["totals"]
            return (
                decode_feasible(note["feasible"], designs) is not None
                and set(counts) == set(COUNTED)
                and all(is_count(count) for count in counts.values())
            )
        except (KeyError, TypeError, AttributeError):
            return False

    def place(self, index: int) -> str:
        """Describe a part by its designs and the values on the axes at which it starts."""
        designs = self.plan.part(index)
        position = self.plan.coordinates(designs.start)
        values = []
        for axis, place in zip(self.plan.axes, position, strict=True):
            value = axis.names[place] if axis.names else format(axis.values[place], ".6g")
            values.append(f"{axis.key}={value}")
        start = ", ".join(values) or "the only design"
        return f"designs {designs.start} to {designs.stop - 1}, from {start}"

    def results(self, notes: Sequence[Note], *_: Any) -> dict[str, Any]:
        """Count designs, states and choices for the record, from the notes of all parts."""
        check = check_of_sweep(self.plan)
        return {
            "designs": self.plan.designs,
            "states": self.plan.states,
            **{name: sum(note["totals"][name] for note in notes) for name in COUNTED},
            "choices": count_choices(self.plan),
            "feasible_choices": count_feasible_choices(
                self.plan, (note["feasible"] for note in notes)
            ),
            **({} if check is None else {"checks": {"cutoff": to_json(check)}}),
        }

    def warnings(self, record: Mapping[str, Any]) -> list[str]:
        """Return the warnings that a reader of the tables needs first."""
        warnings = super().warnings(record)
        states = record["states"]
        uncertain = self.study.uncertain
        if uncertain and self.study.drawing is None:
            names = few(list(uncertain))
            warnings.append(
                f"uncertain numbers take their middle value ({names}); [uncertainty] with draws"
                " above 0 draws them"
            )
        remark = kernel.missing_compiler_hint()
        if remark:
            warnings.append(remark)
        if record["no_equilibrium"]:
            have = "has" if record["no_equilibrium"] == 1 else "have"
            warnings.append(
                f"{share(record['no_equilibrium'], states, 'state')} {have} no equilibrium: the "
                "flexor has passed the joint's centre (its moment arm is not positive). No "
                "tensions balance a positive elbow torque there, and those that balance another "
                "need not be the only ones; the results are null"
            )
        if record["slack"] and self._is_bilateral_anywhere():
            warnings.append(
                "the bilateral model lets tendons push: tensions in slack states are the paper's, "
                'not physics; slack = "unilateral" gives those of real tendons'
            )
        if record["unstable"]:
            are = "is" if record["unstable"] == 1 else "are"
            warnings.append(
                f"{share(record['unstable'], states, 'state')} {are} unstable (negative elbow "
                "stiffness): the spool would have to turn back, and friction acts the other way "
                "there"
            )
        return warnings

    def _is_bilateral_anywhere(self) -> bool:
        """Return True if tendons push in the model of the study or of a row of its tables."""
        tables = self.study.row_tables
        of_rows = (table.numbers[SLACK] for table in tables if SLACK in table.numbers)
        return self.study.model.slack == "bilateral" or any((row == 0.0).any() for row in of_rows)


def state_rows(plan: Plan, block: Block, keys: LeadingValues) -> Filler:
    """Return the function that writes the rows of a block's states.

    Args:
        plan: The plan.
        block: The states.
        keys: Columns that say which design and state a row is.
    """
    return kernel.row_writer(plan.state(block), block.shape, keys)
