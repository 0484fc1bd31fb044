"""Proofs that the window of a choice holds between the samples: at every angle, load and posture, and in a box."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.between_samples import estimated, worst_between
from tendon_cli.answers.coverage import grouped
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question import LEAN, LOADS
from tendon_cli.answers.solve import Solutions, solve_windows
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.proof import MOST_CELLS, Cells, Proof, cells_of, prove
from tendon_cli.model.setting import pretension_of
from tendon_cli.model.whole_motion import refined
from tendon_cli.model.window import Ends, Positions
from tendon_cli.space.axis import Numbers, Rows, scale_of

_MARGIN = 1e-6  # N; by which a window is proved at either end less than it is given: there a limit is just kept
_ENDLESS = 1e6  # N; how far a window is proved that nothing bounds
_ARCS = 8  # of an interval of postures, at first
_ROUNDS = 24  # in which a proof may find what an end is tightened by
_CLIMBS, _MOST_CLIMBED = (
    60,
    16,
)  # steps in a box to where a limit asks for most, from so many points
_FIRST_STEP, _LAST_STEP = (
    0.25,
    1e-4,
)  # as shares of half the box: an end is off by the square of the last


@dataclass(frozen=True, eq=False)
class Certificate:
    """What is known of the window of one choice between the samples."""

    status: str
    cells: int
    margin: float  # N
    estimate: float | None = None  # by how much its ends may be off that are not proved, N


@dataclass(frozen=True, eq=False)
class _Held:
    """What a window is held to: conditions, each in one posture of the upper arm or in all between two, over a box."""

    problem: Problem
    numbers: Numbers  # of the choice
    row: Rows  # of the conditions; of those that differ in the box alone the first
    low: Array
    high: Array  # inclinations of the upper arm, rad; NaN where that of the condition holds

    @classmethod
    def of(cls, problem: Problem, numbers: Numbers) -> _Held:
        """The conditions but those with a load between others; of an interval of postures ends and arcs between."""
        needed = np.ones(len(problem.conditions), dtype=np.bool_)
        places = problem.conditions.places(np.arange(len(needed)))
        for axis in problem.conditions.axes:
            if axis.key in LOADS:
                needed &= np.isin(
                    axis.values[places[axis.key]], (axis.values.min(), axis.values.max())
                )
        for axis in problem.box:
            needed &= places[axis.key] == 0
        rows = np.flatnonzero(needed)
        if (leaning := problem.leaning) is None:
            return cls(problem, numbers, rows, *np.full((2, len(rows)), np.nan))
        rows = rows[places[LEAN][rows] == 0]
        edges = np.linspace(leaning.values.min(), leaning.values.max(), _ARCS + 1)
        low, high = np.append(edges[:-1], edges[[0, -1]]), np.append(edges[1:], edges[[0, -1]])
        return cls(
            problem,
            numbers,
            np.repeat(rows, len(low)),
            np.tile(low, len(rows)),
            np.tile(high, len(rows)),
        )

    def __len__(self) -> int:
        return len(self.row)

    def select(self, which: Any) -> _Held:
        """Some of them."""
        return replace(self, row=self.row[which], low=self.low[which], high=self.high[which])

    def halved(self, which: Flags) -> _Held:
        """All, some of them in two."""
        some, middle = self.select(which), 0.5 * (self.low + self.high)[which]
        return replace(
            self,
            row=np.concatenate([self.row[~which], some.row, some.row]),
            low=np.concatenate([self.low[~which], some.low, middle]),
            high=np.concatenate([self.high[~which], middle, some.high]),
        )

    @property
    def middles(self) -> _Held:
        """The posture in the middle of each."""
        middle = 0.5 * (self.low + self.high)
        return replace(self, low=middle, high=middle)

    def design(self, shares: Array | float = 0.0) -> Design:
        """Designs, (held, 1, 1), each at a point of the box, (held, its numbers) from -1 to 1.

        Limits are linear in sine and cosine of the forearm's inclination: what holds at the point where the tangents at
        the ends of an arc meet, and at both ends of all arcs, holds on the arcs. There the weights are larger.
        """
        box, above = self.problem.box, dict[str, Array]()
        each = np.broadcast_to(shares, (len(self), len(box)))
        for axis, share in zip(box, each.T, strict=True):
            low, high = axis.values.min(), axis.values.max()
            above[axis.key] = 0.5 * (low + high) + 0.5 * (high - low) * share
        if not np.isnan(self.low).all():
            grown = (1.0 + 1e-12) / np.cos(0.5 * (self.high - self.low))
            above |= {scale_of(key): grown for key in ("arm.forearm_mass", "load.mass")}
            above[LEAN] = self.middles.low
        return self.problem.paired(self.numbers, np.zeros_like(self.row), self.row, above)

    def proved(self, low: Array, high: Array) -> Proof:
        """What holds of the choice from `low` to `high`, (conditions,) N as they are read."""
        problem, design = self.problem, self.design()
        span, sides = (
            (float(problem.angles.min()), float(problem.angles.max())),
            np.eye(len(problem.box)),
        )
        at_low, at_high = (
            np.broadcast_to(
                pretension_of(design, end[self.row, np.newaxis, np.newaxis]), (len(self), 1, 1)
            ).ravel()
            for end in (low, np.minimum(high, _ENDLESS))
        )
        cells = cells_of(len(self), span, problem.flexion, design.knots, len(sides))
        return prove(
            design, cells, at_low, at_high, problem.bounds, [self.design(side) for side in sides]
        )


class Proofs:
    """The choices that an answer names, each proved once, with the ends of its windows as they are read."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.done: dict[tuple[float, ...], tuple[Solutions, Certificate, Ends]] = {}

    def of(self, some: Solutions) -> Solutions:
        """Choices with their windows proved, or tightened."""
        ones = []
        for one in (some.select([at]) for at in range(len(some))):
            place = tuple(float(values[0]) for values in one.columns.values())
            if place not in self.done:
                self.done[place] = certified(self.problem, one)
            ones.append(self.done[place][0])
        return Solutions.concatenate(ones)


