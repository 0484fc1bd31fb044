"""The product of named axes, and every number of its designs, in a box of it or at listed points.

A design is a row of the product; the last axis varies fastest. A number has the study's single
value unless an axis sets it. A later axis takes precedence over an earlier one (cases, numbers that
vary, persons, draws), and a value for one side over a value for both. Last, the number is
multiplied by the factors that axes give for it, such as for the anchors of a larger arm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model.design import READINGS, Design, Limb, Posture, Side
from tendon_cli.model.kinematics import Anchors, Array, Excursion, Flag, Rows, Spline
from tendon_cli.model.limits import GIVEN
from tendon_cli.model.setting import with_set_pretension
from tendon_cli.quantities import SIDES
from tendon_cli.studies.space.axis import (
    AFTER,
    LIMIT,
    PERSON_AXIS,
    PRETENSION,
    READ,
    READING_ERROR,
    REFERENCE,
    SLACK,
    SPRING_AT,
    Axis,
    Box,
    CarriedColumn,
    NamedAxis,
    Numbers,
    Role,
    Varying,
    along_axis,
    factor_of,
    limit_of,
    of_side,
    scale_of,
    shift_of,
    split_side,
)


@dataclass(frozen=True, eq=False)
class Carried:
    """Column of a table that rows of named axes carry along: one column, or a sum of several."""

    column: str
    """Name of the column of the table."""
    tables: tuple[str, ...]
    """Keys of the axes whose columns are added."""
    parts: tuple[tuple[int, CarriedColumn], ...]
    """Place of each of these axes, and its column."""

    @property
    def first(self) -> CarriedColumn:
        """First of the columns that are added: all have its unit."""
        return self.parts[0][1]

    def within(self, box: Box) -> Array:
        """Return its values in a box, shaped to broadcast over designs, directions and angles.

        The values of words are their places.
        """
        values = [along_axis(place, column.values, box) for place, column in self.parts]
        return np.asarray(sum(values[1:], start=values[0]))

    def at(self, places: Sequence[Rows]) -> Array:
        """Return its values at places on each axis, (rows,) each."""
        values = [column.values[places[place]] for place, column in self.parts]
        return np.asarray(sum(values[1:], start=values[0]))


Place = tuple[str, str | None]
"""Common key of a number, and its side; None if it belongs to no side."""


@dataclass(frozen=True, eq=False)
class Space:
    """A product of axes, and the single numbers that all of its rows share."""

    axes: tuple[Axis, ...] = ()
    """Slowest first."""
    single: Mapping[str, Any] = field(default_factory=dict)
    """Numbers that a study gives once for all, by dotted key, SI."""
    groups: Rows | None = None
    """Group of each row, numbered from 0 and ascending; a group counts if all its rows are served.
    None if each row counts by itself."""
    weighting: Array | None = None
    """Weight of each row; None if all count the same."""

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis."""
        return tuple(len(axis) for axis in self.axes)

    def __len__(self) -> int:
        return math.prod(self.shape)

    @property
    def whole(self) -> Box:
        """Box of all rows."""
        return tuple(slice(0, length) for length in self.shape)

    @cached_property
    def rows_by_value(self) -> Rows:
        """Rows in ascending order of their values, the axes in order of their keys.

        Members of a sample, and listed points, keep their order and come first.
        """
        columns = []
        others = []
        places = self.places(np.arange(len(self)))
        for axis in self.axes:
            if axis.role == "draw" or not axis.key:
                columns.append(places[axis.key])
            else:
                others.append(axis)
        others.sort(key=lambda axis: axis.key)
        columns += [axis.rank[places[axis.key]] for axis in others]
        return np.lexsort(columns[::-1]) if columns else np.zeros(1, dtype=np.int64)

    def _of_roles(self, *roles: Role) -> Space:
        """Return the product of the axes of some roles, with the same single numbers."""
        return Space(tuple(axis for axis in self.axes if axis.role in roles), self.single)

    @cached_property
    def choices(self) -> Space:
        """Product of the axes on which a designer chooses."""
        return self._of_roles("choice")

    @cached_property
    def conditions(self) -> Space:
        """Product of the axes that a design must cope with, grouped by person and draw."""
        return self._of_roles("condition", "draw").grouped()

    @property
    def intervals(self) -> tuple[int, ...]:
        """Places of the axes of intervals.

        A number that depends on one of them lies anywhere between the values along it.
        """
        return tuple(place for place, axis in enumerate(self.axes) if axis.is_interval)

    def grouped(self) -> Space:
        """Return the same product grouped by persons, draws or pairs of both.

        Their axes become the slowest, that of persons first. A pretension serves a group if it
        suits all other conditions of the group, which counts as much in a share as its person and
        its draw are weighted.
        """
        drawn = [axis for axis in self.axes if axis.role == "draw"]
        if not drawn:
            return self
        counted = tuple(sorted(drawn, key=lambda axis: axis.key != PERSON_AXIS))
        others = tuple(axis for axis in self.axes if axis not in counted)
        rows_per_group = math.prod(len(axis) for axis in others)
        weighting = np.ones(1)
        for axis in counted:
            of_axis = np.ones(len(axis)) if axis.weighting is None else axis.weighting
            weighting = np.multiply.outer(weighting, of_axis).ravel()
        return replace(
            self,
            axes=(*counted, *others),
            groups=np.repeat(np.arange(len(weighting)), rows_per_group),
            weighting=np.repeat(weighting, rows_per_group),
        )

    def at(self, *points: Numbers) -> Space:
        """Return the space of listed points, with the same single numbers.

        Args:
            points: Numbers that the points set, (points,) each. Several lists make a product, in
                which a later one takes precedence over an earlier one.
        """
        return Space(tuple(map(Axis.of_points, points)), self.single)

    def without_pretension(self) -> Space:
        """Return the same product without pretension, which is solved for.

        The tendons of its designs cannot push.
        """
        axes = tuple(
            axis.without(PRETENSION, SLACK) for axis in self.axes if axis.role != "pretension"
        )
        single = {
            key: value for key, value in self.single.items() if split_side(key)[0] != PRETENSION
        }
        return Space(axes, {**single, PRETENSION: 0.0, SLACK: 1.0, UNSET: True})

    def places(self, rows: Rows) -> dict[str, Rows]:
        """Return the places of rows on each axis, (rows,), by the key of the axis."""
        if not self.axes:
            return {}
        places = np.unravel_index(rows, self.shape)
        return {axis.key: np.asarray(place) for axis, place in zip(self.axes, places, strict=True)}

    def numbers(self, rows: Rows) -> Numbers:
        """Return the numbers that axes set for rows, and the factors by which they scale some."""
        places = self.places(rows)
        return {
            key: values[places[axis.key]]
            for axis in self.axes
            for key, values in axis.numbers.items()
        }

    def columns(self, rows: Rows) -> dict[str, npt.NDArray[Any]]:
        """Return rows as columns of a table: values, or the places of their names or words.

        They are the columns of the axes, and those that named axes carry along.
        """
        places = self.places(rows)
        columns = {
            axis.column: places[axis.key] if axis.names else axis.values[places[axis.key]]
            for axis in self.axes
        }
        along = [places[axis.key] for axis in self.axes]
        for carried in self.carried:
            columns[carried.column] = carried.at(along)
        return columns

    @cached_property
    def carried(self) -> tuple[Carried, ...]:
        """Columns that named axes carry along: each by itself, then the sums of those of a name.

        A sum counts the springs of both sides.
        """
        columns = []
        sums: dict[str, list[tuple[int, int, CarriedColumn]]] = {}
        for place, axis in enumerate(self.axes):
            if not isinstance(axis, NamedAxis):
                continue
            for column in axis.carried:
                name = f"{axis.key}_{column.name}"
                columns.append(Carried(name, (axis.key,), ((place, column),)))
                sums.setdefault(column.name, []).append((place, axis.pieces, column))
        for name, stated in sums.items():
            with_numbers = [column for _, _, column in stated if column.addends is not None]
            if not with_numbers:
                continue
            parts = []
            for place, pieces, column in stated:
                # A sum over a part whose number is not known is not known.
                addends = column.addends
                if addends is None:
                    addends = np.full(len(column.values), np.nan)
                of_all = CarriedColumn(name, with_numbers[0].unit, pieces * addends)
                parts.append((place, of_all))
            keys = tuple(self.axes[place].key for place, _ in parts)
            columns.append(Carried(name, keys, tuple(parts)))
        return tuple(columns)

    @cached_property
    def keys_of_sides(self) -> frozenset[str]:
        """Common keys, such as `tendon.length`, that are given for a single side anywhere."""
        given = (*self.single, *self._axis_numbers)
        return frozenset(common for common, side in map(split_side, given) if side)

    def number(self, key: str, side: str | None = None) -> Varying:
        """Return a number of the designs, as it varies over the axes.

        Args:
            key: Its common key.
            side: Side of the arm whose number is wanted; None for a number that has no side.
        """
        value = _DEFAULTS.get(key, np.nan)
        sets: list[tuple[int, Array]] = []
        along_axes = self._axis_numbers
        candidates = (key,) if side is None else (key, of_side(key, side))
        for candidate in candidates:
            if candidate in self.single:
                value = self.single[candidate]
                sets = []
            if candidate not in along_axes:
                continue
            for place, values in along_axes[candidate]:
                is_silent = np.isnan(values)
                given = values
                if not is_silent.any():  # overrules all that came before, a curve, too
                    sets = []
                    value = np.nan if isinstance(value, Spline) else value
                elif not sets:
                    given = np.where(is_silent, value, values)
                # A number that is the same in several named rows does not vary over them.
                is_named = isinstance(self.axes[place], NamedAxis) and len(given) > 1
                if is_named and not sets and (given == given[:1]).all():
                    value = given[0].item()
                else:
                    sets.append((place, given))
        scales = [*along_axes.get(scale_of(key), ())]
        shifts: list[tuple[int, Array]] = []
        for candidate in candidates:
            scales += along_axes.get(factor_of(candidate), ())
            shifts += along_axes.get(shift_of(candidate), ())
        if isinstance(value, Spline):
            return Varying(value)
        return Varying(value, tuple(sets), tuple(scales), tuple(shifts), _LEAST.get(key, -np.inf))

    @cached_property
    def _axis_numbers(self) -> dict[str, list[tuple[int, Array]]]:
        """Places of axes, with the values or factors that they give, by key of the number."""
        given: dict[str, list[tuple[int, Array]]] = {}
        for place, axis in enumerate(self.axes):
            for key, values in axis.numbers.items():
                given.setdefault(key, []).append((place, values))
        return given

    @cached_property
    def set_by_names(self) -> dict[str, Varying]:
        """Numbers that vary over a named axis, by the keys under which its rows set them."""
        numbers: dict[str, Varying] = {}
        for place, axis in enumerate(self.axes):
            if not isinstance(axis, NamedAxis):
                continue
            for key in axis.keys:
                number = self.number(*split_side(key))
                if place in number.axes:
                    numbers[key] = number
        return numbers

    @cached_property
    def model_numbers(self) -> dict[Place, Varying]:
        """Numbers that the model takes, by common key and side."""
        of_limits = {(f"{LIMIT}{name}", None): number for name, number in self.limits.items()}
        return {place: self.number(*place) for place in _PLACES} | of_limits

    @cached_property
    def limits(self) -> dict[str, Varying]:
        """Limits that axes set, by name; a number is NaN for designs without that limit."""
        keys = [key for key in self._axis_numbers if limit_of(key) is not None]
        return {key.removeprefix(LIMIT): self.number(key) for key in keys}

    def axes_of(self, wanted: Callable[[str], bool]) -> frozenset[int]:
        """Return the places of the axes that some numbers of the model depend on.

        Args:
            wanted: Returns True for the common key of a number that is meant.
        """
        return frozenset(
            axis
            for (key, _), number in self.model_numbers.items()
            if wanted(key)
            for axis in number.axes
        )

    def design(self, box: Box | None = None) -> Design:
        """Return the designs of a box, or of the whole product if none is given.

        Each number is shaped as it varies, to broadcast to (*box, 1, 1).
        """
        box = self.whole if box is None else box
        given: dict[Place, Any] = {
            place: number.within(box) for place, number in self.model_numbers.items()
        }

        def numbers(keys: Mapping[str, str], side: str | None = None) -> dict[str, Any]:
            return {name: given[key, side] for name, key in keys.items()}

        def is_true(key: str, side: str | None = None) -> Flag:
            return np.asarray(given[key, side]) > 0.5

        flexor, extensor = (
            Side(**numbers(_SIDE, side), spring_at_motor=is_true(SPRING_AT, side)) for side in SIDES
        )
        joint: Anchors | Excursion
        travels = numbers(_TRAVELS)
        if travels["flexor"] is None or travels["extensor"] is None:
            joint = Anchors(**numbers(_ANCHORS), from_initial=is_true(REFERENCE))
        else:
            origin = given["setting.angle", None]
            joint = Excursion(**travels, origin=origin, scale=given[EXCURSION, None])
        design = Design(
            arm=Limb(joint, **numbers(_LIMB), inertia=self.single.get(INERTIA, 0.0)),
            flexor=flexor,
            extensor=extensor,
            **numbers(_DESIGN),
            trajectory=self.single.get(TRAJECTORY),
            unilateral=is_true(SLACK),
            given={key: given[key, side] for key, side in _GIVEN},
            limits={name: given[f"{LIMIT}{name}", None] for name in self.limits},
            setting=Posture(**numbers(_SETTING), after_flexion=is_true(AFTER)),
            read=READINGS[int(self.single.get(READ, 0.0))],
        )
        is_set = UNSET not in self.single or PRETENSION in self._axis_numbers
        return with_set_pretension(design) if is_set else design


