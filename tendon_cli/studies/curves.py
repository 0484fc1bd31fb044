"""Curves over the joint's angle: a CSV beside the study, or its columns in the study, as smooth cubic splines."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from tendon_cli.errors import InputError
from tendon_cli.model.kinematics import Array
from tendon_cli.model.spline import Spline
from tendon_cli.studies.fields import Single, fault
from tendon_cli.studies.number import Number
from tendon_cli.units import UNITS, described, known_units, shorten

MAX_BYTES = 4_000_000
MOST_ROWS = 20_000
_FEWEST = 3
_SEPARATORS = (";", "\t")


@dataclass(frozen=True)
class CurveTable:
    """CurveColumns over ascending angles of the joint, SI; the first is the angle."""

    columns: dict[str, tuple[float, ...]]

    @property
    def angles(self) -> Array:
        """rad, ascending."""
        return np.array(self.columns["angle"])

    def document(self) -> dict[str, Any]:
        """As a study may say it."""
        return {
            name: [f"{value!r} rad" for value in values] if name in ("angle", "bend") else list(values)
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
            found = interpolate.PPoly.from_spline(interpolate.splrep(angles, values, k=3, s=len(angles) * noise**2))
            pieces = np.flatnonzero(np.diff(found.x) > 0.0)
            return Spline(np.append(found.x[pieces], found.x[-1]), found.c[:, pieces])
        cubic = interpolate.CubicSpline(angles, values)
        return Spline(cubic.x, cubic.c)


@dataclass(frozen=True)
class CurveColumns:
    """Marks a field as a curve: the name of a CSV, or a table with these columns; each with its dimension."""

    dimensions: tuple[tuple[str, str], ...]
    fewest: int = _FEWEST

    def read(self, value: object) -> str | CurveTable | None:
        """A file's name as it stands, columns as a table; raises PydanticCustomError."""
        if value is None or isinstance(value, CurveTable):
            return value
        if isinstance(value, str) and 0 < len(value) <= 4096:
            return value
        names = [name for name, _ in self.dimensions]
        if not isinstance(value, dict) or set(value) != set(names):
            raise fault(f"{described(value)} is no curve, expected the name of a CSV, or lists of {', '.join(names)}")
        found = {name: self._column(name, dimension, value[name]) for name, dimension in self.dimensions}
        if len({len(values) for values in found.values()}) > 1:
            raise fault("its lists have different lengths, expected one value of each for every angle")
        wrong = disorder(np.array([found[name] for name in names]), self.fewest)
        if wrong is not None:
            raise fault(wrong[0])
        return CurveTable(_ascending(found))

    def _column(self, name: str, dimension: str, values: object) -> tuple[float, ...]:
        if not isinstance(values, (list, tuple)) or len(values) > MOST_ROWS:
            raise fault(f"{name}: {described(values)} is no list of values")
        single = Single({"angle": "elbow_angle", "torque": "elbow_torque", "length": "flexor_travel"}[dimension], 0, 0)
        return tuple(single.measure(value).si for value in values)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        values = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": self.fewest}
        names = [name for name, _ in self.dimensions]
        table = {"type": "object", "properties": dict.fromkeys(names, values), "required": names}
        return {"anyOf": [{"type": "string", "minLength": 1}, {**table, "additionalProperties": False}]}


TORQUE = CurveColumns((("angle", "angle"), ("torque", "torque")))
EXCURSION = CurveColumns((("angle", "angle"), ("flexor", "length"), ("extensor", "length")))
BEND = CurveColumns((("angle", "angle"), ("bend", "angle")), fewest=2)


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
        values = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 2}
        table = {"type": "object", "properties": {"angle": values, "bend": values}, "required": ["angle", "bend"]}
        return [*super()._json_choices(), {**table, "additionalProperties": False}]


def disorder(rows: Array, fewest: int) -> tuple[str, int] | None:
    """What is wrong with columns whose first are angles, and in which row; None if nothing is."""
    angles = rows[0]
    if len(angles) < fewest:
        return f"{len(angles)} rows, expected {fewest} at least", len(angles)
    if not np.isfinite(rows).all():
        return "a value that is not a finite number", int(np.argmax(~np.isfinite(rows).all(axis=0)))
    order = np.argsort(angles, kind="stable")
    same = np.flatnonzero(np.diff(angles[order]) == 0.0)
    if same.size:
        return "the same angle twice, expected each once", int(order[same[0] + 1])
    steps = np.sign(np.diff(angles))
    if not (steps == steps[0]).all():
        return "angles that go back and forth, expected them to rise", int(np.argmax(steps != steps[0])) + 1
    return None


def _ascending(columns: dict[str, tuple[float, ...]]) -> dict[str, tuple[float, ...]]:
    rising = columns["angle"][0] < columns["angle"][-1]
    return columns if rising else {name: values[::-1] for name, values in columns.items()}


