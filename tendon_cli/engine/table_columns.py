"""The columns of a study's tables, and the values of those that say which row is which."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.engine.plan import Block, Plan
from tendon_cli.model.design import F0
from tendon_cli.model.kinematics import Spline
from tendon_cli.model.statics import STATUS_NAMES
from tendon_cli.quantities import (
    AS_READ,
    OF_DESIGNS,
    OF_MOTION_STATES,
    OF_STATES,
    QUANTITIES,
    SIDES,
    Quantity,
    bound_name,
    unit_of_reading,
)
from tendon_cli.studies.axis_words import axis_meaning
from tendon_cli.studies.contents import column_of
from tendon_cli.studies.model_words import KEYS_OF_WORDS, WORDS_OF
from tendon_cli.studies.space.axis import SLACK, Axis, Varying, of_side, split_side
from tendon_cli.studies.space.space import ANCHORS, Carried, Space
from tendon_cli.studies.study import keys
from tendon_cli.tables.schema import Column, Kind

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
"""Columns of `designs` that are true or false, with their meanings; the record counts each."""

AT_RECORD_END = (
    "so near an end of the record that smoothing spoils it: counts in no peak, mean, work or limit"
)
"""Meaning of the column `at_record_end`."""
_KINDS: dict[str, Kind] = {"friction_direction": "count", "turning": "truth"}
"""Kinds of columns along a trajectory that are no numbers."""

_MOST_MOMENT_ARMS = 2**18
"""Most moment arms, arms times elbow angles, that are computed to see if results may be null."""

BlockValues: TypeAlias = Callable[[Block], npt.ArrayLike]
"""Gives the values of a column in a block, to broadcast over its designs, directions and angles."""


def axis_column(axis: Axis) -> Column:
    """Return the column of an axis: of its numbers, or of the names of its values."""
    if axis.names:
        return Column(
            axis.column, "text", "1", axis_meaning(axis), is_axis=True, choices=axis.names
        )
    return number_column(axis.key)


def number_column(key: str) -> Column:
    """Return the column of a number or a word of a study that may differ between rows."""
    words = WORDS_OF.get(split_side(key)[0])
    if words is None:
        return Column.of(keys()[key].quantity, column_of(key), is_axis=True)
    name = column_of(key)
    return Column(name, "text", "1", say.spaced(name), is_axis=True, choices=words)


def columns_set_by_names(space: Space) -> dict[str, Column]:
    """Return the columns of the numbers that vary over named axes of a space, by key.

    They are in the order of the schema; a number of one side has the column of this side.
    """
    order = (*keys(), *KEYS_OF_WORDS)
    return {key: number_column(key) for key in order if key in space.set_by_names}


def carried_columns(space: Space) -> dict[Column, Carried]:
    """Return the columns that rows of named axes carry along, such as prices, with their values."""
    columns = {}
    for carried in space.carried:
        first = carried.first
        name = carried.first.name.replace("_", " ")
        meaning = f"{name} of the {carried.tables[0]}"
        if carried.column == first.name:
            meaning = f"{name}, summed over {say.join_words(carried.tables)}"
        if first.words:
            kind: Kind = "text"
            has_null = False
        else:
            kind = "number"
            has_null = any(np.isnan(column.values).any() for _, column in carried.parts)
        column = Column(
            name=carried.column,
            kind=kind,
            unit=first.unit or "1",
            long_name=meaning,
            is_axis=True,
            choices=first.words,
            nullable=has_null,
        )
        columns[column] = carried
    return columns


@dataclass(frozen=True, eq=False)
class PlanColumns:
    """Columns of the tables of a plan, in order, with the values of the leading ones."""

    plan: Plan

    @cached_property
    def leading(self) -> dict[Column, BlockValues]:
        """`design` and the columns of the axes, with their values."""
        number = Column("design", "count", "1", "number of the design, from 0")
        columns: dict[Column, BlockValues] = {number: _design_numbers}
        for key in self._keys():
            columns |= self._columns_of(key)
        if self.plan.study.setting.read != F0:
            model = Column.of(QUANTITIES["model_pretension"], is_axis=True, nullable=True)
            columns[model] = self._model_pretension
        for place, axis in enumerate(self.plan.axes):
            if axis.names:
                positions = np.arange(len(axis), dtype=np.float64)
                columns[axis_column(axis)] = _within(Varying(np.nan, ((place, positions),)))
        columns |= self._words
        for column, carried in carried_columns(self.plan.space).items():
            columns[column] = _carried(carried)
        return columns

    @cached_property
    def designs(self) -> tuple[Column, ...]:
        """Columns of `designs`."""
        added = (*self.plan.of_motion, *self.plan.of_forms)
        return (
            *self.leading,
            *(self._result(QUANTITIES[name]) for name in OF_DESIGNS),
            *(Column.of(QUANTITIES[name]) for name in added),
            *(Column(name, "truth", "1", meaning) for name, meaning in JUDGEMENTS.items()),
        )

    @cached_property
    def of_states(self) -> dict[Column, BlockValues]:
        """Columns that say which state of a design a row is, with their values."""
        trajectory = self.plan.study.trajectory
        angles = self.plan.elbow_angles
        direction = Column(
            "direction",
            "text",
            "1",
            "direction of the elbow's motion",
            is_axis=True,
            choices=tuple(dict.fromkeys((*self.plan.directions, "flexion", "extension"))),
        )
        angle = Column.of(QUANTITIES["elbow_angle"], is_axis=True, nullable=False)
        if trajectory is None:
            places = np.arange(len(self.plan.directions))[:, np.newaxis]
            return {
                direction: lambda block: places[block.directions],
                angle: lambda block: angles[block.angles],
            }
        time = Column.of(QUANTITIES["time"], is_axis=True, nullable=False)
        speed = Column.of(QUANTITIES["elbow_speed"], nullable=False)
        at_end = Column("at_record_end", "truth", "1", AT_RECORD_END)
        flexes = trajectory.is_flexing
        samples = {
            time: trajectory.time,
            direction: np.where(flexes == flexes[0], 0, 1),
            angle: angles,
            speed: trajectory.speed,
            at_end: trajectory.is_at_end,
        }
        return {column: partial(_sampled, values) for column, values in samples.items()}

    @cached_property
    def states(self) -> tuple[Column, ...]:
        """Columns of `states`, with the results that the study keeps."""
        kept = self.plan.study.output.states or ("status", *OF_STATES, *OF_MOTION_STATES)
        status = Column("status", "text", "1", "which tendon is slack", choices=STATUS_NAMES)
        results = [status, *(self._result(QUANTITIES[name]) for name in OF_STATES)]
        if self.plan.study.trajectory is not None:
            results += [_of_motion(QUANTITIES[name]) for name in OF_MOTION_STATES]
        return (
            *self.leading,
            *self.of_states,
            *(column for column in results if column.name in kept),
        )

    def _result(self, quantity: Quantity) -> Column:
        """Return the column of a result, nullable only if the study may make it null."""
        return self._as_read(Column.of(quantity, nullable=self._may_be_null(quantity.null)))

    def _may_be_null(self, when: str) -> bool:
        """Return True if a result may be null in the study; `when` is as in `Quantity.null`."""
        if when == "slack":
            space = self.plan.space
            if np.any(space.number(SLACK).within(space.whole)):
                return True
        return when == "often" or (when != "never" and not self._always_balanced)

    @cached_property
    def _always_balanced(self) -> bool:
        """True if both moment arms are positive in every state, so that tendons can hold any load.

        False also if there are too many arms to look at them all.
        """
        space = self.plan.space
        elbow_angles = self.plan.elbow_angles
        axes = {axis for name in ANCHORS for axis in space.number(f"arm.{name}").axes}
        lengths = [length if axis in axes else 1 for axis, length in enumerate(self.plan.shape)]
        if math.prod(lengths) * len(elbow_angles) > _MOST_MOMENT_ARMS:
            return False
        box = tuple(slice(0, length) for length in lengths)
        motion = space.design(box).arm.joint.motion(elbow_angles)
        return not np.isnan(motion.pulling_arm).any()

    def _as_read(self, column: Column) -> Column:
        """Return a column that says how a pretension is read; any other column as it is."""
        read = self.plan.study.setting.read
        if read == F0 or column.name not in (*AS_READ, bound_name("max_pretension")):
            return column
        long_name = f"{column.long_name}, read as {read}"
        return replace(column, unit=unit_of_reading(read), long_name=long_name)

    def _keys(self) -> dict[str, None]:
        """Return the common keys of numbers that have a column, each once and in order.

        These are the keys of every table, those of axes, those that vary over named axes, and those
        whose sides differ.
        """
        axes = [key for key in self.plan.study.axes if key in keys()]
        of_names = [key for key in columns_set_by_names(self.plan.space) if key in keys()]
        common = [split_side(key)[0] for key in (*axes, *of_names)]
        of_sides = sorted(self.plan.space.keys_of_sides & keys().keys())
        return dict.fromkeys((*ALWAYS, *common, *of_sides))

    @property
    def _words(self) -> dict[Column, BlockValues]:
        """Columns of the words that vary over named axes; of both sides if the sides differ."""
        space = self.plan.space
        common = [split_side(key)[0] for key in space.set_by_names]
        columns: dict[Column, BlockValues] = {}
        for key in WORDS_OF:
            if key not in common:
                continue
            sides = SIDES if key in space.keys_of_sides else (None,)
            for side in sides:
                column = number_column(key if side is None else of_side(key, side))
                columns[column] = _within(space.number(key, side))
        return columns

    def _columns_of(self, key: str) -> dict[Column, BlockValues]:
        """Return the column of a key; if the sides differ, a null one and one for each side."""
        space = self.plan.space
        quantity = keys()[key].quantity
        name = keys()[key].column
        common = space.number(key)
        numbers = {name: common}
        if key in space.keys_of_sides:
            of_sides = {f"{name}_{side}": space.number(key, side) for side in SIDES}
            if not all(isinstance(number.value, Spline) for number in of_sides.values()):
                numbers = {name: Varying(None), **of_sides}
        columns: dict[Column, BlockValues] = {}
        for column_name, number in numbers.items():
            # A bend that follows the joint is a curve, not a number.
            is_number = number.value is not None and not isinstance(number.value, Spline)
            # Only one side, or only some cases, may state a number that a study need not have.
            is_given = is_number and not np.isnan(number.within(space.whole)).any()
            column = Column.of(quantity, column_name, is_axis=True, nullable=not is_given)
            columns[self._as_read(column)] = _within(number) if is_number else _null
        return columns

    def _model_pretension(self, block: Block) -> npt.ArrayLike:
        """Return the pretension that the model takes for a setting, N."""
        return np.asarray(self.plan.design(block).flexor.pretension)


def _of_motion(quantity: Quantity) -> Column:
    """Return the column of a further result along a trajectory."""
    column = Column.of(quantity, nullable=quantity.null != "never")
    kind = _KINDS.get(quantity.name)
    return column if kind is None else replace(column, kind=kind)


def _design_numbers(block: Block) -> npt.ArrayLike:
    """Return the numbers of the designs of a block (designs ..., 1, 1)."""
    shape = (*block.shape[:-2], 1, 1)
    return np.arange(block.first_design, block.first_design + block.design_count).reshape(shape)


def _sampled(values: npt.NDArray[Any], block: Block) -> npt.ArrayLike:
    """Return the values at a block's samples of a trajectory."""
    return values[block.angles]


def _null(_block: Block) -> npt.ArrayLike:
    return np.nan


def _carried(carried: Carried) -> BlockValues:
    """Return the function that gives what rows carry along for the designs of a block."""
    return lambda block: carried.within(block.designs)


def _within(number: Varying) -> BlockValues:
    """Return the function that gives a number for the designs of a block."""
    return lambda block: number.within(block.designs)