UNSET = "pretension is solved for"
"""Key of the mark of a space whose designs have no pretension but what points set."""
TRAJECTORY = "motion.trajectory"
INERTIA = "motion.inertia"
EXCURSION = "joint.excursion"
"""Key of the factor from the measured travels of the tendons to those of a body."""
ANCHORS = ("a1", "b1", "a2", "b2", "elbow_radius")
_WEIGHTS = (
    "forearm_mass",
    "forearm_com",
    "load_distance",
    "upper_arm_angle",
    "contact_width",
    "contact_radius",
    "contact_from",
)

# Common keys of the numbers of a joint (by anchors or by travels), of the limb, of a design, of its
# setting and of a side, by the names that the model has for them.
_ANCHORS = {name: f"arm.{name}" for name in ANCHORS}
_TRAVELS = {side: f"joint.{side}_excursion" for side in SIDES}
_LIMB = {name: f"arm.{name}" for name in _WEIGHTS} | {
    name: f"joint.{name}" for name in ("stiffness", "rest_angle", "torque")
}
_DESIGN = {
    "flexor_radius": "spool.flexor_radius",
    "ratio": "spool.ratio",
    "load_mass": "load.mass",
    "load_torque": "load.torque",
    "load_scale": "load.scale",
}
_SETTING = {
    "angle": "setting.angle",
    "upper_arm_angle": "setting.upper_arm_angle",
    "load_mass": "setting.load",
    "reading_error": READING_ERROR,
}
_SIDE = {
    "friction": "sheath.friction",
    "bend_angle": "sheath.bend_angle",
    "length": "tendon.length",
    "diameter": "tendon.diameter",
    "youngs_modulus": "tendon.youngs_modulus",
    "spring_stiffness": "spring.stiffness",
    "anchor_stiffness": "anchor.stiffness",
    "pretension": PRETENSION,
}
_DEFAULTS: dict[str, Any] = {
    **dict.fromkeys(
        (*_SETTING.values(), "joint.stiffness", "joint.rest_angle", SPRING_AT, AFTER), 0.0
    ),
    **dict.fromkeys((EXCURSION, "load.scale"), 1.0),
    **dict.fromkeys((*_TRAVELS.values(), "load.torque", "joint.torque")),
    "anchor.stiffness": np.inf,
}
"""Values of numbers that a study leaves out; any other number is then NaN."""
_LEAST = {f"arm.{name}": 1e-3 for name in ANCHORS}
"""Smallest values, m, of numbers that deviate by an amount: no anchor lies closer to the elbow."""
_WITH_SIDES = ("sheath", "tendon", "spring", "anchor")
_GIVEN: tuple[Place, ...] = tuple(
    (key, SIDES[0] if key.startswith(_WITH_SIDES) else None) for key in GIVEN
)
"""Numbers that only limits need; the flexor's, if the sides may differ."""
_PLACES: tuple[Place, ...] = (
    *(
        (key, None)
        for keys in (_ANCHORS, _TRAVELS, _LIMB, _DESIGN, _SETTING)
        for key in keys.values()
    ),
    *((key, None) for key in (REFERENCE, SLACK, AFTER, EXCURSION)),
    *((key, side) for key in (*_SIDE.values(), SPRING_AT) for side in SIDES),
    *_GIVEN,
)
