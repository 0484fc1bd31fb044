"""Effects of a real suit on the window.

Anchors that give, the joint's own torque, the place of the spring, and how pretension is read.
"""

import json

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.model.design import READINGS
from tendon_cli.model.setting import Reading, all_readings
from tendon_cli.studies.spaces import space_of
from tests.answers import answered, solved

SUITS = {"K 5": ("5 kN/m", 0.6), "K 8": ("8 kN/m", 0.5)}


def first_choice(content):
    """Return the first choice of the answer to a study."""
    return answered(content).choices.iloc[0]


def window(suit, tables=None, loads=("0 kg", "10 kg")):
    """Return both ends of the window of a suit with keys of some tables replaced, N."""
    stiffness, ratio = SUITS[suit]
    content = {
        "allow_implausible": True,
        "spring": {"stiffness": stiffness},
        "spool": {"ratio": ratio},
        "load": {"mass": list(loads)},
    }
    for table, keys in (tables or {}).items():
        content[table] = content.get(table, {}) | keys
    choice = solved(content)
    return choice.pretension_from[0], choice.pretension_to[0]


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
def test_each_effect_changes_the_window_as_in_the_checked_model(tables, first, second):
    """Section 16 of the checked model: 0 and 10 kg, 0 to 90 degrees, no slack, k >= 0."""
    for suit, expected in zip(SUITS, (first, second), strict=True):
        low, high = window(suit, tables)
        if expected is None:
            assert not low <= high
            continue
        expected_low, expected_high = expected
        if expected_low is None:
            assert high == pytest.approx(expected_high, abs=0.51)
            continue
        has_two_digits = any(round(end, 1) != end for end in expected)
        rounding = 0.0051 if has_two_digits else 0.06
        assert low == pytest.approx(expected_low, abs=rounding)
        assert high == pytest.approx(expected_high, abs=rounding)


@pytest.mark.parametrize(
    ("stiffness", "expected"), [("3 kN/m", (160.7, 168.3)), ("1 kN/m", (103.3, 106.3))]
)
def test_the_joints_own_stiffness_opens_the_windows_that_the_papers_suits_lack(stiffness, expected):
    choice = first_choice(
        {
            "spring": {"stiffness": stiffness},
            "load": {"mass": ["0 kg", "5 kg"]},
            "joint": {"stiffness": "1.8 N m/rad", "rest_angle": "73 deg"},
        }
    )
    ends = (choice.pretension_from, choice.pretension_to)
    assert ends == pytest.approx(expected, abs=0.051)


RIGID = {"stiffness": "rigid"}
HALF = {"stiffness": "10 kN/m"}
SMOOTH = {"friction": 0.0}
SAME = {
    "an anchor in place of a spring": ({"spring": RIGID, "anchor": {"stiffness": "5 kN/m"}}, {}),
    "1/K adds up at the joint": ({"spring": HALF, "anchor": HALF}, {}),
    "either end without friction": (
        {"sheath": SMOOTH, "spring": {"at": "motor"}},
        {"sheath": SMOOTH},
    ),
}


@pytest.mark.parametrize("name", SAME)
def test_suits_that_are_the_same_have_the_same_window(name):
    first, second = SAME[name]
    assert window("K 5", first) == pytest.approx(window("K 5", second), rel=1e-12)


def test_the_stiffer_the_anchor_the_nearer_a_rigid_one():
    windows = [
        window("K 5", {"anchor": {"stiffness": f"{stiffness} kN/m"}})
        for stiffness in (10, 20, 100, 1e6)
    ]
    assert (np.diff(np.array(windows), axis=0) > 0.0).all()
    assert windows[-1] == pytest.approx(window("K 5"), rel=1e-4)


