"""Arms from tape measures: three persons by hand, and required pretension over the survey."""

from dataclasses import dataclass

import numpy as np
import pytest

from tendon_cli.model.actuator import evaluate
from tendon_cli.model.body import Body, anchor_scales, forearm_com, forearm_mass, load_distance
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.kinematics import Anchors
from tendon_cli.model.statics import respond
from tendon_cli.studies.people.population import draw
from tendon_cli.studies.people.survey import ansur2
from tests.model import designs, rig

SURVEY = ansur2()
PAPER = Anchors(0.040, 0.150, 0.020, 0.150, 0.045)
BOTH_DIRECTIONS = np.array([[True], [False]])


@dataclass(frozen=True)
class Person:
    """A body as tape and scale measure it, and its arm as a pocket calculator has it."""

    body: Body
    arm: dict


BY_HAND = {
    "the mean man": Person(
        body=Body(
            stature=1.75621,
            weight=85.52,
            acromion_radiale_length=0.33524,
            radiale_stylion_length=0.26788,
            forearm_grip_length=0.34901,
            biceps_circumference=0.35814,
            forearm_circumference=0.31006,
            wrist_circumference=0.17592,
        ),
        arm={
            "a1": 0.040,
            "b1": 0.150,
            "a2": 0.020,
            "b2": 0.150,
            "elbow_radius": 0.045,
            "forearm_mass": 1.88144,
            "forearm_com": 0.18269416,
            "load_distance": 0.34901,
        },
    ),
    "a slight woman": Person(
        body=Body(
            stature=1.52,
            weight=50.0,
            acromion_radiale_length=0.284,
            radiale_stylion_length=0.218,
            forearm_grip_length=0.290,
            biceps_circumference=0.258,
            forearm_circumference=0.234,
            wrist_circumference=0.142,
        ),
        arm={
            "a1": 0.02881555,
            "b1": 0.12707314,
            "a2": 0.01509385,
            "b2": 0.12206958,
            "elbow_radius": 0.03396117,
            "forearm_mass": 1.1,
            "forearm_com": 0.148676,
            "load_distance": 0.290,
        },
    ),
    "a tall and heavy man": Person(
        body=Body(
            stature=1.95,
            weight=120.0,
            acromion_radiale_length=0.380,
            radiale_stylion_length=0.305,
            forearm_grip_length=0.395,
            biceps_circumference=0.430,
            forearm_circumference=0.360,
            wrist_circumference=0.195,
        ),
        arm={
            "a1": 0.04802591,
            "b1": 0.17002744,
            "a2": 0.02322131,
            "b2": 0.17078543,
            "elbow_radius": 0.05224795,
            "forearm_mass": 2.64,
            "forearm_com": 0.20801,
            "load_distance": 0.395,
        },
    ),
}


def arm_of(body, reference):
    """Return the numbers of a body's arm; the reference has the paper's anchors."""
    arm = {
        name: scale * getattr(PAPER, name) for name, scale in anchor_scales(body, reference).items()
    }
    arm["forearm_mass"] = forearm_mass(body)
    arm["forearm_com"] = forearm_com(body)
    arm["load_distance"] = load_distance(body)
    return arm


@pytest.mark.parametrize("name", BY_HAND)
def test_the_arm_of_a_person_is_the_one_worked_by_hand(name):
    person = BY_HAND[name]
    assert arm_of(person.body, SURVEY.male.mean_body) == pytest.approx(person.arm, rel=1e-6)


def required(people, *, spring_stiffness, ratio, load_mass):
    """Return the smallest pretension that keeps each person taut, N.

    It does so over 0 to 90 degrees in both directions.
    """
    suit = designs.baseline(spring_stiffness=spring_stiffness, ratio=ratio, load_mass=load_mass)
    for name, values in arm_of(people.body, people.reference).items():
        suit[name] = np.reshape(values, (-1, 1, 1))
    angles = np.radians(np.linspace(0.0, 90.0, 91))
    state = evaluate(designs.design(suit), angles[np.newaxis], BOTH_DIRECTIONS)
    return respond(state.coupling).required.max(axis=(1, 2))


@pytest.mark.parametrize(
    ("spring_stiffness", "ratio", "load_mass", "expected"),
    [
        (3e3, 1.0, 0.0, (87.5, 99.6, 111.7)),
        (3e3, 0.7, 5.0, (90.5, 101.1, 111.7)),
        (1e3, 0.8, 5.0, (84.8, 89.8, 94.9)),
    ],
)
def test_percentiles_of_required_pretension_of_20000_men(
    spring_stiffness, ratio, load_mass, expected
):
    people = draw(SURVEY, "male", 20_000, seed=1)
    pretensions = required(
        people, spring_stiffness=spring_stiffness, ratio=ratio, load_mass=load_mass
    )
    np.testing.assert_allclose(np.percentile(pretensions, [5, 50, 95]), expected, rtol=0.01)


@pytest.mark.parametrize("name", BY_HAND)
@pytest.mark.parametrize("load_mass", [0.0, 5.0])
def test_the_window_of_a_person_worked_by_hand_is_where_the_rig_is_taut_and_stable(name, load_mass):
    """The rig is brute force: an integration along the sheath, and a spool that is turned.

    It is turned until the elbow balances (`tests.model.rig`): 5 kN/m, ratio 0.6, 0 and 5 kg.
    """
    suit = designs.baseline(
        **BY_HAND[name].arm, spring_stiffness=5e3, ratio=0.6, load_mass=load_mass
    )
    angles = np.radians([1e-9, 30.0, 60.0, 90.0])
    ends = designs.window_of(designs.design(suit), angles[np.newaxis], BOTH_DIRECTIONS, Bounds())
    low = float(ends.low)
    high = float(ends.high)
    assert 0.0 < low < high < np.inf
    for pretension, is_kept in (
        (low - 1.0, False),
        (low + 1.0, True),
        (high - 1.0, True),
        (high + 1.0, False),
    ):
        numbers = suit | {"flexor_pretension": pretension, "extensor_pretension": pretension}
        columns = {key: np.full(2 * len(angles), value) for key, value in numbers.items()}
        flexion = np.repeat([True, False], len(angles))
        outcomes = rig.run(columns, np.tile(angles, 2), flexion)
        kept = all(outcome.status == "taut" and outcome.stiffness >= 0.0 for outcome in outcomes)
        assert kept == is_kept, pretension
