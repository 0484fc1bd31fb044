"""From a plan to the model's arguments: each number of the study where it varies, ready to broadcast."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import Arm, Design, Side
from tendon_cli.model.kinematics import Anchors, Real
from tendon_cli.study.checks import case_numbers
from tendon_cli.study.study import SIDES, split_side
from tendon_cli.sweep.plan import Block, Plan

Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Source:
    """A number of the design: its values along the design axes that it depends on, in ascending order of `axes`."""

    values: npt.NDArray[np.float64]
    axes: tuple[int, ...] = ()

    def times(self, other: Source) -> Source:
        """The product of both, over the axes of either."""
        axes = tuple(sorted({*self.axes, *other.axes}))
        factors = [
            np.expand_dims(each.values, tuple(at for at, axis in enumerate(axes) if axis not in each.axes))
            for each in (self, other)
        ]
        return Source(factors[0] * factors[1], axes)

    def within(self, block: Block) -> Real:
        """The values in a block, shaped to broadcast over its designs, directions and angles."""
        return self._apart(block)[..., np.newaxis, np.newaxis] if self.axes else float(self.values)

    def in_tile(self, block: Block, loops: tuple[int, ...]) -> Real:
        """The values in a block as `Tile.of` takes them: scalar, or (1, 1, B) for the designs of a tile.

        Values that vary along an axis in `loops` have the shape (P, 1, 1, B) or (P, 1, 1, 1).
        """
        apart, lengths = self._apart(block), block.shape[:-2]
        if apart.size == 1:
            return float(apart.item())
        rest = [axis for axis in range(len(lengths)) if axis not in loops]
        sides = [_spread(apart.shape, lengths, axes) for axes in (loops, rest)]
        values = np.broadcast_to(apart.transpose(*loops, *rest), [*sides[0], *sides[1]])
        shaped = values.reshape(-1, 1, 1, math.prod(sides[1]))
        return shaped[0] if len(shaped) == 1 else shaped

    def _apart(self, block: Block) -> npt.NDArray[np.float64]:
        """The values in a block with an axis for each of its designs' axes, one long where they do not vary."""
        shape = [1] * len(block.designs)
        for axis in self.axes:
            shape[axis] = block.designs[axis].stop - block.designs[axis].start
        return np.asarray(self.values[tuple(block.designs[axis] for axis in self.axes)]).reshape(shape)


def _spread(apart: Sequence[int], lengths: Sequence[int], axes: Sequence[int]) -> list[int]:
    """The lengths of some axes where values vary along any of these, else ones."""
    varies = any(apart[axis] > 1 for axis in axes)
    return [lengths[axis] if varies else 1 for axis in axes]


