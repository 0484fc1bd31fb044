"""States that no run keeps: of a recorded study, or at angles that a program gives; worked out when they are read."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.engine.plan import Block, Plan
from tendon_cli.engine.sweep import Sweep, state_rows
from tendon_cli.errors import UsageError
from tendon_cli.studies.load import AnyStudy, any_study, recorded_study, varied_study
from tendon_cli.tables.read import AnyTable
from tendon_cli.tables.schema import as_numpy
from tendon_cli.tables.write import RowsInMemory

_MOVES = ("flexion", "extension")
_LEADING = ("design", "direction", "elbow_angle")


@dataclass(frozen=True, eq=False)
class WorkedOut(AnyTable):
    """All rows and columns that a recorded study gives in a table of designs or states, kept or not."""

    record: Mapping[str, Any]
    """Of the study, as a run or a table keeps it."""
    study_hash: str
    files: tuple[Path, ...] = ()
    """What is named if something is wrong: the run's folder."""
    kind: str = "states"

    @cached_property
    def sweep(self) -> Sweep:
        """What gives them, whatever the study keeps of them."""
        output = {"tables": ["designs", "states"]}
        return Sweep.of(
            recorded_study({**self.record, "study": {**self.record["study"], "output": output}})
        )

    @property
    def plan(self) -> Plan:
        """The study as a product."""
        return self.sweep.plan

    @property
    def schema(self) -> pa.Schema:
        """Columns with units and meaning."""
        return self.sweep.layout(self.kind, 0).schema

    @property
    def facts(self) -> dict[str, Any]:
        """What a table knows of itself."""
        return {"table": self.kind, "study": self.record, "study_hash": self.study_hash}

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.plan.rows(self.kind, range(self.plan.designs))

    def parts(
        self, columns: Sequence[str] | None = None, wanted: npt.NDArray[np.int64] | None = None
    ) -> Iterator[tuple[int, pa.Table]]:
        """States block by block, each with the number of its first row; only of designs that have `wanted` rows."""
        each, names = self.plan.states_per_design, columns or self.schema.names
        runs = [range(self.plan.designs)]
        if wanted is not None:
            asked = np.unique(wanted // each)
            apart = np.split(asked, np.flatnonzero(np.diff(asked) > 1) + 1)
            runs = [range(run[0], run[-1] + 1) for run in apart if len(run)]
        for designs in runs:
            start = designs.start * each
            for block in self.plan.blocks(designs, self.plan.block_states):
                part = self._rows(block, names)
                yield start, part
                start += part.num_rows

    def _rows(self, block: Block, names: Sequence[str]) -> pa.Table:
        whole = self.sweep.layout("states", 0)
        columns = {column.name: column for column in whole.columns}
        schema = pa.schema([whole.schema.field(name) for name in names], whole.schema.metadata)
        rows = RowsInMemory(
            replace(whole, columns=tuple(columns[name] for name in names), schema=schema)
        )
        rows.fill(
            math.prod(block.shape), state_rows(self.plan, block, self.sweep.keys("states", block))
        )
        return rows.table()


def states(design: AnyStudy, angle: npt.ArrayLike, flexion: npt.ArrayLike = True) -> dict[str, Any]:
    """The results of a study's states at elbow angles in rad, moving in flexion or extension, as arrays.

    `angle` and `flexion` broadcast against each other. Every result has their shape, after one dimension for each axis
    of the study, and SI units; `status` is text. Raises UsageError for what is no angle, StudyError for one out of
    range.

    >>> import numpy as np
    >>> import tendon_cli as tendon
    >>> results = tendon.states({}, np.radians([0.0, 45.0, 90.0]))
    >>> results["motor_torque"].round(3)
    array([2.59 , 0.392, 0.72 ])
    """
    try:
        angles, moves = np.broadcast_arrays(
            np.asarray(angle, dtype=np.float64), np.asarray(flexion, dtype=np.bool_)
        )
    except (TypeError, ValueError) as error:
        raise UsageError(f"angle and flexion are not arrays of one shape: {error}") from None
    if not angles.size:
        raise UsageError("angle is empty, expected at least one")
    different, at = np.unique(angles, return_inverse=True)
    asked = varied_study(
        any_study(design),
        {
            "motion.elbow_angle": [f"{value!r} rad" for value in different.tolist()],
            "motion.direction": list(_MOVES),
        },
    )
    every = WorkedOut(asked.record, asked.hash, ())
    table, shape = every.read(), (*every.plan.shape, *angles.shape)
    rows = np.where(moves, 0, 1).ravel() * len(different) + at.ravel()
    by_state = {
        name: as_numpy(table[name]).reshape(every.plan.designs, -1) for name in table.column_names
    }
    return {
        name: values[:, rows].reshape(shape)
        for name, values in by_state.items()
        if name not in _LEADING
    }
