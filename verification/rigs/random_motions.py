"""Random motions in time, drawn as numbers that a study can state, and the rig's course of each.

`MOTIONS` has, for every kind, the seeds whose motions keep both tendons taut. The rig's last cycle
of each is kept in `random_motions.npz`; `python -m verification.rigs.random_motions` makes it anew.

    for case in random_cases():
        study = case.study(folder)       # dictionary of strings with units; writes the CSVs
        course = case.course()           # the rig's last cycle: see `Course`
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .elastic_links import History, Motion, simulate
from .gripped_cables import Array
from .plain_dictionary import make_rig

KINDS = {
    "plain": 200,
    "spring at the motor": 15,
    "bend follows the joint": 15,
    "excursions": 15,
    "joint's own torque": 15,
    "slack": 10,
}
"""Kinds of motions, and how many of each there are."""

CYCLES = 3
"""Cycles that the rig goes through; the last one counts."""

SAMPLES = 320
"""Samples of a cycle in the rig."""

KEPT = 80
"""Samples of a cycle that are kept."""

NODES = 24
"""Nodes of each sheath."""

CACHE = Path(__file__).with_name("random_motions.npz")
"""Seeds and last cycles of all motions."""

MOST_ACCELERATION = 70.0
"""Largest angular acceleration of a joint, rad/s²."""

LEAST_ANGLE = 0.05
MOST_ANGLE = 2.0
"""Range of the joint's angle, rad."""


def rounded(value: float) -> float:
    """Round to four digits, so that a study's text has the very number."""
    return float(f"{value:.4g}")


@dataclass(frozen=True)
class Sines:
    """Middle plus a sum of amplitude × sin(2π n f t + phase), n counting the harmonics."""

    middle: float
    frequency: float
    amplitudes: tuple[float, ...]
    phases: tuple[float, ...]

    def derivative(self, time: Array, order: int) -> Array:
        """Return a derivative of some order with respect to time, order 0 being the value."""
        value = np.full_like(time, self.middle if order == 0 else 0.0)
        for place, (amplitude, phase) in enumerate(zip(self.amplitudes, self.phases, strict=True)):
            pulse = 2.0 * np.pi * self.frequency * (place + 1)
            turned = pulse * time + phase + 0.5 * np.pi * order
            value = value + amplitude * pulse**order * np.sin(turned)
        return value


@dataclass(frozen=True)
class Reaches:
    """Minimum-jerk reaches from one angle to another and back, with a rest after each.

    A period is reach, rest, return, rest; `share` of each half of it is motion.
    """

    low: float
    high: float
    frequency: float
    share: float

    def derivative(self, time: Array, order: int) -> Array:
        """Return a derivative of some order with respect to time, order 0 being the value."""
        half = 0.5 / self.frequency
        duration = self.share * half
        number = np.floor(time / half)
        place = np.minimum((time - number * half) / duration, 1.0)
        course = np.polynomial.Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
        value = (course.deriv(order) if order else course)(place) / duration**order
        returns = number % 2 == 1
        start = np.where(returns, self.high, self.low) if order == 0 else 0.0
        span = np.where(returns, self.low - self.high, self.high - self.low)
        return start + span * value


@dataclass(frozen=True)
class Course:
    """The rig's last cycle of a motion, `KEPT` samples from its start.

    Attributes:
        time: Time since the start of the cycle, s.
        motor_torque: Torque of the motor, N m.
        spool_angle: Spool's angle since the set-up, rad.
        slides: 1 where both sheaths slide as when the spool winds the flexor, -1 where they
            slide the other way, 0 where some node does otherwise; at rest as they last slid.
        is_slack: True where a tendon is slack.
        lost: Work of friction over the cycle, J.
        work: Work of the motor over the cycle, J.
        peak_torque: Largest torque of the motor by magnitude, at all the rig's samples, N m.
    """

    time: Array
    motor_torque: Array
    spool_angle: Array
    slides: NDArray[np.int8]
    is_slack: NDArray[np.bool_]
    lost: float
    work: float
    peak_torque: float


