"""Rows of two cells that can be readings of a loaded tendon: noise, resolution, and what is set aside at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.friction.reading.readings import Floats, Integers

USED, NO_READING, NOT_POSITIVE, UNLOADED, SATURATED, SPIKE, AT_REST, INSIDE, PARTIAL = range(9)
REASONS = (
    "",
    "no reading",
    "force at or below zero",
    "no load (below 3 % of the usual force)",
    "saturated (a cell stands at its largest reading)",
    "spike (far from the rows beside it)",
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
step
repeats values without any rail: two codes then hold over half of its rows each."""
_NEAR_RAIL = 3.0
"""Standard deviations of noise below the rail, where readings are those that noise happened to lower."""
_SPIKE_MEDIANS, _SPIKE_NOISE, _SPIKE_SHARE, _SPIKE_STEPS = 10.0, 6.0, 0.05, 3.0
"""A spike exceeds all four: 10 usual deviations and 6 of the noise (one row in 1e9 by chance), 5 % of the force, 3
steps."""
_WINDOW = 7
"""Rows of the median that spikes are told by: it passes over up to three bad rows in succession."""
_LOG_ROWS = 60
"""Rows from which neighbours say what a row should be; shorter files are typed by hand."""
_ENOUGH_VALUES, _FINEST_DECIMALS = 10, 9


@dataclass(frozen=True, eq=False)
class FittedRows:
    """The readings one by one, as the figure shows them."""

    line: Integers
    """Line in the file."""
    motor: Floats
    """Force at the motor, its stated zero taken off, in the unit of the file."""
    load: Floats
    log_ratio: Floats
    """ln(force at motor / force at load); NaN if there is no such reading."""
    way: Integers
    """+1 pulled toward the motor, -1 toward the load, 0 set aside before directions were told."""
    bend_angle: Floats
    """rad."""
    run: Integers
    """Number of the stroke, used or not; -1 for a reading that is in none."""
    stroke: Integers
    """Number of the stroke, -1 for a reading that is set aside."""
    residual: Floats
    """log_ratio less the fitted line; NaN for a reading that is set aside."""
    codes: npt.NDArray[np.int8]
    """Why a row is set aside (`REASONS`)."""
    time: Floats | None
    """As in the file, if it has a column of numbers for it."""
    position: Floats | None
    position_is_speed: bool

    @property
    def used(self) -> npt.NDArray[np.bool_]:
        """Which readings the estimate rests on."""
        return self.stroke >= 0


def resolution_of(readings: Floats) -> float:
    """Smallest step of the readings of one cell.

    Ten different values show it; with fewer it is the last decimal that is written, since three readings 0.378 apart
    do not say that the cell counts in steps of 0.378.
    """
    values = np.unique(readings[np.isfinite(readings)])
    if len(values) >= _ENOUGH_VALUES:
        # A logger that writes binary fractions repeats a value with a last digit more or less.
        steps = np.diff(values)
        return float(steps[steps > 1e-9 * abs(values).max()].min(initial=abs(values).max()))
    scale = float(np.max(np.abs(values), initial=0.0))
    for decimals in range(_FINEST_DECIMALS + 1):
        if np.all(np.abs(values - np.round(values, decimals)) <= 1e-12 * scale):
            return float(10.0**-decimals)
    return 0.0


def noise_of(values: Floats, side: Integers | None = None) -> float:
    """Standard deviation of a row about its neighbours, by second differences, which a steady change leaves at zero.

    `side` is what divides the rows into strokes: differences across its changes are left out.
    """
    bends = np.abs(np.diff(values, 2)) / np.sqrt(6.0)
    if side is not None and len(side) > 2:
        within = (side[2:] == side[1:-1]) & (side[1:-1] == side[:-2])
        bends = bends[within] if np.any(within) else bends[:0]
    if not len(bends):
        return 0.0
    noise = 1.4826 * float(np.median(bends))
    # Of a coarse cell most differences are zero, and a mean without the largest tenth still sees its steps.
    return noise or 1.3 * float(np.sqrt(np.mean(np.sort(bends)[: max(1, int(0.9 * len(bends)))] ** 2)))


