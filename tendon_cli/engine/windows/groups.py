"""Groups of conditions, such as those of one person, of which a pretension serves a share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from tendon_cli import say
from tendon_cli.engine.windows.coverage import (
    Coverage,
    effective_count,
    normalise,
    serves,
    share_served,
)
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.studies.space.space import Space


@dataclass(frozen=True, eq=False)
class Groups:
    """Persons, draws or pairs of both to which conditions belong, or conditions by themselves.

    A pretension serves a group if it suits all its conditions.
    """

    of: Rows
    """Group of each condition, (conditions,), from 0 and ascending."""
    weighting: Array
    """Weight of each group, (groups,), the largest from 0.5 to 1 so that sums stay finite."""
    counts: Mapping[str, int]
    """Numbers of persons and of draws by the keys of their axes; if there are both, groups are
    their pairs. Bodies drawn for a person count as draws."""

    @classmethod
    def of_conditions(cls, conditions: Space, counts: Mapping[str, int]) -> Self:
        """Return the groups of conditions, or each by itself if they have none."""
        groups = conditions.groups
        if groups is None:
            groups = np.arange(len(conditions))
        if conditions.weighting is None:
            return cls(groups, np.ones(groups[-1] + 1), counts)
        first_conditions = np.flatnonzero(np.diff(groups, prepend=-1))
        weighting = conditions.weighting[first_conditions]
        _, exponent = np.frexp(np.max(weighting))
        return cls(groups, np.asarray(np.ldexp(weighting, -int(exponent))), counts)

    def __len__(self) -> int:
        return len(self.weighting)

    @property
    def noun(self) -> str:
        """Noun for what a share counts: "persons", "pairs", "draws" or "conditions"."""
        kinds = tuple(self.counts)
        if len(kinds) == 2:
            return "pairs"
        return f"{kinds[0]}s" if kinds else "conditions"

    @property
    def conditions_per_group(self) -> int:
        """Number of conditions of each group."""
        return len(self.of) // len(self)

    @property
    def first_conditions(self) -> Rows:
        """Row of the first condition of each group, ascending."""
        return np.flatnonzero(np.diff(self.of, prepend=-1))

    @property
    def effective_count(self) -> float:
        """Number of equally weighted groups that tell as much."""
        return effective_count(self.weighting)

    def select(self, groups: Rows) -> Self:
        """Select groups, in ascending order, numbered anew."""
        of_selected = self.of[np.isin(self.of, groups)]
        return replace(
            self, of=np.searchsorted(groups, of_selected), weighting=self.weighting[groups]
        )

    def conditions_of(self, groups: Rows) -> Rows:
        """Return the rows of all conditions of some groups, ascending."""
        return np.flatnonzero(np.isin(self.of, groups))

    def within(self, conditions: Rows) -> Self:
        """Select conditions, in ascending order, with their groups, numbered anew."""
        groups, of_selected = np.unique(self.of[conditions], return_inverse=True)
        return replace(self, of=of_selected, weighting=self.weighting[groups])

    def windows(self, low: Array, high: Array) -> tuple[Array, Array]:
        """Return the ends of windows that serve every condition of a group, (choices, groups), N.

        Args:
            low: Lower ends of the windows of conditions, (choices, conditions), N.
            high: Upper ends.

        Returns:
            Lower and upper ends; NaN if no pretension could do in one of the conditions.
        """
        firsts = self.first_conditions
        return np.maximum.reduceat(low, firsts, axis=1), np.minimum.reduceat(high, firsts, axis=1)

    def served_at(self, low: Array, high: Array, pretension: Array) -> Flags:
        """Return True where a choice serves a group at its pretension, (choices, groups).

        Args:
            low: Lower ends of the windows of conditions, (choices, conditions), N.
            high: Upper ends.
            pretension: Pretensions of the choices, (choices,), N.
        """
        return serves(*self.windows(low, high), pretension[:, np.newaxis])

    def coverage(self, low: Array, high: Array, *, serve: float = 1.0) -> Coverage:
        """Return the windows and shares of groups that one pretension can serve.

        Args:
            low: Lower ends of the windows of groups, (choices, groups), N.
            high: Upper ends.
            serve: Share that is enough.
        """
        return share_served(low, high, self.weighting, serve=serve)

    def share(self, is_served: Flags) -> Array:
        """Return the share of groups that are served, (choices,), exactly 1 if all are.

        Args:
            is_served: True where a choice serves a group, (choices, groups).
        """
        shares = np.minimum(is_served @ normalise(self.weighting), 1.0)
        return np.where(is_served.all(axis=1), 1.0, shares)

    def interval(self, share: float) -> list[float]:
        """Return the 95 % interval of a share of the groups."""
        return [*say.interval(share, self.effective_count)]
