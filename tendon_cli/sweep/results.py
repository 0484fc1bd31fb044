"""What a sweep gave: its record and its tables, as pandas and xarray have them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tendon_cli.errors import FolderError, InputError, UsageError
from tendon_cli.sweep.record import RECORD, read_record, stands
from tendon_cli.sweep.run_folder import is_begun

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    import xarray as xr


@dataclass(frozen=True, eq=False)
class Run:
    """A finished run: `record` as in `run.json`, `designs` and `states` as tables with their units in `attrs`."""

    record: dict[str, Any]
    folder: Path | None = None
    """Where it stands; None in memory."""
    up_to_date: bool = False
    """Whether it had stood there before."""
    note: str | None = None
    """Why there is no slack map, where one was asked for."""
    tables: Mapping[str, pa.Table] = field(default_factory=dict, repr=False)
    """Those that are in memory."""

    @cached_property
    def designs(self) -> pd.DataFrame:
        """One row per design; raises UsageError where the study leaves the table out, InputError for a damaged one."""
        return self._frame("designs")

    @cached_property
    def states(self) -> pd.DataFrame:
        """One row per design, direction and elbow angle; raises as `designs` does."""
        return self._frame("states")

    def to_xarray(self) -> xr.Dataset:
        """The tables as one dataset: the study's axes are its dimensions, every variable has its unit.

        Needs the extra `tendon-cli[xarray]`; raises UsageError without.
        """
        from tendon_cli.sweep.dataset import dataset_of

        return dataset_of(self.record, self.table)

    def table(self, name: str) -> pa.Table:
        """A table as Arrow has it, every byte verified."""
        if name in self.tables:
            return self.tables[name]
        if name not in self.record["study"]["output"]["tables"]:
            hint = f'[output] tables needs "{name}"'
            raise UsageError(f"the run has no table {name}", where=str(self.folder or "in memory"), hint=hint)
        from tendon_cli.tables.read import open_table

        return open_table(Path(self.folder or "") / f"{name}.parquet").read()

    def _frame(self, name: str) -> pd.DataFrame:
        table = self.table(name)
        frame: pd.DataFrame = table.to_pandas()
        frame.attrs = json.loads(table.schema.metadata[b"PANDAS_ATTRS"])
        return frame


def open_run(path: Path) -> Run:
    """A finished run from its folder, its record and every byte of its tables verified.

    Raises InputError where there is none or a file of it is damaged, FolderError where it is unfinished.
    """
    record = read_record(path)
    if record is None:
        if is_begun(path):
            hint = "`tendon sweep --resume` finishes it; in Python sweep(..., resume=True)"
            raise FolderError("holds an unfinished run", where=str(path), hint=hint)
        hint = "`tendon sweep` writes one"
        raise InputError(f"is no run folder, it holds no {RECORD}", where=str(path), hint=hint)
    for entry in record["files"]:
        if not stands(path, entry):
            hint = "`tendon sweep --resume` computes just this anew"
            raise InputError("is missing, or not as it was written", where=str(path / entry["path"]), hint=hint)
    return Run(record, path, up_to_date=True)
