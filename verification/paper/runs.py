"""Studies of the paper, swept into tables as any study is and read back, and their curves."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd

from tendon_cli.commands.starter import examples_folder
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.results import Run
from tendon_cli.engine.run import RunOptions, run_task
from tendon_cli.engine.sweep import Sweep
from tendon_cli.engine.window_fold import fold_ends
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.fits.friction.fit_result import Fit
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, shape_of
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.quantities import SIDES
from tendon_cli.studies.load import load_study, study_from
from tendon_cli.studies.study import Study

FOLDER = examples_folder() / "paper"
"""Folder of the paper's studies."""
READINGS = examples_folder() / "friction" / "table_a1.csv"
"""Table A.1 as a file of readings."""
STUDIES = ("fig04", "fig06", "fig07", "fig08", "fig09", "fig10", "fig11")
"""Names of the paper's studies, one for each figure."""
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
"""Variants by name: a study, and the settings that a statement about the paper needs."""


@dataclass(frozen=True)
class PaperTables:
    """Study of the paper with its tables.

    Methods with an argument `fixed` return results of the designs with these values of columns, in
    the order of the study.
    """

    study: Study
    """The study."""
    folder: Path
    """Folder of its run."""
    states: pd.DataFrame
    """Table of states."""
    designs: pd.DataFrame
    """Table of designs."""

    @cached_property
    def degrees(self) -> Array:
        """Elbow angles, rising, deg."""
        return np.degrees(np.sort(self.study.motion.elbow_angle.array))

    def values(self, axis: str) -> Array:
        """Return the different values of a column of designs, in the order of the study."""
        return self.designs[axis].unique().astype(np.float64)

    @property
    def loads(self) -> Array:
        """Masses of the load, kg."""
        return self.values("load_mass")

    def is_selected(self, **fixed: float) -> Flags:
        """Return True for each design with these values, shape (designs,)."""
        selected = np.ones(len(self.designs), dtype=np.bool_)
        for axis, value in fixed.items():
            selected &= np.isclose(self.designs[axis].to_numpy(np.float64), value)
        return selected

    def curves(self, column: str, **fixed: float) -> Array:
        """Return a column of states, shape (designs, directions, rising elbow angles)."""
        angles = self.study.motion.elbow_angle.array
        shape = (len(self.designs), len(self.study.motion.direction), len(angles))
        values = self.states[column].to_numpy(np.float64).reshape(shape)
        return np.asarray(values[self.is_selected(**fixed)][..., np.argsort(angles)])

    def line(self, column: str, direction: str = "flexion", **fixed: float) -> Array:
        """Return a column of the states of one design and direction, by rising elbow angle."""
        (curve,) = self.curves(column, **fixed)
        directions = [str(name) for name in self.study.motion.direction]
        return np.asarray(curve[directions.index(direction)])

    def design(self, column: str, **fixed: float) -> Array:
        """Return a column of designs, shape (designs,)."""
        return self.designs[column].to_numpy(np.float64)[self.is_selected(**fixed)]

    def select(self, **fixed: float) -> PaperTables:
        """Return the tables of the designs with these values."""
        selected = self.is_selected(**fixed)
        states_each = len(self.states) // len(self.designs)
        states = self.states[np.repeat(selected, states_each)]
        return replace(self, states=states, designs=self.designs[selected])

    def inputs(self) -> tuple[Design, Array, Flags]:
        """Return designs, elbow angles and flags of flexion for the model, ready to broadcast."""
        plan = Plan(self.study)
        (block,) = plan.blocks(range(plan.designs))
        return plan.design(block), *plan.motion(block)

    # --- Measures of curves ----------------------------------------------------------------------

    def travel_ratio(self) -> Array:
        """Return R_e / R_f for no slack as Eq. 3 prints it, H_f / H_e."""
        return self.line("flexor_travel") / self.line("extensor_travel")

    def gain(self, **fixed: float) -> Array:
        """Return τ_a − τ_m, shape (designs, directions, elbow angles), N m."""
        return self.curves("elbow_torque", **fixed) - self.curves("motor_torque", **fixed)

    def crossings(self, **fixed: float) -> list[float]:
        """Return the angle of flexion at which the elbow torque comes to exceed the motor torque.

        Returns:
            An angle in deg for each design; NaN if there is no such angle.
        """
        return self.crossings_of(self.gain(**fixed)[:, 0])

    def crossings_of(self, gains: Array) -> list[float]:
        """Return the last angle at which each gain comes to be positive, deg, or NaN.

        Args:
            gains: τ_a − τ_m in flexion, shape (designs, rising elbow angles), N m.
        """
        angles = []
        for gain in gains:
            below = np.flatnonzero(gain <= 0.0)
            if len(below) > 0 and below[-1] + 1 < len(gain):
                step = slice(below[-1], below[-1] + 2)
                angles.append(float(np.interp(0.0, gain[step], self.degrees[step])))
            else:
                angles.append(np.nan)
        return angles

    def smallest(self, column: str, **fixed: float) -> Array:
        """Return the smallest value of a column of states, by design."""
        return np.asarray(self.curves(column, **fixed).min(axis=(1, 2)))

    def slack_depth(self, **fixed: float) -> Array:
        """Return the depth of the extensor's slack by design, -(least distal tension) / K, mm.

        It is negative for an extensor that stays in tension.
        """
        least = self.smallest("extensor_tension_distal", **fixed)
        stiffness = self.design("spring_stiffness", **fixed)
        return -1e3 * least / stiffness

    def difference(self, quantity: str, **fixed: float) -> Array:
        """Return the largest difference between flexion and extension.

        Args:
            quantity: A column of states without its side, such as "tension_distal".
            **fixed: Values of the designs.

        Returns:
            Shape (sides, designs), % of the peak.
        """
        return np.array(
            [
                relative_difference(self.curves(f"{side}_{quantity}", **fixed)).max(axis=-1)
                for side in SIDES
            ]
        )

    def windows(self, **fixed: float) -> tuple[Array, Array]:
        """Return the pretensions at which every state of a design is taut and stable, N.

        Returns:
            Lowest and highest pretension by design; there is none if the lowest is larger.
        """
        design, angles, flexion = self.inputs()
        solved = fold_ends(design, shape_of(design), angles, flexion, Bounds())
        selected = self.is_selected(**fixed)
        return np.ravel(solved.low)[selected], np.ravel(solved.high)[selected]


