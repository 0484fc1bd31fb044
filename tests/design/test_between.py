"""The window of an answer is that of the whole motion, whichever angles a study lists."""

import numpy as np
import pytest

import tendon_cli as tendon

# What each design is, its largest angle (deg), its limits, and its window with 40 digits in N (degrees where it binds
# between 0 and the largest), under 0 kg and the load, both directions: by root search on g(F, G, θ) in mpmath.
FIVE = {
    "K 5": ({"spring": {"stiffness": 5e3}, "spool": {"ratio": 0.6}}, 10.0, 90, {}, 122.121369120, 173.934155491, {}),
    "K 2": (
        {"spring": {"stiffness": 2e3}, "spool": {"ratio": 0.45}}, 10.0, 90, {}, 69.195919756, 85.288504590,
        {"from": 62.384430},
    ),
    "tension": (
        {"spring": {"stiffness": 5e3}, "spool": {"ratio": 0.55}, "arm": {"b1": 0.17, "b2": 0.13}}, 8.0, 120,
        {"max_tension": 380.0}, 101.015290544, 152.233691844, {"to": 47.212074},
    ),
    "torque": (
        {"spring": {"stiffness": 8e3}, "spool": {"ratio": 0.5}}, 10.0, 140, {"peak_motor_torque": 12.5},
        132.579566906, 238.107470235, {"to": 39.032457},
    ),
    "a2": (
        {"spring": {"stiffness": 5e3}, "spool": {"ratio": 0.45}, "arm": {"elbow_radius": 0.04, "a2": 0.01}}, 10.0, 130,
        {}, 79.114699387, 127.965755530, {},
    ),
}  # fmt: skip


def answered(content, **changes):
    return tendon.design(tendon.study({**content, **changes})).choices.iloc[0]


@pytest.mark.parametrize("angles", [5, 10, 20, 91])
@pytest.mark.parametrize("name", FIVE)
def test_five_windows_whatever_the_studys_angles(name, angles):
    content, load, last, limits, low, high, where = FIVE[name]
    motion = {"elbow_angle": {"from": "0 deg", "to": f"{last} deg", "num": angles}}
    found = answered(content, load={"mass": [0.0, load]}, motion=motion, limits=limits)
    assert found.pretension_from == pytest.approx(low, abs=1e-6)
    assert found.pretension_to == pytest.approx(high, abs=1e-6)
    for end, angle in where.items():
        assert np.degrees(found[f"{end}_elbow_angle"]) == pytest.approx(angle, abs=2e-3)


def test_random_windows_are_those_of_very_many_angles():
    """Never wider, and narrower by no more than what ten thousand angles leave."""
    rng, checked = np.random.default_rng(8), 0
    springs = {"max_spring_extension": 0.09, "min_flexor_tension": 20.0}
    limits = [{}, {"max_tension": 500.0}, {"peak_motor_torque": 14.0}, springs]
    for number in range(24):
        content = {
            "arm": {
                "b1": rng.uniform(0.13, 0.17), "a1": rng.uniform(0.03, 0.05),
                "upper_arm_angle": f"{rng.uniform(-20, 40)} deg",
            },
            "spring": {"stiffness": rng.uniform(2e3, 8e3)}, "spool": {"ratio": rng.uniform(0.4, 0.9)},
            "load": {"mass": [0.0, rng.uniform(2.0, 10.0)]}, "limits": limits[number % 4],
        }  # fmt: skip
        last = rng.uniform(60.0, 140.0)
        few = answered(content, motion={"elbow_angle": {"from": "0 deg", "to": f"{last} deg", "num": 4}})
        very_many = {"elbow_angle": {"from": "0 deg", "to": f"{last} deg", "num": 4001}}
        many = tendon.sweep(tendon.study(content | {"motion": very_many, "output": {"tables": ["designs"]}})).designs
        low, high = many.pretension_from.max(), many.pretension_to.fillna(np.inf).min()
        if np.isnan(few.pretension_from):
            assert np.isnan(many.pretension_from).any()
            continue
        checked += 1
        assert low - 1e-7 <= few.pretension_from <= low + 1e-3
        few_high = np.inf if np.isnan(few.pretension_to) else few.pretension_to
        assert high == few_high or high - 1e-3 <= few_high <= high + 1e-7
    assert checked > 14
