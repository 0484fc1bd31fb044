"""A design question: choices and conditions of a study, its limits and goals, and its designs."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, Self, cast

import numpy as np

from tendon_cli import say
from tendon_cli.engine.plan import bounds_of
from tendon_cli.engine.windows.groups import Groups
from tendon_cli.engine.windows.points import Points
from tendon_cli.errors import UsageError
from tendon_cli.model import whole_motion
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import F0, READINGS, Design
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.limits import LIMITS
from tendon_cli.model.sliding import BOTH_DIRECTIONS
from tendon_cli.studies.answer_draws import for_answer
from tendon_cli.studies.checks import check_set_once, check_shares_are_counted
from tendon_cli.studies.space.axis import (
    DRAW_AXIS,
    LIMIT,
    PERSON_AXIS,
    PRETENSION,
    READ,
    READING_ERROR,
    Axis,
    Numbers,
    overlay,
    split_side,
)
from tendon_cli.studies.space.space import Space
from tendon_cli.studies.spaces import check_reading, space_of, wearer_axis
from tendon_cli.studies.study import Study, states_reading
from tendon_cli.studies.values import StudyNumber
from tendon_cli.units import shorten

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
CONTACT_FROM = "arm.contact_from"
"""The strap presses at every angle of the smallest value: that suffices for all."""
_ENDS_SUFFICE = (*LINEAR, LEAN, PRETENSION, CONTACT_FROM)

EQUAL = 1e-9
"""Relative difference up to which values that are equal but for rounding are a tie."""
_TIE_OF_SAMPLES = 0.01
"""Relative difference up to which values of samples are a tie."""
_OF_SEARCH = 50
"""Factor on the time of a state whose window is sought pretension by pretension."""


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
    Goal("tolerance_length", maximise=True),
    Goal("pretension", maximise=False),
    Goal("max_tension", maximise=False),
    Goal("max_spring_extension", maximise=False),
    Goal("peak_motor_torque", maximise=False),
)
"""An answer names the best choice by each of these, too, if the study names no goal."""
SERVED = Goal("served", maximise=True)
"""The largest share served; it comes before the usual goals if there are people or draws."""


def goals_of(study: Study) -> tuple[Goal, ...]:
    """Return the goals of a study in its order; none if it leaves them open."""
    smallest = tuple(Goal(column, maximise=False) for column in study.design.minimise)
    largest = tuple(Goal(column, maximise=True) for column in study.design.maximise)
    return (*smallest, *largest)


_STATES_WITH_MOTION = 2**20
"""Most states of choices with columns of motion, which take far longer than the other columns."""

Place = Literal["least", "reserve", "middle"]
"""Point of a window of pretension."""


@dataclass(frozen=True)
class Placement:
    """Pretension at which choices are set: a point of each one's window, or given for all."""

    point: Place = "reserve"
    """Point of the window: its lower end, this end and a reserve for how well a suit can be set, or
    its middle."""
    given: float | None = None
    """Pretension of every choice, N, if the question gives one; windows are solved nevertheless."""
    given_as_f0: bool = False
    """True if the given pretension is F0 of the study's own arm, whatever gauge the answer has."""

    def within(self, low: Array, high: Array, reserve: Array) -> Array:
        """Return the pretension of this point of windows, N.

        A reserve does not reach beyond the middle. If nothing bounds a window above, it has no
        middle, and twice the lower end is taken for it where the study asks for the middle.

        Args:
            low: Lower ends, (choices,), N.
            high: Upper ends; infinite if nothing bounds a window above.
            reserve: Tension that the accuracy of setting is worth, N.
        """
        if self.point == "least":
            return low
        if self.point == "middle":
            return np.where(np.isinf(high), 2.0 * low, 0.5 * (low + high))
        return np.minimum(low + reserve, 0.5 * (low + high))


