"""Worst values of choices over all conditions that their pretensions serve."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Self

import numpy as np

from tendon_cli.engine.windows.by_choice import ByChoice, Selection
from tendon_cli.model.kinematics import Array


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
    motion: Mapping[str, Array] = field(default_factory=dict)
    """Columns of motion by name: the largest value, of the efficiency the smallest."""

    @classmethod
    def unknown(cls, count: int, motion: Iterable[str] = ()) -> Self:
        """Return the values of choices for which none is known, with some columns of motion."""
        of_states = {name: np.full(count, np.nan) for name in OF_STATES}
        return cls(**of_states, motion={name: np.full(count, np.nan) for name in motion})

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
        for name in OF_STATES:
            changed[name] = getattr(self, name).copy()
            changed[name][rows] = getattr(values, name)
        motion = {name: column.copy() for name, column in self.motion.items()}
        for name, column in values.motion.items():
            motion[name][rows] = column
        return type(self)(**changed, motion=motion)


QUANTITIES = 7
"""Number of quantities whose largest values are the worst values; the torque is two."""
OF_STATES = tuple(one.name for one in fields(Worst) if one.name != "motion")
"""Names of the worst values of states."""
WORST = tuple(name for name in OF_STATES if name != "spring_room")
"""Names of the worst values that have columns, which go by these names, too."""
