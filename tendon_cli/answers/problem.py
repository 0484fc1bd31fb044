"""Windows of a question's choices under its conditions, in portions that fit into memory."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from tendon_cli import kernel
from tendon_cli.answers.coverage import group_windows, share_served
from tendon_cli.answers.question import Question, select_numbers
from tendon_cli.answers.text_notes import question_notes
from tendon_cli.engine.plan import bounds_of
from tendon_cli.errors import UsageError
from tendon_cli.model import whole_motion, window
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.motor_window import narrow
from tendon_cli.model.window import Ends, Window
from tendon_cli.space.axis import PRETENSION, Numbers, Rows
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import Study
from tendon_cli.studies.values import StudyNumber
from tendon_cli.units import shorten

_STATES_AT_ONCE = 2**21
"""States in one portion, so that each array of the model stays within a few megabytes."""
_MOTOR_IN_NUMPY = 8
"""Factor by which a portion is smaller with limits on the motor, whose arrays hold all states."""
_REFINED_AT_ONCE = 2**12
"""Ends that are sought between the angles together."""


@dataclass(frozen=True, eq=False)
class Problem(Question):
    """A design question together with the windows of its choices."""

    def windows(self, numbers: Numbers, count: int) -> Window:
        """Return windows with the limits that bind, (choices, conditions).

        Args:
            numbers: Numbers of the choices, (choices,) each.
            count: Number of choices.
        """
        return cast("Window", self.ends(numbers, count, named=True))

    def ends(self, numbers: Numbers, count: int, *, named: bool = False) -> Ends:
        """Return the ends of windows, (choices, conditions), in half the time of `windows`.

        They are a `Window` if `named`, or if the limits that bind follow without more work.
        """
        ends = self.ends_over_angles(numbers, count)
        return self.finish_ends(ends, numbers, named=named)

    def finish_ends(self, ends: Ends, numbers: Numbers, *, named: bool = False) -> Ends:
        """Turn ends that limits on states set, as F0, into ends of all limits, as they are read.

        Args:
            ends: Ends of `ends_over_angles`, (choices, conditions).
            numbers: Numbers of the choices.
            named: True to name the limits that bind, too.
        """
        of_motion = bool(self.bounds.of_motion)
        named = named or of_motion or kernel.kind() is None
        if not named and self.is_f0:
            return ends
        finished: dict[str, Any] = {}
        for rows, conditions, design in self.chunks(numbers, len(ends.low)):
            part = Ends(**{name: values[rows, conditions] for name, values in vars(ends).items()})
            if named:
                part = window.with_binding_limits(
                    part, design, self.angles, self.flexion, self.bounds
                )
            if of_motion:
                part = narrow(
                    cast("Window", part),
                    design,
                    self.angles,
                    self.flexion,
                    self.bounds,
                    self.loads,
                )
            for name, values in vars(window.as_read(part, design)).items():
                if name not in finished:
                    finished[name] = np.empty(ends.low.shape, dtype=values.dtype)
                finished[name][rows, conditions] = values
        return Window(**finished) if named else Ends(**finished)

    def ends_over_angles(self, numbers: Numbers, count: int) -> Ends:
        """Return the ends that limits on states set, (choices, conditions), as F0.

        Ends that may set the window of their choice hold over all angles, others at `angles` alone.
        """
        is_continuous = self.study.trajectory is None and self.angles.size >= 3
        if not is_continuous:
            return self._ends_over_states(numbers, count, self.angles)
        ends = self._ends_over_states(numbers, count, whole_motion.with_edges(self.angles))
        self._refine_between_angles(ends, numbers)
        return ends

    def _ends_over_states(self, numbers: Numbers, count: int, angles: Array) -> Ends:
        """Fold the states at `angles`, (1, K) rad, into ends, (choices, conditions), as F0."""
        folded: dict[str, Any] = {}
        for rows, conditions, design in self.chunks(numbers, count):
            shape = (rows.stop - rows.start, conditions.stop - conditions.start)
            state = State.of(design, angles, self.flexion)
            tightest = window.begin(shape)
            kernel.fold_window(
                tightest, state, self.bounds, (*shape, len(self.flexion), angles.size)
            )
            part = window.finish(tightest, design, self.bounds)
            for name, values in vars(part).items():
                if name not in folded:
                    folded[name] = np.empty((count, len(self.conditions)), dtype=values.dtype)
                folded[name][rows, conditions] = values
        return Ends(**folded)

    def _refine_between_angles(self, ends: Ends, numbers: Numbers) -> None:
        """Replace ends that may set the window of their choice by those over all angles, in place.

        Args:
            ends: Ends over the angles of `with_edges`; their states become those of `angles`.
            numbers: Numbers of the choices.
        """
        low_may_bind, high_may_bind = self._may_bind(ends)
        sides = (
            (False, low_may_bind, ends.low, ends.low_state, ends.low_angle),
            (True, high_may_bind, ends.high, ends.high_state, ends.high_angle),
        )
        for upper, may_bind, value, state, angle in sides:
            is_inner = whole_motion.without_edges(state, self.angles)
            is_sought = may_bind & is_inner & (state >= 0) & np.isfinite(ends.low)
            rows, conditions = np.nonzero(is_sought)
            for part in self.cut(len(rows), _REFINED_AT_ONCE):
                pairs = (rows[part], conditions[part])
                value[pairs], state[pairs], angle[pairs] = whole_motion.refine_ends(
                    self.paired(numbers, *pairs),
                    state[pairs],
                    value[pairs],
                    self.angles.ravel(),
                    self.flexion,
                    self.bounds,
                    upper=upper,
                )

    def _may_bind(self, ends: Ends) -> tuple[Flags, Flags]:
        """Return True for lower and upper ends that may set the window of their choice.

        They may do so once they are sought between the angles; both are (choices, conditions).
        """
        # Ends as they are read may have another order than as F0: then all are sought.
        if not 0.0 < self.near < np.inf or not self.is_f0:
            all_or_none = np.full(ends.low.shape, self.near > 0.0)
            return all_or_none, all_or_none
        low = [ends.low.max(axis=1)]
        high = [ends.high.min(axis=1)]
        if self.enough < 1.0:
            group_low, group_high = group_windows(ends.low, ends.high, self.groups)
            covered = share_served(group_low, group_high, self.weighting, enough=self.enough)
            low += [covered.low, covered.best_low]
            high += [covered.high, covered.best_high]
        return _near_any(ends.low, low, self.near), _near_any(ends.high, high, self.near)

    def chunks(
        self, numbers: Numbers, count: int, pretension: Array | None = None
    ) -> Iterator[tuple[slice, slice, Design]]:
        """Yield portions: choices and conditions that are worked out together, and their designs.

        A portion has several of both, so that what depends on one of them alone is worked out once.

        Args:
            numbers: Numbers of the choices.
            count: Number of choices.
            pretension: Pretensions of the choices, (choices,), N.

        Raises:
            Stopped: The run was cancelled.
        """
        most = _STATES_AT_ONCE // self.states_per_design
        if self.bounds.of_motion:
            most //= _MOTOR_IN_NUMPY
        most = max(1, most)
        width = min(len(self.conditions), max(1, most // min(count, 2 * math.isqrt(most))))
        step = max(1, most // width)
        of_choices = numbers if pretension is None else {**numbers, PRETENSION: pretension}
        for conditions in self.cut(len(self.conditions), width):
            for rows in self.cut(count, step):
                of_conditions = select_numbers(self.condition_numbers, conditions)
                design = self.design(select_numbers(of_choices, rows), of_conditions)
                yield rows, conditions, design

    def cut(self, count: int, most: int) -> Iterator[slice]:
        """Yield slices of at most `most` of `count` items.

        Raises:
            Stopped: The run was cancelled.
        """
        for start in range(0, count, most):
            self.check_stopped()
            yield slice(start, min(start + most, count))


def _near_any(ends: Array, references: list[Array], share: float) -> Flags:
    """Return True where ends, (choices, conditions), lie near any reference, (choices,)."""
    is_near = np.zeros(ends.shape, dtype=np.bool_)
    with np.errstate(invalid="ignore"):
        for reference in references:
            distance = np.abs(ends - reference[:, np.newaxis])
            is_near |= distance <= share * (1.0 + np.abs(reference))[:, np.newaxis]
    return is_near


def question_of(study: Study) -> Problem:
    """Return the question that a study asks of `tendon design`."""
    space = space_of(study).without_pretension()
    pretension = study.design.pretension
    problem = Problem(
        study=study,
        choices=space.choices,
        conditions=space.conditions,
        bounds=bounds_of(study),
        enough=study.serve,
        middle=pretension == "middle",
        given=pretension.single if isinstance(pretension, StudyNumber) else None,
    )
    notes = question_notes(study, problem.sampled_intervals, problem.whole_intervals)
    return replace(problem, notes=(*study.warnings, *notes))


def rows_to_prove(problem: Problem) -> Rows:
    """Return the choices that the study names in `[design] prove`, ascending.

    Raises:
        UsageError: The study names something that is no row of the choices.
    """
    count = len(problem.choices)
    texts = problem.study.design.prove
    for text in texts:
        if not text.isdecimal() or int(text) >= count:
            raise UsageError(
                f'"{shorten(text)}" is not a row of choices.parquet',
                where="--prove",
                hint=f"0 to {count - 1}",
            )
    return np.unique(np.array([int(text) for text in texts], dtype=np.int64))
