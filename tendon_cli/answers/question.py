"""A design question: choices and conditions of a study, its limits and goals, and its designs."""

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
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.space.axis import (
    DRAW_AXIS,
    PERSON_AXIS,
    PRETENSION,
    READ,
    Axis,
    Numbers,
    Rows,
    overlay,
    split_side,
)
from tendon_cli.space.space import Space
from tendon_cli.studies.study import Study

ColumnArrays = dict[str, npt.NDArray[Any]]
"""Arrays of one length by the names of a table's columns."""

LOADS = ("load.mass", "load.scale")
"""A list of one of these means all values between, too; any other number needs an interval."""
LINEAR = (
    *LOADS,
    "arm.forearm_mass",
    "arm.forearm_com",
    "arm.load_distance",
    "joint.stiffness",
    "joint.rest_angle",
)
"""Every limit on states is linear in each: what suits both ends suits all values between."""
LEAN = "arm.upper_arm_angle"
"""Every limit on states is linear in the sine and cosine of this."""
_ENDS_SUFFICE = (*LINEAR, LEAN, PRETENSION)


@dataclass(frozen=True)
class Goal:
    """A column of the choices to minimise or to maximise."""

    column: str
    maximise: bool

    def score(self, values: Array) -> Array:
        """Return scores, the larger the better; a torque counts by its magnitude, null is worst."""
        is_torque = self.column == "peak_motor_torque"
        sizes = np.abs(values) if is_torque else np.asarray(values, dtype=np.float64)
        return np.where(np.isnan(sizes), -np.inf, sizes if self.maximise else -sizes)


USUAL = (
    Goal("tolerance", maximise=True),
    Goal("pretension", maximise=False),
    Goal("max_tension", maximise=False),
    Goal("max_spring_extension", maximise=False),
    Goal("peak_motor_torque", maximise=False),
)
"""An answer names the best choice by each of these if the study names no goal."""
SERVED = Goal("served", maximise=True)
"""The largest share served; it comes before the usual goals if there are people or draws."""


def goals_of(study: Study) -> tuple[Goal, ...]:
    """Return the goals of a study in its order; none if it leaves them open."""
    smallest = tuple(Goal(column, maximise=False) for column in study.design.minimise)
    largest = tuple(Goal(column, maximise=True) for column in study.design.maximise)
    return (*smallest, *largest)