@dataclass(frozen=True)
class RandomCase:
    """A suit and its motion.

    Attributes:
        kind: One of `KINDS`.
        seed: Number that it was drawn with.
        suit: Its numbers, as `make_rig` takes them.
        joint: Joint's angle over time, rad.
        task: Further torque over time, N m, or None.
    """

    kind: str
    seed: int
    suit: Mapping[str, Any]
    joint: Sines | Reaches
    task: Sines | None

    @property
    def period(self) -> float:
        """Duration of a cycle, s."""
        return 1.0 / self.joint.frequency

    @property
    def highest_frequency(self) -> float:
        """Highest frequency of the motion that matters, Hz; of reaches, two in a reach."""
        if isinstance(self.joint, Reaches):
            return 4.0 * self.joint.frequency / self.joint.share
        return self.joint.frequency * len(self.joint.amplitudes)

    def motion(self, cycles: int = CYCLES, samples: int = SAMPLES) -> Motion:
        """Return the motion at samples, with exact derivatives."""
        time = np.arange(cycles * samples + 1) * self.period / samples
        return Motion(
            time=time,
            angle=self.joint.derivative(time, 0),
            acceleration=self.joint.derivative(time, 2),
            task=self.task.derivative(time, 0) if self.task else np.zeros(0),
        )

    def course(self) -> Course:
        """Return the rig's last cycle, as it is kept in the file."""
        index = self._index()
        kept = cached()
        rows = slice(index * KEPT, (index + 1) * KEPT)
        return Course(
            time=np.arange(KEPT) * self.period / KEPT,
            motor_torque=kept["motor_torque"][rows].astype(float),
            spool_angle=kept["spool_angle"][rows].astype(float),
            slides=kept["slides"][rows],
            is_slack=kept["is_slack"][rows],
            lost=float(kept["lost"][index]),
            work=float(kept["work"][index]),
            peak_torque=float(kept["peak_torque"][index]),
        )

    def _index(self) -> int:
        kept = cached()
        kind = list(KINDS).index(self.kind)
        is_this = (kept["kind"] == kind) & (kept["seed"] == self.seed)
        return int(np.flatnonzero(is_this)[0])

    def study(
        self, folder: Path, cycles: int = 5, samples: int = 240, cutoff: float = 4.0
    ) -> dict[str, Any]:
        """Write trajectory and task as CSV files; return a study that names them.

        The record has whole cycles from time 0 on. Every number is a string with a unit.

        Args:
            folder: Folder of the CSV files.
            cycles: Cycles of the record.
            samples: Rows of a cycle; a multiple of `KEPT` has those of `course` among them.
            cutoff: Cutoff of the low-pass over the highest frequency of the motion.
        """
        motion = self.motion(cycles, samples)
        trajectory = folder / "trajectory.csv"
        write_table(trajectory, "time (s),angle (rad)", motion.time, motion.angle)
        study = study_numbers(self.suit)
        study["name"] = f"{self.kind.replace(' ', '-').replace(chr(39), '')}-{self.seed}"
        study["motion"]["trajectory"] = str(trajectory)
        study["motion"]["cutoff"] = f"{cutoff * self.highest_frequency:.6g} Hz"
        if self.task:
            task = folder / "task.csv"
            write_table(task, "time (s),torque (N m)", motion.time, motion.task)
            study["load"]["torque"] = str(task)
        return study


def write_table(path: Path, header: str, *columns: Array) -> None:
    """Write columns as a CSV file with all their digits."""
    rows = zip(*(column.tolist() for column in columns), strict=True)
    lines = [",".join(repr(value) for value in row) for row in rows]
    path.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")


