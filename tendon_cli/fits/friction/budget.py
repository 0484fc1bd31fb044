"""Uncertainty of μ part by part.

The budget is that of the Guide to the Expression of Uncertainty in Measurement (GUM).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pandas as pd

from tendon_cli.fits.friction.effects import DELAY, OFFSETS
from tendon_cli.fits.friction.estimate import FrictionEstimate
from tendon_cli.fits.friction.usable_rows import AT_REST, Log
from tendon_cli.fits.log_rows import Floats, noise_of

FEW = 4
"""Number of strokes below which their scatter says little."""
FEW_SHARE = 0.03
"""Standard deviation from stroke to stroke, as a share of μ, that is usual and assumed then."""
LEAST_SCATTER = 0.002
"""Least scatter of strokes, as a share of μ: no rig's strokes agree more closely."""
USUAL_ZERO = 0.02
"""Standard uncertainty of a cell's zero, as a share of the usual force, that is assumed where none
is stated and the readings cannot show it: data sheets give a zero balance of 1 % of the rated
force, and a cell is mostly loaded by half of that."""
USUAL_DELAY = 0.01
"""Standard uncertainty of the delay of one cell against the other, s, that is assumed where none is
stated and the readings cannot show it: amplifiers are set to low-passes of 5 to 50 Hz, which are 30
to 3 ms late."""
_SLIGHT = 1e-4
"""Share of μ up to which a delay is not spoken of: the force is constant."""
_BARE = 0.2
"""Share of the usual force below which both cells are without load while the motor rests."""
SCATTER = "scatter of the strokes"
SCATTER_WITHIN = "scatter of the readings within the strokes"
"""Name of the scatter where strokes are too few to show their own: it counts readings."""
RESOLUTION = "resolution of the cells"
EFFECTS = "effects that the readings leave open"
DELAY_TAKEN_OUT = "delay, corrected for"
FEW_STROKES = "few strokes, 3 % assumed"
BEND = "bend angle"
GAIN = "gain of the cells"
ZEROS = ("zero of the motor's cell", "zero of the load's cell")
LATE = "delay between the cells"


@dataclass(frozen=True)
class BudgetPart:
    """One line of the budget: an input, and what it contributes to the uncertainty of μ."""

    name: str
    type: str
    """"A" by statistics of these readings, "B" by other knowledge (GUM 4.2, 4.3)."""
    standard_uncertainty: float
    """Standard uncertainty of the input, in its unit."""
    unit: str
    sensitivity: float
    """∂μ/∂input."""
    contribution: float
    """Magnitude of the sensitivity times the standard uncertainty."""
    degrees_of_freedom: float = math.inf


@dataclass(frozen=True)
class FrictionUncertainty:
    """Standard error of μ and the parts it is made of."""

    parts: tuple[BudgetPart, ...]
    standard_error: float
    degrees_of_freedom: float
    """Effective number (Welch and Satterthwaite, GUM G.4)."""
    coverage: float
    """Factor of the 95 % interval, Student's t."""
    interval_95: tuple[float, float]

    def holds(self, friction: float) -> bool:
        """Return True if a μ lies in the 95 % interval."""
        low, high = self.interval_95
        return low <= friction <= high

    def contribution_of(self, name: str) -> float:
        """Return the contribution of one part; 0 if it has none."""
        return sum(part.contribution for part in self.parts if part.name == name)


def readings_without_load(rows: pd.DataFrame) -> tuple[dict[str, float], dict[str, float]]:
    """Return what the motor's and the load's cell read at rest without load.

    Args:
        rows: Rows of the fit, as `Fit.rows` has them.

    Returns:
        Median reading at the "start" and at the "end" of the file, as far as there are any.
    """
    used = rows[rows["used"]]
    is_bare = rows["code"] == AT_REST
    for end in ("motor", "load"):
        is_bare &= rows[end].abs() < _BARE * float(used[end].median())
    strokes = np.flatnonzero(rows["run"] >= 0)
    place = np.arange(len(rows))
    parts = {"start": is_bare & (place < strokes[0]), "end": is_bare & (place > strokes[-1])}
    motor, load = (
        {name: float(rows.loc[part, end].median()) for name, part in parts.items() if part.any()}
        for end in ("motor", "load")
    )
    return motor, load


def zero_errors_of(
    result: FrictionEstimate,
    stated: float | None,
    are_known: tuple[bool, bool],
    without_load: tuple[dict[str, float], dict[str, float]],
) -> tuple[float, float]:
    """Return the standard uncertainty of the zero of the motor's and of the load's cell.

    It is the stated one, or what the cells read at rest without load. Without either it is the
    usual zero error, where the readings cannot tell it from friction: under a constant force. If
    the cells differ by more, all of that may be a zero
    error of one of them: it is a rectangular distribution of this half-width (GUM 4.3.7).

    Args:
        result: Estimate of μ.
        stated: Stated standard uncertainty, in the unit of the forces; None if it is not stated.
        are_known: True for the motor's and the load's cell if its reading without load is given.
        without_load: Readings of both without load, of `readings_without_load`.
    """
    if stated is not None:
        return stated, stated
    average = result.average
    is_fitted = any(set(OFFSETS).intersection(model.effects) for model in average.models)
    if is_fitted or not result.points.both_ways:
        return 0.0, 0.0
    share = max(USUAL_ZERO, abs(average.log_gain) / math.sqrt(3.0))
    cells = (result.points.motor, result.points.load)
    errors = []
    for cell, is_known, bare in zip(cells, are_known, without_load, strict=True):
        error = 0.0 if is_known else share * float(np.median(cell))
        if bare:
            left = np.array(list(bare.values()))
            error = math.hypot(float(left.mean()), 0.5 * float(np.ptp(left)))
        errors.append(error)
    return errors[0], errors[1]


