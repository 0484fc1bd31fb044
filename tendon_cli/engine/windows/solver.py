"""Ends, windows and worst values of choices under conditions, in portions that fit into memory."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self, TypeAlias, cast

import numpy as np

from tendon_cli import kernel
from tendon_cli.engine.plan import Block, columns_of_motion
from tendon_cli.engine.window_fold import fold_ends, named_ends
from tendon_cli.engine.windows.coverage import upper_quantile
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import Question, select_numbers
from tendon_cli.engine.windows.worst import QUANTITIES, Worst
from tendon_cli.errors import Stopped
from tendon_cli.model import extremes, whole_motion, window
from tendon_cli.model.actuator import State
from tendon_cli.model.design import MOTOR_TORQUE, Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import CONTACT_PRESSURE, contact_pressure
from tendon_cli.model.motor import cycle_columns
from tendon_cli.model.moving import Moving, motion_columns
from tendon_cli.model.setting import Reading
from tendon_cli.model.window import Ends, Window

_STATES_AT_ONCE = 2**21
"""States in one portion, so that each array of the model stays within a few megabytes."""
_MOTOR_IN_NUMPY = 64
"""Factor by which a portion is smaller for power and a whole motion, so that NumPy's arrays of all
states stay in the cache."""
_MOTION_IN_NUMPY = 128
"""Factor by which a portion is smaller along a trajectory, of which NumPy has all states."""
_SAME_ANGLE = 1e-12
"""Distance within which two angles are the same but for rounding, rad."""
_REFINED_AT_ONCE = 2**12
"""Ends that are sought between the angles together."""
NEAR = 0.01
"""Relative distance from the end of a choice's window within which an end under one condition may
set the end of the choice: an end over the grid of angles is off by a thousandth."""
Portion: TypeAlias = tuple[slice, slice]
"""Choices and conditions that are worked out together."""


@dataclass(frozen=True, eq=False)
class Folded:
    """Ends of windows from states, (choices, conditions) each: as F0, and how these are read."""

    ends: Ends
    """Ends that limits on forms set, as F0; along a trajectory a `Window` of all limits."""
    low_between: Flags
    """True for lower ends that may lie between the samples, and are not sought there yet."""
    high_between: Flags
    """The same for upper ends."""
    reading: Reading | None
    """Reading of the gauge; None if pretensions are F0."""

    def as_read(self) -> Ends:
        """Return the ends as the gauge shows them."""
        return self.ends if self.reading is None else window.read_by(self.ends, self.reading)


@dataclass(frozen=True, eq=False)
class Solver:
    """Solver of a question: ends and windows of its choices, and the worst at a pretension.

    Limits on forms of states set the ends of a window, as F0, in states at the elbow angles of the
    question and, over all angles, between these. A limit on power narrows them, and then they are
    turned into readings of the gauge that the study names.
    """

    question: Question
    stop: threading.Event = field(default_factory=threading.Event)
    """Event that cancels the run."""
    with_motion: bool = False
    """True to work out the columns of motion with the worst values; else only those of goals."""
    seeks: bool = True
    """False to leave ends as they are at the elbow angles of the question, as a sweep has them."""

    @property
    def columns_of_motion(self) -> tuple[str, ...]:
        """Columns of motion that are worked out with the worst values."""
        columns = columns_of_motion(self.question.study)
        if self.with_motion:
            return columns
        goals = [goal.column for goal in self.question.goals]
        return tuple(name for name in columns if name in goals)

    def for_question(self, question: Question) -> Self:
        """Return the solver of another question in the same run."""
        return replace(self, question=question)

    # --- Ends and windows -------------------------------------------------------------------------

    def ends(self, points: Points, at: Array | None = None) -> Ends:
        """Return the ends of windows, (choices, conditions), as they are read.

        Those that may set the window of their choice hold over all angles, others at samples alone.

        Args:
            points: The choices.
            at: Pretensions, (choices,), near which all ends hold over all angles, too.
        """
        folded = self.fold(points)
        self.seek(folded, points, at)
        return self.read(folded, points)

    def windows(self, points: Points) -> Window:
        """Return windows with the limits that bind, (choices, conditions).

        As they are read, they hold over all angles under each condition.
        """
        folded = self.fold(points)
        if self.question.is_f0:
            self.seek(folded, points)
        else:
            self.seek_everywhere(folded, points)
        return cast("Window", self.read(folded, points, named=True))

    def fold(self, points: Points) -> Folded:
        """Fold the states of choices under all conditions, at the samples.

        These are the angles of the question, one just inward of the first and the last, and those
        from which on a strap presses.
        """
        question = self.question
        angles = question.angles
        has_between = self.seeks and question.study.trajectory is None and angles.size > 2
        sampled = whole_motion.with_edges(angles) if has_between else angles

        asks_pressure = CONTACT_PRESSURE in (limit.name for limit in question.bounds.asked)

        def fold_portion(design: Design, here: Portion) -> dict[str, Any]:
            shape = tuple(part.stop - part.start for part in here)
            ends = fold_ends(design, shape, sampled, question.flexion, question.bounds)
            low_between = np.zeros(shape, dtype=np.bool_)
            high_between = low_between
            if has_between:
                has_end = np.isfinite(ends.low)
                low_is_inner = whole_motion.without_edges(ends.low_state, angles)
                high_is_inner = whole_motion.without_edges(ends.high_state, angles)
                low_between = low_is_inner & (ends.low_state >= 0) & has_end
                high_between = high_is_inner & (ends.high_state >= 0) & has_end
                if asks_pressure:
                    low_begins, high_begins = self._tighten_at_contact(ends, design)
                    low_between |= low_begins
                    high_between |= high_begins
            reading: dict[str, Array] = {}
            if not question.is_f0:
                reading = vars(Reading.of(design))
            return {
                **vars(ends),
                "low_between": low_between,
                "high_between": high_between,
                **{name: window.drop_state_axes(values) for name, values in reading.items()},
            }

        columns = self._of_portions(points, fold_portion)

        def taken(kind: type[Any]) -> Any:
            return kind(**{one.name: columns[one.name] for one in fields(kind)})

        return Folded(
            ends=taken(Window if "low_by" in columns else Ends),
            low_between=columns["low_between"],
            high_between=columns["high_between"],
            reading=None if question.is_f0 else taken(Reading),
        )

    def read(self, folded: Folded, points: Points, *, named: bool = False) -> Ends:
        """Return ends of all limits as they are read, (choices, conditions).

        Args:
            folded: Ends of limits on forms, at samples or over all angles.
            points: The choices.
            named: True for a `Window`, with the limits that bind.
        """
        question = self.question
        is_along = question.study.trajectory is not None  # ends have all limits already
        if is_along or not (named or question.bounds.asks_power):
            return folded.as_read()

        def name_portion(design: Design, here: Portion) -> dict[str, Any]:
            ends = Ends(**{name: values[here] for name, values in vars(folded.ends).items()})
            motion = question.angles, question.flexion, question.bounds
            return vars(named_ends(ends, design, *motion, question.loads))

        named_columns = self._of_portions(points, name_portion)
        return replace(folded, ends=Window(**named_columns)).as_read()

    def _of_portions(
        self, points: Points, compute: Callable[[Design, Portion], Mapping[str, Any]]
    ) -> dict[str, Any]:
        """Return arrays of all choices and conditions from those of portions, by name.

        Args:
            points: The choices.
            compute: Returns the arrays of a portion.
        """
        whole: dict[str, Any] = {}
        for rows, conditions, design in self.portions(points):
            for name, values in compute(design, (rows, conditions)).items():
                if name not in whole:
                    shape = (len(points), len(self.question.conditions))
                    whole[name] = np.empty(shape, dtype=np.asarray(values).dtype)
                whole[name][rows, conditions] = values
        return whole

    def _tighten_at_contact(self, ends: Ends, design: Design) -> tuple[Flags, Flags]:
        """Tighten ends at the angles from which on the straps of designs press, in place.

        A limit on the strap's pressure begins there at once, and such an angle need not be one of
        the question.

        Args:
            ends: Ends at samples, (choices, conditions), as F0.
            design: The designs.

        Returns:
            True for lower and for upper ends that are tighter there.
        """
        question = self.question
        shape = ends.low.shape
        angles = question.angles.ravel()
        contact = np.atleast_2d(np.clip(design.arm.first_contact, angles[0], angles[-1]))
        distance = np.abs(contact[..., np.newaxis] - angles).min(axis=-1)
        if np.all(distance <= _SAME_ANGLE):
            nowhere = np.zeros(shape, dtype=np.bool_)
            return nowhere, nowhere
        at_contact = fold_ends(design, shape, contact, question.flexion, question.bounds)
        is_bounded = question.bounds.of(design).asks(CONTACT_PRESSURE)
        begins = np.broadcast_to(is_bounded, (*shape, 1, 1))[..., 0, 0]
        of_designs = np.broadcast_to(contact, (*shape, 1, 1))[..., 0, 0]
        place = np.searchsorted(angles, of_designs)  # of the first angle with pressure
        tightened = []
        for name, sign in (("low", 1.0), ("high", -1.0)):
            value = getattr(at_contact, name)
            direction = getattr(at_contact, f"{name}_state")
            is_tighter = begins & (sign * value > sign * getattr(ends, name))
            tightened.append(is_tighter)
            for target, new in (
                (name, value),
                (f"{name}_state", direction * angles.size + place),
                (f"{name}_angle", of_designs),
            ):
                np.copyto(getattr(ends, target), new, where=is_tighter)
        return tightened[0], tightened[1]

    def seek(self, folded: Folded, points: Points, at: Array | None = None) -> None:
        """Replace ends that may set the window of their choice by those over all angles, in place.

        Args:
            folded: Ends at samples.
            points: The choices.
            at: Pretensions, (choices,), near which all ends are sought, too.
        """
        while folded.low_between.any() or folded.high_between.any():
            low_may_bind, high_may_bind = self._may_bind(folded, at)
            low_sought = folded.low_between & low_may_bind
            high_sought = folded.high_between & high_may_bind
            self._seek(folded, points, low_sought, high_sought)
            # Ends that are tighter now may leave it to others to bind.
            if self.question.is_f0 or not (low_sought.any() or high_sought.any()):
                return

    def seek_everywhere(self, folded: Folded, points: Points) -> None:
        """Replace all ends by those over all angles, in place."""
        self._seek(folded, points, folded.low_between.copy(), folded.high_between.copy())

    def _seek(self, folded: Folded, points: Points, low_sought: Flags, high_sought: Flags) -> None:
        """Replace ends by those over all angles, in place.

        Args:
            folded: Ends at samples.
            points: The choices.
            low_sought: True for lower ends that are sought, (choices, conditions).
            high_sought: True for upper ends.
        """
        question = self.question
        ends = folded.ends
        sides = (
            (False, low_sought, ends.low, ends.low_state, ends.low_angle),
            (True, high_sought, ends.high, ends.high_state, ends.high_angle),
        )
        for upper, is_sought, value, state, angle in sides:
            rows, conditions = np.nonzero(is_sought)
            for part in self.cut(len(rows), _REFINED_AT_ONCE):
                pairs = (rows[part], conditions[part])
                value[pairs], state[pairs], found = whole_motion.refine_ends(
                    question.paired_designs(points, *pairs),
                    state[pairs],
                    value[pairs],
                    question.angles.ravel(),
                    question.flexion,
                    question.bounds,
                    upper=upper,
                )
                angle[pairs] = np.where(np.isnan(found), angle[pairs], found)
        folded.low_between[low_sought] = False
        folded.high_between[high_sought] = False

    def _may_bind(self, folded: Folded, at: Array | None) -> tuple[Flags, Flags]:
        """Return True for lower and upper ends that may set the window of their choice.

        They may do so once they are sought between the angles; both are (choices, conditions).

        Args:
            folded: Ends at samples.
            at: Pretensions near which ends count, too, (choices,).
        """
        question = self.question
        is_torque = question.study.setting.read == MOTOR_TORQUE
        if not question.is_f0 and (question.bounds.asks_power or is_torque):
            everywhere = np.ones(folded.ends.low.shape, dtype=np.bool_)
            return everywhere, everywhere
        # Ends as they are read may have another order than as F0, but each grows with its own.
        read = folded.as_read()
        low = [read.low.max(axis=1)]
        high = [read.high.min(axis=1)]
        if question.sample.enough < 1.0:
            of_groups = question.groups.windows(read.low, read.high)
            covered = question.groups.coverage(*of_groups, serve=question.sample.enough)
            low += [covered.low, covered.best_low]
            high += [covered.high, covered.best_high]
        if at is not None:
            low.append(at)
            high.append(at)
        return _near_any(read.low, low), _near_any(read.high, high)

    # --- The worst at a pretension ----------------------------------------------------------------

    def worst(self, points: Points, pretension: Array, served: Flags) -> Worst:
        """Return the worst values of choices over the conditions that they serve.

        Of persons or draws it is the worst of each, and of these the quantile of
        `upper_quantile`: their maximum grows with their number.

        Args:
            points: The choices.
            pretension: Pretensions of the choices, (choices,), N.
            served: Conditions that count, (choices, conditions).

        Returns:
            Worst values; NaN for a choice that serves no condition.
        """
        groups = self.question.groups
        largest = np.full((QUANTITIES, len(points), len(groups)), -np.inf)
        for rows, conditions, values in self._quantities(points, pretension):
            of_served = np.where(served[rows, conditions], values, -np.inf)
            known = np.where(np.isnan(of_served), -np.inf, of_served)
            self._take_largest(largest, rows, conditions, known)
        of_states = Worst.of_quantities(self._over_groups(largest))
        names = self.columns_of_motion
        return replace(of_states, motion=self.worst_of_motion(points, pretension, served, names))

    def _take_largest(self, largest: Array, rows: slice, conditions: slice, values: Array) -> None:
        """Raise the largest value of each group, (..., choices, groups), to those of a portion."""
        of = self.question.groups.of[conditions]
        firsts = np.flatnonzero(np.diff(of, prepend=-1))
        of_portion = np.maximum.reduceat(values, firsts, axis=-1)
        groups = slice(of[0], of[-1] + 1)
        np.maximum(largest[..., rows, groups], of_portion, out=largest[..., rows, groups])

    def _over_groups(self, largest: Array) -> Array:
        """Return the worst over groups, (..., choices), of the worst of each; NaN if none is known.

        Args:
            largest: Largest values of the groups, (..., choices, groups), -infinity if unknown.
        """
        if self.question.conditions.groups is None:
            worst = largest.max(axis=-1)
        else:
            worst = upper_quantile(largest, self.question.groups.weighting)
        return np.where(np.isneginf(worst), np.nan, worst)

    def worst_of_motion(
        self, points: Points, pretension: Array, served: Flags, names: Sequence[str]
    ) -> dict[str, Array]:
        """Return columns of motion by name, each the worst over the conditions served."""
        question = self.question
        trajectory = question.study.trajectory
        if not names:
            return {}
        largest = np.full((len(names), len(points), len(question.groups)), -np.inf)
        signs = np.array([-1.0 if name == "efficiency" else 1.0 for name in names])
        for rows, conditions, design in self.portions(
            points.at_pretension(pretension), in_numpy=True
        ):
            if trajectory is not None:
                columns = motion_columns(Moving.of(design, trajectory))
            else:
                motion = question.angles, question.flexion, float(question.bounds.speed)
                columns = cycle_columns(design, *motion, names)
            shape = (rows.stop - rows.start, conditions.stop - conditions.start)
            values = np.stack([np.broadcast_to(columns[name], shape) for name in names])
            values = signs[:, np.newaxis, np.newaxis] * values
            is_known = served[rows, conditions] & ~np.isnan(values)
            self._take_largest(largest, rows, conditions, np.where(is_known, values, -np.inf))
        worst = signs[:, np.newaxis] * self._over_groups(largest)
        return dict(zip(names, worst, strict=True))

    def quantities_under_each(self, points: Points, pretension: Array, served: Flags) -> Array:
        """Return the quantities of one choice under each condition, (QUANTITIES, conditions).

        They are -infinity under a condition that is not served.
        """
        largest = np.full((QUANTITIES, len(self.question.conditions)), -np.inf)
        for rows, conditions, values in self._quantities(points, pretension):
            counts = served[rows, conditions] & ~np.isnan(values)
            largest[:, conditions] = np.where(counts, values, -np.inf)[:, 0]
        return largest

    def _quantities(
        self, points: Points, pretension: Array
    ) -> Iterator[tuple[slice, slice, Array]]:
        """Yield choices, conditions and their quantities, the larger the worse.

        The quantities, (QUANTITIES, choices, conditions), are the largest over all states of those
        that `Worst.of_quantities` takes.
        """
        flexion = self.question.flexion
        trajectory = self.question.study.trajectory
        for rows, conditions, design in self.portions(points.at_pretension(pretension)):
            shape = (rows.stop - rows.start, conditions.stop - conditions.start)
            values = extremes.begin(shape)
            if trajectory is not None:
                kernel.fold_motion(values, Moving.of(design, trajectory))
            else:
                angles = whole_motion.with_contacts(self.question.angles, design)
                state = State.of(design, angles, flexion)
                states = (*shape, len(flexion), angles.size)
                kernel.fold_extremes(values, state, angles.ravel(), states)
            tension = values["max_strap_tension"][..., np.newaxis, np.newaxis]
            pressure = contact_pressure(design, tension)[..., 0, 0]
            quantities = (
                values["max_tension"],
                values["max_spring_extension"],
                values["highest_motor_torque"],
                -values["lowest_motor_torque"],
                -values["min_elbow_stiffness"],
                np.broadcast_to(pressure, shape),
                -values["min_room"],
            )
            yield rows, conditions, np.stack(quantities)

    # --- Portions ---------------------------------------------------------------------------------

    def portions(
        self, points: Points, *, in_numpy: bool = False
    ) -> Iterator[tuple[slice, slice, Design]]:
        """Yield portions: choices and conditions that are worked out together, and their designs.

        A portion has several of both, so that what depends on one of them alone is worked out once.

        Args:
            points: The choices.
            in_numpy: True for smaller portions, whose states are all in NumPy's arrays.

        Raises:
            Stopped: The run was cancelled.
        """
        question = self.question
        most = _STATES_AT_ONCE // question.states_per_design
        if question.study.trajectory is not None:
            most //= _MOTION_IN_NUMPY
        elif question.bounds.asks_power or in_numpy:
            most //= _MOTOR_IN_NUMPY

        def longer_axis(block: Block) -> int | None:
            choices, conditions = block.shape[:2]
            return None if choices * conditions <= max(1, most) else int(conditions > choices)

        product = slice(0, len(points)), slice(0, len(question.conditions))
        for block in Block(0, product, slice(0, 1), slice(0, 1)).cut(longer_axis):
            self.check_stopped()
            rows, conditions = block.designs
            of_conditions = select_numbers(question.condition_numbers, conditions)
            yield rows, conditions, question.designs(points.select(rows), of_conditions)

    def cut(self, count: int, most: int) -> Iterator[slice]:
        """Yield slices of at most `most` of `count` items.

        Raises:
            Stopped: The run was cancelled.
        """
        for start in range(0, count, most):
            self.check_stopped()
            yield slice(start, min(start + most, count))

    def check_stopped(self) -> None:
        """Raise Stopped if the run was cancelled."""
        if self.stop.is_set():
            raise Stopped


def _near_any(ends: Array, references: list[Array]) -> Flags:
    """Return True where ends, (choices, conditions), lie near any reference, (choices,)."""
    is_near = np.zeros(ends.shape, dtype=np.bool_)
    with np.errstate(invalid="ignore"):
        for reference in references:
            distance = np.abs(ends - reference[:, np.newaxis])
            is_near |= distance <= NEAR * (1.0 + np.abs(reference))[:, np.newaxis]
    return is_near
