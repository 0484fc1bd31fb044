"""Proofs that the window of a choice holds at every angle, load and posture, and over a box."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.between_samples import estimate_error, worst_between
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.proof import MOST_CELLS, Cells, Proof, first_cells, prove
from tendon_cli.model.setting import pretension_of
from tendon_cli.model.whole_motion import refine_ends
from tendon_cli.model.window import Ends
from tendon_cli.space.axis import scale_of
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import LEAN, LOADS, Question
from tendon_cli.windows.solutions import Solutions, solve_windows
from tendon_cli.windows.solver import Solver

_MARGIN = 1e-6
"""Distance from both ends within which a window is not proved, N: there a limit is just kept."""
_ENDLESS = 1e6
"""Pretension up to which a window without an upper end is proved, N."""
_ARCS = 8
"""Arcs into which an interval of postures is cut at first."""
_ROUNDS = 24
"""Rounds in which a proof may find states by which an end is tightened."""
_CLIMBS = 60
"""Steps in a box to the point where a limit asks for most."""
_MOST_CLIMBED = 16
"""Points in the box from which such steps are taken."""
_FIRST_STEP = 0.25
"""First step in the box, as a share of half its width."""
_LAST_STEP = 1e-4
"""Last step in the box: the error of an end goes with the square of this."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """Result of the proof of one choice's window between the samples."""

    status: str
    """One of `say.STATUSES`."""
    cells: int
    """Number of cells that were tried."""
    margin: float
    """Distance from both ends within which the window is not proved, N."""
    estimate: float | None = None
    """Estimated error of the ends that are not proved, N."""


@dataclass(frozen=True, eq=False)
class _ConditionArcs:
    """Conditions that a window must satisfy, each over an arc of postures and over the box.

    An arc is one posture of the upper arm, or all postures between two.
    """

    question: Question
    points: Points
    """The choice."""
    row: Rows
    """Rows of the conditions; the first of those that differ only within the box."""
    low: Array
    """Smallest inclination of the upper arm, rad; NaN for that of the condition itself."""
    high: Array
    """Largest inclination of the upper arm, rad; NaN for that of the condition itself."""

    @classmethod
    def of(cls, question: Question, points: Points) -> _ConditionArcs:
        """Return the conditions that imply all others.

        They are those with the smallest or the largest load and, in an interval of postures, its
        two ends and the arcs between them.
        """
        is_needed = np.ones(len(question.conditions), dtype=np.bool_)
        places = question.conditions.places(np.arange(len(is_needed)))
        for axis in question.conditions.axes:
            if axis.key in LOADS:
                extremes = (axis.values.min(), axis.values.max())
                is_needed &= np.isin(axis.values[places[axis.key]], extremes)
        for axis in question.box:
            is_needed &= places[axis.key] == 0
        rows = np.flatnonzero(is_needed)
        leaning = question.leaning
        if leaning is None:
            unset = np.full(len(rows), np.nan)
            return cls(question, points, rows, unset, unset)
        rows = rows[places[LEAN][rows] == 0]
        edges = np.linspace(leaning.values.min(), leaning.values.max(), _ARCS + 1)
        low = np.append(edges[:-1], edges[[0, -1]])
        high = np.append(edges[1:], edges[[0, -1]])
        return cls(
            question,
            points,
            row=np.repeat(rows, len(low)),
            low=np.tile(low, len(rows)),
            high=np.tile(high, len(rows)),
        )

    def __len__(self) -> int:
        return len(self.row)

    def select(self, which: Any) -> _ConditionArcs:
        """Select arcs by index or mask."""
        return replace(self, row=self.row[which], low=self.low[which], high=self.high[which])

    def halve(self, which: Flags) -> _ConditionArcs:
        """Return all arcs, with the selected ones cut in two and placed last."""
        rest = self.select(~which)
        cut = self.select(which)
        middle = cut.middles.low
        return replace(
            self,
            row=np.concatenate([rest.row, cut.row, cut.row]),
            low=np.concatenate([rest.low, cut.low, middle]),
            high=np.concatenate([rest.high, middle, cut.high]),
        )

    @property
    def middles(self) -> _ConditionArcs:
        """Postures in the middle of the arcs."""
        middle = 0.5 * (self.low + self.high)
        return replace(self, low=middle, high=middle)

    def design(self, shares: Array | float = 0.0) -> Design:
        """Return designs at points of the box, (arcs, 1, 1).

        Limits are linear in sine and cosine of the forearm's inclination: what holds at the point
        where the tangents at the ends of an arc meet, and at both ends of all arcs, holds on the
        arcs. The weights are larger at that point, by 1/cos of half the arc.

        Args:
            shares: Place of each number in the box, (arcs, numbers), from -1 to 1.
        """
        box = self.question.box
        numbers: dict[str, Array] = {}
        points = np.broadcast_to(shares, (len(self), len(box)))
        for axis, share in zip(box, points.T, strict=True):
            low = axis.values.min()
            high = axis.values.max()
            numbers[axis.key] = 0.5 * (low + high) + 0.5 * (high - low) * share
        if not np.isnan(self.low).all():
            growth = (1.0 + 1e-12) / np.cos(0.5 * (self.high - self.low))
            numbers[scale_of("arm.forearm_mass")] = growth
            numbers[scale_of("load.mass")] = growth
            numbers[LEAN] = self.middles.low
        return self.question.paired_designs(self.points, np.zeros_like(self.row), self.row, numbers)

    def prove(self, low: Array, high: Array) -> Proof:
        """Prove that all limits are kept from `low` to `high`, (conditions,) N as they are read."""
        question = self.question
        design = self.design()
        angles = (float(question.angles.min()), float(question.angles.max()))
        ends_of_numbers = np.eye(len(question.box))
        cells = first_cells(len(self), angles, question.flexion, design.knots, len(ends_of_numbers))
        return prove(
            design,
            cells,
            self._as_f0(design, low),
            self._as_f0(design, np.minimum(high, _ENDLESS)),
            question.bounds,
            [self.design(end) for end in ends_of_numbers],
        )

    def _as_f0(self, design: Design, pretension: Array) -> Array:
        """Return pretensions, (conditions,) N as they are read, as F0 of the arcs, (arcs,) N."""
        of_arcs = pretension_of(design, pretension[self.row, np.newaxis, np.newaxis])
        return np.broadcast_to(of_arcs, (len(self), 1, 1)).ravel()


