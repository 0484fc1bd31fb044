"""Differences between tool and engine, quantity by quantity, and the table of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model import statics
from verification.rig import Answer
from verification.tool import ToolAnswers, side_is_slack

TOLERANCE = 1e-6


@dataclass(frozen=True)
class Quantity:
    """A row of the table."""

    name: str
    """Name in `rig.Answer` and `tool.ToolAnswers`."""
    unit: str
    floor: float
    """Smallest magnitude that a difference is divided by, so that tensions of 0 N count too."""
    needs_tension: bool = False
    """True if the quantity is not determined where both tendons are slack."""


QUANTITIES = (
    Quantity("flexor_path", "m", 1e-3),
    Quantity("flexor_moment_arm", "m", 1e-3),
    Quantity("extensor_travel", "m", 1e-3),
    Quantity("extensor_moment_arm", "m", 1e-3),
    Quantity("elbow_torque", "N m", 1e-3),
    Quantity("flexor_tension", "N", 1.0),
    Quantity("extensor_tension", "N", 1.0),
    Quantity("motor_torque", "N m", 1e-3),
    Quantity("spool_angle", "rad", 1e-3, needs_tension=True),
    Quantity("loose", "m", 1e-3),
    Quantity("flexor_slack", "m", 1e-3, needs_tension=True),
    Quantity("extensor_slack", "m", 1e-3, needs_tension=True),
    Quantity("elbow_stiffness", "N m/rad", 1.0),
)
_LONG_NAMES = {"loose": "path left loose by both"}


@dataclass(frozen=True)
class Difference:
    """The largest differences of a quantity."""

    quantity: Quantity
    states: int
    """Number of states with a value to compare."""
    largest: float
    """Magnitude of the largest value, in the quantity's unit."""
    absolute: float
    """Largest difference, in the quantity's unit."""
    relative: float
    """Largest difference as a share of the engine's value or of the floor, if that is larger."""
    worst: int
    """Number of the case with the largest relative difference."""

    @property
    def holds(self) -> bool:
        """True if within the tolerance; a value that is not a number never is."""
        return bool(self.relative <= TOLERANCE)


def differences(engine: list[Answer], tool: ToolAnswers) -> list[Difference]:
    """Return the largest differences of each quantity."""
    return [_difference(quantity, engine, tool) for quantity in QUANTITIES]


def _difference(quantity: Quantity, engine: list[Answer], tool: ToolAnswers) -> Difference:
    """Return the largest differences of a quantity, over the states that determine it."""
    is_determined = np.ones(len(engine), dtype=bool)
    if quantity.needs_tension:
        flexor, extensor = engine_slack(engine)
        is_determined = ~(flexor & extensor)
    expected = np.array([getattr(answer, quantity.name) for answer in engine])[is_determined]
    got = tool.values[quantity.name][is_determined]
    absolute = np.abs(got - expected)
    relative = absolute / np.maximum(np.abs(expected), quantity.floor)
    return Difference(
        quantity=quantity,
        states=int(is_determined.sum()),
        largest=float(np.abs(expected).max()),
        absolute=float(absolute.max()),
        relative=float(relative.max()),
        worst=int(np.flatnonzero(is_determined)[np.argmax(relative)]),
    )


def engine_slack(engine: list[Answer]) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Return masks of the states in which flexor and extensor are slack in the engine."""
    flexor = np.array([answer.flexor_is_slack for answer in engine])
    extensor = np.array([answer.extensor_is_slack for answer in engine])
    return flexor, extensor


def disagreements(engine: list[Answer], tool: ToolAnswers) -> int:
    """Count the states in which tendon and the engine differ on which side is slack.

    The spool angle must be undetermined just where both sides are slack.
    """
    flexor, extensor = engine_slack(engine)
    our_flexor, our_extensor = side_is_slack(tool.status)
    has_no_angle = np.isnan(tool.values["spool_angle"])
    sides_differ = (flexor != our_flexor) | (extensor != our_extensor)
    angle_differs = has_no_angle != (flexor & extensor)
    return int((sides_differ | angle_differs).sum())


def table(rows: list[Difference]) -> str:
    """Return the differences as a Markdown table that also reads well in a terminal."""
    head = (
        "quantity",
        "unit",
        "states",
        "largest value",
        "largest difference",
        "relative",
        "tolerance",
        "verdict",
    )
    cells = [head, *(_cells(row) for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = []
    for row_cells in cells:
        padded = [cell.ljust(width) for cell, width in zip(row_cells, widths, strict=True)]
        lines.append(f"| {' | '.join(padded)} |")
    rule = "|".join("-" * (width + 2) for width in widths)
    return "\n".join([lines[0], f"|{rule}|", *lines[1:]])


def _cells(row: Difference) -> tuple[str, ...]:
    """Return a row of the table."""
    name = row.quantity.name
    return (
        _LONG_NAMES.get(name, name.replace("_", " ")),
        row.quantity.unit,
        str(row.states),
        f"{row.largest:.3g}",
        f"{row.absolute:.0e}",
        f"{row.relative:.0e}",
        f"{TOLERANCE:.0e}",
        "holds" if row.holds else f"MISSED, case {row.worst}",
    )


def counts(tool: ToolAnswers) -> str:
    """Return the number of states of each status, in words."""
    numbers = np.bincount(tool.status, minlength=len(statics.STATUS_NAMES))
    named = zip(numbers, statics.STATUS_NAMES, strict=True)
    return ", ".join(f"{number} {name}" for number, name in named if number)