def unusable(cells: tuple[Floats, Floats], rest: npt.NDArray[np.bool_]) -> npt.NDArray[np.int8]:
    """Code of each row that cannot be a reading of a loaded tendon that moves; `USED` for one that may be."""
    codes = np.zeros(len(rest), dtype=np.int8)
    usual = [float(np.quantile(cell[cell > 0.0], 0.9)) if np.any(cell > 0.0) else 0.0 for cell in cells]
    codes[rest] = AT_REST
    if len(rest) >= _LOG_ROWS:
        for cell in cells:
            codes[_spikes(cell)] = SPIKE
            codes[_saturated(cell)] = SATURATED
    codes[(cells[0] < _UNLOADED * usual[0]) & (cells[1] < _UNLOADED * usual[1])] = UNLOADED
    for cell, force in zip(cells, usual, strict=True):
        codes[cell <= 1e-9 * force] = NOT_POSITIVE  # what is less than rounding is nothing
    codes[~(np.isfinite(cells[0]) & np.isfinite(cells[1]))] = NO_READING
    return codes


def _saturated(cell: Floats) -> npt.NDArray[np.bool_]:
    """Rows at a rail and next to it."""
    known = cell[np.isfinite(cell)]
    none = np.zeros(len(cell), dtype=bool)
    values, counts = np.unique(known, return_counts=True)
    if len(values) < _ENOUGH_VALUES or counts[-1] < _TOP_ROWS or counts[-1] <= _TOP_CODES * counts[-6:-1].mean():
        return none
    noise = noise_of(known)
    # A cell without noise stands wherever the tendon sticks, at both ends of the strokes, and not at the top alone.
    starts = np.concatenate([[0], np.flatnonzero(np.diff(known) != 0.0) + 1, [len(known)]])
    stands, top = np.diff(starts), known[starts[:-1]] == values[-1]
    if noise <= _TOP_NOISE * resolution_of(cell) or stands[top].max() < 2 * stands[~top].max():
        return none
    return np.asarray(cell >= values[-1] - _NEAR_RAIL * noise)


def _spikes(cell: Floats) -> npt.NDArray[np.bool_]:
    """Rows far from the median of those about them."""
    filled = np.nan_to_num(cell, nan=0.0, posinf=0.0, neginf=0.0)
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(filled, _WINDOW // 2, mode="edge"), _WINDOW)
    middle = np.empty_like(filled)
    for first in range(0, len(filled), 200_000):
        middle[first : first + 200_000] = np.median(windows[first : first + 200_000], axis=1)
    away = np.abs(filled - middle)
    usual = float(np.median(np.abs(filled)))
    limit = max(
        _SPIKE_MEDIANS * float(np.median(away)), _SPIKE_NOISE * noise_of(filled),
        _SPIKE_SHARE * usual, _SPIKE_STEPS * resolution_of(cell),
    )  # fmt: skip
    found = away > limit
    # Corners of steep strokes are no spikes: a spike's own neighbours agree with each other.
    return np.asarray(found & (np.mean(found) < 0.2))


def rates_of(time: Floats, log_force: Floats, stroke: Integers, width: int) -> Floats:
    """d ln F/dt of each row by the means of `width` rows after and before it; at the ends of strokes the nearest.

    The difference is odd about the row, so its own noise does not enter, which would pass for a delay.
    """
    rows = np.arange(len(time))
    first, last = np.searchsorted(stroke, stroke, "left"), np.searchsorted(stroke, stroke, "right")
    reach = np.minimum(width, (last - first - 1) // 2)
    centre = np.clip(rows, first + reach, last - 1 - reach)
    change = []
    for column in (log_force - log_force.mean(), time - time.mean()):
        sums = np.concatenate([[0.0], np.cumsum(column)])
        change.append(sums[centre + reach + 1] - sums[centre + 1] - sums[centre] + sums[centre - reach])
    return np.asarray(np.divide(change[0], change[1], out=np.zeros(len(time)), where=change[1] > 0.0))
