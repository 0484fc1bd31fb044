"""Which way the tendon moved in each reading, and which cell is the motor's."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.friction.limits import levels_of
from tendon_cli.friction.reading.readings import Floats, Integers, Readings
from tendon_cli.friction.rows import noise_of
from tendon_cli.units import shorten

Mask = npt.NDArray[np.bool_]

_PULLED = {
    "up", "upward", "upwards", "raising", "raise", "rising", "lifting", "lift", "pull", "pulling", "pulled",
    "toward motor", "towards motor", "to motor", "loading", "winding", "weight is moving in upward direction",
    "auf", "hoch", "heben", "ziehen",
}  # fmt: skip
_RELEASED = {
    "down", "downward", "downwards", "lowering", "lower", "falling", "release", "releasing", "released", "toward load",
    "towards load", "to load", "toward elbow", "towards elbow", "unloading", "unwinding",
    "weight is moving in downward direction", "ab", "runter", "senken", "nachlassen",
}  # fmt: skip
_RESTING = {"rest", "at rest", "stop", "stopped", "hold", "holding", "idle", "pause", "paused", "still", "none"}
_MANY = 40
"""Rows from which one name for all of them says nothing: it is the name of the log."""
_STILL = 0.3
"""A motor's cell that changes less than this share of the other's between the directions is not the motor's."""
_SLOW = 0.05
"""Of the usual speed: what is slower rests. Creep after a stop is slower, a crank passes its turn within few rows."""


@dataclass(frozen=True, eq=False)
class Named:
    """What the file itself says of each row's direction."""

    way: Integers | None
    """+1 for rows named like the upper ratio cell 1 / cell 2, -1 like the lower, 0 at rest; None if nothing is
    named."""
    meaning: Integers
    """+1 pulled, -1 released, by the name's own meaning; 0 for a name without one."""
    rest: Mask
    """Rows in which the motor stands."""


def meanings(readings: Readings) -> tuple[Integers, Mask, Mask]:
    """Per row: what its label means (+1, -1, 0 for nothing), whether it says rest, whether it is a bare name."""
    rows, labels = len(readings.lines), readings.directions
    if labels is None:
        return np.zeros(rows, dtype=np.int64), np.zeros(rows, dtype=bool), np.zeros(rows, dtype=bool)
    names = [_tidy(name) for name in labels.names]
    if "" in names:
        row = int(np.argmax(labels.code == names.index("")))
        raise InputError("the direction is missing", where=readings.place(row))
    # 0 beside 1 and -1 is a motor at rest; 0 and 1 alone are two names.
    rest = _RESTING | ({"0"} if len(set(names) - {"0"}) >= 2 else set())
    known = np.array([1 if name in _PULLED else -1 if name in _RELEASED else 0 for name in names], dtype=np.int64)
    resting = np.array([name in rest for name in names])
    return known[labels.code], resting[labels.code], ((known == 0) & ~resting)[labels.code]


def _tidy(label: str) -> str:
    text = re.sub(r"^case[\s_]*(?=.)", "", label.casefold().strip(' *:"'))
    if re.fullmatch(r"[+-]?[012](\.0*)?", text):
        return str(int(float(text)))
    return re.sub(r"[\s_-]+", " ", text).strip()


def resting(readings: Readings) -> Mask:
    """Rows in which the motor stands, by a column of position, speed or direction."""
    if readings.position is not None:
        return np.asarray(moving(readings) == 0)
    return meanings(readings)[1]


def named_ways(readings: Readings, log_ratio: Floats, good: Mask) -> Named:
    """Directions by a column of position or speed, else by a column of names; `log_ratio` is of the good rows."""
    meaning, rest, bare = meanings(readings)
    if readings.position is not None:
        motion = moving(readings)
        return Named(_like_the_ratio(readings, motion, log_ratio, good), np.zeros_like(motion), motion == 0)
    if readings.directions is None:
        return Named(None, meaning, rest)
    code = readings.directions.code
    names = np.unique(code[good])
    if len(names) == 0 or (len(names) == 1 and len(code) >= _MANY):
        return Named(None, meaning, rest)
    if bare.any() and np.any(meaning != 0):
        shown = ", ".join(shorten(name, 20) for name in readings.directions.names[:6])
        hint = 'use "pull", "release" and "rest", or two names of your own'
        raise InputError(f"directions are named in two ways: {shown}", where=readings.source, hint=hint)
    means = {int(name): float(np.mean(log_ratio[code[good] == name])) for name in names}
    middle = (max(means.values()) + min(means.values())) / 2.0 if len(names) == 2 else 0.0
    side = np.zeros(len(readings.directions.names), dtype=np.int64)
    for name, mean in means.items():
        side[name] = 1 if mean > middle else -1
    return Named(np.where(rest, 0, side[code]), meaning, rest)


