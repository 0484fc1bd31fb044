"""The total curvature of a route through space from its way-points."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from tendon_cli.model.route import total_curvature

PERMILLE = 1e-3
HALF_TURN = np.radians(180)
HELIX_RADIUS = 0.05  # m


def arc(angle, count=50):
    return uneven_arc(angle, np.linspace(0, 1, count))


def uneven_arc(angle, shares):
    """Return an arc with way-points at shares of its length."""
    turn = angle * shares
    return 0.2 * np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])


def helix(pitch, count=50):
    turn = 2 * np.pi * np.linspace(0, 1, count)
    height = pitch * turn / (2 * np.pi)
    return np.column_stack([HELIX_RADIUS * np.cos(turn), HELIX_RADIUS * np.sin(turn), height])


def bend_of_helix(pitch):
    return 2 * np.pi * HELIX_RADIUS / np.hypot(HELIX_RADIUS, pitch / (2 * np.pi))


def line(count):
    return np.outer(np.linspace(0, 1, count), [0.3, -0.7, 0.2]) + np.array([1.0, 2.0, 3.0])


def wave(count):
    """Return half a metre along one period of a sine that swings by 6 cm.

    It has two points of inflection inside.
    """
    along = np.linspace(0, 0.5, count)
    return np.column_stack([along, 0.06 * np.cos(4 * np.pi * along), 0 * along])


def corner(count):
    """Return 0.3 m straight, a quarter of a circle of 0.1 m, and 0.3 m straight."""
    along = np.linspace(0, 0.6 + 0.05 * np.pi, count)
    turn = np.clip((along - 0.3) / 0.1, 0, np.pi / 2)
    before = np.minimum(along, 0.3)
    after = np.maximum(along - 0.3 - 0.05 * np.pi, 0)
    forward = before + 0.1 * np.sin(turn)
    up = 0.1 - 0.1 * np.cos(turn) + after
    return np.column_stack([forward, up, 0 * along])


def twisted(count):
    """Return (t, t², t³), whose curvature and torsion change."""
    t = np.linspace(0, 1, count)
    return np.column_stack([t, t**2, t**3])


def rate_of_twisted(t):
    first = np.array([1.0, 2 * t, 3 * t * t])
    second = np.array([0.0, 2.0, 6 * t])
    return np.linalg.norm(np.cross(first, second)) / (first @ first)


def half_turn(steps):
    """Return half a circle whose way-points are steps of these relative lengths apart."""
    return uneven_arc(HALF_TURN, shares_of(steps))


def shares_of(steps):
    """Return way-points that are steps of these lengths apart, as shares of the whole."""
    along = np.append(0.0, np.cumsum(steps))
    return along / along[-1]


CURVES = {
    **{f"line {n}": (line(n), 0.0, 0.0) for n in (2, 3, 7, 50)},
    **{f"arc {d}": (arc(np.radians(d)), np.radians(d), PERMILLE / 10) for d in (1, 90, 144, 359)},
    **{f"arc 90 by {n}": (arc(np.pi / 2, n), np.pi / 2, 1e-12) for n in range(3, 7)},
    **{f"arc 90 by {n}": (arc(np.pi / 2, n), np.pi / 2, 2 * PERMILLE) for n in (7, 8)},
    **{f"helix {p}": (helix(p), bend_of_helix(p), PERMILLE) for p in (0.0, 0.05, 0.3, 3.0)},
    **{f"corner {n}": (corner(n), np.pi / 2, 1e-12) for n in (20, 50, 200)},
    "wave": (wave(200), 4 * np.arctan(0.06 * 4 * np.pi), 0.01),
    "twisted cubic": (twisted(50), quad(rate_of_twisted, 0, 1)[0], 2 * PERMILLE),
    "uneven steps": (half_turn(np.tile([1.0, 5.0], 25)), HALF_TURN, PERMILLE),
    "random steps": (half_turn(np.random.default_rng(0).random(50)), HALF_TURN, PERMILLE),
    "a dense half": (half_turn(np.repeat([10.0, 1.0], [40, 400])), HALF_TURN, PERMILLE),
}
"""Way-points of a curve, its bend in rad, and the share by which the result may be off."""


@pytest.mark.parametrize("name", CURVES)
def test_known_curves_bend_by_what_they_do(name):
    points, bend, share = CURVES[name]
    assert total_curvature(points)[0] == pytest.approx(bend, rel=share, abs=1e-12)


def test_more_points_bring_a_helix_closer():
    bends = [total_curvature(helix(0.3, count))[0] for count in (12, 24, 48, 96)]
    errors = [abs(bend / bend_of_helix(0.3) - 1) for bend in bends]
    for coarser, finer in pairwise(errors):
        assert finer < 0.3 * coarser


@pytest.mark.parametrize(
    ("points", "turn"),
    [
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [2, 2, 0]], np.pi / 2),
        ([[0, 0, 0], [1, 0, 0], [0, 0, 0]], np.pi),
        (arc(np.pi / 2, 6), np.pi / 10),
    ],
)
def test_the_largest_turn_at_one_way_point(points, turn):
    assert total_curvature(points)[1] == pytest.approx(turn)


@given(st.lists(st.integers(0, 19), max_size=12))
def test_repeated_points_change_nothing(places):
    route = helix(0.1, 20)
    repeated = np.repeat(route, 1 + np.bincount(places, minlength=20), axis=0)
    assert total_curvature(repeated) == total_curvature(route)


def random_route(seed):
    rng = np.random.default_rng(seed)
    steps = rng.normal([1.0, 0, 0], 0.4, (4 + seed % 30, 3))
    return np.cumsum(steps, axis=0)


@given(st.integers(0, 10_000).map(random_route), st.integers(0, 1000), st.floats(1e-4, 1e4))
def test_neither_unit_nor_frame_nor_direction_of_a_route_counts(route, seed, unit):
    rng = np.random.default_rng(seed)
    moved = unit * Rotation.random(rng=rng).apply(route) + rng.normal(0, 10.0, 3)
    reverse = route[::-1]
    mirrored = route * [1, 1, -1]
    for same in (moved, reverse, mirrored):
        assert total_curvature(same) == pytest.approx(total_curvature(route), rel=1e-9)


@pytest.mark.parametrize(
    ("points", "problem"),
    [
        (np.zeros((5, 2)), "shape"),
        (np.zeros((2, 5, 3)), "shape"),
        ([], "shape"),
        (np.ones((0, 3)), "two different"),
        (np.ones((10, 3)), "two different"),
    ],
)
def test_what_is_no_route_is_refused(points, problem):
    with pytest.raises(ValueError, match=problem):
        total_curvature(points)
