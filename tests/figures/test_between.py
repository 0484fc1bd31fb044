"""The window over the angle: lines as in the record, dots on what binds, a band for the window."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.figures.arm import arm_page
from tendon_cli.figures.scales import off_default
from tendon_cli.studies.load import study_from
from tests.figures.runs import by_gid, words

ANKLE = {
    "name": "ankle",
    "excursion": {
        "angle": ["-10 deg", "20 deg", "45 deg", "70 deg", "100 deg"],
        "flexor": ["-1.7 mm", "3.5 mm", "7.8 mm", "12.2 mm", "16 mm"],
        "extensor": ["-1.4 mm", "2.8 mm", "6.3 mm", "10 mm", "14 mm"],
    },
}


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory) -> tendon.Answer:
    content = {
        "spring": {"stiffness": ["5 kN/m", "8 kN/m"]},
        "spool": {"ratio": 0.5},
        "load": {"mass": ["0 kg", "5 kg"]},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
        "joint": {"name": "knee"},
    }
    return tendon.design(content, tmp_path_factory.mktemp("between") / "answer")


def test_the_window_is_what_the_lines_leave_at_all_angles(answer: tendon.Answer) -> None:
    figure = answer.plot("between")
    (panel,) = figure.axes
    curves = answer.record["between_samples"]["curves"]
    best = answer.record["best"]
    for end, side in (("from", "lower"), ("to", "upper")):
        for limit, values in curves[side].items():
            (line,) = by_gid(panel, f"{end} {limit}")
            drawn = line.get_ydata()
            recorded = np.array(values, dtype=np.float64)
            is_drawn = np.isfinite(drawn)
            np.testing.assert_allclose(drawn[is_drawn], recorded[is_drawn])
    # The dots are the angles of the study; the tightest is not far from the window's end.
    lower, upper = (line.get_ydata() for line in by_gid(panel, "samples"))
    assert len(lower) == len(curves["samples"]) == 7
    assert best["pretension_from"] >= np.nanmax(lower) - 1e-6 * best["pretension_from"]
    assert best["pretension_to"] <= np.nanmin(upper) + 1e-3 * best["pretension_to"]
    assert f"{np.degrees(best['from_elbow_angle']):.3g}°" in words(figure)
    assert "knee angle" in words(figure)
    assert "knee unstable" in words(figure)


def test_a_symbol_with_an_index_is_drawn_as_a_formula() -> None:
    content = {
        "name": "motors",
        "load": {"mass": "5 kg"},
        "motion": {"speed": "60 deg/s"},
        "limits": {"peak_motor_power": ["150 W", "200 W"]},
    }
    figure = tendon.design(content).plot("between")
    assert "$P_{m}$" in words(figure)
    assert "_" not in re.sub(r"\$[^$]*\$", "", words(figure))


READ_AT_THE_JOINT = {
    "setting": {"read": "flexor at joint"},
    "design": {"conditions": ["load.mass"]},
}
ARMS = [{"name": f"{angle}", "arm.upper_arm_angle": f"{angle} deg"} for angle in (-40, 0, 40)]
SERVE_HALF = {
    "arm": {"forearm_mass": "9 kg"},
    "table": [{"name": "posture", "role": "draw", "rows": ARMS}],
    "design": {"conditions": ["load.mass"], "serve": 0.5},
}


@pytest.mark.parametrize(
    ("more", "label", "of_all"),
    [
        (READ_AT_THE_JOINT, "tension in the flexor at the joint (N)", True),
        (SERVE_HALF, "pretension F₀ (N)", False),
    ],
    ids=["read at the joint", "half served"],
)
def test_what_is_set_lies_between_the_lines_as_it_is_read(
    more: dict[str, object], label: str, *, of_all: bool
) -> None:
    content: dict[str, object] = {
        "spring": {"stiffness": "8 kN/m"},
        "spool": {"ratio": 0.5},
        "load": {"mass": ["0 kg", "5 kg"]},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
        **more,
    }
    answer = tendon.design(content)
    figure = answer.plot("between")
    (panel,) = figure.axes
    assert panel.get_ylabel() == label
    curves = answer.record["between_samples"]["curves"]
    best = answer.record["best"]
    highest_from = np.nanmax(np.array(list(curves["lower"].values()), dtype=np.float64))
    lowest_to = np.nanmin(np.array(list(curves["upper"].values()), dtype=np.float64))
    assert highest_from <= best["pretension"] <= lowest_to
    assert curves["all_conditions"] == of_all
    text = " ".join(words(figure).split())
    assert ("Each line is the worst over all conditions" in text) == of_all
    assert ("window: works at every angle for at least 50 %" in text) != of_all
    assert ("The window serves at least 50 % of the draws" in text) != of_all
    assert ("works at that angle for those served" in text) != of_all
    if of_all:
        assert highest_from == pytest.approx(best["pretension_from"], rel=1e-3)
        assert lowest_to == pytest.approx(best["pretension_to"], rel=1e-3)


def test_the_page_shows_it_too_and_names_the_joint(answer: tendon.Answer, tmp_path: Path) -> None:
    page = tendon.report(answer, tmp_path / "page.html").read_text(encoding="utf-8")
    data = json.loads(page.partition('id="data">')[2].partition("</script>")[0])
    best = answer.record["best"]
    assert data["between"]["window"] == [best["pretension_from"], best["pretension_to"]]
    assert {len(line["values"]) for line in data["between"]["lines"]} == {91}
    assert data["angle"] == "knee angle"
    answer_text = page.partition("<main>")[2].partition('<section id="study')[0]
    assert re.findall(r"\bknees?\b", answer_text)
    assert not re.findall(r"\belbow\b", answer_text)


BEND_OVER_ANGLE = {"angle": ["0 deg", "90 deg"], "bend": ["3 rad", "4 rad"]}


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({}, []),
        ({"anchor": {"stiffness": "10 kN/m"}}, ["$K_{t}$ = 10 kN/m"]),
        (
            {"joint": {"stiffness": "1.1 N m/rad", "rest_angle": "73 deg"}},
            ["$k_{j}$ = 1.1 N m/rad", "$θ_{r}$ = 73 deg"],
        ),
        (
            {"spring": {"at": "motor", "flexor": {"stiffness": "rigid"}}},
            ["spring.at = motor", "K = rigid (flexor)"],
        ),
        ({"load": {"mass": ["0 kg", "5 kg"]}}, ["0 kg to 5 kg load"]),
        ({"sheath": {"friction": "0.09 +/- 0.02"}}, ["μ = 0.09 ± 0.02"]),
        ({"arm": {"b1": "140 mm to 160 mm"}}, ["b₁ = 150 mm ± 10 mm (uniform)"]),
        ({"setting": {"read": "flexor at joint"}}, ["setting.read = flexor at joint"]),
        ({"joint": ANKLE}, ["joint.excursion as in the study"]),
        ({"sheath": {"bend_angle": BEND_OVER_ANGLE}}, ["φ over the angle"]),
    ],
)
def test_what_is_off_its_default_is_named(content: dict[str, object], says: list[str]) -> None:
    study = study_from(content)
    assert off_default(study, (), {}) == says
    unnamed = [text for text in says if "K_{t}" not in text and "load" not in text]
    assert off_default(study, {"anchor_stiffness", "load_mass"}, {}) == unnamed


def test_a_joint_by_its_travels_is_drawn_as_curves_through_what_was_measured() -> None:
    study = study_from({"joint": ANKLE, "motion": {"elbow_angle": ["0 deg", "90 deg"]}})
    page = arm_page(study, [math.radians(45.0)])
    travel_panel, arm_panel = page.figure.axes
    travels = by_gid(travel_panel, "travel")
    measurements = by_gid(travel_panel, "measured")
    moment_arms = by_gid(arm_panel, "moment arm")
    for travel, measured, arm in zip(travels, measurements, moment_arms, strict=True):
        angle, values = travel.get_data()
        at_measured = np.interp(measured.get_xdata(), angle, values)
        np.testing.assert_allclose(at_measured, measured.get_ydata(), atol=1e-2)
        assert np.interp(0.0, angle, values) == pytest.approx(0.0, abs=1e-3)
        # The moment arm is the slope of the travel.
        slope = np.gradient(values, np.radians(angle))
        np.testing.assert_allclose(slope[1:-1], arm.get_ydata()[1:-1], rtol=1e-3)
    assert travel_panel.get_xlabel() == "ankle angle θ (deg)"


def test_a_window_of_one_angle_is_said_to_work_at_this_angle() -> None:
    content = {
        "spring": {"stiffness": "8 kN/m"},
        "spool": {"ratio": 0.5},
        "motion": {"elbow_angle": "60 deg"},
    }
    text = " ".join(words(tendon.design(content).plot("between")).split())
    assert "window: works at this angle" in text
    assert "Proved for the angle of 60 deg." in text
    assert "every angle" not in text
