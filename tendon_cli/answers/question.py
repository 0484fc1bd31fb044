"""What is asked: the choices and conditions of a study, its limits and goals, and the designs of both."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import Stopped
from tendon_cli.model import whole_motion
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import F0, READINGS, Design
from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import (
    DRAW_AXIS,
    PERSON_AXIS,
    PRETENSION,
    READ,
    Axis,
    Numbers,
    Rows,
    over,
    split_side,
)
from tendon_cli.space.space import Space
from tendon_cli.studies.study import Study

Flags = npt.NDArray[np.bool_]
Columns = dict[str, npt.NDArray[Any]]

LINEAR = (
    "load.mass",
    "load.scale",
    "arm.forearm_mass",
    "arm.forearm_com",
    "arm.load_distance",
    "joint.stiffness",
    "joint.rest_angle",
)
"""Every limit on states is linear in each of these, so that what suits both ends suits all between."""
LOADS = LINEAR[
    :2
]  # of these a list is meant with all between; of others that hold an interval alone is
LEAN = "arm.upper_arm_angle"  # and linear in sine and cosine of this
_ENDS_SUFFICE = (*LINEAR, LEAN, PRETENSION)


@dataclass(frozen=True)
class Goal:
    """A column of the choices that is to be as small, or as large, as can be."""

    column: str
    maximise: bool

    def score(self, values: Array) -> Array:
        """The larger the better; a torque counts by its magnitude, and what is null is worst."""
        sized = (
            np.abs(values)
            if self.column == "peak_motor_torque"
            else np.asarray(values, dtype=np.float64)
        )
        return np.where(np.isnan(sized), -np.inf, sized if self.maximise else -sized)


USUAL = (
    Goal("tolerance", maximise=True),
    Goal("pretension", maximise=False),
    Goal("max_tension", maximise=False),
    Goal("max_spring_extension", maximise=False),
    Goal("peak_motor_torque", maximise=False),
)
"""Where a study names no goal, the best by each of these."""
SERVED = Goal(
    "served", maximise=True
)  # before them where there are people or draws: the most universal choice


def goals_of(study: Study) -> tuple[Goal, ...]:
    """The goals of a study, in its order; none where it leaves them open."""
    least = tuple(Goal(column, maximise=False) for column in study.design.minimise)
    return (*least, *(Goal(column, maximise=True) for column in study.design.maximise))


@dataclass(frozen=True, eq=False)
class Question:
    """What is asked: over which choices, under which conditions, within which limits."""

    study: Study
    choices: Space
    conditions: Space
    bounds: Bounds
    enough: float = 1.0  # the share that a window must serve
    middle: bool = True  # a choice is set in the middle of its window, else at its least pretension
    given: float | None = (
        None  # the pretension of every choice, N, if the question has one; its window is solved, too
    )
    near: float = 0.01
    """The share within which ends of conditions are sought between the angles, which may set those of their choice; the
    grid is off by a thousandth. Below 0 none is, and with infinity every one."""
    notes: tuple[str, ...] = ()  # what was left out of the question, and why
    stop: threading.Event = field(
        default_factory=threading.Event
    )  # set when whoever asked wants no answer any more

    @property
    def goals(self) -> tuple[Goal, ...]:
        """The goals of the study, or if it leaves them open those by each of which an answer names the best."""
        usual = USUAL if self.conditions.groups is None else (SERVED, *USUAL)
        return goals_of(self.study) or usual

    @cached_property
    def angles(self) -> Array:
        """Elbow angles at which states are taken, (1, K), rad: those of a trajectory, or evenly from first to last."""
        if self.study.trajectory is not None:
            return self.study.angles[np.newaxis]
        return whole_motion.grid(self.study.angles)

    @property
    def flexion(self) -> Flags:
        """Whether each direction is flexion, (D, 1), or each sample of a trajectory, (1, K)."""
        return self.study.flexion

    @property
    def states_per_design(self) -> int:
        """Directions times elbow angles."""
        return self.angles.size * len(self.flexion)

    @cached_property
    def axes(self) -> dict[str, Axis]:
        """Those of the conditions, by their keys."""
        return {axis.key: axis for axis in self.conditions.axes}

    @cached_property
    def condition_numbers(self) -> Numbers:
        """What all conditions say of the study's numbers."""
        return self.conditions.numbers(np.arange(len(self.conditions)))

    @cached_property
    def groups(self) -> Rows:
        """The group of each condition: what must be served together to count."""
        groups = self.conditions.groups
        return np.arange(len(self.conditions)) if groups is None else groups

    @cached_property
    def weighting(self) -> Array:
        """Of each group, the largest between a half and 1, so that sums stay finite."""
        weights = self.conditions.weighting
        if weights is None:
            return np.ones(self.groups[-1] + 1)
        each = weights[np.flatnonzero(np.diff(self.groups, prepend=-1))]
        return np.asarray(np.ldexp(each, -int(np.frexp(np.max(each))[1])))

    def under(self, conditions: Rows) -> Self:
        """The same question under some of its conditions alone, each of which counts by itself."""
        numbers = select_numbers(self.condition_numbers, conditions)
        return replace(self, conditions=Space((Axis.of_points(numbers, len(conditions)),)))

    def of_groups(self, chosen: Rows) -> Self:
        """The same question for some of those who count together, ascending."""
        rows = np.flatnonzero(np.isin(self.groups, chosen))
        space = self.under(rows).conditions
        weighting, groups = (
            self.weighting[self.groups[rows]],
            np.searchsorted(chosen, self.groups[rows]),
        )
        return replace(self, conditions=replace(space, weighting=weighting, groups=groups))

    def saying(self, numbers: Numbers) -> Self:
        """The same question where its conditions say something else, or more, of the study's numbers."""
        rows = Axis.of_points({**self.condition_numbers, **numbers}, len(self.conditions))
        return replace(self, conditions=replace(self.conditions, axes=(rows,)))

    def bounded(self, name: str, value: float) -> Self:
        """The same question with another value of one limit, or of the speed."""
        return replace(self, bounds=self.bounds.changed(name, value))

    @property
    def counts(self) -> dict[str, int]:
        """How many persons and draws there are, by the keys of their axes; a share is of the pairs if of both.

        Bodies drawn of a person are draws.
        """
        counts = {key: len(self.axes[key]) for key in (PERSON_AXIS, DRAW_AXIS) if key in self.axes}
        bodies = self.study.people.population.completions if self.study.people is not None else 1
        if PERSON_AXIS in counts and bodies > 1:
            return {
                PERSON_AXIS: counts[PERSON_AXIS] // bodies,
                DRAW_AXIS: counts.get(DRAW_AXIS, 1) * bodies,
            }
        return counts

    @property
    def counted(self) -> str:
        """What a share is of: "persons", "pairs" of person and draw, "draws" or "conditions"."""
        kinds = tuple(self.counts)
        return "pairs" if len(kinds) == 2 else f"{kinds[0]}s" if kinds else "conditions"

    @property
    def one_by_one(self) -> Axis | None:
        """The axis of persons, or if there are none of draws; None if there are neither."""
        return self.axes.get(PERSON_AXIS) or self.axes.get(DRAW_AXIS)

    def numbers_of(self, columns: Columns) -> Numbers:
        """What choices, given by their columns, say of the study's numbers."""
        numbers: dict[str, Array] = {}
        for axis in self.choices.axes:
            values = columns[axis.column]
            numbers |= (
                {key: each[values] for key, each in axis.numbers.items()}
                if axis.names
                else {axis.key: values}
            )
        return numbers

    def design(
        self, numbers: Numbers, conditions: Numbers | None = None, pretension: Array | None = None
    ) -> Design:
        """Designs (choices, conditions, 1, 1) of some choices under all conditions, or those given, as they vary.

        A condition says more than a choice. `pretension` has the shape (choices,).
        """
        at = numbers if pretension is None else {**numbers, PRETENSION: pretension}
        return self.choices.at(
            at, self.condition_numbers if conditions is None else conditions
        ).design()

    def paired(
        self, numbers: Numbers, rows: Rows, condition: Rows, above: Numbers | None = None
    ) -> Design:
        """Designs (pairs, 1, 1) of choices, each under one condition, and by what is said above these."""
        under = {**select_numbers(self.condition_numbers, condition), **(above or {})}
        points = Axis.of_points(over(select_numbers(numbers, rows), under), len(rows))
        return Space((points,), self.choices.single).design()

    @cached_property
    def box(self) -> tuple[Axis, ...]:
        """Intervals that proofs hold for as a box; of the others those in which limits are not linear are sampled."""
        provable = self.is_f0 and self.study.trajectory is None
        return tuple(
            axis for axis in self._curved if provable and not axis.key.startswith("setting.")
        )

    @property
    def _curved(self) -> list[Axis]:
        """Intervals in which limits are not linear."""
        intervals = (axis for axis in self.conditions.axes if axis.is_interval)
        return [axis for axis in intervals if split_side(axis.key)[0] not in _ENDS_SUFFICE]

    @property
    def leaning(self) -> Axis | None:
        """The interval of postures of the upper arm, if there is one."""
        axis = self.axes.get(LEAN)
        return axis if axis is not None and axis.is_interval else None

    @property
    def sampled_intervals(self) -> tuple[str, ...]:
        """The keys of those that are solved at their ends alone."""
        return tuple(axis.key for axis in self._curved if axis not in self.box)

    @property
    def whole_intervals(self) -> tuple[str, ...]:
        """The keys of those whose inside may be worse than both ends, and for all of which windows are proved."""
        is_whole = self.leaning is not None and self.study.trajectory is None
        return (*([LEAN] if is_whole else []), *(axis.key for axis in self.box))

    @property
    def is_sampled(self) -> bool:
        """Whether something that is asked has no proof."""
        return bool(self.bounds.of_motion or self.sampled_intervals or self.study.trajectory)

    @property
    def loads(self) -> tuple[float, float] | None:
        """The least and the largest load, kg, if there are several."""
        axis = self.axes.get("load.mass")
        return None if axis is None else (float(axis.values.min()), float(axis.values.max()))

    @property
    def is_f0(self) -> bool:
        """Whether pretensions are those of the model, and no readings."""
        return READINGS[int(self.choices.single.get(READ, 0.0))] == F0

    def check_stopped(self) -> None:
        """Raises Stopped if nobody wants an answer any more."""
        if self.stop.is_set():
            raise Stopped


def select_numbers(numbers: Numbers, rows: Rows | slice) -> dict[str, Array]:
    """What some choices or conditions say of the study's numbers."""
    return {key: values[rows] for key, values in numbers.items()}
