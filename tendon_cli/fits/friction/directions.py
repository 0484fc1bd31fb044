"""Direction of the tendon in each reading, and the cell at the motor."""

from __future__ import annotations

import re

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.fits.friction.readings import Readings
from tendon_cli.fits.log_rows import Floats, Integers, Mask, noise_of
from tendon_cli.readers.file_text import raise_all
from tendon_cli.units import shorten

_PULLED = re.compile(
    r"up(wards?)?|rais(e|ing)|rising|lift(ing)?|pull(ing|ed)?|(towards?|to) motor|loading|winding"
    r"|reel(ing)? in|weight is moving in upward direction|auf|hoch|heben|ziehen"
)
_RELEASED = re.compile(
    r"down(wards?)?|lower(ing)?|falling|releas(e|ing|ed)|(towards?|to) load|towards? elbow"
    r"|unloading|unwinding|pay(ing)? out|reel(ing)? out|let(ting)? (go|out)"
    r"|weight is moving in downward direction|ab|runter|senken|nachlassen"
)
_RESTING = re.compile(r"(at )?rest|stop(ped)?|hold(ing)?|idle|paused?|still|none")
_MANY = 40
"""Number of rows from which one direction for all of them says nothing: it names the log."""
_TRIGGER = 0.3
"""Distance past the middle, over the half distance, at which the ratio turns a stroke. Noise below
a tenth of it never does."""
_STILL = 0.3
"""Change of a cell's force between the directions, over the larger change, under which the cell is
hardly the motor's."""
_CHANGES_MORE = 2.0
"""Change of a cell's force between the directions, over the other's, from which the cell is the
motor's."""
_SLOW = 0.05
"""Speed over the usual speed under which the motor rests. Creep after a stop is slower, a crank
passes its turn within few rows."""


def stated_motion(readings: Readings) -> tuple[Integers, Mask]:
    """Return the direction of the motor that the file states in each row, and where it rests.

    The file states it by a column of position or speed, or else by a column of names. Directions
    are +1 and -1, and 0 at rest or if a name does not tell; rests are True.
    """
    if "position" in readings.rows:
        way = _way_by_position(readings)
        return way, way == 0
    if "direction" not in readings.rows:
        total = len(readings.rows)
        return np.zeros(total, dtype=np.int64), np.zeros(total, dtype=bool)
    labels, code = readings.codes("direction")
    names = [_tidy(str(label)) for label in labels]
    if "" in names:
        rows = np.flatnonzero(code == names.index("")).tolist()
        raise_all(
            [InputError("the direction is missing", where=readings.place(row)) for row in rows],
            readings.source,
        )
    # 0 with 1 and -1 is a motor at rest; 0 and 1 alone are two names.
    is_signed = len(set(names) - {"0"}) >= 2
    way_of_name = np.array([_way_of(name) for name in names], dtype=np.int64)
    rest_of_name = np.array(
        [bool(_RESTING.fullmatch(name)) or (is_signed and name == "0") for name in names]
    )
    if way_of_name.any() and np.any((way_of_name == 0) & ~rest_of_name):
        raise _mixed_names(readings.source, labels, way_of_name, rest_of_name)
    return way_of_name[code], rest_of_name[code]


def unread_direction(readings: Readings) -> str:
    """Return the header of a column that is not read, though a word in it is a direction's."""
    header, *words = readings.unread_names or ("",)
    names = [_tidy(word) for word in words]
    is_direction = any(_way_of(name) or _RESTING.fullmatch(name) for name in names)
    return header if is_direction else ""


def _mixed_names(source: str, labels: list[str], way: Integers, rest: Mask) -> InputError:
    """Return the error for names of which some are known and others are not.

    Args:
        source: Name of the file.
        labels: Different names, as the file has them.
        way: Direction by each name; 0 if it tells none.
        rest: True for names of a motor at rest.
    """
    shown = [shorten(str(label), 20) for label in labels[:6]]
    problem = f"direction names are mixed: {', '.join(shown)}"
    kinds = {1: "pull", -1: "release", 0: "rest"}
    read = []
    unknown = []
    for label, direction, is_rest in zip(shown, way.tolist(), rest.tolist(), strict=False):
        if direction or is_rest:
            read.append(f'"{label}" is read as {kinds[direction]}')
        else:
            unknown.append(f'"{label}" is unknown')
    hint = (
        f"{', '.join([*read, *unknown])}; use pull, release and rest,"
        " or two names of your own and rest"
    )
    return InputError(problem, where=source, hint=hint)


