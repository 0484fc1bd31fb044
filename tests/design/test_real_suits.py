"""What a real suit adds to the window: anchors that give, the joint's own torque, where the spring sits."""

import json

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.model.design import READINGS
from tendon_cli.model.setting import Reading, all_readings
from tendon_cli.studies.spaces import space_of

SUITS = {"K 5": ("5 kN/m", 0.6), "K 8": ("8 kN/m", 0.5)}


def window(suit, tables=None, loads=("0 kg", "10 kg")):
    stiffness, ratio = SUITS[suit]
    content = {
        "spring": {"stiffness": stiffness},
        "spool": {"ratio": ratio},
        "load": {"mass": list(loads)},
    }
    for table, keys in (tables or {}).items():
        content[table] = content.get(table, {}) | keys
    found = tendon.design(tendon.study(content)).choices.iloc[0]
    return found.pretension_from, found.pretension_to


PASSIVE = {"stiffness": "1.1 N m/rad", "rest_angle": "73 deg"}


@pytest.mark.parametrize(
    ("tables", "first", "second"),
    [
        ({}, (122.1, 173.9), (60.4, 251.9)),
        ({"anchor": {"stiffness": "20 kN/m"}}, (None, 173.9 - 28), (None, 251.9 - 61)),
        ({"anchor": {"stiffness": "10 kN/m"}}, (115.0, 126.5), (72.7, 155.6)),
        ({"anchor": {"stiffness": "5 kN/m"}}, None, (None, 251.9 - 135)),
        ({"joint": PASSIVE}, (123.09, 205.02), (61.30, 284.07)),
        ({"spring": {"at": "motor"}}, (150.35, 158.76), (85.1, 230.1)),
        ({"arm": {"upper_arm_angle": ["0 deg", "20 deg"]}}, (145.3, 159.7), (129.0, 236.8)),
        ({"arm": {"upper_arm_angle": ["0 deg", "-20 deg"]}}, (160.9, 173.9), (171.5, 251.9)),
    ],
)
def test_what_each_effect_does_to_the_window(tables, first, second):
    """Section 16 of the checked model: 0 and 10 kg, 0 to 90 degrees, no slack, k >= 0."""
    for suit, expected in zip(SUITS, (first, second), strict=True):
        low, high = window(suit, tables)
        if expected is None:
            assert not low <= high
            continue
        digits = (
            0.0051 if any(end is not None and round(end, 1) != end for end in expected) else 0.06
        )
        rounded = 0.51 if expected[0] is None else digits
        assert expected[0] is None or low == pytest.approx(expected[0], abs=digits)
        assert high == pytest.approx(expected[1], abs=rounded)


@pytest.mark.parametrize(
    ("stiffness", "expected"), [("3 kN/m", (160.7, 168.3)), ("1 kN/m", (103.3, 106.3))]
)
def test_the_joints_own_stiffness_opens_what_the_papers_suits_lack(stiffness, expected):
    content = {"spring": {"stiffness": stiffness}, "load": {"mass": ["0 kg", "5 kg"]}}
    joint = {"stiffness": "1.8 N m/rad", "rest_angle": "73 deg"}
    found = tendon.design({**content, "joint": joint}).choices.iloc[0]
    assert (found.pretension_from, found.pretension_to) == pytest.approx(expected, abs=0.051)


RIGID, HALF, SMOOTH = {"stiffness": "rigid"}, {"stiffness": "10 kN/m"}, {"friction": 0.0}
SAME = {
    "an anchor in place of a spring": ({"spring": RIGID, "anchor": {"stiffness": "5 kN/m"}}, {}),
    "1/K adds up at the joint": ({"spring": HALF, "anchor": HALF}, {}),
    "either end without friction": (
        {"sheath": SMOOTH, "spring": {"at": "motor"}},
        {"sheath": SMOOTH},
    ),
}


@pytest.mark.parametrize("what", SAME)
def test_suits_that_are_the_same_have_the_same_window(what):
    one, other = SAME[what]
    assert window("K 5", one) == pytest.approx(window("K 5", other), rel=1e-12)


