"""Which way the tendon moved in each reading, and which cell is the motor's."""

from __future__ import annotations

import re

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.friction.reading.readings import Floats, Integers, Mask, Readings
from tendon_cli.friction.usable_rows import noise_of
from tendon_cli.units import shorten

_PULLED = re.compile(
    r"up(wards?)?|rais(e|ing)|rising|lift(ing)?|pull(ing|ed)?|(towards?|to) motor|loading|winding"
    r"|weight is moving in upward direction|auf|hoch|heben|ziehen"
)
_RELEASED = re.compile(
    r"down(wards?)?|lower(ing)?|falling|releas(e|ing|ed)|(towards?|to) load|towards? elbow|unloading|unwinding"
    r"|weight is moving in downward direction|ab|runter|senken|nachlassen"
)
_RESTING = re.compile(r"(at )?rest|stop(ped)?|hold(ing)?|idle|paused?|still|none")
_MANY = 40
"""Rows from which one name for all of them says nothing: it is the name of the log."""
_TRIGGER = 0.3
"""Of the half distance: how far past the middle the ratio turns a stroke. Noise below a tenth of it never does."""
_STILL, _STEADIER = 0.3, 2.0
"""Change of the motor's cell between the directions over the other's: under 0.3 it is not the motor's; the force that
changes over twice as much is the motor's."""
_SLOW = 0.05
"""Of the usual speed: what is slower rests. Creep after a stop is slower, a crank passes its turn within few rows."""


def stated_motion(readings: Readings) -> tuple[Integers, Mask]:
    """Way of the motor in each row, by a column of position or speed or else of names, and where it rests.

    The way is 0 at rest, and where a name says nothing of it.
    """
    if "position" in readings.rows:
        way = _moving(readings)
        return way, way == 0
    if "direction" not in readings.rows:
        return np.zeros(len(readings.rows), dtype=np.int64), np.zeros(
            len(readings.rows), dtype=bool
        )
    labels, code = readings.codes("direction")
    names = [_tidy(str(label)) for label in labels]
    if "" in names:
        row = int(np.argmax(code == names.index("")))
        raise InputError("the direction is missing", where=readings.place(row))
    is_signed = (
        len(set(names) - {"0"}) >= 2
    )  # 0 with 1 and -1 is a motor at rest; 0 and 1 alone are two names
    known = np.array(
        [bool(_PULLED.fullmatch(name)) - bool(_RELEASED.fullmatch(name)) for name in names],
        np.int64,
    )
    resting = np.array(
        [bool(_RESTING.fullmatch(name)) or (is_signed and name == "0") for name in names]
    )
    if known.any() and np.any((known == 0) & ~resting):
        shown = ", ".join(shorten(str(label), 20) for label in labels[:6])
        hint = 'use "pull", "release" and "rest", or two other names'
        raise InputError(
            f"directions are named in two ways: {shown}", where=readings.source, hint=hint
        )
    return known[code], resting[code]


def _tidy(label: str) -> str:
    text = re.sub(r"^case[\s_]*(?=.)", "", label.casefold().strip(' *:"'))
    if re.fullmatch(r"[+-]?[012](\.0*)?", text):
        return str(int(float(text)))
    return re.sub(r"[\s_-]+", " ", text).strip()


def _moving(readings: Readings) -> Integers:
    """+1, -1 or 0 (at rest) by a column of position or speed."""
    position = readings.rows["position"].to_numpy()
    known = np.isfinite(position)
    if not known.any() or np.ptp(position[known]) == 0.0:
        problem = f'"{shorten(readings.position_name, 30)}" never moves'
        raise InputError(
            problem,
            where=readings.source,
            hint="name the column of the motor's position: --position",
        )
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


def stated_sides(
    readings: Readings, way: Integers, log_ratio: Floats, good: Mask
) -> Integers | None:
    """Per good row: +1 if the file says that cell 1 / cell 2 is at its upper limit, -1 at its lower, 0 at rest.

    `way` is that of the motor in all rows, `log_ratio` that of the good ones. None if the file says nothing.
    """
    if "position" in readings.rows:
        way, (middle, half) = way[good], levels_of(log_ratio)
        counted = (np.abs(log_ratio - middle) > 0.5 * half) & (way != 0)
        agree = (
            float(np.mean((way * np.sign(log_ratio - middle))[counted])) if counted.any() else 0.0
        )
        if abs(agree) < 0.2 and len(np.unique(way)) > 1:
            problem = f'"{shorten(readings.position_name, 30)}" turns at other times than the force ratio does'
            raise InputError(
                problem,
                where=readings.source,
                hint="is it the motor's position, and of the same clock?",
            )
        return way if agree >= 0.0 else -way
    if "direction" not in readings.rows:
        return None
    code = readings.codes("direction")[1]
    names = np.unique(code[good])
    if len(names) == 1 and len(code) >= _MANY:
        return None
    mean = (np.bincount(code[good], log_ratio) / np.maximum(np.bincount(code[good]), 1))[code[good]]
    return np.where(mean > ((mean.max() + mean.min()) / 2.0 if len(names) == 2 else 0.0), 1, -1)