@dataclass(frozen=True)
class OwnSample:
    """Weight of a question's own sample of persons and draws in what is decided."""

    enough: float = 1.0
    """Share of the sample by which a window counts as serving so many: that which is asked for, or
    more where the sample is small and chooses among many."""
    sets_by_sample: bool = False
    """True if the best choices are solved again, and set, by a second and larger sample."""
    tie: float = EQUAL
    """Relative difference up to which the goals of two choices are a tie."""
    shows_own_f0: bool = False
    """True if the gauge is the answer's own: columns of pretension have F0 of the study's arm."""


@dataclass(frozen=True, eq=False)
class Question:
    """A design question: its choices, the conditions that they must cope with, and its limits."""

    study: Study
    choices: Space
    conditions: Space
    bounds: Bounds
    """Limits with the speed of the elbow; of a limit that differs between choices all values."""
    goals: tuple[Goal, ...] = ()
    """Goals of the study in their order; none if it leaves them open."""
    serve: float = 1.0
    """Share of persons or draws that a window must serve; 1 if there are neither."""
    sample: OwnSample = OwnSample()
    """Weight of the question's own sample in what is decided."""
    stated: Study | None = None
    """The study as its author states it, without what an answer draws; None for `study`."""
    placement: Placement = Placement()
    arm: Numbers = field(default_factory=dict)
    """Numbers of the conditions that hold where a suit is set, (1,) each."""

    @property
    def ranking(self) -> tuple[Goal, ...]:
        """Goals of the study, or if it leaves them open the usual ones."""
        usual = USUAL if self.conditions.groups is None else (SERVED, *USUAL)
        return self.goals or usual

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
        """True where a direction is flexion, (D, 1).

        Along a trajectory these are both directions in which tendons may slide.
        """
        return BOTH_DIRECTIONS if self.study.trajectory is not None else self.study.flexion

    @property
    def states_per_design(self) -> int:
        """Number of directions times number of elbow angles."""
        return self.angles.size * len(self.flexion)

    @property
    def states(self) -> int:
        """Number of states of all choices under all conditions."""
        return len(self.choices) * len(self.conditions) * self.states_per_design

    @cached_property
    def axes(self) -> dict[str, Axis]:
        """Axes of the conditions by their keys."""
        return {axis.key: axis for axis in self.conditions.axes}

    @cached_property
    def condition_numbers(self) -> Numbers:
        """Numbers that all conditions set, (conditions,) each."""
        return self.conditions.numbers(np.arange(len(self.conditions)))

    @cached_property
    def groups(self) -> Groups:
        """Groups of the conditions, such as persons."""
        return Groups.of_conditions(self.conditions, self._counts)

    @property
    def _counts(self) -> dict[str, int]:
        """Numbers of persons and of draws by the keys of their axes."""
        counts = {PERSON_AXIS: len(self.axes[PERSON_AXIS])} if PERSON_AXIS in self.axes else {}
        drawn = [axis for axis in self.axes.values() if axis.role == "draw"]
        draws = [len(axis) for axis in drawn if axis.key != PERSON_AXIS]
        if draws:
            counts[DRAW_AXIS] = math.prod(draws)
        people = self.study.people
        bodies = people.population.completions if people is not None else 1
        if PERSON_AXIS in counts and bodies > 1:
            return {
                PERSON_AXIS: counts[PERSON_AXIS] // bodies,
                DRAW_AXIS: counts.get(DRAW_AXIS, 1) * bodies,
            }
        return counts

    # --- Other questions --------------------------------------------------------------------------

    def for_conditions(self, conditions: Rows) -> Self:
        """Return this question for some of its conditions, each of which then counts by itself."""
        numbers = select_numbers(self.condition_numbers, conditions)
        points = Axis.of_points(numbers, len(conditions))
        return replace(self, conditions=Space((points,)))

    def within_groups(self, conditions: Rows) -> Self:
        """Return this question for some conditions of groups, each of which needs only these.

        Args:
            conditions: Rows of the conditions, ascending.
        """
        selected = self.groups.within(conditions)
        few = replace(
            self.for_conditions(conditions).conditions,
            weighting=selected.weighting[selected.of],
            groups=selected.of,
        )
        return replace(self, conditions=few)

    def with_numbers(self, numbers: Numbers) -> Self:
        """Return this question with other or further numbers set by its conditions."""
        points = Axis.of_points({**self.condition_numbers, **numbers}, len(self.conditions))
        return replace(self, conditions=replace(self.conditions, axes=(points,)))

    def for_choice(self, points: Points) -> Self:
        """Return this question with the limits of one choice as those that all choices share.

        Limits that conditions set stay as they are.
        """
        space = self.choices.at(points.numbers)
        bounds = self.bounds
        for name, limit in space.limits.items():
            if f"{LIMIT}{name}" not in self.condition_numbers:
                value = np.asarray(limit.within(space.whole)).item()
                bounds = bounds.changed(name, LIMITS[name].bound_of(value).item())
        return replace(self, bounds=bounds)

    # --- Designs ----------------------------------------------------------------------------------

    def points(self, rows: Rows) -> Points:
        """Return the choices in some rows of the grid."""
        return Points.of_rows(self.choices, rows)

    def all_points(self) -> Points:
        """Return all choices of the grid."""
        return self.points(np.arange(len(self.choices)))

    def designs(self, points: Points, conditions: Numbers | None = None) -> Design:
        """Return the designs of some choices under conditions, as they vary.

        A number of a condition takes precedence over that of a choice.

        Args:
            points: The choices.
            conditions: Numbers of the conditions, (conditions,) each; all conditions by default.

        Returns:
            Designs that broadcast to (choices, conditions, 1, 1).
        """
        under = self.condition_numbers if conditions is None else conditions
        return self.choices.at(points.numbers, under).design()

    def paired_designs(
        self, points: Points, rows: Rows, conditions: Rows, above: Numbers | None = None
    ) -> Design:
        """Return the designs of choices, each under one condition, (pairs, 1, 1).

        Args:
            points: The choices.
            rows: Choice of each pair, as a place in `points`.
            conditions: Condition of each pair.
            above: Numbers of the pairs that take precedence over those of both.
        """
        of_conditions = select_numbers(self.condition_numbers, conditions)
        of_choices = select_numbers(points.numbers, rows)
        of_pairs = overlay(of_choices, {**of_conditions, **(above or {})})
        pairs = Axis.of_points(of_pairs, len(rows))
        return Space((pairs,), self.choices.single).design()

    # --- Intervals --------------------------------------------------------------------------------

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
        return bool(self.bounds.asks_power or self.sampled_intervals or self.study.trajectory)

    @property
    def loads(self) -> tuple[float, float] | None:
        """Smallest and largest load, kg; None if no axis of the conditions is the load."""
        axis = self.axes.get("load.mass")
        return None if axis is None else (float(axis.values.min()), float(axis.values.max()))

    @property
    def is_f0(self) -> bool:
        """True if pretensions are those of the model, F0, and not readings of a gauge."""
        has_errors = any(READING_ERROR in axis.numbers for axis in self.conditions.axes)
        return READINGS[int(self.choices.single.get(READ, 0.0))] == F0 and not has_errors


