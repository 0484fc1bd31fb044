"""Conditions of a proof, each over an arc of postures and over the box of a question."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.limits import CONTACT_PRESSURE
from tendon_cli.model.setting import pretension_of
from tendon_cli.proof.subdivision import Proof, first_cells, prove
from tendon_cli.space.axis import scale_of
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import LEAN, LOADS, Question

_ENDLESS = 1e6
"""Pretension up to which a window without an upper end is proved, N."""
_FIRST_ARCS = 8
"""Arcs into which an interval of postures is cut at first."""


@dataclass(frozen=True, eq=False)
class ConditionArcs:
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
    def of(cls, question: Question, points: Points) -> ConditionArcs:
        """Return the conditions that imply all others.

        They are those with the smallest or the largest load and, in an interval of postures, its
        two ends and the arcs between them. If a share of single conditions is enough, no condition
        implies another: those with other loads may be served without it.
        """
        is_needed = np.ones(len(question.conditions), dtype=np.bool_)
        places = question.conditions.places(np.arange(len(is_needed)))
        for axis in question.conditions.axes:
            if axis.key in LOADS and not question.counts_conditions:
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
        edges = np.linspace(leaning.values.min(), leaning.values.max(), _FIRST_ARCS + 1)
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

    def select(self, which: Any) -> ConditionArcs:
        """Select arcs by index or mask."""
        return replace(self, row=self.row[which], low=self.low[which], high=self.high[which])

    def halve(self, which: Flags) -> ConditionArcs:
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
    def middles(self) -> ConditionArcs:
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
        edges = design.knots
        if CONTACT_PRESSURE in question.bounds:
            edges = np.union1d(edges, design.arm.first_contact)
        cells = first_cells(len(self), angles, question.flexion, edges, len(ends_of_numbers))
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
