"""The total curvature of a route from way-points that scatter, with its uncertainty.

Noise has curvature: the turns between the chords of noisy way-points add up to far more than the route bends. So the
direction of the route is taken by straight lines through windows of several way-points each, and the turns between
neighbouring windows are added up. In a plane, where a route bends to one side, their sum does not depend on the length
of the windows; turns that the scatter explains are taken for none, and what such turns add on average is taken off.
Of all lengths the one with the least expected error is used. A window of one step is the sum of turns as it stands.
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
_ORDERS = range(2, 8)
# A turn by noise alone, of two components of variance v: its square is beyond 4v for e^-2 of them.
_SIGNIFICANT = 4.0
_MISSED = 1.0 - math.exp(-2.0)
_LEFT = 0.2977  # mean of sqrt(θ² - v), counted where θ² > 4v, in units of sqrt(v)
_MEDIANS = {2: 1.386, 3: 2.366}  # of chi-squared
_LEAST_OF_SEVERAL = 1.06  # the least of several estimates of one noise is this much too small
_CORNER = 0.5  # rad
_TURNS_SHOW = 0.02  # rad²; where noise makes larger turns than this no single one stands out
_LEAST_ERROR, _UNKNOWN_LOSS = 0.003, 0.1  # shares of the bend


@dataclass(frozen=True)
class MeasuredRoute:
    """What way-points tell of a route; angles in rad, lengths in m."""

    bend_angle: float
    """∫κ ds over the whole route."""
    standard_error: float
    """Of the bend angle; twice as much covers the truth in nine of ten routes or more."""
    as_it_stands: float
    """The sum of turns without regard to noise."""
    noise: float | None
    """Standard deviation of each coordinate of the way-points as the points show; None where they are too few."""
    largest_turn: float
    """Largest turn at one way-point that noise does not explain; above about 0.5 the route is sampled coarsely."""


def measured_route(points: Array, stated_noise: float | None = None) -> MeasuredRoute:
    """Total curvature of way-points of shape (n, 3) in m, of which the noise is known or estimated.

    Of the noise that is stated and the estimated one the larger counts. Raises ValueError for fewer than two
    different way-points.
    """
    route = distinct(np.asarray(points, dtype=np.float64))
    raw, turn = total_curvature(route)
    if len(route) < FEWEST:
        return _of_few(route, raw, turn)
    measured = noise_of(route)
    noise = max(measured, stated_noise or 0.0)
    scales = {length: _at_scale(route, length, noise) for length in _lengths(len(route))}
    first = scales[1]
    if first.variance < 1e-6:  # way-points of no noise to speak of: every turn counts
        return MeasuredRoute(
            raw, math.hypot(_LEAST_ERROR * raw, _correction(scales, 1)[1]), raw, measured, turn
        )
    bend_angle, error = min(
        (_with_error(scales, length) for length in scales), key=lambda pair: pair[1]
    )
    largest = first.largest if first.variance < _TURNS_SHOW else 0.0
    return MeasuredRoute(bend_angle, error, raw, measured, largest)


def _of_few(route: Array, bend_angle: float, largest: float) -> MeasuredRoute:
    """Of a few way-points: an arc bends up to its ends, a corner does not; what that makes is the uncertainty."""
    chords = np.diff(route, axis=0)
    turns = _angles(chords[:-1], chords[1:])
    ends = bend_angle - float(turns.sum())
    counted = 0.0 if largest > _CORNER else ends
    error = math.hypot(0.5 * ends, _LEAST_ERROR * bend_angle)
    return MeasuredRoute(float(turns.sum()) + counted, error, bend_angle, None, largest)


def noise_of(route: Array) -> float:
    """Standard deviation of the noise in each coordinate of way-points, m.

    Divided differences of order m leave noise and remove a polynomial of lower order. Their median does not notice a
    few corners; of several orders, by number and by chord length, the least counts: none is below the noise.
    """
    chords = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1)))
    estimates = []
    for along, components in ((np.arange(len(route), dtype=np.float64), 3), (chords, 2)):
        for order in _ORDERS:
            if len(route) < 2 * order + 5:
                break
            windows = np.arange(len(route) - order)[:, np.newaxis] + np.arange(order + 1)
            at = along[windows] - along[windows[:, :1]]
            gaps = (at[:, :, np.newaxis] - at[:, np.newaxis, :]) / at[:, -1:, np.newaxis]
            gaps[:, np.arange(order + 1), np.arange(order + 1)] = 1.0
            weights = 1.0 / np.prod(gaps, axis=2)
            weights /= np.linalg.norm(weights, axis=1)[:, np.newaxis]
            left = np.einsum("ij,ijk->ik", weights, route[windows])
            estimates.append(
                math.sqrt(float(np.median(np.sum(left**2, axis=1))) / _MEDIANS[components])
            )
    return _LEAST_OF_SEVERAL * min(estimates, default=0.0)


@dataclass(frozen=True)
class _Scale:
    """Sum of turns between windows of one length, averaged over where the first one starts."""

    total: float
    scatter: float
    """Variance of the total by noise and by what its ends leave open, rad²."""
    taken_off: float
    """What noise adds on average, rad."""
    variance: float
    """Of one component of a turn by noise, rad²."""
    largest: float


def _lengths(count: int) -> list[int]:
    """Lengths of windows in steps, each about half as long again as the one before."""
    lengths = [1]
    while (count - 1) // (
        longer := max(lengths[-1] + 1, int(1.5 * lengths[-1]))
    ) >= _FEWEST_WINDOWS:
        lengths.append(longer)
    return lengths


def _with_error(scales: dict[int, _Scale], length: int) -> tuple[float, float]:
    """The total at a scale, extrapolated to windows of no length, and its expected error."""
    scale, (correction, lost) = scales[length], _correction(scales, length)
    parts = (
        1.5 * scale.scatter,
        (0.5 * scale.taken_off) ** 2,
        lost**2,
        (_LEAST_ERROR * scale.total) ** 2,
    )
    return max(0.0, scale.total + correction), math.sqrt(sum(parts))


def _correction(scales: dict[int, _Scale], length: int) -> tuple[float, float]:
    """What windows of this length lose, from those about twice as long (Richardson: it is of second order).

    First what is to be added, then how large it may be; where there are no longer windows that is not known.
    """
    total = scales[length].total
    longer = min(scales, key=lambda other: abs(math.log(other / (2.0 * length))))
    if longer <= length:
        return 0.0, _UNKNOWN_LOSS * total
    lost = (total - scales[longer].total) / ((longer / length) ** 2 - 1.0)
    return (lost if abs(lost) <= 2.0 * _UNKNOWN_LOSS * total else 0.0), abs(lost)


def _at_scale(route: Array, length: int, noise: float) -> _Scale:
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1)))
    offsets = np.unique(np.linspace(0, length - 1, min(length, _MOST_OFFSETS)).astype(int))
    scales = [_from(route, along, length, int(offset), noise) for offset in offsets]
    total, scatter, taken_off, variance = np.mean(
        [[s.total, s.scatter, s.taken_off, s.variance] for s in scales], axis=0
    )
    largest = max(scale.largest for scale in scales)
    return _Scale(float(total), float(scatter), float(taken_off), float(variance), largest)


def _from(route: Array, along: Array, length: int, offset: int, noise: float) -> _Scale:
    """The sum of turns between windows of `length` steps, the first of which starts at `offset`."""
    count = (len(route) - 1 - offset) // length
    windows = offset + np.arange(count)[:, np.newaxis] * length + np.arange(length + 1)
    centres = along[windows].mean(axis=1)
    arms = along[windows] - centres[:, np.newaxis]
    weights = arms / np.sum(arms**2, axis=1)[:, np.newaxis]
    slopes = np.einsum("ij,ijk->ik", weights, route[windows])
    weights /= np.linalg.norm(slopes, axis=1)[:, np.newaxis]
    turns = _angles(slopes[:-1], slopes[1:])
    each = np.sum(weights**2, axis=1)
    variances = noise**2 * (
        each[:-1] + each[1:] - 2.0 * weights[:-1, -1] * weights[1:, 0]
    )  # they share a way-point
    counts = turns**2 > _SIGNIFICANT * variances
    real = np.where(counts, np.sqrt(np.maximum(turns**2 - variances, 0.0)), 0.0)
    idle = min(1.0, float(np.mean(~counts)) / _MISSED) if noise > 0.0 else 0.0
    taken_off = idle * _LEFT * float(np.sum(np.sqrt(variances)))
    ends = [
        _end(real[:3] / np.diff(centres)[:3], centres[0] - along[0]),
        _end(real[:-4:-1] / np.diff(centres)[:-4:-1], along[-1] - centres[-1]),
    ]
    variance = float(np.mean(variances))
    scatter = variance * (1.5 + 0.5 * len(turns) * idle) + sum(error**2 for _, error in ends)
    total = max(0.0, float(real.sum()) - taken_off) + sum(bend for bend, _ in ends)
    certain = turns**2 > 2.0 * variances * (
        math.log(len(turns)) + 5.0
    )  # noise alone hardly makes one of so many
    return _Scale(total, scatter, taken_off, variance, float(real[certain].max(initial=0.0)))


def _end(curvatures: Array, distance: float) -> tuple[float, float]:
    """How much a route bends between its end and the window next to it, and how uncertain that is.

    Where the turns next to the end are alike it goes on as they do; where they are not there may be a corner.
    """
    mean, least = float(curvatures.mean()), float(curvatures.min())
    if len(curvatures) > 1 and least >= 0.5 * mean:
        return mean * distance, float(curvatures.std()) / math.sqrt(len(curvatures)) * distance
    return least * distance * (len(curvatures) > 1), 0.5 * (
        mean - least * (len(curvatures) > 1)
    ) * distance


def total_curvature(points: npt.ArrayLike) -> tuple[float, float]:
    """Total curvature ∫κ ds of way-points that do not scatter, (n, 3) in m, n ≥ 2, and their largest turn, rad.

    The turns between successive chords are summed, the half chords at both ends counted with the curvature next to
    them, and the sum is extrapolated from chords of one and of two steps (Richardson), which removes the error of
    second order. Raises ValueError for fewer than two distinct points.
    """
    route = distinct(np.asarray(points, dtype=np.float64))
    fine, largest = _sum_of_turns(route, np.arange(len(route)))
    if len(route) < FEWEST:
        return fine, largest
    coarse = float(
        np.mean([_sum_of_turns(route, np.arange(first, len(route), 2))[0] for first in (0, 1)])
    )
    return fine + (fine - coarse) / 3.0, largest


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
    turns = _angles(chords[:-1], chords[1:])
    if not len(turns):
        return 0.0, 0.0
    spans = (lengths[:-1] + lengths[1:]) / 2.0
    steps = np.linalg.norm(np.diff(route, axis=0), axis=1)
    before, after = steps[: chosen[0]].sum(), steps[chosen[-1] :].sum()
    start = turns[0] / spans[0] * (lengths[0] / 2.0 + before)
    end = turns[-1] / spans[-1] * (lengths[-1] / 2.0 + after)
    return float(turns.sum() + start + end), float(turns.max())


def _angles(first: Array, second: Array) -> Array:
    """Angles between vectors of shape (n, 3), precise where they are small and where they are nearly pi."""
    across = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.arctan2(across, np.sum(first * second, axis=1)))
