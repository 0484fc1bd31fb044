"""By how much a window may be off that is sampled: what denser angles take from it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tendon_cli.answers.question import Problem
from tendon_cli.answers.solve import Solutions
from tendon_cli.model.kinematics import Array
from tendon_cli.model.motor_window import narrowed
from tendon_cli.model.window import Window, as_read
from tendon_cli.space.axis import Numbers

_GRIDS, _MOST_NEAR = 16, 16
"""How much denser, and for how many of the conditions that are tightest at either end."""
_SAFE, _MISSED, _LEAST = 1.1, 0.05, 1e-6
"""The dense grid misses at most 3 % of what is missed near an end, and elsewhere 1.2 % of the worst; the rest is
room. N for what is rounded."""


def estimated(problem: Problem, numbers: Numbers, one: Solutions) -> float | None:
    """By how much the ends that limits on the whole motion set may be off, N, as they are read.

    It is what a grid sixteen times as dense takes from the window of the conditions that it serves. That grid misses,
    too: of a peak between two angles a share of what grids as wide as the window's, displaced by shares of a step, miss
    at worst; of one near the first or last angle, which all grids hold, a share of what the window's misses.
    """
    if not problem.bounds.of_motion:
        return None
    ends, window = problem.ends(numbers, 1), (one["pretension_from"][0], one["pretension_to"][0])
    low, high = (
        np.where(each[0] * sign <= end * sign, each[0] * sign, -np.inf)
        for each, end, sign in zip((ends.low, ends.high), window, (1.0, -1.0), strict=True)
    )
    rows = np.unique([*np.argsort(-low)[:_MOST_NEAR], *np.argsort(-high)[:_MOST_NEAR]])
    found = replace(problem, bounds=problem.bounds.of_states).windows(numbers, 1)
    some = Window(**{name: values[0, rows] for name, values in vars(found).items()})
    design = problem.paired(numbers, np.zeros_like(rows), rows)

    def ends_over(angles: Array) -> Array:
        grid = np.unique(angles)[np.newaxis]
        each = as_read(narrowed(some, design, grid, problem.flexion, problem.bounds, problem.loads).window, design)
        return np.array([each.low.max(), -each.high.min()])

    angles, step = problem.angles[0], np.diff(problem.angles)[0, 0]
    displaced = [np.append(angles[:-1] + share * step, angles[[0, -1]]) for share in np.arange(_GRIDS) / _GRIDS]
    near_ends = step * 2.0 ** (-0.5 * np.arange(1, 2 * _GRIDS))
    finest = ends_over(np.concatenate([*displaced, angles[0] + near_ends, angles[-1] - near_ends]))
    with np.errstate(invalid="ignore"):
        off = [np.nan_to_num(finest - ends_over(grid), nan=0.0, posinf=np.inf) for grid in displaced]
    estimate = float(np.max(_SAFE * np.maximum(off[0], 0.0) + _MISSED * np.max(off, axis=0)) + _LEAST)
    return estimate if np.isfinite(estimate) else None