@dataclass(frozen=True)
class Paper:
    """Evidence for all statements: the tables of the studies, and fits of Table A.1."""

    runs: dict[str, PaperTables]
    """Tables by the name of the study or variant."""
    fit: Fit
    """Fit with the wrap angle that its coefficients imply."""
    fit_at_pi: Fit
    """Fit with the angle that the paper prints."""

    def __getitem__(self, name: str) -> PaperTables:
        return self.runs[name]


def relative_difference(curves: Array) -> Array:
    """Return the difference between curves of flexion and extension at each angle.

    Args:
        curves: Shape (..., 2, angles), flexion first.

    Returns:
        Shape (..., angles), % of the peak of both curves.
    """
    peak = np.abs(curves).max(axis=(-2, -1))[..., np.newaxis]
    difference = np.abs(curves[..., 0, :] - curves[..., 1, :])
    return np.asarray(100.0 * difference / np.where(peak > 0.0, peak, 1.0))


def shares_of_people(
    people: int, stiffness: float, ratio: float, loads: npt.ArrayLike
) -> tuple[float, float]:
    """Return the shares of people whom one pretension serves, and each a pretension of their own.

    Args:
        people: Number of men and women drawn from the survey.
        stiffness: Stiffness of the springs, N/m.
        ratio: Ratio of the spool.
        loads: Masses of the load, all of which a pretension must hold every 5°, kg.
    """
    content = {
        "people": {"count": people},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 19}},
        "spring": {"stiffness": stiffness},
        "spool": {"ratio": ratio},
        "load": {"mass": np.atleast_1d(loads).tolist()},
        "uncertainty": {"usual": False},  # the paper's suit is exact
    }
    question = question_of(study_from(content))
    ends = Solver(question).ends(question.all_points())
    groups = question.groups
    low, high = groups.windows(ends.low, ends.high)
    by_one = groups.coverage(low, high).served
    by_their_own = groups.share(low <= high)
    return float(by_one[0]), float(by_their_own[0])


def is_falling(values: npt.ArrayLike) -> bool:
    """Return True if each value is smaller than the one before."""
    return bool((np.diff(np.asarray(values)) < 0.0).all())


def load(name: str) -> Study:
    """Return a study of the paper, or a variant of one."""
    study, *settings = VARIANTS.get(name, (name,))
    return load_study(FOLDER / f"{study}.toml", tuple(settings))


def sweep_studies(
    names: tuple[str, ...],
    area: Path,
    *,
    jobs: int | None,
    stop: threading.Event,
) -> Iterator[tuple[str, PaperTables]]:
    """Sweep studies one after the other, and yield each with its tables, every byte verified.

    Args:
        names: Names of studies or variants.
        area: Folder in which each study has a folder of its own.
        jobs: Parts made at once; None for one for each core.
        stop: Event that ends the sweeps.
    """
    for name in names:
        study = load(name)
        done = run_task(Sweep, Run, study, area / name, RunOptions(jobs=jobs, stop=stop))
        yield name, PaperTables(study, area / name, done.states, done.designs)
