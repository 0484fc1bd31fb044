"""What a limit is made of: the form that it bounds, what it needs, and its words. The table is in `limits`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli.model.kinematics import Array, Real


@dataclass(frozen=True, eq=False)
class Form:
    """A quantity of a state: flexor x + extensor y + stiffness k + constant. A share that is 0.0 has no part in it."""

    flexor: Real = 0.0
    extensor: Real = 0.0
    stiffness: Real = 0.0
    constant: Real = 0.0

    def of(self, flexor: Array, extensor: Array, stiffness: Array) -> Array:
        """The quantity but for its constant, from both distal tensions (N) and the elbow stiffness (N m/rad)."""
        parts = ((self.flexor, flexor), (self.extensor, extensor), (self.stiffness, stiffness))
        return np.asarray(sum(share * value for share, value in parts if not is_nothing(share)))


def is_nothing(share: Real) -> bool:
    """Whether a form has no such part."""
    return isinstance(share, float) and share == 0.0


@dataclass(frozen=True)
class LimitWords:
    """A limit in words; `{}` stands for its bound."""

    label: str
    """What is wrong if it is not kept, for a legend or a table."""
    topic: str
    """What it is about."""
    broken: str
    """What happens if it is not kept, as a sentence."""
    keeps: str
    """What a pretension does that is high enough, after "the pretension that"."""
    breaks: str
    """What a pretension does that is too high, after "the pretension ... already"."""


@dataclass(frozen=True)
class Need:
    """What a study must state for a limit."""

    key: str
    what: str
    example: str


@dataclass(frozen=True, eq=False)
class DesignLimit:
    """One limit: on forms of single states, on a number of the design, or on the whole motion."""

    name: str
    """Key of `[limits]` and name of its quantity: min_ bounds from below, max_ from above, peak_ in magnitude."""
    accepts: tuple[float, float]
    """What a study may say, SI."""
    words: LimitWords
    forms: Callable[[Any, Real], tuple[Form, ...]] | None = None
    """Of a `State` and of the elbow's speed (rad/s): every one of them is held."""
    of_design: Callable[[Any], Array] | None = None
    """Of a `Design`, whatever its state."""
    lines: Callable[[Any], Any] | None = None
    """Of the whole motion, a `Motor`, its straight lines in pretension or None; in magnitude."""
    excess: Callable[[Any, Real], Callable[[Array], Array]] | None = None
    """Of the whole motion, by how much a bound is exceeded at a pretension; no straight line."""
    column: str = ""
    """The column of designs that it bounds; by default of its name."""
    needs: tuple[Need, ...] = ()
    default: float | None = None
    """Its bound if a study says nothing."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "column", self.column or self.name)

    @property
    def from_below(self) -> bool:
        """Whether it is the smallest that is bounded."""
        return self.name.startswith("min_")

    @property
    def in_magnitude(self) -> bool:
        """Whether it is the largest magnitude that is bounded, on either side of zero."""
        return self.name.startswith("peak_")

    @property
    def of_motion(self) -> bool:
        """Whether it compares states of the whole motion."""
        return self.lines is not None or self.excess is not None

    def range_of(self, bound: Real) -> tuple[Real | None, Real | None]:
        """The least and the largest that its quantity may be."""
        if self.from_below:
            return bound, None
        return (-np.asarray(bound) if self.in_magnitude else None), bound

    def beyond(self, values: Array, bound: Real) -> Array:
        """By how much values are outside of the bound: above 0 they break it."""
        if self.from_below:
            return np.asarray(bound - values)
        return np.asarray((np.abs(values) if self.in_magnitude else values) - bound)

    def value(self, state: Any, speed: Real = np.nan) -> Array:
        """Its quantity in states (`State`), of several forms that nearest to the bound; TypeError if it has none."""
        if self.forms is None:
            raise TypeError(f"{self.name} is no limit on single states")
        at = state.balance.flexor, state.balance.extensor, state.elbow_stiffness
        values = [form.of(*at) + form.constant for form in self.forms(state, speed)]
        worst = values[0]
        for other in values[1:]:
            worst = np.where(self.beyond(other, 0.0) > self.beyond(worst, 0.0), other, worst)
        return np.asarray(worst)
