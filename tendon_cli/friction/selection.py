"""Which readings say something about μ: rows that can be readings, and of these the ones that slip."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.friction.directions import meanings, named_sides, sides_by_sign
from tendon_cli.friction.reading.readings import Floats, Integers, Readings
from tendon_cli.friction.resolution import resolution_of
from tendon_cli.friction.result import FittedRows
from tendon_cli.friction.slip import INSIDE, PARTIAL, STICKING, Slip, separate

AT_REST = "at rest, says the column of directions"
NOT_POSITIVE = "force at or below zero"
NO_READING = "no reading"
SATURATED = "saturated (a cell stands at its largest reading)"

UNLOADED = "no load (below 3 % of the usual force)"

_NO_ROW = {AT_REST, NOT_POSITIVE, NO_READING, SATURATED, UNLOADED}
_UNLOADED = 0.03
_STANDS = 4
_FEWEST_ELSEWHERE = 10
_FAR_INSIDE = 0.1
_MOVING = 0.03
_LEAST_SHARE = 0.1
_NOTHING = 1e-9
"""Of the usual force of a cell: what is below it is nothing."""
_FEWEST_IN_LOG = 60


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
    is_log: bool
    """Whether the rows are those of a logger, of which some stick."""


def select(readings: Readings) -> Selection:
    """The slipping rows of a file and their strokes; refuses a file in which too little slips."""
    labels, meaning = meanings(readings)
    reasons = _unusable(readings, meaning)
    good = reasons == ""
    if not np.any(good):
        raise InputError("no row has two forces above zero", where=readings.source, hint="check the sign of the cells")
    log_ratio: Floats = np.zeros(len(good))
    log_ratio[good] = np.log(readings.cell_1[good] / readings.cell_2[good])
    named = named_sides(readings, labels, meaning, log_ratio, good)
    steps = [resolution_of(cell[good]) / float(np.median(cell[good])) for cell in (readings.cell_1, readings.cell_2)]
    step = float(np.hypot(steps[0], steps[1]))
    border = _borders(readings, labels if named is not None else [])
    run = np.full(len(good), -1, dtype=np.int64)
    side = np.zeros(len(good), dtype=np.int64)
    moving: list[float] = []
    for rows in _blocks(readings, good):
        cells = readings.cell_1[rows], readings.cell_2[rows]
        known = named
        if known is None and len(rows) < _FEWEST_IN_LOG:
            known = sides_by_sign(readings, log_ratio, rows)
        found = separate(log_ratio[rows], cells, None if known is None else known[rows], border[rows], step)
        if found.one_sided and known is None:
            raise InputError(
                "the log does not go back and forth between two limits, so its directions cannot be told from the"
                " forces",
                where=f"{readings.source}, lines {readings.lines[rows[0]]} to {readings.lines[rows[-1]]}",
                hint='log at least two strokes each way, or add a column "direction" with "up" and "down"',
            )
        _check_swapped(readings, rows, known, found, border)
        run[rows] = np.where(found.run >= 0, found.run + run.max() + 1, -1)
        side[rows] = found.side
        reasons[rows] = found.reasons
        moving.append(found.moving)
    is_log = bool(np.isin(reasons, [STICKING, PARTIAL]).any()) or (readings.timed and len(good) >= _FEWEST_IN_LOG)
    _check_slip(readings, reasons, moving, is_log)
    return Selection(_strokes(readings, run, side), side, meaning, tuple(reasons), is_log)


def _check_swapped(readings: Readings, rows: Integers, named: Integers | None, found: Slip, border: Integers) -> None:
    """Refuse a short table in which a row lies on the other limit than its direction says, after others that do not."""
    if named is None or len(readings.lines) >= _FEWEST_IN_LOG:
        return
    for way in (1, -1):
        mine = named[rows] == way
        if np.any(mine) and np.mean(found.against[mine]) >= 0.5:
            raise InputError(
                "friction would help the motion: most readings of one direction look like those of the other",
                where=readings.place(int(rows[mine][0])),
                hint="check the column of directions",
            )
    for at in np.flatnonzero(found.against):
        if at > 0 and border[rows[at]] == border[rows[at - 1]] and found.run[at - 1] >= 0:
            raise InputError(
                "friction would help the motion in this reading, against the others",
                where=readings.place(int(rows[at])),
                hint="are its two forces, or its direction, swapped?",
            )


def drop_inside(chosen: Selection, rows: FittedRows, friction: float) -> Selection:
    """Set aside stretches inside both limits, such as a pause of the motor; the same selection if there are none."""
    from scipy.ndimage import median_filter

    used = np.flatnonzero(chosen.stroke >= 0)
    inward = -rows.residual[used] * rows.way[used]
    noise = 1.4826 * float(np.median(np.abs(inward - np.median(inward))))
    width = 5 if len(used) >= 20 * int(chosen.stroke.max() + 1) else 1
    smooth = median_filter(inward, size=width, mode="nearest") if width > 1 else inward
    limit = np.maximum(_FAR_INSIDE * abs(friction) * rows.bend_angle[used], (6.0 if width == 1 else 4.0) * noise)
    away = used[smooth > limit]
    if not len(away):
        return chosen
    stroke, reasons = chosen.stroke.copy(), list(chosen.reasons)
    stroke[away] = -1
    for row in away:
        reasons[row] = INSIDE
    _, stroke[stroke >= 0] = np.unique(stroke[stroke >= 0], return_inverse=True)
    return replace(chosen, stroke=stroke, side=np.where(stroke >= 0, chosen.side, 0), reasons=tuple(reasons))


def _unusable(readings: Readings, meaning: list[int | None]) -> npt.NDArray[np.object_]:
    """Why a row cannot be a reading of a loaded tendon that moves, "" for one that may be."""
    cells = np.stack([readings.cell_1, readings.cell_2])
    reasons = np.full(cells.shape[1], "", dtype=object)
    if meaning:
        reasons[np.array([known == 0 for known in meaning])] = AT_REST
    for cell in cells:
        reasons[_saturated(cell)] = SATURATED
    usual = [float(np.quantile(cell[cell > 0.0], 0.9)) if np.any(cell > 0.0) else 0.0 for cell in cells]
    reasons[np.all(cells < _UNLOADED * np.array(usual)[:, None], axis=0)] = UNLOADED
    nothing = _NOTHING * np.array(usual).reshape(2, 1)
    reasons[np.any(cells <= nothing, axis=0)] = NOT_POSITIVE
    reasons[~np.all(np.isfinite(cells), axis=0)] = NO_READING
    return reasons


def _saturated(cell: Floats) -> npt.NDArray[np.bool_]:
    """Stretches at the largest reading, in a cell that elsewhere hardly ever reads the same twice in a row."""
    top: npt.NDArray[np.bool_] = cell == np.nanmax(cell, initial=-np.inf)
    same = np.diff(cell) == 0.0
    elsewhere = ~(top[1:] | top[:-1])
    if np.count_nonzero(elsewhere) < _FEWEST_ELSEWHERE or np.mean(same[elsewhere]) > 0.3:
        return np.zeros(len(cell), dtype=bool)
    starts = np.concatenate([[0], np.flatnonzero(~same) + 1, [len(cell)]])
    stands = np.diff(starts) >= _STANDS
    at_top = stands & top[starts[:-1]]
    # A cell without noise stands wherever the tendon sticks, at both ends of the strokes.
    if 2 * np.count_nonzero(stands & ~at_top) >= np.count_nonzero(at_top):
        return np.zeros(len(cell), dtype=bool)
    # Where it stands at all, every row at the top may be cut off.
    return top


def _borders(readings: Readings, labels: list[str]) -> Integers:
    """A number that changes from row to row where the file says that another stroke begins."""
    border = np.zeros(len(readings.lines), dtype=np.int64)
    columns: list[npt.NDArray[np.generic]] = [np.array(given) for given in (labels, readings.strokes or ()) if given]
    if readings.bend_angle is not None:
        columns.append(readings.bend_angle)
    for column in columns:
        border[1:] += np.cumsum(column[1:] != column[:-1])
    return border


def _blocks(readings: Readings, good: npt.NDArray[np.bool_]) -> list[Integers]:
    """Rows at each bend angle."""
    if readings.bend_angle is None:
        return [np.flatnonzero(good)]
    return [np.flatnonzero(good & (readings.bend_angle == angle)) for angle in np.unique(readings.bend_angle[good])]


def _check_slip(readings: Readings, reasons: npt.NDArray[np.object_], moving: list[float], is_log: bool) -> None:
    """Refuse a file whose ratio never comes to rest, or in which almost nothing slips."""
    climbs = [value for value in moving if np.isfinite(value)]
    used, possible = int(np.sum(reasons == "")), int(np.sum([reason not in _NO_ROW for reason in reasons]))
    stuck = bool(climbs) and float(np.mean(climbs)) > _MOVING
    if stuck or (is_log and used < _LEAST_SHARE * possible):
        what = "no stroke slips: the force ratio still moves where each of them ends" if stuck or not used else (
            f"only {used} of {possible} rows slip, which is too few to answer for the others")  # fmt: skip
        raise InputError(what, where=readings.source, hint="make the strokes longer, until the force ratio rests")


def _strokes(readings: Readings, run: Integers, side: Integers) -> Integers:
    """Strokes from 0, without gaps: the runs, or what a column of strokes says, apart by direction and angle."""
    used = run >= 0
    stroke = np.full(len(run), -1, dtype=np.int64)
    if readings.strokes is None:
        _, stroke[used] = np.unique(run[used], return_inverse=True)
        return stroke
    parts = [readings.strokes, side.astype(str)]
    if readings.bend_angle is not None:
        parts.append([repr(float(angle)) for angle in readings.bend_angle])
    names = np.array(["|".join(part) for part in zip(*parts, strict=True)])
    _, first, number = np.unique(names[used], return_index=True, return_inverse=True)
    stroke[used] = np.argsort(np.argsort(first))[number]
    return stroke
