"""The paper's studies, swept into tables as any study is and read back, and what is measured of their curves."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from tendon_cli.answers.coverage import grouped, share_served
from tendon_cli.answers.question import question
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.results import Run
from tendon_cli.engine.run import How, carried_out
from tendon_cli.engine.sweep import Sweep
from tendon_cli.friction.result import Fit
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design
from tendon_cli.model.window import window as window_of
from tendon_cli.studies.load import load_study, study_from
from tendon_cli.studies.study import Study

Array = npt.NDArray[np.float64]

FOLDER = Path(__file__).parent / "studies"
READINGS = Path(__file__).parent / "table_a1.csv"
"""Table A.1 as a file of readings."""
STUDIES = ("fig04", "fig06", "fig07", "fig08", "fig09", "fig10", "fig11")
_EVERY_PLACE = "arm.load_distance={ from = '250 mm', to = '380 mm', num = 27 }"
PLACES = {f"{study}-places": (study, _EVERY_PLACE) for study in STUDIES[1:]}
"""The studies with the load held nearer and farther, 5 mm apart."""
_SPRINGS = 'spring.stiffness=["3 kN/m", "1 kN/m", "0.9 kN/m", "0.5 kN/m"]'
VARIANTS = PLACES | {
    "fig04-initial": ("fig04", "model.reference=initial"),
    "fig06-30kN": ("fig06", "spring.stiffness=30 kN/m"),
    "fig06-pretensions": ("fig06", "load.mass=0 kg", 'tendon.pretension=["1 N", "50 N", "100 N", "200 N"]'),
    "fig06-windows": ("fig06", 'spring.stiffness=["3 kN/m", "1 kN/m"]', "spool.ratio=[1.0, 0.7]"),
    "fig07-smooth": ("fig07", "sheath.friction=0"),
    "fig09-10kg": ("fig09", "load.mass=10 kg", 'tendon.pretension=["100 N", "200 N", "221 N"]'),
    "fig10-springs": ("fig10", 'load.mass=["5 kg", "10 kg"]', _SPRINGS),
    "fig11-10kg": ("fig11", "load.mass=10 kg"),
}
"""Studies of which some keys are as the letter of the paper, the reading used, or a claim has them."""

DIRECTIONS = ("flexion", "extension")
SIDES = ("flexor", "extensor")


@dataclass(frozen=True)
class PaperTables:
    """A study of the paper and its tables; `fixed` chooses the one design with these values."""

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

    @property
    def loads(self) -> list[float]:
        """kg."""
        return self.values("load_mass")

    def _rows(self, **fixed: float) -> npt.NDArray[np.bool_]:
        rows = np.ones(len(self.designs), dtype=np.bool_)
        for axis, value in fixed.items():
            rows &= np.isclose(self.designs[axis].to_numpy(np.float64), value)
        return rows

    def row(self, **fixed: float) -> int:
        """The place of the one design."""
        (row,) = np.flatnonzero(self._rows(**fixed))
        return int(row)

    def line(self, column: str, direction: str = "flexion", **fixed: float) -> Array:
        """A column of the states of one design and direction, by rising elbow angle."""
        angles = self.study.motion.elbow_angle.array
        shape = len(self.designs), len(self.study.motion.direction), len(angles)
        values = self.states[column].to_numpy(np.float64).reshape(shape)
        way = [*map(str, self.study.motion.direction)].index(direction)
        line: Array = values[self.row(**fixed), way][np.argsort(angles)]
        return line

    def design(self, column: str, **fixed: float) -> float:
        """A column of the one design."""
        return float(self.designs[column].to_numpy(np.float64)[self.row(**fixed)])

    def at(self, **fixed: float) -> PaperTables:
        """The run of the designs with these values alone."""
        rows = self._rows(**fixed)
        per_design = len(self.states) // len(self.designs)
        return replace(self, states=self.states[np.repeat(rows, per_design)], designs=self.designs[rows])

    def inputs(self) -> tuple[Design, Array, npt.NDArray[np.bool_]]:
        """What the model takes for the study: designs, elbow angles and whether it is flexion, ready to broadcast."""
        plan = Plan(self.study)
        (block,) = plan.blocks(range(plan.designs))
        return plan.design(block), *plan.motion(block)

    # --- Measures of curves ------------------------------------------------------------------------------------------

    def gain(self, direction: str, **fixed: float) -> Array:
        """τ_a − τ_m by elbow angle, N m."""
        return self.line("elbow_torque", direction, **fixed) - self.line("motor_torque", direction, **fixed)

    def crossing(self, **fixed: float) -> float:
        """The elbow angle of flexion at which the elbow torque comes to exceed the motor torque, deg; NaN for none."""
        gained = self.gain("flexion", **fixed)
        below = np.flatnonzero(gained <= 0.0)
        if not len(below) or below[-1] + 1 == len(gained):
            return float("nan")
        last = slice(below[-1], below[-1] + 2)
        return float(np.interp(0.0, gained[last], self.degrees[last]))

    def least(self, column: str, **fixed: float) -> float:
        """The smallest value of a column of states in both directions."""
        return float(min(self.line(column, way, **fixed).min() for way in DIRECTIONS))

    def depth(self, **fixed: float) -> float:
        """How deep the extensor's slack is: -(least distal tension) / K, mm; negative where it stays in tension."""
        return -1e3 * self.least("extensor_tension_distal", **fixed) / self.design("spring_stiffness", **fixed)

    def apart(self, quantity: str, **fixed: float) -> list[float]:
        """Largest difference between flexion and extension over the peak, in %, of flexor and extensor."""
        sides = ([self.line(f"{side}_{quantity}", way, **fixed) for way in DIRECTIONS] for side in SIDES)
        return [float(apart(np.array(both)).max()) for both in sides]

    def window(self, **fixed: float) -> tuple[float, float]:
        """The pretensions at which every state of a design is taut and stable, N; empty where the first is larger."""
        solved = window_of(*self.inputs(), Bounds())
        low, high = (float(np.ravel(end)[self.row(**fixed)]) for end in (solved.low, solved.high))
        return low, high


@dataclass(frozen=True)
class Paper:
    """All that statements are judged by: the tables of the studies, and fits of Table A.1."""

    runs: dict[str, PaperTables]
    fit: Fit
    """With the wrap angle that its coefficients imply."""
    fit_at_pi: Fit
    """With the angle that the paper prints."""

    def __getitem__(self, name: str) -> PaperTables:
        return self.runs[name]


def apart(both: Array) -> Array:
    """The difference between two lines at each place, in % of their peak."""
    peak = np.abs(both).max()
    return np.asarray(100.0 * np.abs(both[0] - both[1]) / peak) if peak else np.zeros(both.shape[1:])


def shared(windows: list[tuple[float, float]]) -> tuple[float, float]:
    """What is common to windows; empty where the first is the larger."""
    return max(low for low, _ in windows), min(high for _, high in windows)


def served(people: int, stiffness: float, ratio: float, loads: list[float]) -> float:
    """The share of men and women drawn from the survey whom one pretension serves for all loads, every 5°."""
    motion = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 19}}
    choice = {"spring": {"stiffness": stiffness}, "spool": {"ratio": ratio}, "load": {"mass": loads}}
    asked = question(study_from({"people": {"count": people}, "motion": motion, **choice}))
    windows = asked.windows({}, 1)
    return float(share_served(*grouped(windows.low, windows.high, asked.groups), asked.weighting).served[0])


def falls(values: Array | list[float]) -> bool:
    """Whether each value is smaller than the one before."""
    return bool((np.diff(values) < 0.0).all())


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
