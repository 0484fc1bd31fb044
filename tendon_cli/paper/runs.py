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
from tendon_cli.answers.problem import question
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.results import Run
from tendon_cli.engine.run import How, run_task
from tendon_cli.engine.sweep import Sweep
from tendon_cli.friction.fit_result import Fit
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
    "fig06-pretensions": (
        "fig06",
        "load.mass=0 kg",
        'tendon.pretension=["1 N", "50 N", "100 N", "200 N"]',
    ),
    "fig06-windows": ("fig06", 'spring.stiffness=["3 kN/m", "1 kN/m"]', "spool.ratio=[1.0, 0.7]"),
    "fig07-smooth": ("fig07", "sheath.friction=0"),
    "fig09-10kg": ("fig09", "load.mass=10 kg", 'tendon.pretension=["100 N", "200 N", "221 N"]'),
    "fig10-springs": ("fig10", 'load.mass=["5 kg", "10 kg"]', _SPRINGS),
    "fig11-10kg": ("fig11", "load.mass=10 kg"),
}
"""Studies of which some keys are as the letter of the paper, the reading used, or a claim has them."""

SIDES = ("flexor", "extensor")


@dataclass(frozen=True)
class PaperTables:
    """A study of the paper and its tables; `fixed` chooses the designs with these values, in the order of the study."""

    study: Study
    folder: Path
    states: pd.DataFrame
    designs: pd.DataFrame

    @cached_property
    def degrees(self) -> Array:
        """The elbow angles, rising, deg."""
        return np.degrees(np.sort(self.study.motion.elbow_angle.array))

    def values(self, axis: str) -> Array:
        """The different values of a column of `designs`, in the order of the study."""
        return self.designs[axis].unique().astype(np.float64)

    @property
    def loads(self) -> Array:
        """kg."""
        return self.values("load_mass")

    def places(self, **fixed: float) -> npt.NDArray[np.bool_]:
        """Where the designs are."""
        rows = np.ones(len(self.designs), dtype=np.bool_)
        for axis, value in fixed.items():
            rows &= np.isclose(self.designs[axis].to_numpy(np.float64), value)
        return rows

    def curves(self, column: str, **fixed: float) -> Array:
        """A column of states: designs, directions, rising elbow angles."""
        angles = self.study.motion.elbow_angle.array
        shape = len(self.designs), len(self.study.motion.direction), len(angles)
        values = self.states[column].to_numpy(np.float64).reshape(shape)
        return np.asarray(values[self.places(**fixed)][..., np.argsort(angles)])

    def line(self, column: str, direction: str = "flexion", **fixed: float) -> Array:
        """A column of the states of one design and direction, by rising elbow angle."""
        (curve,) = self.curves(column, **fixed)
        return np.asarray(curve[[*map(str, self.study.motion.direction)].index(direction)])

    def design(self, column: str, **fixed: float) -> Array:
        """A column of designs."""
        return self.designs[column].to_numpy(np.float64)[self.places(**fixed)]

    def at(self, **fixed: float) -> PaperTables:
        """The run of the designs with these values alone."""
        rows = self.places(**fixed)
        per_design = len(self.states) // len(self.designs)
        return replace(
            self, states=self.states[np.repeat(rows, per_design)], designs=self.designs[rows]
        )

    def inputs(self) -> tuple[Design, Array, npt.NDArray[np.bool_]]:
        """What the model takes for the study: designs, elbow angles and whether it is flexion, ready to broadcast."""
        plan = Plan(self.study)
        (block,) = plan.blocks(range(plan.designs))
        return plan.design(block), *plan.motion(block)

    # --- Measures of curves ------------------------------------------------------------------------------------------

    def travel_ratio(self) -> Array:
        """R_e / R_f for no slack as Eq. 3 prints it, H_f / H_e."""
        return self.line("flexor_travel") / self.line("extensor_travel")

    def gain(self, **fixed: float) -> Array:
        """τ_a − τ_m, N m: designs, directions, elbow angles."""
        return self.curves("elbow_torque", **fixed) - self.curves("motor_torque", **fixed)

    def crossings(self, **fixed: float) -> list[float]:
        """The elbow angle of flexion at which the elbow torque comes to exceed the motor torque, deg; NaN for none."""
        angles = []
        for gained in self.gain(**fixed)[:, 0]:
            below = np.flatnonzero(gained <= 0.0)
            crosses = len(below) > 0 and below[-1] + 1 < len(gained)
            last = slice(below[-1], below[-1] + 2) if crosses else slice(0)
            angles.append(
                float(np.interp(0.0, gained[last], self.degrees[last])) if crosses else np.nan
            )
        return angles

    def least(self, column: str, **fixed: float) -> Array:
        """The smallest value of a column of states, by design."""
        return np.asarray(self.curves(column, **fixed).min(axis=(1, 2)))

    def depth(self, **fixed: float) -> Array:
        """How deep the extensor's slack is: -(least distal tension) / K, mm; negative where it stays in tension."""
        return (
            -1e3
            * self.least("extensor_tension_distal", **fixed)
            / self.design("spring_stiffness", **fixed)
        )

    def apart(self, quantity: str, **fixed: float) -> Array:
        """Largest difference between flexion and extension, in % of the peak, by side and design."""
        return np.array(
            [apart(self.curves(f"{side}_{quantity}", **fixed)).max(axis=-1) for side in SIDES]
        )

    def windows(self, **fixed: float) -> tuple[Array, Array]:
        """The pretensions at which every state of a design is taut and stable, N; empty if the first is larger."""
        solved, places = window_of(*self.inputs(), Bounds()), self.places(**fixed)
        return np.ravel(solved.low)[places], np.ravel(solved.high)[places]


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
    """The difference between lines of flexion and extension, (..., 2, angles), at each angle, in % of their peak."""
    peak = np.abs(both).max(axis=(-2, -1))[..., np.newaxis]
    return np.asarray(
        100.0 * np.abs(both[..., 0, :] - both[..., 1, :]) / np.where(peak > 0.0, peak, 1.0)
    )


def served(people: int, stiffness: float, ratio: float, loads: Array) -> float:
    """The share of men and women drawn from the survey whom one pretension serves for all loads, every 5°."""
    motion = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 19}}
    choice = {
        "spring": {"stiffness": stiffness},
        "spool": {"ratio": ratio},
        "load": {"mass": list(loads)},
    }
    asked = question(study_from({"people": {"count": people}, "motion": motion, **choice}))
    windows = asked.windows({}, 1)
    return float(
        share_served(*grouped(windows.low, windows.high, asked.groups), asked.weighting).served[0]
    )


def falls(values: npt.ArrayLike) -> bool:
    """Whether each value is smaller than the one before."""
    return bool((np.diff(np.asarray(values)) < 0.0).all())


def load(name: str) -> Study:
    """A study of the paper, or a variant of one."""
    study, *settings = VARIANTS.get(name, (name,))
    return load_study(FOLDER / f"{study}.toml", tuple(settings))


def swept(
    names: tuple[str, ...],
    area: Path,
    *,
    jobs: int | None,
    stop: threading.Event,
    lock: bool = True,
) -> Iterator[tuple[str, PaperTables]]:
    """Sweep studies into folders of `area`, one after the other, and read their tables back, every byte verified."""
    for name in names:
        study = load(name)
        done = run_task(Sweep, Run, study, area / name, How(jobs=jobs, stop=stop, lock=lock))
        yield name, PaperTables(study, area / name, done.states, done.designs)
