"""Limits that designs break, found in columns of their table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from tendon_cli.checks.check_text import NO_EQUILIBRIUM, SLACK
from tendon_cli.cube.cube import Cube
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMITS
from tendon_cli.model.statics import SLACK_TOLERANCE
from tendon_cli.quantities import SIDES

Breach = dict[str, Any]
"""A limit that a design breaks, as in the record."""


def columns_of(limit: str) -> list[str]:
    """Return the column that a limit bounds, and those of flexor and extensor if there are any."""
    column = LIMITS[limit].column
    return [column, *(f"{column}_{side}" for side in SIDES)]


def columns_that_judge(cube: Cube) -> list[str]:
    """Return the columns from which breaches are found, whether a table has them or not."""
    names = ["feasible", "taut", "margin", "required_pretension"]
    for limit in cube.limits:
        names += [*columns_of(limit), *cube.columns_of_bound(limit)]
    return list(dict.fromkeys(names))


def breaches_in(columns: Mapping[str, Array], bounds: Mapping[str, Array]) -> Iterator[Breach]:
    """Yield every breach of a limit by a design, in SI.

    Slack and no equilibrium count as limits. The value of slack is the margin of pretension. The
    excess is a share of the bound, or for slack of the pretension needed; -inf marks limits kept.

    Args:
        columns: Columns of the designs, (designs,) each.
        bounds: Limits by name, () or (designs,) each.
    """
    needed = columns["required_pretension"]
    margin = columns["margin"]
    no_equilibrium = np.isnan(needed)
    is_slack = (columns["taut"] == 0.0) & ~no_equilibrium
    no_value = np.full(len(needed), np.nan)
    missing = np.where(is_slack, -margin / np.maximum(needed, 1e-300), -np.inf)
    judged = [
        (NO_EQUILIBRIUM, no_value, no_value, np.where(no_equilibrium, np.inf, -np.inf)),
        (SLACK, margin, np.zeros_like(margin), missing),
    ]
    for limit, bound in bounds.items():
        scale = np.where(bound == 0.0, 1.0, np.abs(bound))
        of_designs = np.broadcast_to(bound, needed.shape)
        for name in columns_of(limit):
            if name in columns:
                with np.errstate(invalid="ignore"):  # without a bound there is no share of it
                    excess = LIMITS[limit].beyond(columns[name], bound) / scale
                excess = np.where(excess > SLACK_TOLERANCE, excess, -np.inf)
                judged.append((limit, columns[name], of_designs, excess))
    for limit, values, of_designs, excess in judged:
        for row in np.flatnonzero((columns["feasible"] == 0.0) & (excess > -np.inf)):
            yield {
                "design": int(columns["design"][row]),
                "limit": limit,
                "value": float(values[row]),
                "bound": float(of_designs[row]),
                "excess": float(excess[row]),
                "direction": None,
                "elbow_angle": None,
                "time": None,
            }
