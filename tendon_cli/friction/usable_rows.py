"""Rows of two cells: noise, resolution, what is set aside at once, and the log of those that can be readings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.friction.reading.readings import Floats, Integers, Mask

USED, NO_READING, NOT_POSITIVE, UNLOADED, SATURATED, SPIKE, AT_REST, INSIDE, PARTIAL = range(9)
REASONS = (
    "",
    "no reading",
    "force at or below zero",
    "no load (below 3 % of the usual force)",
    "saturated (a cell stands at its largest reading)",
    "spike (far from its neighbours)",
    "at rest (by the column of direction or position)",
    "inside the limits (sticking after a reversal, or a pause)",
    "in a stroke that does not reach the limit",
)
"""Why a row is set aside, by its code."""

_UNLOADED = 0.03
"""A cell under this share of its 90th percentile weighs its own zero more than the tendon: 1 % of full scale is 30 %
there."""
_TOP_ROWS, _TOP_CODES, _TOP_NOISE = 20, 5.0, 0.4
"""A rail has at least 20 rows and five times the rows of the codes below it. A cell whose noise is under 0.4 of its
step repeats values without any rail: two codes then hold over half of its rows each."""
_NEAR_RAIL = 3.0
"""Standard deviations of noise below the rail, where readings are those that noise happened to lower."""
_SPIKE_MEDIANS, _SPIKE_NOISE, _SPIKE_SHARE, _SPIKE_STEPS = 10.0, 6.0, 0.05, 3.0
"""A spike exceeds all four: 10 usual deviations and 6 of the noise (one row in 1e9 by chance), 5 % of the force, 3
steps."""
_SPIKE_WINDOW, _MOST_SPIKES = 7, 0.2
"""Rows of the median that spikes are compared with: it passes over up to three bad rows in succession. More than a
fifth are the corners of steep strokes."""
_NOTHING = 1e-20
"""In any unit of force: no cell reads so little, and ratios to more are numbers."""
_LOG_ROWS = 60
"""Rows from which neighbours say what a row should be; shorter files are typed by hand."""
_ENOUGH_VALUES, _FINEST_DECIMALS = 10, 9
_SAME_BEND = 0.02
"""Bend angles that differ by less are one: nobody measures them better."""


@dataclass(frozen=True, eq=False)
class Log:
    """What the estimator sees of a file; a value per row.

    `way` is +1 pulled toward the motor, -1 let go toward the load; `stroke` is 0, 1, ... rising, without gaps; `place`
    goes along the file from -1/2 to 1/2. `middle` and `half` are the middle and half distance of the log ratio's two
    limits at the bend of the row, `noise` its standard deviation, rounding included. `steps` are the resolutions of the
    motor's and of the load's cell; `time` is None if rows are no log in order of time. A power of the force counts
    from `mean_force`, the mean of ln F at the load; `rate` is d ln F/dt.
    """

    motor: Floats
    load: Floats
    way: Integers
    bend: Floats
    stroke: Integers
    place: Floats
    middle: Floats
    half: Floats
    noise: Floats
    steps: tuple[float, float]
    time: Floats | None
    settled: bool
    mean_force: float
    rate: Floats | None = None

    @property
    def log_ratio(self) -> Floats:
        """ln(F_motor/F_load)."""
        return np.asarray(np.log(self.motor / self.load))

    @property
    def strokes(self) -> int:
        """How many."""
        return int(self.stroke[-1]) + 1

    @property
    def first(self) -> Integers:
        """First row of each stroke, and one past the last row."""
        return np.searchsorted(self.stroke, np.arange(self.strokes + 1))

    @property
    def duration(self) -> float:
        """Of a usual stroke, in the unit of the time; 1 without one."""
        if self.time is None:
            return 1.0
        return max(
            float(np.median(self.time[self.first[1:] - 1] - self.time[self.first[:-1]])), 1e-300
        )

    @property
    def both_ways(self) -> bool:
        """Whether gain and friction can be separated."""
        return len(np.unique(self.way[self.bend > 0.0])) == 2

    def select(self, rows: Mask) -> Log:
        """Some of the rows, their strokes counted anew."""
        columns = {name: column[rows] for name, column in self._columns().items()}
        columns["stroke"] = np.unique(columns["stroke"], return_inverse=True)[1]
        return replace(self, **columns)

    def means(self, part: Integers) -> Log:
        """Means over the parts 0, 1, ... of strokes; noise becomes that of a mean."""
        count = np.bincount(part)
        columns: dict[str, Any] = {
            name: np.bincount(part, column) / count for name, column in self._columns().items()
        }
        columns["noise"] /= np.sqrt(count)
        columns |= {name: np.rint(columns[name]).astype(np.int64) for name in ("way", "stroke")}
        return replace(self, **columns)

    def _columns(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)}


def bend_groups(bend: Floats) -> Integers:
    """A number from 1 for each angle, the same for angles that are one."""
    values, place = np.unique(bend, return_inverse=True)
    steps = np.diff(values, prepend=values[:1]) > _SAME_BEND * values
    return np.asarray(1 + np.cumsum(steps), dtype=np.int64)[place]


def resolution_of(readings: Floats) -> float:
    """Smallest step of the readings of one cell.

    Ten different values show it; with fewer it is the last decimal that is written, since three readings 0.378 apart
    do not say that the cell counts in steps of 0.378.
    """
    values = np.unique(readings[np.isfinite(readings)])
    largest = float(np.max(np.abs(values), initial=0.0))
    if len(values) >= _ENOUGH_VALUES:
        # A logger that writes binary fractions repeats a value with a last digit more or less.
        steps = np.diff(values)
        return float(steps[steps > 1e-9 * largest].min(initial=largest))
    for decimals in range(_FINEST_DECIMALS + 1):
        if np.all(np.abs(values - np.round(values, decimals)) <= 1e-12 * largest):
            return float(10.0**-decimals)
    return 0.0


def noise_of(values: Floats, side: Integers | None = None) -> float:
    """Standard deviation of a row about its neighbours, by second differences, which a steady change leaves at zero.

    `side` is what divides the rows into strokes: differences across its changes are left out.
    """
    bends = np.abs(np.diff(values, 2)) / np.sqrt(6.0)
    if side is not None and len(side) > 2:
        bends = bends[(side[2:] == side[1:-1]) & (side[1:-1] == side[:-2])]
    if not len(bends):
        return 0.0
    noise = 1.4826 * float(np.median(bends))
    # Of a coarse cell most differences are zero, and a mean without the largest tenth still sees its steps.
    return noise or 1.3 * float(
        np.sqrt(np.mean(np.sort(bends)[: max(1, int(0.9 * len(bends)))] ** 2))
    )


def unusable(
    cells: tuple[Floats, Floats], steps: tuple[float, float], rest: Mask
) -> npt.NDArray[np.int8]:
    """Code of each row that cannot be a reading of a loaded tendon that moves; `USED` for one that may be.

    `steps` are the resolutions of the cells, `rest` the rows in which the motor is known to stand.
    """
    codes = np.where(rest, AT_REST, USED).astype(np.int8)
    usual = [
        float(np.quantile(cell[cell > 0.0], 0.9)) if np.any(cell > 0.0) else 0.0 for cell in cells
    ]
    if len(rest) >= _LOG_ROWS:
        for cell, step in zip(cells, steps, strict=True):
            codes[_spikes(cell, step)] = SPIKE
            codes[_saturated(cell, step)] = SATURATED
    codes[(cells[0] < _UNLOADED * usual[0]) & (cells[1] < _UNLOADED * usual[1])] = UNLOADED
    for cell, force in zip(cells, usual, strict=True):
        codes[cell <= max(1e-9 * force, _NOTHING)] = (
            NOT_POSITIVE  # what is less than rounding is nothing
        )
    codes[~(np.isfinite(cells[0]) & np.isfinite(cells[1]))] = NO_READING
    return codes


def _saturated(cell: Floats, step: float) -> Mask:
    """Rows at a rail and next to it."""
    known = cell[np.isfinite(cell)]
    values, counts = np.unique(known, return_counts=True)
    noise, none = noise_of(known), np.zeros(len(cell), dtype=bool)
    if len(values) < _ENOUGH_VALUES or counts[-1] < _TOP_ROWS or noise <= _TOP_NOISE * step:
        return none
    # A cell without noise stands wherever the tendon sticks, at both ends of the strokes, and not at the top alone.
    starts = np.concatenate([[0], np.flatnonzero(np.diff(known) != 0.0) + 1, [len(known)]])
    stands, top = np.diff(starts), known[starts[:-1]] == values[-1]
    if (
        counts[-1] <= _TOP_CODES * counts[-6:-1].mean()
        or stands[top].max() < 2 * stands[~top].max()
    ):
        return none
    return np.asarray(cell >= values[-1] - _NEAR_RAIL * noise)


def _spikes(cell: Floats, step: float) -> Mask:
    """Rows far from the median of those about them."""
    from scipy.ndimage import median_filter

    filled = np.nan_to_num(cell, nan=0.0, posinf=0.0, neginf=0.0)
    away = np.abs(filled - median_filter(filled, _SPIKE_WINDOW, mode="nearest"))
    usual, spread = float(np.median(np.abs(filled))), float(np.median(away))
    by_noise = max(_SPIKE_MEDIANS * spread, _SPIKE_NOISE * noise_of(filled))
    spikes = away > max(by_noise, _SPIKE_SHARE * usual, _SPIKE_STEPS * step)
    return np.asarray(spikes & (np.mean(spikes) < _MOST_SPIKES))


def rates_of(time: Floats, log_force: Floats, stroke: Integers, width: int) -> Floats:
    """d ln F/dt of each row by the means of `width` rows after and before it; at the ends of strokes the nearest.

    The difference is odd about the row, so the row's noise does not enter, which would pass for a delay.
    """
    first, last = np.searchsorted(stroke, stroke, "left"), np.searchsorted(stroke, stroke, "right")
    reach = np.minimum(width, (last - first - 1) // 2)
    centre = np.clip(np.arange(len(time)), first + reach, last - 1 - reach)
    change = []
    for column in (log_force - log_force.mean(), time - time.mean()):
        sums = np.concatenate([[0.0], np.cumsum(column)])
        change.append(
            sums[centre + reach + 1] - sums[centre + 1] - sums[centre] + sums[centre - reach]
        )
    return np.asarray(
        np.divide(change[0], change[1], out=np.zeros(len(time)), where=change[1] > 0.0)
    )
