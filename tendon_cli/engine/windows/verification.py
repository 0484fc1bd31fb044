"""Chosen designs judged by a fresh sample: the share that their pretension serves, and a window."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, Self

import numpy as np

from tendon_cli import say
from tendon_cli.engine.windows.coverage import ROUNDING, effective_count_of_strata, serves
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import (
    LEAN,
    Question,
    cost_per_design,
    is_sought,
    with_enough,
)
from tendon_cli.engine.windows.solutions import WINDOWS_AT_ONCE, Binding, End, Solutions, solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.studies.space.axis import SAMPLE_AXES, Axis
from tendon_cli.studies.space.space import Space
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.verbs.answer_record import FreshRecord, VerifiedRecord

if TYPE_CHECKING:
    from tendon_cli.studies.fresh_sample import FreshSample

_POSTURE_STEP = np.radians(5.0)
"""Largest step between postures of the upper arm at which an interval of them is judged, rad.
Limits are linear in its sine and cosine, so that they miss 0.1 % of the arm's weight between."""
_MOST_STATES = 2**25
"""Most states of one choice that a fresh sample has, or as many as take as long."""
_FEWEST_MEMBERS = 256
"""Members that a fresh sample has however long they take."""
_FEWER_TO_SET = 8
"""Factor by which the sample that sets choices is smaller than the one that judges."""
_INSIDE = 3
"""Values at which any other interval is judged in which limits are not linear."""


@dataclass(frozen=True, eq=False)
class Verified:
    """Judgement of a fresh sample on one choice at its pretension."""

    value: float
    """Share that the pretension serves."""
    interval: tuple[float, float]
    """95 % interval of that share among all who could have been drawn."""
    sample: FreshSample
    low: float
    """Lower end of the widest interval of pretension that serves enough, N; NaN if none does."""
    high: float
    """Upper end, N; infinite if nothing bounds it."""
    is_served: Flags
    """True for the members that the pretension serves, (members,)."""
    windows: tuple[Array, Array]
    """Lower and upper ends of the members' windows, (members,) each, N."""

    @property
    def record(self) -> VerifiedRecord:
        """The judgement as it is recorded."""
        return VerifiedRecord(
            value=self.value,
            interval_95=[*self.interval],
            of=len(self.sample),
            from_=finite_or_none(self.low),
            to=finite_or_none(self.high),
        )

    def is_enough(self, serve: float) -> bool:
        """Return True if the sample does not refute that so many are served."""
        return self.interval[1] >= serve - ROUNDING


