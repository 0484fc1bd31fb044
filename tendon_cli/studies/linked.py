"""Axes along which several numbers change together: a person's arm, a draw of the uncertain numbers.

Draws are scrambled Sobol points, each number independent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from tendon_cli.model.kinematics import Array
from tendon_cli.studies.uncertain import Uncertain


@dataclass(frozen=True, eq=False)
class Linked:
    """A linked axis: what it is called in a study, and what each of its values sets."""

    key: str
    """Also its column."""
    names: Sequence[str]
    """Of its values, in order."""
    numbers: Mapping[str, Array]
    """Numbers that it sets, by their dotted keys, each of shape (len(names),), SI."""
    scales: Mapping[str, Array] = field(default_factory=dict)
    """Factors on numbers that stand elsewhere: in the study, on an axis, or on another linked axis."""

    def __len__(self) -> int:
        return len(self.names)


def quantile(known: Uncertain, share: Array) -> Array:
    """The value below which a share of a distribution lies, SI; what a normal one has beyond its ends is cut off."""
    if known.kind == "uniform":
        return np.asarray(known.middle + known.spread * (2.0 * share - 1.0))
    from scipy.special import ndtr, ndtri  # only uncertain numbers pay for its import

    first, last = (ndtr((end - known.middle) / known.spread) for end in (known.low, known.high))
    value = known.middle + known.spread * ndtri(first + (last - first) * share)
    return np.asarray(np.clip(value, known.low, known.high))


def drawn(uncertain: Mapping[str, Uncertain], count: int, seed: int) -> dict[str, Array]:
    """`count` values of each number, by its key; the first so many of 2^m Sobol points."""
    from scipy.stats import qmc

    points = qmc.Sobol(len(uncertain), scramble=True, rng=np.random.default_rng([seed, len(uncertain)]))
    shares = points.random_base2(max(0, count - 1).bit_length())[:count]
    return {key: quantile(known, shares[:, at]) for at, (key, known) in enumerate(uncertain.items())}


def draw_axis(key: str, uncertain: Mapping[str, Uncertain], count: int, seed: int) -> Linked:
    """The axis of draws."""
    return Linked(key, tuple(f"draw {at + 1}" for at in range(count)), drawn(uncertain, count, seed))
