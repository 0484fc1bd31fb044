"""How far a joint drifts with the spool held, against an independent root search, and for a stable one not at all."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from tendon_cli.answers.problem import question
from tendon_cli.model.actuator import evaluate
from tendon_cli.model.reversal import drift
from tendon_cli.studies.load import study_from


def at_pretension(design, value):
    return replace(
        design,
        **{
            side: replace(getattr(design, side), pretension=value)
            for side in ("flexor", "extensor")
        },
    )


def designed(stiffness, ratio, pretension, mass=0.0):
    suit = {"spring": {"stiffness": stiffness}, "spool": {"ratio": ratio}, "load": {"mass": mass}}
    return at_pretension(question(study_from(suit)).design({}), pretension)


@pytest.mark.parametrize(
    ("stiffness", "ratio", "degrees", "torque"),
    [(5e3, 0.6, 7.4, 0.08), (3e3, 1.0, 27.6, 0.94)],
    ids=["5", "paper"],
)
def test_the_arm_drifts_as_far_as_was_found_independently(stiffness, ratio, degrees, torque):
    found = drift(designed(stiffness, ratio, 200.0), 0.0, np.pi / 2)
    assert found.balanced
    assert np.degrees(found.end) == pytest.approx(degrees, abs=0.07)
    assert found.torque == pytest.approx(torque, abs=0.005)


@pytest.mark.parametrize(("stiffness", "ratio"), [(5e3, 0.6), (3e3, 1.0), (3e3, 0.8)])
def test_where_it_rests_the_same_spool_holds_it(stiffness, ratio):
    design = designed(stiffness, ratio, 200.0)
    found = drift(design, 0.0, np.pi / 2)

    def spool(angle):
        return evaluate(design, np.array([[angle]]), np.array([[True]])).spool_angle.item()

    held = spool(0.0)
    assert found.end == pytest.approx(
        brentq(lambda angle: spool(angle) - held, 0.01, np.pi / 2), abs=1e-6
    )


def test_the_torque_that_drives_it_is_the_slope_of_energy():
    """Without friction and weight it is what springs and tendons give up per angle."""
    content = {
        "spring": {"stiffness": 3e3},
        "sheath": {"friction": 0.0},
        "arm": {"forearm_mass": 0.0},
    }
    design = at_pretension(question(study_from(content)).design({}), 200.0)
    state = evaluate(design, np.array([[0.0]]), np.array([[True]]))
    found, radius = drift(design, 0.0, np.pi / 2), 0.03
    held = radius * state.spool_angle.item()

    def energy(angle):
        at = evaluate(design, np.array([[angle]]), np.array([[True]]))
        sides = zip(
            (held - at.motion.flexor_travel, at.motion.extensor_travel - held),
            (at.coupling.flexor_compliance, at.coupling.extensor_compliance),
            strict=True,
        )
        return sum(0.5 * c.item() * (200.0 + travel.item() / c.item()) ** 2 for travel, c in sides)

    def torque(angle):
        return -(energy(angle + 1e-6) - energy(angle - 1e-6)) / 2e-6

    largest = max(torque(angle) for angle in np.linspace(0.0, found.end, 200))
    assert found.torque == pytest.approx(largest, rel=1e-3)


def test_a_stable_arm_stays():
    found = drift(designed(5e3, 0.6, 150.0), 0.0, np.pi / 2)
    assert (found.end, found.torque, found.balanced) == (0.0, 0.0, True)