@dataclass(frozen=True, eq=False)
class ProvedChoice:
    """A choice whose window was proved, or tightened until it could be."""

    choice: Solutions
    certificate: Certificate
    ends: Ends
    """Ends of its windows as they are read, (1, conditions)."""


class Proofs:
    """Choices that an answer names, each proved once."""

    def __init__(self, solver: Solver) -> None:
        self.solver = solver
        self.done: dict[tuple[float, ...], ProvedChoice] = {}
        """Proved choices by their values of each axis, in the order in which they were proved."""

    def prove(self, choices: Solutions) -> Solutions:
        """Return choices with their windows proved, or tightened."""
        proved = []
        for place in range(len(choices)):
            choice = choices.select([place])
            values = tuple(float(column[0]) for column in choice.points.columns.values())
            if values not in self.done:
                self.done[values] = prove_choice(self.solver, choice)
            proved.append(self.done[values].choice)
        return Solutions.concatenate(proved)


def prove_choice(solver: Solver, choice: Solutions) -> ProvedChoice:
    """Prove the window of one choice; tighten it around each state that breaks a limit."""
    question = solver.question
    points = choice.points
    status = say.SAMPLED
    cells = 0
    margin = 0.0
    arcs = _ConditionArcs.of(question, points)
    if question.serve < 1.0:
        ends = solver.ends_over_all_angles(points)
    else:
        ends = solver.ends_that_may_bind(points)
    rounds = 0
    if choice.has_window.item() and question.study.trajectory is None:
        rounds = _ROUNDS
        choice = _solve_again(solver, choice, ends)
    for _ in range(rounds):
        low, high = _served_windows(question, solver.all_limits(ends, points), choice)
        margin = min(_MARGIN, 0.25 * float(np.max(high - low)))
        arcs = arcs.select((high - low)[arcs.row] >= 2.0 * margin)
        proof = arcs.prove(low + margin, high - margin)
        cells += proof.cells
        failing = np.unique(np.concatenate([proof.broken.row, proof.left.row]))
        if not len(failing):
            status = say.SAMPLED if question.is_sampled else say.PROVEN
            break
        status = say.OPEN
        if cells > MOST_CELLS:
            break
        broken = proof.broken
        postures = arcs
        can_halve = arcs.high[failing] > arcs.low[failing]
        if can_halve.any():
            # A limit that is broken where two tangents meet need not be broken on the arc.
            postures = arcs.select(failing).middles
            broken = postures.prove(low + margin, high - margin).broken
        if len(broken):
            ends = _tighten(question, ends, broken, postures)
            choice = _solve_again(solver, choice, ends)
            if not choice.has_window.item():
                break
        elif not can_halve.any():
            break
        halves = np.zeros(len(arcs), dtype=np.bool_)
        halves[failing[can_halve]] = True
        arcs = arcs.halve(halves)
    is_open = status == say.OPEN
    estimate = None
    if not is_open and choice.has_window.item():
        estimate = estimate_error(solver, choice, ends)
    certificate = Certificate(status, cells, 0.0 if is_open else margin, estimate)
    choice = replace(choice, between_samples=np.array([say.STATUSES.index(status)]))
    return ProvedChoice(choice, certificate, solver.all_limits(ends, points))


def _served_windows(question: Question, ends: Ends, choice: Solutions) -> tuple[Array, Array]:
    """Return the ends of the window that must hold under each condition, (conditions,).

    They are as they are read, N. The window is empty under a condition that need not be served.
    """
    low = choice.pretension_from
    high = choice.pretension_to
    if question.serve >= 1.0:
        count = len(question.conditions)
        return np.repeat(low, count), np.repeat(high, count)
    group_low, group_high = question.groups.windows(ends.low, ends.high)
    served_low = np.maximum(group_low[0], low)
    served_high = np.minimum(group_high[0], high)
    return served_low[question.groups.of], served_high[question.groups.of]