@dataclass(frozen=True, eq=False)
class Inputs:
    """Where each number of a plan's designs comes from."""

    plan: Plan

    @cached_property
    def overridden(self) -> frozenset[str]:
        """Common keys, such as `tendon.length`, that the study or one of its cases gives for a single side."""
        linked = [key for axis in self.plan.study.linked for key in axis.numbers]
        given = [*self.plan.study.numbers, *(key for case in self._cases for key in case), *linked]
        return frozenset(common for common, side in map(split_side, given) if side)

    @cached_property
    def _cases(self) -> list[dict[str, float]]:
        return [case_numbers(case) for case in self.plan.study.cases]

    def source(self, key: str, side: str | None = None) -> Source:
        """A number by its common key; with `side`, as it is on that side of the arm."""
        table, _, name = key.rpartition(".")
        candidates = [f"{table}.{side}.{name}", key] if side else [key]
        source = self._linked(candidates)
        if source is None:
            given = [self._given(candidates, case) for case in self._cases or [{}]]
            source = self._one(given[0]) if len(set(given)) == 1 else self._per_case(given)
        for axis in self.plan.study.linked:
            if key in axis.scales:
                source = source.times(Source(axis.scales[key], (self.plan.study.axes.index(axis.key),)))
        return source

    def _linked(self, candidates: list[str]) -> Source | None:
        """A number that persons or draws set, more than what a case, an axis or the study says of the same key."""
        study = self.plan.study
        for key in candidates:
            for axis in study.linked:
                if key in axis.numbers:
                    return Source(axis.numbers[key], (study.axes.index(axis.key),))
            if key in study.numbers or any(key in case for case in self._cases):
                break
        return None

    def _given(self, candidates: list[str], case: dict[str, float]) -> float | str:
        """What counts for a case: a side's own value before the common one, the case's before the study's.

        A number, or the key of the axis that gives it.
        """
        numbers = self.plan.study.numbers
        for key in candidates:
            if key in case:
                return case[key]
            if key in numbers:
                return key if numbers[key].is_axis else numbers[key].single
        raise KeyError(candidates[-1])

    def _one(self, given: float | str) -> Source:
        if isinstance(given, str):
            index = self.plan.study.axes.index(given)
            return Source(self.plan.study.numbers[given].array, (index,))
        return Source(np.array(given))

    def _per_case(self, given: list[float | str]) -> Source:
        """A number that differs between cases; one that is an axis in other cases depends on both."""
        sources = [self._one(each) for each in given]
        along = next((source for source in sources if source.axes), None)
        if along is None:
            return Source(np.array([source.values for source in sources]), (0,))
        rows = [np.broadcast_to(source.values, along.values.shape) for source in sources]
        return Source(np.array(rows), (0, *along.axes))

    def flag(self, read: Callable[[str, str], bool]) -> Source | bool:
        """A choice of the model, which cases may differ in."""
        model = self.plan.study.model
        base = read(model.slack, model.reference)
        chosen = []
        for case in self.plan.study.cases:
            own = getattr(case, "model", None)
            slack = getattr(own, "slack", None) or model.slack
            reference = getattr(own, "reference", None) or model.reference
            chosen.append(read(slack, reference))
        if all(choice == base for choice in chosen):
            return base
        return Source(np.array(chosen), (0,))

    @cached_property
    def _all(self) -> dict[str, Source]:
        """Every number the model takes, once."""
        arm = {f"arm.{name}": self.source(f"arm.{name}") for name in _ARM}
        sides = {f"{side} {key}": self.source(key, side) for side in SIDES for key in _SIDE.values()}
        rest = {key: self.source(key) for key in ("spool.flexor_radius", "spool.ratio", "load.mass")}
        return arm | sides | rest

    @cached_property
    def _unilateral(self) -> Source | bool:
        """Whether tendons cannot push."""
        return self.flag(lambda slack, _: slack == "unilateral")

    @cached_property
    def _from_initial(self) -> Source | bool:
        return self.flag(lambda _, reference: reference == "initial")

    def design(self, block: Block) -> Design:
        """The designs of a block, as the model takes them."""
        return self._design(lambda source: source.within(block))

    def motion(self, block: Block) -> tuple[npt.NDArray[np.float64], Flags]:
        """Elbow angles (1, K) and whether it is flexion (D, 1), shaped to broadcast with `design`."""
        flexion = np.array([direction == "flexion" for direction in self.plan.directions[block.directions]])
        return self.plan.elbow_angles[block.angles].reshape(1, -1), flexion.reshape(-1, 1)

    @cached_property
    def loops(self) -> tuple[int, ...]:
        """The design axes that nothing but pretension depends on; a tile looks at these one by one."""
        sources = [source for key, source in self._all.items() if not key.endswith("tendon.pretension")]
        flags = [flag for flag in (self._from_initial, self._unilateral) if not isinstance(flag, bool)]
        taken = {axis for source in (*sources, *flags) for axis in source.axes}
        return tuple(axis for axis in range(len(self.plan.shape)) if axis not in taken)

    def tile(self, block: Block) -> tuple[Design, npt.NDArray[np.float64], Flags]:
        """The designs, elbow angles and directions of a block as `Tile.of` takes them."""
        angles, flexion = self.motion(block)
        design = self._design(lambda source: source.in_tile(block, self.loops))
        return design, angles.reshape(-1, 1, 1), flexion.reshape(1, -1, 1)

    def arranged(self, block: Block, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Results for a tile, which broadcast to (P, B), on axes that broadcast to those of the block's designs."""
        lengths = block.shape[:-2]
        axes = range(len(lengths))
        order = (*self.loops, *(axis for axis in axes if axis not in self.loops))
        spread = [lengths[axis] if values.shape[axis not in self.loops] > 1 else 1 for axis in order]
        return values.reshape(spread).transpose([order.index(axis) for axis in axes])

    def _design(self, values: Callable[[Source], Real]) -> Design:
        number = {key: values(source) for key, source in self._all.items()}
        if "tendon.pretension" not in self.overridden:
            # One array for both sides: the model sees that they are the same.
            number["extensor tendon.pretension"] = number["flexor tendon.pretension"]

        def side(name: str) -> Side:
            return Side(**{argument: number[f"{name} {key}"] for argument, key in _SIDE.items()})

        def flag(choice: Source | bool) -> bool | Flags:
            return choice if isinstance(choice, bool) else np.asarray(values(choice), dtype=bool)

        anchors = Anchors(**{name: number[f"arm.{name}"] for name in _ANCHORS})
        return Design(
            arm=Arm(anchors, **{name: number[f"arm.{name}"] for name in _ARM if name not in _ANCHORS}),
            flexor=side("flexor"),
            extensor=side("extensor"),
            flexor_radius=number["spool.flexor_radius"],
            ratio=number["spool.ratio"],
            load_mass=number["load.mass"],
            from_initial=flag(self._from_initial),
            unilateral=flag(self._unilateral),
        )


_ANCHORS = ("a1", "b1", "a2", "b2", "elbow_radius")
_ARM = (*_ANCHORS, "forearm_mass", "forearm_com", "load_distance", "upper_arm_angle")
_SIDE = {
    "friction": "sheath.friction",
    "bend_angle": "sheath.bend_angle",
    "length": "tendon.length",
    "diameter": "tendon.diameter",
    "youngs_modulus": "tendon.youngs_modulus",
    "spring_stiffness": "spring.stiffness",
    "pretension": "tendon.pretension",
}
