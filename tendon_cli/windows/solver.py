"""Ends, windows and worst values of choices under conditions, in portions that fit into memory."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self, cast

import numpy as np

from tendon_cli import kernel
from tendon_cli.engine.plan import columns_of_motion
from tendon_cli.errors import Stopped
from tendon_cli.model import extremes, whole_motion, window
from tendon_cli.model.actuator import State
from tendon_cli.model.design import MOTOR_TORQUE, Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import CONTACT_PRESSURE, contact_pressure
from tendon_cli.model.motion_window import window_along
from tendon_cli.model.motor import cycle_columns
from tendon_cli.model.moving import Moving, motion_columns
from tendon_cli.model.power_window import within_power
from tendon_cli.model.setting import Reading
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.model.window import Ends, Window
from tendon_cli.windows.coverage import upper_quantile
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import Question, select_numbers
from tendon_cli.windows.study_arm import given_pretensions
from tendon_cli.windows.worst import QUANTITIES, Worst

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

    def windows(self, points: Points) -> Window:
        """Return windows with the limits that bind, (choices, conditions).

        As they are read, they hold over all angles under each condition.
        """
        is_f0 = self.question.is_f0
        ends = self.ends_that_may_bind(points) if is_f0 else self.ends_over_all_angles(points)
        return cast("Window", self._all_limits(ends, points, named=True))

    def ends(self, points: Points) -> Ends:
        """Return the ends of windows, (choices, conditions), in half the time of `windows`.

        They are a `Window` if the limits that bind follow without more work.
        """
        reading = self._reading(points)
        ends = self.ends_that_may_bind(points, reading)
        return self.all_limits(ends, points) if reading is None else window.read_by(ends, reading)

    def _reading(self, points: Points) -> Reading | None:
        """Return the gauge's reading of choices under conditions, (choices, conditions) each.

        None where pretensions are F0, or where the limits that bind follow with the ends.
        """
        question = self.question
        if question.is_f0 or self._names_limits or question.study.setting.read == MOTOR_TORQUE:
            return None
        shape = (len(points), len(question.conditions))
        whole = Reading(*(np.empty(shape) for _ in range(4)))
        for rows, conditions, design in self.portions(points):
            for name, values in vars(Reading.of(design)).items():
                of_designs = np.asarray(values)
                if of_designs.ndim > 2:
                    of_designs = of_designs[..., 0, 0]
                getattr(whole, name)[rows, conditions] = of_designs
        return whole

    @property
    def _names_limits(self) -> bool:
        """True if ends of all limits are a `Window`, with the limits that bind."""
        bounds = self.question.bounds
        is_along = self.question.study.trajectory is not None
        return is_along or bounds.asks_power or kernel.kind() is None

    def all_limits(self, ends: Ends, points: Points) -> Ends:
        """Turn ends that limits on forms set, as F0, into ends of all limits, as they are read.

        Args:
            ends: Ends of windows, (choices, conditions), at samples or over all angles.
            points: The choices.
        """
        return self._all_limits(ends, points, named=False)

    def _all_limits(self, ends: Ends, points: Points, *, named: bool) -> Ends:
        """Turn ends as F0 into ends of all limits, as a `Window` if `named` or at no cost."""
        question = self.question
        is_along = question.study.trajectory is not None  # ends have all limits already
        asks_power = question.bounds.asks_power and not is_along
        named = named or self._names_limits
        if question.is_f0 and (is_along or not named):
            return ends
        finished: dict[str, Any] = {}
        kind = Window if is_along else Ends
        for rows, conditions, design in self.portions(points):
            part = kind(**{name: values[rows, conditions] for name, values in vars(ends).items()})
            if named and not is_along:
                part = window.with_binding_limits(
                    part, design, question.angles, question.flexion, question.bounds
                )
            if asks_power:
                part = within_power(
                    cast("Window", part),
                    design,
                    question.angles,
                    question.flexion,
                    question.bounds,
                    question.loads,
                )
            for name, values in vars(window.as_read(part, design)).items():
                if name not in finished:
                    finished[name] = np.empty(ends.low.shape, dtype=values.dtype)
                finished[name][rows, conditions] = values
        return Window(**finished) if named else Ends(**finished)

    def ends_at_samples(self, points: Points) -> Ends:
        """Return the ends that limits on forms set at the angles of the question, as F0."""
        ends, _, _ = self._sampled_ends(points)
        return ends

    def ends_that_may_bind(self, points: Points, reading: Reading | None = None) -> Ends:
        """Return the ends that limits on forms set, (choices, conditions), as F0.

        Ends that may set the window of their choice hold over all angles, others at samples alone.

        Args:
            points: The choices.
            reading: The gauge's reading, if it is known.
        """
        ends, low_between, high_between = self._sampled_ends(points)
        while True:
            low_may_bind, high_may_bind = self._may_bind(ends, points, reading)
            low_sought = low_between & low_may_bind
            high_sought = high_between & high_may_bind
            self._seek(ends, points, low_sought, high_sought)
            low_between &= ~low_sought
            high_between &= ~high_sought
            # Ends that are tighter now may leave it to others to bind.
            if self.question.is_f0 or not (low_sought.any() or high_sought.any()):
                return ends

    def ends_over_all_angles(self, points: Points) -> Ends:
        """Return the ends that limits on forms set, (choices, conditions), over all angles."""
        ends, low_between, high_between = self._sampled_ends(points)
        self._seek(ends, points, low_between, high_between)
        return ends

    def _sampled_ends(self, points: Points) -> tuple[Ends, Flags, Flags]:
        """Return the ends at samples, (choices, conditions), as F0.

        Returns:
            The ends; and True for lower and for upper ends that may lie between the samples.
        """
        question = self.question
        if question.study.trajectory is not None:
            along = self._windows_along(points, question.study.trajectory)
            nowhere = np.zeros(along.low.shape, dtype=np.bool_)
            return along, nowhere, nowhere
        if question.angles.size < 3:
            ends = self._fold_states(points, question.angles)
            nowhere = np.zeros(ends.low.shape, dtype=np.bool_)
            return ends, nowhere, nowhere
        ends = self._fold_states(points, whole_motion.with_edges(question.angles))
        has_end = np.isfinite(ends.low)
        low_is_inner = whole_motion.without_edges(ends.low_state, question.angles)
        high_is_inner = whole_motion.without_edges(ends.high_state, question.angles)
        low_between = low_is_inner & (ends.low_state >= 0) & has_end
        high_between = high_is_inner & (ends.high_state >= 0) & has_end
        if CONTACT_PRESSURE in (limit.name for limit in question.bounds.asked):
            low_begins, high_begins = self._tighten_at_contact(ends, points)
            low_between |= low_begins
            high_between |= high_begins
        return ends, low_between, high_between

    def _windows_along(self, points: Points, trajectory: Trajectory) -> Window:
        """Return the windows along a trajectory, (choices, conditions), of all limits, as F0."""
        found: dict[str, Any] = {}
        whole = (len(points), len(self.question.conditions))
        for rows, conditions, design in self.portions(points):
            part = window_along(design, trajectory, self.question.bounds)
            for name, values in vars(part).items():
                if name not in found:
                    found[name] = np.empty(whole, dtype=values.dtype)
                found[name][rows, conditions] = values
        return Window(**found)

    def _tighten_at_contact(self, ends: Ends, points: Points) -> tuple[Flags, Flags]:
        """Tighten ends at the angles from which on the straps press, in place.

        A limit on the strap's pressure begins there at once, and such an angle need not be one of
        the question.

        Args:
            ends: Ends at samples, (choices, conditions), as F0.
            points: The choices.

        Returns:
            True for lower and for upper ends that are tighter there.
        """
        question = self.question
        angles = question.angles.ravel()
        tightened = {name: np.zeros(ends.low.shape, dtype=np.bool_) for name in ("low", "high")}
        for rows, conditions, design in self.portions(points):
            shape = (rows.stop - rows.start, conditions.stop - conditions.start)
            contact = np.clip(design.arm.first_contact, angles[0], angles[-1])
            distance = np.abs(contact[..., np.newaxis] - angles).min(axis=-1)
            if np.all(distance <= _SAME_ANGLE):
                continue
            state = State.of(design, contact, question.flexion)
            tightest = window.begin(shape)
            kernel.fold_window(tightest, state, question.bounds, (*shape, len(question.flexion), 1))
            part = window.finish(tightest, design, question.bounds)
            is_bounded = question.bounds.of(design).asks(CONTACT_PRESSURE)
            begins = np.broadcast_to(is_bounded, (*shape, 1, 1))[..., 0, 0]
            of_designs = np.broadcast_to(contact, (*shape, 1, 1))[..., 0, 0]
            place = np.searchsorted(angles, of_designs)  # of the first angle with pressure
            here = rows, conditions
            for name, sign in (("low", 1.0), ("high", -1.0)):
                value = getattr(part, name)
                direction = getattr(part, f"{name}_state")
                is_tighter = begins & (sign * value > sign * getattr(ends, name)[here])
                tightened[name][here] = is_tighter
                for target, new in (
                    (name, value),
                    (f"{name}_state", direction * angles.size + place),
                    (f"{name}_angle", of_designs),
                ):
                    np.copyto(getattr(ends, target)[here], new, where=is_tighter)
        return tightened["low"], tightened["high"]

    def _fold_states(self, points: Points, angles: Array) -> Ends:
        """Fold the states at `angles`, (1, K) rad, into ends, (choices, conditions), as F0."""
        question = self.question
        folded: dict[str, Any] = {}
        for rows, conditions, design in self.portions(points):
            shape = (rows.stop - rows.start, conditions.stop - conditions.start)
            state = State.of(design, angles, question.flexion)
            tightest = window.begin(shape)
            kernel.fold_window(
                tightest, state, question.bounds, (*shape, len(question.flexion), angles.size)
            )
            part = window.finish(tightest, design, question.bounds)
            for name, values in vars(part).items():
                if name not in folded:
                    whole = (len(points), len(question.conditions))
                    folded[name] = np.empty(whole, dtype=values.dtype)
                folded[name][rows, conditions] = values
        return Ends(**folded)

    def _seek(self, ends: Ends, points: Points, low_sought: Flags, high_sought: Flags) -> None:
        """Replace ends by those over all angles, in place.

        Args:
            ends: Ends at samples.
            points: The choices.
            low_sought: True for lower ends that are sought, (choices, conditions).
            high_sought: True for upper ends.
        """
        question = self.question
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

    def _may_bind(self, ends: Ends, points: Points, reading: Reading | None) -> tuple[Flags, Flags]:
        """Return True for lower and upper ends that may set the window of their choice.

        They may do so once they are sought between the angles; both are (choices, conditions).

        Args:
            ends: Ends at samples, as F0.
            points: The choices.
            reading: The gauge's reading, if it is known.
        """
        question = self.question
        read = ends
        if not question.is_f0:
            if question.bounds.asks_power or question.study.setting.read == MOTOR_TORQUE:
                everywhere = np.ones(ends.low.shape, dtype=np.bool_)
                return everywhere, everywhere
            # Ends as they are read may have another order than as F0, but each grows with its own.
            if reading is None:
                read = self._all_limits(ends, points, named=False)
            else:
                read = window.read_by(ends, reading)
        low = [read.low.max(axis=1)]
        high = [read.high.min(axis=1)]
        if question.sample.enough < 1.0:
            of_groups = question.groups.windows(read.low, read.high)
            covered = question.groups.coverage(*of_groups, serve=question.sample.enough)
            low += [covered.low, covered.best_low]
            high += [covered.high, covered.best_high]
        if question.placement.given is not None:
            at_given = given_pretensions(question, points)
            low.append(at_given)
            high.append(at_given)
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
                columns = motion_columns(Moving.of(design, trajectory), names)
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
        count = len(points)
        most = _STATES_AT_ONCE // question.states_per_design
        if question.study.trajectory is not None:
            most //= _MOTION_IN_NUMPY
        elif question.bounds.asks_power or in_numpy:
            most //= _MOTOR_IN_NUMPY
        most = max(1, most)
        width = min(len(question.conditions), max(1, most // min(count, 2 * math.isqrt(most))))
        step = max(1, most // width)
        for conditions in self.cut(len(question.conditions), width):
            for rows in self.cut(count, step):
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
