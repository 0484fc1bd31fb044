"""Uncertain numbers are drawn whether or not a study says so; exact ones are named."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.answers.assumed import largest_move
from tendon_cli.engine.windows.question import question_of
from tendon_cli.errors import StudyError
from tendon_cli.studies.load import study_from
from tendon_cli.studies.usual import USUAL
from tests.answers import answered as known_answer
from tests.sampled import quick_and_torture

SUIT = {
    "spring": {"stiffness": "5 kN/m"},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "10 kg"]},
}
ROUGH = {"sheath": {"friction": "0.07 +/- 0.014"}}


def answered(**content):
    return known_answer(SUIT | content)


def exact_in(answer):
    """Return what an answer says of numbers that it takes as exact, by key."""
    return {of["key"]: of for of in answer.record["assumed"] if of["kind"] == "exact"}


# --- Draws ----------------------------------------------------------------------------------------


def test_an_answer_draws_what_is_uncertain_as_if_the_study_said_so():
    silent = question_of(study_from(SUIT | ROUGH))
    stated = question_of(study_from(SUIT | ROUGH | {"uncertainty": {"draws": 256, "seed": 1}}))
    assert silent.study.hash == stated.study.hash
    assert silent.serve == 0.95
    for key, values in stated.condition_numbers.items():
        np.testing.assert_array_equal(silent.condition_numbers[key], values)


def test_no_draws_are_the_middle():
    middle = answered(**ROUGH, uncertainty={"draws": 0})
    exact = answered(sheath={"friction": 0.07})
    for name in ("pretension_from", "pretension_to", "pretension", "served"):
        assert middle.record["best"][name] == exact.record["best"][name]
    assert "take their middle value (sheath.friction)" in " ".join(middle.text.split())


def test_a_sweep_takes_the_middle_and_says_so():
    run = tendon.sweep(SUIT | ROUGH)
    assert len(run.designs) == 2
    middle = "take their middle value (sheath.friction)"
    assert any(middle in text for text in run.record["warnings"])
    assert not tendon.sweep(SUIT).record["warnings"]


def test_an_answer_refuses_a_case_that_sets_what_is_drawn():
    content = SUIT | ROUGH | {"cases": [{"name": "dry", "sheath": {"friction": 0.1}}]}
    with pytest.raises(StudyError, match=r"cases\.0\.sheath\.friction: .* is uncertain"):
        question_of(study_from(content))
    question_of(study_from(content | {"uncertainty": {"draws": 0}}))


def test_draws_have_a_spread_of_what_is_not_read():
    arm = {"elbow_radius": "45 mm +/- 2 mm"}
    answer = answered(arm=arm, setting={"read": "flexor at joint"})
    spread = answer.record["population"]["set"]
    low, high = spread["set_flexor_tension"]
    assert low == pytest.approx(high, rel=1e-9)
    low, high = spread["set_extensor_tension"]
    # The moment balance ties both tensions: y = x J / R, and nine in ten radii are within 1.64 sd.
    assert high / low == pytest.approx((45 + 2 * 1.645) / (45 - 2 * 1.645), rel=0.02)
    assert "in nine of ten draws" in " ".join(answer.text.split())


# --- Taken as exact -------------------------------------------------------------------------------


def test_an_exact_number_moves_an_end_as_the_same_question_with_another_value():
    taken = exact_in(answered())
    assert "sheath.friction" in taken
    assert "load.mass" not in taken  # a condition
    assert "joint.stiffness" not in taken  # not stated
    before = answered().record["best"]
    for key, share in (("arm.b1", 0.05), ("spring.stiffness", 0.2), ("spool.ratio", 0.5)):
        record = taken[key]
        value = record["value"] + share * record["deviation"]
        table, name = key.split(".")
        after = answered(**{table: SUIT.get(table, {}) | {name: value}}).record["best"]
        for end in ("from", "to"):
            change = after[f"pretension_{end}"] - before[f"pretension_{end}"]
            expected = share * record[f"moves_{end}"]
            assert change == pytest.approx(expected, rel=0.1, abs=0.02)


def test_what_a_study_draws_is_not_taken_as_exact():
    answer = answered(**ROUGH)
    assert "sheath.friction" not in exact_in(answer)
    kinds = {of["key"]: of["kind"] for of in answer.record["assumed"]}
    assert kinds["sheath.friction"] == "normal"
    moves = [largest_move(of) for of in answer.answer.assumed if of.kind != "given"]
    assert moves == sorted(moves, reverse=True)


def test_persons_leave_out_what_comes_from_their_bodies():
    answer = answered(people={"count": 20}, design={"serve": 0.5})
    taken = {of["key"] for of in answer.record["assumed"] if of["kind"] != "given"}
    assert not taken & {"arm.forearm_mass", "arm.forearm_com", "arm.load_distance"}


def test_usual_deviations_are_those_that_the_documentation_lists():
    assert USUAL["spring.stiffness"].of(5e3) == 250.0
    assert USUAL["arm.a1"].of(0.04) == 5e-3
    assert USUAL["anchor.stiffness"].text("anchor.stiffness") == "a factor of 1.4"


# --- The error of the gauge -----------------------------------------------------------------------


@pytest.mark.parametrize(
    "read", quick_and_torture(["flexor at joint"], ["pretension", "extensor at motor"])
)
def test_an_error_of_the_gauge_narrows_the_window_by_its_quantile(read):
    exact = answered(setting={"read": read}).record["best"]
    error = {"read": read, "reading_error": "2 N"}
    of_sample = {"uncertainty": {"draws": 1024}, "design": {"verify": 0}}
    drawn = answered(setting=error, **of_sample).record["best"]
    # 95 % of the errors are above their lower 5 % quantile, at 1.645 standard deviations; the
    # window is wide enough that no error misses both ends.
    assert drawn["pretension_from"] == pytest.approx(exact["pretension_from"] + 2 * 1.645, abs=0.05)
    assert drawn["pretension_to"] == pytest.approx(exact["pretension_to"] - 2 * 1.645, abs=0.05)


def test_an_error_of_the_gauge_is_stated_as_a_standard_deviation():
    study = study_from(SUIT | {"setting": {"reading_error": "5 N"}})
    assert study.uncertain["setting.reading_error"].spread == 5.0
    assert study_from(study.document()).hash == study.hash
    assert not study_from(SUIT | {"setting": {"reading_error": "0 N"}}).uncertain
    for wrong in ("-5 N", ["5 N"], "5 N +/- 1 N", "5 mm", {"from": "0 N", "to": "5 N"}):
        with pytest.raises(StudyError, match=r"setting\.reading_error"):
            study_from(SUIT | {"setting": {"reading_error": wrong}})


# --- The joint on other bodies --------------------------------------------------------------------


def test_the_stiffness_of_the_joint_goes_with_the_volume_of_the_arm():
    joint = {"stiffness": "1.1 N m/rad", "rest_angle": "73 deg", "stiffness_with": "arm_volume"}
    content = SUIT | {"people": {"count": 50}, "joint": joint}
    question = question_of(study_from(content))
    population = question.study.people.population
    body = population.body
    man = population.reference

    def volume(of):
        upper = of.acromion_radiale_length * of.biceps_circumference**2
        return upper + of.radiale_stylion_length * of.forearm_circumference**2

    design = question.designs(question.all_points())
    of_persons = np.ravel(design.arm.stiffness).reshape(50, -1)[:, 0]
    np.testing.assert_allclose(of_persons, 1.1 * volume(body) / volume(man), rtol=1e-12)
    page = tendon.state(study_from(content), person="man 3")
    assert page.study.numbers["joint.stiffness"].single == pytest.approx(of_persons[2])


def test_stiffness_with_needs_a_stiffness():
    with pytest.raises(StudyError, match=r"joint\.stiffness_with: belongs to the joint's own"):
        study_from(SUIT | {"joint": {"stiffness_with": "arm_volume"}})


def test_a_setting_nearer_to_an_end_than_the_usual_errors_is_always_said():
    near = answered(spring={"stiffness": "3 kN/m"}, spool={"ratio": 0.5})
    best = near.record["best"]
    moves = [record["moves_from"] or 0.0 for record in exact_in(near).values()]
    away = best["pretension"] - best["pretension_from"]
    together = np.linalg.norm(moves)
    assert away < together
    said = f"lower end by {together:.2g} N (the setting is {away:.2g} N above it)"
    assert said in " ".join(near.short.split())
    middle = answered(
        spring={"stiffness": "8 kN/m"},
        spool={"ratio": 0.5},
        load={"mass": "5 kg"},
        design={"pretension": "middle"},
    )
    assert "the setting is" not in middle.short
