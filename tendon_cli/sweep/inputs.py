"""From a plan to the model's arguments: each number of the study where it varies, ready to broadcast."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import Arm, Design, Side
from tendon_cli.model.kinematics import Anchors, Real
from tendon_cli.study.checks import case_numbers
from tendon_cli.study.study import SIDES, split_side
from tendon_cli.sweep.plan import Block, Plan


@dataclass(frozen=True)
class Source:
    """A number of the design: its values along the design axes that it depends on, in ascending order of `axes`."""

    values: npt.NDArray[np.float64]
    axes: tuple[int, ...] = ()

    def within(self, block: Block, *, states_first: bool = False) -> Real:
        """The values in a block, shaped to broadcast over its designs, directions and angles.

        With `states_first` over directions, angles and designs.
        """
        if not self.axes:
            return float(self.values)
        chosen: npt.NDArray[np.float64] = self.values[tuple(block.designs[axis] for axis in self.axes)]
        shape = [1] * (len(block.designs) + 2)
        for axis, length in zip(self.axes, chosen.shape, strict=True):
            shape[axis] = length
        return chosen.reshape(shape[-2:] + shape[:-2] if states_first else shape)


@dataclass(frozen=True)
class Inputs:
    """Where each number of a plan's designs comes from."""

    plan: Plan

    @cached_property
    def overridden(self) -> frozenset[str]:
        """Common keys, such as `tendon.length`, that the study or one of its cases gives for a single side."""
        given = [*self.plan.study.numbers, *(key for case in self._cases for key in case)]
        return frozenset(common for common, side in map(split_side, given) if side)

    @cached_property
    def _cases(self) -> list[dict[str, float]]:
        return [case_numbers(case) for case in self.plan.study.cases]

    def source(self, key: str, side: str | None = None) -> Source:
        """A number by its common key; with `side`, as it is on that side of the arm."""
        table, _, name = key.rpartition(".")
        candidates = [f"{table}.{side}.{name}", key] if side else [key]
        given = [self._given(candidates, case) for case in self._cases or [{}]]
        if len(set(given)) == 1:
            return self._one(given[0])
        return self._per_case(given)

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

    def design(self, block: Block, *, states_first: bool = False) -> Design:
        """The designs of a block, as the model takes them; with `states_first` their axes come after the states'."""
        number = {key: source.within(block, states_first=states_first) for key, source in self._all.items()}
        if "tendon.pretension" not in self.overridden:
            # One array for both sides: the model sees that they are the same.
            number["extensor tendon.pretension"] = number["flexor tendon.pretension"]

        def side(name: str) -> Side:
            return Side(**{argument: number[f"{name} {key}"] for argument, key in _SIDE.items()})

        anchors = Anchors(**{name: number[f"arm.{name}"] for name in _ANCHORS})
        return Design(
            arm=Arm(anchors, **{name: number[f"arm.{name}"] for name in _ARM if name not in _ANCHORS}),
            flexor=side("flexor"),
            extensor=side("extensor"),
            flexor_radius=number["spool.flexor_radius"],
            ratio=number["spool.ratio"],
            load_mass=number["load.mass"],
            from_initial=_flag_within(self._from_initial, block, states_first=states_first),
            unilateral=_flag_within(self._unilateral, block, states_first=states_first),
        )

    def motion(
        self, block: Block, *, states_first: bool = False
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
        """Elbow angles (1, K) and whether it is flexion (D, 1), shaped to broadcast with `design`."""
        flexion = np.array([direction == "flexion" for direction in self.plan.directions[block.directions]])
        designs = (1,) * len(block.designs) if states_first else ()
        return self.plan.elbow_angles[block.angles].reshape(1, -1, *designs), flexion.reshape(-1, 1, *designs)


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


def _flag_within(flag: Source | bool, block: Block, *, states_first: bool) -> bool | npt.NDArray[np.bool_]:
    return flag if isinstance(flag, bool) else np.asarray(flag.within(block, states_first=states_first), dtype=bool)
