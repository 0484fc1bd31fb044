"""The parts of the standard error put together, and the interval from them."""

from __future__ import annotations

import math

from tendon_cli.friction.bend import BendAngle
from tendon_cli.friction.estimate import Estimate, Slipping
from tendon_cli.friction.resolution import resolution_floor
from tendon_cli.friction.result import Uncertainty


def uncertainty_of(estimate: Estimate, slipping: Slipping, bend: BendAngle | None) -> Uncertainty:
    """Scatter of the strokes, raised to what the resolution allows, and the bend angle's own uncertainty.

    The last two are known rather than estimated from few strokes, which the effective degrees of freedom of Welch and
    Satterthwaite take into account (Guide to the Expression of Uncertainty in Measurement, G.4).
    """
    from scipy.special import stdtrit

    scatter = estimate.standard_error
    resolution = resolution_floor((slipping.motor, slipping.load), slipping.stroke, estimate.weights)
    angle = abs(estimate.friction) * bend.uncertainty / bend.radians if bend else 0.0
    total = math.hypot(max(scatter, resolution), angle)
    degrees = estimate.degrees_of_freedom * (total / scatter) ** 4 if scatter > 1e-6 * total > 0.0 else math.inf
    half_width = float(stdtrit(min(degrees, 1e9), 0.975)) * total
    interval = (estimate.friction - half_width, estimate.friction + half_width)
    return Uncertainty(scatter, resolution, angle, total, degrees, interval)
