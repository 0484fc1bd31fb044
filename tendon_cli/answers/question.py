"""A design question: a study's choices and conditions, its limits, and how windows over them are worked out."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.answers.coverage import grouped, share_served
from tendon_cli.answers.front import SERVED, USUAL, Goal, goals_of
from tendon_cli.engine.plan import bounds_of
from tendon_cli.errors import Stopped
from tendon_cli.model import between, window
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import F0, READINGS, Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.motor_window import narrowed
from tendon_cli.model.window import Ends, Window
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, PRETENSION, READ, Axis, Numbers, Rows, over, split_side
from tendon_cli.space.space import Space
from tendon_cli.studies.axes import space_of
from tendon_cli.studies.contents import case_numbers
from tendon_cli.studies.study import Study
from tendon_cli.studies.values import Values

Flags = npt.NDArray[np.bool_]
Columns = dict[str, npt.NDArray[Any]]

_STATES_AT_ONCE = 2**21  # so that the model's arrays stay within a few megabytes each
_MOTOR_IN_NUMPY = 8  # by how much fewer are at once with limits on the motor, of which all states have arrays
_REFINED_AT_ONCE = 2**12
LINEAR = (
    "load.mass", "load.scale", "arm.forearm_mass", "arm.forearm_com", "arm.load_distance", "joint.stiffness",
    "joint.rest_angle",
)  # fmt: skip
"""Every limit on states is linear in each of these, so that what suits both ends suits all between."""
LOADS = LINEAR[:2]
"""Of these a list is meant with all between; of others that hold an interval alone is."""
LEAN = "arm.upper_arm_angle"
"""And linear in sine and cosine of this."""
_ENDS_SUFFICE = (*LINEAR, LEAN, PRETENSION)
_SEVERAL = {"peak_motor_power", "max_motor_work_in", "max_friction_loss", "min_efficiency"}


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
    near: float = 0.01
    """The share within which ends of conditions are sought between the angles, which may set those of their choice; the
    grid is off by a thousandth. Below 0 none is, and with infinity every one."""
    notes: tuple[str, ...] = ()
    """What was left out of the question, and why."""
    stop: threading.Event = field(default_factory=threading.Event)
    """Set when whoever asked wants no answer any more."""

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
        return between.grid(self.study.angles)

    @property
    def flexion(self) -> Flags:
        """Whether each direction is flexion, (D, 1), or each sample of a trajectory, (1, K)."""
        return self.study.flexion

    @property
    def states_per_design(self) -> int:
        """Directions times elbow angles."""
        return self.angles.size * len(self.flexion)

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
        numbers = _taken(self.condition_numbers, conditions)
        return replace(self, conditions=Space((Axis.of_points(numbers, len(conditions)),)))

    def of_groups(self, chosen: Rows) -> Problem:
        """The same question for some of those who count together, ascending."""
        rows = np.flatnonzero(np.isin(self.groups, chosen))
        space = self.under(rows).conditions
        weighting, groups = self.weighting[self.groups[rows]], np.searchsorted(chosen, self.groups[rows])
        return replace(self, conditions=replace(space, weighting=weighting, groups=groups))

    def saying(self, numbers: Numbers) -> Problem:
        """The same question where its conditions say something else, or more, of the study's numbers."""
        rows = Axis.of_points({**self.condition_numbers, **numbers}, len(self.conditions))
        return replace(self, conditions=replace(self.conditions, axes=(rows,)))

    def bounded(self, name: str, value: float) -> Problem:
        """The same question with another value of one limit, or of the speed."""
        return replace(self, bounds=self.bounds.changed(name, value))

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

    @property
    def one_by_one(self) -> Axis | None:
        """The axis of persons, or if there are none of draws; None if there are neither."""
        axes = {axis.key: axis for axis in self.conditions.axes}
        return axes.get(PERSON_AXIS) or axes.get(DRAW_AXIS)

    def numbers_of(self, columns: Columns) -> Numbers:
        """What choices, given by their columns, say of the study's numbers."""
        numbers: dict[str, Array] = {}
        for axis in self.choices.axes:
            values = columns[axis.column]
            numbers |= {key: each[values] for key, each in axis.numbers.items()} if axis.names else {axis.key: values}
        return numbers

    def design(self, numbers: Numbers, conditions: Numbers | None = None, pretension: Array | None = None) -> Design:
        """Designs (choices, conditions, 1, 1) of some choices under all conditions, or those given, as they vary.

        A condition says more than a choice. `pretension` has the shape (choices,).
        """
        at = numbers if pretension is None else {**numbers, PRETENSION: pretension}
        return self.points(at, self.condition_numbers if conditions is None else conditions).design()

    def points(self, numbers: Numbers, under: Numbers) -> Space:
        """Every choice of some under every condition of some, by what these say of the study's numbers."""
        return Space((Axis.of_points(numbers), Axis.of_points(under)), self.choices.single)

    def paired(self, numbers: Numbers, rows: Rows, condition: Rows, above: Numbers | None = None) -> Design:
        """Designs (pairs, 1, 1) of choices, each under one condition, and by what is said above these."""
        under = {**_taken(self.condition_numbers, condition), **(above or {})}
        points = Axis.of_points(over(_taken(numbers, rows), under), len(rows))
        return Space((points,), self.choices.single).design()

    @cached_property
    def box(self) -> tuple[Axis, ...]:
        """Intervals that proofs hold for as a box; of the others those in which limits are not linear are sampled."""
        provable = self._is_f0 and self.study.trajectory is None
        return tuple(axis for axis in self._curved if provable and not axis.key.startswith("setting."))

    @property
    def _curved(self) -> list[Axis]:
        """Intervals in which limits are not linear."""
        return [
            axis for axis in self.conditions.axes if axis.is_interval and split_side(axis.key)[0] not in _ENDS_SUFFICE
        ]

    @property
    def sampled_intervals(self) -> tuple[str, ...]:
        """The keys of those that are solved at their ends alone."""
        return tuple(axis.key for axis in self._curved if axis not in self.box)

    @property
    def is_sampled(self) -> bool:
        """Whether something that is asked has no proof."""
        return bool(self.bounds.of_motion or self.sampled_intervals or self.study.trajectory)

    @property
    def loads(self) -> tuple[float, float] | None:
        """The least and the largest load, kg, if there are several."""
        masses = [axis.values for axis in self.conditions.axes if axis.key == "load.mass"]
        return (float(masses[0].min()), float(masses[0].max())) if masses else None

    def windows(self, numbers: Numbers, count: int) -> Window:
        """The windows of `count` choices, (choices, conditions), with the limits that bind."""
        return cast("Window", self.ends(numbers, count, named=True))

    def ends(self, numbers: Numbers, count: int, *, named: bool = False) -> Ends:
        """The same in half the time: windows where naming the limits costs nothing, else their ends alone."""
        return self.finished(self.ends_over_angles(numbers, count), numbers, named=named)

    def finished(self, ends: Ends, numbers: Numbers, *, named: bool = False) -> Ends:
        """Ends within all limits and as they are read, of those that limits on states set as F0."""
        of_motion, whole, shape = bool(self.bounds.of_motion), dict[str, Any](), ends.low.shape
        named = named or of_motion or kernel.kind() is None
        if not named and self._is_f0:
            return ends
        for rows, conditions, design in self.chunks(numbers, len(ends.low)):
            each = Ends(**{name: values[rows, conditions] for name, values in vars(ends).items()})
            if named:
                each = window.named(each, design, self.angles, self.flexion, self.bounds)
            if of_motion:
                window_of = cast("Window", each)
                each = narrowed(window_of, design, self.angles, self.flexion, self.bounds, self.loads).window
            for name, values in vars(window.as_read(each, design)).items():
                whole.setdefault(name, np.empty(shape, dtype=values.dtype))[rows, conditions] = values
        return Window(**whole) if named else Ends(**whole)

    @property
    def _is_f0(self) -> bool:
        return READINGS[int(self.choices.single.get(READ, 0.0))] == F0

    def ends_over_angles(self, numbers: Numbers, count: int) -> Ends:
        """Ends that limits on states set, (choices, conditions), as F0; those that may matter are of all angles."""
        whole: dict[str, Any] = {}
        for rows, conditions, design in self.chunks(numbers, count):
            shape = rows.stop - rows.start, conditions.stop - conditions.start
            found, states = window.begin(shape), (*shape, len(self.flexion), self.angles.size)
            kernel.fold_window(found, State.of(design, self.angles, self.flexion), self.bounds, states)
            for name, values in vars(window.finished(found, design, self.bounds)).items():
                every = whole.setdefault(name, np.empty((count, len(self.conditions)), dtype=values.dtype))
                every[rows, conditions] = values
        ends = Ends(**whole)
        for name, chosen in zip(("low", "high"), self._may_bind(ends), strict=True):
            value, state, angle = (getattr(ends, f"{name}{of}") for of in ("", "_state", "_angle"))
            at = np.nonzero(chosen & (state >= 0) & np.isfinite(ends.low) & (self.angles.size > 1))
            for step in range(0, len(at[0]), _REFINED_AT_ONCE):
                self.heed()
                some = at[0][step : step + _REFINED_AT_ONCE], at[1][step : step + _REFINED_AT_ONCE]
                of_some = self.paired(numbers, *some), state[some], value[some], self.angles.ravel()
                tightest = between.refined(*of_some, self.flexion, self.bounds, upper=name == "high")
                value[some], state[some], angle[some] = tightest
        return ends

    def _may_bind(self, ends: Ends) -> tuple[Flags, Flags]:
        """Which lower and upper ends, (choices, conditions), may set those of their choices, whichever angles bind."""
        if self.study.trajectory is not None:
            return (np.zeros(ends.low.shape, dtype=np.bool_),) * 2
        if not 0.0 < self.near < np.inf or not self._is_f0:  # the order of readings may be another one
            return (np.full(ends.low.shape, self.near > 0.0),) * 2
        low, high = [ends.low.max(axis=1)], [ends.high.min(axis=1)]
        if self.enough < 1.0:
            of_groups = grouped(ends.low, ends.high, self.groups)
            covered = share_served(*of_groups, self.weighting, enough=self.enough)
            low, high = [*low, covered.low, covered.best_low], [*high, covered.high, covered.best_high]
        return _near(ends.low, low, self.near), _near(ends.high, high, self.near)

    def heed(self) -> None:
        """Raises Stopped if nobody wants an answer any more."""
        if self.stop.is_set():
            raise Stopped

    def chunks(
        self, numbers: Numbers, count: int, pretension: Array | None = None
    ) -> Iterator[tuple[slice, slice, Design]]:
        """Choices and conditions that are worked out together, and their designs: several of both.

        So what depends on one of these alone is worked out once. Raises Stopped between them if that is asked for.
        """
        under = len(self.conditions)
        most = max(1, _STATES_AT_ONCE // self.states_per_design // (_MOTOR_IN_NUMPY if self.bounds.of_motion else 1))
        width = min(under, max(1, most // min(count, 2 * math.isqrt(most))))
        step = max(1, most // width)
        at = {**numbers, **({} if pretension is None else {PRETENSION: pretension})}
        for condition in range(0, under, width):
            conditions = slice(condition, min(condition + width, under))
            for row in range(0, count, step):
                self.heed()
                rows = slice(row, min(row + step, count))
                yield rows, conditions, self.design(_taken(at, rows), _taken(self.condition_numbers, conditions))


def _taken(numbers: Numbers, rows: Rows | slice) -> dict[str, Array]:
    return {key: values[rows] for key, values in numbers.items()}


def _near(ends: Array, of: list[Array], share: float) -> Flags:
    """Which ends lie so near to one of some of their choices that other angles may make them this."""
    near = np.zeros(ends.shape, dtype=np.bool_)
    with np.errstate(invalid="ignore"):
        for each in of:
            near |= np.abs(ends - each[:, np.newaxis]) <= share * (1.0 + np.abs(each))[:, np.newaxis]
    return near


def question(study: Study) -> Problem:
    """What a study asks of `tendon design`."""
    space = space_of(study).unset()
    problem = Problem(
        study=study,
        choices=space.choices,
        conditions=space.conditions,
        bounds=bounds_of(study),
        enough=study.serve,
        middle=study.design.pretension == "middle",
        given=study.design.pretension.single if isinstance(study.design.pretension, Values) else None,
    )
    return replace(problem, notes=(*study.warnings, *_left_out(problem)))


def _left_out(problem: Problem) -> Iterator[str]:
    """What the study says of pretension, which is solved for; what is assumed of persons; what is not drawn."""
    study = problem.study
    given = [key for key in study.numbers if split_side(key)[0] == PRETENSION]
    if any(split_side(key)[1] for key in given):
        yield "the study's pretensions per side are left out: one of both sides is solved for"
    if any(study.numbers[key].is_axis for key in given):
        yield "the study's values of pretension are left out: the window is solved exactly, without them"
    if any(split_side(key)[0] == PRETENSION for case in study.cases for key in case_numbers(case)):
        yield "the pretensions of the study's cases are left out: one of all is solved for"
    if ends := problem.sampled_intervals:
        yield f"{', '.join(ends)}: solved at both ends of the interval; what lies between is not proved"
    if several := [name for name in study.limits if name in _SEVERAL]:
        yield f"{', '.join(several)}: where several intervals of pretension keep to this, the widest is used"
    if study.people is not None and study.people.content is None:
        yield from study.people.population.notes
    if study.uncertain and study.uncertainty is None:
        yield "uncertain numbers stand at their middle; [uncertainty] draws them"
    if study.uncertainty is not None and not study.uncertain:
        yield "nothing in this study is uncertain, so that [uncertainty] draws nothing"
