"""The product of named axes, and what every number is for its designs, in a box of it or at listed points alike.

A design is a row of the product, the last axis fastest. What a number is: the study's single value, over it what an
axis sets (a later axis over an earlier one: a case, a number that varies, a person or a draw), what is given for one
side over what is given for both, and at last multiplied by what axes scale it by, such as the anchors of a larger arm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model.design import READINGS, Design, Limb, Posture, Side
from tendon_cli.model.kinematics import Anchors, Array, Excursion, Flag
from tendon_cli.model.limits import GIVEN
from tendon_cli.model.setting import set_by
from tendon_cli.space.axis import (
    AFTER,
    CASE_AXIS,
    DRAW_AXIS,
    PERSON_AXIS,
    PRETENSION,
    READ,
    REFERENCE,
    SIDES,
    SLACK,
    SPRING_AT,
    Axis,
    Box,
    Numbers,
    Role,
    Rows,
    Varying,
    of_side,
    scale_of,
    split_side,
)

Place = tuple[str, str | None]
"""The common key of a number, and the side of the arm if it is that of one."""


@dataclass(frozen=True, eq=False)
class Space:
    """Every combination of some axes, and the single numbers that all of them share."""

    axes: tuple[Axis, ...] = ()
    """Slowest first."""
    single: Mapping[str, Any] = field(default_factory=dict)
    """By dotted key, SI; those that a study gives once for all."""
    groups: Rows | None = None
    """Which rows must be served together to count, numbered from 0 and ascending; None where each counts by itself."""
    weighting: Array | None = None
    """Of each row; None where all count the same."""

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis."""
        return tuple(len(axis) for axis in self.axes)

    def __len__(self) -> int:
        return math.prod(self.shape)

    @property
    def whole(self) -> Box:
        """The box of all rows."""
        return tuple(slice(0, length) for length in self.shape)

    def _of_role(self, role: Role) -> Space:
        return Space(tuple(axis for axis in self.axes if axis.role == role), self.single)

    @cached_property
    def choices(self) -> Space:
        """The product of what a designer decides."""
        return self._of_role("choice")

    @cached_property
    def conditions(self) -> Space:
        """The product of what a design must survive, grouped by what a share is of."""
        return self._of_role("condition").grouped()

    @property
    def intervals(self) -> tuple[int, ...]:
        """The axes of intervals, by their places: a number that depends on one lies between the values along it."""
        return tuple(at for at, axis in enumerate(self.axes) if axis.is_interval)

    def grouped(self) -> Space:
        """The same product with what a share is of slowest: persons, draws, or the pairs of both.

        One of these is served by a pretension that all its other conditions allow, and counts as much as the person
        is weighted.
        """
        whose = tuple(
            axis for key in (PERSON_AXIS, DRAW_AXIS) for axis in self.axes if axis.key == key
        )
        if not whose:
            return self
        others = tuple(axis for axis in self.axes if axis not in whose)
        each, weighting = math.prod(len(axis) for axis in others), np.ones(1)
        for axis in whose:
            along = np.ones(len(axis)) if axis.weighting is None else axis.weighting
            weighting = np.multiply.outer(weighting, along).ravel()
        groups = np.repeat(np.arange(len(weighting)), each)
        return replace(
            self, axes=(*whose, *others), weighting=np.repeat(weighting, each), groups=groups
        )

    def at(self, *points: Numbers) -> Space:
        """Listed points, by what each says of the study's numbers, with the same single numbers; a product if several.

        What later ones say counts over what earlier ones do.
        """
        return Space(tuple(map(Axis.of_points, points)), self.single)

    def unset(self) -> Space:
        """The same product without pretension, which is solved for, and with tendons that cannot push."""
        axes = tuple(
            axis.without(PRETENSION, SLACK) for axis in self.axes if axis.role != "pretension"
        )
        single = {
            key: value for key, value in self.single.items() if split_side(key)[0] != PRETENSION
        }
        return Space(axes, {**single, PRETENSION: 0.0, SLACK: 1.0})

    def places(self, rows: Rows) -> dict[str, Rows]:
        """Where rows stand on each axis, by its key."""
        if not self.axes:
            return {}
        at = np.unravel_index(rows, self.shape)
        return {axis.key: np.asarray(place) for axis, place in zip(self.axes, at, strict=True)}

    def numbers(self, rows: Rows) -> Numbers:
        """What rows say of the study's numbers."""
        at = self.places(rows)
        return {
            key: values[at[axis.key]] for axis in self.axes for key, values in axis.numbers.items()
        }

    def columns(self, rows: Rows) -> dict[str, npt.NDArray[Any]]:
        """Rows as a table has them: values, or the position among their names."""
        at = self.places(rows)
        return {
            axis.column: at[axis.key] if axis.names else axis.values[at[axis.key]]
            for axis in self.axes
        }

    @cached_property
    def of_sides(self) -> frozenset[str]:
        """Common keys, such as `tendon.length`, that are given for a single side anywhere."""
        given = (*self.single, *self._of_axes)
        return frozenset(common for common, side in map(split_side, given) if side)

    def number(self, key: str, side: str | None = None) -> Varying:
        """A number by its common key; with `side`, as it is on that side of the arm."""
        value, sets = _DEFAULTS.get(key, np.nan), list[tuple[int, Array]]()
        for candidate in (key, of_side(key, side)) if side else (key,):
            if candidate in self.single:
                value, sets = self.single[candidate], []
            for at, values in self._of_axes.get(candidate, ()):
                silent, given = np.isnan(values), values
                if not silent.any():
                    sets = []
                elif not sets:
                    given = np.where(silent, value, values)
                if self.axes[at].key == CASE_AXIS and not sets and (given == given[:1]).all():
                    value = given[0].item()
                else:
                    sets.append((at, given))
        return Varying(value, tuple(sets), tuple(self._of_axes.get(scale_of(key), ())))

    @cached_property
    def _of_axes(self) -> dict[str, list[tuple[int, Array]]]:
        """What axes set and scale, by key, each with the place of its axis."""
        given: dict[str, list[tuple[int, Array]]] = {}
        for at, axis in enumerate(self.axes):
            for key, values in axis.numbers.items():
                given.setdefault(key, []).append((at, values))
        return given

    @cached_property
    def of_the_model(self) -> dict[Place, Varying]:
        """Every number that the model takes, once."""
        return {place: self.number(*place) for place in _PLACES}

    def axes_of(self, wanted: Callable[[str], bool]) -> frozenset[int]:
        """The axes that the numbers of the model whose keys are wanted depend on."""
        return frozenset(
            at
            for (key, _), number in self.of_the_model.items()
            if wanted(key)
            for at in number.axes
        )

    def design(self, box: Box | None = None) -> Design:
        """The designs of a box, else of the whole product, each number shaped as it varies to (*box, 1, 1)."""
        place = self.whole if box is None else box
        given: dict[Place, Any] = {
            where: number.within(place) for where, number in self.of_the_model.items()
        }

        def of(names: Mapping[str, str], side: str | None = None) -> dict[str, Any]:
            return {name: given[key, side] for name, key in names.items()}

        def is_so(key: str, side: str | None = None) -> Flag:
            return np.asarray(given[key, side]) > 0.5

        flexor, extensor = (
            Side(**of(_OF_A_SIDE, side), spring_at_motor=is_so(SPRING_AT, side)) for side in SIDES
        )
        travels = of(_TRAVELS)
        if travels["flexor"] is None or travels["extensor"] is None:
            joint: Anchors | Excursion = Anchors(**of(_ANCHORS), from_initial=is_so(REFERENCE))
        else:
            joint = Excursion(
                **travels, origin=given["setting.angle", None], scale=given[EXCURSION, None]
            )
        made = Design(
            arm=Limb(joint, **of(_LIMB), inertia=self.single.get(INERTIA, 0.0)),
            flexor=flexor,
            extensor=extensor,
            **of(_OF_A_DESIGN),
            trajectory=self.single.get(TRAJECTORY),
            unilateral=is_so(SLACK),
            given={key: given[key, side] for key, side in _GIVEN},
            setting=Posture(**of(_SETTING), after_flexion=is_so(AFTER)),
            read=READINGS[int(self.single.get(READ, 0.0))],
        )
        return set_by(made)


