"""Parts of a limit: the form that it bounds, what it needs, its words. `limits` has the table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli.model.kinematics import Array, Real
from tendon_cli.model.statics import SLACK_TOLERANCE


@dataclass(frozen=True, eq=False)
class Form:
    """Quantity of a state: flexor x + extensor y + stiffness k + constant.

    A share that is the number 0.0 means that the form has no such part.
    """

    flexor: Real = 0.0
    """Share of the distal flexor tension x."""
    extensor: Real = 0.0
    """Share of the distal extensor tension y."""
    stiffness: Real = 0.0
    """Share of the elbow stiffness k."""
    constant: Real = 0.0
    """Part that depends on none of the three."""

    def of(self, flexor: Array, extensor: Array, stiffness: Array) -> Array:
        """Return the quantity without its constant.

        Args:
            flexor: Distal flexor tension, N.
            extensor: Distal extensor tension, N.
            stiffness: Elbow stiffness, N m/rad.
        """
        parts = ((self.flexor, flexor), (self.extensor, extensor), (self.stiffness, stiffness))
        return np.asarray(sum(share * value for share, value in parts if not is_nothing(share)))


def is_nothing(share: Real) -> bool:
    """Return True if a share is the number 0.0: the form has no such part."""
    return isinstance(share, float) and share == 0.0


@dataclass(frozen=True)
class LimitWords:
    """A limit in words; `{}` stands for its bound."""

    label: str
    """Fault of a design that breaks it, for a legend or a table."""
    topic: str
    """Subject in a word or two."""
    broken: str
    """Sentence that says how a state breaks it."""


@dataclass(frozen=True)
class Need:
    """A number that a study must state for a limit."""

    key: str
    """Dotted key."""
    phrase: str
    """The number in words."""
    example: str
    """A value as a study may state it."""


@dataclass(frozen=True, eq=False)
class DesignLimit:
    """One limit: on forms of states, on a number of the design, or with neither on power."""

    name: str
    """Key of `[limits]` and name of its quantity; min_ bounds from below, max_ from above, peak_ in
    magnitude."""
    accepts: tuple[float, float]
    """Least and largest bound that a study may state, SI."""
    words: LimitWords
    """The limit in messages and figures."""
    forms: Callable[[Any, Real], tuple[Form, ...]] | None = None
    """Forms of a `State` at a speed of the elbow (rad/s); the bound holds for every one."""
    of_design: Callable[[Any], Array] | None = None
    """Quantity of a `Design`, whatever its state."""
    column: str = ""
    """Column of designs that it bounds, by default the one of its name."""
    needs: tuple[Need, ...] = ()
    """Numbers that a study must state."""
    default: float | None = None
    """Bound if a study states none."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "column", self.column or self.name)

    @property
    def from_below(self) -> bool:
        """True if the smallest value is bounded."""
        return self.name.startswith("min_")

    @property
    def in_magnitude(self) -> bool:
        """True if the largest magnitude is bounded, on either side of zero."""
        return self.name.startswith("peak_")

    def bound_of(self, values: Real) -> Array:
        """Return bounds that are infinite, and so bound nothing, where values are NaN."""
        return np.where(np.isnan(values), -np.inf if self.from_below else np.inf, values)

    def range_of(self, bound: Real) -> tuple[Real | None, Real | None]:
        """Return the least and the largest value that a bound allows; None if there is none."""
        if self.from_below:
            return bound, None
        if self.in_magnitude:
            return -np.asarray(bound), bound
        return None, bound

    def beyond(self, values: Array, bound: Real) -> Array:
        """Return the excess of values over a bound; above 0 they break it."""
        if self.from_below:
            return np.asarray(bound - values)
        if self.in_magnitude:
            return np.asarray(np.abs(values) - bound)
        return np.asarray(values - bound)

    def room(self, values: Array, bound: Real) -> Array:
        """Return the room that values leave to a bound, negative where they break it.

        It is in the unit of the bound, and 0 within rounding of it. NaN, where there is nothing to
        compare, stays NaN. It is infinite without a bound.
        """
        room = -self.beyond(values, bound)
        is_rounding = np.abs(room) <= SLACK_TOLERANCE * np.abs(bound)
        return np.where(is_rounding & np.isfinite(room), 0.0, room)

    def value(self, state: Any, speed: Real = np.nan) -> Array:
        """Return the quantity in states; if it has several forms, the worst of them.

        Args:
            state: A `State`.
            speed: Speed of the elbow, rad/s.

        Raises:
            TypeError: If the limit is not on forms.
        """
        if self.forms is None:
            raise TypeError(f"{self.name} is not a limit on forms")
        parts = state.balance.flexor, state.balance.extensor, state.elbow_stiffness
        first, *others = (form.of(*parts) + form.constant for form in self.forms(state, speed))
        worst = first
        for value in others:
            is_worse = self.beyond(value, 0.0) > self.beyond(worst, 0.0)
            worst = np.where(is_worse, value, worst)
        return np.asarray(worst)