def moving(readings: Readings) -> Integers:
    """+1, -1 or 0 (at rest) by a column of position or speed."""
    position = np.zeros(0) if readings.position is None else readings.position
    known = np.isfinite(position)
    if not known.any() or np.ptp(position[known]) == 0.0:
        problem = f'"{shorten(readings.position_name, 30)}" never moves'
        raise InputError(problem, where=readings.source, hint="name the column of the motor's position: --position")
    rows = np.arange(len(position))
    x = np.interp(rows, rows[known], position[known])
    speed, noise, width = x, noise_of(x), 1
    while not readings.position_is_speed:  # wide enough for the noise and the steps of an encoder
        speed = x[np.minimum(rows + width, len(x) - 1)] - x[np.maximum(rows - width, 0)]
        if width >= 16 or np.quantile(np.abs(speed), 0.9) >= 10.0 * noise:
            break
        width *= 2
    usual = float(np.quantile(np.abs(speed), 0.9))
    least = max(_SLOW * usual, min(3.0 * noise, 0.5 * usual))
    return np.where(np.abs(speed) > least, np.sign(speed), 0.0).astype(np.int64)


def _like_the_ratio(readings: Readings, motion: Integers, log_ratio: Floats, good: Mask) -> Integers:
    """The motion with the sign that the ratio has."""
    middle, half = levels_of(log_ratio)
    counted = (np.abs(log_ratio - middle) > 0.5 * half) & (motion[good] != 0)
    agree = float(np.mean((motion[good] * np.sign(log_ratio - middle))[counted])) if counted.any() else 0.0
    if abs(agree) < 0.2 and len(np.unique(motion[good])) > 1:
        problem = f'"{shorten(readings.position_name, 30)}" turns at other times than the force ratio does'
        raise InputError(problem, where=readings.source, hint="is it the motor's position, and of the same clock?")
    return motion if agree >= 0.0 else -motion


def sides_by_sign(readings: Readings, log_ratio: Floats) -> Integers:
    """Directions of a short table by the forces: the motor's cell reads more when it pulls."""
    ordered = np.sort(log_ratio)
    steps = np.diff(ordered)
    if len(steps) > 1 and (ordered[0] > 0.0 or ordered[-1] < 0.0):
        gap = float(steps.max())
        if gap > 3.0 * (ordered[-1] - ordered[0] - gap) and gap > 0.1 * float(np.mean(np.abs(ordered))):
            raise InputError(
                "the readings form two groups on the same side of ratio 1, so the forces do not show the direction",
                where=readings.source,
                hint='add a column "direction" with "pull" and "release"',
            )
    return np.sign(log_ratio).astype(np.int64)


@dataclass(frozen=True, eq=False)
class MotorCell:
    """Which cell is the motor's."""

    cell: str
    """"1" or "2"."""
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def find_motor(readings: Readings, sides: Integers, meaning: Integers, used: Mask, motor: str | None) -> MotorCell:
    """As given, by the headers, by named directions, or by the steadier force; `sides` is 0 in rows not used."""
    agree = int(np.sum((meaning * sides)[used]))
    by_name = "1" if agree > 0 else "2" if agree < 0 else None
    given = motor or readings.motor
    if given and by_name and given != by_name:
        raise InputError(
            f"friction would help the motion: with cell {given} at the motor, its force is the smaller one where the"
            " tendon is pulled toward it",
            where=readings.source,
            hint=f"if cell {by_name} is at the motor, say --motor {by_name}; else check the column of directions",
        )
    if motor or (by_name and not given):
        return MotorCell(motor or by_name or "1")
    changes = _changes(readings, sides, used)
    if given:
        header = f'"{shorten(readings.names[0 if given == "1" else 1], 30)}"'
        swapped = changes[int(given) - 1] < _STILL * max(changes)
        warning = f"{header} hardly changes between the directions, the other does: are the headers swapped?"
        return MotorCell(given, (), (warning,) if swapped else ())
    for number, mine, other in (("1", *changes), ("2", *changes[::-1])):
        if mine > 2.0 * other:  # the load's force changes less between the directions than the motor's
            note = f"cell {number} is taken as the motor's: it changes more between the directions"
            return MotorCell(number, (note,))
    return MotorCell("1", ("cell 1 is taken as the motor's, since nothing says which is; --motor 2 says otherwise",))


def _changes(readings: Readings, sides: Integers, used: Mask) -> tuple[float, float]:
    """How much each cell changes between the directions, in the log; 0 if there is one direction only."""
    upper, lower = used & (sides > 0), used & (sides < 0)
    if not upper.any() or not lower.any():
        return 0.0, 0.0
    one, two = (
        abs(float(np.mean(np.log(cell[upper])) - np.mean(np.log(cell[lower]))))
        for cell in (readings.cell_1, readings.cell_2)
    )
    return one, two
