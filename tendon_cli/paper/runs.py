"""The paper's studies, swept into tables as any study is, and the tables read back."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from tendon_cli.model.actuator import Design
from tendon_cli.study.load import load_study
from tendon_cli.study.study import Study
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Plan
from tendon_cli.sweep.run import run
from tendon_cli.sweep.run_folder import RunFolder
from tendon_cli.tables.read import open_table

Array = npt.NDArray[np.float64]

FOLDER = Path(__file__).parent / "studies"
READINGS = Path(__file__).parent / "table_a1.csv"
"""Table A.1 as a file of readings."""
STUDIES = ("fig04", "fig06", "fig07", "fig08", "fig09", "fig10", "fig11")
VARIANTS = {"fig06-30kN": ("fig06", "spring.stiffness=30 kN/m"), "fig04-initial": ("fig04", "model.reference=initial")}
"""Studies of which one key is as the letter of the paper has it, or as the reading used does not."""


@dataclass(frozen=True)
class Run:
    """A study of the paper and its tables."""

    study: Study
    folder: Path
    states: pd.DataFrame
    designs: pd.DataFrame

    @cached_property
    def degrees(self) -> Array:
        """The elbow angles, rising, deg."""
        return np.asarray(np.degrees(np.unique(self.states["elbow_angle"].to_numpy(np.float64))))

    def values(self, axis: str) -> list[float]:
        """The different values of a column of `designs`, in the order of the study."""
        return [float(value) for value in dict.fromkeys(self.designs[axis])]

    def line(self, column: str, direction: str = "flexion", **fixed: float) -> Array:
        """A column of the states of one design and direction, by rising elbow angle."""
        rows = self.states[self.states["direction"] == direction]
        for axis, value in fixed.items():
            rows = rows[np.isclose(rows[axis], value)]
        values = rows.sort_values("elbow_angle")[column].to_numpy(np.float64)
        if values.shape != self.degrees.shape:
            raise ValueError(f"{self.study.name}: {column} of {len(values)} states, expected {len(self.degrees)}")
        return values

    def design(self, column: str, **fixed: float) -> float:
        """A column of the one design with these values."""
        rows = self.designs
        for axis, value in fixed.items():
            rows = rows[np.isclose(rows[axis], value)]
        (value,) = rows[column].to_numpy(np.float64)
        return float(value)

    def inputs(self) -> tuple[Design, Array, npt.NDArray[np.bool_]]:
        """What the model takes for the study: designs, elbow angles and whether it is flexion, ready to broadcast."""
        plan = Plan(self.study)
        (block,) = plan.blocks(range(plan.designs))
        inputs = Inputs(plan)
        return inputs.design(block), *inputs.motion(block)


def load(name: str) -> Study:
    """A study of the paper, or a variant of one."""
    study, *settings = VARIANTS.get(name, (name,))
    return load_study(FOLDER / f"{study}.toml", tuple(settings))


def swept(
    names: tuple[str, ...], area: Path, *, jobs: int, stop: threading.Event, lock: bool = True
) -> Iterator[tuple[str, Run]]:
    """Sweep studies into folders of `area`, one after the other, and read their tables back, every byte verified."""
    for name in names:
        study = load(name)
        folder = RunFolder(area / name, Plan(study))
        with folder.locked(use_lock=lock):
            outcome = run(folder, jobs=jobs, stop=stop, progress=_silent)
            if not outcome.up_to_date:
                folder.write_record(outcome.record)
        states, designs = (
            open_table(folder.path / f"{table}.parquet").read().to_pandas() for table in ("states", "designs")
        )
        yield name, Run(study, folder.path, states, designs)


def _silent(_done: int, _total: int) -> None:
    """Each of these studies is one part: there is nothing to show between its start and its end."""
