"""Curves over the joint's angle, or over time, from a CSV or from lists in the study.

Those over the angle are smooth cubic splines.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from pydantic import GetJsonSchemaHandler
from pydantic_core import CoreSchema

from tendon_cli.model.kinematics import Array, Spline
from tendon_cli.quantities import QUANTITIES
from tendon_cli.readers.clock import first_back
from tendon_cli.readers.heading import Heading, columns_named
from tendon_cli.readers.table import Table, read_table
from tendon_cli.studies.fields import FieldMark, SingleField, fault
from tendon_cli.studies.magnitude import (
    Slip,
    column_slips,
    raise_with_slips,
    step_slips,
)
from tendon_cli.studies.number import NumberField, schema_table
from tendon_cli.units import counted, described, factor_of, known_units

MAX_BYTES = 4_000_000
"""Largest size of a CSV of a curve, bytes."""
MOST_ROWS = 20_000
"""Largest number of rows of a curve."""
_LONGEST_NAME = 4096  # of a file
_STRAIGHT = 1e-13
"""Bend of a curve between two of its points, as a share of its values, that is rounding alone."""


class _Column(NamedTuple):
    """Column that a curve may have."""

    quantity: str
    """Quantity by whose units and range its values are read."""
    spellings: tuple[str, ...]
    """Its names in files, those of tendon's own tables among them."""

    @property
    def dimension(self) -> str:
        """Dimension of its values."""
        return QUANTITIES[self.quantity].dimension


_COLUMNS = {
    "angle": _Column("elbow_angle", ("angle", "elbow_angle", "joint_angle", "theta", "winkel")),
    "time": _Column("time", ("time", "t", "zeit", "timestamp", "millis", "micros", "nanos")),
    "torque": _Column(
        "elbow_torque",
        ("torque", "load_torque", "joint_torque", "elbow_torque", "moment", "drehmoment"),
    ),
    "flexor": _Column("flexor_travel", ("flexor", "flexor_travel", "flexor_excursion")),
    "extensor": _Column("flexor_travel", ("extensor", "extensor_travel", "extensor_excursion")),
    "bend": _Column("bend_angle", ("bend", "bend_angle")),
}
_OPTIONAL_SPELLINGS = {"torque": ("torque", "load_torque")}
"""Names of columns that a file may lack: its elbow torque is that of all loads."""


@dataclass(frozen=True)
class CurveTable:
    """Columns over ascending angles of the joint, or times, SI; the first is the angle or time."""

    columns: dict[str, tuple[float, ...]]
    """Values of each column by its name."""
    slips: tuple[Slip, ...] = field(default=(), compare=False)
    """Values as they were written that are far from any arm."""

    @property
    def is_in_time(self) -> bool:
        """True if the columns are over times, False if they are over angles."""
        return "time" in self.columns

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values())))

    @property
    def angles(self) -> Array:
        """Angles, ascending, rad."""
        return np.array(self.columns["angle"])

    @property
    def times(self) -> Array:
        """Times, ascending, s."""
        return np.array(self.columns["time"])

    def without(self, column: str) -> CurveTable:
        """Return the curve without a column, with the slips of all."""
        kept = {name: values for name, values in self.columns.items() if name != column}
        return CurveTable(kept, self.slips)

    def document(self) -> dict[str, Any]:
        """Return the columns as a study may state them."""
        document: dict[str, Any] = {}
        for name, values in self.columns.items():
            if name in ("angle", "bend"):
                document[name] = [f"{value!r} rad" for value in values]
            else:
                document[name] = list(values)
        return document

    def spline(self, column: str, noise: float = 0.0) -> Spline:
        """Return a column as a cubic spline, through its values (not-a-knot) or smoothed.

        Args:
            column: Name of the column.
            noise: Standard deviation of its values, by which it is smoothed; 0 for no smoothing.
        """
        from scipy import interpolate  # only curves pay for its import

        angles = self.angles
        values = np.array(self.columns[column])
        if len(angles) == 2:
            slope = (values[1] - values[0]) / (angles[1] - angles[0])
            return Spline(angles, np.array([[0.0], [0.0], [slope], [values[0]]]))
        if noise > 0.0 and len(angles) > 3:
            fitted = interpolate.splrep(angles, values, k=3, s=len(angles) * noise**2)
            smooth = interpolate.PPoly.from_spline(fitted)
            pieces = np.flatnonzero(np.diff(smooth.x) > 0.0)
            return Spline(np.append(smooth.x[pieces], smooth.x[-1]), smooth.c[:, pieces])
        cubic = interpolate.CubicSpline(angles, values)
        return Spline(cubic.x, _without_rounding(cubic.c, angles, values))