UNITS = {
    "a1": "m",
    "b1": "m",
    "a2": "m",
    "b2": "m",
    "elbow_radius": "m",
    "forearm_mass": "kg",
    "forearm_com": "m",
    "load_distance": "m",
    "upper_arm_angle": "rad",
    "bend_angle": "rad",
    "length": "m",
    "diameter": "m",
    "youngs_modulus": "Pa",
    "pretension": "N",
    "stiffness": "N/m",
    "flexor_radius": "m",
    "mass": "kg",
    "inertia": "kg m2",
    "rest_angle": "rad",
    "angle": "rad",
    "bend": "rad",
    "torque": "N m",
    "flexor": "m",
    "extensor": "m",
}
"""Units of a suit's numbers by the last part of their keys."""


def study_numbers(part: Mapping[str, Any], name: str = "") -> dict[str, Any]:
    """Return a suit's numbers as a study states them: strings with units."""
    result: dict[str, Any] = {}
    for key, value in part.items():
        unit = UNITS.get(key, "")
        if name == "joint" and key == "stiffness":
            unit = "N m/rad"
        if isinstance(value, Mapping):
            result[key] = study_numbers(value, key)
        elif isinstance(value, Sequence) and not isinstance(value, str):
            result[key] = [f"{number!r} {unit}".strip() for number in value]
        elif isinstance(value, str) or not unit:
            result[key] = value
        else:
            result[key] = f"{value!r} {unit}"
    return result


def draw_suit(rng: np.random.Generator, kind: str) -> dict[str, Any]:
    """Draw the numbers of a suit."""
    bend = rounded(rng.uniform(2.0, 5.0))
    friction = rounded(rng.uniform(0.1, 0.9) / bend)
    low_pretension = kind == "slack"
    suit: dict[str, Any] = {
        "arm": {
            "a1": rounded(rng.uniform(0.03, 0.06)),
            "b1": rounded(rng.uniform(0.12, 0.2)),
            "a2": rounded(rng.uniform(0.015, 0.035)),
            "b2": rounded(rng.uniform(0.12, 0.18)),
            "elbow_radius": rounded(rng.uniform(0.038, 0.055)),
            "forearm_mass": rounded(rng.uniform(1.0, 2.0)),
            "forearm_com": rounded(rng.uniform(0.15, 0.2)),
            "load_distance": rounded(rng.uniform(0.27, 0.36)),
            "upper_arm_angle": rounded(rng.uniform(-0.15, 0.35)),
        },
        "sheath": {"friction": friction, "bend_angle": bend},
        "tendon": {
            "length": rounded(rng.uniform(0.8, 2.5)),
            "diameter": rounded(rng.uniform(1.0e-3, 2.0e-3)),
            "youngs_modulus": rounded(rng.uniform(60e9, 150e9)),
            "pretension": rounded(rng.uniform(20, 60) if low_pretension else rng.uniform(100, 350)),
        },
        "spring": {"stiffness": rounded(rng.uniform(3e3, 12e3))},
        "spool": {
            "flexor_radius": rounded(rng.uniform(0.02, 0.04)),
            "ratio": rounded(rng.uniform(0.45, 0.85)),
        },
        "load": {"mass": rounded(rng.uniform(0.0, 5.0)) if rng.random() < 0.8 else 0.0},
        "motion": {"inertia": rounded(rng.uniform(0.04, 0.12))},
    }
    if rng.random() < 0.5:
        suit["anchor"] = {"stiffness": rounded(rng.uniform(5e3, 25e3))}
    if kind == "spring at the motor":
        suit["spring"]["at"] = "motor"
    if kind == "bend follows the joint":
        further = rounded(bend + rng.uniform(-1.0, 1.5))
        suit["sheath"]["bend_angle"] = {"angle": [0.0, 2.2], "bend": [bend, further]}
    if kind == "excursions":
        suit["joint"] = {"excursion": draw_excursion(rng)}
        for key in ("a1", "b1", "a2", "b2", "elbow_radius"):
            del suit["arm"][key]
    if kind == "joint's own torque":
        suit["joint"] = draw_joint(rng)
    return suit


