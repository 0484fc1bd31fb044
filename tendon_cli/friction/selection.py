"""Which readings say something about μ: all that are settled, or the slipping ones of a raw log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.friction.directions import meanings, settled_sides
from tendon_cli.friction.reading.readings import Floats, Integers, Readings
from tendon_cli.friction.strokes import STICKING, separate

AT_REST = "at rest, says the column of directions"
NOT_POSITIVE = "force at or below zero"
NO_READING = "no reading"

_FEWEST_IN_LOG = 60
_FEWEST_UNTIMED = 500
_FEWEST_IN_BLOCK = 40


@dataclass(frozen=True, eq=False)
class Selection:
    """What became of each reading."""

    stroke: Integers
    """Number of the stroke from 0, without gaps; -1 for a reading that is set aside."""
    side: Integers
    """+1 where cell 1 / cell 2 is on its upper limit, -1 on the lower, 0 for a reading that is set aside."""
    meaning: list[int | None]
    """What the file's own name of the direction means for each reading, empty where there is none."""
    reasons: tuple[str, ...]
    """Why a reading is set aside, "" for one that is used."""


def is_raw_log(readings: Readings) -> bool:
    """Whether these are rows of a logger, of which many stick, and not readings that someone chose.

    A log is long and has a time, or is very long, or is long and leaves the direction open; and it stays at one bend
    angle for many rows. A few settled readings are never taken for a log.
    """
    count = len(readings.lines)
    if count < _FEWEST_IN_LOG or readings.strokes is not None:
        return False
    if readings.bend_angle is not None and count / len(_blocks(readings)) < _FEWEST_IN_BLOCK:
        return False
    return readings.timed or readings.directions is None or count >= _FEWEST_UNTIMED


def _blocks(readings: Readings) -> list[Integers]:
    """Rows of each stretch at one bend angle."""
    rows = np.arange(len(readings.lines))
    if readings.bend_angle is None:
        return [rows]
    return np.split(rows, np.flatnonzero(np.diff(readings.bend_angle)) + 1)


def select_settled(readings: Readings) -> Selection:
    """Every reading, but those that the file says are at rest; each is a stroke unless a column says otherwise."""
    side, meaning = settled_sides(readings, np.log(readings.cell_1 / readings.cell_2))
    used = side != 0
    if readings.strokes is None:
        names = np.arange(len(side)).astype(str)
    else:
        parts = [list(readings.strokes), [str(way) for way in side]]
        if readings.bend_angle is not None:
            parts.append([repr(float(angle)) for angle in readings.bend_angle])
        names = np.array(["|".join(part) for part in zip(*parts, strict=True)])
    stroke = np.full(len(side), -1, dtype=np.int64)
    _, stroke[used] = np.unique(names[used], return_inverse=True)
    return Selection(stroke, side, meaning, tuple("" if take else AT_REST for take in used))


def select_log(readings: Readings) -> Selection:
    """The slipping rows of a raw log, block by block of equal bend angle."""
    _, meaning = meanings(readings)
    count = len(readings.lines)
    reasons = np.full(count, "", dtype=object)
    missing = ~(np.isfinite(readings.cell_1) & np.isfinite(readings.cell_2))
    reasons[missing] = NO_READING
    with np.errstate(invalid="ignore"):
        reasons[~missing & ((readings.cell_1 <= 0.0) | (readings.cell_2 <= 0.0))] = NOT_POSITIVE
    if meaning:
        reasons[(reasons == "") & np.array([known == 0 for known in meaning])] = AT_REST
    if not np.any(reasons == ""):
        raise InputError("no row has two forces above zero", where=readings.source, hint="check the sign of the cells")
    stroke = np.full(count, -1, dtype=np.int64)
    side = np.zeros(count, dtype=np.int64)
    for block in _blocks(readings):
        rows = block[reasons[block] == ""]
        if len(rows) >= _FEWEST_IN_BLOCK // 2:
            _select_block(readings, rows, stroke, side, reasons)
    reasons[(stroke < 0) & (reasons == "")] = "too few rows at this bend angle"
    _drop_contradicted(stroke, side, meaning, reasons)
    _, stroke[stroke >= 0] = np.unique(stroke[stroke >= 0], return_inverse=True)
    side[stroke < 0] = 0
    return Selection(stroke, side, meaning, tuple(reasons))


def _select_block(
    readings: Readings,
    rows: Integers,
    stroke: Integers,
    side: Integers,
    reasons: np.ndarray[tuple[int], np.dtype[np.object_]],
) -> None:
    """Fill in stroke, side and reasons for the rows of one bend angle."""
    log_ratio: Floats = np.log(readings.cell_1[rows] / readings.cell_2[rows])
    found = separate(log_ratio)
    if found.one_sided and readings.directions is None:
        raise InputError(
            "the log does not go back and forth between two limits, so its directions cannot be told from the forces",
            where=f"{readings.source}, lines {readings.lines[rows[0]]} to {readings.lines[rows[-1]]}",
            hint='log at least two strokes each way, or add a column "direction" with "up" and "down"',
        )
    stroke[rows] = np.where(found.stroke >= 0, found.stroke + stroke.max() + 1, -1)
    side[rows] = found.side
    reasons[rows] = found.reasons


def _drop_contradicted(
    stroke: Integers,
    side: Integers,
    meaning: list[int | None],
    reasons: np.ndarray[tuple[int], np.dtype[np.object_]],
) -> None:
    """Set aside rows whose named direction has turned while the forces are still on the old limit."""
    if not meaning:
        return
    meant = np.array([known or 0 for known in meaning], dtype=np.int64)
    agree = int(np.sign(np.sum((meant * side)[stroke >= 0])))
    if agree:
        turned = (stroke >= 0) & (meant * side * agree < 0)
        reasons[turned] = STICKING
        stroke[turned] = -1
