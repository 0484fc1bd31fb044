"""States of some designs, computed anew for the page by the same engine, as curves over the elbow angle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

import numpy as np

from tendon_cli.figures.labels import shown
from tendon_cli.report.packed import packed
from tendon_cli.study.load import study_from
from tendon_cli.study.study import keys
from tendon_cli.sweep.sweep import sweep

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
}
_ARM = ("a1", "b1", "a2", "b2", "elbow_radius", "load_distance")

Numbers = Mapping[str, Any]
"""Values in SI by their dotted keys."""


def with_designs(document: Mapping[str, Any], designs: Sequence[Numbers]) -> dict[str, Any]:
    """A study whose designs are those given, one case each, at a few of its elbow angles."""
    study = deepcopy(dict(document))
    angles = study_from(study).motion.elbow_angle.array
    chosen = np.unique(np.round(np.linspace(0, len(angles) - 1, min(len(angles), MOST_ANGLES))).astype(int))
    for numbers in designs:
        for key, value in numbers.items():
            _put(study, key, value)  # an axis becomes one value; which, each case says
    study["motion"]["elbow_angle"] = [f"{float(angle)!r} rad" for angle in angles[chosen]]
    study["cases"] = [_case(at, numbers) for at, numbers in enumerate(designs)]
    study["output"] = {"tables": ["states"]}
    for name in ("people", "uncertainty", "design"):
        study.pop(name, None)
    return study


def states_record(document: Mapping[str, Any], designs: Sequence[Numbers]) -> dict[str, Any]:
    """Curves of designs, in their order, as the page has them."""
    study = study_from(with_designs(document, designs))
    table = sweep(study).tables["states"]
    groups = []
    for label, columns in GROUPS.items():
        lines = [
            {
                "label": shown(table.schema, column).name,
                "colour": next((side for side in ("flexor", "extensor") if side in column), "motor"),
                "array": packed(shown(table.schema, column).scaled(_numbers(table, column))),
            }
            for column in columns
        ]
        lines[0]["colour"] = "extensor" if label == "torque" else lines[0]["colour"]
        unit = shown(table.schema, columns[0]).unit
        groups.append({"label": label, "unit": "" if unit == "1" else unit, "lines": lines})
    angles = np.rad2deg(study.motion.elbow_angle.array)
    shown_angles = [round(float(angle), 6) for angle in angles]
    return {"angles": shown_angles, "directions": list(study.motion.direction), "groups": groups}


def arm_record(
    document: Mapping[str, Any], axis_of: Mapping[str, int], values: Sequence[Sequence[float]]
) -> dict[str, Any]:
    """The arm's measures: one value, or those along an axis of the page."""
    found = {}
    for name in _ARM:
        axis = axis_of.get(f"arm.{name}")
        given = document["arm"][name]
        single = given if isinstance(given, int | float) else 0.0
        found[name] = {"axis": axis, "values": [single] if axis is None else list(values[axis])}
    return found


def _numbers(table: Any, column: str) -> Any:
    return table.column(column).to_numpy(zero_copy_only=False)


def _case(at: int, numbers: Numbers) -> dict[str, Any]:
    case: dict[str, Any] = {"name": str(at)}
    for key, value in numbers.items():
        _put(case, key, value)
    return case


def _put(into: dict[str, Any], key: str, value: Any) -> None:
    *tables, name = key.split(".")
    for table in tables:
        into = into.setdefault(table, {})
    is_number = key in keys() and isinstance(value, int | float)
    into[name] = _with_unit(key, float(value)) if is_number else value


def _with_unit(key: str, value: float) -> str | float:
    """A number as a study takes it: a bare angle would be refused."""
    unit = keys()[key].number.quantity.unit
    return value if unit == "1" else f"{value!r} {unit}"
