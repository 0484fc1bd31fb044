"""From a plan to the model's arguments: each number of the study where it varies, ready to broadcast."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import Situation
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, Limb, Side
from tendon_cli.model.kinematics import Anchors, Real, kinematics
from tendon_cli.model.limits import GIVEN
from tendon_cli.space.plan import Block, Plan
from tendon_cli.studies.checks import PRETENSION, case_numbers
from tendon_cli.studies.study import SIDES, Study, split_side

Flags = npt.NDArray[np.bool_]
Values = npt.NDArray[np.float64]
Place = tuple[str, str | None]
"""The common key of a number, and the side of the arm if it is that of one."""


@dataclass(frozen=True, eq=False)
class Input:
    """A number of the design: its values along the design axes that it depends on, in ascending order of `axes`."""

    values: npt.NDArray[Any]
    axes: tuple[int, ...] = ()

    def combined(self, other: Input, how: Callable[[Values, Values], Values]) -> Input:
        """What comes of the values of both, over the axes of either."""
        axes = tuple(sorted({*self.axes, *other.axes}))
        first, second = (
            np.expand_dims(each.values, tuple(at for at, axis in enumerate(axes) if axis not in each.axes))
            for each in (self, other)
        )
        return Input(how(first, second), axes)

    def within(self, block: Block) -> Real:
        """The values in a block, shaped to broadcast over its designs, directions and angles."""
        if not self.axes:
            value: float | bool = self.values.item()
            return value
        shape = [1] * len(block.shape)
        for axis in self.axes:
            shape[axis] = block.shape[axis]
        return np.asarray(self.values[tuple(block.designs[axis] for axis in self.axes)]).reshape(shape)


@dataclass(frozen=True, eq=False)
class Inputs:
    """Where each number of a plan's designs comes from."""

    plan: Plan

    @cached_property
    def overridden(self) -> frozenset[str]:
        """Common keys, such as `tendon.length`, that the study or one of its cases gives for a single side."""
        linked = [key for axis in self.plan.study.linked for key in axis.numbers]
        given = (*self.plan.study.numbers, *self._of_cases, *linked)
        return frozenset(common for common, side in map(split_side, given) if side)

    @cached_property
    def _of_cases(self) -> dict[str, Input]:
        """The numbers that cases give, NaN in those that do not."""
        cases = [case_numbers(case) for case in self.plan.study.cases]
        given = dict.fromkeys(key for case in cases for key in case)
        return {key: Input(np.array([case.get(key, np.nan) for case in cases]), (0,)) for key in given}

    def source(self, key: str, side: str | None = None) -> Input:
        """A number by its common key; with `side`, as it is on that side of the arm, whose own value goes first."""
        table, _, name = key.rpartition(".")
        source = self._given(key, Input(np.array(np.nan)))  # a study may leave the width of the strap open
        if side:
            source = self._given(f"{table}.{side}.{name}", source)
        for axis in self.plan.study.linked:
            if key in axis.scales:
                source = source.combined(self._along(axis.key, axis.scales[key]), np.multiply)
        return source

    def _given(self, key: str, else_: Input) -> Input:
        """What counts of a key: what persons or draws set, before a case, before the study."""
        study, source = self.plan.study, else_
        for axis in study.linked:
            if key in axis.numbers:
                return self._along(axis.key, axis.numbers[key])
        if key in study.numbers:
            number = study.numbers[key]
            source = self._along(key, number.array) if number.is_axis else Input(np.array(number.single))
        if (own := self._of_cases.get(key)) is not None:
            if np.isnan(own.values).any():
                own = own.combined(source, lambda own, said: np.where(np.isnan(own), said, own))
            same = (own.values == own.values[:1]).all()
            source = Input(own.values[0], own.axes[1:]) if same else own
        return source

    def _along(self, axis: str, values: Values) -> Input:
        return Input(values, (self.plan.study.axes.index(axis),))

    def _chosen(self, key: str, word: str) -> Input:
        """Whether a choice of the model, which cases may differ in, is this word."""
        study, name = self.plan.study, key.rpartition(".")[2]
        models = [getattr(case, "model", None) for case in study.cases] or [None]
        said = np.array([(getattr(each, name, None) or getattr(study.model, name)) == word for each in models])
        return Input(said[0]) if (said == said[0]).all() else Input(said, (0,))

    @cached_property
    def _all(self) -> dict[Place, Input]:
        """Every number the model takes, once, and its choices."""
        choices = {(key, None): self._chosen(key, word) for key, word in _CHOICES.items()}
        return choices | {place: self.source(*place) for place in _PLACES}

    def motion(self, block: Block) -> tuple[Values, Flags]:
        """Elbow angles (1, K) and whether it is flexion (D, 1), shaped to broadcast with `design`."""
        flexion = np.array([direction == "flexion" for direction in self.plan.directions[block.directions]])
        return self.plan.elbow_angles[block.angles].reshape(1, -1), flexion.reshape(-1, 1)

    def situation(self, block: Block) -> Situation:
        """What the states of a block depend on."""
        return Situation.of(self.design(block), *self.motion(block))

    @cached_property
    def only_pretension(self) -> tuple[int, ...]:
        """The design axes that nothing but pretension depends on."""
        taken = {axis for (key, _), source in self._all.items() if key != PRETENSION for axis in source.axes}
        return tuple(axis for axis in range(len(self.plan.shape)) if axis not in taken)

    @cached_property
    def of_the_arm(self) -> tuple[int, ...]:
        """The design axes that the arm's motion depends on, so that there is something to know for each elbow angle."""
        sources = [source for (key, _), source in self._all.items() if key.startswith(("arm.", "model."))]
        return tuple({axis for source in sources for axis in source.axes})

    @property
    def may_be_unilateral(self) -> bool:
        """Whether any design has tendons that cannot push."""
        return bool(np.any(self._all["model.slack", None].values))

    @cached_property
    def always_balanced(self) -> bool:
        """Whether the flexor can balance a load in every state; not looked into, and false, for very many arms."""
        anchors = {name: self._all[f"arm.{name}", None] for name in _ANCHORS}
        axes = {axis for source in anchors.values() for axis in source.axes}
        lengths = [length if axis in axes else 1 for axis, length in enumerate(self.plan.shape)]
        angles = self.plan.elbow_angles
        if math.prod(lengths) * len(angles) > _MOST_LOOKED_INTO:
            return False
        arms = Block(0, tuple(slice(0, length) for length in lengths), slice(0, 1), slice(0, len(angles)))
        motion = kinematics(Anchors(**{name: source.within(arms) for name, source in anchors.items()}), angles)
        return not np.isnan(motion.pulling_arm).any()

    def design(self, block: Block) -> Design:
        """The designs of a block, as the model takes them."""
        given = {place: source.within(block) for place, source in self._all.items()}
        return design_of(lambda key, side: given[key, side])


