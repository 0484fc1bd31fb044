"""The uncertainty of μφ part by part, as the Guide to the Expression of Uncertainty in Measurement (GUM) has it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.estimate import Estimated, Log
from tendon_cli.friction.models import Average
from tendon_cli.friction.rows import noise_of, resolution_of

FEW, FEW_SHARE = 4, 0.03
"""Strokes below which their scatter says little: 3 % of μ from stroke to stroke is added, as rigs have it."""
_KEEPS = 0.002
"""Of μ: no rig's strokes agree more closely."""


@dataclass(frozen=True)
class BudgetPart:
    """One line of the budget."""

    name: str
    type: str
    """"A" by statistics of these readings, "B" by other knowledge (GUM 4.2, 4.3)."""
    value: float
    """Standard uncertainty of the input."""
    unit: str
    sensitivity: float
    """∂μ/∂input."""
    contribution: float
    """|sensitivity| × value, in μ."""
    degrees_of_freedom: float


@dataclass(frozen=True)
class FrictionUncertainty:
    """Standard error of μ and the parts it is made of."""

    parts: tuple[BudgetPart, ...]
    standard_error: float
    degrees_of_freedom: float
    """Effective number (Welch and Satterthwaite, GUM G.4)."""
    coverage: float
    """Factor of the 95 % interval: Student's t."""
    interval_95: tuple[float, float]

    def of(self, name: str) -> float:
        """Contribution of one part; 0 if it has none."""
        return sum(part.contribution for part in self.parts if part.name == name)


SCATTER, RESOLUTION, EFFECTS, FEW_STROKES, BEND, GAIN = (
    "scatter of the strokes", "resolution of the cells", "effects that the readings leave open",
    "few strokes, 3 % assumed", "bend angle", "gain of the cells",
)  # fmt: skip


def uncertainty_of(
    average: Average, estimate: Estimated, log: Log, unit: str, bend_share: float,
    cells: tuple[float, float] | None = None,
) -> FrictionUncertainty:  # fmt: skip
    """`bend_share` is the bend angle's uncertainty over it, `cells` the stated one of each cell's zero and of its gain.

    Scatter and resolution are not added: what rounding does to the strokes is in their scatter, too.
    """
    points, friction = estimate.points, average.friction
    strokes = points.strokes
    scatter = max(average.scatter, _KEEPS * abs(friction) / math.sqrt(strokes))
    rounding = resolution_floor(estimate, log)
    free = float(max(average.best.free, 1))
    parts = [BudgetPart(SCATTER, "A", scatter, "1", 1.0, scatter, free)]
    if rounding > scatter:
        parts = [BudgetPart(RESOLUTION, "B", rounding, "1", 1.0, rounding, math.inf)]
    if average.doubt > 0.0:
        parts.append(BudgetPart(EFFECTS, "A", average.doubt, "1", 1.0, average.doubt, math.inf))
    if strokes < FEW:
        few = FEW_SHARE * abs(friction) / math.sqrt(strokes)
        parts.append(BudgetPart(FEW_STROKES, "B", FEW_SHARE, "1", abs(friction) / math.sqrt(strokes), few, math.inf))
    if bend_share:
        angle = float(np.mean(points.bend))
        parts.append(
            BudgetPart(BEND, "B", bend_share * angle, "rad", -friction / angle, bend_share * abs(friction), math.inf)
        )
    if cells is not None:
        parts += _cell_parts(average, points.bend, cells, unit, points.both_ways)
    total = math.sqrt(sum(part.contribution**2 for part in parts))
    return _together(tuple(parts), friction, total)


def _cell_parts(
    average: Average, bend: np.ndarray, cells: tuple[float, float], unit: str, both: bool
) -> list[BudgetPart]:
    """Of the cells' stated uncertainty: a zero that is fitted has none left, gains cancel between directions."""
    zero, gain = cells
    parts = []
    for place, name in enumerate(("zero of the motor's cell", "zero of the load's cell")):
        slope = math.sqrt(float(average.weights @ [model.zero[place] ** 2 for model in average.models]))
        sign = math.copysign(1.0, average.best.zero[place])
        if zero:
            parts.append(BudgetPart(name, "B", zero, unit, sign * slope, slope * zero, math.inf))
    if gain and not both:
        slope = math.sqrt(2.0) / float(np.mean(bend))
        parts.append(BudgetPart(GAIN, "B", gain, "1", slope, slope * gain, math.inf))
    return parts


def _together(parts: tuple[BudgetPart, ...], friction: float, total: float) -> FrictionUncertainty:
    """The standard error, its degrees of freedom and the interval."""
    from scipy.special import stdtrit

    share = sum((part.contribution / max(total, 1e-300)) ** 4 / part.degrees_of_freedom for part in parts)
    degrees = 1.0 / share if share > 1e-9 else math.inf
    factor = float(stdtrit(min(degrees, 1e9), 0.975))
    return FrictionUncertainty(parts, total, degrees, factor, (friction - factor * total, friction + factor * total))


def resolution_floor(estimate: Estimated, log: Log) -> float:
    """Standard error of μ from the rounding of the readings alone.

    Rounding moves all readings of a way alike if they are alike; noise of half a step or more averages it out (dither):
    the mean is then off by no more than exp(-2π²·variance/step²) of it. A force that moves over many steps does, too.
    """
    variance = 0.0
    turn = 2.0 if estimate.points.both_ways else 1.0
    for cell in (log.motor, log.load):
        step = resolution_of(cell)
        if step == 0.0:
            continue
        noise = 0.0 if log.settled else min(noise_of(cell), step)
        left = math.exp(-2.0 * math.pi**2 * (noise / step) ** 2)
        for way in (1, -1):
            mine = cell[estimate.used & (log.way == way)]
            if not len(mine):
                continue
            reach = max(len(np.unique(np.round(mine / step))), 1)  # different codes are rounded independently
            angle = float(np.mean(log.bend[estimate.used & (log.way == way)]))
            variance += (step * left / (math.sqrt(12.0 * reach) * float(np.mean(mine)) * turn * angle)) ** 2
    return math.sqrt(variance)
