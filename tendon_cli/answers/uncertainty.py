"""Where the uncertainty of a window comes from: Sobol indices of uncertain numbers, and of bodies as one group."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tendon_cli.answers.coverage import grouped, normalised
from tendon_cli.answers.question import Problem
from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, Axis, Numbers
from tendon_cli.space.space import Space
from tendon_cli.studies.values import quantile

BODY = "body"
"""All dimensions of a body together: they are correlated, so that none has an index of its own."""

_STATES = 2e7
"""Most states that are worked out for the indices."""
_MOST, _FEWEST = 4096, 64
_RESAMPLES = 200

Ends = Callable[[Array], Array]
"""From points of the unit cube, (points, inputs), to results, (results, points)."""


def sobol(ends: Ends, inputs: tuple[str, ...], names: tuple[str, ...], count: int, seed: int) -> Iterator[Any]:
    """First-order and total indices of results by Saltelli's design of `count` (a power of two) Sobol points.

    Standard errors are of the bootstrap. A result that is not finite everywhere, or never changes, has no indices.
    """
    from scipy import stats  # only uncertain numbers pay for its import

    random, width = np.random.default_rng([seed, 7]), len(inputs)
    a, b = np.split(stats.qmc.Sobol(2 * width, rng=random, bits=64).random(count), 2, axis=1)
    mixed = [np.where(np.arange(width) == at, b, a) for at in range(width)]
    results = ends(np.concatenate([a, b, *mixed])).reshape(len(names), width + 2, count)
    # The result's own bootstrap draws anew each time, so that the same question would not have the same answer.
    draws = random.integers(count, size=(_RESAMPLES, count))

    def indices(values: Array) -> Array:
        """Saltelli et al. 2010, table 2, (b) and (f)."""
        of_a, of_b, of_mixed = values[0], values[1], values[2:]
        first = np.mean(of_b * (of_mixed - of_a), axis=-1)
        total = 0.5 * np.mean(np.square(of_a - of_mixed), axis=-1)
        return np.asarray(np.stack([first, total]) / np.var(values[:2]))

    for name, values in zip(names, results, strict=True):
        if not np.isfinite(values).all() or np.ptp(values) == 0.0:
            continue
        apart = values - values[:2].mean()
        first_error, total_error = np.std([indices(apart[:, some]) for some in draws], axis=0, ddof=1)
        first, total = indices(apart)
        columns = {"first": first, "first_standard_error": first_error}
        columns |= {"total": total, "total_standard_error": total_error}
        of_inputs = {key: {what: float(row[at]) for what, row in columns.items()} for at, key in enumerate(inputs)}
        yield {"end": name, "standard_deviation": float(np.std(values[0])), "inputs": of_inputs}


def indices(problem: Problem, numbers: Numbers) -> list[dict[str, Any]]:
    """The indices of both ends of one choice's window over all its conditions but persons and draws, as recorded."""
    study = problem.study
    if study.uncertainty is None or not study.uncertain:
        return []
    people = study.people.population if study.people is not None else None
    whose = next((axis for axis in problem.conditions.axes if axis.key == PERSON_AXIS), None)
    inputs = (*study.uncertain, *((BODY,) if whose is not None and len(whose) > 1 else ()))
    others = [each for each in problem.conditions.axes if each.key not in (PERSON_AXIS, DRAW_AXIS)]
    each_point = problem.states_per_design * max(1, int(np.prod([len(axis) for axis in others])))
    most = max(_STATES / (each_point * (len(inputs) + 2)), 1.0)
    count = int(2 ** np.clip(np.floor(np.log2(most)), np.log2(_FEWEST), np.log2(_MOST)))

    def ends(points: Array) -> Array:
        drawn: dict[str, Array] = {}
        if whose is not None and people is not None:  # the persons at these shares of the weighting
            up_to = np.cumsum(normalised(people.weighting))
            persons = np.minimum(np.searchsorted(up_to, points[:, -1], side="right"), len(people) - 1)
            drawn |= {key: values[persons] for key, values in whose.numbers.items()}
        drawn |= {key: quantile(known, points[:, at]) for at, (key, known) in enumerate(study.uncertain.items())}
        axis = replace(Axis.of_points(drawn), key=DRAW_AXIS)
        asked = replace(problem, conditions=Space((axis, *others)).grouped())
        windows = asked.ends(numbers, 1)
        return np.concatenate(grouped(windows.low, windows.high, asked.groups))

    return list(sobol(ends, inputs, ("pretension_from", "pretension_to"), count, study.uncertainty.seed))