def certified(problem: Problem, one: Solutions) -> tuple[Solutions, Certificate, Ends]:
    """One choice with its window proved; tightened where the proof meets a state that does not keep a limit."""
    exactly = replace(problem, near=np.inf) if problem.enough < 1.0 else problem
    numbers, status, cells, margin = problem.numbers_of(one.columns), say.SAMPLED, 0, 0.0
    held, ends = _Held.of(problem, numbers), exactly.ends_over_angles(numbers, 1)
    provable = one.has_window.item() and problem.study.trajectory is None
    if provable:
        one = _solved_again(exactly, numbers, one, ends)
    for _ in range(_ROUNDS if provable else 0):
        low, high = _served(exactly, exactly.finish_ends(ends, numbers), one)
        margin = min(_MARGIN, 0.25 * float(np.max(high - low)))
        asked = held.select((high - low)[held.row] >= 2.0 * margin)
        proof = asked.proved(low + margin, high - margin)
        status, cells, broken = say.OPEN, cells + proof.cells, proof.broken
        failing = np.unique(np.concatenate([broken.row, proof.left.row]))
        if not len(failing):
            status = say.SAMPLED if problem.is_sampled else say.PROVEN
            break
        if cells > MOST_CELLS:
            break
        points, arcs = asked, asked.high[failing] > asked.low[failing]
        if arcs.any():
            points = asked.select(failing).middles
            broken = points.proved(low + margin, high - margin).broken
        if len(broken):
            ends = _tightened(exactly, ends, broken, points)
            one = _solved_again(exactly, numbers, one, ends)
            if not one.has_window.item():
                break
        elif not arcs.any():
            break
        which = np.zeros(len(asked), dtype=np.bool_)
        which[failing[arcs]] = True
        held = asked.halved(which)
    is_open = status == say.OPEN
    estimate = (
        None if is_open or not one.has_window.item() else estimated(problem, numbers, one, ends)
    )
    known = {"between_samples": np.array([say.STATUSES.index(status)])}
    certificate = Certificate(status, cells, 0.0 if is_open else margin, estimate)
    return (
        replace(one, results=one.results | known),
        certificate,
        exactly.finish_ends(ends, numbers),
    )


