"""What a log says beside its coefficient: stroke by stroke, against speed, by file, and before it slides."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.files import write_whole
from tendon_cli.friction.reading.readings import Floats, Integers
from tendon_cli.friction.rows import REASONS, FittedRows

_SPEEDS = 0.2
"""Largest speed over the least, less 1, from which strokes say anything about it."""
_FEWEST = 6
"""Strokes from which a slope over them, or a difference between files, is more than one odd stroke."""
_EXACT = 0.002
"""Of μ: no rig's strokes agree more closely."""
_BY_CHANCE, _MATTERS = 0.003, 0.02
"""Files differ if chance would make it so in three of a thousand sets, and by more than 2 %."""
_STICK = (0.05, 0.35)
"""Part of the way from limit to limit in which the motor's force over its position is still nearly straight."""
MARK = "# strokes of a log, by tendon fit-friction"


@dataclass(frozen=True)
class StrokeRow:
    """One stroke; forces in the unit of the file."""

    stroke: int
    file: str
    direction: str
    first_line: int
    last_line: int
    bend_angle: float | None
    rows: int
    used: int
    force_motor: float
    force_load: float
    log_ratio: float
    friction: float | None
    """Of this stroke, gain and effects of the rig taken off; None if it is not used."""
    speed: float | None
    """Of the motor, in the unit of its column, per unit of time; None without a position."""
    why_not: str


@dataclass(frozen=True)
class Speed:
    """How μ goes with the motor's speed."""

    power: float
    """μ goes with the speed to this power."""
    standard_error: float
    slowest: float
    fastest: float


@dataclass(frozen=True)
class Presliding:
    """What the motor does before the tendon slides: medians over the reversals."""

    stiffness: float
    """Force at the motor per unit of its position."""
    backlash: float
    """Travel after a reversal before the force follows, in the unit of the position."""
    reversals: int


def strokes_of(
    rows: FittedRows, friction: float, given: bool, files: tuple[str, ...], file: Integers | None
) -> tuple[StrokeRow, ...]:
    """Every stroke of a log, used or not."""
    speed, on_limit = _speeds(rows), rows.used
    order = np.argsort(rows.run, kind="stable")
    borders = np.searchsorted(rows.run[order], np.arange(int(rows.run.max()) + 2))
    found = []
    for number in range(len(borders) - 1):
        mine = order[borders[number] : borders[number + 1]]
        used = mine[on_limit[mine]]
        on = used if len(used) else mine
        bend = float(rows.bend_angle[mine[0]])
        own = None
        if len(used) and bend > 0.0:
            own = friction + float(np.mean(rows.way[used] * rows.residual[used])) / bend
        codes = rows.codes[mine]
        why = "" if len(used) else REASONS[int(np.bincount(codes).argmax())]
        found.append(
            StrokeRow(
                number + 1, files[int(file[mine[0]])] if file is not None else files[0],
                "toward motor" if rows.way[mine[0]] > 0 else "toward load", int(rows.line[mine[0]]),
                int(rows.line[mine[-1]]), bend if given else None, len(mine), len(used), float(np.mean(rows.motor[on])),
                float(np.mean(rows.load[on])), float(np.mean(rows.log_ratio[on])), own,
                None if speed is None else float(np.mean(np.abs(speed[on]))), why,
            )
        )  # fmt: skip
    return tuple(found)


def _speeds(rows: FittedRows) -> Floats | None:
    """Speed of the motor in each row; per row if there is no time."""
    if rows.position is None:
        return None
    if rows.position_is_speed:
        return rows.position
    time = np.arange(len(rows.position), dtype=np.float64) if rows.time is None else rows.time
    moved, passed = np.gradient(rows.position), np.gradient(time)
    return np.asarray(np.divide(moved, passed, out=np.zeros(len(moved)), where=passed > 0.0))


