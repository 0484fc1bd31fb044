"""Curves over the joint's angle: a CSV beside the study, or its columns in the study, as smooth cubic splines."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import GetJsonSchemaHandler
from pydantic_core import CoreSchema

from tendon_cli.errors import InputError
from tendon_cli.model.kinematics import Array, Spline
from tendon_cli.studies.csv_columns import read_columns
from tendon_cli.studies.fields import Mark, Single, fault
from tendon_cli.studies.number import Number, schema_table
from tendon_cli.units import described

MAX_BYTES = 4_000_000
MOST_ROWS = 20_000
FEWEST_BEYOND = 3
"""Rows of measured travels beyond the motion that keep the end of a spline away from it."""


@dataclass(frozen=True)
class CurveTable:
    """Columns over ascending angles of the joint, or times, SI; the first is the angle."""

    columns: dict[str, tuple[float, ...]]

    @property
    def angles(self) -> Array:
        """rad, ascending."""
        return np.array(self.columns["angle"])

    def document(self) -> dict[str, Any]:
        """As a study may say it."""
        return {
            name: [f"{value!r} rad" for value in values]
            if name in ("angle", "bend")
            else list(values)
            for name, values in self.columns.items()
        }

    def spline(self, column: str, noise: float = 0.0) -> Spline:
        """A column as a cubic spline: through its values, not-a-knot, or smoothed by noise of a standard deviation."""
        from scipy import interpolate  # only curves pay for its import

        angles, values = self.angles, np.array(self.columns[column])
        if len(angles) == 2:
            slope = (values[1] - values[0]) / (angles[1] - angles[0])
            return Spline(angles, np.array([[0.0], [0.0], [slope], [values[0]]]))
        if noise > 0.0 and len(angles) > 3:
            smooth = interpolate.PPoly.from_spline(
                interpolate.splrep(angles, values, k=3, s=len(angles) * noise**2)
            )
            pieces = np.flatnonzero(np.diff(smooth.x) > 0.0)
            return Spline(np.append(smooth.x[pieces], smooth.x[-1]), smooth.c[:, pieces])
        cubic = interpolate.CubicSpline(angles, values)
        return Spline(cubic.x, cubic.c)


@dataclass(frozen=True)
class CurveColumns(Mark):
    """Marks a field as a curve: the name of a CSV, or a table with these columns; each with its dimension."""

    dimensions: tuple[tuple[str, str], ...]
    fewest: int = 3

    @property
    def names(self) -> list[str]:
        """Of the columns, the angle first."""
        return [name for name, _ in self.dimensions]

    def read(self, value: object) -> str | CurveTable | None:
        """A file's name as it stands, columns as a table; raises PydanticCustomError."""
        if (
            value is None
            or isinstance(value, CurveTable)
            or (isinstance(value, str) and 0 < len(value) <= 4096)
        ):
            return value
        if not isinstance(value, dict) or set(value) != set(self.names):
            names = ", ".join(self.names)
            raise fault(
                f"{described(value)} is no curve, expected the name of a CSV, or lists of {names}"
            )
        columns = {
            name: self._column(name, dimension, value[name]) for name, dimension in self.dimensions
        }
        if len({len(values) for values in columns.values()}) > 1:
            raise fault(
                "its lists have different lengths, expected one value of each for every "
                + self.names[0]
            )
        wrong = disorder(np.array([*columns.values()]), self.fewest, self.names[0])
        if wrong is not None:
            raise fault(wrong[0])
        return _curve(columns)

    def _column(self, name: str, dimension: str, values: object) -> tuple[float, ...]:
        if not isinstance(values, (list, tuple)) or len(values) > MOST_ROWS:
            raise fault(f"{name}: {described(values)} is no list of values")
        kinds = {
            "angle": "elbow_angle",
            "torque": "elbow_torque",
            "length": "flexor_travel",
            "time": "time",
        }
        single = Single(kinds[dimension], 0, 0)
        return tuple(single.measure(value).si for value in values)

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"anyOf": [{"type": "string", "minLength": 1}, self.json_table()]}

    def json_table(self) -> dict[str, Any]:
        """The schema of its columns."""
        values = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": self.fewest}
        return schema_table(dict.fromkeys(self.names, values), len(self.names))


TORQUE = CurveColumns((("angle", "angle"), ("torque", "torque")))
EXCURSION = CurveColumns((("angle", "angle"), ("flexor", "length"), ("extensor", "length")))
BEND = CurveColumns((("angle", "angle"), ("bend", "angle")), fewest=2)
TRAJECTORY = CurveColumns((("time", "time"), ("angle", "angle")), fewest=12)


@dataclass(frozen=True)
class BendNumber(Number):
    """A bend angle, which may follow the joint: `{ angle = [...], bend = [...] }`."""

    def read(self, value: object) -> Any:
        """As a number, or as a curve; raises PydanticCustomError."""
        if isinstance(value, CurveTable):
            return value
        if isinstance(value, dict) and "bend" in value:
            return BEND.read(value)
        return super().read(value)

    def _json_choices(self) -> list[dict[str, Any]]:
        return [*super()._json_choices(), BEND.json_table()]


