"""A choice of an answer as CSV files: a table for a controller, and a list of its numbers."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from tendon_cli import say
from tendon_cli.exports.chosen import ChosenSuit, scalar
from tendon_cli.files import write_csv_rows
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Spline
from tendon_cli.quantities import AS_READ, QUANTITIES, SIDES, in_unit_of_reading
from tendon_cli.studies.contents import column_of, keys
from tendon_cli.studies.space.axis import PRETENSION, NamedAxis
from tendon_cli.studies.study import Study
from tendon_cli.units import shorten
from tendon_cli.verbs.answer_record import value_of
from tendon_cli.version import __version__

CONTROLLER_MARK = "direction (1 flexion; -1 extension),"
"""Beginning of a table for a controller."""
PARAMETERS_MARK = "name,value,unit,source\ntendon.version,"
"""Beginning of a list of numbers."""


# --- For a controller -----------------------------------------------------------------------------


def controller_csv(suit: ChosenSuit) -> str:
    """Return motor torque and spool angle over the elbow angle, by direction and condition.

    Rows without equilibrium are left out; a spool angle that is not determined is empty.
    """
    conditions = suit.conditions
    rows = np.arange(len(conditions))
    design = suit.design(conditions.numbers(rows))
    axes = [axis for axis in conditions.axes if axis.column != "load_mass"]
    names = [axis.column for axis in axes]
    places = conditions.places(rows)
    angles = suit.question.study.angles[np.newaxis]
    flexion = suit.question.flexion
    state = State.of(design, angles, flexion)
    shape = (1, len(conditions), *np.broadcast_shapes(angles.shape, flexion.shape))
    torque = np.broadcast_to(state.motor_torque, shape)[0]  # (conditions, directions, angles)
    spool = np.broadcast_to(state.spool_angle, shape)[0]
    load = np.broadcast_to(np.asarray(design.load_mass), (1, len(conditions), 1, 1)).ravel()
    is_flexion = np.broadcast_to(flexion, shape[2:])
    file = io.StringIO()
    written: list[Sequence[str | int]] = [[*_controller_heads(design, names)]]
    for direction in range(shape[2]):
        for condition in rows.tolist():
            others = [
                axis.names[places[axis.key][condition]]
                if axis.names
                else repr(float(axis.values[places[axis.key][condition]]))
                for axis in axes
            ]
            for place in range(shape[3]):
                if math.isnan(torque[condition, direction, place]):
                    continue
                written.append(
                    [
                        1 if is_flexion[direction, place] else -1,
                        repr(float(load[condition])),
                        *others,
                        repr(float(np.broadcast_to(angles, shape[2:])[direction, place])),
                        repr(float(torque[condition, direction, place])),
                        _cell(float(spool[condition, direction, place])),
                    ]
                )
    write_csv_rows(file, written)
    return file.getvalue()


def _controller_heads(design: Design, names: Sequence[str]) -> Iterator[str]:
    """Yield the heads of the columns, with units and with how friction is taken."""
    yield CONTROLLER_MARK.removesuffix(",")
    yield "load_mass (kg)"
    for name in names:
        quantity = QUANTITIES.get(name) or _quantity_of_column(name)
        unit = "" if quantity is None or quantity.unit == "1" else f" ({quantity.unit})"
        yield f"{name}{unit}"
    yield "elbow_angle (rad)"
    yield f"motor_torque (N m; {_friction_note(design)})"
    yield "spool_angle (rad; 0 where both tendons have their pretension; winds the flexor)"


def _quantity_of_column(column: str) -> Any:
    """Return the quantity of a column of an axis; None for names."""
    for path, key in keys().items():
        if column_of(path) == column:
            return key.number.quantity
    return None


def _friction_note(design: Design) -> str:
    """Say how friction is taken, for the head of the torque."""
    parts = []
    for name, side in zip(SIDES, (design.flexor, design.extensor), strict=True):
        bend = "a bend that follows the joint"
        if not isinstance(side.bend_angle, Spline):
            bend = f"{say.number(math.degrees(scalar(side.bend_angle)), 5)} deg"
        parts.append(f"{name} mu {say.number(scalar(side.friction), 5)} over {bend}")
    return f"capstan friction of sliding in this direction: {' and '.join(parts)}"


def _cell(value: float) -> str:
    """Return a number that reads back exactly; empty if there is none."""
    return "" if math.isnan(value) else repr(value)


# --- A list of numbers ----------------------------------------------------------------------------


class ListedNumber(NamedTuple):
    """A number of the suit."""

    name: str
    value: str
    unit: str
    source: str


def parameters_csv(suit: ChosenSuit) -> str:
    """Return every number of the suit with its unit and its source."""
    file = io.StringIO()
    write_csv_rows(file, [ListedNumber._fields, *_listed(suit)])
    return file.getvalue()


def _listed(suit: ChosenSuit) -> Iterator[ListedNumber]:
    """Yield the numbers of the study, then those that follow from them."""
    record = suit.record
    yield ListedNumber("tendon.version", __version__, "", "tendon")
    yield ListedNumber("study.name", record.name, "", "study")
    yield ListedNumber("study.hash", record.study_hash, "", "SHA-256 of the resolved study")
    yield from _parts(suit)
    yield from _of_study(suit)
    yield from _worked_out(suit)
    yield from _of_answer(suit)


def _parts(suit: ChosenSuit) -> Iterator[ListedNumber]:
    """Yield the row of each table of choices, with what it carries, and the sums over tables."""
    for axis in suit.question.choices.axes:
        if not isinstance(axis, NamedAxis):
            continue
        name = str(value_of(suit.choice, axis.column))
        row = axis.place(name)
        source = f"row of the table {axis.key}"
        yield ListedNumber(axis.key, name, "", source)
        for column in axis.carried:
            if column.text(row):
                value = column.text(row) if column.words else repr(float(column.values[row]))
                yield ListedNumber(f"{axis.key}.{column.name}", value, column.unit, source)
    for name, carried in suit.record.question.carried.items():
        total = value_of(suit.choice, name)
        if total is not None and len(carried.tables) > 1:
            source = f"sum over the tables {', '.join(carried.tables)}"
            yield ListedNumber(name, repr(float(total)), carried.unit, source)


def _of_study(suit: ChosenSuit) -> Iterator[ListedNumber]:
    """Yield the numbers of the design, by the key of each in a study, with its side."""
    space = suit.space
    for (key, side), number in space.model_numbers.items():
        table, _, name = key.partition(".")
        path = key if side is None else f"{table}.{side}.{name}"
        if key not in keys() or key == PRETENSION:
            continue  # a switch of the model, or what is solved for
        value = number.within(space.whole)
        if isinstance(value, Spline):
            continue
        single = scalar(value)
        if math.isnan(single):
            continue
        quantity = keys()[key].number.quantity
        text = "rigid" if math.isinf(single) else repr(single)
        unit = "" if quantity.unit == "1" or math.isinf(single) else quantity.unit
        yield ListedNumber(path, text, unit, _source(suit, key, path))


def _source(suit: ChosenSuit, key: str, path: str) -> str:
    """Say where a number comes from: the choice, a condition, a file, a person, or the study."""
    question = suit.question
    study = question.study
    for known in (path, key):
        if known in suit.points.numbers:
            return "choice"
        files = [
            source["file"]
            for name, source in study.sources.items()
            if name in _FILES_OF.get(known, ())
        ]
        if files:
            return f"file {shorten(files[0])}"
        if known in study.uncertain:
            return "study, middle of an uncertain number"
    for axis in question.conditions.axes:
        if key in axis.numbers or path in axis.numbers:
            if axis.role == "draw":
                return "mean man of the people" if key in study.body_numbers else "study, mean"
            return f"condition, where the suit is set (least of {len(axis)})"
    if key in study.body_numbers:
        return "mean man of the people"
    default = Study().numbers.get(key)
    stated = study.numbers.get(path) or study.numbers.get(key)
    is_default = (
        default is not None and stated is not None and np.array_equal(default.array, stated.array)
    )
    return "study, as by default" if is_default or stated is None else "study"


_FILES_OF = {
    "sheath.bend_angle": ("sheath.path",),
    "sheath.flexor.bend_angle": ("sheath.flexor.path",),
    "sheath.extensor.bend_angle": ("sheath.extensor.path",),
    "sheath.friction": ("sheath.friction_from",),
    "sheath.flexor.friction": ("sheath.flexor.friction_from",),
    "sheath.extensor.friction": ("sheath.extensor.friction_from",),
}
"""Keys that name the file of a number, by the key of the number."""


def _worked_out(suit: ChosenSuit) -> Iterator[ListedNumber]:
    """Yield numbers of the parts that follow from those of the study."""
    design = suit.design()
    sides = zip(SIDES, (design.flexor, design.extensor), strict=True)
    flexor_radius = scalar(design.flexor_radius)
    radii = (flexor_radius, scalar(design.ratio) * flexor_radius)
    for (name, side), radius in zip(sides, radii, strict=True):
        area = math.pi * scalar(side.diameter) ** 2 / 4.0
        stiffness = area * scalar(side.youngs_modulus) / scalar(side.length)
        yield _number(f"{name}_spool_radius", radius, "m", "spool.flexor_radius, spool.ratio")
        yield _number(f"{name}_tendon_stiffness", stiffness, "N/m", "A E / L")
        if not isinstance(side.bend_angle, Spline):
            factor = math.exp(scalar(side.friction) * scalar(side.bend_angle))
            yield _number(f"{name}_capstan_factor", factor, "", "exp(mu phi)")
        f0 = scalar(side.pretension)
        yield _number(
            f"{name}_model_pretension", f0, "N", "F0, the distal tension at zero spool angle"
        )


_FROM_ANSWER = (
    "set_flexor_tension",
    "set_extensor_tension",
    "set_flexor_tension_motor",
    "set_extensor_tension_motor",
    "pretension",
    "pretension_from",
    "pretension_to",
    "tolerance_length",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_contact_pressure",
)
"""Columns of the choice that are listed."""


def _of_answer(suit: ChosenSuit) -> Iterator[ListedNumber]:
    """Yield what the answer says of the choice: what to set, and what its parts must bear."""
    question = suit.record.question
    read = "pretension" if question.shows_own_f0 else question.read
    for name in _FROM_ANSWER:
        value = value_of(suit.choice, name)
        if value is None:
            continue
        quantity = QUANTITIES[name]
        source = f"answer: {quantity.long_name}"
        if name in AS_READ:
            quantity = in_unit_of_reading(quantity, read)
            source += "" if read == "pretension" else f", as read: {read}"
        yield _number(name, float(value), quantity.unit, source)


def _number(name: str, value: float, unit: str, source: str) -> ListedNumber:
    """Return a number of the list."""
    return ListedNumber(name, repr(float(value)), "" if unit == "1" else unit, source)