def test_the_stiffer_the_anchor_the_nearer_a_rigid_one():
    ends = np.array(
        [window("K 5", {"anchor": {"stiffness": f"{k} kN/m"}}) for k in (10, 20, 100, 1e6)]
    )
    assert (np.diff(ends, axis=0) > 0.0).all()
    assert tuple(ends[-1]) == pytest.approx(window("K 5"), rel=1e-4)


def test_sides_cases_and_axes_say_where_a_spring_sits_and_what_gives():
    cases = [
        {"name": "all at the joint"},
        {"name": "flexor at the motor", "spring": {"flexor": {"at": "motor"}}},
        {"name": "soft", "anchor": {"extensor": {"stiffness": "6 kN/m"}}},
    ]
    springs = {"extensor": {"stiffness": ["5 kN/m", "rigid"]}, "stiffness": "5 kN/m"}
    suit = {
        "anchor": {"stiffness": ["rigid", "20 kN/m"]},
        "spool": {"ratio": 0.6},
        "spring": springs,
    }
    designs = tendon.sweep(
        {"cases": cases, **suit, "motion": {"elbow_angle": ["30 deg", "80 deg"]}}
    ).designs
    assert len(designs) == 12
    assert set(designs["spring_stiffness_extensor"]) == {5e3, np.inf}
    soft = designs[designs["case"] == "soft"]
    assert set(soft["anchor_stiffness_extensor"]) == {6e3}
    assert set(soft["anchor_stiffness_flexor"]) == {np.inf, 2e4}
    assert designs.groupby("case", observed=True)["pretension_from"].first().nunique() == 3


def test_an_uncertain_anchor_is_drawn():
    anchor = {
        "anchor": {"stiffness": {"value": "10 kN/m", "tolerance": "20 %"}},
        "uncertainty": {"draws": 16},
    }
    suit = {
        "spring": {"stiffness": "8 kN/m"},
        "spool": {"ratio": 0.5},
        "load": {"mass": ["0 kg", "10 kg"]},
    }
    answer = tendon.design({**anchor, **suit})
    assert (answer.feasible, len(answer.conditions)) == (1, 32)
    assert (
        0.0
        < answer.choices["pretension_to"].iloc[0]
        < window("K 8", {"anchor": {"stiffness": "12 kN/m"}})[1]
    )


def test_a_rigid_spring_is_infinite_in_tables_and_a_word_in_what_is_read():
    study = tendon.study({"spring": {"stiffness": ["rigid", "5 kN/m"]}, "spool": {"ratio": 0.6}})
    answer = tendon.design(study)
    assert answer.choices["spring_stiffness"].tolist() == [np.inf, 5e3]
    assert '"spring_stiffness": "rigid"' in json.dumps(answer.record)
    assert "K rigid" in answer.text
    assert tendon.study(study.document()).hash == study.hash


# --- Setting and reading --------------------------------------------------------------------------

K5 = {"spring": {"stiffness": "5 kN/m"}, "spool": {"ratio": 0.6}}
MIDDLE = 0.5 * (122.121369120 + 173.934155491)


@pytest.mark.parametrize(
    ("after", "shown", "read_as"),
    [
        ("flexion", (188.6, 125.4, 234.9, 100.7), (115.9, 174.9)),
        ("extension", (188.9, 125.6, 151.6, 156.5), (115.8, 174.6)),
    ],
)
def test_what_gauges_show_where_the_pretension_is_set(after, shown, read_as):
    """Section 16 of the checked model, for the middle of the window of K 5, 148.0 N."""
    study = tendon.study({**K5, "tendon": {"pretension": MIDDLE}, "setting": {"after": after}})
    made = space_of(study).design()
    found = all_readings(made, MIDDLE)
    assert tuple(round(float(each), 1) for each in found.values()) == shown
    back = [
        float(Reading.of(made, f"{side} at joint").pretension(MIDDLE))
        for side in ("flexor", "extensor")
    ]
    assert tuple(round(each, 1) for each in back) == read_as
    values = {line["symbol"]: line["values"] for line in tendon.state(study).record["lines"]}
    assert [*values["F_o,set"], *values["F_I,set"]] == pytest.approx(list(shown), abs=0.051)
    assert values["dF0/dl"][0] == pytest.approx(4.81e3, rel=2e-3)