def test_sides_cases_and_axes_say_where_a_spring_is_and_how_stiff_anchors_are():
    content = {
        "cases": [
            {"name": "all at the joint"},
            {"name": "flexor at the motor", "spring": {"flexor": {"at": "motor"}}},
            {"name": "soft", "anchor": {"extensor": {"stiffness": "6 kN/m"}}},
        ],
        "anchor": {"stiffness": ["rigid", "20 kN/m"]},
        "spool": {"ratio": 0.6},
        "spring": {"extensor": {"stiffness": ["5 kN/m", "rigid"]}, "stiffness": "5 kN/m"},
        "motion": {"elbow_angle": ["30 deg", "80 deg"]},
    }
    designs = tendon.sweep(content).designs
    assert len(designs) == 12
    assert set(designs["spring_stiffness_extensor"]) == {5e3, np.inf}
    soft = designs[designs["case"] == "soft"]
    assert set(soft["anchor_stiffness_extensor"]) == {6e3}
    assert set(soft["anchor_stiffness_flexor"]) == {np.inf, 2e4}
    assert designs.groupby("case", observed=True)["pretension_from"].first().nunique() == 3


def test_an_uncertain_anchor_is_drawn():
    answer = tendon.design(
        {
            "anchor": {"stiffness": {"value": "10 kN/m", "tolerance": "20 %"}},
            "uncertainty": {"draws": 16},
            "spring": {"stiffness": "8 kN/m"},
            "spool": {"ratio": 0.5},
            "load": {"mass": ["0 kg", "10 kg"]},
        }
    )
    assert answer.feasible == 1
    assert len(answer.conditions) == 32
    _, stiffest_to = window("K 8", {"anchor": {"stiffness": "12 kN/m"}})
    assert 0.0 < answer.choices["pretension_to"].iloc[0] < stiffest_to


def test_a_rigid_spring_is_infinite_in_tables_and_a_word_elsewhere():
    springs = {"spring": {"stiffness": ["rigid", "5 kN/m"]}, "spool": {"ratio": 0.6}}
    study = tendon.study({**springs, "design": {"prove": ["0"]}})
    answer = tendon.design(study)
    assert answer.choices["spring_stiffness"].tolist() == [np.inf, 5e3]
    assert '"spring_stiffness": "rigid"' in json.dumps(answer.record)
    assert "rigid" in answer.text
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
def test_gauges_show_the_tensions_of_the_arm_as_it_is_set(after, shown, read_as):
    """Section 16 of the checked model, for the middle of the window of K 5, 148.0 N."""
    study = tendon.study({**K5, "tendon": {"pretension": MIDDLE}, "setting": {"after": after}})
    design = space_of(study).design()
    readings = all_readings(design, MIDDLE)
    assert tuple(round(float(value), 1) for value in readings.values()) == shown
    pretensions = [
        float(Reading.of(design, f"{side} at joint").pretension(MIDDLE))
        for side in ("flexor", "extensor")
    ]
    assert tuple(round(value, 1) for value in pretensions) == read_as
    values = {line["symbol"]: line["values"] for line in tendon.state(study).record["lines"]}
    assert [*values["F_o,set"], *values["F_I,set"]] == pytest.approx(list(shown), abs=0.051)
    assert values["dF0/dl"][0] == pytest.approx(4.81e3, rel=2e-3)


