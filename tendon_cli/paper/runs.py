"""The paper's studies, swept into tables as any study is, and the tables read back."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from tendon_cli.engine.plan import Plan
from tendon_cli.engine.results import Run
from tendon_cli.engine.run import How, carried_out
from tendon_cli.engine.sweep import Sweep
from tendon_cli.model.design import Design
from tendon_cli.studies.load import load_study
from tendon_cli.studies.study import Study

Array = npt.NDArray[np.float64]

FOLDER = Path(__file__).parent / "studies"
READINGS = Path(__file__).parent / "table_a1.csv"
"""Table A.1 as a file of readings."""
STUDIES = ("fig04", "fig06", "fig07", "fig08", "fig09", "fig10", "fig11")
_EVERY_PLACE = "arm.load_distance={ from = '250 mm', to = '380 mm', num = 27 }"
PLACES = {f"{study}-places": (study, _EVERY_PLACE) for study in STUDIES[1:]}
"""The studies with the load held nearer and farther, 5 mm apart."""
VARIANTS = PLACES | {
    "fig04-initial": ("fig04", "model.reference=initial"),
    "fig06-30kN": ("fig06", "spring.stiffness=30 kN/m"),
    "fig06-pretensions": ("fig06", "load.mass=0 kg", 'tendon.pretension=["1 N", "50 N", "100 N", "200 N"]'),
    "fig06-windows": (
        "fig06",
        'spring.stiffness=["3 kN/m", "1 kN/m"]',
        "spool.ratio=[1.0, 0.7]",
    ),
    "fig07-smooth": ("fig07", "sheath.friction=0"),
    "fig09-10kg": ("fig09", "load.mass=10 kg", 'tendon.pretension=["100 N", "200 N", "221 N"]'),
    "fig10-springs": (
        "fig10",
        'load.mass=["5 kg", "10 kg"]',
        'spring.stiffness=["3 kN/m", "1 kN/m", "0.9 kN/m", "0.5 kN/m"]',
    ),
    "fig11-10kg": ("fig11", "load.mass=10 kg"),
}
"""Studies of which some keys are as the letter of the paper, the reading used, or a claim has them."""


@dataclass(frozen=True)
class PaperTables:
    """A study of the paper and its tables."""

    study: Study
    folder: Path
    states: pd.DataFrame
    designs: pd.DataFrame

    @cached_property
    def degrees(self) -> Array:
        """The elbow angles, rising, deg."""
        return np.degrees(np.sort(self.study.motion.elbow_angle.array))

    def values(self, axis: str) -> list[float]:
        """The different values of a column of `designs`, in the order of the study."""
        return [float(value) for value in dict.fromkeys(self.designs[axis])]

    def line(self, column: str, direction: str = "flexion", **fixed: float) -> Array:
        """A column of the states of one design and direction, by rising elbow angle."""
        angles = self.study.motion.elbow_angle.array
        shape = len(self.designs), len(self.study.motion.direction), len(angles)
        values = self.states[column].to_numpy(np.float64).reshape(shape)
        way = [*map(str, self.study.motion.direction)].index(direction)
        line: Array = values[self.row(**fixed), way][np.argsort(angles)]
        return line

    def design(self, column: str, **fixed: float) -> float:
        """A column of the one design with these values."""
        return float(self.designs[column].to_numpy(np.float64)[self.row(**fixed)])

    def at(self, **fixed: float) -> PaperTables:
        """The run of the designs with these values alone."""
        found = self._rows(fixed)
        per_design = len(self.states) // len(self.designs)
        return replace(self, states=self.states[np.repeat(found, per_design)], designs=self.designs[found])

    def _rows(self, fixed: Mapping[str, float]) -> npt.NDArray[np.bool_]:
        found = np.ones(len(self.designs), dtype=np.bool_)
        for axis, value in fixed.items():
            found &= np.isclose(self.designs[axis].to_numpy(np.float64), value)
        return found

    def row(self, **fixed: float) -> int:
        """The place of the one design with these values."""
        (found,) = np.flatnonzero(self._rows(fixed))
        return int(found)

    def inputs(self) -> tuple[Design, Array, npt.NDArray[np.bool_]]:
        """What the model takes for the study: designs, elbow angles and whether it is flexion, ready to broadcast."""
        plan = Plan(self.study)
        (block,) = plan.blocks(range(plan.designs))
        return plan.design(block), *plan.motion(block)


def load(name: str) -> Study:
    """A study of the paper, or a variant of one."""
    study, *settings = VARIANTS.get(name, (name,))
    return load_study(FOLDER / f"{study}.toml", tuple(settings))


def swept(
    names: tuple[str, ...], area: Path, *, jobs: int | None, stop: threading.Event, lock: bool = True
) -> Iterator[tuple[str, PaperTables]]:
    """Sweep studies into folders of `area`, one after the other, and read their tables back, every byte verified."""
    for name in names:
        study = load(name)
        done = carried_out(Sweep, Run, study, area / name, How(jobs=jobs, stop=stop, lock=lock))
        yield name, PaperTables(study, area / name, done.states, done.designs)
