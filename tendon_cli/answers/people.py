"""For whom, and how sure: what one choice is to every person, or over draws of what is uncertain, as recorded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers import coverage
from tendon_cli.answers.coverage import (
    Sizes,
    best_sizes,
    effective_count,
    grouped,
    normalised,
    serves,
)
from tendon_cli.answers.phrases import LESS, MORE, NEITHER, population_share, row_words, why_not
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question import ColumnArrays
from tendon_cli.answers.sensitivity import indices
from tendon_cli.answers.setup import FEW, settings, study_arm
from tendon_cli.answers.solve import Solutions
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import LIMIT_NAMES, Codes
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, Axis, Rows
from tendon_cli.studies.people.population import Population as People
from tendon_cli.studies.values import RIGID

MOST_SIZES = 3
_MOST_ALONG = 16  # values of an axis among which sizes are chosen
_MOST_PERSONS = 1000  # persons by whom sizes are chosen: the first so many, as the search grows with their square
_MOST_OF_CURVE = 1000
_MOST_NAMES = 100


@dataclass(frozen=True, eq=False)
class GroupWindows:
    """The windows of groups, such as persons, of one choice over their other conditions, each of shape (groups,)."""

    low: Array  # N; empty where low > high, NaN where no pretension could do
    high: Array
    low_by: Codes  # index into `LIMIT_NAMES`, or -1
    high_by: Codes
    low_condition: Rows  # the row of conditions that binds
    high_condition: Rows

    @classmethod
    def of(cls, problem: Problem, columns: ColumnArrays) -> GroupWindows:
        """Those of all groups of a question, for one choice."""
        windows = problem.windows(problem.numbers_of(columns), 1)
        shape = (int(problem.groups[-1]) + 1, -1)
        low, high = windows.low.reshape(shape), windows.high.reshape(shape)
        at_low, at_high = np.argmax(low, axis=1), np.argmin(high, axis=1)  # NaN counts as the first
        first, rows = np.arange(shape[0]) * low.shape[1], np.arange(shape[0])
        codes = (
            windows.low_by.reshape(shape)[rows, at_low],
            windows.high_by.reshape(shape)[rows, at_high],
        )
        return cls(low[rows, at_low], high[rows, at_high], *codes, first + at_low, first + at_high)

    def served(self, pretension: float) -> Flags:
        """Which of them a pretension serves."""
        return serves(self.low, self.high, pretension)


def people_of(problem: Problem) -> People | None:
    """Whose windows are asked for; None if they are those of draws."""
    study = problem.study
    return (
        study.people.population if study.people is not None and PERSON_AXIS in study.axes else None
    )


def person_of(problem: Problem, groups: Rows) -> Rows:
    """The row of the population that each of some groups belongs to, for a question of people."""
    return groups // (len(problem.axes[DRAW_AXIS]) if DRAW_AXIS in problem.axes else 1)


def population(
    problem: Problem, chosen: Solutions, row: dict[str, Any], windows: GroupWindows
) -> dict[str, Any]:
    """What a choice, `row` of the table, is to persons or draws, whose windows these are; as recorded."""
    weighting, people = problem.weighting, people_of(problem)
    pretension, served, most = (
        chosen.scalar(name) for name in ("pretension", "served_at", "served")
    )
    curve = coverage.curve(windows.low, windows.high, weighting)
    count = len(curve.pretension)
    kept = np.unique(np.linspace(0, count - 1, min(count, _MOST_OF_CURVE)).round().astype(np.int64))
    record = {
        "choice": row["choice"],
        "values": {axis.column: row[axis.column] for axis in problem.choices.axes},
        "kind": problem.counted,
        "count": len(windows.low),
        "effective_count": effective_count(weighting),
        "counts": problem.counts,
        "window": [row["pretension_from"], row["pretension_to"]],
        "pretension": row["pretension"],
        "served": served,
        "interval_95": list(say.interval(served, effective_count(weighting))),
        "largest_share": most,
        "largest_share_at": curve.best if most > 0.0 else None,
        "set": {} if people is None else _set(problem, chosen),
        "by": [] if people is None else _by_sex(problem, people, windows.served(pretension)),
        "curve": {name: values[kept].tolist() for name, values in vars(curve).items()},
        "not_served": not_served(problem, windows, pretension),
        "sizes": {} if people is None else dict(_sizes(problem, chosen)),
        "sobol": indices(problem, problem.numbers_of(chosen.columns)),
    }
    at = "" if row["pretension"] is None else f"{say.number(row['pretension'])} N "
    what = row_words(problem.choices, record["values"])
    return record | {
        "title": ", ".join(filter(None, (what, f"{at}serves {population_share(record)}")))
    }


def _set(problem: Problem, chosen: Solutions) -> dict[str, list[float]]:
    """What gauges show on nine persons of ten, of few on all, at the choice's pretension: from, to, N."""
    axis = problem.group_axis
    if axis is None:
        return {}
    numbers, each = problem.numbers_of(chosen.columns), chosen["pretension"][:1]
    values = settings(study_arm(problem, numbers, each, axis), len(axis))
    ends = (0.05, 0.95) if problem.counts[PERSON_AXIS] >= FEW else (0.0, 1.0)
    return {name: np.quantile(shown, ends).tolist() for name, shown in values.items()}