def speed_of(strokes: tuple[StrokeRow, ...]) -> Speed | None:
    """μ against speed, if the strokes have different speeds."""
    used = [(each.speed, each.friction) for each in strokes if each.friction and each.friction > 0.0 and each.speed]
    if len(used) < _FEWEST:
        return None
    speed, friction = (np.log(np.array(column, dtype=np.float64)) for column in zip(*used, strict=True))
    if float(np.ptp(speed)) < math.log1p(_SPEEDS):
        return None
    line, covariance = np.polyfit(speed, friction, 1, cov=True)
    return Speed(
        float(line[0]), float(np.sqrt(covariance[0, 0])), float(np.exp(speed.min())), float(np.exp(speed.max()))
    )


def presliding_of(rows: FittedRows) -> Presliding | None:
    """Stiffness and backlash after the reversals, by the straight part of the motor's force over its position."""
    if rows.position is None or rows.position_is_speed:
        return None
    slopes, lost = [], []
    kept = np.flatnonzero(rows.used)
    for at in np.flatnonzero(np.diff(rows.way[kept]) != 0):
        first, end = int(kept[at]), int(kept[at + 1])
        force, x = rows.motor[first : end + 1], rows.position[first : end + 1]
        share = (force - force[0]) / (force[-1] - force[0]) if force[-1] != force[0] else np.zeros(len(force))
        straight = (share > _STICK[0]) & (share < _STICK[1])
        if np.count_nonzero(straight) < 3 or np.ptp(x[straight]) == 0.0:
            continue
        slope, height = np.polyfit(x[straight], force[straight], 1)
        turn = x[np.argmax(np.abs(x - x[-1]))]
        slopes.append(float(slope))
        lost.append(abs(float((force[0] - height) / slope - turn)))
    if not slopes:
        return None
    return Presliding(abs(float(np.median(slopes))), float(np.median(lost)), len(slopes))


def by_file(strokes: tuple[StrokeRow, ...], files: tuple[str, ...]) -> tuple[dict[str, Any], ...]:
    """μ of each file's strokes and its standard error: the mean of both directions, in which a file's gain cancels."""
    found = []
    for name in files:
        own = [(each.direction, each.friction) for each in strokes if each.file == name and each.friction is not None]
        names = sorted({direction for direction, _ in own})
        ways = [np.array([friction for direction, friction in own if direction == each]) for each in names]
        many = min((len(way) for way in ways), default=0)
        error = math.sqrt(sum(float(np.var(way, ddof=1)) / len(way) for way in ways)) / len(ways) if many > 1 else None
        mean = float(np.mean([way.mean() for way in ways])) if ways else None
        found.append({"file": name, "friction": mean, "standard_error": error, "strokes": sum(map(len, ways))})
    return tuple(found)


def disagreement(files: tuple[dict[str, Any], ...]) -> str | None:
    """What to say if the files do not agree: their scatter about the mean against their errors (chi-square)."""
    from scipy.special import chdtrc

    told = [(each["friction"], each["standard_error"]) for each in files if each["standard_error"] is not None]
    if len(told) < 2:
        return None
    value, error = (np.array(column, dtype=np.float64) for column in zip(*told, strict=True))
    weight = 1.0 / np.maximum(error, _EXACT * np.abs(value)) ** 2
    mean = float(weight @ value / weight.sum())
    chance = float(chdtrc(len(value) - 1, weight @ (value - mean) ** 2))
    if chance >= _BY_CHANCE or np.ptp(value) <= _MATTERS * abs(mean):
        return None
    shown = ", ".join(f"{each:.4g}" for each in value[:6])
    return f"the files do not agree, they give {shown}: one number does not hold for all; fit them one by one"


def write_strokes(strokes: tuple[StrokeRow, ...], path: Path) -> None:
    """Write the table of strokes as CSV; raises OutputError."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    text.write(f"{MARK}\n")
    writer.writerow([field.name for field in fields(StrokeRow)])
    for each in strokes:
        writer.writerow(["" if value is None else value for value in asdict(each).values()])
    write_whole(path, text.getvalue().encode())
