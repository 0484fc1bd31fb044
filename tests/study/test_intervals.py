"""Intervals, which mean every value between two ends, and words that are an axis."""

import json

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.studies.load import study_from
from tendon_cli.studies.spaces import space_of

BOXES = {
    "load.mass": ("0 kg", "10 kg"),
    "arm.upper_arm_angle": ("-15 deg", "15 deg"),
    "arm.b1": ("140 mm", "160 mm"),
    "sheath.friction": (0.05, 0.09),
    "sheath.flexor.bend_angle": ("170 deg", "190 deg"),
    "spring.stiffness": ("2.9 kN/m", "3.1 kN/m"),
    "spring.extensor.stiffness": ("2.9 kN/m", "3.1 kN/m"),
    "anchor.stiffness": ("10 kN/m", "20 kN/m"),
}
MOTION = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}}


def study(**numbers):
    """Return a study of numbers at dotted keys, whose dots are written as double underlines."""
    values = {key.replace("__", "."): value for key, value in numbers.items()}
    return study_from({"motion": MOTION, "limits": {"max_tension": "600 N"}}).vary(**values)


def window(question):
    """Return the smallest and the largest pretension of a question's first choice, N."""
    row = tendon.design(question).choices.iloc[0]
    return row.pretension_from, row.pretension_to


def window_at_combinations(values):
    """Return the window of a study whose conditions are all combinations of values."""
    conditions = [key.replace("__", ".") for key in values]
    return window(study(**values).vary(**{"design.conditions": conditions}))


@pytest.mark.parametrize("key", BOXES)
def test_two_ends_without_a_count_are_an_interval_and_a_condition(key):
    low, high = BOXES[key]
    number = key.replace(".", "__")
    box = study(**{number: {"from": low, "to": high}})
    listed = study(**{number: [low, high]})
    assert box.numbers[key].is_interval
    assert box.numbers[key].extremes == listed.numbers[key].extremes
    assert box.axes == (key,)
    assert box.conditions == (key,)
    space = space_of(box)
    assert space.intervals == (0,)
    assert space.axes[0].role == "condition"
    again = study_from(json.loads(json.dumps(box.document())))
    assert again.hash == box.hash
    assert again.numbers[key].extremes == box.numbers[key].extremes
    assert box.hash != listed.hash


def test_a_sweep_has_no_values_to_take_from_an_interval():
    box = study(
        load__mass={"from": "0 kg", "to": "10 kg"}, arm__b1={"from": "140 mm", "to": "150 mm"}
    )
    with pytest.raises(tendon.TendonError, match=r"arm\.b1") as caught:
        tendon.sweep(box)
    assert caught.value.exit == 2
    assert '{ from = "0 kg", to = "10 kg", num = 5 }' in str(caught.value)


def test_a_window_of_a_box_holds_at_its_corners_and_for_every_posture_between():
    box = study(
        sheath__friction={"from": 0.05, "to": 0.09},
        arm__upper_arm_angle={"from": "-15 deg", "to": "15 deg"},
    )
    corners = {"sheath__friction": [0.05, 0.09], "arm__upper_arm_angle": ["-15 deg", "15 deg"]}
    postures = [f"{angle} deg" for angle in range(-15, 16)]
    low, high = window(box)
    corner_low, corner_high = window_at_combinations(corners)
    assert corner_low < low
    assert high <= corner_high * (1.0 + 1e-12)
    dense = window_at_combinations(corners | {"arm__upper_arm_angle": postures})
    assert (low, high) == pytest.approx(dense, rel=1e-4)


# --- Where a spring sits --------------------------------------------------------------------------


@pytest.mark.parametrize("key", ["spring__at", "spring__flexor__at", "spring__extensor__at"])
def test_designs_along_the_places_of_a_spring_are_those_of_each_place_alone(key):
    def designs_at(places):
        return tendon.sweep(study(**{key: places}, spring__stiffness="4 kN/m")).designs

    both = designs_at(["motor", "joint"])
    sides = key.split("__")[1:-1]
    column = "_".join(["spring_at", *sides])
    assert list(both[column]) == ["motor", "joint"]
    for row, place in enumerate(["motor", "joint"]):
        alone = designs_at(place).drop(columns="design")
        same = both.iloc[[row]][list(alone.columns)].reset_index(drop=True)
        np.testing.assert_array_equal(same.select_dtypes("number"), alone.select_dtypes("number"))


def test_where_a_spring_sits_is_a_choice_of_an_answer():
    def question_at(places):
        masses = ["0 kg", "2 kg"]
        more = {"anchor__stiffness": "10 kN/m", "load__mass": masses, "spool__ratio": 0.6}
        return study(spring__at=places, **more)

    both = question_at(["joint", "motor"])
    assert both.axes == ("spring.at", "load.mass")
    assert both.conditions == ("load.mass",)
    rows = tendon.design(both).choices.set_index("spring_at")
    for place in ("joint", "motor"):
        row = tuple(rows.loc[place, ["pretension_from", "pretension_to"]])
        assert row == pytest.approx(window(question_at(place)), rel=1e-12)
    document = json.loads(json.dumps(both.document()))
    assert study_from(document, order=both.axes).hash == both.hash
    varied = study().vary(**{"spring.at": ["motor", "joint"], "load.mass": [0.0, 1.0]})
    assert varied.axes == ("spring.at", "load.mass")


def test_the_place_of_a_spring_may_be_a_condition_and_filters_know_it(tmp_path):
    low, high = window(study(spring__at=["joint", "motor"], design__conditions="spring.at"))
    joint_low, joint_high = window(study(spring__at="joint"))
    motor_low, motor_high = window(study(spring__at="motor"))
    assert low == pytest.approx(max(joint_low, motor_low), rel=1e-12)
    assert high == pytest.approx(min(joint_high, motor_high), rel=1e-12)
    tendon.sweep(study(spring__at=["joint", "motor"]), tmp_path / "run")
    places = tendon.open(tmp_path / "run").to_xarray()["spring_at"]
    assert places.values.tolist() == ["joint", "motor"]