def levels_of(log_ratio: Floats) -> tuple[float, float]:
    """Middle and half distance, by the outer fifths of the two sides in turn: more than half of a stroke may stick."""
    sample = log_ratio[:: max(1, len(log_ratio) // 100_000)]
    middle, half = float(np.mean(np.quantile(sample, (0.02, 0.98)))), 0.0
    for _ in range(20):
        above, below = sample[sample > middle], sample[sample <= middle]
        if not len(above) or not len(below):
            return middle, 0.0
        upper, lower = float(np.quantile(above, 0.8)), float(np.quantile(below, 0.2))
        half, before, middle = (upper - lower) / 2.0, middle, (upper + lower) / 2.0
        if middle == before:
            break
    return middle, half


def usual_run(side: Integers) -> int:
    """How many rows a run has at least that nine of ten rows belong to."""
    edges = np.flatnonzero(np.diff(side)) + 1
    rows = np.diff(np.concatenate([[0], edges, [len(side)]]))
    return int(np.quantile(np.repeat(rows, rows), 0.1, method="lower")) if len(side) else 0


def triggered_sides(log_ratio: Floats, middle: float, half: float, noise: float) -> Integers:
    """+1 and -1 by a trigger about the middle, so that noise does not turn a stroke."""
    height = (log_ratio - middle) / half
    sides = _triggered(height)
    width = int(np.clip((noise / (0.1 * half)) ** 2, 1, min(15, max(usual_run(sides), 1))))
    if width == 1:
        return sides
    padded = np.pad(height, (width // 2, width - 1 - width // 2), mode="edge")
    return _triggered(np.convolve(padded, np.full(width, 1.0 / width), mode="valid"))


def _triggered(height: Floats) -> Integers:
    """The side on which each row last was beyond the trigger; the first rows are on that of those after them."""
    beyond = np.where(height > _TRIGGER, 1, np.where(height < -_TRIGGER, -1, 0))
    last = np.maximum.accumulate(np.where(beyond != 0, np.arange(len(beyond)), -1))
    return np.asarray(beyond[np.maximum(last, int(np.argmax(beyond != 0)))], dtype=np.int64)


def sides_by_sign(readings: Readings, log_ratio: Floats) -> Integers:
    """Directions of a short table by the forces: the motor's cell reads more when it pulls."""
    ordered = np.sort(log_ratio)
    gap, whole = float(np.max(np.diff(ordered), initial=0.0)), float(np.ptp(ordered))
    apart = gap > 3.0 * (whole - gap) and gap > 0.1 * float(np.mean(np.abs(ordered)))
    if len(ordered) > 2 and apart and (ordered[0] > 0.0 or ordered[-1] < 0.0):
        problem = "the readings form two groups on the same side of ratio 1, so the forces do not show the direction"
        hint = 'add a column "direction" with "pull" and "release"'
        raise InputError(problem, where=readings.source, hint=hint)
    return np.sign(log_ratio).astype(np.int64)


def motor_cell(
    readings: Readings,
    first: str,
    way: Integers,
    sides: Integers,
    cells: tuple[Floats, Floats],
    *,
    is_stated: bool,
) -> tuple[str, list[str], list[str]]:
    """Which cell is the motor's, "1" or "2", with notes and warnings; `way` is 0 where no name says it.

    It is as stated, by the headers, by named directions, or by the steadier force; `first` is taken to be it.
    """
    other = "2" if first == "1" else "1"
    agree = 0 if "position" in readings.rows else int(np.sum(way * sides))
    if agree < 0 and (is_stated or readings.motor):
        problem = (
            f"friction would help the motion: cell {first}, at the motor, reads less where it pulls"
        )
        hint = f"if cell {other} is at the motor, say --motor {other}; else check the column of directions"
        raise InputError(problem, where=readings.source, hint=hint)
    if agree < 0:
        return other, [], []
    if is_stated or (agree > 0 and not readings.motor):
        return first, [], []
    changes = [0.0, 0.0]
    if np.any(sides > 0) and np.any(sides < 0):
        changes = [
            abs(float(np.mean(log[sides > 0]) - np.mean(log[sides < 0])))
            for log in map(np.log, cells)
        ]
    if readings.motor:
        header = f'"{shorten(readings.names[int(first) - 1], 30)}"'
        warning = f"{header} hardly changes between the directions, the other does: are the headers swapped?"
        return first, [], [warning] * (changes[0] < _STILL * max(changes))
    for number, (change, others) in ((first, changes), (other, changes[::-1])):
        if change > _STEADIER * others:
            return (
                number,
                [f"cell {number} is taken as the motor's: it changes more between the directions"],
                [],
            )
    return (
        "1",
        ["cell 1 is taken as the motor's, since nothing says which is; --motor 2 says otherwise"],
        [],
    )
