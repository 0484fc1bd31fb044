"""Total curvature of a route from noisy way-points, with its uncertainty.

Noise has curvature: the turns between the chords of noisy way-points add up to far more than the
route bends. So straight lines are fitted to windows of several way-points each, and the turns
between neighbouring windows are added up. In a plane, where a route bends to one side, their sum
does not depend on the length of the windows; turns that noise explains count as zero, and the
average that such turns add is subtracted. The length with the least expected error is used. With
windows of one step it is the plain sum of turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array

FEWEST = 7
"""With fewer way-points neither their scatter nor the bend at their ends can be estimated."""
_SHORTEST_STEP = 1e-3  # of the median step
_FEWEST_WINDOWS = 5
_MOST_OFFSETS = 8
_ORDERS = range(2, 8)  # of divided differences
# A turn by noise alone has two components of variance v: its square exceeds 4v in e^-2 of cases.
_SIGNIFICANT = 4.0
_MISSED = 1.0 - math.exp(-2.0)
_LEFT = 0.2977  # mean of sqrt(θ² - v), counted where θ² > 4v, in units of sqrt(v)
_MEDIANS = {2: 1.386, 3: 2.366}  # of chi-squared
_LEAST_OF_SEVERAL = 1.06  # the least of several estimates of one noise is this much too small
_CORNER = 0.5  # rad
_TURNS_SHOW = 0.02  # rad²; where noise makes larger turns than this no single one stands out
_NO_NOISE = 1e-6  # rad²; where noise makes smaller turns than this every turn counts
_LEAST_ERROR = 0.003  # share of the bend
_UNKNOWN_LOSS = 0.1  # share of the bend


@dataclass(frozen=True)
class MeasuredRoute:
    """Bend of a route from its way-points; angles in rad, lengths in m."""

    bend_angle: float
    """∫κ ds over the whole route."""
    standard_error: float
    """Standard error of the bend angle; twice as much covers the truth in nine of ten routes or
    more."""
    sum_of_turns: float
    """Sum of turns without regard to noise."""
    noise: float | None
    """Standard deviation of each coordinate, estimated from the way-points; None if they are too
    few."""
    largest_turn: float
    """Largest turn at one way-point that noise does not explain; above about 0.5 the route is
    sampled coarsely."""


def measured_route(points: Array, stated_noise: float | None = None) -> MeasuredRoute:
    """Return the total curvature of noisy way-points.

    Args:
        points: Way-points, (n, 3), m.
        stated_noise: Standard deviation of each coordinate, m; the larger of this and the one
            estimated from the points counts.

    Raises:
        ValueError: If there are fewer than two different way-points.
    """
    route = distinct(np.asarray(points, dtype=np.float64))
    sum_of_turns, turn = total_curvature(route)
    if len(route) < FEWEST:
        return _measure_few(route, sum_of_turns, turn)
    estimated_noise = noise_of(route)
    noise = max(estimated_noise, stated_noise or 0.0)
    scales = {length: _at_scale(route, length, noise) for length in _lengths(len(route))}
    first = scales[1]
    if first.variance < _NO_NOISE:
        _, lost = _correction(scales, 1)
        error = math.hypot(_LEAST_ERROR * sum_of_turns, lost)
        return MeasuredRoute(sum_of_turns, error, sum_of_turns, estimated_noise, turn)
    estimates = [_with_error(scales, length) for length in scales]
    bend_angle, error = min(estimates, key=lambda estimate: estimate[1])
    largest = first.largest if first.variance < _TURNS_SHOW else 0.0
    return MeasuredRoute(bend_angle, error, sum_of_turns, estimated_noise, largest)


def _measure_few(route: Array, bend_angle: float, largest: float) -> MeasuredRoute:
    """Return the bend of a few way-points.

    An arc bends up to its ends, a corner does not; the difference is the uncertainty.
    """
    chords = np.diff(route, axis=0)
    turns = float(_angles(chords[:-1], chords[1:]).sum())
    ends = bend_angle - turns
    counted = 0.0 if largest > _CORNER else ends
    error = math.hypot(0.5 * ends, _LEAST_ERROR * bend_angle)
    return MeasuredRoute(turns + counted, error, bend_angle, None, largest)


def noise_of(route: Array) -> float:
    """Return the standard deviation of the noise in each coordinate of way-points, m.

    Divided differences of order m leave noise and remove a polynomial of lower order. Their median
    does not notice a few corners. The least of several orders, by number and by chord length,
    counts: none is below the noise.
    """
    numbers = np.arange(len(route), dtype=np.float64)
    estimates = []
    for along, components in ((numbers, 3), (_chord_lengths(route), 2)):
        for order in _ORDERS:
            if len(route) < 2 * order + 5:
                break
            rest = _divided_differences(route, along, order)
            median = float(np.median(np.sum(rest**2, axis=1)))
            estimates.append(math.sqrt(median / _MEDIANS[components]))
    return _LEAST_OF_SEVERAL * min(estimates, default=0.0)


def _chord_lengths(route: Array) -> Array:
    """Return the length along the chords up to each way-point, (n,), m."""
    return np.append(0.0, np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1)))


def _divided_differences(route: Array, along: Array, order: int) -> Array:
    """Return divided differences of way-points along a parameter, with weights of norm 1.

    There is one difference for every `order` + 1 way-points in succession, (differences, 3).
    """
    windows = np.arange(len(route) - order)[:, np.newaxis] + np.arange(order + 1)
    at = along[windows] - along[windows[:, :1]]
    gaps = (at[:, :, np.newaxis] - at[:, np.newaxis, :]) / at[:, -1:, np.newaxis]
    gaps[:, np.arange(order + 1), np.arange(order + 1)] = 1.0
    weights = 1.0 / np.prod(gaps, axis=2)
    weights /= np.linalg.norm(weights, axis=1)[:, np.newaxis]
    return np.asarray(np.einsum("ij,ijk->ik", weights, route[windows]))


@dataclass(frozen=True)
class _Scale:
    """Sum of turns between windows of one length, averaged over the start of the first."""

    total: float
    """Sum of turns less what noise adds, rad."""
    scatter: float
    """Variance of the total by noise and by the uncertain bend of both ends, rad²."""
    taken_off: float
    """Turns that noise adds on average, rad."""
    variance: float
    """Variance of one component of a turn by noise, rad²."""
    largest: float
    """Largest turn that noise alone hardly makes, rad."""


def _lengths(count: int) -> list[int]:
    """Return lengths of windows in steps, each about half as long again as the one before."""
    lengths = [1]
    while True:
        longer = max(lengths[-1] + 1, int(1.5 * lengths[-1]))
        if (count - 1) // longer < _FEWEST_WINDOWS:
            return lengths
        lengths.append(longer)


def _with_error(scales: dict[int, _Scale], length: int) -> tuple[float, float]:
    """Return the total at a scale, extrapolated to length zero, and its expected error, rad."""
    scale = scales[length]
    correction, lost = _correction(scales, length)
    variances = (
        1.5 * scale.scatter,
        (0.5 * scale.taken_off) ** 2,
        lost**2,
        (_LEAST_ERROR * scale.total) ** 2,
    )
    return max(0.0, scale.total + correction), math.sqrt(sum(variances))


def _correction(scales: dict[int, _Scale], length: int) -> tuple[float, float]:
    """Estimate the bend that windows of a length lose, from those about twice as long.

    This is Richardson's extrapolation: the loss is of second order.

    Returns:
        Correction to add and its possible size, rad. Without longer windows the correction is 0.
    """
    total = scales[length].total
    longer = min(scales, key=lambda other: abs(math.log(other / (2.0 * length))))
    if longer <= length:
        return 0.0, _UNKNOWN_LOSS * total
    lost = (total - scales[longer].total) / ((longer / length) ** 2 - 1.0)
    is_plausible = abs(lost) <= 2.0 * _UNKNOWN_LOSS * total
    return (lost if is_plausible else 0.0), abs(lost)


def _at_scale(route: Array, length: int, noise: float) -> _Scale:
    """Return the sum of turns between windows of a length, over several offsets of the first."""
    along = _chord_lengths(route)
    offsets = np.unique(np.linspace(0, length - 1, min(length, _MOST_OFFSETS)).astype(int))
    scales = [_at_offset(route, along, length, int(offset), noise) for offset in offsets]
    total, scatter, taken_off, variance = np.mean(
        [[scale.total, scale.scatter, scale.taken_off, scale.variance] for scale in scales], axis=0
    )
    largest = max(scale.largest for scale in scales)
    return _Scale(float(total), float(scatter), float(taken_off), float(variance), largest)


def _at_offset(route: Array, along: Array, length: int, offset: int, noise: float) -> _Scale:
    """Return the sum of turns between windows of `length` steps, the first of which is at `offset`.

    Args:
        route: Way-points, (n, 3), m.
        along: Length along the chords up to each way-point, (n,), m.
        length: Steps in a window.
        offset: Way-point at which the first window starts.
        noise: Standard deviation of each coordinate, m.
    """
    # A straight line through each window, by least squares
    count = (len(route) - 1 - offset) // length
    windows = offset + np.arange(count)[:, np.newaxis] * length + np.arange(length + 1)
    centres = along[windows].mean(axis=1)
    arms = along[windows] - centres[:, np.newaxis]
    weights = arms / np.sum(arms**2, axis=1)[:, np.newaxis]
    slopes = np.einsum("ij,ijk->ik", weights, route[windows])
    weights /= np.linalg.norm(slopes, axis=1)[:, np.newaxis]

    # Turns and their variances by noise; neighbouring windows share a way-point
    turns = _angles(slopes[:-1], slopes[1:])
    per_window = np.sum(weights**2, axis=1)
    shared = 2.0 * weights[:-1, -1] * weights[1:, 0]
    variances = noise**2 * (per_window[:-1] + per_window[1:] - shared)
    is_significant = turns**2 > _SIGNIFICANT * variances
    bends = np.where(is_significant, np.sqrt(np.maximum(turns**2 - variances, 0.0)), 0.0)
    noise_share = min(1.0, float(np.mean(~is_significant)) / _MISSED) if noise > 0.0 else 0.0
    taken_off = noise_share * _LEFT * float(np.sum(np.sqrt(variances)))

    steps = np.diff(centres)
    first_bend, first_error = _end(bends[:3] / steps[:3], centres[0] - along[0])
    last_bend, last_error = _end(bends[:-4:-1] / steps[:-4:-1], along[-1] - centres[-1])
    variance = float(np.mean(variances))
    by_noise = variance * (1.5 + 0.5 * len(turns) * noise_share)
    scatter = by_noise + (first_error**2 + last_error**2)
    total = max(0.0, float(bends.sum()) - taken_off) + (first_bend + last_bend)
    # By noise alone hardly one of so many turns would be as large.
    is_certain = turns**2 > 2.0 * variances * (math.log(len(turns)) + 5.0)
    return _Scale(total, scatter, taken_off, variance, float(bends[is_certain].max(initial=0.0)))


def _end(curvatures: Array, distance: float) -> tuple[float, float]:
    """Estimate how much a route bends between its end and the window next to it.

    If the turns next to the end are alike it goes on as they do; if not there may be a corner.

    Args:
        curvatures: Curvatures next to the end, the nearest first, rad/m.
        distance: Length from the middle of the window to the end, m.

    Returns:
        The bend and its uncertainty, rad.
    """
    mean = float(curvatures.mean())
    least = float(curvatures.min()) if len(curvatures) > 1 else 0.0
    if len(curvatures) > 1 and least >= 0.5 * mean:
        return mean * distance, float(curvatures.std()) / math.sqrt(len(curvatures)) * distance
    return least * distance, 0.5 * (mean - least) * distance


def total_curvature(points: npt.ArrayLike) -> tuple[float, float]:
    """Return the total curvature ∫κ ds of way-points that do not scatter, and their largest turn.

    The turns between successive chords are summed, the half chords at both ends counted with the
    curvature next to them, and the sum is extrapolated from chords of one and of two steps
    (Richardson), which removes the error of second order.

    Args:
        points: Way-points, (n, 3), n ≥ 2, m.

    Returns:
        Both angles, rad.

    Raises:
        ValueError: If there are fewer than two distinct points.
    """
    route = distinct(np.asarray(points, dtype=np.float64))
    fine, largest = _sum_of_turns(route, np.arange(len(route)))
    if len(route) < FEWEST:
        return fine, largest
    sums = [_sum_of_turns(route, np.arange(first, len(route), 2))[0] for first in (0, 1)]
    coarse = float(np.mean(sums))
    return fine + (fine - coarse) / 3.0, largest


def distinct(points: Array) -> Array:
    """Return the way-points without repetitions.

    A step far shorter than the others is left out, too: its direction is noise.
    """
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"way-points have the shape {points.shape}, expected (n, 3)")
    if not np.all(np.isfinite(points)):
        raise ValueError("way-points must be finite")
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1) if len(points) else np.zeros(0)
    if not np.any(steps > 0.0):
        raise ValueError("a route needs at least two different way-points")
    moved = steps > _SHORTEST_STEP * np.median(steps[steps > 0.0])
    route: Array = points[np.append(True, moved)]
    return route


def _sum_of_turns(route: Array, selected: npt.NDArray[np.int_]) -> tuple[float, float]:
    """Return the turns of the polygon through selected way-points, and the largest, rad.

    The ends of the polygon are extended to the whole route.
    """
    chords = np.diff(route[selected], axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    turns = _angles(chords[:-1], chords[1:])
    if not len(turns):
        return 0.0, 0.0
    spans = (lengths[:-1] + lengths[1:]) / 2.0
    steps = np.linalg.norm(np.diff(route, axis=0), axis=1)
    before = steps[: selected[0]].sum()
    after = steps[selected[-1] :].sum()
    start = turns[0] / spans[0] * (lengths[0] / 2.0 + before)
    end = turns[-1] / spans[-1] * (lengths[-1] / 2.0 + after)
    return float(turns.sum() + start + end), float(turns.max())


def _angles(first: Array, second: Array) -> Array:
    """Return angles between vectors, (n, 3), precise where small and where nearly pi, rad."""
    across = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.arctan2(across, np.sum(first * second, axis=1)))