@dataclass(frozen=True, eq=False)
class Verifier:
    """Judge of choices by a fresh sample."""

    solver: Solver
    """Solver of the same question under the conditions of the sample."""
    sample: FreshSample

    @classmethod
    def of(cls, solver: Solver, *, second: bool = False) -> Self | None:
        """Return the judge of a question's choices; None if it has no fresh sample.

        Args:
            solver: Solver of the question.
            second: True for the sample that sets choices, under the question's own conditions.
        """
        question = solver.question
        counted = {axis.key for axis in question.conditions.axes if axis.role == "draw"}
        if not counted or not counted <= set(SAMPLE_AXES):
            return None
        # A question without persons and draws does without the import.
        from tendon_cli.studies.fresh_sample import fresh_sample

        sample = fresh_sample(question.study, second=second)
        if sample is None:
            return None
        others = [axis for axis in question.conditions.axes if axis.role != "draw"]
        if not second:
            others = [_with_inside(question, axis) for axis in others]
        conditions = Space((sample.axis, *others)).grouped()
        of_sample = with_enough(replace(question, conditions=conditions), question.serve)
        judge = cls(solver.for_question(of_sample), sample)
        of_member = judge.solver.question.groups.conditions_per_group * cost_per_design(of_sample)
        most = _MOST_STATES // of_member
        if second and is_sought(question):
            most //= _FEWER_TO_SET  # it solves many choices, where each window is sought
        return judge.thinned(max(_FEWEST_MEMBERS, most))

    def thinned(self, most: int) -> Self:
        """Return a judge that asks at most so many members (`FreshSample.thinned`)."""
        sample = self.sample.thinned(most)
        if sample is self.sample:
            return self
        question = self.solver.question
        _, *others = question.conditions.axes
        conditions = Space((sample.axis, *others)).grouped()
        thinned = self.for_question(replace(question, conditions=conditions))
        return replace(thinned, sample=sample)

    def for_question(self, question: Question) -> Self:
        """Return the judge with the same sample, but with other limits or numbers.

        Args:
            question: Question under the conditions of the sample.
        """
        return replace(self, solver=self.solver.for_question(question))

    def set_choices(self, choices: Solutions) -> Solutions:
        """Return choices with the windows, settings and worst values of this sample.

        The conditions that bind are those of the same kind in the question's own sample.

        Args:
            choices: Choices of the question, solved under its own conditions.
        """
        solved = solve(self.solver, choices.points)
        per_group = self.solver.question.groups.conditions_per_group

        def of_own_sample(end: End) -> Binding:
            binding = solved.binding(end)
            own = choices.binding(end).condition
            condition = own - own % per_group + binding.condition % per_group
            return replace(binding, condition=condition)

        return replace(solved, from_binding=of_own_sample("from"), to_binding=of_own_sample("to"))

    def judge(self, points: Points, pretensions: Array) -> list[Verified]:
        """Judge choices, each at its pretension.

        Args:
            points: The choices.
            pretensions: Their pretensions, (choices,), N.

        Raises:
            Stopped: The run was cancelled.
        """
        question = self.solver.question
        groups = question.groups
        judged = []
        at_once = max(1, WINDOWS_AT_ONCE // len(question.conditions))
        for rows in self.solver.cut(len(points), at_once):
            ends = self.solver.ends(points.select(rows), pretensions[rows])
            group_low, group_high = groups.windows(ends.low, ends.high)
            is_served = serves(group_low, group_high, pretensions[rows, np.newaxis])
            covered = groups.coverage(group_low, group_high, serve=question.serve)
            for place, of_members in enumerate(is_served):
                windows = (group_low[place], group_high[place])
                low = float(covered.low[place])
                high = float(covered.high[place])
                if question.serve >= 1.0:
                    common_low = float(windows[0].max())
                    common_high = float(windows[1].min())
                    has_window = common_low <= common_high
                    low = common_low if has_window else np.nan
                    high = common_high if has_window else np.nan
                judged.append(self._verified(of_members, windows, low, high))
        return judged

    def _verified(
        self, is_served: Flags, windows: tuple[Array, Array], low: float, high: float
    ) -> Verified:
        """Return the judgement of one choice, from the members that its pretension serves."""
        groups = self.solver.question.groups
        value = float(groups.share(is_served[np.newaxis])[0])
        if np.ptp(groups.weighting) == 0.0:
            value = float(np.mean(is_served))  # without the rounding of a weighted sum
        sample = self.sample
        effective = effective_count_of_strata(is_served, sample.weighting, sample.strata)
        return Verified(
            value=value,
            interval=say.interval(value, effective),
            sample=sample,
            low=low,
            high=high,
            is_served=is_served,
            windows=windows,
        )


def fresh_record(sample: FreshSample) -> FreshRecord:
    """Return the record of a fresh sample."""
    kind: Literal["persons", "draws"] = "persons" if sample.draws_persons else "draws"
    return FreshRecord(count=len(sample), persons=sample.persons, kind=kind)


def _with_inside(question: Question, axis: Axis) -> Axis:
    """Return an axis of conditions with values inside an interval that may be worse than its ends.

    A proof sees to these in the study's own sample.
    """
    if axis.key not in question.whole_intervals:
        return axis
    ends = axis.numbers[axis.key]
    count = _INSIDE
    if axis.key == LEAN:
        steps = np.ceil(np.ptp(ends) / _POSTURE_STEP - ROUNDING)
        count = 1 + max(1, int(steps))
    values = np.linspace(ends[0], ends[-1], count)
    return replace(axis, numbers={axis.key: values}, is_interval=False)
