"""The record of one choice for persons or draws: whom it serves, why not others, and sizes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from tendon_cli import say
from tendon_cli.answers.phrases import LESS, MORE, NEITHER, reason_words
from tendon_cli.answers.question_facts import (
    condition_values,
    question_record,
    value_at,
)
from tendon_cli.answers.sensitivity import indices
from tendon_cli.answers.setup import settings
from tendon_cli.answers.text_bench import FEW_PERSONS, population_title
from tendon_cli.engine.windows import coverage
from tendon_cli.engine.windows.coverage import (
    Sizes,
    best_sizes,
    effective_count,
    normalise,
    serves,
)
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import Question, select_numbers
from tendon_cli.engine.windows.solutions import Solutions
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.verification import Verified, fresh_record
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.limits import LIMIT_NAMES, Codes
from tendon_cli.studies.people.population import Population
from tendon_cli.studies.space.axis import PERSON_AXIS, Axis, evenly_spaced, limit_of
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.verbs.answer_record import (
    BodyRecord,
    ChoiceRecord,
    PopulationRecord,
    ReasonRecord,
    SexRecord,
    ShareCurve,
    SizeRecord,
    SuitRecord,
    Values,
    row_as_read,
    value_of,
)

MOST_SIZES = 3
_MOST_ALONG = 16
"""Values of an axis among which sizes are chosen."""
_MOST_PERSONS = 1000
"""Persons for whom sizes are chosen, the first ones: the search grows with their square."""
_MOST_OF_CURVE = 1000
"""Most points of the recorded curve."""
_MOST_NAMES = 100
"""Most names recorded for a reason."""


@dataclass(frozen=True, eq=False)
class GroupWindows:
    """Windows of one choice for groups, such as persons, over their other conditions, (groups,)."""

    low: Array
    """Lower end, N. The window is empty where low > high, NaN where no pretension could do."""
    high: Array
    """Upper end, N."""
    low_by: Codes
    """Limit that binds below: index into `LIMIT_NAMES`, or -1."""
    high_by: Codes
    """Limit that binds above."""
    low_condition: Rows
    """Row of the condition that binds below."""
    high_condition: Rows
    """Row of the condition that binds above."""

    @classmethod
    def of(cls, solver: Solver, points: Points) -> GroupWindows:
        """Return the windows of all groups of a question for one choice."""
        windows = solver.windows(points)
        groups = len(solver.question.groups)
        low = windows.low.reshape(groups, -1)  # (groups, conditions of each)
        high = windows.high.reshape(groups, -1)
        first_binding = np.argmax(low, axis=1)  # argmax and argmin take the first NaN
        last_binding = np.argmin(high, axis=1)
        rows = np.arange(groups)
        first_condition = rows * low.shape[1]
        return cls(
            low=low[rows, first_binding],
            high=high[rows, last_binding],
            low_by=windows.low_by.reshape(groups, -1)[rows, first_binding],
            high_by=windows.high_by.reshape(groups, -1)[rows, last_binding],
            low_condition=first_condition + first_binding,
            high_condition=first_condition + last_binding,
        )

    def served(self, pretension: float) -> Flags:
        """Return True where a pretension, N, serves a group."""
        return serves(self.low, self.high, pretension)


def people_of(question: Question) -> Population | None:
    """Return the people of a question; None if it has no axis of persons."""
    study = question.study
    if study.people is None or PERSON_AXIS not in study.axes:
        return None
    return study.people.population


def person_of(question: Question, groups: Rows) -> Rows:
    """Return the row of the population that each group belongs to, for a question about people."""
    drawn = [axis for axis in question.conditions.axes if axis.role == "draw"]
    draws = math.prod(len(axis) for axis in drawn if axis.key != PERSON_AXIS)
    return groups // draws


def population(
    solver: Solver,
    chosen: Solutions,
    row: ChoiceRecord,
    windows: GroupWindows,
    judged: Verified | None = None,
) -> PopulationRecord:
    """Return the record of a choice for persons or draws: whom it serves, and why not the others.

    Args:
        solver: Solver of the question.
        chosen: The choice.
        row: Its row of the table.
        windows: Its windows for all groups.
        judged: Judgement of a fresh sample on it, which then gives the shares by sex and the curve
            if it has persons or draws of its own.
    """
    question = solver.question
    groups = question.groups
    people = people_of(question)
    pretension = float(chosen.pretension[0])
    served = float(groups.share(windows.served(pretension)[np.newaxis])[0])
    largest_share = float(chosen.served[0])
    own_curve = coverage.curve(windows.low, windows.high, groups.weighting)
    curve = own_curve
    asks_sex = people is not None and question.study.design.by == "sex"
    by: list[SexRecord] = []
    if judged is not None and not judged.sample.persons:
        curve = coverage.curve(*judged.windows, judged.sample.weighting)
        by = [*_by_sex_of_fresh(judged)] if asks_sex else []
    elif people is not None and asks_sex:
        by = [*_by_sex(question, people, windows.served(pretension))]
    count = len(curve.pretension)
    thinned = evenly_spaced(count, _MOST_OF_CURVE)
    values: Values = {axis.column: value_of(row, axis.column) for axis in question.choices.axes}
    record: PopulationRecord = PopulationRecord(
        choice=row.choice,
        values=values,
        kind=groups.noun,
        count=len(windows.low),
        effective_count=groups.effective_count,
        counts=dict(groups.counts),
        window=[
            finite_or_none(chosen.pretension_from[0]),
            finite_or_none(chosen.pretension_to[0]),
        ],
        pretension=finite_or_none(chosen.pretension[0]),
        served=served,
        interval_95=groups.interval(served),
        served_verified=None if judged is None else judged.record,
        largest_share=largest_share,
        largest_share_at=finite_or_none(own_curve.best),
        set=_spread_of_settings(question, chosen),
        by=by,
        curve=ShareCurve(
            pretension=curve.pretension[thinned].tolist(),
            share=curve.share[thinned].tolist(),
            low=curve.low[thinned].tolist(),
            high=curve.high[thinned].tolist(),
        ),
        not_served=reasons_not_served(question, windows, pretension, row.columns),
        sizes={} if people is None else dict(_sizes(solver, chosen)),
        sobol=indices(solver, chosen.points),
        title="",
    )
    fresh = None if judged is None else fresh_record(judged.sample)
    shown = row_as_read(row) if question.sample.shows_own_f0 else row
    record.title = population_title(question_record(question), record, shown, fresh, question.serve)
    return record


def _spread_of_settings(question: Question, chosen: Solutions) -> dict[str, list[float]]:
    """Return the range over persons and draws of each tension to set at the pretension, N.

    It holds nine in ten of them, or all if they are few; it is empty without a pretension.
    """
    if np.isnan(chosen.pretension[0]):
        return {}
    groups = question.groups
    numbers = select_numbers(question.condition_numbers, groups.first_conditions)
    design = question.designs(chosen.points.at_pretension(chosen.pretension), numbers)
    shares = (0.05, 0.95) if len(groups) >= FEW_PERSONS else (0.0, 1.0)
    tensions = settings(design, chosen.pretension, len(groups))
    return {name: np.quantile(values, shares).tolist() for name, values in tensions.items()}


def _by_sex(question: Question, people: Population, served: Flags) -> Iterator[SexRecord]:
    """Yield the share that the pretension serves among men and among women."""
    weighting = question.groups.weighting
    rows = person_of(question, np.arange(len(weighting)))
    sexes = np.array(people.sexes)[rows]
    for sex in dict.fromkeys(sexes.tolist()):
        groups = np.flatnonzero(sexes == sex)
        weights = normalise(weighting[groups])
        is_served = served[groups]
        share = 1.0 if is_served.all() else float(min(weights[is_served].sum(), 1.0))
        persons = len(np.unique(rows[groups] // people.completions))
        effective = effective_count(weighting[groups]) * persons / len(groups)
        yield _sex_record(sex, persons, share, effective)


def _by_sex_of_fresh(judged: Verified) -> Iterator[SexRecord]:
    """Yield the share that a pretension serves among the men and women of a fresh sample."""
    sexes = np.array(judged.sample.sexes)
    for sex in dict.fromkeys(sexes.tolist()):
        is_served = judged.is_served[sexes == sex]
        yield _sex_record(sex, len(is_served), float(is_served.mean()), len(is_served))


def _sex_record(
    sex: Literal["male", "female"], persons: int, served: float, effective: float
) -> SexRecord:
    """Return the share served among persons of one sex, with the effective size of their sample."""
    interval = [*say.interval(served, effective)]
    return SexRecord(sex=sex, persons=persons, served=served, interval_95=interval)


def reasons_not_served(
    question: Question, windows: GroupWindows, pretension: float, choice: Mapping[str, Any]
) -> list[ReasonRecord]:
    """Return the reasons why a pretension does not serve some groups, as recorded.

    The most frequent reason comes first. A reason names the limit that is not kept, or both limits
    that conflict if no pretension would do; for each limit the condition under which it binds for
    most of these groups; and the persons, the farthest from being served first.

    Args:
        question: The question.
        windows: Windows of one choice for all groups.
        pretension: Its pretension, N.
        choice: Its row in the table.
    """
    people = people_of(question)
    weights = normalise(question.groups.weighting)
    groups = np.flatnonzero(~windows.served(pretension))
    low = windows.low[groups]
    high = windows.high[groups]
    more_or_less = np.where(low > pretension, MORE, LESS)
    needs = np.where(low <= high, more_or_less, NEITHER)
    missing = np.fmax(low - pretension, pretension - high)
    low_by = np.where(needs == LESS, -1, windows.low_by[groups])
    high_by = np.where(needs == MORE, -1, windows.high_by[groups])
    kinds = list(zip(needs.tolist(), low_by.tolist(), high_by.tolist(), strict=True))
    facts = question_record(question)
    reasons: list[ReasonRecord] = []
    for kind in dict.fromkeys(kinds):
        need, low_code, high_code = kind
        places = [place for place, other in enumerate(kinds) if other == kind]
        farthest_first = np.argsort(-missing[places], kind="stable")
        members = groups[places][farthest_first]
        limits = []
        conditions = []
        if low_code >= 0:
            limits.append(LIMIT_NAMES[low_code])
            conditions.append(_most_frequent(question, windows.low_condition[members]))
        if high_code >= 0 and high_code != low_code:
            limits.append(LIMIT_NAMES[high_code])
            conditions.append(_most_frequent(question, windows.high_condition[members]))
        share = float(weights[members].sum())
        names: list[str] = []
        bodies: dict[str, BodyRecord] = {}
        if people is not None:
            rows = person_of(question, members)
            persons = (rows // people.completions).tolist()
            names = list(dict.fromkeys(people.persons[person] for person in persons))
            bodies = dict(_differences(people, rows))
        under = [condition_values(question, condition) for condition in conditions]
        reasons.append(
            ReasonRecord(
                text=reason_words(facts, choice, limits, under),
                needs=need,
                limits=limits,
                conditions=conditions,
                under=under,
                count=len(members),
                share=share,
                interval_95=list(say.interval(share, effective_count(weights))),
                first=names[:_MOST_NAMES],
                bodies=bodies,
            )
        )
    return sorted(reasons, key=lambda reason: (-reason.share, -reason.count))


def _most_frequent(question: Question, conditions: Rows) -> int:
    """Return the condition that binds in most groups, as a row of the first of these groups."""
    within = conditions % question.groups.conditions_per_group
    return int(conditions[np.argmax(within == np.bincount(within).argmax())])


def _differences(people: Population, members: Rows) -> Iterator[tuple[str, BodyRecord]]:
    """Yield the dimensions in which persons differ from everyone, the largest difference first.

    Means are SI; `deviations` is the difference in standard deviations.
    """
    weights = normalise(people.weighting)
    mean = weights @ people.values
    deviation = np.sqrt(weights @ np.square(people.values - mean))
    mean_of_members = people.values[members].mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        difference = np.where(deviation > 0.0, (mean_of_members - mean) / deviation, 0.0)
    for dimension in np.argsort(-np.abs(difference), kind="stable"):
        record: BodyRecord = BodyRecord(
            theirs=float(mean_of_members[dimension]),
            of_all=float(mean[dimension]),
            deviations=float(difference[dimension]),
        )
        yield DIMENSIONS[dimension], record


def _sizes(solver: Solver, chosen: Solutions) -> Iterator[tuple[str, list[SizeRecord]]]:
    """Yield the best few suits along each axis of the choices, all else as in the chosen one.

    An axis of limits has no sizes: it changes what is asked of a suit, and no suit.
    """
    question = solver.question
    draws = len(question.groups) // question.groups.counts[PERSON_AXIS]
    persons = min(question.groups.counts[PERSON_AXIS], _MOST_PERSONS)
    groups = question.groups.select(np.arange(persons * draws))
    weighting = groups.weighting[::draws]
    of_persons = solver.for_question(question.for_conditions(np.arange(len(groups.of))))
    at_chosen = question.choices.places(chosen.row)
    for axis in question.choices.axes:
        along = evenly_spaced(len(axis), _MOST_ALONG)
        has_sizes = any(limit_of(key) is None for key in axis.keys)
        if len(along) < 2 or not has_sizes:
            continue
        places = np.broadcast_arrays(*(at_chosen | {axis.key: along}).values())
        rows = np.ravel_multi_index(places, question.choices.shape)
        ends = of_persons.ends(question.points(rows))
        low, high = groups.windows(ends.low, ends.high)
        if draws > 1:  # a person's window serves enough of the draws
            covered = coverage.share_served(
                low.reshape(-1, draws),
                high.reshape(-1, draws),
                np.ones(draws),
                serve=question.serve,
            )
            low = covered.low.reshape(len(along), -1)
            high = covered.high.reshape(len(along), -1)
        best = best_sizes(low, high, weighting, MOST_SIZES, solver.check_stopped)
        yield axis.column, [_size(axis, along, sizes, persons) for sizes in best]


def _size(axis: Axis, along: Rows, sizes: Sizes, persons: int) -> SizeRecord:
    """Return the record of the best few suits, whose choices are places in `along`."""
    suits: list[SuitRecord] = []
    for choice, pretension in zip(sizes.choices, sizes.pretensions, strict=True):
        suits.append(SuitRecord(value=value_at(axis, along[choice]), pretension=pretension))
    return SizeRecord(
        choices=suits,
        served=sizes.share,
        interval_95=list(say.interval(sizes.share, persons)),
        persons=persons,
        values_tried=len(along),
        all_values=len(along) == len(axis),
    )
