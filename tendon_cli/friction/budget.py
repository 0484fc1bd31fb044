"""The uncertainty of μ part by part, as the Guide to the Expression of Uncertainty in Measurement (GUM) has it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.estimate import FrictionEstimate
from tendon_cli.friction.usable_rows import Log, noise_of

FEW, FEW_SHARE = 4, 0.03
"""Strokes below which their scatter says little: 3 % of μ from stroke to stroke is added, as rigs have it."""
_KEEPS = 0.002
"""Of μ: no rig's strokes agree more closely."""
SCATTER, RESOLUTION, EFFECTS, FEW_STROKES, BEND, GAIN = (
    "scatter of the strokes",
    "resolution of the cells",
    "effects that the readings leave open",
    "few strokes, 3 % assumed",
    "bend angle",
    "gain of the cells",
)


@dataclass(frozen=True)
class BudgetPart:
    """One line of the budget: the standard uncertainty of an input, and what it contributes to that of μ.

    `type` is "A" by statistics of these readings, "B" by other knowledge (GUM 4.2, 4.3), `sensitivity` ∂μ/∂input,
    `contribution` its magnitude times the standard uncertainty.
    """

    name: str
    type: str
    standard_uncertainty: float
    unit: str
    sensitivity: float
    contribution: float
    degrees_of_freedom: float = math.inf


@dataclass(frozen=True)
class FrictionUncertainty:
    """Standard error of μ and the parts it is made of.

    `degrees_of_freedom` is the effective number (Welch and Satterthwaite, GUM G.4), `coverage` the factor of the 95 %
    interval, Student's t.
    """

    parts: tuple[BudgetPart, ...]
    standard_error: float
    degrees_of_freedom: float
    coverage: float
    interval_95: tuple[float, float]

    def of(self, name: str) -> float:
        """Contribution of one part; 0 if it has none."""
        return sum(part.contribution for part in self.parts if part.name == name)


def uncertainty_of(
    result: FrictionEstimate,
    log: Log,
    unit: str,
    bend_share: float,
    cells: tuple[float, float] | None,
) -> FrictionUncertainty:
    """`bend_share` is the bend angle's uncertainty over it, `cells` the stated one of each cell's zero and of its gain.

    Scatter and resolution are not added: what rounding does to the strokes is in their scatter, too.
    """
    from scipy.special import stdtrit

    average, points, friction = result.average, result.points, abs(result.friction)
    parts: list[BudgetPart] = []

    def add(
        name: str,
        kind: str,
        value: float,
        unit: str = "1",
        slope: float = 1.0,
        free: float = math.inf,
    ) -> None:
        if value and slope:
            parts.append(BudgetPart(name, kind, value, unit, slope, abs(slope) * value, free))

    root, angle = math.sqrt(points.strokes), float(np.mean(points.bend))
    scatter, rounding = max(average.scatter, _KEEPS * friction / root), _resolution(result, log)
    if rounding > scatter:
        add(RESOLUTION, "B", rounding)
    else:
        add(SCATTER, "A", scatter, free=float(max(average.best.free, 1)))
    add(EFFECTS, "A", average.spread)
    if points.strokes < FEW:
        add(FEW_STROKES, "B", FEW_SHARE, slope=friction / root)
    add(BEND, "B", bend_share * angle, "rad", -result.friction / angle)
    if (
        cells is not None
    ):  # a zero that is fitted has no part left, gains cancel between the directions
        for place, name in enumerate(("zero of the motor's cell", "zero of the load's cell")):
            slope = math.sqrt(
                float(average.weights @ [model.zero[place] ** 2 for model in average.models])
            )
            add(name, "B", cells[0], unit, math.copysign(slope, average.best.zero[place]))
        add(GAIN, "B", 0.0 if points.both_ways else cells[1], slope=math.sqrt(2.0) / angle)
    total = math.sqrt(sum(part.contribution**2 for part in parts))
    share = sum(
        (part.contribution / max(total, 1e-300)) ** 4 / part.degrees_of_freedom for part in parts
    )
    degrees = 1.0 / share if share > 1e-9 else math.inf
    factor = float(stdtrit(min(degrees, 1e9), 0.975))
    low, high = (result.friction + sign * factor * total for sign in (-1.0, 1.0))
    return FrictionUncertainty(tuple(parts), total, degrees, factor, (low, high))


def _resolution(result: FrictionEstimate, log: Log) -> float:
    """Standard error of μ from the rounding of the readings alone.

    Rounding moves all readings of a way alike if they are alike; noise of half a step or more averages it out (dither):
    the mean is then off by no more than exp(-2π²·variance/step²) of it. A force that moves over many steps does, too.
    """
    variance, turn = 0.0, 2.0 if result.points.both_ways else 1.0
    for cell, step in zip((log.motor, log.load), log.steps, strict=True):
        noise = 0.0 if log.settled else min(noise_of(cell), step)
        left = step * math.exp(-2.0 * math.pi**2 * (noise / step) ** 2) if step else 0.0
        for way in np.unique(log.way[result.used]):
            rows = result.used & (log.way == way)
            reach = len(
                np.unique(np.round(cell[rows] / (step or 1.0)))
            )  # different codes are rounded independently
            force, angle = float(np.mean(cell[rows])), float(np.mean(log.bend[rows]))
            variance += (left / (math.sqrt(12.0 * reach) * force * turn * angle)) ** 2
    return math.sqrt(variance)