def _tighten(question: Question, ends: Ends, broken: Cells, postures: _ConditionArcs) -> Ends:
    """Return ends of one choice, tightened around the states that break a limit.

    Args:
        question: The question.
        ends: Ends over all angles, (1, conditions), as F0.
        broken: Cells in whose middle a limit is not kept; their rows are places in `postures`.
        postures: Conditions in single postures.
    """
    ends = Ends(**{name: values.copy() for name, values in vars(ends).items()})
    angles = question.angles.ravel()
    middle = broken.middle  # (cells, 1 + numbers): angle, rad, and place in the box
    direction = (broken.flexion[:, np.newaxis] == question.flexion.ravel()).argmax(axis=1)
    nearest = np.abs(middle[:, :1] - angles).argmin(axis=1)
    state = direction * len(angles) + nearest
    sides = (
        (False, ends.low, ends.low_state, ends.low_angle),
        (True, ends.high, ends.high_state, ends.high_angle),
    )
    for upper, value, binding_state, binding_angle in sides:
        which = np.flatnonzero(broken.upper == upper)
        # The first of several cells stands for those that differ only within the box.
        kinds = np.stack([broken.row[which], state[which]])
        which = which[np.unique(kinds, axis=1, return_index=True)[1]]
        if not len(which):
            continue
        selected = postures.select(broken.row[which])
        conditions, tightest = _tightest_ends(selected, middle[which], state[which], upper=upper)
        for condition, end, end_state, end_angle in zip(conditions, *tightest, strict=True):
            before = value[0, condition]
            is_tighter = end < before if upper else end > before
            if is_tighter:
                value[0, condition] = end
                binding_state[0, condition] = end_state
                binding_angle[0, condition] = end_angle
    return ends


def _tightest_ends(
    postures: _ConditionArcs, points: Array, state: Rows, *, upper: bool
) -> tuple[Rows, list[Any]]:
    """Seek the tightest ends near points at which a limit is broken.

    Args:
        postures: Conditions in single postures.
        points: An angle, rad, and a place in the box for each, (postures, 1 + numbers).
        state: Nearest state of each.
        upper: True for upper ends.

    Returns:
        The conditions, and for each the end (N, as F0), its state and its angle (rad). If there
        is a box, only the tightest ends are returned.
    """
    question = postures.question
    box = question.box
    sign = -1.0 if upper else 1.0
    shares = points[:, 1:]

    def ends_at(
        selected: _ConditionArcs, shares: Array, state: Rows, start: Array | None = None
    ) -> list[Any]:
        """Return ends (N), states and angles (rad) at points of the box."""
        unbounded = np.full(len(state), -sign * np.inf)
        return list(
            refine_ends(
                selected.design(shares),
                state,
                unbounded,
                question.angles.ravel(),
                question.flexion,
                question.bounds,
                upper=upper,
                start=start,
            )
        )

    from_states = ends_at(postures, shares, state)
    from_points = ends_at(postures, shares, state, points[:, 0])
    is_tighter = sign * from_points[0] > sign * from_states[0]
    best = [
        np.where(is_tighter, new, old) for new, old in zip(from_points, from_states, strict=True)
    ]
    if not box:
        return postures.row, best

    # Climb in the box from the tightest ends: each step tries both directions of every number.
    tightest_first = np.argsort(-sign * best[0])[:_MOST_CLIMBED]
    postures = postures.select(tightest_first)
    shares = shares[tightest_first]
    best = [values[tightest_first] for values in best]
    step = _FIRST_STEP
    directions = np.concatenate([np.eye(len(box)), -np.eye(len(box))])
    starts = np.arange(len(postures))
    tried = np.repeat(starts, len(directions))
    for _ in range(_CLIMBS):
        moves = step * np.tile(directions, (len(postures), 1))
        points = np.clip(shares[tried] + moves, -1.0, 1.0)
        tightest = ends_at(postures.select(tried), points, best[1][tried])
        of_starts = (sign * tightest[0]).reshape(len(postures), -1)
        top = of_starts.argmax(axis=1) + starts * len(directions)
        is_tighter = sign * tightest[0][top] > sign * best[0]
        shares = np.where(is_tighter[:, np.newaxis], points[top], shares)
        best = [
            np.where(is_tighter, new[top], old) for new, old in zip(tightest, best, strict=True)
        ]
        if not is_tighter.any():
            step *= 0.5
            if step < _LAST_STEP:
                break
    return postures.row, best


def _solve_again(solver: Solver, choice: Solutions, ends: Ends) -> Solutions:
    """Solve one choice from the ends of its windows over all angles, (1, conditions), as F0."""
    points = choice.points
    solved, served = solve_windows(solver, points, solver.all_limits(ends, points))
    worst = worst_between(solver, points, solved.pretension, served)
    return solved.with_worst(slice(None), worst)
