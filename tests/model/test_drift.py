"""The drift of a joint with the spool held, against an independent root search.

A stable joint does not drift at all.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from tendon_cli.engine.windows.question import question_of
from tendon_cli.model.actuator import evaluate
from tendon_cli.model.reversal import drift
from tendon_cli.studies.load import study_from


def designed(content, pretension):
    """Return the design of a study's content at a pretension of both sides, N."""
    question = question_of(study_from(content))
    design = question.designs(question.all_points())
    flexor = replace(design.flexor, pretension=pretension)
    extensor = replace(design.extensor, pretension=pretension)
    return replace(design, flexor=flexor, extensor=extensor)


def suit(stiffness, ratio, pretension=200.0):
    """Return a suit with an empty hand."""
    content = {
        "spring": {"stiffness": stiffness},
        "spool": {"ratio": ratio},
        "load": {"mass": 0.0},
    }
    return designed(content, pretension)


def state_of(design, angle):
    """Return the state of a design in flexion at an angle."""
    return evaluate(design, np.array([[angle]]), np.array([[True]]))


@pytest.mark.parametrize(
    ("stiffness", "ratio", "degrees", "torque"),
    [(5e3, 0.6, 7.4, 0.08), (3e3, 1.0, 27.6, 0.94)],
    ids=["5", "paper"],
)
def test_the_arm_drifts_as_far_as_was_found_independently(stiffness, ratio, degrees, torque):
    result = drift(suit(stiffness, ratio), 0.0, np.pi / 2)
    assert result.balanced
    assert np.degrees(result.end) == pytest.approx(degrees, abs=0.07)
    assert result.torque == pytest.approx(torque, abs=0.005)


@pytest.mark.parametrize(("stiffness", "ratio"), [(5e3, 0.6), (3e3, 1.0), (3e3, 0.8)])
def test_where_it_rests_the_same_spool_holds_it(stiffness, ratio):
    design = suit(stiffness, ratio)
    result = drift(design, 0.0, np.pi / 2)
    held = state_of(design, 0.0).spool_angle.item()

    def turn_from_held(angle):
        return state_of(design, angle).spool_angle.item() - held

    at_rest = brentq(turn_from_held, 0.01, np.pi / 2)
    assert result.end == pytest.approx(at_rest, abs=1e-6)


def test_the_torque_that_drives_it_is_the_slope_of_energy():
    """Without friction and weight, springs and tendons give up that torque as energy per angle."""
    content = {
        "spring": {"stiffness": 3e3},
        "sheath": {"friction": 0.0},
        "arm": {"forearm_mass": 0.0},
    }
    design = designed(content, 200.0)
    result = drift(design, 0.0, np.pi / 2)
    held = 0.03 * state_of(design, 0.0).spool_angle.item()

    def stored(compliance, stretch):
        return 0.5 * compliance.item() * (200.0 + stretch.item() / compliance.item()) ** 2

    def energy(angle):
        state = state_of(design, angle)
        coupling = state.coupling
        flexor = stored(coupling.flexor_compliance, held - state.motion.flexor_travel)
        extensor = stored(coupling.extensor_compliance, state.motion.extensor_travel - held)
        return flexor + extensor

    def torque(angle):
        return -(energy(angle + 1e-6) - energy(angle - 1e-6)) / 2e-6

    largest = max(torque(angle) for angle in np.linspace(0.0, result.end, 200))
    assert result.torque == pytest.approx(largest, rel=1e-3)


def test_a_stable_arm_stays():
    result = drift(suit(5e3, 0.6, pretension=150.0), 0.0, np.pi / 2)
    assert result.end == 0.0
    assert result.torque == 0.0
    assert result.balanced
