"""Tensions to set on the bench, and drift of the arm.

They are checked against the model and the published numbers.
"""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.answers.setup import settings
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.study_arm import study_arm
from tendon_cli.model.setting import pretension_per_length

from .studies import NO_UPPER_END

SUIT = {
    "spring": {"stiffness": "5 kN/m"},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "10 kg"]},
}


def answered(**content):
    """Answer the question about the suit, set to the middle, with some tables replaced."""
    at_middle = {"design": {"pretension": "middle"}}
    return tendon.design({**SUIT, **at_middle, **content})


@pytest.fixture(scope="module")
def answer():
    """Return the answer for the suit."""
    return answered()


def test_the_tensions_to_set_are_those_of_the_state_in_which_it_is_set(answer):
    row = answer.choices.iloc[0]
    assert row.tolerance_length == pytest.approx(5.391e-3, abs=5e-7)
    setting = {
        **SUIT,
        "load": {"mass": 0.0},
        "tendon": {"pretension": row.pretension},
        "motion": {"direction": "extension", "elbow_angle": 0.0},
    }
    state = tendon.sweep(setting).states.iloc[0]
    for side in ("flexor", "extensor"):
        at_joint = state[f"{side}_tension_distal"]
        at_motor = state[f"{side}_tension_proximal"]
        assert row[f"set_{side}_tension"] == pytest.approx(at_joint, rel=1e-12)
        assert row[f"set_{side}_tension_motor"] == pytest.approx(at_motor, rel=1e-12)


@pytest.mark.parametrize(
    ("stiffness", "ratio", "per_mm"), [("5 kN/m", 0.6, 4.8), ("8 kN/m", 0.5, 7.5)]
)
def test_a_millimetre_of_both_tendons_adds_its_pretension(stiffness, ratio, per_mm):
    question = question_of(
        tendon.study({"spring": {"stiffness": stiffness}, "spool": {"ratio": ratio}})
    )
    design = study_arm(question, question.all_points().at_pretension(np.array([100.0])))
    assert pretension_per_length(design) * 1e-3 == pytest.approx(per_mm, abs=0.05)


@pytest.mark.parametrize(
    "whom", [{"people": {"count": 3}}, {"uncertainty": {"draws": 4}}], ids=["people", "draws"]
)
def test_the_tensions_to_set_are_those_of_the_study_arm(whom):
    content = {**SUIT, "sheath": {"friction": {"value": 0.07, "tolerance": "20 %"}}}

    def settings_of(content):
        question = question_of(tendon.study(content))
        pretension = np.array([140.0])
        points = question.all_points().at_pretension(pretension)
        return settings(study_arm(question, points), pretension, 1)

    of_many = settings_of({**content, **whom})
    for name, values in settings_of(content).items():
        np.testing.assert_allclose(of_many[name], values, rtol=1e-12, err_msg=name)


def test_a_window_without_an_end_has_no_length():
    choices = tendon.design(SUIT | {"joint": NO_UPPER_END}).choices
    assert choices["feasible"].all()
    assert choices["pretension_to"].isna().all()
    assert choices["tolerance_length"].isna().all()
    choices = tendon.design(SUIT | {"spring": {"stiffness": ["1 kN/m", "5 kN/m"]}}).choices
    np.testing.assert_array_equal(choices["tolerance_length"].isna(), ~choices["feasible"])


def test_the_text_says_which_tensions_to_set_and_how_far_the_arm_drifts(answer):
    text = " ".join(answer.text.split())
    assert text.startswith("Set 189 N in the flexor (126 N in the extensor) at the joint, ")
    assert "shortening both tendons by 1 mm adds 4.8 N of pretension" in text
    assert "they may be 5.3 mm too long or 5.3 mm too short (122.1 to 173.9 N works)" in text
    drift = "settles at 4.97 deg instead of 0 deg, pushed by at most 0.035 N m"
    assert f"10 % above this the elbow {drift}" in text
    assert "snap" not in text
