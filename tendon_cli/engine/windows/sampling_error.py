"""Error of the ends of a window that are only sampled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tendon_cli.engine.windows.question import Question
from tendon_cli.engine.windows.solutions import Solutions
from tendon_cli.engine.windows.solver import Folded, Solver
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.motion_window import window_along
from tendon_cli.model.power_window import within_power
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.model.window import Ends, Window, as_read, with_binding_limits
from tendon_cli.studies.measured_motion import at_times

_DENSER = 16
"""Factor by which samples are made denser to estimate the error of an end."""
_DENSER_IN_TIME = (12, 17)
"""More such factors along a trajectory.

Where a tendon turns for a moment, what samples find jumps from one factor to the next, and with it
the end of the window.
"""
_MOST_NEAR = 16
"""Most conditions at each end for which its error is estimated: the tightest."""
_MOST_SAMPLES = 2**12
"""Most samples of a trajectory, times the conditions, in an estimate."""
# The dense samples miss at most 3 % of an error near the ends of the motion, and elsewhere 1.2 % of
# the largest error; the rest is reserve.
_SAFE = 1.1
"""Factor on the error that dense samples find."""
_SAFE_IN_TIME = 1.5
"""The same along a trajectory, where in 1 of 1,000 random motions the error was 1.3 times as large
as three densities find.
"""
_MISSED = 0.05
"""Share of the largest error that is added for the error that dense samples miss."""
_ROUNDING = 1e-6
"""Error that is added for rounding, N."""


def estimate_error(solver: Solver, choice: Solutions, folded: Folded) -> float | None:
    """Estimate the error of a window's ends that are only sampled, N, as they are read.

    Ends that power sets are sampled, and all ends along a trajectory. The estimate is the amount by
    which samples sixteen times as dense narrow the window, plus a share of the largest error of
    samples with the original step, displaced by parts of it. Along a trajectory it is the largest
    amount by which samples of three densities narrow the window.

    Args:
        solver: Solver of the question.
        choice: The solved choice.
        folded: Ends of its windows over all angles, (1, conditions).

    Returns:
        The estimate; None if no end is sampled, if there is a single angle, or if it is
            infinite: the window may be empty.
    """
    question = solver.question.for_choice(choice.points)
    trajectory = question.study.trajectory
    is_still = trajectory is None and question.angles.size == 1
    if is_still or (not question.bounds.asks_power and trajectory is None):
        return None
    within = solver.read(folded, choice.points)
    most = _MOST_NEAR
    if trajectory is not None:
        most = max(1, min(_MOST_NEAR, _MOST_SAMPLES // len(trajectory.time)))
    rows = np.unique(
        [
            *_tightest_conditions(within.low[0], choice.pretension_from[0], most),
            *_tightest_conditions(-within.high[0], -choice.pretension_to[0], most),
        ]
    )
    design = question.paired_designs(choice.points, np.zeros_like(rows), rows)
    if trajectory is None:
        of_states = Ends(**{name: values[0, rows] for name, values in vars(folded.ends).items()})
        ends_over = _ends_over_angles(question, design, of_states)
        places = question.angles[0]
    else:
        ends_over = _ends_over_times(question, design, trajectory)
        places = trajectory.time
    displaced, finest = _displaced_samples(places)
    dense = [finest] if trajectory is None else [finest, *_evenly_denser(places)]
    tightest = np.max([ends_over(samples) for samples in dense], axis=0)
    with np.errstate(invalid="ignore"):
        errors = [
            np.nan_to_num(tightest - ends_over(samples), nan=0.0, posinf=np.inf)
            for samples in displaced
        ]
    safe = _SAFE if trajectory is None else _SAFE_IN_TIME
    found = safe * np.maximum(errors[0], 0.0)
    missed = _MISSED * np.max(np.abs(errors), axis=0)
    estimate = float(np.max(found + missed) + _ROUNDING)
    return estimate if np.isfinite(estimate) else None


def _tightest_conditions(ends: Array, common: float, most: int) -> Rows:
    """Return the `most` conditions with the largest ends that do not exceed the common one."""
    return np.argsort(-np.where(ends <= common, ends, -np.inf))[:most]


def _displaced_samples(places: Array) -> tuple[list[Array], Array]:
    """Return samples displaced by parts of a step, and all of them with more near the ends.

    Args:
        places: Evenly spaced angles (rad) or times (s).
    """
    first = places[0]
    last = places[-1]
    step = (last - first) / (len(places) - 1)
    displaced = []
    for share in np.arange(_DENSER) / _DENSER:
        samples = np.append(places[:-1] + share * step, [first, last])
        displaced.append(np.unique(np.minimum(samples, last)))
    near_ends = step * 2.0 ** (-0.5 * np.arange(1, 2 * _DENSER))
    finest = np.unique(np.concatenate([*displaced, first + near_ends, last - near_ends]))
    return displaced, finest


def _evenly_denser(places: Array) -> list[Array]:
    """Return evenly spaced times, s, of the factors in `_DENSER_IN_TIME`."""
    steps = len(places) - 1
    return [np.linspace(places[0], places[-1], factor * steps + 1) for factor in _DENSER_IN_TIME]


def _ends_over_angles(
    question: Question, design: Design, of_states: Ends
) -> Callable[[Array], Array]:
    """Return a function from the angles of the whole motion, rad, to `_common_ends`.

    Args:
        question: The question.
        design: One choice under some conditions.
        of_states: Ends that limits on forms set, (conditions,), as F0.
    """
    windows = with_binding_limits(
        of_states, design, question.angles, question.flexion, question.bounds
    )

    def ends(angles: Array) -> Array:
        """Return `_common_ends` of windows with power taken at angles, rad."""
        within = within_power(
            windows, design, angles[np.newaxis], question.flexion, question.bounds, question.loads
        )
        return _common_ends(as_read(within, design))

    return ends


def _ends_over_times(
    question: Question, design: Design, trajectory: Trajectory
) -> Callable[[Array], Array]:
    """Return a function from the times of a trajectory's samples, s, to `_common_ends`."""

    def ends(times: Array) -> Array:
        """Return `_common_ends` of windows with the trajectory taken at times, s."""
        motion = at_times(trajectory, times)
        along = replace(design, trajectory=motion)
        windows = window_along(along, motion, question.bounds)
        return _common_ends(as_read(windows, design))

    return ends


def _common_ends(windows: Window) -> Array:
    """Return the lower and the negated upper end of the common window, N; infinite if NaN."""
    ends = np.array([windows.low.max(), -windows.high.min()])
    return np.where(np.isnan(ends), np.inf, ends)