@pytest.mark.parametrize("read", READINGS[1:])
def test_a_study_in_readings_gives_the_same_suit(read):
    content = {**K5, "load": {"mass": ["0 kg", "10 kg"]}}
    in_f0 = first_choice({**content, "setting": {"read": "pretension"}})
    in_readings = first_choice({**content, "setting": {"read": read}})
    reading = Reading.of(space_of(tendon.study(K5)).design(), read)
    for end in ("pretension_from", "pretension_to", "pretension"):
        shown = float(reading.shown(in_f0[end]).item())
        assert in_readings[end] == pytest.approx(shown, rel=1e-12)
    for name in (
        "max_tension",
        "peak_motor_torque",
        "tolerance_length",
        "set_flexor_tension",
    ):
        assert in_readings[name] == pytest.approx(in_f0[name], rel=1e-10)
    for name in ("from_by", "to_by"):
        assert in_readings[name] == in_f0[name]

    def swept(pretension, **tables):
        given = {**content, **tables, "tendon": {"pretension": [pretension]}}
        return tendon.sweep(tendon.study(given)).designs

    designs = swept(in_readings.pretension, setting={"read": read})
    np.testing.assert_allclose(designs["model_pretension"], in_f0.pretension, rtol=1e-12)
    # The run has 91 angles, the answer has all.
    of_states = designs["max_tension"].max()
    assert in_f0.max_tension * (1.0 - 5e-5) <= of_states <= in_f0.max_tension * (1.0 + 1e-10)
    by_f0 = swept(in_f0.pretension)
    assert of_states == pytest.approx(by_f0["max_tension"].max(), rel=1e-10)
    assert designs["pretension_from"].max() == pytest.approx(in_readings.pretension_from, rel=1e-12)
    pretensions = (designs["required_pretension"] + designs["margin"]).to_numpy()
    assert pretensions == pytest.approx(in_readings.pretension, rel=1e-12)


def test_windows_of_different_arms_are_intersected_as_they_are_read():
    """One reading for all is another question than one F0 for all."""
    read = "extensor at joint"
    stiffnesses = ["0.4 N m/rad", "1.8 N m/rad"]
    both = first_choice(
        {
            **K5,
            "joint": {"stiffness": stiffnesses, "rest_angle": "73 deg"},
            "setting": {"read": read},
        }
    )
    windows = []
    for stiffness in stiffnesses:
        content = {**K5, "joint": {"stiffness": stiffness, "rest_angle": "73 deg"}}
        alone = first_choice(content)
        reading = Reading.of(space_of(tendon.study(content)).design(), read)
        ends = [
            float(reading.shown(alone[end]).item()) for end in ("pretension_from", "pretension_to")
        ]
        windows.append(ends)
    low, high = np.array(windows).T
    assert both.pretension_from == pytest.approx(low.max(), rel=1e-12)
    assert both.pretension_to == pytest.approx(high.min(), rel=1e-12)


def test_the_largest_pretension_is_a_reading_too():
    content = {**K5, "setting": {"read": "flexor at motor"}, "limits": {"max_pretension": "120 N"}}
    choice = first_choice(content)
    assert choice.pretension_to == pytest.approx(120.0, rel=1e-12)
    assert choice.to_by == "max_pretension"
    run = tendon.sweep(tendon.study({**content, "tendon": {"pretension": ["119 N", "121 N"]}}))
    assert run.designs["feasible"].tolist() == [True, False]


def test_a_reading_that_no_pretension_gives_is_refused_with_those_that_are_possible():
    content = {**K5, "setting": {"read": "flexor at joint"}}
    with pytest.raises(
        tendon.TendonError, match=r"cannot be read as flexor at joint, which shows .* N or more"
    ):
        tendon.study({**content, "tendon": {"pretension": "0.2 N"}})
    sides = {"pretension": "100 N", "extensor": {"pretension": "80 N"}}
    with pytest.raises(tendon.TendonError, match="a single reading for both"):
        tendon.study({**content, "tendon": sides})


SET_UNDER_LOAD = {**K5, "setting": {"read": "flexor at motor", "load": "10 kg", "angle": "90 deg"}}
"""Suit that is set while it holds a load: its gauge shows more than 100 N with slack tendons."""


