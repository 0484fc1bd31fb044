"""Quantities that no table has and a figure may show: each follows from columns of `states`, row by row."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.quantities import Quantity

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Derived:
    """A quantity and how it follows from some columns."""

    quantity: Quantity
    needs: tuple[str, ...]
    """Columns; where a table has one per side, that of `side` counts."""
    side: str
    of: Callable[..., Array]
    """Takes the columns in the order of `needs`, SI values."""


def _ratio(flexor_travel: Array, extensor_travel: Array) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(extensor_travel == 0.0, np.nan, flexor_travel / extensor_travel)


def _sum(tendon_stretch: Array, spring_stretch: Array) -> Array:
    return np.asarray(tendon_stretch + spring_stretch)


def _spring_elongation(tension: Array, stiffness: Array) -> Array:
    return np.asarray(tension / stiffness)


def _elongation(tension: Array, pretension: Array, tendon_stretch: Array, spring_stretch: Array) -> Array:
    """Stretches are from the pretensioned state, and linear in tension, c (F - F0). From no load, c F."""
    change = tension - pretension
    with np.errstate(divide="ignore", invalid="ignore"):
        compliance = np.where(change == 0.0, np.nan, (tendon_stretch + spring_stretch) / change)
    return np.asarray(compliance * tension)


def _length(name: str, symbol: str, meaning: str) -> Quantity:
    return Quantity(name, symbol, "length", "m", "mm", meaning)


def _of_side(side: str, sign: str) -> tuple[Derived, ...]:
    tendon, spring, tension = f"{side}_tendon_stretch", f"{side}_spring_stretch", f"{side}_tension_distal"
    change = f"change of {side} tendon and spring length from the pretensioned state"
    total = f"{side} tendon and spring elongation from the unloaded state, negative where slack"
    of_spring = f"{side} spring elongation from its free length, negative where slack"
    return (
        Derived(_length(f"{side}_length_change", f"ΔL^{sign}", change), (tendon, spring), side, _sum),
        Derived(
            _length(f"{side}_elongation", f"δ^{sign}", total),
            (tension, "pretension", tendon, spring),
            side,
            _elongation,
        ),
        Derived(
            _length(f"{side}_spring_elongation", f"δ_SE^{sign}", of_spring),
            (tension, "spring_stiffness"),
            side,
            _spring_elongation,
        ),
    )


_RATIO = Quantity("radius_ratio", "H_f / H_e", "number", "1", "1", "flexor over extensor travel, Eq. 3")

DERIVED: dict[str, Derived] = {
    derived.quantity.name: derived
    for derived in (
        Derived(_RATIO, ("flexor_travel", "extensor_travel"), "", _ratio),
        *_of_side("flexor", "f"),
        *_of_side("extensor", "e"),
    )
}
