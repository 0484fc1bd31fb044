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
    """In `rig.Answer` and `tool`."""
    unit: str
    floor: float
    """Smallest magnitude that a difference is related to, so that slack tensions of 0 N count too."""
    needs_tension: bool = False
    """Not determined where both tendons are slack."""


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
    """How many states have a value to compare."""
    largest: float
    """Magnitude of the largest value, in the quantity's unit."""
    absolute: float
    relative: float
    """To the engine's value or the floor, whichever is larger."""
    worst: int
    """Number of the case with the largest relative difference."""

    @property
    def holds(self) -> bool:
        """Within the tolerance; a value that is not a number never is."""
        return bool(self.relative <= TOLERANCE)


def differences(engine: list[Answer], tool: ToolAnswers) -> list[Difference]:
    """One entry per quantity."""
    return [_difference(quantity, engine, tool) for quantity in QUANTITIES]


def _difference(quantity: Quantity, engine: list[Answer], tool: ToolAnswers) -> Difference:
    flexor, extensor = engine_slack(engine)
    chosen = ~(flexor & extensor) if quantity.needs_tension else np.ones(len(engine), dtype=bool)
    expected = np.array([getattr(answer, quantity.name) for answer in engine])[chosen]
    got = tool.values[quantity.name][chosen]
    absolute = np.abs(got - expected)
    relative = absolute / np.maximum(np.abs(expected), quantity.floor)
    return Difference(
        quantity=quantity,
        states=int(chosen.sum()),
        largest=float(np.abs(expected).max()),
        absolute=float(absolute.max()),
        relative=float(relative.max()),
        worst=int(np.flatnonzero(chosen)[np.argmax(relative)]),
    )


def engine_slack(engine: list[Answer]) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Whether flexor and extensor are slack in the engine."""
    flexor = np.array([answer.flexor_is_slack for answer in engine])
    return flexor, np.array([answer.extensor_is_slack for answer in engine])


def disagreements(engine: list[Answer], tool: ToolAnswers) -> int:
    """In how many states tool and engine differ on which side is slack, or the tool makes up a free spool angle."""
    flexor, extensor = engine_slack(engine)
    our_flexor, our_extensor = side_is_slack(tool.status)
    unknown = np.isnan(tool.values["spool_angle"])
    return int(
        (
            (flexor != our_flexor) | (extensor != our_extensor) | (unknown != (flexor & extensor))
        ).sum()
    )


def table(rows: list[Difference]) -> str:
    """The differences as a Markdown table that also reads well in a terminal."""
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
    widths = [max(len(line[column]) for line in cells) for column in range(len(head))]
    lines = [
        "| "
        + " | ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True))
        + " |"
        for line in cells
    ]
    return "\n".join(
        [lines[0], "|" + "|".join("-" * (width + 2) for width in widths) + "|", *lines[1:]]
    )


def _cells(row: Difference) -> tuple[str, ...]:
    name = _LONG_NAMES.get(row.quantity.name, row.quantity.name.replace("_", " "))
    numbers = f"{row.largest:.3g}", f"{row.absolute:.0e}", f"{row.relative:.0e}", f"{TOLERANCE:.0e}"
    return (
        name,
        row.quantity.unit,
        str(row.states),
        *numbers,
        "holds" if row.holds else f"MISSED, case {row.worst}",
    )


def counts(tool: ToolAnswers) -> str:
    """How many states there are of each status."""
    number = np.bincount(tool.status, minlength=len(statics.STATUS_NAMES))
    return ", ".join(
        f"{count} {name}" for count, name in zip(number, statics.STATUS_NAMES, strict=True) if count
    )