def _way_of(name: str) -> int:
    """Return the direction of the motor by its name: +1 pulled, -1 released, 0 if neither."""
    return bool(_PULLED.fullmatch(name)) - bool(_RELEASED.fullmatch(name))


def _tidy(label: str) -> str:
    """Simplify a label: no capitals, no "case" before it, no quotes, single blanks, 1 for 1.0."""
    text = re.sub(r"^case[\s_]*(?=.)", "", label.casefold().strip(' *:"'))
    if re.fullmatch(r"[+-]?[012](\.0*)?", text):
        return str(int(float(text)))
    return re.sub(r"[\s_-]+", " ", text).strip()


def _way_by_position(readings: Readings) -> Integers:
    """Return the direction of the motor by its position or speed: +1, -1, or 0 at rest."""
    position = readings.rows["position"].to_numpy()
    known = np.isfinite(position)
    if not known.any() or np.ptp(position[known]) == 0.0:
        raise InputError(
            f'"{shorten(readings.position_name, 30)}" never moves',
            where=readings.source,
            hint="name the column of the motor's position: --position",
        )
    rows = np.arange(len(position))
    filled = np.interp(rows, rows[known], position[known])
    noise = noise_of(filled)
    speed = filled
    width = 1
    while not readings.position_is_speed:  # wide enough for the noise and the steps of an encoder
        after = filled[np.minimum(rows + width, len(filled) - 1)]
        before = filled[np.maximum(rows - width, 0)]
        speed = after - before
        if width >= 16 or np.quantile(np.abs(speed), 0.9) >= 10.0 * noise:
            break
        width *= 2
    usual = np.quantile(np.abs(speed), 0.9)
    least = max(_SLOW * usual, min(3.0 * noise, 0.5 * usual))
    return np.where(np.abs(speed) > least, np.sign(speed), 0.0).astype(np.int64)


def stated_sides(
    readings: Readings, way: Integers, log_ratio: Floats, good: Mask
) -> Integers | None:
    """Return the limit that each good row belongs to, by the file.

    Args:
        readings: All readings.
        way: Direction of the motor in all rows.
        log_ratio: Log ratio of the good rows.
        good: True in the rows that can be readings.

    Returns:
        +1 if the file says that cell 1 / cell 2 is at its upper limit, -1 at its lower, 0 at rest;
        None if the file says nothing.
    """
    if "position" in readings.rows:
        return _sides_by_position(readings, way[good], log_ratio)
    if "direction" not in readings.rows:
        return None
    code = readings.codes("direction")[1]
    total = len(code)
    code = code[good]
    names = np.unique(code)
    if len(names) == 1 and total >= _MANY:
        return None
    count = np.maximum(np.bincount(code), 1)
    mean = (np.bincount(code, log_ratio) / count)[code]
    middle = 0.0
    if len(names) == 2:
        middle = (mean.max() + mean.min()) / 2.0
    return np.where(mean > middle, 1, -1)


def _sides_by_position(readings: Readings, way: Integers, log_ratio: Floats) -> Integers:
    """Return the direction of the motor, reversed if the ratio is low while the position rises."""
    middle, half = levels_of(log_ratio)
    away = log_ratio - middle
    counted = (np.abs(away) > 0.5 * half) & (way != 0)
    agreement = 0.0
    if counted.any():
        agreement = np.mean((way * np.sign(away))[counted])
    if abs(agreement) < 0.2 and len(np.unique(way)) > 1:
        name = shorten(readings.position_name, 30)
        raise InputError(
            f'"{name}" reverses at other times than the force ratio',
            where=readings.source,
            hint="is it the position of the motor, recorded by the same clock?",
        )
    return way if agreement >= 0.0 else -way


