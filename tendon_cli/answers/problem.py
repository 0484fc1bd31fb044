"""A design question: a study's choices and conditions, its limits, and how windows over them are worked out."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.errors import Stopped
from tendon_cli.model import between, window
from tendon_cli.model.actuator import Situation
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import F0, Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.motor_window import narrowed
from tendon_cli.model.window import Ends, Window
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, PRETENSION, Axis, Numbers, Rows, over
from tendon_cli.space.space import Space
from tendon_cli.studies.study import Study

Flags = npt.NDArray[np.bool_]

_STATES_AT_ONCE = 2**21
"""So that the model's arrays stay within a few megabytes each."""
_NEAR = 0.01
"""Share within which windows of conditions are looked at between the angles; these move ends by a thousandth."""
_MOTOR_IN_NUMPY = 8
"""By how much fewer are at once with limits on the motor, of which all states have arrays."""


@dataclass(frozen=True, eq=False)
class Problem:
    """What is asked: over which choices, under which conditions, within which limits."""

    study: Study
    choices: Space
    conditions: Space
    bounds: Bounds
    enough: float = 1.0
    """The share that a window must serve."""
    middle: bool = True
    """A choice is set in the middle of its window, else at its least pretension."""
    given: float | None = None
    """The pretension of every choice, N, if the question has one; its window is solved, too."""
    notes: tuple[str, ...] = ()
    """What was left out of the question, and why."""
    stop: threading.Event = field(default_factory=threading.Event)
    """Set when whoever asked wants no answer any more."""

    @cached_property
    def angles(self) -> Array:
        """Elbow angles at which states are taken, (1, K), rad: the same between the study's first and last."""
        return between.grid(self.study.motion.elbow_angle.array)

    @property
    def flexion(self) -> Flags:
        """Whether each direction is flexion, (D, 1)."""
        return np.array([direction == "flexion" for direction in self.study.motion.direction]).reshape(-1, 1)

    @property
    def states_per_design(self) -> int:
        """Directions times elbow angles."""
        return self.angles.size * self.flexion.size

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

    def under(self, conditions: Rows) -> Problem:
        """The same question under some of its conditions alone, each of which counts by itself."""
        numbers = {key: values[conditions] for key, values in self.condition_numbers.items()}
        return replace(self, conditions=Space((Axis.of_points(numbers, len(conditions)),)))

    def of_groups(self, chosen: Rows) -> Problem:
        """The same question for some of those who count together, ascending."""
        rows = np.flatnonzero(np.isin(self.groups, chosen))
        numbers = {key: values[rows] for key, values in self.condition_numbers.items()}
        groups = np.searchsorted(chosen, self.groups[rows])
        points, weighting = Axis.of_points(numbers, len(rows)), self.weighting[self.groups[rows]]
        return replace(self, conditions=Space((points,), weighting=weighting, groups=groups))

    @property
    def counts(self) -> dict[str, int]:
        """How many persons and draws there are, by the keys of their axes; a share is of the pairs if of both.

        Bodies drawn of a person are draws.
        """
        counts = {axis.key: len(axis) for axis in self.conditions.axes if axis.key in (PERSON_AXIS, DRAW_AXIS)}
        bodies = self.study.people.population.completions if self.study.people is not None else 1
        if PERSON_AXIS in counts and bodies > 1:
            return {PERSON_AXIS: counts[PERSON_AXIS] // bodies, DRAW_AXIS: counts.get(DRAW_AXIS, 1) * bodies}
        return counts

    @property
    def counted(self) -> str:
        """What a share is of: "persons", "pairs" of person and draw, "draws" or "conditions"."""
        kinds = tuple(self.counts)
        return "pairs" if len(kinds) == 2 else f"{kinds[0]}s" if kinds else "conditions"

    def person_of(self, groups: Rows) -> Rows:
        """The row of the population that each of some groups belongs to, for a question of people."""
        return groups // next((len(axis) for axis in self.conditions.axes if axis.key == DRAW_AXIS), 1)

    def saying(self, numbers: Numbers) -> Problem:
        """The same question where its conditions say something else, or more, of the study's numbers."""
        rows = Axis.of_points({**self.condition_numbers, **numbers}, len(self.conditions))
        return replace(self, conditions=replace(self.conditions, axes=(rows,)))

    def limit(self, name: str) -> float:
        """A limit in SI."""
        return float(self.bounds[name])

    def relaxed(self, name: str, value: float) -> Problem:
        """The same question with another value of one limit."""
        return self.within(self.bounds.changed(name, value))

    def within(self, bounds: Bounds) -> Problem:
        """The same question within other limits."""
        return replace(self, bounds=bounds)

    def design(self, numbers: Numbers, conditions: Numbers | None = None, pretension: Array | None = None) -> Design:
        """Designs (choices, conditions, 1, 1) of some choices under all conditions, or those given, as they vary.

        A condition says more than a choice. `pretension` has the shape (choices,).
        """
        under = self.condition_numbers if conditions is None else conditions
        at = numbers if pretension is None else {**numbers, PRETENSION: pretension}
        return self.points(at, under).design()

    def points(self, numbers: Numbers, under: Numbers) -> Space:
        """Every choice of some under every condition of some, by what these say of the study's numbers."""
        return Space((Axis.of_points(numbers), Axis.of_points(under)), self.choices.single)

    def windows(self, numbers: Numbers, count: int) -> Window:
        """The windows of `count` choices, (choices, conditions)."""
        return Window(**self._chunked(self._window, numbers, count))

    def ends(self, numbers: Numbers, count: int) -> Ends:
        """The same in half the time: windows where naming the limits costs nothing, else their ends alone."""
        if self.bounds.of_motion or kernel.kind() is None:
            return self.windows(numbers, count)
        return Ends(**self._chunked(self._ends, numbers, count))

    def named(self, numbers: Numbers, found: Ends, condition: Rows) -> Window:
        """Of what was found of choices the windows, (choices,), each under one condition."""
        rows = np.arange(len(condition))
        if isinstance(found, Window):
            return Window(**{name: values[rows, condition] for name, values in vars(found).items()})
        under = {key: values[condition] for key, values in self.condition_numbers.items()}
        design = self.points(over(numbers, under), {}).design()
        picked = Ends(**{name: values[rows, condition, np.newaxis] for name, values in vars(found).items()})
        each = window.named(picked, design, self.angles, self.flexion, self.bounds)
        return Window(**{name: values[:, 0] for name, values in vars(each).items()})

    def _chunked(self, find: Callable[[Design, tuple[int, int]], Ends], numbers: Numbers, count: int) -> dict[str, Any]:
        whole: dict[str, Any] = {}
        for rows, conditions in self.chunks(count):
            part = {key: values[rows] for key, values in numbers.items()}
            under = {key: values[conditions] for key, values in self.condition_numbers.items()}
            shape = rows.stop - rows.start, conditions.stop - conditions.start
            for name, values in vars(find(self.design(part, under), shape)).items():
                if name not in whole:
                    whole[name] = np.empty((count, len(self.conditions)), dtype=values.dtype)
                whole[name][rows, conditions] = values
        return whole

    def _window(self, design: Design, shape: tuple[int, int]) -> Window:
        ends = self._of_states(design, shape)
        found = window.named(ends, design, self.angles, self.flexion, self.bounds)
        if self.bounds.of_motion:
            found = narrowed(found, design, self.angles, self.flexion, self.bounds).window
        return window.as_read(found, design)

    def _ends(self, design: Design, shape: tuple[int, int]) -> Ends:
        return window.as_read(self._of_states(design, shape), design)

    def _of_states(self, design: Design, shape: tuple[int, int]) -> Ends:
        found, states = window.begin(shape), (*shape, self.flexion.size, self.angles.size)
        kernel.fold_window(found, Situation.of(design, self.angles, self.flexion), self.bounds, states)
        ends = window.finished(found, design, self.bounds)
        return between.refined(ends, design, self.angles, self.flexion, self.bounds, self._may_bind(ends, design))

    def _may_bind(self, ends: Ends, design: Design) -> Flags:
        """Which windows, (choices, conditions), may set those of their choices, whichever angles lie between."""
        if design.read != F0:  # whose order may be another one
            return np.ones(ends.low.shape, dtype=np.bool_)
        if self.enough < 1.0:  # any may: a share is counted over the angles of the grid
            return np.zeros(ends.low.shape, dtype=np.bool_)
        low, high = ends.low.max(axis=1, keepdims=True), ends.high.min(axis=1, keepdims=True)
        with np.errstate(invalid="ignore"):
            return np.asarray((ends.low >= low - _NEAR * (1.0 + low)) | (ends.high <= high + _NEAR * (1.0 + high)))

    def heed(self) -> None:
        """Raises Stopped where that is asked for."""
        if self.stop.is_set():
            raise Stopped

    def chunks(self, count: int) -> Iterator[tuple[slice, slice]]:
        """Choices and conditions that are worked out together: several of both, for what depends on one of these alone.

        Raises Stopped between them where that is asked for.
        """
        under = len(self.conditions)
        designs = max(1, _STATES_AT_ONCE // self.states_per_design // (_MOTOR_IN_NUMPY if self.bounds.of_motion else 1))
        beside = min(under, max(1, designs // min(count, 2 * math.isqrt(designs))))
        step = max(1, designs // beside)
        for condition in range(0, under, beside):
            for at in range(0, count, step):
                self.heed()
                yield slice(at, min(at + step, count)), slice(condition, min(condition + beside, under))
