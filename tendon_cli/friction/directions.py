"""Which way the tendon moved in each reading, and which cell is the motor's."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.friction.reading.readings import Floats, Integers, Readings
from tendon_cli.units import shorten

_PULLED = {
    "up", "upward", "upwards", "raising", "raise", "rising", "lifting", "lift", "pull", "pulling", "pulled",
    "toward motor", "towards motor", "to motor", "loading", "winding", "weight is moving in upward direction",
    "auf", "hoch", "heben", "ziehen",
}  # fmt: skip
_DRAGGED = {
    "down", "downward", "downwards", "lowering", "lower", "falling", "release", "releasing", "released", "toward load",
    "towards load", "to load", "toward elbow", "towards elbow", "unloading", "unwinding",
    "weight is moving in downward direction", "ab", "runter", "senken", "nachlassen",
}  # fmt: skip
_MANY = 40
_STILL = 0.3
_RESTING = {"rest", "at rest", "stop", "stopped", "hold", "holding", "idle", "pause", "paused", "still", "none"}


@dataclass(frozen=True, eq=False)
class Directions:
    """The way of each reading, seen from the motor."""

    way: Integers
    """+1 where the tendon is pulled toward the motor, -1 toward the load, 0 where it is not known."""
    motor: str
    """"1" or "2", the cell at the motor."""
    notes: tuple[str, ...]
    """What was inferred and not given, to be said aloud."""
    warnings: tuple[str, ...] = ()
    """What speaks against it."""


def meanings(readings: Readings) -> tuple[list[str], list[int | None]]:
    """The tidied label of each row and what it means: +1 pulled, -1 dragged, 0 at rest, None for a bare name."""
    labels = [_tidy(label) for label in readings.directions or ()]
    # 0 beside 1 and -1 is a motor at rest; 0 and 1 alone are two names.
    rest = _RESTING | ({"0"} if len(set(labels) - {"0"}) >= 2 else set())
    known: dict[str, int | None] = {}
    for row, label in enumerate(labels):
        if not label:
            raise InputError("the direction is missing", where=readings.place(row))
        known[label] = 1 if label in _PULLED else -1 if label in _DRAGGED else 0 if label in rest else None
    return labels, [known[label] for label in labels]


def _tidy(label: str) -> str:
    text = label.casefold().strip(' *:"')
    text = re.sub(r"^case[\s_]*(?=.)", "", text)
    if re.fullmatch(r"[+-]?[012](\.0*)?", text):
        return str(int(float(text)))
    return re.sub(r"[\s_-]+", " ", text).strip()


def named_sides(
    readings: Readings,
    labels: list[str],
    meaning: list[int | None],
    log_ratio: Floats,
    good: npt.NDArray[np.bool_],
) -> Integers | None:
    """+1 for rows named like the upper ratio cell 1 / cell 2, -1 like the lower; None where nothing is named."""
    if not labels:
        return None
    present = np.array(labels, dtype=object)
    names = sorted({label for label, known, fine in zip(labels, meaning, good, strict=True) if known != 0 and fine})
    if len(names) == 0 or (len(names) == 1 and len(labels) >= _MANY):
        return None  # one name for a whole log says nothing about its strokes
    if any(known is None for known in meaning) and any(known in {1, -1} for known in meaning):
        raise InputError(
            f"directions are named in two ways: {', '.join(shorten(name, 20) for name in names[:6])}",
            where=readings.source,
            hint='use "up" and "down", or two names of your own',
        )
    means = {name: float(np.mean(log_ratio[good & (present == name)])) for name in names}
    middle = (max(means.values()) + min(means.values())) / 2.0 if len(names) == 2 else 0.0
    sides = {name: 1 if mean > middle else -1 for name, mean in means.items()}
    return np.array([sides.get(label, 0) for label in labels], dtype=np.int64)


def sides_by_sign(readings: Readings, log_ratio: Floats, rows: Integers) -> Integers:
    """The same from the forces of a short table: the motor's cell reads more when it pulls."""
    ordered = np.sort(log_ratio[rows])
    steps = np.diff(ordered)
    if len(steps) > 1 and (ordered[0] > 0.0 or ordered[-1] < 0.0):
        gap = float(steps.max())
        if gap > 3.0 * (ordered[-1] - ordered[0] - gap) and gap > 0.1 * float(np.mean(np.abs(ordered))):
            raise InputError(
                "the readings form two groups on the same side of ratio 1, so the direction cannot be told from the"
                " forces",
                where=readings.source,
                hint='add a column "direction" with "up" and "down"',
            )
    return np.sign(log_ratio).astype(np.int64)


def find_motor(
    readings: Readings,
    sides: Integers,
    meaning: list[int | None],
    used: npt.NDArray[np.bool_],
    motor: str | None,
) -> Directions:
    """Settle which cell is the motor's: as told, by the headers, by named directions, or by the steadier force."""
    told = motor or readings.motor
    meant = np.array([known or 0 for known in meaning], dtype=np.int64) if meaning else np.zeros_like(sides)
    agree = int(np.sum((meant * sides)[used]))
    by_name = "1" if agree > 0 else "2" if agree < 0 else None
    if told and by_name and told != by_name:
        raise InputError(
            f"friction would help the motion: with cell {told} at the motor, its force is the smaller one where the"
            " tendon is pulled toward it",
            where=readings.source,
            hint=f"if cell {by_name} is at the motor, say --motor {by_name}; else check the column of directions",
        )
    notes, warnings = list[str](), tuple[str, ...]()
    header = readings.names[0 if (told or by_name) == "1" else 1]
    if not motor and told:
        notes.append(f'cell {told} ("{shorten(header, 30)}") is taken as the motor\'s, from its header')
    elif not told and by_name:
        notes.append(
            f"cell {by_name} is taken as the motor's: it reads more where the tendon is pulled toward the motor"
        )
    chosen = told or by_name
    changes = _changes(readings, sides, used)
    if readings.motor and not motor and changes[int(readings.motor) - 1] < _STILL * max(changes):
        warnings = (
            f'"{shorten(header, 30)}" hardly changes between the directions, the other does: are the headers swapped?',
        )
    if chosen is None:
        chosen, note = _by_steadiness(*changes)
        notes.append(note)
    return Directions(sides if chosen == "1" else -sides, chosen, tuple(notes), warnings)


def _changes(readings: Readings, sides: Integers, used: npt.NDArray[np.bool_]) -> tuple[float, float]:
    """How much each cell changes between the directions, in the log; 0 where there is one direction only."""
    upper, lower = used & (sides > 0), used & (sides < 0)
    if not upper.any() or not lower.any():
        return 0.0, 0.0
    one, two = (
        abs(float(np.mean(np.log(cell[upper])) - np.mean(np.log(cell[lower]))))
        for cell in (readings.cell_1, readings.cell_2)
    )
    return one, two


def _by_steadiness(one: float, two: float) -> tuple[str, str]:
    """The load's force changes less between the directions than the motor's."""
    for number, mine, other in (("1", one, two), ("2", two, one)):
        if mine > 2.0 * other:
            return number, f"cell {number} is taken as the motor's: it changes more between the two directions"
    return "1", "cell 1 is taken as the motor's, since nothing says which is; --motor 2 says otherwise"
