"""A tendon in a curved sheath with Coulomb friction (Eqs. 6 and 13, Appendix A).

Along the sheath dF/ds = σ μ κ F, where σ is -1 for a tendon that is pulled toward the motor and +1 for one that is
dragged toward the elbow. For the ratio of the tensions only the total curvature φ = ∫κ ds matters (Eq. A.17), whatever
the route in three dimensions; the elongation (Eq. 13) supposes that the curvature is spread evenly along the sheath.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array, Real

_FEWEST_TO_EXTRAPOLATE = 7
_SHORTEST_STEP = 1e-3  # of the median step

TOWARD_MOTOR = -1.0
TOWARD_ELBOW = 1.0


def capstan_ratio(friction: Real, bend_angle: Real, toward: Real) -> Array:
    """Distal over proximal tension, e^{σμφ} (Eqs. 6 and A.17); `toward` is σ."""
    return np.exp(np.multiply(np.multiply(toward, friction), bend_angle))


def relative_elongation(exponent: Real) -> Array:
    """(e^z - 1)/z, the elongation of a tendon over that without friction; 1 in the limit z → 0.

    With z = σμφ it is per proximal tension, with z = -σμφ per distal tension (Eq. 13, β/L).
    """
    z = np.asarray(exponent)
    with np.errstate(invalid="ignore"):
        return np.where(z == 0.0, 1.0, np.expm1(z) / z)


def tendon_compliance(
    length: Real, diameter: Real, youngs_modulus: Real, friction: Real, bend_angle: Real, toward: Real
) -> Array:
    """Elongation of a round tendon per newton at its distal end (Eq. 13), m/N."""
    area = np.pi * np.square(diameter) / 4.0
    exponent = np.multiply(np.multiply(-np.asarray(toward), friction), bend_angle)
    return np.asarray(length / (area * youngs_modulus) * relative_elongation(exponent))


@dataclass(frozen=True)
class RouteCurvature:
    """Total curvature of a route and how far its way-points can be trusted."""

    bend_angle: float
    """∫κ ds over the whole route, rad."""
    noise_share: float
    """By how much the sum of turns falls when every second way-point is left out, as a share of it. Near 0 for a
    smooth, well-sampled route; near 0.75 where digitisation noise makes most of the turns."""
    largest_turn: float
    """Largest turn at one way-point, rad; above about 0.5 the route is sampled coarsely."""


def total_curvature(points: npt.ArrayLike) -> RouteCurvature:
    """Total curvature ∫κ ds of a route given as way-points, an array of shape (n, 3) in m; n ≥ 2.

    The turns between successive chords are summed, the half chords at both ends counted with the curvature found next
    to them, and the sum is extrapolated from chords of one and of two steps (Richardson), which removes the error of
    second order. Raises ValueError for fewer than two distinct points.
    """
    route = distinct(np.asarray(points, dtype=np.float64))
    fine, largest = _sum_of_turns(route, np.arange(len(route)))
    if len(route) < _FEWEST_TO_EXTRAPOLATE:
        return RouteCurvature(fine, 0.0, largest)
    coarse = float(np.mean([_sum_of_turns(route, np.arange(first, len(route), 2))[0] for first in (0, 1)]))
    share = max(0.0, (fine - coarse) / fine) if fine > 1e-9 else 0.0
    return RouteCurvature(fine + (fine - coarse) / 3.0, share, largest)


def distinct(points: Array) -> Array:
    """The way-points without repetitions: a step far shorter than the others has a direction, but it is noise."""
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"way-points have the shape {points.shape}, expected (n, 3)")
    if not np.all(np.isfinite(points)):
        raise ValueError("way-points are finite")
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1) if len(points) else np.zeros(0)
    if not np.any(steps > 0.0):
        raise ValueError("a route needs at least two different way-points")
    moved = steps > _SHORTEST_STEP * np.median(steps[steps > 0.0])
    route: Array = points[np.append(True, moved)]
    return route


def _sum_of_turns(route: Array, chosen: npt.NDArray[np.int_]) -> tuple[float, float]:
    """Turns of the polygon through the chosen way-points, its ends extended to the whole route; and the largest."""
    chords = np.diff(route[chosen], axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    # atan2 of the two products keeps its precision for small turns and near reversals, unlike arccos.
    across = np.linalg.norm(np.cross(chords[:-1], chords[1:]), axis=1)
    turns = np.arctan2(across, np.sum(chords[:-1] * chords[1:], axis=1))
    if not len(turns):
        return 0.0, 0.0
    spans = (lengths[:-1] + lengths[1:]) / 2.0
    steps = np.linalg.norm(np.diff(route, axis=0), axis=1)
    before, after = steps[: chosen[0]].sum(), steps[chosen[-1] :].sum()
    start = turns[0] / spans[0] * (lengths[0] / 2.0 + before)
    end = turns[-1] / spans[-1] * (lengths[-1] / 2.0 + after)
    return float(turns.sum() + start + end), float(turns.max())
