"""Where the uncertainty of a window comes from: Sobol indices of uncertain numbers, and of bodies as one group."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.answers.coverage import grouped, normalised
from tendon_cli.answers.problem import Problem
from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, Axis, Numbers
from tendon_cli.space.space import Space
from tendon_cli.studies.people.population import Population
from tendon_cli.studies.values import quantile

BODY = "body"
"""All dimensions of a body together: they are correlated, so that none has an index of its own."""

_STATES = 2e7
"""Most states that are worked out for the indices."""
_MOST, _FEWEST = 4096, 64
_RESAMPLES = 200


@dataclass(frozen=True, eq=False)
class Indices:
    """Sobol indices of one end of the window: shares of its variance."""

    end: str
    """"pretension_from" or "pretension_to"."""
    inputs: tuple[str, ...]
    """Dotted keys of the uncertain numbers, and BODY."""
    first: Array
    """The share of variance that knowing an input would take away, (inputs,)."""
    total: Array
    """The share that remains as long as only this input is not known, (inputs,)."""
    first_error: Array
    """Standard errors."""
    total_error: Array
    deviation: float
    """Standard deviation of the end, N."""


Ends = Callable[[Array], Array]
"""From points of the unit cube, (points, inputs), to results, (results, points)."""


def sobol(ends: Ends, inputs: tuple[str, ...], names: tuple[str, ...], count: int, seed: int) -> list[Indices]:
    """First-order and total indices of results by Saltelli's design of `count` (a power of two) Sobol points.

    Standard errors are of the bootstrap. A result that is not finite everywhere, or never changes, has no indices.
    """
    from scipy import stats  # only uncertain numbers pay for its import

    last: list[Array] = []

    def func(points: Array) -> Array:
        values = ends(points.T)
        last.append(values)
        usable = np.isfinite(values).all(axis=1) & (np.ptp(values, axis=1) > 0.0)
        # scipy wants finite numbers that vary; what has none is left out below.
        return np.where(usable[:, np.newaxis], values, points.sum(axis=0))

    sampled: list[tuple[Array, Array, Array]] = []

    def method(f_A: Array, f_B: Array, f_AB: Array) -> tuple[Array, Array]:  # noqa: N803 - the names scipy asks for
        sampled.append((f_A, f_B, f_AB))
        return _first_and_total(f_A, f_B, f_AB)

    random = np.random.default_rng([seed, 7])
    result = stats.sobol_indices(func=func, n=count, dists=[_Share()] * len(inputs), method=method, rng=random)
    # The result's own bootstrap draws anew each time, so that the same question would not have the same answer.
    draws = random.integers(count, size=(_RESAMPLES, count))
    first_error, total_error = np.std([_first_and_total(*sampled[0], some) for some in draws], axis=0, ddof=1)
    everywhere = np.concatenate(last, axis=1)
    results = []
    for at, name in enumerate(names):
        values = everywhere[at]
        if not np.isfinite(values).all() or np.ptp(values) == 0.0:
            continue
        each = (result.first_order, result.total_order, first_error, total_error)
        # scipy drops axes of one result or one input.
        first, total, *errors = (np.reshape(row, (len(names), -1))[at] for row in each)
        results.append(Indices(name, inputs, first, total, errors[0], errors[1], float(np.std(last[0][at]))))
    return results


def _first_and_total(
    a: Array, b: Array, mixed: Array, some: npt.NDArray[np.int64] | slice = slice(None)
) -> tuple[Array, Array]:
    """Indices, (results, inputs), from some points of two samples, (results, points), and of mixed ones.

    Those are the first with each input from the second, (inputs, results, points): Saltelli et al. 2010, table 2, (b)
    and (f).
    """
    a, b, mixed = a[:, some], b[:, some], mixed[..., some]
    variance = np.var(np.stack([a, b]), axis=(0, -1))
    with np.errstate(divide="ignore", invalid="ignore"):
        first = np.mean(b * (mixed - a), axis=-1) / variance
        total = 0.5 * np.mean(np.square(a - mixed), axis=-1) / variance
    return first.T, total.T


class _Share:
    """A number from 0 to 1, from which `ends` works out what it stands for."""

    def ppf(self, share: Any) -> Any:
        """The share itself."""
        return share


def indices(problem: Problem, numbers: Numbers) -> list[Indices]:
    """The indices of both ends of one choice's window over all its conditions but persons and draws."""
    study = problem.study
    if study.uncertainty is None or not study.uncertain:
        return []
    people = study.people.population if study.people is not None else None
    whose = next((factor for factor in problem.conditions.axes if factor.key == PERSON_AXIS), None)
    inputs = (*study.uncertain, *((BODY,) if whose is not None and len(whose) > 1 else ()))
    others = [each for each in problem.conditions.axes if each.key not in (PERSON_AXIS, DRAW_AXIS)]
    each_point = problem.states_per_design * max(1, int(np.prod([len(factor) for factor in others])))
    count = _power_of_two(_STATES / (each_point * (len(inputs) + 2)))

    def ends(points: Array) -> Array:
        drawn: dict[str, Array] = {}
        if whose is not None and people is not None:
            drawn |= _of_persons(whose, people, points[:, -1])
        drawn |= {key: quantile(known, points[:, at]) for at, (key, known) in enumerate(study.uncertain.items())}
        axis = replace(Axis.of_points(drawn), key=DRAW_AXIS)
        asked = replace(problem, conditions=Space((axis, *others)).grouped())
        windows = asked.ends(numbers, 1)
        low, high = grouped(windows.low, windows.high, asked.groups)
        return np.concatenate([low, high])

    return sobol(ends, inputs, ("pretension_from", "pretension_to"), count, study.uncertainty.seed)


def _of_persons(whose: Axis, people: Population, shares: Array) -> dict[str, Array]:
    """What the persons at some shares of the weighting say of the study's numbers."""
    upto = np.cumsum(normalised(people.weighting))
    persons = np.minimum(np.searchsorted(upto, shares, side="right"), len(people) - 1)
    return {key: values[persons] for key, values in whose.numbers.items()}


def _power_of_two(most: float) -> int:
    return int(2 ** np.clip(np.floor(np.log2(max(most, 1.0))), np.log2(_FEWEST), np.log2(_MOST)))