def of_second_sample(question: Question) -> Question:
    """Return a question about choices that the second sample has solved and set."""
    if not question.sample.sets_by_sample:
        return question
    sample = replace(question.sample, enough=question.serve, tie=_TIE_OF_SAMPLES)
    return replace(question, sample=sample)


def with_enough(question: Question, enough: float) -> Question:
    """Return a question in which another share of its own sample is enough."""
    return replace(question, sample=replace(question.sample, enough=enough))


def group_axis(question: Question) -> Axis | None:
    """Return the axis of persons or, without persons, of draws or drawn rows; None without one."""
    drawn = (axis for axis in question.conditions.axes if axis.role == "draw")
    return next(drawn, None)


def column_read(question: Question) -> str:
    """Return the gauge whose readings columns of pretension have."""
    return F0 if question.sample.shows_own_f0 else question.study.setting.read


def select_numbers(numbers: Numbers, rows: Rows | slice) -> dict[str, Array]:
    """Select some rows of every number, such as some choices or conditions."""
    return {key: values[rows] for key, values in numbers.items()}


def arm_numbers(study: Study, conditions: Space) -> dict[str, Array]:
    """Return the numbers of the conditions that hold where a suit is set, (1,) each.

    Of several values it is the least, of several rows the one with the least numbers, and of
    several cases the first by name, whatever their order in the study. The numbers of a draw are
    left out, and so are those of people, but for the wearer on whom the anchors were measured.
    """
    numbers: dict[str, Array] = {}
    for axis in conditions.axes:
        if axis.role != "draw":
            place = int(np.argmin(axis.rank))
            least = {key: values[place : place + 1] for key, values in axis.numbers.items()}
            numbers = overlay(numbers, least)
    wearer = wearer_axis(study)
    return numbers if wearer is None else overlay(numbers, wearer.numbers)