@dataclass(frozen=True, eq=False)
class Question:
    """A design question: its choices, the conditions that they must cope with, and its limits."""

    study: Study
    choices: Space
    conditions: Space
    bounds: Bounds
    enough: float = 1.0
    """Share of persons, draws or conditions that a window must serve."""
    middle: bool = True
    """True if a choice is set in the middle of its window, else at its least pretension."""
    given: float | None = None
    """Pretension of every choice, N, if the question gives one; windows are solved nevertheless."""
    near: float = 0.01
    """Relative distance from the end of a choice's window within which an end under one condition
    is sought between the angles, because it may set the end of the choice.

    An end over the grid of angles is off by a thousandth. No end is sought if this is 0 or less,
    and every end if it is infinite.
    """
    notes: tuple[str, ...] = ()
    """Sentences on what was left out of the question, and why."""
    stop: threading.Event = field(default_factory=threading.Event)
    """Event that cancels the run."""

    @property
    def goals(self) -> tuple[Goal, ...]:
        """Goals of the study, or if it leaves them open the usual ones."""
        usual = USUAL if self.conditions.groups is None else (SERVED, *USUAL)
        return goals_of(self.study) or usual

    @cached_property
    def angles(self) -> Array:
        """Elbow angles of the states, (1, K), rad.

        They are those of a trajectory, or evenly spaced from the first to the last of the study.
        """
        if self.study.trajectory is not None:
            return self.study.angles[np.newaxis]
        return whole_motion.angle_grid(self.study.angles)

    @property
    def flexion(self) -> Flags:
        """True where a direction is flexion, (D, 1), or a sample of a trajectory, (1, K)."""
        return self.study.flexion

    @property
    def states_per_design(self) -> int:
        """Number of directions times number of elbow angles."""
        return self.angles.size * len(self.flexion)

    @cached_property
    def axes(self) -> dict[str, Axis]:
        """Axes of the conditions by their keys."""
        return {axis.key: axis for axis in self.conditions.axes}

    @cached_property
    def condition_numbers(self) -> Numbers:
        """Numbers that all conditions set, (conditions,) each."""
        return self.conditions.numbers(np.arange(len(self.conditions)))

    @cached_property
    def groups(self) -> Rows:
        """Group of each condition, (conditions,); it counts if all its conditions are served."""
        groups = self.conditions.groups
        return np.arange(len(self.conditions)) if groups is None else groups

    @cached_property
    def weighting(self) -> Array:
        """Weight of each group, (groups,), the largest from 0.5 to 1 so that sums stay finite."""
        weights = self.conditions.weighting
        if weights is None:
            return np.ones(self.groups[-1] + 1)
        first_conditions = np.flatnonzero(np.diff(self.groups, prepend=-1))
        of_groups = weights[first_conditions]
        _, exponent = np.frexp(np.max(of_groups))
        return np.asarray(np.ldexp(of_groups, -int(exponent)))

    def under(self, conditions: Rows) -> Self:
        """Return this question for some of its conditions, each of which then counts by itself."""
        numbers = select_numbers(self.condition_numbers, conditions)
        points = Axis.of_points(numbers, len(conditions))
        return replace(self, conditions=Space((points,)))

    def select_groups(self, groups: Rows) -> Self:
        """Return this question for some of its groups, which are given in ascending order."""
        rows = np.flatnonzero(np.isin(self.groups, groups))
        selected = replace(
            self.under(rows).conditions,
            weighting=self.weighting[self.groups[rows]],
            groups=np.searchsorted(groups, self.groups[rows]),
        )
        return replace(self, conditions=selected)

    def saying(self, numbers: Numbers) -> Self:
        """Return this question with other or further numbers set by its conditions."""
        points = Axis.of_points({**self.condition_numbers, **numbers}, len(self.conditions))
        return replace(self, conditions=replace(self.conditions, axes=(points,)))

    def bounded(self, name: str, value: float) -> Self:
        """Return this question with another value of one limit, or of the speed."""
        return replace(self, bounds=self.bounds.changed(name, value))

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of persons and of draws by the keys of their axes.

        If there are both, a share is of their pairs. Bodies drawn for a person count as draws.
        """
        counts = {key: len(self.axes[key]) for key in (PERSON_AXIS, DRAW_AXIS) if key in self.axes}
        people = self.study.people
        bodies = people.population.completions if people is not None else 1
        if PERSON_AXIS in counts and bodies > 1:
            return {
                PERSON_AXIS: counts[PERSON_AXIS] // bodies,
                DRAW_AXIS: counts.get(DRAW_AXIS, 1) * bodies,
            }
        return counts

    @property
    def counted(self) -> str:
        """Noun for what a share counts: "persons", "pairs", "draws" or "conditions"."""
        kinds = tuple(self.counts)
        if len(kinds) == 2:
            return "pairs"
        return f"{kinds[0]}s" if kinds else "conditions"

    @property
    def group_axis(self) -> Axis | None:
        """Axis of persons or, without persons, of draws; None if there are neither."""
        return self.axes.get(PERSON_AXIS) or self.axes.get(DRAW_AXIS)

    def numbers_of(self, columns: ColumnArrays) -> Numbers:
        """Return the numbers that choices, given by their columns, set."""
        numbers: dict[str, Array] = {}
        for axis in self.choices.axes:
            values = columns[axis.column]
            if axis.names:
                numbers |= {key: of_names[values] for key, of_names in axis.numbers.items()}
            else:
                numbers[axis.key] = values
        return numbers

    def design(
        self, numbers: Numbers, conditions: Numbers | None = None, pretension: Array | None = None
    ) -> Design:
        """Return the designs of some choices under conditions, as they vary.

        A number of a condition takes precedence over that of a choice.

        Args:
            numbers: Numbers of the choices, (choices,) each.
            conditions: Numbers of the conditions, (conditions,) each; all conditions by default.
            pretension: Pretensions of the choices, (choices,), N.

        Returns:
            Designs that broadcast to (choices, conditions, 1, 1).
        """
        of_choices = numbers if pretension is None else {**numbers, PRETENSION: pretension}
        under = self.condition_numbers if conditions is None else conditions
        return self.choices.at(of_choices, under).design()

    def paired(
        self, numbers: Numbers, rows: Rows, condition: Rows, above: Numbers | None = None
    ) -> Design:
        """Return the designs of choices, each under one condition, (pairs, 1, 1).

        Args:
            numbers: Numbers of the choices.
            rows: Choice of each pair, as a place in `numbers`.
            condition: Condition of each pair.
            above: Numbers of the pairs that take precedence over those of both.
        """
        of_conditions = select_numbers(self.condition_numbers, condition)
        of_pairs = overlay(select_numbers(numbers, rows), {**of_conditions, **(above or {})})
        points = Axis.of_points(of_pairs, len(rows))
        return Space((points,), self.choices.single).design()

    @cached_property
    def box(self) -> tuple[Axis, ...]:
        """Intervals over which a proof holds as a box; other nonlinear ones are only sampled."""
        if not self.is_f0 or self.study.trajectory is not None:
            return ()
        intervals = self._nonlinear_intervals
        return tuple(axis for axis in intervals if not axis.key.startswith("setting."))

    @property
    def _nonlinear_intervals(self) -> list[Axis]:
        """Intervals of numbers in which limits are not linear."""
        intervals = [axis for axis in self.conditions.axes if axis.is_interval]
        return [axis for axis in intervals if split_side(axis.key)[0] not in _ENDS_SUFFICE]

    @property
    def leaning(self) -> Axis | None:
        """Interval of postures of the upper arm; None if there is none."""
        axis = self.axes.get(LEAN)
        return axis if axis is not None and axis.is_interval else None

    @property
    def sampled_intervals(self) -> tuple[str, ...]:
        """Keys of the intervals that are solved at their ends alone."""
        return tuple(axis.key for axis in self._nonlinear_intervals if axis not in self.box)

    @property
    def whole_intervals(self) -> tuple[str, ...]:
        """Keys of the intervals whose inside may be worse than both ends, but is proved as well."""
        of_box = tuple(axis.key for axis in self.box)
        leans = self.leaning is not None and self.study.trajectory is None
        return (LEAN, *of_box) if leans else of_box

    @property
    def is_sampled(self) -> bool:
        """True if part of the question is only sampled, so that its windows cannot be proved."""
        return bool(self.bounds.of_motion or self.sampled_intervals or self.study.trajectory)

    @property
    def loads(self) -> tuple[float, float] | None:
        """Smallest and largest load, kg; None if no axis of the conditions is the load."""
        axis = self.axes.get("load.mass")
        return None if axis is None else (float(axis.values.min()), float(axis.values.max()))

    @property
    def is_f0(self) -> bool:
        """True if pretensions are those of the model, F0, and not readings of a gauge."""
        return READINGS[int(self.choices.single.get(READ, 0.0))] == F0

    def check_stopped(self) -> None:
        """Raise Stopped if the run was cancelled."""
        if self.stop.is_set():
            raise Stopped


def select_numbers(numbers: Numbers, rows: Rows | slice) -> dict[str, Array]:
    """Select some rows of every number, such as some choices or conditions."""
    return {key: values[rows] for key, values in numbers.items()}