def disorder(rows: Array, fewest: int, of: str) -> tuple[str, int] | None:
    """What is wrong with columns over the first, angles or times, and in which row; None if nothing is."""
    angles = rows[0]
    if not fewest <= len(angles) <= MOST_ROWS:
        bound = f"{fewest} at least" if len(angles) < fewest else f"{MOST_ROWS:,} at most"
        return f"{len(angles):,} rows, expected {bound}", len(angles)
    if not np.isfinite(rows).all():
        return "a value that is not a finite number", int(np.argmax(~np.isfinite(rows).all(axis=0)))
    order = np.argsort(angles, kind="stable")
    same = np.flatnonzero(np.diff(angles[order]) == 0.0)
    if same.size:
        return f"the same {of} twice, expected each once", int(order[same[0] + 1])
    steps = np.sign(np.diff(angles))
    turned = steps != (steps[0] if of == "angle" else 1.0)
    if turned.any():
        return f"{of}s that go back and forth, expected them to rise", int(np.argmax(turned)) + 1
    return None


def _curve(columns: Mapping[str, Sequence[float]]) -> CurveTable:
    """Columns in the order of rising angles, or times."""
    first = next(iter(columns.values()))
    step = 1 if first[0] < first[-1] else -1
    return CurveTable({name: tuple(values[::step]) for name, values in columns.items()})


def read_curve(content: bytes, where: str, columns: CurveColumns) -> CurveTable:
    """A curve from CSV, as `read_columns` takes it; raises InputError with the line at fault."""
    of = columns.names[0]
    rows, lines = read_columns(content, where, dict(columns.dimensions), of)
    wrong = disorder(rows, columns.fewest, of)
    if wrong is not None:
        line = lines[min(wrong[1], len(lines) - 1)] if lines else 1
        names = ", ".join(columns.names)
        raise InputError(
            wrong[0],
            where=f"{where}, line {line}",
            hint=f"a row of {names} for each {of}, in order",
        )
    return _curve(dict(zip(columns.names, rows.tolist(), strict=True)))


def curves_of(study: Any) -> dict[str, Spline]:
    """The curves of a study by the keys of the model's numbers."""
    joint, tables = (
        study.joint,
        {"joint.torque": study.joint.torque, "load.torque": study.load.torque},
    )
    curves = {
        key: table.spline("torque")
        for key, table in tables.items()
        if isinstance(table, CurveTable)
    }
    curves |= {key: table.spline("bend") for key, table in bends_of(study).items()}
    if isinstance(joint.excursion, CurveTable):
        noise = joint.smoothing.single if joint.smoothing is not None else 0.0
        curves |= {
            f"joint.{side}_excursion": joint.excursion.spline(side, noise)
            for side in ("flexor", "extensor")
        }
    return curves


def bends_of(study: Any) -> dict[str, CurveTable]:
    """The bends that follow the joint, by key."""
    sheaths = {
        "sheath": study.sheath,
        "sheath.flexor": study.sheath.flexor,
        "sheath.extensor": study.sheath.extensor,
    }
    bends = {
        f"{key}.bend_angle": getattr(sheath, "bend_angle", None) for key, sheath in sheaths.items()
    }
    return {key: bend for key, bend in bends.items() if isinstance(bend, CurveTable)}


def not_covered(study: Any, table: CurveTable, *, is_travel: bool) -> str | None:
    """Which angle that a study asks for lies outside of a curve; travels are counted from where pretension is set."""
    if isinstance(study.motion.trajectory, str):  # not read yet
        return None
    key = "motion.elbow_angle" if study.trajectory is None else "motion.trajectory"
    asked = [(key, end) for end in (study.angles.min(), study.angles.max())]
    asked += [("setting.angle", end) for end in study.setting.angle.extremes if is_travel]
    low, high = table.angles[0], table.angles[-1]
    for key, angle in asked:
        if not low - 1e-9 <= angle <= high + 1e-9:
            reach = f"{math.degrees(low):.6g} to {math.degrees(high):.6g} deg"
            return f"reaches from {reach}, but {key} asks for {math.degrees(angle):.6g} deg"
    return None


def warnings_of(study: Any, table: CurveTable, where: str) -> list[str]:
    """Where measured travels do not rise, so that states have no equilibrium, or end too soon beyond the motion.

    Raises InputError if one never rises.
    """
    warnings, low, high = list[str](), study.angles.min(), study.angles.max()
    for end, beyond in ((low, table.angles < low - 1e-9), (high, table.angles > high + 1e-9)):
        if beyond.sum() < FEWEST_BEYOND:
            near = f"within {FEWEST_BEYOND} rows of the table's end, where slopes are less sure"
            warnings.append(f"{where}: the motion reaches {math.degrees(end):.4g} deg, {near}")
    for side in ("flexor", "extensor"):
        slopes = table.spline(side)(table.angles, 1)
        if (slopes < 0.0).all():
            hint = f"is the sign of {side} the other way? Both travels rise with flexion"
            raise InputError(f"the travel of the {side} falls throughout", where=where, hint=hint)
        if (slopes <= 0.0).any():
            falling = np.degrees(table.angles[slopes <= 0.0])
            span = f"{falling.min():.4g} to {falling.max():.4g} deg"
            warnings.append(
                f"{where}: the {side}'s travel does not rise at {span}: no equilibrium there"
            )
    return warnings
