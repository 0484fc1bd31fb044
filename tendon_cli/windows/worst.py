"""Worst values of choices over all conditions that their pretensions serve."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from tendon_cli.model.kinematics import Array
from tendon_cli.windows.by_choice import ByChoice, Selection


@dataclass(frozen=True, eq=False)
class Worst(ByChoice):
    """Worst values of choices over all conditions that are served, (choices,); NaN if unknown."""

    max_tension: Array
    """Largest tension of a tendon, N."""
    max_spring_extension: Array
    """Largest extension of a spring, m."""
    peak_motor_torque: Array
    """Motor torque of the largest magnitude, N m."""
    min_elbow_stiffness: Array
    """Least stiffness of the elbow, N m/rad."""
    max_contact_pressure: Array
    """Largest pressure under the strap, Pa."""
    spring_room: Array
    """Smallest room that the flexor's spring leaves between its anchors, m, its own length without
    load counted as far as the study states it; infinite without a spring there."""

    @classmethod
    def unknown(cls, count: int) -> Self:
        """Return the values of choices for which none is known."""
        return cls(*np.full((len(fields(cls)), count), np.nan))

    @classmethod
    def of_quantities(cls, largest: Array) -> Self:
        """Return worst values from the largest of QUANTITIES quantities, (QUANTITIES, choices).

        They are tension, spring extension, motor torque forward and backward, softness of the
        elbow, strap pressure, and the negated room for the flexor's spring.
        """
        tension, extension, forward, backward, softness, pressure, crowding = largest
        torque = np.where(backward > forward, -backward, forward)
        return cls(tension, extension, torque, -softness, pressure, -crowding)

    def with_values(self, rows: Selection, values: Worst) -> Self:
        """Return the same with the values of some choices, (rows,) each, in their places."""
        changed = {}
        for name in (field.name for field in fields(self)):
            changed[name] = getattr(self, name).copy()
            changed[name][rows] = getattr(values, name)
        return type(self)(**changed)


QUANTITIES = 7
"""Number of quantities whose largest values are the worst values; the torque is two."""
WORST = tuple(field.name for field in fields(Worst) if field.name != "spring_room")
"""Names of the worst values that have columns, which go by these names, too."""
