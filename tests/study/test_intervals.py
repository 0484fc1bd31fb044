"""Numbers of which every value between two ends is meant, and words that are an axis."""

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
    """A study of the numbers at dotted keys, whose dots are written as double underlines."""
    given = {key.replace("__", "."): value for key, value in numbers.items()}
    return study_from({"motion": MOTION, "limits": {"max_tension": "600 N"}}).vary(**given)


def window(asked):
    row = tendon.design(asked).choices.iloc[0]
    return row.pretension_from, row.pretension_to


@pytest.mark.parametrize("key", BOXES)
def test_two_ends_without_a_count_are_an_interval_and_a_condition(key):
    low, high = BOXES[key]
    asked = study(**{key.replace(".", "__"): {"from": low, "to": high}})
    ((found, ends),) = asked.intervals.items()
    assert (found, asked.axes, asked.conditions) == (key, (key,), (key,))
    listed = study(**{key.replace(".", "__"): [low, high]})
    assert ends == listed.numbers[key].extremes
    space = space_of(asked)
    assert (space.intervals, space.axes[0].role) == ((0,), "condition")
    again = study_from(json.loads(json.dumps(asked.document())))
    assert (again.hash, again.intervals) == (asked.hash, asked.intervals)
    assert asked.hash != listed.hash


def test_a_sweep_has_no_values_to_take_from_an_interval():
    with pytest.raises(tendon.TendonError, match=r"arm\.b1") as caught:
        tendon.sweep(
            study(
                load__mass={"from": "0 kg", "to": "10 kg"},
                arm__b1={"from": "140 mm", "to": "150 mm"},
            )
        )
    assert caught.value.exit == 2
    assert '{ from = "0 kg", to = "10 kg", num = 5 }' in str(caught.value)


def test_a_window_of_a_box_holds_at_its_corners_and_for_every_posture_between():
    box = {"sheath__friction": (0.05, 0.09), "arm__upper_arm_angle": ("-15 deg", "15 deg")}
    low, high = window(study(**{key: {"from": a, "to": b} for key, (a, b) in box.items()}))
    outer_low, outer_high = window(_conditions(box))
    assert outer_low < low
    assert high <= outer_high * (1.0 + 1e-12)
    between = window(
        _conditions(box | {"arm__upper_arm_angle": [f"{angle} deg" for angle in range(-15, 16)]})
    )
    assert (low, high) == pytest.approx(between, rel=1e-4)


def _conditions(values):
    """The study whose conditions are all combinations of these values."""
    asked = study(**{key: [*each] for key, each in values.items()})
    return asked.vary(**{"design.conditions": [key.replace("__", ".") for key in values]})


# --- Where a spring sits --------------------------------------------------------------------------


@pytest.mark.parametrize("key", ["spring__at", "spring__flexor__at", "spring__extensor__at"])
def test_designs_along_the_places_of_a_spring_are_those_of_each_place_alone(key):
    both = tendon.sweep(study(**{key: ["motor", "joint"]}, spring__stiffness="4 kN/m"))
    column = "_".join(["spring_at", *key.split("__")[1:-1]])
    assert list(both.designs[column]) == ["motor", "joint"]
    for at, place in enumerate(("motor", "joint")):
        alone = tendon.sweep(study(**{key: place}, spring__stiffness="4 kN/m")).designs.drop(
            columns="design"
        )
        same = both.designs.iloc[[at]][list(alone.columns)].reset_index(drop=True)
        np.testing.assert_array_equal(same.select_dtypes("number"), alone.select_dtypes("number"))


def test_where_a_spring_sits_is_a_choice_of_an_answer():
    asked = study(
        spring__at=["joint", "motor"], anchor__stiffness="10 kN/m", load__mass=["0 kg", "2 kg"]
    )
    assert (asked.axes, asked.conditions) == (("spring.at", "load.mass"), ("load.mass",))
    rows = tendon.design(asked).choices.set_index("spring_at")
    for place in ("joint", "motor"):
        alone = study(spring__at=place, anchor__stiffness="10 kN/m", load__mass=["0 kg", "2 kg"])
        assert tuple(rows.loc[place, ["pretension_from", "pretension_to"]]) == pytest.approx(
            window(alone), rel=1e-12
        )
    assert study_from(json.loads(json.dumps(asked.document())), order=asked.axes).hash == asked.hash
    assert study().vary(**{"spring.at": ["motor", "joint"], "load.mass": [0.0, 1.0]}).axes == (
        "spring.at",
        "load.mass",
    )


def test_the_place_of_a_spring_may_be_a_condition_and_filters_know_it(tmp_path):
    asked = study(spring__at=["joint", "motor"], design__conditions="spring.at")
    low, high = window(asked)
    each = [window(study(spring__at=place)) for place in ("joint", "motor")]
    assert (low, high) == pytest.approx(
        (max(a for a, _ in each), min(b for _, b in each)), rel=1e-12
    )
    tendon.sweep(study(spring__at=["joint", "motor"]), tmp_path / "run")
    assert tendon.open(tmp_path / "run").to_xarray()["spring_at"].values.tolist() == [
        "joint",
        "motor",
    ]
