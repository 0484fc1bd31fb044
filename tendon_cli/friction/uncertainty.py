"""The parts of the standard error put together, and the interval from them."""

from __future__ import annotations

import math

import numpy as np

from tendon_cli.friction.estimate import Linear, Slipping
from tendon_cli.friction.resolution import resolution_floor
from tendon_cli.friction.result import FrictionUncertainty


def uncertainty_of(linear: Linear, slipping: Slipping, angle_share: float, doubt: float = 0.0) -> FrictionUncertainty:
    """Scatter of the strokes, raised to what the resolution allows, and the bend angle's own uncertainty.

    `angle_share` is that of the angle as a share of it, `doubt` what offsets and delay may do that are not shown.

    The last two are known rather than estimated from few strokes, which the effective degrees of freedom of Welch and
    Satterthwaite take into account (Guide to the Expression of Uncertainty in Measurement, G.4).
    """
    from scipy.special import stdtrit

    friction, scatter = float(linear.values[0]), linear.error(0)
    turn = slipping.way * slipping.bend_angle
    turn = turn - np.mean(turn) if len(np.unique(slipping.way)) == 2 else turn
    resolution = resolution_floor((slipping.motor, slipping.load), slipping.stroke, turn / float(turn @ turn))
    angle = abs(friction) * angle_share
    total = math.hypot(max(scatter, resolution), angle, doubt)
    free = math.inf if linear.assumed else max(linear.degrees_of_freedom, 1)
    degrees = free * (total / scatter) ** 4 if scatter > 1e-6 * total > 0.0 else math.inf
    half_width = float(stdtrit(min(degrees, 1e9), 0.975)) * total
    return FrictionUncertainty(
        scatter, resolution, angle, doubt, total, degrees, (friction - half_width, friction + half_width)
    )