def question_of(study: Study) -> Question:
    """Return the question that a study asks of `tendon design`.

    Uncertain numbers are drawn whether or not the study has `[uncertainty]`.

    Raises:
        StudyError: It asks for a share, but has neither persons nor draws.
    """
    stated = study
    study = for_answer(study)
    is_drawn = study is not stated
    check_set_once(study)
    check_reading(study)
    check_shares_are_counted(study)
    space = space_of(study).without_pretension()
    pretension = study.design.pretension
    if isinstance(pretension, StudyNumber):
        is_f0 = is_drawn and not states_reading(stated)
        placement = Placement(given=pretension.single, given_as_f0=is_f0)
    else:
        placement = Placement(cast("Place", pretension))
    question = Question(
        study=study,
        choices=space.choices,
        conditions=space.conditions,
        bounds=bounds_of(study, space),
        goals=goals_of(study),
        serve=study.serve,
        placement=placement,
        arm=arm_numbers(study, space.conditions),
        stated=stated,
        sample=OwnSample(study.serve, shows_own_f0=is_drawn and not states_reading(stated)),
    )
    if not is_drawn or not study.design.verify or study.drawn_tables:
        return question
    enough = least_share_for(study.serve, question.groups.effective_count)
    return replace(question, sample=replace(question.sample, enough=enough, sets_by_sample=True))


def least_share_for(serve: float, count: float) -> float:
    """Return the least share of a sample whose 95 % interval lies at `serve` or above.

    It is 1 where the sample is too small to tell: then all of it has to be served.

    Args:
        serve: Share that is wanted.
        count: Effective number of the sample's members.
    """
    members = int(count)
    for served in range(math.ceil(serve * members), members + 1):
        share = served / members
        if say.interval(share, count)[0] >= serve:
            return share
    return 1.0


def rows_to_prove(question: Question) -> Rows:
    """Return the choices that the study names in `[design] prove`, ascending.

    Raises:
        UsageError: The study names something that is no row of the choices.
    """
    count = len(question.choices)
    texts = question.study.design.prove
    for text in texts:
        if not text.isdecimal() or int(text) >= count:
            raise UsageError(
                f'"{shorten(text)}" is not a row of choices.parquet',
                where="--prove",
                hint=f"0 to {count - 1}",
            )
    return np.unique(np.array([int(text) for text in texts], dtype=np.int64))


def is_sought(question: Question) -> bool:
    """Return True if windows are sought pretension by pretension, which takes far longer.

    So it is with a limit on power, and along a motion in time.
    """
    return question.bounds.asks_power or question.study.trajectory is not None


def affords_motion(question: Question, choices: int) -> bool:
    """Return True if so many choices have columns of motion although no goal names one."""
    states = choices * len(question.conditions) * question.states_per_design
    return question.study.trajectory is not None or states <= _STATES_WITH_MOTION


def cost_per_design(question: Question) -> int:
    """Return the number of states whose windows take as long as the window of one design."""
    factor = _OF_SEARCH if is_sought(question) else 1
    return question.states_per_design * factor