def design_of(number: Callable[[str, str | None], Any]) -> Design:
    """A design, from what gives each number by its common key, on a side of the arm or (None) for the whole of it."""

    def arm(names: tuple[str, ...]) -> dict[str, Any]:
        return {name: number(f"arm.{name}", None) for name in names}

    flexor, extensor = (Side(**{name: number(key, side) for name, key in _OF_A_SIDE.items()}) for side in SIDES)
    return Design(
        arm=Limb(Anchors(**arm(_ANCHORS)), **arm(_WEIGHTS)),
        flexor=flexor,
        extensor=extensor,
        flexor_radius=number("spool.flexor_radius", None),
        ratio=number("spool.ratio", None),
        load_mass=number("load.mass", None),
        from_initial=number("model.reference", None),
        unilateral=number("model.slack", None),
        given={key: number(key, side) for key, side in _GIVEN},
    )


def bounds_of(study: Study) -> Bounds:
    """The limits of a study, as the model holds states to them."""
    speed = study.motion.speed
    return Bounds(speed=math.nan if speed is None else speed.single, **study.limits)


_MOST_LOOKED_INTO = 2**18
_ANCHORS = ("a1", "b1", "a2", "b2", "elbow_radius")
_WEIGHTS = ("forearm_mass", "forearm_com", "load_distance", "upper_arm_angle", "contact_width")
OF_SHEATHS = {
    "friction": "sheath.friction",
    "bend_angle": "sheath.bend_angle",
    "length": "tendon.length",
    "diameter": "tendon.diameter",
    "youngs_modulus": "tendon.youngs_modulus",
    "spring_stiffness": "spring.stiffness",
}
"""What a side of the arm has besides its pretension: the names in the model and the common keys."""
_OF_A_SIDE = {**OF_SHEATHS, "pretension": PRETENSION}
_GIVEN: tuple[Place, ...] = tuple(
    (key, SIDES[0] if key.partition(".")[0] in ("sheath", "tendon", "spring") else None) for key in GIVEN
)
_CHOICES = {"model.reference": "initial", "model.slack": "unilateral"}
_PLACES: tuple[Place, ...] = (
    *((f"arm.{name}", None) for name in (*_ANCHORS, *_WEIGHTS)),
    *((key, side) for side in SIDES for key in _OF_A_SIDE.values()),
    *((key, None) for key in ("spool.flexor_radius", "spool.ratio", "load.mass")),
    *_GIVEN,
)