def draw_excursion(rng: np.random.Generator) -> dict[str, list[float]]:
    """Draw travels over the angle, whose slopes are moment arms of 20 to 80 mm."""
    angle = np.linspace(-0.1, 2.2, 24)
    flexor_arm = rng.uniform(0.035, 0.05) + rng.uniform(0.0, 0.03) * np.sin(0.9 * angle)
    wave = np.cos(1.3 * angle - rng.uniform(0.0, 1.0))
    extensor_arm = rng.uniform(0.025, 0.035) + rng.uniform(0.0, 0.008) * wave
    step = np.diff(angle)
    flexor = np.concatenate([[0.0], np.cumsum(0.5 * (flexor_arm[1:] + flexor_arm[:-1]) * step)])
    middle = 0.5 * (extensor_arm[1:] + extensor_arm[:-1])
    extensor = np.concatenate([[0.0], np.cumsum(middle * step)])
    return {
        "angle": [float(f"{value:.10g}") for value in angle],
        "flexor": [float(f"{value:.10g}") for value in flexor],
        "extensor": [float(f"{value:.10g}") for value in extensor],
    }


def draw_joint(rng: np.random.Generator) -> dict[str, Any]:
    """Draw the torque of a joint: a stiffness about a rest angle, or a table that stiffens."""
    if rng.random() < 0.5:
        return {
            "stiffness": rounded(rng.uniform(0.4, 2.5)),
            "rest_angle": rounded(rng.uniform(0.8, 1.6)),
        }
    angle = np.linspace(-0.1, 2.2, 16)
    slope = rng.uniform(0.4, 1.5)
    end = 0.6 * np.exp(3.0 * (angle - 1.9)) - 0.6 * np.exp(-4.0 * angle - 1.0)
    torque = slope * (angle - rng.uniform(0.8, 1.5)) + end
    return {
        "torque": {
            "angle": [float(f"{value:.10g}") for value in angle],
            "torque": [float(f"{value:.10g}") for value in torque],
        }
    }


def draw_joint_motion(rng: np.random.Generator) -> Sines | Reaches:
    """Draw sines, sums of sines and reaches of 0.25 to 3 Hz within the angles allowed."""
    kind = rng.choice(["sine", "sum", "reach"], p=[0.5, 0.3, 0.2])
    middle = rng.uniform(0.5, 1.3)
    room = min(middle - LEAST_ANGLE, MOST_ANGLE - middle)
    if kind == "reach":
        frequency = np.exp(rng.uniform(np.log(0.25), np.log(1.0)))
        share = rng.uniform(0.4, 0.9)
        duration = 0.5 * share / frequency
        half = min(room, MOST_ACCELERATION * duration**2 / 11.55) * rng.uniform(0.4, 1.0)
        return Reaches(
            rounded(middle - half), rounded(middle + half), rounded(frequency), rounded(share)
        )
    frequency = rounded(np.exp(rng.uniform(np.log(0.25), np.log(3.0))))
    count = 1
    if kind == "sum":
        frequency = rounded(np.exp(rng.uniform(np.log(0.25), np.log(1.2))))
        count = 2
        if rng.random() < 0.5:
            count = 3
    shares = rng.uniform(0.3, 1.0, count) / np.arange(1, count + 1) ** 1.5
    acceleration = (shares * (2.0 * np.pi * frequency * np.arange(1, count + 1)) ** 2).sum()
    most = min(room / shares.sum(), MOST_ACCELERATION / acceleration)
    amplitudes = most * rng.uniform(0.4, 1.0) * shares
    return Sines(
        middle=rounded(middle),
        frequency=frequency,
        amplitudes=tuple(rounded(value) for value in amplitudes),
        phases=tuple(rounded(value) for value in rng.uniform(0.0, 2.0 * np.pi, count)),
    )


def draw_task(rng: np.random.Generator, frequency: float) -> Sines | None:
    """Draw a torque over time of up to 6 N m, with one to four periods a cycle, or none."""
    if rng.random() < 0.6:
        return None
    count = int(rng.integers(1, 5))
    amplitudes = np.zeros(count)
    amplitudes[-1] = rng.uniform(0.3, 6.0) / count**0.5
    return Sines(
        middle=rounded(rng.uniform(-1.0, 2.0)),
        frequency=frequency,
        amplitudes=tuple(rounded(value) for value in amplitudes),
        phases=tuple(rounded(value) for value in rng.uniform(0.0, 2.0 * np.pi, count)),
    )


