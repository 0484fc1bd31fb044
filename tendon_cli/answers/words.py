"""Choices, conditions, states and limits as people say them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from tendon_cli.answers.factors import Combinations
from tendon_cli.model.limits import ALWAYS, LIMITS
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.studies.study import keys
from tendon_cli.units import UNITS


def rounded(value: float, digits: int = 3) -> str:
    """A number to some significant digits, without an exponent where people would write none."""
    if not math.isfinite(value):
        return "any" if value > 0 else "none"
    short = float(f"{value:.{digits}g}")
    whole = f"{short:,.0f}" if abs(short) >= 10**digits else f"{short:g}"
    return "0" if short == 0.0 else whole.replace(",", " ")


def shown(quantity: Quantity, value: float, digits: int = 3) -> str:
    """A value in SI in the unit that people read it in."""
    unit = quantity.shown_in
    number = rounded(value / float(UNITS[unit].factor), digits) if unit in UNITS else rounded(value, digits)
    return number if unit == "1" else f"{number} {unit}"


def of_key(key: str, value: float) -> str:
    """A number of a study, with its symbol."""
    quantity = keys()[key].number.quantity
    side = next((f" of the {word}" for word in ("flexor", "extensor") if f".{word}." in key), "")
    return f"{quantity.symbol}{side} {shown(quantity, value)}"


def of_row(product: Combinations, columns: Mapping[str, Any]) -> str:
    """A choice or a condition: what it has of each axis; empty where there is none."""
    said = []
    for factor in product.factors:
        value = columns[factor.column]
        said.append(factor.names[int(value)] if factor.names else of_key(factor.key, float(value)))
    return ", ".join(said)


def broken(limit: str, bounds: Mapping[str, float]) -> str:
    """What happens where a limit is not kept."""
    bound = shown(QUANTITIES[limit], bounds[limit]) if limit in bounds else ""
    if limit == "min_elbow_stiffness" and bounds.get(limit) == 0.0:
        return "the elbow is unstable"
    return (ALWAYS[limit] if limit in ALWAYS else LIMITS[limit].words).broken.format(bound)
