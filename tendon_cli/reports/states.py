"""States of some designs as curves over the elbow angle, and their arms, by the model alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import evenly
from tendon_cli.cube.labels import Shown
from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Anchors, Array
from tendon_cli.quantities import QUANTITIES
from tendon_cli.reports.data import packed
from tendon_cli.studies.study import Study

MOST_ANGLES = 61
MOST_DESIGNS = 400
"""Whose states the page keeps: about 3 kB each."""

GROUPS = {
    "tension at the elbow": ("flexor_tension_distal", "extensor_tension_distal"),
    "tension at the motor": ("flexor_tension_proximal", "extensor_tension_proximal"),
    "torque": ("elbow_torque", "motor_torque"),
    "elbow stiffness": ("elbow_stiffness",),
    "slack length": ("flexor_slack", "extensor_slack"),
    "spool angle": ("spool_angle",),
    "travel": ("flexor_travel", "extensor_travel"),
}
OF_TAUT = ("tension at the elbow", "torque", "elbow stiffness", "travel")
"""Those that say something of states without slack; the travels are shown of a joint that has no anchors to draw."""
_ANCHORS = ("a1", "b1", "a2", "b2", "elbow_radius")
_ARM = (*_ANCHORS, "load_distance")

Curves = dict[str, Array]
"""Columns of states, (designs, directions, angles), and measures of the arm, (designs,)."""


def angles_of(study: Study) -> Array:
    """The elbow angles that a page keeps, (1, K)."""
    angles = study.angles
    if study.trajectory is not None:  # curves over the angle stand still
        angles = np.linspace(angles.min(), angles.max(), MOST_ANGLES)
    return np.asarray(angles[evenly(len(angles), MOST_ANGLES)]).reshape(1, -1)


def curves(study: Study, design: Design, shape: tuple[int, ...], labels: Iterable[str] = GROUPS) -> Curves:
    """Of designs, whose axes have a shape, the curves of some groups."""
    flexion = np.array([[direction == "flexion"] for direction in study.motion.direction])
    angles = angles_of(study)
    columns = State.columns(evaluate(design, angles, flexion))
    states = (*shape, flexion.size, angles.size)
    is_drawn = isinstance(design.arm.joint, Anchors)
    wanted = [column for label in labels if not (is_drawn and label == "travel") for column in GROUPS[label]]
    result = {name: np.broadcast_to(columns[name], states).reshape(-1, *states[-2:]) for name in wanted}
    joint = design.arm.joint
    measures = {name: getattr(joint, name) for name in _ANCHORS} if is_drawn else {}
    measures["load_distance"] = design.arm.load_distance
    return result | {name: np.broadcast_to(value, (*shape, 1, 1)).ravel() for name, value in measures.items()}


def states_record(
    study: Study, kept: Sequence[npt.NDArray[np.int64]], of_conditions: Sequence[tuple[str, Curves]]
) -> tuple[dict[str, Any], list[dict[str, list[float]]]]:
    """Curves and arms as the page has them, of each condition by what it is called; `kept` on the page's axes."""
    record = {
        "kept": [[int(index) for index in each] for each in kept],
        "angles": [round(float(angle), 6) for angle in np.rad2deg(angles_of(study).ravel())],
        "directions": list(study.motion.direction),
        "groups": [group for at, each in enumerate(of_conditions) for group in _groups(at, *each)],
    }
    arms = [{name: _short(result[name]) for name in _ARM if name in result} for _, result in of_conditions]
    return record, arms


def _groups(arm: int, condition: str, result: Curves) -> Iterable[dict[str, Any]]:
    for label, columns in GROUPS.items():
        lines: list[dict[str, Any]] = []
        for column in columns if columns[0] in result else ():
            shown = Shown.of(column, QUANTITIES[column])
            colour = next((side for side in ("flexor", "extensor") if side in column), "motor")
            lines.append({"label": shown.name, "colour": colour, "array": packed(shown.scaled(result[column]))})
        if not lines:
            continue
        lines[0]["colour"] = "joint" if label == "torque" else lines[0]["colour"]
        unit = Shown.of(columns[0], QUANTITIES[columns[0]]).unit
        text = f"{label}, {condition}" if condition else label
        yield {"label": text, "condition": condition, "arm": arm, "unit": "" if unit == "1" else unit, "lines": lines}


def _short(values: Array) -> list[float]:
    """A measure of each design, or once where it is the same for all."""
    rounded = [float(f"{value:.6g}") for value in values.tolist()]
    return rounded[:1] if len(set(rounded)) == 1 else rounded