def late_error_of(
    result: FrictionEstimate, log: Log, stated: float | None, second: float | None
) -> float:
    """Return the standard uncertainty of the delay between the cells, in the unit of the time.

    It is the stated one. Else it is the usual one, or the error of a row if two converters read by
    themselves, where this is larger; and no more than what the readings leave open.

    Args:
        result: Estimate of μ.
        log: Rows that it was estimated from.
        stated: Stated standard uncertainty, s; None if it is not stated.
        second: Units of the time in a second; None if the file does not say.
    """
    if log.time is None or result.delay:
        return 0.0
    if stated is not None:
        return stated * (second or 1.0)
    row = float(np.median(np.abs(np.diff(log.time))))
    usual = max(USUAL_DELAY * (second or 0.0), row / math.sqrt(3.0))
    for model in result.average.models:
        if model.effects == (DELAY,):
            usual = min(usual, math.hypot(*model.value(DELAY)))
    return usual


def uncertainty_of(
    result: FrictionEstimate,
    log: Log,
    unit: str,
    time_unit: str,
    bend_share: float,
    zero_errors: tuple[float, float],
    gain_error: float,
    late_error: float,
) -> FrictionUncertainty:
    """Add up the uncertainty of μ.

    Only the larger of scatter and resolution counts, since the scatter of the strokes includes that
    by rounding.

    Args:
        result: Estimate of μ.
        log: Rows that it was estimated from.
        unit: Unit of the forces.
        time_unit: Unit of the time.
        bend_share: Standard uncertainty of the bend angle over the angle.
        zero_errors: Standard uncertainty of the zero of the motor's and of the load's cell, in
            `unit`.
        gain_error: Standard uncertainty of each cell's gain, as a share.
        late_error: Standard uncertainty of the delay between the cells, in `time_unit`.
    """
    from scipy.special import stdtrit

    average = result.average
    points = result.points
    friction = abs(result.friction)
    parts: list[BudgetPart] = []

    def add(
        name: str,
        kind: str,
        value: float,
        unit: str = "1",
        slope: float = 1.0,
        free: float = math.inf,
    ) -> None:
        """Add a part, unless it contributes nothing."""
        if value and slope:
            parts.append(BudgetPart(name, kind, value, unit, slope, abs(slope) * value, free))

    root = math.sqrt(points.strokes)
    angle = float(np.mean(points.bend))
    scatter = max(average.scatter, LEAST_SCATTER * friction / root)
    rounding = _resolution(result, log)
    if rounding > scatter:
        add(RESOLUTION, "B", rounding)
    else:
        name = SCATTER if points.strokes > 1 + points.both_ways else SCATTER_WITHIN
        add(name, "A", scatter, free=float(max(average.best.free, 1)))
    add(EFFECTS, "A", average.spread)
    add(DELAY_TAKEN_OUT, "A", result.delay_error)
    if points.strokes < FEW:
        add(FEW_STROKES, "B", FEW_SHARE, slope=friction / root)
    add(BEND, "B", bend_share * angle, "rad", -result.friction / angle)
    # A zero that is fitted has no part left, and gains cancel between the directions.
    for cell, name in enumerate(ZEROS):
        squares = [model.zero[cell] ** 2 for model in average.models]
        slope = math.sqrt(float(average.weights @ squares))
        add(name, "B", zero_errors[cell], unit, math.copysign(slope, average.best.zero[cell]))
    slope = math.sqrt(float(average.weights @ [model.late**2 for model in average.models]))
    if slope * late_error > _SLIGHT * friction:
        add(LATE, "B", late_error, time_unit, math.copysign(slope, average.best.late))
    gain = 0.0 if points.both_ways else gain_error
    add(GAIN, "B", gain, slope=math.sqrt(2.0) / angle)
    total = math.sqrt(sum(part.contribution**2 for part in parts))
    share = sum(
        (part.contribution / max(total, 1e-300)) ** 4 / part.degrees_of_freedom for part in parts
    )
    degrees = 1.0 / share if share > 1e-9 else math.inf
    coverage = float(stdtrit(min(degrees, 1e9), 0.975))
    half = coverage * total
    interval = (result.friction - half, result.friction + half)
    return FrictionUncertainty(tuple(parts), total, degrees, coverage, interval)


def _resolution(result: FrictionEstimate, log: Log) -> float:
    """Return the standard error of μ from the rounding of the readings alone.

    Readings of one direction that are alike are rounded alike. Noise of half a step or more
    averages this out (dither): the mean keeps no more than exp(-2π²·variance/step²) of the error. A
    force that moves over many steps averages it out, too.
    """
    variance = 0.0
    directions = 2.0 if result.points.both_ways else 1.0
    for cell, step in zip((log.motor, log.load), log.steps, strict=True):
        remaining_step = _undithered(cell, step, log)
        for way in np.unique(log.way[result.used]):
            rows = result.used & (log.way == way)
            # Different codes are rounded independently.
            codes = len(np.unique(np.round(cell[rows] / (step or 1.0))))
            force = float(np.mean(cell[rows]))
            angle = float(np.mean(log.bend[rows]))
            divisor = math.sqrt(12.0 * codes) * force * directions * angle
            variance += (remaining_step / divisor) ** 2
    return math.sqrt(variance)


def _undithered(cell: Floats, step: float, log: Log) -> float:
    """Return the part of a cell's step that the mean of many noisy readings still shows."""
    if not step:
        return 0.0
    noise = 0.0 if log.settled else min(noise_of(cell), step)
    return step * math.exp(-2.0 * math.pi**2 * (noise / step) ** 2)
