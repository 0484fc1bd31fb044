"""From tape measure to arm: three persons by hand, and the survey's spread of required pretension."""

import numpy as np
import pytest

from tendon_cli.model.actuator import evaluate
from tendon_cli.model.body import Body, anchor_scales, forearm_com, forearm_mass, load_distance
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.kinematics import Anchors
from tendon_cli.model.statics import respond
from tendon_cli.model.window import window
from tendon_cli.studies.people.population import draw
from tendon_cli.studies.people.survey import ansur2
from tests.model import designs, rig

SURVEY = ansur2()
PAPER = Anchors(0.040, 0.150, 0.020, 0.150, 0.045)

# Stature, weight, acromion-radiale, radiale-stylion, forearm-grip, biceps, forearm and wrist, as tape and scale say;
# then a1, b1, a2, b2, R_elb, forearm mass, its centre and the load's distance, worked out with a pocket calculator.
ARM = ("a1", "b1", "a2", "b2", "elbow_radius", "forearm_mass", "forearm_com", "load_distance")
BY_HAND = {
    "the mean man": (
        (1.75621, 85.52, 0.33524, 0.26788, 0.34901, 0.35814, 0.31006, 0.17592),
        (0.040, 0.150, 0.020, 0.150, 0.045, 1.88144, 0.18269416, 0.34901),
    ),
    "a slight woman": (
        (1.52, 50.0, 0.284, 0.218, 0.290, 0.258, 0.234, 0.142),
        (0.02881555, 0.12707314, 0.01509385, 0.12206958, 0.03396117, 1.1, 0.148676, 0.290),
    ),
    "a tall and heavy man": (
        (1.95, 120.0, 0.380, 0.305, 0.395, 0.430, 0.360, 0.195),
        (0.04802591, 0.17002744, 0.02322131, 0.17078543, 0.05224795, 2.64, 0.20801, 0.395),
    ),
}


@pytest.mark.parametrize("person", BY_HAND)
def test_the_arm_of_a_person_worked_by_hand(person):
    measured, expected = BY_HAND[person]
    body = Body(*measured)
    found = [
        scale * getattr(PAPER, name)
        for name, scale in anchor_scales(body, SURVEY.male.mean_body).items()
    ]
    assert [*found, forearm_mass(body), forearm_com(body), load_distance(body)] == pytest.approx(
        expected, rel=1e-6
    )


def required(people, *, spring_stiffness, ratio, load_mass):
    """The smallest pretension that keeps each person taut over 0 to 90 degrees in both directions, N."""
    body = people.body
    on = {
        name: scale * getattr(PAPER, name)
        for name, scale in anchor_scales(body, people.reference).items()
    }
    column = {name: np.reshape(values, (-1, 1, 1)) for name, values in on.items()}
    column |= {
        f.__name__: np.reshape(f(body), (-1, 1, 1))
        for f in (forearm_mass, forearm_com, load_distance)
    }
    p = (
        designs.baseline(spring_stiffness=spring_stiffness, ratio=ratio, load_mass=load_mass)
        | column
    )
    angles = np.radians(np.linspace(0.0, 90.0, 91))
    state = evaluate(designs.design(p), angles[np.newaxis], np.array([[True], [False]]))
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
    found = required(people, spring_stiffness=spring_stiffness, ratio=ratio, load_mass=load_mass)
    np.testing.assert_allclose(np.percentile(found, [5, 50, 95]), expected, rtol=0.01)


# The windows of these three, by brute force from an integration along the sheath and a spool that is turned until the
# elbow balances (`tests.model.rig`): 5 kN/m, ratio 0.6, 0 and 5 kg.


@pytest.mark.parametrize("person", BY_HAND)
@pytest.mark.parametrize("load_mass", [0.0, 5.0])
def test_the_window_of_a_person_worked_by_hand_is_where_the_rig_is_taut_and_stable(
    person, load_mass
):
    arm = dict(zip(ARM, BY_HAND[person][1], strict=True))
    p = designs.baseline(**arm, spring_stiffness=5e3, ratio=0.6, load_mass=load_mass)
    angles = np.radians([1e-9, 30.0, 60.0, 90.0])
    found = window(designs.design(p), angles[np.newaxis], np.array([[True], [False]]), Bounds())
    low, high = float(found.low), float(found.high)
    assert 0.0 < low < high < np.inf
    for pretension, is_kept in (
        (low - 1.0, False),
        (low + 1.0, True),
        (high - 1.0, True),
        (high + 1.0, False),
    ):
        q = p | {"flexor_pretension": pretension, "extensor_pretension": pretension}
        flat = {name: np.full(2 * len(angles), value) for name, value in q.items()}
        outcomes = rig.run(flat, np.tile(angles, 2), np.repeat([True, False], len(angles)))
        kept = all(outcome.status == "taut" and outcome.stiffness >= 0.0 for outcome in outcomes)
        assert kept == is_kept, pretension
