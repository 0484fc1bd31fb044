"""Noise and resolution of the cells, rows set aside before the fit, and the log of usable rows."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.fits.log_rows import (
    SAME_READING,
    Floats,
    Integers,
    LogRows,
    Mask,
    means_by,
    noise_of,
    spikes,
)
from tendon_cli.model.design import map_arrays

REASONS = (
    "",
    "no reading",
    "force at or below zero",
    "no load (below 3 % of the usual force)",
    "saturated (a cell is at its largest reading)",
    "spike (far from its neighbours)",
    "at rest (by the column of direction or position)",
    "inside the limits (sticking after a reversal, or a pause)",
    "in a stroke that does not reach the limit",
)
"""Why a row is set aside, by its code."""
USED, NO_READING, NOT_POSITIVE, UNLOADED, SATURATED, SPIKE, AT_REST, INSIDE, PARTIAL = range(9)
"""Codes of the reasons, in their order."""

_UNLOADED = 0.03
"""Share of a cell's 90th percentile below which it shows its zero error more than the tendon: an
error of 1 % of full scale is 30 % of such a reading."""
_TOP_ROWS = 20
"""Least number of rows at a rail, the largest reading of a saturated cell."""
_TOP_CODES = 5.0
"""Least number of rows at a rail over the mean number at each of the five codes below it."""
_TOP_NOISE = 0.4
"""Noise over the step of a cell, under which it repeats values without any rail: one or two codes
then hold most of its rows."""
_NEAR_RAIL = 3.0
"""Standard deviations of noise below the rail, down to which a reading is a saturated one."""
_SPIKE_SHARE = 0.05
"""Share of the usual force that a spike exceeds."""
_SPIKE_STEPS = 3.0
"""Steps of the cell that a spike exceeds."""
_HUM_FROM = 0.25
"""Lowest frequency of a hum over half the rate of the readings: strokes are slower."""
_HUM_WIDTH = 3
"""Bins of a spectrum on either side of a hum that are taken out with it."""
_HUM_SHARE = 0.5
"""Share of the power above the lowest frequency that a hum has: noise is spread over all of it."""
_HUM_LARGEST = 0.3
"""Amplitude of a hum over the usual force from which it is no hum: a cell drops out, say."""
_HUM_ROWS = 400
"""Least number of rows that show a hum."""
_NOTHING = 1e-20
"""Force, in any unit, that no cell reads; ratios to larger ones are finite."""
LOG_ROWS = 60
"""Number of rows from which neighbours show the value of a row; shorter files are typed by hand."""
_ENOUGH_VALUES = 10
"""Number of different values from which they show the step of a cell without strokes."""
_STEPPING = 0.5
"""Share of the strokes of a log in which a cell steps, from which fewer values show its step."""
_FINEST_DECIMALS = 9
"""Largest number of decimals that is tried where no step shows."""
_SAME_BEND = 0.02
"""Share by which two readings of one bend angle may differ: nobody measures it better."""


@dataclass(frozen=True, eq=False)
class Log(LogRows):
    """Usable rows of a file, as the estimator sees them; a value per row."""

    motor: Floats
    """Force at the motor, in the unit of the file."""
    load: Floats
    """Force at the load, in the unit of the file."""
    way: Integers
    """Direction of the tendon: +1 pulled toward the motor, -1 released toward the load."""
    bend: Floats
    """Bend angle of the sheath, rad."""
    stroke: Integers
    """Number of the stroke: 0, 1, ... rising, without gaps."""
    place: Floats
    """Place in the file, from -1/2 at its start to 1/2 at its end."""
    middle: Floats
    """Middle of the two limits of the log ratio, at the bend of the row."""
    half: Floats
    """Half distance of these limits."""
    noise: Floats
    """Standard deviation of the log ratio, rounding included."""
    steps: tuple[float, float]
    """Resolutions of the motor's and of the load's cell."""
    shows_steps: bool
    """True if the readings of a cell show its resolution; else it is the last decimal written."""
    time: Floats | None
    """Time in the unit of the file; None if rows are no log in order of time."""
    settled: bool
    """True if rows are settled readings rather than a raw log."""
    mean_force: float
    """Mean of ln F at the load, at which μ holds if it depends on the force."""
    rate: Floats | None = None
    """d ln F/dt at the load."""

    @property
    def log_ratio(self) -> Floats:
        """ln(F_motor/F_load)."""
        return np.log(self.motor / self.load)

    @property
    def strokes(self) -> int:
        """Number of strokes."""
        return int(self.stroke[-1]) + 1

    @property
    def first(self) -> Integers:
        """First row of each stroke, and one past the last row."""
        return np.searchsorted(self.stroke, np.arange(self.strokes + 1))

    @property
    def duration(self) -> float:
        """Median duration of a stroke, in the unit of the time; 1 without one."""
        if self.time is None:
            return 1.0
        first = self.first
        durations = self.time[first[1:] - 1] - self.time[first[:-1]]
        return max(np.median(durations), 1e-300)

    @property
    def both_ways(self) -> bool:
        """True if both directions are read, so that gain and friction can be separated."""
        return len(np.unique(self.way[self.bend > 0.0])) == 2

    def select(self, rows: Mask | Integers | slice) -> Log:
        """Select rows, and number their strokes anew."""
        log = super().select(rows)
        return replace(log, stroke=np.unique(log.stroke, return_inverse=True)[1])

    def means(self, part: Integers) -> Log:
        """Average over the parts 0, 1, ... of strokes; noise becomes that of a mean."""
        means: Log = map_arrays(self, lambda column: means_by(part, column))
        return replace(
            means,
            noise=means.noise / np.sqrt(np.bincount(part)),
            way=np.rint(means.way).astype(np.int64),
            stroke=np.rint(means.stroke).astype(np.int64),
        )


def bend_groups(bend: Floats) -> Integers:
    """Number bend angles from 1; angles that differ only by measurement have the same number."""
    values, place = np.unique(bend, return_inverse=True)
    steps = np.diff(values, prepend=values[:1]) > _SAME_BEND * values
    return np.asarray(1 + np.cumsum(steps), dtype=np.int64)[place]


def resolutions_of(
    written: tuple[Floats, Floats], stroke: Integers
) -> tuple[tuple[float, float], bool]:
    """Return the resolutions of the motor's and of the load's cell.

    A cell that reads the same throughout most strokes shows no step. It is then taken to be as fine
    as the other cell. If that shows none either, all that is left is the last decimal that is
    written, which depends on the unit in which the codes of a converter are written.

    Args:
        written: Forces at the motor and at the load as they are written, zeros not taken off.
        stroke: Number of the stroke of each row.

    Returns:
        The resolutions, and True if a cell shows its step.
    """
    motor, load = (_step_of(cell, stroke) for cell in written)
    finest = min(motor, load)
    if not math.isfinite(finest):
        return (_last_decimal(written[0]), _last_decimal(written[1])), False
    if not math.isfinite(motor):
        motor = finest
    if not math.isfinite(load):
        load = finest
    return (motor, load), True


def _step_of(cell: Floats, stroke: Integers) -> float:
    """Return the smallest step of the readings of one cell; infinite if they show none.

    Ten different values show it. Fewer show it in a log, if the cell steps within most strokes:
    between strokes another weight may be hung on. A few readings that are typed by hand do not,
    since three that are 0.378 apart do not mean that the cell counts in steps of 0.378.
    """
    is_known = np.isfinite(cell)
    readings = cell[is_known]
    values = np.unique(readings)
    # A logger that writes binary fractions repeats a value with a last digit more or less.
    least = SAME_READING * np.max(np.abs(values), initial=0.0)
    if len(values) >= _ENOUGH_VALUES:
        steps = np.diff(values)
        return float(steps[steps > least].min(initial=math.inf))
    if len(cell) < LOG_ROWS:
        return math.inf
    strokes = stroke[is_known]
    order = np.lexsort((readings, strokes))
    steps = np.diff(readings[order])
    is_step = (np.diff(strokes[order]) == 0) & (steps > least)
    stepping = len(np.unique(strokes[order][1:][is_step]))
    if stepping < _STEPPING * len(np.unique(strokes)):
        return math.inf
    return float(steps[is_step].min(initial=math.inf))


def _last_decimal(cell: Floats) -> float:
    """Return a unit of the last decimal that is written; 0 if there are more than nine."""
    values = np.unique(cell[np.isfinite(cell)])
    largest = np.max(np.abs(values), initial=0.0)
    for decimals in range(_FINEST_DECIMALS + 1):
        if np.all(np.abs(values - np.round(values, decimals)) <= 1e-12 * largest):
            return 10.0**-decimals
    return 0.0


def unusable(
    cells: tuple[Floats, Floats], steps: tuple[float, float], rest: Mask
) -> npt.NDArray[np.int8]:
    """Find the rows that cannot be readings of a loaded tendon that moves.

    Args:
        cells: Forces at the motor and at the load, zeros taken off.
        steps: Resolutions of the cells.
        rest: True in rows in which the motor is known to rest.

    Returns:
        Code of the reason, per row; `USED` if it may be such a reading.
    """
    codes = np.where(rest, AT_REST, USED).astype(np.int8)
    usual = [_usual_force(cell) for cell in cells]
    if len(rest) >= LOG_ROWS:
        for cell, step in zip(cells, steps, strict=True):
            filled = np.nan_to_num(cell, nan=0.0, posinf=0.0, neginf=0.0)
            usual_force = np.median(np.abs(filled))
            codes[spikes(filled, max(_SPIKE_SHARE * usual_force, _SPIKE_STEPS * step))] = SPIKE
            codes[_saturated(cell, step)] = SATURATED
    # A motor that rests needs no load: its readings are those of the cells without load.
    moves = codes != AT_REST
    is_bare = (cells[0] < _UNLOADED * usual[0]) & (cells[1] < _UNLOADED * usual[1])
    codes[moves & is_bare] = UNLOADED
    for cell, force in zip(cells, usual, strict=True):
        rounding = max(1e-9 * force, _NOTHING)  # a force below rounding is none
        codes[moves & (cell <= rounding)] = NOT_POSITIVE
    codes[~(np.isfinite(cells[0]) & np.isfinite(cells[1]))] = NO_READING
    return codes


def _usual_force(cell: Floats) -> float:
    """90th percentile of the forces above zero; 0 if there are none."""
    loaded = cell[cell > 0.0]
    return np.quantile(loaded, 0.9) if len(loaded) else 0.0


def _saturated(cell: Floats, step: float) -> Mask:
    """Select the rows at a rail and next to it."""
    none = np.zeros(len(cell), dtype=bool)
    known = cell[np.isfinite(cell)]
    values, counts = np.unique(known, return_counts=True)
    noise = noise_of(known)
    if len(values) < _ENOUGH_VALUES or counts[-1] < _TOP_ROWS or noise <= _TOP_NOISE * step:
        return none
    # A cell without noise repeats its reading wherever the tendon sticks, at both ends of the
    # strokes, and not only at the top.
    starts = np.concatenate([[0], np.flatnonzero(np.diff(known) != 0.0) + 1, [len(known)]])
    rows = np.diff(starts)
    at_top = known[starts[:-1]] == values[-1]
    has_few = counts[-1] <= _TOP_CODES * counts[-6:-1].mean()
    if has_few or rows[at_top].max() < 2 * rows[~at_top].max():
        return none
    return np.asarray(cell >= values[-1] - _NEAR_RAIL * noise)


def without_hum(cell: Floats) -> tuple[Floats, float]:
    """Take a hum of one frequency out of a cell, such as that of the mains.

    Readings of 80 Hz show the 50 Hz of the mains as 30 Hz; whatever it is, strokes are slower.

    Returns:
        Forces, and the frequency of the hum in periods a row; 0 if there is none.
    """
    if len(cell) < _HUM_ROWS or not np.all(np.isfinite(cell)):
        return cell, 0.0
    spectrum = np.fft.rfft(cell)
    first = int(_HUM_FROM * len(spectrum))
    power = np.abs(spectrum) ** 2
    place = first + int(np.argmax(power[first:]))
    hum = slice(max(place - _HUM_WIDTH, first), place + _HUM_WIDTH + 1)
    amplitude = 2.0 * math.sqrt(power[hum].sum()) / len(cell)
    is_line = power[hum].sum() >= _HUM_SHARE * power[first:].sum() > 0.0
    if not is_line or amplitude > _HUM_LARGEST * np.median(np.abs(cell)):
        return cell, 0.0
    spectrum[hum] = 0.0
    return np.fft.irfft(spectrum, len(cell)), place / len(cell)


def rates_of(time: Floats, log_force: Floats, stroke: Integers, width: int) -> Floats:
    """Return d ln F/dt of each row from the means of `width` rows after and before it.

    At the ends of a stroke it is that of the nearest row that has as many on either side. The row
    itself is in neither mean: its noise would pass for a delay.
    """
    first = np.searchsorted(stroke, stroke, "left")
    last = np.searchsorted(stroke, stroke, "right")
    reach = np.minimum(width, (last - first - 1) // 2)
    centre = np.clip(np.arange(len(time)), first + reach, last - 1 - reach)
    force_change = _change_about(log_force - log_force.mean(), centre, reach)
    time_change = _change_about(time - time.mean(), centre, reach)
    return np.divide(force_change, time_change, out=np.zeros(len(time)), where=time_change > 0.0)


def _change_about(column: Floats, centre: Integers, reach: Integers) -> Floats:
    """Sum of the `reach` rows after each centre less the sum of those before it."""
    sums = np.concatenate([[0.0], np.cumsum(column)])
    return np.asarray(
        sums[centre + reach + 1] - sums[centre + 1] - sums[centre] + sums[centre - reach]
    )
