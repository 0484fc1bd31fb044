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


def arc(angle, count=50, radius=0.2, at=None):
    turn = angle * (np.linspace(0, 1, count) if at is None else at)
    return radius * np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])


def helix(pitch, count=50, radius=0.05, turns=1.0, at=None):
    turn = 2 * np.pi * turns * (np.linspace(0, 1, count) if at is None else at)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), pitch * turn / (2 * np.pi)])


def bend_of_helix(pitch, radius=0.05, turns=1.0):
    return 2 * np.pi * turns * radius / np.hypot(radius, pitch / (2 * np.pi))


def wave(count=50, at=None):
    """Half a metre of cable in one period of a sine that swings by 6 cm, with two points of inflection inside."""
    along = 0.5 * (np.linspace(0, 1, count) if at is None else at)
    return np.column_stack([along, 0.06 * np.cos(4 * np.pi * along), np.zeros_like(along)])


BEND_OF_WAVE = 4 * np.arctan(0.06 * 4 * np.pi)


# --- Known curves ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [2, 3, 5, 6, 7, 8, 50])
def test_a_straight_line_has_no_bend(count):
    found = total_curvature(np.outer(np.linspace(0, 1, count), [0.3, -0.7, 0.2]) + np.array([1.0, 2.0, 3.0]))
    assert found[0] == pytest.approx(0.0, abs=1e-12)
    assert found[1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("degrees", [1, 10, 45, 90, 144, 180, 270, 359])
def test_a_planar_arc_bends_by_its_angle(degrees):
    found = total_curvature(arc(np.radians(degrees)))
    assert found[0] == pytest.approx(np.radians(degrees), rel=PERMILLE / 10)


@pytest.mark.parametrize("pitch", [0.0, 0.01, 0.05, 0.1, 0.3, 1.0, 3.0])
def test_a_helix_of_one_turn_is_measured_to_a_thousandth(pitch):
    found = total_curvature(helix(pitch))
    assert found[0] == pytest.approx(bend_of_helix(pitch), rel=PERMILLE)


@pytest.mark.parametrize("count", [3, 4, 5, 6, 7, 8])
@pytest.mark.parametrize("degrees", [20, 90, 150])
def test_few_points_on_an_arc_are_enough(count, degrees):
    found = total_curvature(arc(np.radians(degrees), count))
    assert found[0] == pytest.approx(np.radians(degrees), rel=1e-12 if count < 7 else 2 * PERMILLE)
    assert found[1] == pytest.approx(np.radians(degrees) / (count - 1), rel=1e-9)


def test_an_s_of_two_arcs_adds_both_bends():
    first = arc(np.pi / 2, 60)
    second = first[-1] * 2 - first[-2::-1]
    assert total_curvature(np.vstack([first, second]))[0] == pytest.approx(np.pi, rel=0.03)


def test_a_route_with_inflections_counts_bends_to_both_sides():
    assert total_curvature(wave(200))[0] == pytest.approx(BEND_OF_WAVE, rel=0.01)


def test_a_curve_of_changing_curvature_and_torsion_is_measured():
    """The twisted cubic (t, t², t³)."""

    def rate(t):
        first, second = np.array([1.0, 2 * t, 3 * t * t]), np.array([0.0, 2.0, 6 * t])
        return np.linalg.norm(np.cross(first, second)) / (first @ first)

    t = np.linspace(0, 1, 50)
    found = total_curvature(np.column_stack([t, t**2, t**3]))
    assert found[0] == pytest.approx(quad(rate, 0, 1)[0], rel=2 * PERMILLE)


def test_more_points_bring_a_helix_closer():
    errors = [abs(total_curvature(helix(0.3, count))[0] / bend_of_helix(0.3) - 1) for count in (12, 24, 48, 96)]
    assert all(finer < 0.3 * coarser for coarser, finer in pairwise(errors))


# --- Uneven and repeated points --------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_points_anywhere_on_an_arc_will_do(seed):
    at = np.sort([0.0, *np.random.default_rng(seed).random(48), 1.0])
    assert total_curvature(arc(np.pi, at=at))[0] == pytest.approx(np.pi, rel=PERMILLE)


def test_steps_that_alternate_between_long_and_short_are_not_taken_for_noise():
    at = np.cumsum(np.tile([1.0, 5.0], 25))
    found = total_curvature(arc(np.pi, at=(at - at[0]) / (at[-1] - at[0])))
    assert found[0] == pytest.approx(np.pi, rel=PERMILLE)


@pytest.mark.parametrize("count", [20, 50, 200])
def test_a_bend_between_two_straight_parts_is_found_whole(count):
    """0.3 m straight, a quarter of a circle of 0.1 m, 0.3 m straight."""
    along = np.linspace(0, 0.6 + 0.05 * np.pi, count)
    turn = np.clip((along - 0.3) / 0.1, 0, np.pi / 2)
    before, after = np.minimum(along, 0.3), np.maximum(along - 0.3 - 0.05 * np.pi, 0)
    route = np.column_stack([before + 0.1 * np.sin(turn), 0.1 - 0.1 * np.cos(turn) + after, 0 * along])
    assert total_curvature(route)[0] == pytest.approx(np.pi / 2, rel=1e-12)


def test_a_part_sampled_ten_times_as_densely_does_not_count_for_more():
    share = np.concatenate([np.linspace(0, 0.5, 40, endpoint=False), np.linspace(0.5, 1, 401)])
    assert total_curvature(arc(np.pi, at=share))[0] == pytest.approx(np.pi, rel=PERMILLE)


@given(st.lists(st.integers(0, 19), max_size=12))
def test_repeated_points_change_nothing(places):
    route = helix(0.1, 20)
    repeated = np.repeat(route, 1 + np.bincount(places, minlength=20), axis=0)
    assert total_curvature(repeated) == total_curvature(route)


# --- Symmetries ------------------------------------------------------------------------------------------------------

ROUTES = st.integers(0, 10_000).map(
    lambda seed: np.cumsum(np.random.default_rng(seed).normal([1.0, 0, 0], 0.4, (4 + seed % 30, 3)), axis=0)
)


@given(ROUTES, st.integers(0, 1000), st.floats(1e-4, 1e4))
def test_neither_unit_nor_frame_nor_direction_of_a_route_counts(route, seed, unit):
    rng = np.random.default_rng(seed)
    moved = unit * Rotation.random(rng=rng).apply(route) + rng.normal(0, 10.0, 3)
    for other in (moved, route[::-1], route * [1, 1, -1]):
        assert total_curvature(other) == pytest.approx(total_curvature(route), rel=1e-9)


# --- Corners ---------------------------------------------------------------------------------------------------------


def test_a_corner_is_the_largest_turn():
    corner = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [2, 2, 0]]
    assert total_curvature(corner)[1] == pytest.approx(np.pi / 2)


def test_a_reversal_is_a_turn_of_half_a_circle():
    assert total_curvature([[0, 0, 0], [1, 0, 0], [0, 0, 0]])[1] == np.pi


# --- What is no route ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("points", [np.zeros((5, 2)), np.zeros(3), np.zeros((2, 5, 3)), np.zeros((3, 4)), []])
def test_points_that_are_not_in_space_are_refused(points):
    with pytest.raises(ValueError, match="shape"):
        total_curvature(points)


@pytest.mark.parametrize("count", [0, 1, 2, 10])
def test_a_route_that_never_leaves_its_first_point_is_refused(count):
    with pytest.raises(ValueError, match="two different"):
        total_curvature(np.ones((count, 3)))