@dataclass(frozen=True)
class CurveColumns:
    """Columns of a curve over angles or times."""

    columns: tuple[str, ...]
    """Names of the columns, the angle or time first."""
    fewest: int = 3
    """Smallest number of rows of a curve; two are a line."""
    optional: tuple[str, ...] = ()
    """Names of those columns that a curve may lack."""
    meaning: str = ""
    """Sign of the values in words, for errors."""
    is_sampled: bool = False
    """True for a motion that is measured sample by sample, whose usual step is plausible."""

    @property
    def first(self) -> str:
        """Name of the column over which the others are given."""
        return self.columns[0]

    @property
    def names(self) -> list[str]:
        """Names of the columns that every curve has, the angle or time first."""
        return [name for name in self.columns if name not in self.optional]

    @property
    def phrase(self) -> str:
        """Names of the columns in words."""
        more = "".join(f" and, if there is one, {name}" for name in self.optional)
        return f"{', '.join(self.names)}{more}"

    def are_in(self, names: Collection[object]) -> bool:
        """Return True if a table with these names, and no others, is such a curve."""
        return set(names) - set(self.optional) == set(self.names)

    def spellings(self, name: str) -> tuple[str, ...]:
        """Return the names that a column may have in a file, its own first."""
        return _OPTIONAL_SPELLINGS[name] if name in self.optional else _COLUMNS[name].spellings

    def of_lists(self, value: Mapping[str, object]) -> CurveTable:
        """Return the curve of a table of lists.

        Raises:
            PydanticCustomError: The lists are no curve.
        """
        columns: dict[str, tuple[float, ...]] = {}
        slips: tuple[Slip, ...] = ()
        for name in self.columns:
            if name not in value:
                continue
            listed = value[name]
            if not isinstance(listed, (list, tuple)) or len(listed) > MOST_ROWS:
                raise fault(f"{name}: {described(listed)} is not a list of values")
            single = SingleField(_COLUMNS[name].quantity, 0, 0)
            measures = [single.measure(item) for item in listed]
            columns[name] = tuple(measure.si for measure in measures)
            if name != "time":
                places = [f"{name} {row + 1}" for row in range(len(listed))]
                slips += single.slips(*zip(places, listed, measures, strict=True))
        if len({len(values) for values in columns.values()}) > 1:
            raise fault(
                f"its lists have different lengths, expected one value of each for every "
                f"{self.first}"
            )
        wrong = disorder(np.array([*columns.values()]), self.fewest, self.first)
        if wrong:
            raise fault(wrong[0][0])
        if self.is_sampled:
            slips += step_slips(np.array(columns["time"]), "s", "")
        return _ascending(columns, slips)

    def json_table(self) -> dict[str, Any]:
        """Return the JSON schema of a table with these columns."""
        values = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": self.fewest}
        return schema_table(dict.fromkeys(self.columns, values), len(self.names))


