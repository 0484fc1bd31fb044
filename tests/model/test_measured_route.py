"""The bend of a route from way-points that scatter lies within twice its standard error.

So it is for every kind of route.
"""

from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tendon_cli.model.route import measured_route, noise_of
from tests.sampled import check_all


def resampled(fine, spacing, rng):
    """Return way-points about `spacing` apart along a finely sampled route, with both ends."""
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1)))
    chosen = np.linspace(0.0, along[-1], round(along[-1] / spacing) + 1)
    chosen[1:-1] += rng.uniform(-0.2, 0.2, len(chosen) - 2) * spacing
    return np.column_stack([np.interp(chosen, along, fine[:, axis]) for axis in range(3)])


# Each route is sampled finely, (points, 3) in m, and comes with its bend in rad.


def helix():
    turn = np.linspace(0.0, 6.0 * np.pi, 20_001)
    points = np.column_stack([0.1 * np.cos(turn), 0.1 * np.sin(turn), 0.03 * turn])
    return points, 6.0 * np.pi * 0.1 / np.hypot(0.1, 0.03)


def arc():
    turn = np.linspace(0.0, np.pi, 20_001)
    points = 0.25 * np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    return points, np.pi


def arcs():
    """Return a quarter and a third of a circle in two planes, with straight parts around them."""
    straight = np.linspace(0.0, 0.3, 3000)[1:, np.newaxis]
    heading = np.array([1.0, 0.0, 0.0])
    parts = [np.zeros((1, 3))]
    for radius, angle, towards in (
        (0.1, np.pi / 2, [0, 1, 0]),
        (0.15, 2 * np.pi / 3, [0.1, 0, 1]),
    ):
        parts.append(parts[-1][-1] + straight * heading)
        inward = np.array(towards) - np.dot(towards, heading) * heading
        inward /= np.linalg.norm(inward)
        turn = np.linspace(0.0, angle, 3000)[1:, np.newaxis]
        circle = np.sin(turn) * heading + (1.0 - np.cos(turn)) * inward
        parts.append(parts[-1][-1] + radius * circle)
        heading = np.cos(angle) * heading + np.sin(angle) * inward
    parts.append(parts[-1][-1] + straight * heading)
    return np.vstack(parts), np.pi / 2 + 2 * np.pi / 3


def corners():
    ends = np.array([[0, 0, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0.5, 0.5, 0.5], [0.9, 0.7, 0.9]])
    steps = np.diff(ends, axis=0)
    headings = steps / np.linalg.norm(steps, axis=1)[:, np.newaxis]
    turns = np.arccos(np.sum(headings[1:] * headings[:-1], axis=1))
    share = np.linspace(0, 1, 4000, endpoint=False)[:, np.newaxis]
    parts = [first + share * (last - first) for first, last in pairwise(ends)]
    return np.vstack([*parts, ends[-1:]]), float(turns.sum())


def line():
    along = np.linspace(0.0, 1.5, 5001)[:, np.newaxis]
    return along * np.array([[0.6, 0.8, 0.0]]), 0.0


ROUTES = {"helix": helix, "arc": arc, "arcs": arcs, "corners": corners, "line": line}
SPACINGS = (0.005, 0.015, 0.05)
NOISES = (0.0, 0.2e-3, 0.5e-3, 1e-3, 2e-3)


def drawn(name, spacing, noise, draws, seed=0):
    """Return errors and standard errors of routes drawn, each of shape (draws,), rad."""
    fine, truth = ROUTES[name]()
    number = list(ROUTES).index(name)
    rng = np.random.default_rng([seed, number, round(1e6 * spacing), round(1e6 * noise)])
    errors = np.empty(draws)
    standard_errors = np.empty(draws)
    for draw in range(draws):
        points = resampled(fine, spacing, rng)
        route = measured_route(points + rng.normal(0.0, 1.0, points.shape) * noise)
        errors[draw] = route.bend_angle - truth
        standard_errors[draw] = route.standard_error
    return errors, standard_errors


def within_twice(errors, standard_errors):
    """Return True where an error is within twice the standard error."""
    return np.abs(errors) <= 2.0 * standard_errors + 1e-9


def test_the_truth_lies_within_twice_the_standard_error():
    def check(name, spacing, noise):
        errors, standard_errors = drawn(name, spacing, noise, 3)
        assert np.sum(within_twice(errors, standard_errors)) >= 2
        assert np.mean(standard_errors) < np.radians(25.0)

    check_all(check, product(ROUTES, SPACINGS, NOISES))


@pytest.mark.torture
@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("spacing", SPACINGS)
@pytest.mark.parametrize("name", ROUTES)
def test_the_truth_lies_within_twice_the_standard_error_in_nine_of_ten_draws(name, spacing, noise):
    errors, standard_errors = drawn(name, spacing, noise, 100, seed=1)
    # 0.9 within three standard errors of 1500 draws
    assert np.mean(within_twice(errors, standard_errors)) >= 0.88


@pytest.mark.parametrize("noise", [0.2e-3, 1e-3, 2e-3])
@pytest.mark.parametrize("name", ROUTES)
def test_the_noise_is_found_from_the_points(name, noise):
    rng = np.random.default_rng(5)
    fine, _ = ROUTES[name]()
    points = resampled(fine, 0.01, rng)
    assert noise_of(points + rng.normal(0.0, noise, points.shape)) == pytest.approx(noise, rel=0.25)


def scattered_arc(spacing, rng):
    """Return way-points along the arc that scatter by 1 mm."""
    fine, _ = arc()
    points = resampled(fine, spacing, rng)
    return points + rng.normal(0.0, 1e-3, points.shape)


@given(st.integers(0, 1000), st.floats(1e-3, 1e3))
@settings(max_examples=40)
def test_neither_the_unit_nor_the_frame_nor_the_end_counts(seed, unit):
    rng = np.random.default_rng(seed)
    points = scattered_arc(0.02, rng)
    turned = Rotation.random(rng=rng).apply(points[::-1])
    moved = measured_route(unit * (turned + rng.normal(0.0, 1.0, 3)))
    route = measured_route(points)
    assert moved.bend_angle == pytest.approx(route.bend_angle, rel=1e-6)
    assert moved.standard_error == pytest.approx(route.standard_error, rel=1e-6)
    assert moved.noise == pytest.approx(unit * route.noise, rel=1e-6)


def test_half_of_the_noise_stated_changes_nothing_and_more_of_it_is_taken():
    points = scattered_arc(0.005, np.random.default_rng(2))
    assert measured_route(points, 0.5e-3) == measured_route(points)
    assert measured_route(points, 2e-3).standard_error >= measured_route(points).standard_error


@pytest.mark.parametrize("angle", [10, 45, 90, 144])
def test_a_corner_of_three_points_is_no_arc_unless_that_is_within_its_error(angle):
    turn = np.radians(angle)
    route = measured_route(np.array([[0, 0, 0], [1, 0, 0], [1 + np.cos(turn), np.sin(turn), 0]]))
    as_arc = 2.0 * turn
    expected = turn if turn > 0.5 else as_arc
    assert route.bend_angle == pytest.approx(expected)
    assert within_twice(route.bend_angle - turn, route.standard_error)
    assert within_twice(route.bend_angle - as_arc, route.standard_error)
