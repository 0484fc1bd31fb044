"""Anchors that a study states: the survey's mean man's, or measured on the person of a file."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.errors import StudyError, UsageError
from tendon_cli.model.body import ANCHOR_ALONG
from tendon_cli.studies.load import study_from
from tendon_cli.studies.people.people_section import BODIES
from tendon_cli.studies.people.person import person_study
from tendon_cli.studies.space.axis import scale_of
from tendon_cli.studies.spaces import space_of, wearer_axis
from tests.people.in_full import in_full

ONE = "name,sex,stature (cm)\nEve,female,152\n"
TWO = ONE + "Bo,male,181\n"
STATED = {"a1": 0.033, "b1": 0.11, "a2": 0.017, "b2": 0.13, "elbow_radius": 0.041}
SUIT = {
    "spring": {"stiffness": 5e3},
    "spool": {"ratio": 0.6},
    "load": {"mass": [0.0, 5.0]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
}


def of_file(folder, arm, text=ONE, people=(), **content):
    """Return a study of the persons of a file, given as text, with a table of the arm."""
    (folder / "people.csv").write_text(text, encoding="utf-8")
    table = {"file": "people.csv", **dict(people)}
    return study_from({**content, "arm": arm, "people": table}, folder=folder)


def arms_in(study):
    """Return the anchors of the designs of a study as the model gets them, by name."""
    space = space_of(study)
    return {
        name: np.ravel(space.number(f"arm.{name}").within(space.whole)) for name in ANCHOR_ALONG
    }


@pytest.mark.parametrize("name", ANCHOR_ALONG)
def test_stated_anchors_and_a_file_of_persons_need_a_word_that_says_whose_they_are(tmp_path, name):
    with pytest.raises(StudyError, match=r"arm\.anchors: is needed") as error:
        of_file(tmp_path, {name: STATED[name]})
    assert f"states arm.{name} and has a file" in error.value.message
    assert 'anchors = "measured": measured on the one person' in error.value.message
    assert 'anchors = "mean man": those of the survey' in error.value.message
    of_file(tmp_path, {"forearm_mass": 1.2, "upper_arm_angle": "5 deg"})


def test_an_anchor_of_a_case_needs_the_word_too(tmp_path):
    cases = [{"name": "short", "arm": {"b1": 0.1}}, {"name": "usual"}]
    with pytest.raises(StudyError, match=r"states cases\.0\.arm\.b1 and has a file"):
        of_file(tmp_path, {}, cases=cases)
    of_file(tmp_path, {"anchors": "mean man"}, cases=cases)
    with pytest.raises(StudyError, match=r"cases\.0\.arm\.b1: .*give arm\.b1 in the study, too"):
        of_file(tmp_path, {"anchors": "measured"}, cases=cases)
    measured = of_file(tmp_path, {"anchors": "measured", "b1": 0.12}, cases=cases)
    assert arms_in(measured)["b1"].tolist() == [0.1, 0.12]


def test_no_other_case_is_named_where_each_states_the_anchor(tmp_path):
    cases = [{"name": "short", "arm": {"b1": 0.1}}, {"name": "long", "arm": {"b1": 0.13}}]
    with pytest.raises(StudyError, match=r"anchors of \[arm\], which does not state") as error:
        of_file(tmp_path, {"anchors": "measured"}, cases=cases)
    assert "elsewhere" not in error.value.message
    measured = of_file(tmp_path, {"anchors": "measured", "b1": 0.12}, cases=cases)
    assert sorted(set(arms_in(measured)["b1"])) == [0.1, 0.13]


@pytest.mark.parametrize("people", [{}, {"seed": 5}])
def test_measured_anchors_are_those_stated_to_the_bit_and_the_rest_scales(tmp_path, people):
    for stated in (STATED, {"b1": 0.11}, {"elbow_radius": 0.041}):
        study = of_file(tmp_path, stated | {"anchors": "measured"}, people=people)
        usual = arms_in(of_file(tmp_path, {}, people=people))
        for name, values in arms_in(study).items():
            expected = np.full_like(values, stated[name]) if name in stated else usual[name]
            np.testing.assert_array_equal(values, expected)


def test_the_wearer_is_one_person_however_many_bodies_were_drawn_before(tmp_path):
    measured = {"b1": 0.11, "anchors": "measured"}
    study = of_file(tmp_path, measured)
    assert len(study.people.population) == BODIES
    assert len(wearer_axis(study)) == 1


def test_anchors_of_the_mean_man_are_scaled_by_the_body(tmp_path):
    study = of_file(tmp_path, STATED | {"anchors": "mean man"}, TWO)
    people = study.people.population
    for name, dimension in ANCHOR_ALONG.items():
        ratio = getattr(people.body, dimension) / getattr(people.reference, dimension)
        np.testing.assert_allclose(arms_in(study)[name], STATED[name] * ratio, rtol=1e-14)


def test_measured_is_about_one_person_of_a_file_and_stated_anchors(tmp_path):
    measured = {"b1": 0.11, "anchors": "measured"}
    with pytest.raises(StudyError, match="is about one person, but the file has 2"):
        of_file(tmp_path, measured, TWO)
    with pytest.raises(StudyError, match="but a survey draws its persons"):
        study_from({"arm": measured, "people": {"count": 1}})
    with pytest.raises(StudyError, match="but this study states none"):
        of_file(tmp_path, {"anchors": "measured"})
    assert arms_in(study_from({"arm": measured}))["b1"].tolist() == [0.11]


def test_a_survey_and_stated_anchors_get_a_note():
    def notes(arm):
        study = study_from({"arm": arm, "people": {"count": 3}})
        again = study_from(study.document())
        assert again.warnings == study.warnings
        return [note for note in study.warnings if "mean man" in note]

    (note,) = notes({"b1": 0.11, "a2": 0.03})
    assert note.startswith("arm.b1 and arm.a2 as stated")
    assert notes({"b1": 0.11, "anchors": "mean man"}) == []
    short = {"name": "short", "arm": {"b2": 0.1}}
    (note,) = study_from({"people": {"count": 3}, "cases": [short]}).warnings
    assert note.startswith("arm.b2 as stated")
    assert notes({}) == notes({"forearm_mass": 1.0}) == []


@pytest.mark.parametrize("word", ["measured", "mean man"])
def test_a_record_keeps_whose_the_anchors_are(tmp_path, word):
    study = of_file(tmp_path, {"b1": 0.11, "anchors": word})
    again = study_from(study.document())
    assert again.hash == study.hash
    for name, values in arms_in(again).items():
        np.testing.assert_array_equal(values, arms_in(study)[name])
    scaled = {name for name in ANCHOR_ALONG if scale_of(f"arm.{name}") in space_keys(again)}
    assert scaled == set(ANCHOR_ALONG) - ({"b1"} if word == "measured" else set())


def space_keys(study):
    """Return the keys of what the persons of a study give."""
    return space_of(study).axes[0].numbers.keys()


def test_a_varied_study_is_asked_about_the_anchors_that_it_states_itself(tmp_path):
    study = of_file(tmp_path, {})
    assert study.vary(**{"load.mass": 3.0}).stated_anchors == ()
    with pytest.raises(StudyError, match=r"arm\.anchors: is needed"):
        study.vary(**{"arm.b1": 0.11})
    measured = study.vary(**{"arm.b1": 0.11, "arm.anchors": "measured"})
    assert set(arms_in(measured)["b1"]) == {0.11}
    file = str(tmp_path / "people.csv")
    alone = study_from({}).vary(people={"file": file})
    assert alone.stated_anchors == ()
    assert alone.body_numbers == study.body_numbers


def test_the_answer_for_a_measured_person_is_that_for_the_arm_typed_in(tmp_path):
    study = of_file(tmp_path, {"b1": 0.11, "anchors": "measured"}, in_full(ONE), **SUIT)
    worn = person_study(study, "Eve").study
    assert worn.people is None
    assert worn.arm.b1.single == 0.11
    answer = tendon.design(study)
    typed = tendon.design(worn)
    for column in ("pretension_from", "pretension_to", "set_flexor_tension", "tolerance_length"):
        of_person = answer.table("choices").column(column).to_numpy()
        np.testing.assert_allclose(
            of_person, typed.table("choices").column(column).to_numpy(), rtol=1e-12
        )
    assert " on this person, " in " ".join(answer.short.split())
    assert "the mean man" not in answer.text


def test_measured_anchors_are_of_nobody_else(tmp_path):
    study = of_file(tmp_path, {"b1": 0.11, "anchors": "measured"})
    steps = {step.quantity: step for step in person_study(study, "Eve").arm}
    assert steps["b1"].value == 0.11
    assert steps["b1"].formula == "as measured on this person"
    for studied in (study, study_from({"arm": {"b1": 0.11, "anchors": "measured"}})):
        with pytest.raises(UsageError, match="measured on its wearer, not on the mean-man"):
            person_study(studied, "mean-man")
