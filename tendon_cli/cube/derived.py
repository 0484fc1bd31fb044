"""Quantities that no table has and a figure may show: each follows from columns of `states`, row by row."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.quantities import OF_FIGURES, Quantity

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


def _elongation(tension: Array, pretension: Array, tendon_stretch: Array, spring_stretch: Array) -> Array:
    """Stretches are from the pretensioned state, and linear in tension, c (F - F0). From no load, c F."""
    change = tension - pretension
    with np.errstate(divide="ignore", invalid="ignore"):
        compliance = np.where(change == 0.0, np.nan, (tendon_stretch + spring_stretch) / change)
    return np.asarray(compliance * tension)


DERIVED = {"radius_ratio": Derived(OF_FIGURES["radius_ratio"], ("flexor_travel", "extensor_travel"), "", _ratio)}
for _side in ("flexor", "extensor"):
    _stretches, _tension = (f"{_side}_tendon_stretch", f"{_side}_spring_stretch"), f"{_side}_tension_distal"
    for _name, _needs, _of in (
        ("length_change", _stretches, np.add),
        ("elongation", (_tension, "pretension", *_stretches), _elongation),
        ("spring_elongation", (_tension, "spring_stiffness"), np.divide),
    ):
        DERIVED[f"{_side}_{_name}"] = Derived(OF_FIGURES[f"{_side}_{_name}"], _needs, _side, _of)
