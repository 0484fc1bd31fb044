"""The bend of a route from way-points that scatter: within twice its standard error, whatever the route."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tendon_cli.model.route import measured_route, noise_of


def resampled(fine, spacing, rng):
    """Way-points about `spacing` apart along a finely sampled route, its ends included."""
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1)))
    at = np.linspace(0.0, along[-1], round(along[-1] / spacing) + 1)
    at[1:-1] += rng.uniform(-0.2, 0.2, len(at) - 2) * spacing
    return np.column_stack([np.interp(at, along, fine[:, axis]) for axis in range(3)])


def helix():
    turn = np.linspace(0.0, 6.0 * np.pi, 20_001)
    points = np.column_stack([0.1 * np.cos(turn), 0.1 * np.sin(turn), 0.03 * turn])
    return points, 6.0 * np.pi * 0.1 / np.hypot(0.1, 0.03)


def arc():
    turn = np.linspace(0.0, np.pi, 20_001)
    return 0.25 * np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn]), np.pi


def arcs():
    """Straight, a quarter of a circle, straight, a third of a circle in another plane, straight."""
    parts, heading = [np.zeros((1, 3))], np.array([1.0, 0.0, 0.0])
    for radius, angle, towards in (
        (0.1, np.pi / 2, [0, 1, 0]),
        (0.15, 2 * np.pi / 3, [0.1, 0, 1]),
        (0, 0, [0, 1, 0]),
    ):
        parts.append(parts[-1][-1] + np.linspace(0.0, 0.3, 3000)[1:, np.newaxis] * heading)
        inward = np.array(towards) - np.dot(towards, heading) * heading
        inward /= np.linalg.norm(inward)
        turn = np.linspace(0.0, angle, 3000)[1:, np.newaxis]
        if radius:
            parts.append(
                parts[-1][-1] + radius * (np.sin(turn) * heading + (1.0 - np.cos(turn)) * inward)
            )
        heading = np.cos(angle) * heading + np.sin(angle) * inward
    return np.vstack(parts), np.pi / 2 + 2 * np.pi / 3


def corners():
    ends = np.array([[0, 0, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0.5, 0.5, 0.5], [0.9, 0.7, 0.9]])
    ways = np.diff(ends, axis=0) / np.linalg.norm(np.diff(ends, axis=0), axis=1)[:, np.newaxis]
    share = np.linspace(0, 1, 4000, endpoint=False)[:, np.newaxis]
    fine = [first + share * (last - first) for first, last in pairwise(ends)]
    return np.vstack([*fine, ends[-1:]]), float(
        np.arccos(np.sum(ways[1:] * ways[:-1], axis=1)).sum()
    )


def line():
    return np.linspace(0.0, 1.5, 5001)[:, np.newaxis] * np.array([[0.6, 0.8, 0.0]]), 0.0


ROUTES = {"helix": helix, "arc": arc, "arcs": arcs, "corners": corners, "line": line}
SPACINGS = (0.005, 0.015, 0.05)
NOISES = (0.0, 0.2e-3, 0.5e-3, 1e-3, 2e-3)


def drawn(name, spacing, noise, draws, seed=0):
    """Errors and standard errors of routes drawn, each of shape (draws,), rad."""
    fine, truth = ROUTES[name]()
    rng = np.random.default_rng(
        [seed, list(ROUTES).index(name), round(1e6 * spacing), round(1e6 * noise)]
    )
    found = []
    for _ in range(draws):
        points = resampled(fine, spacing, rng)
        found.append(measured_route(points + rng.normal(0.0, 1.0, points.shape) * noise))
    return np.array([route.bend_angle - truth for route in found]), np.array(
        [route.standard_error for route in found]
    )


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("name", ROUTES)
def test_the_truth_lies_within_twice_the_standard_error(name, spacing, noise):
    errors, standard = drawn(name, spacing, noise, 6)
    assert np.sum(np.abs(errors) <= 2.0 * standard + 1e-9) >= 4
    assert np.mean(standard) < np.radians(25.0)


@pytest.mark.torture
@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("name", ROUTES)
def test_the_truth_lies_within_twice_the_standard_error_in_nine_of_ten_draws(name, spacing, noise):
    errors, standard = drawn(name, spacing, noise, 100, seed=1)
    assert (
        np.mean(np.abs(errors) <= 2.0 * standard + 1e-9) >= 0.88
    )  # 0.9 within three standard errors of 1500 draws


@pytest.mark.parametrize("noise", [0.2e-3, 1e-3, 2e-3])
@pytest.mark.parametrize("name", ROUTES)
def test_the_noise_is_found_from_the_points(name, noise):
    rng = np.random.default_rng(5)
    points = resampled(ROUTES[name]()[0], 0.01, rng)
    assert noise_of(points + rng.normal(0.0, noise, points.shape)) == pytest.approx(noise, rel=0.25)


@given(st.integers(0, 1000), st.floats(1e-3, 1e3))
@settings(max_examples=40)
def test_neither_the_unit_nor_the_frame_nor_the_end_counts(seed, unit):
    rng = np.random.default_rng(seed)
    points = resampled(arc()[0], 0.02, rng)
    points += rng.normal(0.0, 1e-3, points.shape)
    moved = unit * (Rotation.random(rng=rng).apply(points[::-1]) + rng.normal(0.0, 1.0, 3))
    first, second = measured_route(points), measured_route(moved)
    assert second.bend_angle == pytest.approx(first.bend_angle, rel=1e-6)
    assert second.standard_error == pytest.approx(first.standard_error, rel=1e-6)
    assert second.noise == pytest.approx(unit * first.noise, rel=1e-6)


def test_half_of_the_noise_stated_changes_nothing_and_more_of_it_is_taken():
    rng = np.random.default_rng(2)
    points = resampled(arc()[0], 0.005, rng)
    points += rng.normal(0.0, 1e-3, points.shape)
    assert measured_route(points, 0.5e-3) == measured_route(points)
    assert measured_route(points, 2e-3).standard_error >= measured_route(points).standard_error


@pytest.mark.parametrize("angle", [10, 45, 90, 144])
def test_a_corner_of_three_points_is_no_arc_unless_that_is_within_its_error(angle):
    turn = np.radians(angle)
    found = measured_route(np.array([[0, 0, 0], [1, 0, 0], [1 + np.cos(turn), np.sin(turn), 0]]))
    as_arc = 2.0 * turn
    assert found.bend_angle == pytest.approx(turn if turn > 0.5 else as_arc)
    assert abs(found.bend_angle - turn) <= 2.0 * found.standard_error + 1e-9
    assert abs(found.bend_angle - as_arc) <= 2.0 * found.standard_error + 1e-9