@pytest.mark.parametrize("read", READINGS[1:])
def test_a_study_in_readings_gives_the_same_suit(read):
    loads = {"load": {"mass": ["0 kg", "10 kg"]}}
    ways = ({**K5, **loads, "setting": {"read": way}} for way in ("pretension", read))
    plain, asked = (tendon.design(tendon.study(way)) for way in ways)
    one, other = plain.choices.iloc[0], asked.choices.iloc[0]
    line = Reading.of(space_of(tendon.study(K5)).design(), read)
    for end in ("pretension_from", "pretension_to", "pretension"):
        assert other[end] == pytest.approx(float(line.shown(one[end]).item()), rel=1e-12)
    for same in (
        "max_tension",
        "peak_motor_torque",
        "tolerance_length",
        "set_flexor_tension",
        "from_by",
        "to_by",
    ):
        assert (
            other[same] == pytest.approx(one[same], rel=1e-10)
            if same[-3:] != "_by"
            else other[same] == one[same]
        )
    given = {"setting": {"read": read}, "tendon": {"pretension": [other.pretension]}}
    designs = tendon.sweep(tendon.study({**K5, **loads, **given})).designs
    np.testing.assert_allclose(designs["model_pretension"], one.pretension, rtol=1e-12)
    of_states = designs["max_tension"].max()  # of 91 angles, where the answer's is that of all
    assert one.max_tension * (1.0 - 5e-5) <= of_states <= one.max_tension * (1.0 + 1e-10)
    by_pretension = tendon.sweep(
        tendon.study({**K5, **loads, "tendon": {"pretension": [one.pretension]}})
    ).designs
    assert of_states == pytest.approx(by_pretension["max_tension"].max(), rel=1e-10)
    assert designs["pretension_from"].max() == pytest.approx(other.pretension_from, rel=1e-12)
    assert (designs["required_pretension"] + designs["margin"]).to_numpy() == pytest.approx(
        other.pretension, rel=1e-12
    )


def test_windows_of_different_arms_are_intersected_as_they_are_read():
    """One reading for all is another question than one F0 for all."""
    arms = {"joint": {"stiffness": ["0.4 N m/rad", "1.8 N m/rad"], "rest_angle": "73 deg"}}
    read = "extensor at joint"
    found = tendon.design(tendon.study({**K5, **arms, "setting": {"read": read}})).choices.iloc[0]
    each = []
    for stiffness in arms["joint"]["stiffness"]:
        one = {"joint": {"stiffness": stiffness, "rest_angle": "73 deg"}}
        alone = tendon.design(tendon.study({**K5, **one})).choices.iloc[0]
        line = Reading.of(space_of(tendon.study({**K5, **one})).design(), read)
        each.append(
            [float(line.shown(alone[end]).item()) for end in ("pretension_from", "pretension_to")]
        )
    low, high = np.array(each).T
    assert (found.pretension_from, found.pretension_to) == pytest.approx(
        (low.max(), high.min()), rel=1e-12
    )


def test_the_largest_pretension_is_a_reading_too():
    asked = {**K5, "setting": {"read": "flexor at motor"}, "limits": {"max_pretension": "120 N"}}
    found = tendon.design(tendon.study(asked)).choices.iloc[0]
    assert found.pretension_to == pytest.approx(120.0, rel=1e-12)
    assert found.to_by == "max_pretension"
    run = tendon.sweep(tendon.study({**asked, "tendon": {"pretension": ["119 N", "121 N"]}}))
    assert run.designs["feasible"].tolist() == [True, False]


def test_a_reading_that_no_pretension_gives_is_refused_with_what_could_be_read():
    with pytest.raises(
        tendon.TendonError, match=r"cannot be read as flexor at joint, which shows .* N or more"
    ):
        tendon.study(
            {**K5, "setting": {"read": "flexor at joint"}, "tendon": {"pretension": "0.2 N"}}
        )
    sides = {"pretension": "100 N", "extensor": {"pretension": "80 N"}}
    with pytest.raises(tendon.TendonError, match="one reading for both"):
        tendon.study({**K5, "setting": {"read": "flexor at joint"}, "tendon": sides})