def levels_of(log_ratio: Floats) -> tuple[float, float]:
    """Return the middle and half distance of the two limits.

    A limit is where the outermost fifth of the values on its side of the middle begins, since more
    than half of a stroke may stick; middle and limits are found in turn.
    """
    sample = log_ratio[:: max(1, len(log_ratio) // 100_000)]
    middle = float(np.mean(np.quantile(sample, (0.02, 0.98))))
    half = 0.0
    for _ in range(20):
        above = sample[sample > middle]
        below = sample[sample <= middle]
        if not len(above) or not len(below):
            return middle, 0.0
        upper = np.quantile(above, 0.8)
        lower = np.quantile(below, 0.2)
        half = (upper - lower) / 2.0
        before = middle
        middle = (upper + lower) / 2.0
        if middle == before:
            break
    return middle, half


def usual_run(side: Integers) -> int:
    """Return the largest length such that nine of ten rows are in runs at least as long."""
    if not len(side):
        return 0
    edges = np.flatnonzero(np.diff(side)) + 1
    lengths = np.diff(np.concatenate([[0], edges, [len(side)]]))
    return int(np.quantile(np.repeat(lengths, lengths), 0.1, method="lower"))


def triggered_sides(log_ratio: Floats, middle: float, half: float, noise: float) -> Integers:
    """Return +1 and -1 by a trigger about the middle, so that noise does not turn a stroke."""
    height = (log_ratio - middle) / half
    sides = _triggered(height)
    longest = min(15, max(usual_run(sides), 1))
    width = int(np.clip((noise / (0.1 * half)) ** 2, 1, longest))
    if width == 1:
        return sides
    padded = np.pad(height, (width // 2, width - 1 - width // 2), mode="edge")
    return _triggered(np.convolve(padded, np.full(width, 1.0 / width), mode="valid"))


def _triggered(height: Floats) -> Integers:
    """Return the side on which the ratio was last beyond the trigger, per row.

    Rows before the first that is beyond it are on its side.
    """
    beyond = np.where(height > _TRIGGER, 1, np.where(height < -_TRIGGER, -1, 0))
    last = np.maximum.accumulate(np.where(beyond != 0, np.arange(len(beyond)), -1))
    first = int(np.argmax(beyond != 0))
    return np.asarray(beyond[np.maximum(last, first)], dtype=np.int64)


def sides_by_sign(readings: Readings, log_ratio: Floats) -> Integers:
    """Return the limits of a short table by the sign of the log ratio, +1 and -1."""
    ordered = np.sort(log_ratio)
    gap = np.max(np.diff(ordered), initial=0.0)
    span = np.ptp(ordered)
    is_wide = gap > 3.0 * (span - gap) and gap > 0.1 * np.mean(np.abs(ordered))
    if len(ordered) > 2 and is_wide and (ordered[0] > 0.0 or ordered[-1] < 0.0):
        raise InputError(
            "the readings form two groups on the same side of ratio 1,"
            " so the forces do not show the direction",
            where=readings.source,
            hint='add a column "direction" with "pull" and "release"',
        )
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
    """Find the cell at the motor: as stated, by headers, by directions, or by the forces.

    By the forces it is the cell that changes more between the directions.

    Args:
        readings: All readings.
        first: "1" or "2", the cell that is assumed to be at the motor.
        way: Direction of the motor in each good row; 0 if no name tells it.
        sides: Limit that each of these rows belongs to.
        cells: Forces in these rows, those of cell `first` before those of the other.
        is_stated: True if the user says that `first` is at the motor.

    Returns:
        "1" or "2", notes, and warnings.
    """
    other = "2" if first == "1" else "1"
    agreement = 0 if "position" in readings.rows else int(np.sum(way * sides))
    if agreement < 0:
        if not is_stated and not readings.motor:
            return other, [], []
        raise InputError(
            f"friction would help the motion: cell {first}, at the motor, reads less"
            " while it pulls",
            where=readings.source,
            hint=f"if cell {other} is at the motor, give --motor {other};"
            " if not, check the column of directions",
        )
    if is_stated or (agreement > 0 and not readings.motor):
        return first, [], []
    changes = [0.0, 0.0]
    if np.any(sides > 0) and np.any(sides < 0):
        changes = [
            abs(float(np.mean(np.log(cell[sides > 0])) - np.mean(np.log(cell[sides < 0]))))
            for cell in cells
        ]
    if readings.motor:
        if changes[0] >= _STILL * max(changes):
            return first, [], []
        header = shorten(readings.names[int(first) - 1], 30)
        warning = (
            f'"{header}" hardly changes between the directions, but the other does:'
            " are the headers swapped?"
        )
        return first, [], [warning]
    for cell, change, change_of_other in (
        (first, changes[0], changes[1]),
        (other, changes[1], changes[0]),
    ):
        if change > _CHANGES_MORE * change_of_other:
            note = f"cell {cell} is taken as the motor's: it changes more between the directions"
            return cell, [note], []
    note = "cell 1 is taken as the motor's, because nothing says which is; --motor 2 changes this"
    return "1", [note], []
