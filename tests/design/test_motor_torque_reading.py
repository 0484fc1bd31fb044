"""A pretension that is set by the torque of the motor: windows, units and what it cannot tell."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.cube.columns import TableColumns
from tendon_cli.errors import StudyError
from tendon_cli.studies.load import study_from
from tests.answers import answered
from tests.people import plain_suit

SUIT = {
    "spring": {"stiffness": "5 kN/m"},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "10 kg"]},
}
TORQUE = {"setting": {"read": "motor torque"}}


def test_the_window_is_that_of_f0_as_the_motor_shows_it():
    as_f0 = answered(SUIT).record["best"]
    as_torque = answered(SUIT | TORQUE).record["best"]
    for end in ("pretension_from", "pretension_to"):
        back = plain_suit.papers_arm(5e3).pretension(as_torque[end], "motor torque")
        assert back == pytest.approx(as_f0[end], rel=1e-9)


def test_a_sweep_takes_a_torque_and_has_columns_in_newton_metres():
    torque = tendon.sweep(SUIT | TORQUE | {"tendon": {"pretension": ["1.4 N m", "1.6 N m"]}})
    designs = torque.designs
    assert designs.attrs["units"]["pretension"] == "N m"
    assert designs.attrs["units"]["pretension_from"] == "N m"
    assert designs.attrs["units"]["model_pretension"] == "N"
    back = [
        float(plain_suit.papers_arm(5e3).pretension(shown, "motor torque"))
        for shown in designs["pretension"]
    ]
    np.testing.assert_allclose(designs["model_pretension"], back, rtol=1e-9)
    # At rest in the posture of the setting the motor holds what is read.
    still = {
        "motion": {"elbow_angle": "0 deg", "direction": "extension"},
        "tendon": {"pretension": "1.5 N m"},
    }
    state = tendon.sweep({**SUIT, "load": {"mass": "0 kg"}, **TORQUE, **still}).states
    assert state["motor_torque"].item() == pytest.approx(1.5, rel=1e-12)


def test_rows_are_shown_in_newton_metres():
    answer = answered(SUIT | TORQUE)
    table = TableColumns.of(answer.table("choices").schema)
    assert table.quantities["pretension"].shown_in == "N m"
    assert table.quantities["pretension_from"].dimension == "torque"
    assert table.quantities["max_tension"].shown_in == "N"
    assert answer.record["question"]["unit"] == "N m"


def test_texts_say_newton_metres():
    text = " ".join(answered(SUIT | TORQUE).text.split())
    assert "Set a motor torque of 1.5" in text
    assert " N m of motor torque (4.8 N of F0)" in text
    limits = {"limits": {"max_pretension": "1.5 N m"}}
    limited = tendon.design(SUIT | TORQUE | limits)
    assert limited.record["best"]["pretension_to"] == pytest.approx(1.5)
    assert "above 1.5 N m the pretension is above 1.5 N m" in " ".join(limited.text.split())


@pytest.mark.parametrize(
    ("content", "key"),
    [
        ({"tendon": {"pretension": "100 N"}}, "tendon.pretension"),
        ({"limits": {"max_pretension": "200 N"}}, "limits.max_pretension"),
        ({"design": {"pretension": "38 N"}}, "design.pretension"),
        ({"setting": {"read": "motor torque", "reading_error": "5 N"}}, "setting.reading_error"),
        ({"setting": {"read": "motor torque", "accuracy": "5 N"}}, "setting.accuracy"),
    ],
)
def test_a_tension_is_refused_where_a_torque_is_read(content, key):
    with pytest.raises(
        StudyError, match=rf'{key}: is a tension, but setting.read = "motor torque"'
    ):
        study_from(SUIT | TORQUE | content)


def test_a_torque_is_refused_where_a_tension_is_read():
    with pytest.raises(StudyError, match=r"tendon\.pretension: is a torque"):
        study_from(SUIT | {"tendon": {"pretension": "2 N m"}})
    with pytest.raises(StudyError, match="mixes tensions and torques"):
        study_from(SUIT | TORQUE | {"tendon": {"pretension": ["2 N m", "100 N"]}})


def test_a_sweep_needs_a_stated_torque():
    with pytest.raises(StudyError, match=r'needed with setting\.read = "motor torque"'):
        tendon.sweep(SUIT | TORQUE)


def test_a_torque_that_falls_as_both_tendons_tighten_is_refused():
    # With equal spools friction after extension outweighs the flexor's shorter moment arm.
    equal = SUIT | TORQUE | {"spool": {"ratio": [0.6, 1.0]}}
    arm = plain_suit.papers_arm(5e3)
    arm.ratio = 1.0
    low = arm.pretension(0.0, "motor torque")
    high = arm.pretension(1.0, "motor torque")
    assert high < low
    with pytest.raises(StudyError, match="does not determine the pretension in 2 of 4 designs"):
        study_from(equal)


def test_a_draw_in_which_the_torque_falls_is_refused():
    rough = SUIT | TORQUE | {"sheath": {"friction": "0.07 +/- 0.1"}}
    with pytest.raises(StudyError, match=r"does not determine the pretension in [0-9]+ of 512 "):
        tendon.design(rough)
    assert len(tendon.sweep(rough | {"tendon": {"pretension": "1.5 N m"}}).designs) == 2


def test_no_change_helps_that_makes_the_torque_fall():
    # From 0 N m on no window is left; a larger spool of the extensor would turn the reading around.
    narrow = {
        "load": {"mass": ["0 kg", "30 kg"]},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 5}},
    }
    fixes = tendon.design(SUIT | TORQUE | narrow).record["fixes"]
    for fix in fixes:
        if fix["after"] is not None:
            table, name = fix["parameter"].split(".")
            content = SUIT | TORQUE | narrow
            study_from(content | {table: content.get(table, {}) | {name: fix["after"]}})


def test_the_study_reads_back_from_its_document():
    content = {"setting": {"read": "motor torque", "reading_error": "0.05 N m"}}
    study = study_from(SUIT | content | {"tendon": {"pretension": "1.5 N m"}})
    assert study_from(study.document()).hash == study.hash
    accurate = {"setting": {"read": "motor torque", "accuracy": "0.1 N m"}}
    study = study_from(SUIT | accurate)
    assert study_from(study.document()).hash == study.hash
