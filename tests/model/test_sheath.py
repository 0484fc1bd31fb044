"""Capstan friction and elongation of a tendon in its sheath (Eqs. 6 and 13, Appendix A)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tendon_cli.model.sheath import (
    TOWARD_ELBOW,
    TOWARD_MOTOR,
    capstan_ratio,
    elongation_slope,
    relative_elongation,
    tendon_compliance,
)

from .rig import even, walk_along_sheath

FRICTION = st.floats(0.0, 0.3)
BEND = st.floats(0.0, 12.0)
DIRECTIONS = st.sampled_from([TOWARD_MOTOR, TOWARD_ELBOW])
DIAMETER = 1.5e-3  # m
YOUNGS_MODULUS = 145e9  # Pa


def compliance(length, friction, bend, toward):
    """Return the compliance of a wire in its sheath."""
    return tendon_compliance(length, DIAMETER, YOUNGS_MODULUS, friction, bend, toward)


@pytest.mark.parametrize(
    "profile",
    [
        even,
        lambda s: 2 * s,
        lambda s: 3 * (1 - s) ** 2,
        lambda s: 1 + 0.9 * np.cos(6 * np.pi * s),
        lambda s: 1 + 0.8 * np.sin(2 * np.pi * s) - 0.1 * np.cos(10 * np.pi * s),
    ],
)
@pytest.mark.parametrize("toward", [TOWARD_MOTOR, TOWARD_ELBOW])
def test_only_the_total_bend_counts_for_the_ratio_however_it_is_spread(profile, toward):
    rng = np.random.default_rng(7)
    friction = rng.uniform(0, 0.3, 50)
    bend = rng.uniform(0, 12.0, 50)
    toward_elbow = np.full(50, toward == TOWARD_ELBOW)
    gain, mean = walk_along_sheath(friction, bend, toward_elbow, profile=profile)
    ratio = capstan_ratio(friction, bend, toward)
    np.testing.assert_allclose(ratio, 1 / gain, rtol=1e-11)
    assert (np.minimum(1.0, gain) <= mean * (1 + 1e-12)).all()
    assert (mean <= np.maximum(1.0, gain) * (1 + 1e-12)).all()


@pytest.mark.parametrize("toward", [TOWARD_MOTOR, TOWARD_ELBOW])
def test_an_even_bend_stretches_the_tendon_as_integrated(toward):
    rng = np.random.default_rng(8)
    friction = rng.uniform(0, 0.3, 50)
    bend = rng.uniform(0, 12.0, 50)
    length = rng.uniform(0.2, 4.0, 50)
    _, mean = walk_along_sheath(friction, bend, np.full(50, toward == TOWARD_ELBOW))
    straight = length / (np.pi * 0.75e-3**2 * 145e9)
    bent = compliance(length, friction, bend, toward)
    np.testing.assert_allclose(bent, mean * straight, rtol=1e-11)


@given(DIRECTIONS, st.floats(0.0, 5.0))
def test_without_friction_or_bend_the_tension_is_the_same_everywhere(toward, any_value):
    assert capstan_ratio(0.0, any_value, toward) == 1.0
    assert capstan_ratio(any_value, 0.0, toward) == 1.0
    straight = 2.0 / (np.pi * DIAMETER**2 / 4 * YOUNGS_MODULUS)
    assert compliance(2.0, 0.0, any_value, toward) == pytest.approx(straight, rel=1e-15)
    assert compliance(2.0, any_value, 0.0, toward) == pytest.approx(straight, rel=1e-15)


@pytest.mark.parametrize("exponent", [0.0, -0.0, 5e-324, -5e-324, 1e-300, 1e-17, -1e-17])
def test_without_an_exponent_the_relative_elongation_is_exactly_1(exponent):
    # Derivatives are taken by a complex step, for which NumPy divides in another way.
    with np.errstate(all="raise", under="ignore"):
        assert relative_elongation(exponent) == 1.0
        assert relative_elongation(complex(exponent)) == 1.0


@given(st.floats(-8.0, 8.0))
def test_the_relative_elongation_is_the_mean_of_the_exponential(z):
    nodes, weights = np.polynomial.legendre.leggauss(30)
    mean = float(weights @ np.exp(z * (nodes + 1) / 2)) / 2
    assert relative_elongation(z) == pytest.approx(mean, rel=1e-13)


@given(FRICTION, BEND, DIRECTIONS, st.floats(0.05, 0.95), st.floats(0.1, 4.0))
def test_a_sheath_cut_in_two_stretches_like_the_whole(friction, bend, toward, share, length):
    """The part at the motor feels the tension at the cut, which friction has changed."""
    near = compliance(share * length, friction, share * bend, toward)
    far = compliance((1 - share) * length, friction, (1 - share) * bend, toward)
    at_cut = 1 / capstan_ratio(friction, share * bend, toward)
    whole = compliance(length, friction, bend, toward)
    assert whole == pytest.approx(float(near + at_cut * far), rel=1e-13)


@given(st.lists(st.floats(-4.0, 4.0), min_size=1, max_size=8))
def test_the_slope_of_the_elongation_is_its_difference_wherever_it_is_summed(exponents):
    """Below 0.3 it is a series, beyond it a closed form; an array may have both."""
    z = np.array(exponents)
    slope = elongation_slope(z)
    step = 1e-5
    difference = (relative_elongation(z + step) - relative_elongation(z - step)) / (2.0 * step)
    np.testing.assert_allclose(slope, difference, rtol=1e-5)
    np.testing.assert_array_equal(slope, [elongation_slope(one) for one in z])