def _by_sex(problem: Problem, people: People, served: Flags) -> list[dict[str, Any]]:
    """The share that the pretension serves among men and among women."""
    if problem.study.design.by != "sex":
        return []
    weighting, shares = problem.weighting, []
    rows = person_of(problem, np.arange(len(weighting)))
    sexes = np.array(people.sexes)[rows]
    for sex in dict.fromkeys(sexes.tolist()):
        of_sex = np.flatnonzero(sexes == sex)
        weights = normalised(weighting[of_sex])
        share = 1.0 if served[of_sex].all() else float(min(weights[served[of_sex]].sum(), 1.0))
        persons = len(np.unique(rows[of_sex] // people.completions))
        effective = effective_count(weighting[of_sex]) * persons / len(of_sex)
        shares.append(
            {
                "sex": sex,
                "persons": persons,
                "served": share,
                "interval_95": [*say.interval(share, effective)],
            }
        )
    return shares


def not_served(problem: Problem, windows: GroupWindows, pretension: float) -> list[dict[str, Any]]:
    """Those whom a pretension (N) does not serve, by reason, the most frequent first, as recorded.

    Of each reason the limit that is not kept, or if no pretension would do, both that conflict; for each limit the
    condition under which most of them meet it; and who they are, the farthest first.
    """
    people, weights = people_of(problem), normalised(problem.weighting)
    out = np.flatnonzero(~windows.served(pretension))
    low, high = windows.low[out], windows.high[out]
    needs = np.where(low <= high, np.where(low > pretension, MORE, LESS), NEITHER)
    missing = np.fmax(low - pretension, pretension - high)
    above, below = (
        np.where(needs == LESS, -1, windows.low_by[out]),
        np.where(needs == MORE, -1, windows.high_by[out]),
    )
    kinds, reasons = [*zip(needs.tolist(), above.tolist(), below.tolist(), strict=True)], []
    for need, *codes in dict.fromkeys(kinds):
        places = [at for at, kind in enumerate(kinds) if kind == (need, *codes)]
        members = out[places][np.argsort(-missing[places], kind="stable")]
        by = {
            LIMIT_NAMES[code]: end
            for code, end in zip(codes[::-1], ("high", "low"), strict=True)
            if code >= 0
        }
        limits = [*by][::-1]
        conditions = [
            _usual(problem, getattr(windows, f"{by[limit]}_condition")[members]) for limit in limits
        ]
        share, names, bodies = (
            float(weights[members].sum()),
            list[str](),
            dict[str, dict[str, float]](),
        )
        if people is not None:
            rows = person_of(problem, members)
            names = list(
                dict.fromkeys(people.persons[at] for at in (rows // people.completions).tolist())
            )
            bodies = dict(_differences(people, rows))
        reasons.append(
            {
                "text": why_not(problem, limits, conditions),
                "needs": need,
                "limits": limits,
                "conditions": conditions,
                "count": len(members),
                "share": share,
                "interval_95": list(say.interval(share, effective_count(weights))),
                "first": names[:_MOST_NAMES],
                "bodies": bodies,
            }
        )
    return sorted(reasons, key=lambda reason: (-reason["share"], -reason["count"]))


def _usual(problem: Problem, conditions: Rows) -> int:
    """The condition that binds most of some groups, as that of the first group in which it does."""
    each = len(problem.conditions) // (int(problem.groups[-1]) + 1)
    within = conditions % each
    return int(conditions[np.argmax(within == np.bincount(within).argmax())])


def _differences(people: People, members: Rows) -> Iterator[tuple[str, dict[str, float]]]:
    """The dimensions in which some persons differ from everyone, SI, the largest difference first."""
    weights = normalised(people.weighting)
    mean = weights @ people.values
    deviation = np.sqrt(weights @ np.square(people.values - mean))
    theirs = people.values[members].mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.where(deviation > 0.0, (theirs - mean) / deviation, 0.0)
    for at in np.argsort(-np.abs(apart), kind="stable"):
        each = {
            "theirs": float(theirs[at]),
            "of_all": float(mean[at]),
            "deviations": float(apart[at]),
        }
        yield DIMENSIONS[at], each


def _sizes(problem: Problem, chosen: Solutions) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """For each axis of the choices the best few suits along it, all else as in the one chosen."""
    draws = len(problem.weighting) // problem.counts[PERSON_AXIS]
    persons = min(problem.counts[PERSON_AXIS], _MOST_PERSONS)
    each = len(problem.conditions) // len(problem.weighting)
    some = problem.under(np.arange(persons * each * draws))
    for axis in problem.choices.axes:
        along = np.unique(
            np.linspace(0, len(axis) - 1, min(len(axis), _MOST_ALONG)).round().astype(np.int64)
        )
        if len(along) < 2:
            continue
        columns = {
            name: np.repeat(values[:1], len(along)) for name, values in chosen.columns.items()
        }
        columns[axis.column] = along if axis.names else axis.values[along]
        windows = some.ends(problem.numbers_of(columns), len(along))
        low, high = grouped(windows.low, windows.high, problem.groups[: persons * each * draws])
        if draws > 1:  # the window of a person is of enough of the draws
            pairs = (low.reshape(-1, draws), high.reshape(-1, draws))
            covered = coverage.share_served(*pairs, np.ones(draws), enough=problem.enough)
            low, high = covered.low.reshape(len(low), -1), covered.high.reshape(len(low), -1)
        best = best_sizes(
            low,
            high,
            problem.weighting[: persons * draws : draws],
            MOST_SIZES,
            problem.check_stopped,
        )
        yield axis.column, [_size(axis, along, sizes, persons) for sizes in best]


def _size(axis: Axis, along: Rows, sizes: Sizes, persons: int) -> dict[str, Any]:
    values = [axis.names[at] if axis.names else float(axis.values[at]) for at in along.tolist()]
    suits = [
        (values[at], pretension)
        for at, pretension in zip(sizes.choices, sizes.pretensions, strict=True)
    ]
    return {
        "choices": [
            {"value": RIGID if value == np.inf else value, "pretension": at} for value, at in suits
        ],
        "served": sizes.share,
        "interval_95": list(say.interval(sizes.share, persons)),
        "persons": persons,
        "values_tried": len(along),
        "all_values": len(along) == len(axis),
    }
