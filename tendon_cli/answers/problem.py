"""A design question: what a study asks, and how windows of its choices over its conditions are worked out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from tendon_cli import kernel, say
from tendon_cli.answers.coverage import grouped, share_served
from tendon_cli.answers.question import Flags, Question, select_numbers
from tendon_cli.engine.plan import bounds_of
from tendon_cli.errors import UsageError
from tendon_cli.model import whole_motion, window
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.motor_window import narrowed
from tendon_cli.model.window import Ends, Window
from tendon_cli.space.axis import PRETENSION, Numbers, Rows, split_side
from tendon_cli.studies.contents import case_numbers
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import Study
from tendon_cli.studies.values import Values
from tendon_cli.units import shorten

_STATES_AT_ONCE = 2**21  # so that the model's arrays stay within a few megabytes each
_MOTOR_IN_NUMPY = (
    8  # by how much fewer are at once with limits on the motor, of which all states have arrays
)
_REFINED_AT_ONCE = 2**12
_SEVERAL = {"peak_motor_power", "max_motor_work_in", "max_friction_loss", "min_efficiency"}


@dataclass(frozen=True, eq=False)
class Problem(Question):
    """What is asked, and the windows of its choices."""

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
        if not named and self.is_f0:
            return ends
        for rows, conditions, design in self.chunks(numbers, len(ends.low)):
            each = Ends(**{name: values[rows, conditions] for name, values in vars(ends).items()})
            if named:
                each = window.named(each, design, self.angles, self.flexion, self.bounds)
            if of_motion:
                window_of = cast("Window", each)
                each = narrowed(
                    window_of, design, self.angles, self.flexion, self.bounds, self.loads
                )
            for name, values in vars(window.as_read(each, design)).items():
                whole.setdefault(name, np.empty(shape, dtype=values.dtype))[rows, conditions] = (
                    values
                )
        return Window(**whole) if named else Ends(**whole)

    def ends_over_angles(self, numbers: Numbers, count: int) -> Ends:
        """Ends that limits on states set, (choices, conditions), as F0; those that may matter are of all angles."""
        whole: dict[str, Any] = {}
        still = self.study.trajectory is not None or self.angles.size < 3
        angles = self.angles if still else whole_motion.with_edges(self.angles)
        for rows, conditions, design in self.chunks(numbers, count):
            shape = rows.stop - rows.start, conditions.stop - conditions.start
            folded, states = window.begin(shape), (*shape, len(self.flexion), angles.size)
            kernel.fold_window(folded, State.of(design, angles, self.flexion), self.bounds, states)
            for name, values in vars(window.finished(folded, design, self.bounds)).items():
                every = whole.setdefault(
                    name, np.empty((count, len(self.conditions)), dtype=values.dtype)
                )
                every[rows, conditions] = values
        ends = Ends(**whole)
        if still:
            return ends
        inner = [
            whole_motion.without_edges(state, self.angles)
            for state in (ends.low_state, ends.high_state)
        ]
        for name, may_bind, is_inner in zip(
            ("low", "high"), self._may_bind(ends), inner, strict=True
        ):
            value, state, angle = (getattr(ends, f"{name}{of}") for of in ("", "_state", "_angle"))
            at = np.nonzero(may_bind & is_inner & (state >= 0) & np.isfinite(ends.low))
            for part in self.cut(len(at[0]), _REFINED_AT_ONCE):
                some = at[0][part], at[1][part]
                of_pairs = (
                    self.paired(numbers, *some),
                    state[some],
                    value[some],
                    self.angles.ravel(),
                )
                tightest = whole_motion.refined(
                    *of_pairs, self.flexion, self.bounds, upper=name == "high"
                )
                value[some], state[some], angle[some] = tightest
        return ends

    def _may_bind(self, ends: Ends) -> tuple[Flags, Flags]:
        """Which lower and upper ends, (choices, conditions), may set those of their choices, whichever angles bind."""
        if (
            not 0.0 < self.near < np.inf or not self.is_f0
        ):  # the order of readings may be another one
            return (np.full(ends.low.shape, self.near > 0.0),) * 2
        low, high = [ends.low.max(axis=1)], [ends.high.min(axis=1)]
        if self.enough < 1.0:
            of_groups = grouped(ends.low, ends.high, self.groups)
            covered = share_served(*of_groups, self.weighting, enough=self.enough)
            low, high = (
                [*low, covered.low, covered.best_low],
                [*high, covered.high, covered.best_high],
            )
        return _near(ends.low, low, self.near), _near(ends.high, high, self.near)

    def chunks(
        self, numbers: Numbers, count: int, pretension: Array | None = None
    ) -> Iterator[tuple[slice, slice, Design]]:
        """Choices and conditions that are worked out together, and their designs: several of both.

        So what depends on one of these alone is worked out once. Raises Stopped between them if that is asked for.
        """
        under = len(self.conditions)
        most = max(
            1,
            _STATES_AT_ONCE
            // self.states_per_design
            // (_MOTOR_IN_NUMPY if self.bounds.of_motion else 1),
        )
        width = min(under, max(1, most // min(count, 2 * math.isqrt(most))))
        step = max(1, most // width)
        at = {**numbers, **({} if pretension is None else {PRETENSION: pretension})}
        for conditions in self.cut(under, width):
            for rows in self.cut(count, step):
                yield (
                    rows,
                    conditions,
                    self.design(
                        select_numbers(at, rows), select_numbers(self.condition_numbers, conditions)
                    ),
                )

    def cut(self, count: int, most: int) -> Iterator[slice]:
        """As many at once as memory has room for; raises Stopped between them."""
        for start in range(0, count, most):
            self.check_stopped()
            yield slice(start, min(start + most, count))


def _near(ends: Array, of: list[Array], share: float) -> Flags:
    """Which ends lie so near to one of some of their choices that other angles may make them this."""
    near = np.zeros(ends.shape, dtype=np.bool_)
    with np.errstate(invalid="ignore"):
        for each in of:
            near |= (
                np.abs(ends - each[:, np.newaxis]) <= share * (1.0 + np.abs(each))[:, np.newaxis]
            )
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
        given=study.design.pretension.single
        if isinstance(study.design.pretension, Values)
        else None,
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
        sampled, not_proved = say.proved(say.SAMPLED), say.proved(say.OPEN)
        yield f"{', '.join(ends)}: {sampled} at both ends of the interval; what lies between is {not_proved}"
    if within := problem.whole_intervals:
        yield f"{', '.join(within)}: the window holds for the whole interval; the worst values are those at its ends"
    if several := [name for name in study.limits if name in _SEVERAL]:
        yield f"{', '.join(several)}: where several intervals of pretension keep to this, the widest is used"
    if study.people is not None and study.people.content is None:
        yield from study.people.population.notes
    if study.uncertain and study.uncertainty is None:
        yield "uncertain numbers stand at their middle; [uncertainty] draws them"
    if study.uncertainty is not None and not study.uncertain:
        yield "nothing in this study is uncertain, so that [uncertainty] draws nothing"


def rows_to_prove(problem: Problem) -> Rows:
    """The choices that the study names in `[design] prove`; raises UsageError for what is no row of the choices."""
    count, rows = len(problem.choices), problem.study.design.prove
    for text in rows:
        if not text.isdecimal() or int(text) >= count:
            raise UsageError(
                f'"{shorten(text)}" is no row of choices.parquet',
                where="--prove",
                hint=f"0 to {count - 1}",
            )
    return np.unique(np.array([int(text) for text in rows], dtype=np.int64))
