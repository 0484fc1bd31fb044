"""Tables, texts and datasets of answers tell what a named choice or condition sets."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.cube.choice_grid import position
from tendon_cli.errors import InputError
from tendon_cli.studies.spaces import row_axes

STUDY = {
    "arm": {"upper_arm_angle": 0.0},
    "cases": [
        {"name": "d88", "arm": {"b1": "88 mm"}},
        {"name": "d150", "arm": {"b1": "150 mm"}},
    ],
    "spring": {"stiffness": ["1 kN/m", "3 kN/m"]},
    "load": {"mass": ["0 kg", "3 kg"]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
}
SMALL = {"spool": {"ratio": 0.6}}
CHOSEN = {**STUDY, "design": {"conditions": ["load.mass"]}}


@pytest.fixture(scope="module")
def chosen():
    """Answer in which a case is a choice."""
    return tendon.design(CHOSEN)


def test_choices_say_what_their_case_sets(chosen):
    choices = chosen.choices
    lengths = choices["case"].map({"d88": 0.088, "d150": 0.15}).astype(float)
    np.testing.assert_array_equal(choices["arm_b1"], lengths)
    assert choices.attrs["units"]["arm_b1"] == "m"
    assert "arm_b1" not in chosen.conditions


def test_conditions_say_what_their_case_sets():
    answer = tendon.design({**STUDY, "spring": {"stiffness": ["5 kN/m", "8 kN/m"]}, **SMALL})
    assert answer.conditions["arm_b1"].tolist() == [0.088, 0.088, 0.15, 0.15]
    assert "arm_b1" not in answer.choices
    data = answer.to_xarray()
    assert data["condition_arm_b1"].dims == ("condition",)
    assert "d150: b₁ 150 mm" in answer.text


def test_the_answer_says_what_the_case_named_first_sets(chosen):
    assert chosen.best["case"] == "d88"
    assert chosen.best["arm_b1"] == 0.088
    assert "d88 (b₁ 88 mm)" in " ".join(chosen.short.split())


def test_a_dataset_has_the_number_along_the_cases(chosen):
    data = chosen.to_xarray()
    assert data["arm_b1"].dims == ("case",)
    assert data["arm_b1"].sel(case="d88").item() == 0.088
    assert data["window_from"].dims == ("case", "spring_stiffness", "condition")


def test_conditions_of_people_have_their_bodies():
    people = {**SMALL, "people": {"count": 4}, "design": {"serve": 0.3, "verify": 50}}
    answer = tendon.design({**STUDY, "cases": [], **people})
    persons = answer.conditions.drop_duplicates("person")
    assert persons["arm_b1"].nunique() == 4
    assert persons["arm_forearm_mass"].between(0.5, 4.0).all()


def test_a_name_that_the_axis_does_not_have_has_no_position():
    axis = row_axes(tendon.study(STUDY))[0]
    assert position(axis, "d150").tolist() == [1]
    with pytest.raises(InputError) as told:
        position(axis, "d15")
    assert 'there is no case "d15"' in str(told.value)
    assert told.value.hint == 'did you mean "d150"?'


def test_figures_show_a_rigid_spring_that_is_best(tmp_path):
    rigid = {
        "anchor": {"stiffness": "10 kN/m"},
        "spring": {"stiffness": ["rigid", "1 kN/m"]},
        "joint": {"stiffness": "20 N m/rad", "rest_angle": "40 deg"},
        "design": {"minimise": ["max_spring_extension"]},
        "motion": STUDY["motion"],
    }
    answer = tendon.design(rigid, tmp_path / "answer", figures=True)
    assert answer.best["spring_stiffness"] == "rigid"
    assert (tmp_path / "answer" / "window.png").is_file()