@dataclass(frozen=True)
class CurveField(FieldMark):
    """Mark of a field that is a curve: the name of a CSV, or a table of lists."""

    kinds: tuple[CurveColumns, ...]
    """Columns of each kind of curve that the field takes."""

    def read(self, value: object) -> str | CurveTable | None:
        """Return the name of a file as it is, and lists of values as a table.

        Raises:
            PydanticCustomError: The value is neither, or its lists are no curve.
        """
        if value is None or isinstance(value, CurveTable):
            return value
        if isinstance(value, str) and 0 < len(value) <= _LONGEST_NAME:
            return value
        for kind in self.kinds:
            if isinstance(value, dict) and kind.are_in(value):
                return kind.of_lists(value)
        raise fault(
            f"{described(value)} is not a curve, expected the name of a CSV file, or lists of "
            f"{_any_of(self.kinds)}"
        )

    def __get_pydantic_json_schema__(
        self, core: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        tables = [kind.json_table() for kind in self.kinds]
        return {"anyOf": [{"type": "string", "minLength": 1}, *tables]}


def _any_of(kinds: Sequence[CurveColumns]) -> str:
    """Name the columns of several kinds of curves, and the sign of their values."""
    phrases = ", or ".join(kind.phrase for kind in kinds)
    meanings = [kind.meaning for kind in kinds if kind.meaning]
    return "; ".join(dict.fromkeys([phrases, *meanings]))


SIGN_OF_TASK = "positive torque is what the flexor must give"
"""Sign of the torque of a task in words."""
TORQUE = CurveColumns(("angle", "torque"), fewest=2, meaning="positive torque resists flexion")
TASK_OVER_ANGLE = CurveColumns(("angle", "torque"), fewest=2, meaning=SIGN_OF_TASK)
TASK_OVER_TIME = CurveColumns(("time", "torque"), fewest=2, meaning=SIGN_OF_TASK)
EXCURSION = CurveColumns(("angle", "flexor", "extensor"), meaning="both rise with flexion")
BEND = CurveColumns(("angle", "bend"), fewest=2)
TRAJECTORY = CurveColumns(
    ("time", "angle", "torque"),
    fewest=12,
    optional=("torque",),
    meaning=SIGN_OF_TASK,
    is_sampled=True,
)


@dataclass(frozen=True)
class BendField(NumberField):
    """Mark of a bend angle, which may vary with the joint: `{ angle = [...], bend = [...] }`."""

    def read(self, value: object) -> Any:
        """Return a number, or a curve. Raises PydanticCustomError if the value is neither."""
        if isinstance(value, CurveTable):
            return value
        if isinstance(value, dict) and "bend" in value:
            return CurveField((BEND,)).read(value)
        return super().read(value)

    def _json_choices(self) -> list[dict[str, Any]]:
        return [*super()._json_choices(), BEND.json_table()]


def disorder(columns: Array, fewest: int, first: str) -> list[tuple[str, int]]:
    """Return the problems with the columns of a curve, each with its row.

    Args:
        columns: Angles or times, and values over these, (columns, rows).
        fewest: Smallest number of rows.
        first: Name of the first column.
    """
    count = columns.shape[1]
    if count < fewest:
        return [(f"{counted(count, 'row')}, expected {fewest} at least", count)]
    if count > MOST_ROWS:
        return [(f"{count:,} rows, expected {MOST_ROWS:,} at most", count)]
    not_finite = np.flatnonzero(~np.isfinite(columns).all(axis=0))
    if not_finite.size:
        return [("a value that is not a finite number", row) for row in not_finite.tolist()]
    return _unordered(columns[0], first)


def _unordered(positions: Array, first: str) -> list[tuple[str, int]]:
    """Return the problems with the order of angles or times, each with its row.

    Args:
        positions: Angles or times, (rows,).
        first: Name of their column.
    """
    back = first_back(positions) if first == "time" else None
    if back is not None and "again" in back[1]:
        return [(back[1], back[0])]
    order = np.argsort(positions, kind="stable")
    same = np.flatnonzero(np.diff(positions[order]) == 0.0)
    problem = f"the same {first} twice, expected each once"
    problems = [(problem, row) for row in np.sort(order[same + 1]).tolist()]
    directions = np.sign(np.diff(positions))
    moved = directions[directions != 0.0]
    if not moved.size:
        return problems
    expected = moved[0] if first == "angle" else 1.0  # angles may fall, times may not
    is_back = directions == -expected
    begins = is_back & ~np.append(False, is_back[:-1])
    problem = f"{first}s that go back and forth, expected them to rise"
    return [*problems, *((problem, row) for row in (np.flatnonzero(begins) + 1).tolist())]


def _ascending(columns: Mapping[str, Sequence[float]], slips: tuple[Slip, ...] = ()) -> CurveTable:
    """Return columns in the order of rising angles, or times."""
    first = next(iter(columns.values()))
    step = 1 if first[0] < first[-1] else -1
    return CurveTable({name: tuple(values[::step]) for name, values in columns.items()}, slips)


def read_curve(
    content: bytes, where: str, *kinds: CurveColumns, accepts_slips: bool = True
) -> tuple[CurveTable, list[str]]:
    """Return a curve from the content of a file, with notes on how it was read.

    Args:
        content: The file.
        where: Name of the file in errors.
        kinds: Columns that it may have; the first kind counts over whose angle or time it is.
        accepts_slips: False to list values far from any arm among the faults of a file that has
            others.

    Raises:
        InputError: The content is not such a curve; the error names the lines of all faults.
    """

    def known(columns: Sequence[Heading]) -> list[Heading]:
        """Return the columns of a line that names an angle or a time."""
        spellings = [kind.spellings(name) for kind in kinds for name in kind.columns]
        found = [columns_named(columns, names) for names in spellings]
        found += [_joint_angles(columns)]
        has_first = any(columns_named(columns, kind.spellings(kind.first)) for kind in kinds)
        return [column for few in found for column in few] if has_first else []

    noun = kinds[0].first if len(kinds) == 1 else "row"
    table = read_table(content, known, source=where, noun=noun, most_rows=MOST_ROWS)
    fitting = [kind for kind in kinds if table.named(*kind.spellings(kind.first))]
    if len(kinds) > 1 and not fitting:
        names = " or ".join(kind.first for kind in kinds)
        table.need(names, hint=f"expected the columns {_any_of(kinds)}")
        table.raise_faults()
    kind = fitting[0] if fitting else kinds[0]
    places = [table.place(row=row) for row in range(len(table))]
    columns = {
        name: np.full(len(table), np.nan)
        for name in kind.columns
        if name not in kind.optional or table.named(*kind.spellings(name))
    }
    slips: tuple[Slip, ...] = ()
    read = []
    time_unit = ""
    for name in columns:
        dimension = _COLUMNS[name].dimension
        example = f"such as {name} ({known_units(dimension)[0]})"
        hint = "; ".join(filter(None, (example, kind.meaning)))
        joint_angles = _joint_angles(table.columns)
        if name == "angle" and not table.named(*kind.spellings(name)) and len(joint_angles) == 1:
            column: Heading | None = joint_angles[0]
            table.notes.append(f"{where}: the angle is {joint_angles[0].shown}")
        else:
            column = table.need(*kind.spellings(name), hint=hint)
        if column is None:
            continue
        read.append(column)
        if dimension == "time":
            times, unit = table.times(column)
            time_unit = unit or table.unit_of(column, dimension)
            columns[name] = times * factor_of(time_unit)
            continue
        values, unit = table.quantity(column, dimension)
        if dimension == "angle" and kind.is_sampled:
            values = table.unwrapped(column, values, 2.0 * math.pi)
        if unit:
            slips += column_slips(_COLUMNS[name].quantity, values, unit, name, places)
        columns[name] = values
    _collect_disorder(table, np.array([*columns.values()]), kind)
    raise_with_slips(table, () if accepts_slips else slips)
    if kind.is_sampled:
        slips += step_slips(columns["time"], time_unit, where)
    listed = {name: values.tolist() for name, values in columns.items()}
    return _ascending(listed, slips), [*table.unread(read), *table.notes]


def _joint_angles(columns: Sequence[Heading]) -> list[Heading]:
    """Return the columns of angles that name the elbow, such as OpenSim's "elbow_flexion_r"."""
    return [one for one in columns if one.dimension == "angle" and "elbow" in one.words]


def _collect_disorder(table: Table, columns: Array, kind: CurveColumns) -> None:
    """Add the problems with the rows of a curve to the faults of its table.

    In a table that has faults already, the order of those rows is looked at whose angle or time
    could be read.
    """
    if table.faults:
        rows = np.flatnonzero(np.isfinite(columns[0]))
        problems = _unordered(columns[0][rows], kind.first)
        problems = [(problem, int(rows[row])) for problem, row in problems]
    else:
        problems = disorder(columns, kind.fewest, kind.first)
    names = ", ".join(kind.names)
    hint = f"a row of {names} for each {kind.first}, in order"
    for problem, row in problems:
        table.refuse(problem, hint, row=min(row, len(table) - 1))


def _without_rounding(pieces: Array, angles: Array, values: Array) -> Array:
    """Return the coefficients of cubic pieces, those that errors of rounding alone make set to 0.

    Points on a straight line then make a straight line: a moment arm that does not change has no
    slope, however small, by which a large pretension could move the joint.

    Args:
        pieces: Coefficients, (4, pieces), that of the cube first.
        angles: Angles between which the pieces lie, (pieces + 1,), rad.
        values: Values at these angles.
    """
    steps = np.diff(angles)
    shares = np.array([steps**3, steps**2])
    bends = np.abs(pieces[:2]) * shares
    is_rounding = (bends <= _STRAIGHT * np.abs(values).max()).all()
    return np.vstack([np.zeros_like(pieces[:2]), pieces[2:]]) if is_rounding else pieces
