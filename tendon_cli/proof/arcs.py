"""Conditions of a proof, over arcs of postures and over the box of a question."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import LEAN, LOADS, Question
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.limits import CONTACT_PRESSURE
from tendon_cli.model.motor import select_points
from tendon_cli.model.setting import pretension_of
from tendon_cli.proof.subdivision import Cells, Setup, Verdict, judge
from tendon_cli.studies.space.axis import scale_of

_ENDLESS = 1e6
"""Pretension up to which a window without an upper end is proved, N."""
_FIRST_CELLS = 8
"""Cells of the angle that a proof begins with, besides those that end at knots."""
_WIDEST_ARC = np.pi / 4.0
"""Largest arc of postures that a proof begins with, rad: it must be less than half a turn."""


@dataclass(frozen=True, eq=False)
class ConditionArcs:
    """Conditions that a window must satisfy, which imply all others, with their designs in cells.

    Limits are linear in sine and cosine of the posture of the upper arm. On an arc of postures they
    hold if they hold at the point where the tangents at its ends meet, provided that they hold at
    such points of all arcs of an interval and at both ends of that. At this point the weights are
    larger than in the middle of the arc, by 1/cos of half of it. A single posture is an arc without
    width.
    """

    question: Question
    points: Points
    """The choice."""
    row: Rows
    """Rows of the conditions; the first of those that differ only within the box or in posture."""

    @classmethod
    def of(cls, question: Question, points: Points) -> ConditionArcs:
        """Return the conditions that imply all others: those with the least or the largest load."""
        is_needed = np.ones(len(question.conditions), dtype=np.bool_)
        places = question.conditions.places(np.arange(len(is_needed)))
        for axis in question.conditions.axes:
            if axis.key in LOADS:
                extremes = (axis.values.min(), axis.values.max())
                is_needed &= np.isin(axis.values[places[axis.key]], extremes)
        for axis in question.box:
            is_needed &= places[axis.key] == 0
        if question.leaning is not None:
            is_needed &= places[LEAN] == 0
        return cls(question, points, np.flatnonzero(is_needed))

    @property
    def postures(self) -> tuple[float, float]:
        """Ends of the interval of postures, rad; NaN if there is none."""
        leaning = self.question.leaning
        if leaning is None:
            return np.nan, np.nan
        return float(leaning.values.min()), float(leaning.values.max())

    def first_cells(self, rows: Rows) -> Cells:
        """Return the cells that a proof of some conditions begins with.

        They lie in each direction, at both ends of the windows, and span the whole box. They end at
        the angles of kinks, and at those where a limit begins.

        Args:
            rows: Rows of the conditions.
        """
        question = self.question
        low, high = self.postures
        arcs = [[low, high]]
        if low < high:
            edges = np.linspace(low, high, 1 + int(np.ceil((high - low) / _WIDEST_ARC)))
            arcs = [[low, low], [high, high], *np.column_stack([edges[:-1], edges[1:]])]
        design = self.design(self.row, posture=low)
        knots = design.knots
        if question.bounds.of(design).asks(CONTACT_PRESSURE).any():
            knots = np.union1d(knots, design.arm.first_contact)
        first = float(question.angles.min())
        last = float(question.angles.max())
        inner_knots = knots[(knots > first) & (knots < last)]
        edges = np.unique([*np.linspace(first, last, _FIRST_CELLS + 1), *inner_knots])
        places = np.arange(max(1, len(edges) - 1))
        axes = np.meshgrid(
            rows,
            np.arange(len(arcs)),
            question.flexion.ravel(),
            [False, True],
            places,
            indexing="ij",
        )
        row, arc, direction, upper, place = (axis.ravel() for axis in axes)
        whole_box = np.ones((len(row), len(question.box)))
        next_place = np.minimum(place + 1, len(edges) - 1)
        arc_from, arc_to = np.array(arcs)[arc].T
        return Cells(
            row,
            direction,
            upper,
            low=np.column_stack([edges[place], -whole_box, arc_from]),
            high=np.column_stack([edges[next_place], whole_box, arc_to]),
        )

    def design(
        self,
        row: Rows,
        shares: Array | float = 0.0,
        posture: Array | float = np.nan,
        growth: Array | None = None,
    ) -> Design:
        """Return designs at points of the box, (designs, 1, 1).

        Args:
            row: Row of the condition of each.
            shares: Place of each number in the box, (designs, numbers), from -1 to 1.
            posture: Posture of each, rad; not used without an interval of postures.
            growth: Factor on the weights of each.
        """
        box = self.question.box
        numbers: dict[str, Array] = {}
        points = np.broadcast_to(shares, (len(row), len(box)))
        for axis, share in zip(box, points.T, strict=True):
            low = axis.values.min()
            high = axis.values.max()
            numbers[axis.key] = 0.5 * (low + high) + 0.5 * (high - low) * share
        if self.question.leaning is not None:
            numbers[LEAN] = np.broadcast_to(posture, len(row))
        if growth is not None:
            numbers[scale_of("arm.forearm_mass")] = growth
            numbers[scale_of("load.mass")] = growth
        return self.question.paired_designs(self.points, np.zeros_like(row), row, numbers)

    def judge(self, cells: Cells, low: Array, high: Array) -> Verdict:
        """Decide on cells at the ends of windows, (conditions,) N as they are read."""
        pretension = np.where(cells.upper, np.minimum(high, _ENDLESS)[cells.row], low[cells.row])
        beyond = self._setup(cells, pretension, reaches_beyond=True)
        within = beyond
        if self.question.leaning is not None:
            within = self._setup(cells, pretension, reaches_beyond=False)
        with np.errstate(all="ignore"):
            return judge(cells, beyond, within, self.question.bounds)

    def _setup(self, cells: Cells, pretension: Array, *, reaches_beyond: bool) -> Setup:
        """Return the designs of cells where the tangents of their arcs meet, or in the middle."""
        posture = cells.middle[:, -1]
        growth = None
        if reaches_beyond and self.question.leaning is not None:
            half = 0.5 * (cells.high - cells.low)[:, -1]
            growth = (1.0 + 1e-12) / np.cos(half)
        designs = [
            self.design(cells.row, shares, posture, growth)
            for shares in (0.0, *np.eye(len(self.question.box)))
        ]
        as_f0 = pretension_of(designs[0], pretension[:, np.newaxis, np.newaxis])
        middle, *ends = (_flat(design, len(cells)) for design in designs)
        return Setup(middle, ends, np.broadcast_to(as_f0, (len(cells), 1, 1)).ravel())


def _flat(design: Design, count: int) -> Any:
    """Return designs, (count, 1, 1), along a single axis."""
    nowhere = np.zeros(count, dtype=np.int64)
    return select_points(design, (count, 1, 1), (np.arange(count), nowhere, nowhere))