def draw_case(kind: str, seed: int) -> RandomCase:
    """Draw a suit and its motion; it need not be taut."""
    rng = np.random.default_rng([37, list(KINDS).index(kind), seed])
    suit = draw_suit(rng, kind)
    joint = draw_joint_motion(rng)
    task = draw_task(rng, joint.frequency)
    return RandomCase(kind, seed, suit, joint, task)


def random_cases(*kinds: str) -> list[RandomCase]:
    """Return the motions of some kinds, or of all, as the file has them."""
    kept = cached()
    names = list(KINDS)
    pairs = zip(kept["kind"].tolist(), kept["seed"].tolist(), strict=True)
    cases = [draw_case(names[kind], seed) for kind, seed in pairs]
    return [case for case in cases if not kinds or case.kind in kinds]


@functools.cache
def cached() -> dict[str, NDArray[Any]]:
    """Return the arrays of the file: seeds and last cycles, one case after the other."""
    with np.load(CACHE) as file:
        return dict(file)


def run_cases(
    cases: Sequence[RandomCase],
    cycles: int = CYCLES,
    samples: int = SAMPLES,
    nodes: int = NODES,
) -> list[History]:
    """Drive the rig along all motions and return the last cycle of each."""
    rigs = [make_rig(case.suit) for case in cases]
    motions = [case.motion(cycles, samples) for case in cases]
    histories = simulate(rigs, motions, nodes)
    return [history.select(slice((cycles - 1) * samples, None)) for history in histories]


def is_slack(history: History) -> bool:
    """Return True if a tendon is slack at some sample."""
    return bool((history.flexor_slack | history.extensor_slack).any())


def find_seeds(kind: str, count: int) -> list[int]:
    """Return the first seeds whose motion a coarse rig finds taut, or slack if that is the kind."""
    found: list[int] = []
    first = 0
    while len(found) < count:
        cases = [draw_case(kind, seed) for seed in range(first, first + 2 * count)]
        first += 2 * count
        histories = run_cases(cases, cycles=2, samples=60, nodes=2)
        wanted = kind == "slack"
        pairs = zip(cases, histories, strict=True)
        found += [case.seed for case, history in pairs if is_slack(history) == wanted]
    return found[:count]


def make_cache(path: Path = CACHE) -> None:
    """Find the seeds, drive the rig along their motions and write the file."""
    seeds = {kind: find_seeds(kind, count) for kind, count in KINDS.items()}
    cases = [draw_case(kind, seed) for kind in KINDS for seed in seeds[kind]]
    histories = run_cases(cases)
    every = SAMPLES // KEPT
    rows = [history.select(slice(0, SAMPLES, every)) for history in histories]
    mean_slide = [0.5 * (row.flexor_slides - row.extensor_slides) for row in rows]
    names = list(KINDS)
    np.savez_compressed(
        path,
        kind=np.array([names.index(case.kind) for case in cases], dtype=np.int8),
        seed=np.array([case.seed for case in cases], dtype=np.int32),
        motor_torque=np.concatenate([row.motor_torque for row in rows]).astype(np.float32),
        spool_angle=np.concatenate([row.spool_angle for row in rows]).astype(np.float32),
        slides=np.trunc(np.concatenate(mean_slide)).astype(np.int8),
        is_slack=np.concatenate([row.flexor_slack | row.extensor_slack for row in rows]),
        lost=np.array([one.dissipated[-1] - one.dissipated[0] for one in histories]),
        work=np.array([one.motor_work[-1] - one.motor_work[0] for one in histories]),
        peak_torque=np.array([np.abs(one.motor_torque).max() for one in histories]),
    )


if __name__ == "__main__":
    make_cache()