TRAJECTORY, INERTIA = "motion.trajectory", "motion.inertia"
EXCURSION = "joint.excursion"
"""Measured travels, times which those of a body are."""
ANCHORS = ("a1", "b1", "a2", "b2", "elbow_radius")
_WEIGHTS = (
    "forearm_mass",
    "forearm_com",
    "load_distance",
    "upper_arm_angle",
    "contact_width",
    "contact_radius",
)

# The names in the model and the common keys: of a joint, of the arm, of a design, of its setting, and of a side.
_ANCHORS = {name: f"arm.{name}" for name in ANCHORS}
_TRAVELS = {side: f"joint.{side}_excursion" for side in SIDES}
_LIMB = {name: f"arm.{name}" for name in _WEIGHTS} | {
    name: f"joint.{name}" for name in ("stiffness", "rest_angle", "torque")
}
_OF_A_DESIGN = {
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
}
_OF_A_SIDE = {
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
"""What a number is that nothing gives; others are not a number then."""
_WITH_SIDES = ("sheath", "tendon", "spring", "anchor")
_GIVEN: tuple[Place, ...] = tuple(
    (key, SIDES[0] if key.startswith(_WITH_SIDES) else None) for key in GIVEN
)
"""What a limit alone needs; of what the sides may differ in, the flexor's."""
_PLACES: tuple[Place, ...] = (
    *(
        (key, None)
        for names in (_ANCHORS, _TRAVELS, _LIMB, _OF_A_DESIGN, _SETTING)
        for key in names.values()
    ),
    *((key, None) for key in (REFERENCE, SLACK, AFTER, EXCURSION)),
    *((key, side) for key in (*_OF_A_SIDE.values(), SPRING_AT) for side in SIDES),
    *_GIVEN,
)
