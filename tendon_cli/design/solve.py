"""What each choice comes to: its window, what binds, who is served, and the worst at its pretension."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.design.coverage import ROUNDING, grouped, share_served
from tendon_cli.design.factors import Numbers
from tendon_cli.design.problem import Flags, Problem, Rows
from tendon_cli.model import extremes
from tendon_cli.model.actuator import Situation
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import Codes, contact_pressure
from tendon_cli.model.window import Window

Kind = TypeVar("Kind", bound=np.generic)

WORST = (
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_contact_pressure",
)
"""What is told of a choice at its pretension, over all conditions that this serves."""

_DESIGNS_AT_ONCE = 2**20
"""Windows of choices under conditions that are held at once."""


@dataclass(frozen=True, eq=False)
class Solutions:
    """Results of choices, (choices,), as `choices.parquet` has them; NaN where there is none."""

    pretension_from: Array
    """N; over all conditions, or where enough is served. Empty where from > to, NaN where no pretension could do."""
    pretension_to: Array
    """N; infinite where nothing bounds it."""
    windows: npt.NDArray[np.int64]
    """How many intervals serve enough; the widest is told."""
    from_by: Codes
    """Index into `limits.LIMIT_NAMES`, or NOTHING."""
    to_by: Codes
    from_condition: Rows
    to_condition: Rows
    from_state: Rows
    """The state that binds, by its place among directions and angles; -1 where the limit belongs to none."""
    to_state: Rows
    served: Array
    """The largest share that one pretension serves."""
    pretension: Array
    """In the window, or where that is empty, one that serves most, N."""
    max_tension: Array
    max_spring_extension: Array
    peak_motor_torque: Array
    min_elbow_stiffness: Array
    max_contact_pressure: Array

    @property
    def feasible(self) -> Flags:
        """Whether a choice has a window."""
        return np.asarray(self.pretension_from <= self.pretension_to)

    @property
    def tolerance(self) -> Array:
        """(to - from)/(to + from), the share by which the pretension may be off; 1 where nothing bounds it above."""
        with np.errstate(invalid="ignore", divide="ignore"):
            share = (self.pretension_to - self.pretension_from) / (self.pretension_to + self.pretension_from)
        # Of a window from 0 to 0 nothing may be off.
        share = np.where(np.isinf(self.pretension_to), 1.0, np.where(self.pretension_to == 0.0, 0.0, share))
        return np.where(self.feasible, share, np.nan)

    def column(self, name: str) -> Array:
        """A result by its name, as numbers."""
        return np.asarray(getattr(self, name), dtype=np.float64)

    def taken(self, rows: Rows | slice | Flags) -> Solutions:
        """Some of the choices."""
        return Solutions(**{each.name: getattr(self, each.name)[rows] for each in fields(self)})

    @classmethod
    def joined(cls, parts: list[Solutions]) -> Solutions:
        """The choices of several, one after the other."""
        return cls(**{each.name: np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(cls)})


def solve(problem: Problem, numbers: Numbers, count: int, *, with_worst: bool = True) -> Solutions:
    """Solve `count` choices, whose numbers have the shape (count,). Without the worst it takes a third of the time."""
    step = max(1, _DESIGNS_AT_ONCE // len(problem.conditions))
    parts = []
    for at in range(0, max(count, 1), step):
        some = {key: values[at : at + step] for key, values in numbers.items()}
        parts.append(_solve(problem, some, min(step, count - at), with_worst))
    return Solutions.joined(parts)


def _solve(problem: Problem, numbers: Numbers, count: int, with_worst: bool) -> Solutions:
    found = problem.windows(numbers, count)
    low, high, from_condition, to_condition, windows, served, best = _common(problem, found)
    pretension = np.where(low <= high, _within(problem, low, high), _within(problem, *best))
    if with_worst:
        rest = worst(problem, numbers, pretension, _held(problem, found, pretension))
    else:
        rest = dict.fromkeys(WORST, np.full(count, np.nan))
    return Solutions(
        pretension_from=low,
        pretension_to=high,
        windows=windows,
        from_by=_taken(found.low_by, from_condition),
        to_by=_taken(found.high_by, to_condition),
        from_condition=from_condition,
        to_condition=to_condition,
        from_state=_taken(found.low_state, from_condition),
        to_state=_taken(found.high_state, to_condition),
        served=served,
        pretension=pretension,
        **rest,
    )


def _common(
    problem: Problem, found: Window
) -> tuple[Array, Array, Rows, Rows, npt.NDArray[np.int64], Array, tuple[Array, Array]]:
    """The window over all conditions, or where enough is served; its binding conditions; and what is best served."""
    groups, weighting = problem.groups, problem.weighting
    # A condition that no pretension suits leaves no window at all, and is the reason: argmax takes the first NaN.
    from_condition, to_condition = np.argmax(found.low, axis=1), np.argmin(found.high, axis=1)
    low, high = _taken(found.low, from_condition), _taken(found.high, to_condition)
    is_open = low <= high
    windows, served = is_open.astype(np.int64), np.where(is_open, 1.0, 0.0)
    best_low, best_high = np.where(is_open, low, np.nan), np.where(is_open, high, np.nan)
    rest = np.flatnonzero(~is_open)
    if not rest.size:
        return low, high, from_condition, to_condition, windows, served, (best_low, best_high)
    of_groups = grouped(found.low[rest], found.high[rest], groups)
    covered = share_served(*of_groups, weighting, enough=problem.enough)
    served[rest], best_low[rest], best_high[rest] = covered.served, covered.best_low, covered.best_high
    if problem.enough < 1.0:
        windows[rest] = covered.windows
        for end, ends, value, condition in (
            (low, found.low, covered.low, from_condition),
            (high, found.high, covered.high, to_condition),
        ):
            some = ~np.isnan(value)
            end[rest[some]] = value[some]
            served_group = np.repeat(of_groups[0] <= of_groups[1], np.bincount(groups), axis=1)
            binds = (ends[rest] == value[:, np.newaxis]) & served_group
            condition[rest[some]] = np.argmax(binds[some], axis=1)
    return low, high, from_condition, to_condition, windows, served, (best_low, best_high)


def _taken(values: npt.NDArray[Kind], condition: Rows) -> npt.NDArray[Kind]:
    taken: npt.NDArray[Kind] = np.take_along_axis(values, condition[:, np.newaxis], axis=1)[:, 0]
    return taken


def _within(problem: Problem, low: Array, high: Array) -> Array:
    """Where in its window a choice is set; twice the least pretension where nothing bounds it above."""
    if not problem.middle:
        return low
    return np.where(np.isinf(high), 2.0 * low, 0.5 * (low + high))


def _held(problem: Problem, found: Window, pretension: Array) -> Flags:
    """Which conditions a pretension serves, (choices, conditions): those of the groups that it serves altogether."""
    at = pretension[:, np.newaxis]
    with np.errstate(invalid="ignore"):
        held = (found.low <= at * (1 + ROUNDING)) & (at <= found.high * (1 + ROUNDING))
    if len(problem.weighting) == held.shape[1]:
        return held
    firsts = np.flatnonzero(np.diff(problem.groups, prepend=-1))
    return np.repeat(np.logical_and.reduceat(held, firsts, axis=1), np.bincount(problem.groups), axis=1)


def worst(problem: Problem, numbers: Numbers, pretension: Array, held: Flags) -> dict[str, Array]:
    """The worst of every quantity over the conditions that are held at a pretension, (choices,)."""
    largest = np.full((6, len(pretension)), np.nan)
    for rows, conditions in problem.chunks(len(pretension)):
        part = {key: values[rows] for key, values in numbers.items()}
        under = {key: values[conditions] for key, values in problem.condition_numbers.items()}
        design = problem.design(part, under, pretension[rows])
        found = _extremes(problem, design, held[rows, conditions].shape)
        quantities = (
            found["max_tension"],
            found["max_spring_extension"],
            found["highest_motor_torque"],
            -found["lowest_motor_torque"],
            -found["min_elbow_stiffness"],
            contact_pressure(design, found["max_extensor_distal"][..., np.newaxis, np.newaxis])[..., 0, 0],
        )
        for at, values in enumerate(quantities):
            here = np.fmax.reduce(np.where(held[rows, conditions], values, np.nan), axis=1)
            largest[at, rows] = np.fmax(largest[at, rows], here)
    tension, extension, forward, backward, softness, pressure = largest
    torque = np.where(backward > forward, -backward, forward)
    return dict(zip(WORST, (tension, extension, torque, -softness, pressure), strict=True))


def _extremes(problem: Problem, design: Design, shape: tuple[int, ...]) -> extremes.Found:
    """What designs of a shape, (choices, conditions), come to over all their states."""
    found, states = extremes.begin(shape), (*shape, problem.flexion.size, problem.angles.size)
    kernel.fold_extremes(
        found, Situation.of(design, problem.angles, problem.flexion), problem.angles.ravel(), states
    )  # fmt: skip
    return found
