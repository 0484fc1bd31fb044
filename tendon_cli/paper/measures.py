"""What findings and claims are judged by: measures of the curves of one study."""

from __future__ import annotations

import numpy as np

from tendon_cli.answers.coverage import grouped, share_served
from tendon_cli.answers.question import question
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.window import window as window_of
from tendon_cli.paper.runs import Array, PaperTables
from tendon_cli.studies.load import study_from

DIRECTIONS = ("flexion", "extension")
SIDES = ("flexor", "extensor")


def gain(run: PaperTables, direction: str, **fixed: float) -> Array:
    """τ_a − τ_m by elbow angle, N m."""
    return run.line("elbow_torque", direction, **fixed) - run.line("motor_torque", direction, **fixed)


def crossing(run: PaperTables, **fixed: float) -> float:
    """The elbow angle of flexion at which the elbow torque comes to exceed the motor torque, deg; NaN for none."""
    gained = gain(run, "flexion", **fixed)
    below = np.flatnonzero(gained <= 0.0)
    if not len(below) or below[-1] + 1 == len(gained):
        return float("nan")
    last = slice(below[-1], below[-1] + 2)
    return float(np.interp(0.0, gained[last], run.degrees[last]))


def least(run: PaperTables, column: str, **fixed: float) -> float:
    """The smallest value of a column of states in both directions."""
    return float(min(run.line(column, way, **fixed).min() for way in DIRECTIONS))


def depth(run: PaperTables, **fixed: float) -> float:
    """How deep the extensor's slack is: -(least distal tension) / K, mm; negative where it stays in tension."""
    return -1e3 * least(run, "extensor_tension_distal", **fixed) / run.design("spring_stiffness", **fixed)


def apart(run: PaperTables, quantity: str, **fixed: float) -> list[float]:
    """Largest difference between flexion and extension over the peak, in %, of flexor and extensor."""
    shares = []
    for side in SIDES:
        flexion, extension = (run.line(f"{side}_{quantity}", way, **fixed) for way in DIRECTIONS)
        peak = max(np.abs(flexion).max(), np.abs(extension).max())
        shares.append(float(100.0 * np.abs(flexion - extension).max() / peak) if peak else 0.0)
    return shares


def window(run: PaperTables, **fixed: float) -> tuple[float, float]:
    """The pretensions at which every state of a design is taut and stable, N; empty where the first is the larger."""
    found = window_of(*run.inputs(), Bounds())
    low, high = (float(np.ravel(end)[run.row(**fixed)]) for end in (found.low, found.high))
    return low, high


def shared(windows: list[tuple[float, float]]) -> tuple[float, float]:
    """What is common to windows; empty where the first is the larger."""
    return max(low for low, _ in windows), min(high for _, high in windows)


def served(people: int, stiffness: float, ratio: float, loads: list[float]) -> float:
    """The share of men and women drawn from the survey whom one pretension serves for all loads, every 5°."""
    content = {
        "people": {"count": people},
        "spring": {"stiffness": stiffness},
        "spool": {"ratio": ratio},
        "load": {"mass": loads},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 19}},
    }
    asked = question(study_from(content))
    found = asked.windows({}, 1)
    return float(share_served(*grouped(found.low, found.high, asked.groups), asked.weighting).served[0])


def falls(values: Array | list[float]) -> bool:
    """Whether each value is smaller than the one before."""
    return bool((np.diff(values) < 0.0).all())
