"""Which columns a study's tables have, and the values of those that say which design and state a row is."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.engine.plan import Block, Plan
from tendon_cli.model.design import F0
from tendon_cli.model.kinematics import Spline
from tendon_cli.model.statics import STATUS_NAMES
from tendon_cli.quantities import AS_READ, OF_DESIGNS, OF_STATES, QUANTITIES, Quantity
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, SIDES, SLACK, Varying, split_side
from tendon_cli.space.space import ANCHORS
from tendon_cli.studies.study import keys
from tendon_cli.tables.schema import Column

ALWAYS = (
    "tendon.pretension",
    "spring.stiffness",
    "spool.ratio",
    "load.mass",
    "sheath.friction",
    "sheath.bend_angle",
)
"""Keys that have a column in every table."""

JUDGEMENTS = {
    "taut": "no state is slack or without equilibrium",
    "stable": "no state has less than the least elbow stiffness",
    "feasible": "taut, stable and within every limit",
}
"""Truths of `designs`, with what they mean; the record counts each."""

_MOST_LOOKED_INTO = 2**18
"""Arms at angles."""

Values = Callable[[Block], npt.ArrayLike]


@dataclass(frozen=True, eq=False)
class Tables:
    """The columns of both tables of a plan, in order, with what fills the leading ones."""

    plan: Plan

    @cached_property
    def leading(self) -> dict[Column, Values]:
        """`design` and the columns of the axes, each with its values in a block."""
        columns: dict[Column, Values] = {
            Column("design", "count", "1", "number of the design, from 0"): _design_numbers
        }
        for key in self._keys():
            columns |= self._columns_of(key)
        if self.plan.study.setting.read != F0:
            model = Column.of(QUANTITIES["model_pretension"], is_axis=True, nullable=True)
            columns[model] = lambda block: np.asarray(self.plan.design(block).flexor.pretension)
        for at, axis in enumerate(self.plan.axes):
            if axis.names:
                names = Column(
                    axis.column, "text", "1", axis.meaning, is_axis=True, choices=axis.names
                )
                columns[names] = _within(
                    Varying(np.nan, ((at, np.arange(len(axis), dtype=np.float64)),))
                )
        return columns

    @cached_property
    def designs(self) -> tuple[Column, ...]:
        """Columns of `designs`."""
        results = [self._result(QUANTITIES[name]) for name in OF_DESIGNS]
        results += [
            Column.of(QUANTITIES[name]) for name in (*self.plan.of_motion, *self.plan.of_forms)
        ]
        return (
            *self.leading,
            *results,
            *(Column(name, "truth", "1", meaning) for name, meaning in JUDGEMENTS.items()),
        )

    @cached_property
    def of_states(self) -> dict[Column, Values]:
        """The columns that say which state of a design a row is, each with its values in a block."""
        directions = tuple(dict.fromkeys((*self.plan.directions, "flexion", "extension")))
        text = Column(
            "direction",
            "text",
            "1",
            "direction of the elbow's motion",
            is_axis=True,
            choices=directions,
        )
        angle = Column.of(QUANTITIES["elbow_angle"], is_axis=True, nullable=False)
        trajectory, angles = self.plan.study.trajectory, self.plan.elbow_angles
        if trajectory is None:
            numbers = np.arange(len(self.plan.directions))[:, np.newaxis]
            return {
                text: lambda block: numbers[block.directions],
                angle: lambda block: angles[block.angles],
            }
        ways = np.where(trajectory.flexion == trajectory.flexion[0], 0, 1)
        time = Column.of(QUANTITIES["time"], is_axis=True, nullable=False)
        speed = Column.of(QUANTITIES["elbow_speed"], nullable=False)
        along = {time: trajectory.time, text: ways, angle: angles, speed: trajectory.speed}
        return {column: partial(_sampled, values) for column, values in along.items()}

    @cached_property
    def states(self) -> tuple[Column, ...]:
        """Columns of `states`; of the results those that the study keeps."""
        kept = self.plan.study.output.states or ("status", *OF_STATES)
        status = Column("status", "text", "1", "which tendon is slack", choices=STATUS_NAMES)
        results = (status, *(self._result(QUANTITIES[name]) for name in OF_STATES))
        return (
            *self.leading,
            *self.of_states,
            *(column for column in results if column.name in kept),
        )

    def _result(self, quantity: Quantity) -> Column:
        return self._as_read(Column.of(quantity, nullable=self._may_be_null(quantity.null)))

    def _may_be_null(self, when: str) -> bool:
        """Whether a result that is null under a condition may be so anywhere in the study; see `Quantity.null`."""
        if when == "slack" and np.any(self.plan.space.number(SLACK).within(self.plan.space.whole)):
            return True
        return when == "often" or (when != "never" and not self._always_balanced)

    @cached_property
    def _always_balanced(self) -> bool:
        """Whether the flexor can balance a load in every state; not looked into, and false, for very many arms."""
        axes = {axis for name in ANCHORS for axis in self.plan.space.number(f"arm.{name}").axes}
        box = tuple(
            slice(0, length if axis in axes else 1) for axis, length in enumerate(self.plan.shape)
        )
        if math.prod(each.stop for each in box) * len(self.plan.elbow_angles) > _MOST_LOOKED_INTO:
            return False
        motion = self.plan.space.design(box).arm.joint.motion(self.plan.elbow_angles)
        return not np.isnan(motion.pulling_arm).any()

    def _as_read(self, column: Column) -> Column:
        """A column that says how a pretension is read, if it is one."""
        read = self.plan.study.setting.read
        if read == F0 or column.name not in AS_READ:
            return column
        return replace(column, long_name=f"{column.long_name}, read as {read}")

    def _keys(self) -> dict[str, None]:
        """Common keys that have a column: of every table, of axes and what these change, of what differs by side."""
        axes = [key for key in self.plan.study.axes if key in keys()]
        bodies = [axis for axis in self.plan.axes if axis.key in (PERSON_AXIS, DRAW_AXIS)]
        of_bodies = [key for key in keys() if any(key in axis.keys for axis in bodies)]
        common = [split_side(key)[0] for key in (*axes, *of_bodies)]
        return dict.fromkeys((*ALWAYS, *common, *sorted(self.plan.space.of_sides & keys().keys())))

    def _columns_of(self, key: str) -> dict[Column, Values]:
        """The column of a key, or if the sides differ the two of the sides and a null one."""
        plain, quantity, space = keys()[key].column, keys()[key].number.quantity, self.plan.space
        numbers = {plain: space.number(key)}
        if key in space.of_sides and not isinstance(numbers[plain].value, Spline):
            numbers = {
                plain: Varying(None),
                **{f"{plain}_{side}": space.number(key, side) for side in SIDES},
            }
        columns = {}
        for name, number in numbers.items():  # a bend that follows the joint is no number
            is_number = number.value is not None and not isinstance(number.value, Spline)
            column = self._as_read(Column.of(quantity, name, is_axis=True, nullable=not is_number))
            columns[column] = _within(number) if is_number else lambda _block: np.nan
        return columns


def _design_numbers(block: Block) -> npt.ArrayLike:
    shape = (*block.shape[:-2], 1, 1)
    return np.arange(block.first_design, block.first_design + block.design_count).reshape(shape)


def _sampled(values: npt.NDArray[Any], block: Block) -> npt.ArrayLike:
    return values[block.angles]


def _within(number: Varying) -> Values:
    """What a number is for the designs of a block."""
    return lambda block: number.within(block.designs)