def _served(problem: Problem, ends: Ends, one: Solutions) -> tuple[Array, Array]:
    """Between which pretensions, as they are read, conditions must hold, (conditions,); empty where they need not."""
    low, high = one["pretension_from"], one["pretension_to"]
    if problem.enough >= 1.0:
        return np.repeat(low, len(problem.conditions)), np.repeat(high, len(problem.conditions))
    begin, end = (each[0] for each in grouped(ends.low, ends.high, problem.groups))
    return np.maximum(begin, low)[problem.groups], np.minimum(end, high)[problem.groups]


def _tightened(problem: Problem, ends: Ends, broken: Cells, held: _Held) -> Ends:
    """Ends of one choice, tightened around the states in which a limit is not kept."""
    ends = Ends(**{name: values.copy() for name, values in vars(ends).items()})
    angles, middle = problem.angles.ravel(), broken.middle
    direction = (broken.flexion[:, np.newaxis] == problem.flexion.ravel()).argmax(axis=1)
    state = direction * len(angles) + np.abs(middle[:, :1] - angles).argmin(axis=1)
    for name, upper in (("low", False), ("high", True)):
        which = np.flatnonzero(broken.upper == upper)
        # Of cells that differ in the box alone the first.
        which = which[
            np.unique(np.stack([broken.row, state])[:, which], axis=1, return_index=True)[1]
        ]
        if not len(which):
            continue
        some = held.select(broken.row[which])
        tightest = _tightest(some, middle[which], state[which], upper=upper)
        value, of_state, of_angle = (
            getattr(ends, f"{name}{of}") for of in ("", "_state", "_angle")
        )
        for at, end, its_state, its_angle in zip(tightest[0], *tightest[1], strict=True):
            if (end < value[0, at]) if upper else (end > value[0, at]):
                value[0, at], of_state[0, at], of_angle[0, at] = end, its_state, its_angle
    return ends


def _tightest(
    held: _Held, points: Array, state: Positions, *, upper: bool
) -> tuple[Rows, Sequence[Array | Positions]]:
    """Conditions and their ends (N, state, angle), sought from points (angle, place in the box) and nearby states."""
    problem, sign, shares = held.problem, -1.0 if upper else 1.0, points[:, 1:]

    def ends_at(
        some: _Held, shares: Array, near: Positions, start: Array | None = None
    ) -> list[Any]:
        none = np.full(len(near), -sign * np.inf)
        given = problem.angles.ravel(), problem.flexion, problem.bounds
        return [*refined(some.design(shares), near, none, *given, upper=upper, start=start)]

    near, here = ends_at(held, shares, state), ends_at(held, shares, state, points[:, 0])
    best = [
        np.where(sign * here[0] > sign * near[0], new, old)
        for new, old in zip(here, near, strict=True)
    ]
    if not problem.box:
        return held.row, best
    first = np.argsort(-sign * best[0])[:_MOST_CLIMBED]
    held, shares, best, step = (
        held.select(first),
        shares[first],
        [each[first] for each in best],
        _FIRST_STEP,
    )
    ways = np.concatenate([np.eye(len(problem.box)), -np.eye(len(problem.box))])
    each = np.repeat(np.arange(len(held)), len(ways))
    for _ in range(_CLIMBS):
        points = np.clip(shares[each] + step * np.tile(ways, (len(held), 1)), -1.0, 1.0)
        tightest = ends_at(held.select(each), points, best[1][each])
        top = (sign * tightest[0]).reshape(len(held), -1).argmax(axis=1) + np.arange(
            len(held)
        ) * len(ways)
        better = sign * tightest[0][top] > sign * best[0]
        shares = np.where(better[:, np.newaxis], points[top], shares)
        best = [np.where(better, new[top], old) for new, old in zip(tightest, best, strict=True)]
        if not better.any():
            step *= 0.5
            if step < _LAST_STEP:
                break
    return held.row, best


def _solved_again(problem: Problem, numbers: Numbers, one: Solutions, ends: Ends) -> Solutions:
    """One choice, from ends of its windows over all angles."""
    solved, held = solve_windows(problem, numbers, 1, problem.finish_ends(ends, numbers))
    worsts = worst_between(problem, numbers, solved["pretension"], held)
    return replace(one, results=solved.with_worst(slice(None), worsts).results)