def read_curve(content: bytes, where: str, columns: CurveColumns) -> CurveTable:
    """A curve from CSV: a header with a unit in each cell, such as `angle (deg)` or `torque_Nm`; # begins a comment.

    Raises InputError with the line at fault.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("not UTF-8 text", where=where, hint="save it as CSV in UTF-8") from None
    lines = [(at, line) for at, line in enumerate(text.splitlines(), 1) if line.strip() and line.lstrip()[0] != "#"]
    names = ", ".join(name for name, _ in columns.dimensions)
    if not lines or len(lines) > MOST_ROWS:
        problem = f"holds {len(lines) - 1:,} rows, expected {MOST_ROWS:,} at most" if lines else "is empty"
        raise InputError(problem, where=where, hint=f"a header {names} and a line for each angle")
    separator = next((sign for sign in _SEPARATORS if sign in lines[0][1]), ",")
    places = _places(next(csv.reader([lines[0][1]], delimiter=separator)), columns, f"{where}, line {lines[0][0]}")
    rows = np.array([_row(line, separator, places, f"{where}, line {at}") for at, line in lines[1:]]).reshape(
        -1, len(places)
    )
    wrong = disorder(rows.T, columns.fewest)
    if wrong is not None:
        at = lines[min(wrong[1] + 1, len(lines) - 1)][0]
        raise InputError(wrong[0], where=f"{where}, line {at}", hint=f"a row of {names} for each angle, in order")
    found = {name: tuple(rows[:, at].tolist()) for at, (name, _) in enumerate(columns.dimensions)}
    return CurveTable(_ascending(found))


def _places(header: list[str], columns: CurveColumns, where: str) -> list[tuple[int, str, float]]:
    """Where each column is, and SI values per value in it."""
    found = []
    for name, dimension in columns.dimensions:
        pattern = re.compile(rf"\s*{name}\s*[\[(_ ]?\s*(?P<unit>.*?)\s*[\])]?\s*", re.IGNORECASE)
        cells = [(at, match["unit"]) for at, cell in enumerate(header) if (match := pattern.fullmatch(cell))]
        expected = f"such as {name} ({known_units(dimension)[0]})"
        if not cells:
            raise InputError(
                f"no column {name}, the header reads: {shorten(', '.join(header))}", where=where, hint=expected
            )
        at, unit = cells[0]
        if not unit:
            raise InputError(f"the column {name} has no unit", where=where, hint=expected)
        plain = {re.sub(r"[\s_·*.]", "", symbol).lower(): symbol for symbol in known_units(dimension)}
        symbol = unit if unit in UNITS else plain.get(re.sub(r"[\s_·*.]", "", unit).lower(), "")
        if symbol not in UNITS or UNITS[symbol].dimension != dimension:
            hint = f"units of {dimension}: {', '.join(known_units(dimension))}"
            raise InputError(f'the column {name} has the unit "{shorten(unit)}"', where=where, hint=hint)
        found.append((at, name, float(UNITS[symbol].factor)))
    return found


def _row(line: str, separator: str, places: list[tuple[int, str, float]], where: str) -> list[float]:
    cells = next(csv.reader([line], delimiter=separator))
    numbers = []
    for at, name, factor in places:
        cell = cells[at].strip() if at < len(cells) else ""
        try:
            number = float(cell.replace(",", ".") if separator != "," else cell)
        except ValueError:
            raise InputError(f'{name} is "{shorten(cell)}", expected a number', where=where) from None
        if not math.isfinite(number) or abs(number) > 1e9:
            raise InputError(f"{name} is {number}, expected a finite number", where=where)
        numbers.append(number * factor)
    return numbers


def curves_of(study: Any) -> dict[str, Spline]:
    """The curves of a study by the keys of the model's numbers."""
    joint, found = study.joint, dict[str, Spline]()
    noise = joint.smoothing.single if joint.smoothing is not None else 0.0
    if isinstance(joint.excursion, CurveTable):
        found |= {f"joint.{side}_excursion": joint.excursion.spline(side, noise) for side in ("flexor", "extensor")}
    for key, table in (("joint.torque", joint.torque), ("load.torque", study.load.torque)):
        if isinstance(table, CurveTable):
            found[key] = table.spline("torque")
    for key, table in bends_of(study).items():
        found[key] = table.spline("bend")
    return found


def bends_of(study: Any) -> dict[str, CurveTable]:
    """The bends that follow the joint, by key."""
    sheaths = {"sheath": study.sheath, "sheath.flexor": study.sheath.flexor, "sheath.extensor": study.sheath.extensor}
    bends = {f"{key}.bend_angle": getattr(sheath, "bend_angle", None) for key, sheath in sheaths.items()}
    return {key: bend for key, bend in bends.items() if isinstance(bend, CurveTable)}


def check_covers(study: Any, table: CurveTable, key: str, where: str) -> None:
    """Refuse a file that does not reach as far as the joint moves; raises InputError."""
    problem = not_covered(study, table, is_travel=key == "joint.excursion")
    if problem is not None:
        raise InputError(problem, where=where, hint="extend the table, or ask for fewer angles")


def not_covered(study: Any, table: CurveTable, *, is_travel: bool) -> str | None:
    """Which angle that a study asks for lies outside of a curve; travels are counted from where pretension is set."""
    asked = [("motion.elbow_angle", end) for end in study.motion.elbow_angle.extremes]
    asked += [("setting.angle", end) for end in study.setting.angle.extremes if is_travel]
    low, high = table.angles[0], table.angles[-1]
    for key, angle in asked:
        if not low - 1e-9 <= angle <= high + 1e-9:
            reach = f"{math.degrees(low):.6g} to {math.degrees(high):.6g} deg"
            return f"reaches from {reach}, but {key} asks for {math.degrees(angle):.6g} deg"
    return None


def warnings_of(table: CurveTable, where: str) -> list[str]:
    """Where measured travels do not rise, so that states have no equilibrium; raises InputError if one never does."""
    found = []
    for side in ("flexor", "extensor"):
        slopes = table.spline(side)(table.angles, 1)
        if (slopes < 0.0).all():
            hint = f"is the sign of {side} the other way? Both travels rise with flexion"
            raise InputError(f"the travel of the {side} falls throughout", where=where, hint=hint)
        if (slopes <= 0.0).any():
            falling = np.degrees(table.angles[slopes <= 0.0])
            span = f"{falling.min():.4g} to {falling.max():.4g} deg"
            found.append(f"{where}: the {side}'s travel does not rise at {span}: no equilibrium there")
    return found
