"""What each choice comes to: its window, what binds, who is served, and the worst at its pretension."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.answers.coverage import ROUNDING, grouped, normalised, share_served
from tendon_cli.answers.problem import Flags, Problem
from tendon_cli.model import extremes
from tendon_cli.model.actuator import Situation
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import Codes, contact_pressure
from tendon_cli.model.window import Ends
from tendon_cli.space.axis import Numbers, Rows

Kind = TypeVar("Kind", bound=np.generic)

WORST = (
    "max_tension", "max_spring_extension", "peak_motor_torque", "min_elbow_stiffness", "max_contact_pressure",
)  # fmt: skip
"""Columns of a choice at its pretension: the worst over all conditions that this serves."""

_DESIGNS_AT_ONCE = 2**20
"""Windows of choices under conditions that are held at once."""


@dataclass(frozen=True, eq=False)
class Solutions:
    """Results of choices, (choices,), as `choices.parquet` has them; NaN where there is none."""

    pretension_from: Array
    """N; the widest interval in which enough is served. Empty where from > to, NaN where no pretension could do."""
    pretension_to: Array
    """N; infinite where nothing bounds it."""
    windows: npt.NDArray[np.int64]
    """How many intervals serve enough; the widest is the window."""
    from_by: Codes
    """Index into `limits.LIMIT_NAMES`, or NOTHING."""
    to_by: Codes
    from_condition: Rows
    to_condition: Rows
    from_state: Rows
    """The state that binds, by its place among directions and angles; -1 if the limit belongs to none."""
    to_state: Rows
    from_angle: Array
    """The elbow angle that binds, rad, if it lies beside that of the state; else NaN."""
    to_angle: Array
    served: Array
    """The largest share that one pretension serves."""
    served_at: Array
    """The share that `pretension` serves."""
    pretension: Array
    """In the window, or if that is empty, one that serves most, N."""
    max_tension: Array
    max_spring_extension: Array
    peak_motor_torque: Array
    min_elbow_stiffness: Array
    max_contact_pressure: Array
    has_worst: Flags
    """Whether these last five are worked out: else they are NaN, or bounds."""

    feasible: Flags
    """Whether it has a window; of a given pretension whether that serves enough."""

    @property
    def has_window(self) -> Flags:
        """Whether there is a pretension that serves enough."""
        return np.asarray(self.pretension_from <= self.pretension_to)

    @property
    def tolerance(self) -> Array:
        """(to - from)/(to + from), the share by which the pretension may be off; 1 if nothing bounds it above."""
        with np.errstate(invalid="ignore", divide="ignore"):
            share = (self.pretension_to - self.pretension_from) / (self.pretension_to + self.pretension_from)
        # A window from 0 to 0 tolerates nothing.
        share = np.where(np.isinf(self.pretension_to), 1.0, np.where(self.pretension_to == 0.0, 0.0, share))
        return np.where(self.has_window, share, np.nan)

    def column(self, name: str) -> Array:
        """A result by its name, as numbers."""
        return np.asarray(getattr(self, name), dtype=np.float64)

    def with_worst(self, rows: Rows | slice, values: dict[str, Array], *, has_worst: bool = True) -> Solutions:
        """The same, some of the choices with the worst at their pretension."""
        whole = {name: getattr(self, name).copy() for name in (*WORST, "has_worst")}
        for name, column in values.items():
            whole[name][rows] = column
        whole["has_worst"][rows] = has_worst
        return replace(self, **whole)

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
        solutions, served = without_worst(problem, some, min(step, count - at))
        worsts = worst(problem, some, solutions.pretension, served) if with_worst else None
        parts.append(solutions if worsts is None else solutions.with_worst(slice(None), worsts))
    return Solutions.joined(parts)


def without_worst(problem: Problem, numbers: Numbers, count: int) -> tuple[Solutions, Flags]:
    """Choices solved but for the worst at their pretensions, and which conditions each serves."""
    ends = problem.ends(numbers, count)
    low, high, from_condition, to_condition, windows, served, best = _common(problem, ends)
    pretension = np.where(low <= high, _within(problem, low, high), _within(problem, *best))
    if problem.given is not None:
        pretension = np.full(count, problem.given)
    held = _served_at(problem, ends, pretension)
    served_at = _share(problem, held)
    solutions = Solutions(
        pretension_from=low,
        pretension_to=high,
        windows=windows,
        from_by=problem.named(numbers, ends, from_condition).low_by,
        to_by=problem.named(numbers, ends, to_condition).high_by,
        from_condition=from_condition,
        to_condition=to_condition,
        from_state=_taken(ends.low_state, from_condition),
        to_state=_taken(ends.high_state, to_condition),
        from_angle=_taken(ends.low_angle, from_condition),
        to_angle=_taken(ends.high_angle, to_condition),
        served=served,
        served_at=served_at,
        pretension=pretension,
        **dict.fromkeys(WORST, np.full(count, np.nan)),
        has_worst=np.zeros(count, dtype=np.bool_),
        feasible=low <= high if problem.given is None else served_at >= problem.enough - ROUNDING,
    )
    return solutions, held


def _common(
    problem: Problem, ends: Ends
) -> tuple[Array, Array, Rows, Rows, npt.NDArray[np.int64], Array, tuple[Array, Array]]:
    """The widest interval that serves enough, its binding conditions, how many there are, and what is best served.

    If there is none, its ends are those of the window over all conditions, which is empty.
    """
    # A condition that no pretension suits leaves no window at all, and is the reason: argmax takes the first NaN.
    from_condition, to_condition = np.argmax(ends.low, axis=1), np.argmin(ends.high, axis=1)
    low, high = _taken(ends.low, from_condition), _taken(ends.high, to_condition)
    of_groups = grouped(ends.low, ends.high, problem.groups)
    covered = share_served(*of_groups, problem.weighting, enough=problem.enough)
    served = np.where(low <= high, 1.0, covered.served)
    if problem.enough >= 1.0:
        windows = (low <= high).astype(np.int64)
        return low, high, from_condition, to_condition, windows, served, (covered.best_low, covered.best_high)
    has_window = np.repeat(of_groups[0] <= of_groups[1], np.bincount(problem.groups), axis=1)
    some = np.flatnonzero(~np.isnan(covered.low))
    for end, of_conditions, value, condition in (
        (low, ends.low, covered.low, from_condition),
        (high, ends.high, covered.high, to_condition),
    ):
        end[some] = value[some]
        binds = (of_conditions[some] == value[some, np.newaxis]) & has_window[some]
        condition[some] = np.argmax(binds, axis=1)
    best = covered.best_low, covered.best_high
    return low, high, from_condition, to_condition, covered.windows, served, best


def _taken(values: npt.NDArray[Kind], condition: Rows) -> npt.NDArray[Kind]:
    taken: npt.NDArray[Kind] = np.take_along_axis(values, condition[:, np.newaxis], axis=1)[:, 0]
    return taken


def _within(problem: Problem, low: Array, high: Array) -> Array:
    """Where in its window a choice is set; twice the least pretension if nothing bounds it above."""
    if not problem.middle:
        return low
    return np.where(np.isinf(high), 2.0 * low, 0.5 * (low + high))


def _served_at(problem: Problem, ends: Ends, pretension: Array) -> Flags:
    """Which conditions a pretension serves, (choices, conditions): those of the groups that it serves altogether."""
    at = pretension[:, np.newaxis]
    with np.errstate(invalid="ignore"):
        served = (ends.low <= at * (1 + ROUNDING)) & (at <= ends.high * (1 + ROUNDING))
    if len(problem.weighting) == served.shape[1]:
        return served
    firsts = np.flatnonzero(np.diff(problem.groups, prepend=-1))
    return np.repeat(np.logical_and.reduceat(served, firsts, axis=1), np.bincount(problem.groups), axis=1)


def _share(problem: Problem, served: Flags) -> Array:
    """The share of groups all of whose conditions are served, (choices,); exactly 1 if these are all."""
    firsts = np.flatnonzero(np.diff(problem.groups, prepend=-1))
    weights = normalised(problem.weighting)
    return np.where(served.all(axis=1), 1.0, np.minimum(served[:, firsts] @ weights, 1.0))


# --- The worst at a pretension ---------------------------------------------------------------------------------------


def worst(problem: Problem, numbers: Numbers, pretension: Array, served: Flags) -> dict[str, Array]:
    """The worst over the conditions that a pretension serves, (choices,); NaN if it serves none."""
    largest = np.full((6, len(pretension)), np.nan)
    for rows, conditions, values in _quantities(problem, numbers, pretension):
        here = np.fmax.reduce(np.where(served[rows, conditions], values, np.nan), axis=2)
        largest[:, rows] = np.fmax(largest[:, rows], here)
    tension, extension, forward, backward, softness, pressure = largest
    torque = np.where(backward > forward, -backward, forward)
    return dict(zip(WORST, (tension, extension, torque, -softness, pressure), strict=True))


def severest(problem: Problem, numbers: Numbers, pretension: Array, served: Flags, most: int) -> Rows:
    """The conditions, `most` for each quantity, that are the worst for one choice."""
    whole = np.full((6, len(problem.conditions)), -np.inf)
    for rows, conditions, values in _quantities(problem, numbers, pretension):
        whole[:, conditions] = np.where(served[rows, conditions] & ~np.isnan(values), values, -np.inf)[:, 0]
    return np.unique(np.argsort(-whole, axis=1, kind="stable")[:, :most])


def _quantities(problem: Problem, numbers: Numbers, pretension: Array) -> Iterator[tuple[slice, slice, Array]]:
    """Six quantities of choices under conditions, the larger the worse, (6, choices, conditions)."""
    for rows, conditions in problem.chunks(len(pretension)):
        part = {key: values[rows] for key, values in numbers.items()}
        under = {key: values[conditions] for key, values in problem.condition_numbers.items()}
        design = problem.design(part, under, pretension[rows])
        shape = rows.stop - rows.start, conditions.stop - conditions.start
        values = _extremes(problem, design, shape)
        pressure = contact_pressure(design, values["max_extensor_distal"][..., np.newaxis, np.newaxis])[..., 0, 0]
        quantities = (
            values["max_tension"], values["max_spring_extension"], values["highest_motor_torque"],
            -values["lowest_motor_torque"], -values["min_elbow_stiffness"], np.broadcast_to(pressure, shape),
        )  # fmt: skip
        yield rows, conditions, np.stack(quantities)


def _extremes(problem: Problem, design: Design, shape: tuple[int, ...]) -> extremes.Found:
    """What designs of a shape, (choices, conditions), come to over all their states."""
    values, states = extremes.begin(shape), (*shape, problem.flexion.size, problem.angles.size)
    of_states = Situation.of(design, problem.angles, problem.flexion)
    kernel.fold_extremes(values, of_states, problem.angles.ravel(), states)
    return values