def test_a_pretension_that_no_study_states_is_never_at_fault():
    study = tendon.study(SET_UNDER_LOAD)
    assert tendon.design(study).record["choices"] == 1
    page = tendon.state(study)
    run = tendon.sweep(study)
    # The gauge cannot show 100 N: the default is what it shows at F0 = 100 N, rounded up.
    assert run.designs["model_pretension"].item() >= 100.0
    shown = Reading.of(space_of(study).design()).shown(100.0).item()
    assert run.designs["pretension"].item() == np.ceil(shown)
    stated = {**SET_UNDER_LOAD, "tendon": {"pretension": run.designs["pretension"].item()}}
    assert tendon.sweep(stated).designs.equals(run.designs)
    assert page.columns == tendon.state(stated).columns
    with pytest.raises(tendon.TendonError, match="cannot be read as flexor at motor"):
        tendon.study({**SET_UNDER_LOAD, "tendon": {"pretension": "100 N"}})


def test_a_default_pretension_holds_for_all_designs_and_draws_and_is_read_back():
    friction = {"mean": 0.1, "std": 0.02}
    content = {
        **SET_UNDER_LOAD,
        "load": {"mass": ["0 kg", "5 kg"]},
        "setting": {**SET_UNDER_LOAD["setting"], "load": ["5 kg", "10 kg"]},
        "sheath": {"friction": friction},
        "uncertainty": {"draws": 2},
    }
    study = tendon.study(content)
    run = tendon.sweep(study)
    assert run.designs["pretension"].nunique() == 1
    assert run.designs["model_pretension"].min() >= 100.0
    read_back = tendon.study(study.document())
    assert read_back.hash == study.hash
    lighter = study.vary(**{"setting.load": "0 kg"})
    assert lighter.numbers["tendon.pretension"].single == 100.0
    shown = {
        tendon.state(study, draw=draw).study.numbers["tendon.pretension"].single for draw in (1, 2)
    }
    assert shown == set(run.designs["pretension"])


def test_a_gauge_over_a_slack_tendon_tells_no_window():
    """A stiff joint pulls the arm up as the suit is set, so that the flexor hangs loose at first.

    Whatever the pretension, up to one that pulls it tight, the gauge shows nothing.
    """
    travels = {
        "angle": ["-45 deg", "30 deg", "105 deg", "180 deg"],
        "flexor": ["0 mm", "37 mm", "65 mm", "88 mm"],
        "extensor": ["0 mm", "45 mm", "85 mm", "122 mm"],
    }
    suit = {
        "spool": {"ratio": 0.9},
        "spring": {"stiffness": "28.8 kN/m", "at": "motor"},
        "joint": {"stiffness": "5 N m/rad", "rest_angle": "68 deg", "excursion": travels},
        "motion": {"elbow_angle": "115 deg"},
    }
    found = []
    for limit in ("10 mm", "20 mm", "30 mm"):
        limited = {**suit, "limits": {"max_spring_extension": limit}}
        read = {**limited, "setting": {"read": "flexor at joint"}}
        row = solved(read)
        found.append((bool(solved(limited).feasible[0]), bool(row.feasible[0])))
        if row.feasible[0]:
            ends = [row.pretension_from[0], row.pretension_to[0] * (1.0 - 1e-9)]
            inside = [ends[0], row.pretension[0], ends[1]]
            run = tendon.sweep({**read, "tendon": {"pretension": inside}})
            assert run.designs.feasible.all()
    assert found == [(False, False), (True, False), (True, True)]


@pytest.mark.parametrize("rows", [3, 4, 30])
def test_moment_arms_that_do_not_change_leave_the_window_without_an_upper_end(rows):
    """However many rows state the same straight lines: no slope, nothing to become unstable by."""
    angles = np.linspace(0.0, 1.7, rows)
    excursion = {
        "angle": [f"{angle!r} rad" for angle in angles.tolist()],
        "flexor": (0.03 * angles).tolist(),
        "extensor": (0.02 * angles).tolist(),
    }
    choice = first_choice({"joint": {"excursion": excursion}, "load": {"mass": ["0 kg", "2 kg"]}})
    assert choice.pretension_from > 0.0
    assert np.isnan(choice.pretension_to)
    assert choice.feasible
