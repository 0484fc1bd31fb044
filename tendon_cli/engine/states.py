"""States worked out when they are read: those a run did not keep, and those at angles asked for."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.engine.plan import DESIGNS_AT_ONCE, Block, Plan
from tendon_cli.engine.sweep import Sweep, state_rows
from tendon_cli.errors import UsageError
from tendon_cli.studies.load import AnyStudy, any_study, varied_study
from tendon_cli.studies.parts import Output
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import AnyTable
from tendon_cli.tables.schema import as_numpy
from tendon_cli.tables.write import RowsInMemory

_DIRECTIONS = ("flexion", "extension")
_LEADING = ("design", "direction", "elbow_angle")


@dataclass(frozen=True, eq=False)
class WorkedOut(AnyTable):
    """Table with all rows and columns that a study gives, whether a run keeps them or not."""

    study: Study
    files: tuple[Path, ...] = ()
    """The run's folder, which messages name."""
    kind: str = "states"
    """Kind of the table, designs or states."""

    @cached_property
    def sweep(self) -> Sweep:
        """Task that gives the rows, whatever the study keeps of them."""
        return Sweep.of(self.study.replaced({"output": Output()}))

    @property
    def plan(self) -> Plan:
        """The study as a product."""
        return self.sweep.plan

    @property
    def schema(self) -> pa.Schema:
        """Columns with units and meaning."""
        return self.sweep.layout(self.kind, 0).schema

    @cached_property
    def facts(self) -> dict[str, Any]:
        """Facts of the table: `table`, `study` and `study_hash`."""
        return {
            "table": self.kind,
            "study": self.study.record,
            "study_hash": self.study.hash,
        }

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.plan.rows(self.kind, range(self.plan.designs))

    def parts(
        self, columns: Sequence[str] | None = None, wanted: npt.NDArray[np.int64] | None = None
    ) -> Iterator[tuple[int, pa.Table]]:
        """Yield rows a stretch at a time, each with the number of its first row.

        Args:
            columns: Names of the columns; None for all.
            wanted: Row numbers, ascending: only designs that have such rows are worked out; None
                for all.
        """
        names = columns or self.schema.names
        rows_per_design = self.plan.rows(self.kind, range(1))
        ranges = [range(self.plan.designs)]
        if wanted is not None:
            designs = np.unique(wanted // rows_per_design)
            gaps = np.flatnonzero(np.diff(designs) > 1)
            stretches = np.split(designs, gaps + 1)
            ranges = [range(part[0], part[-1] + 1) for part in stretches if len(part)]
        for consecutive in ranges:
            first_row = consecutive.start * rows_per_design
            compute = self._designs if self.kind == "designs" else self._states
            for part in compute(consecutive, names):
                yield first_row, part
                first_row += part.num_rows

    def _designs(self, designs: range, names: Sequence[str]) -> Iterator[pa.Table]:
        """Work out some columns of a range of designs, a stretch at a time."""
        for start in range(0, len(designs), DESIGNS_AT_ONCE):
            stretch = designs[start : start + DESIGNS_AT_ONCE]
            rows = RowsInMemory(self.sweep.layout("designs", 0, len(stretch)))
            self.sweep.fill_designs({"designs": rows}, stretch)
            yield rows.table().select(list(names))

    def _states(self, designs: range, names: Sequence[str]) -> Iterator[pa.Table]:
        """Work out some columns of the states of a range of designs, block by block."""
        for block in self.plan.blocks(designs, self.plan.block_states):
            yield self._states_of(block, names)

    def _states_of(self, block: Block, names: Sequence[str]) -> pa.Table:
        """Work out some columns of the states of a block."""
        layout = self.sweep.layout("states", 0)
        by_name = {column.name: column for column in layout.columns}
        columns = tuple(by_name[name] for name in names)
        schema = pa.schema([layout.schema.field(name) for name in names], layout.schema.metadata)
        rows = RowsInMemory(replace(layout, columns=columns, schema=schema))
        write = state_rows(self.plan, block, self.sweep.keys("states", block))
        rows.fill(math.prod(block.shape), write)
        return rows.table()


def states(design: AnyStudy, angle: npt.ArrayLike, flexion: npt.ArrayLike = True) -> dict[str, Any]:
    """Return the results of a study's states at elbow angles.

    Args:
        design: The study.
        angle: Elbow angles, rad.
        flexion: True where the elbow flexes, False where it extends; `angle` and `flexion`
            broadcast against each other.

    Returns:
        Results by name, SI; `status` is text. Each has one dimension for each axis of the study,
        and then those of `angle` and `flexion`.

    Raises:
        UsageError: There is no angle, one is not a number, or the shapes do not broadcast.
        StudyError: An angle is out of range.

    >>> import numpy as np
    >>> import tendon_cli as tendon
    >>> results = tendon.states({}, np.radians([0.0, 45.0, 90.0]))
    >>> results["motor_torque"].round(3)
    array([2.59 , 0.392, 0.72 ])
    """
    try:
        angles, flexes = np.broadcast_arrays(
            np.asarray(angle, dtype=np.float64), np.asarray(flexion, dtype=np.bool_)
        )
    except (TypeError, ValueError) as error:
        raise UsageError(f"angle and flexion do not broadcast as arrays: {error}") from None
    if not angles.size:
        raise UsageError("angle is empty, expected at least one")
    different, places = np.unique(angles, return_inverse=True)
    motion = {
        "motion.elbow_angle": [f"{value!r} rad" for value in different.tolist()],
        "motion.direction": list(_DIRECTIONS),
    }
    study = varied_study(any_study(design), motion)
    worked_out = WorkedOut(study)
    plan = worked_out.plan
    table = worked_out.read()
    shape = (*plan.shape, *angles.shape)
    directions = np.where(flexes, 0, 1).ravel()
    columns = directions * len(different) + places.ravel()  # states of a design
    results = {}
    for name in table.column_names:
        if name not in _LEADING:
            values = as_numpy(table[name]).reshape(plan.designs, -1)  # (designs, states)
            results[name] = values[:, columns].reshape(shape)
    return results
