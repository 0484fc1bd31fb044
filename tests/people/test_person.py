"""`tendon state --person`: how a body becomes an arm, and the state on that arm."""

import pytest

from tendon_cli.engine.plan import Plan
from tendon_cli.errors import UsageError
from tendon_cli.model import actuator
from tendon_cli.state_page.page import state_page
from tendon_cli.studies.load import study_from
from tendon_cli.studies.people.person import person_study
from tendon_cli.studies.spaces import space_of
from tests.model import designs

AT_75 = {"motion": {"elbow_angle": "75 deg", "direction": "flexion"}}


def test_the_page_begins_with_the_body_and_its_arm_and_goes_on_with_its_state():
    page = state_page(study_from(AT_75), person="mean-woman")
    text = page.text
    assert text.index("Body: mean-woman") < text.index("From body to arm") < text.index("Geometry")
    arm = {
        "a1": 0.040 * 305.58 / 358.14,
        "b1": 0.150 * 311.20 / 335.24,
        "a2": 0.020 * 264.08 / 310.06,
        "b2": 0.150 * 241.33 / 267.88,
        "elbow_radius": 0.045 * 264.08 / 310.06,
        "forearm_mass": 0.022 * 67.76,
        "forearm_com": 0.682 * 0.24133,
        "load_distance": 0.31771,
    }
    design = designs.design(designs.baseline(**arm))
    state = actuator.evaluate(design, 75 * 3.141592653589793 / 180, flexion=True)
    assert page.columns["motor_torque"] == pytest.approx(float(state.motor_torque), rel=1e-9)
    from_body = {
        line.symbol: line.values[0] for line in page.lines if line.section == "From body to arm"
    }
    assert list(from_body.values()) == pytest.approx(list(arm.values()), rel=1e-9)


def test_the_mean_man_has_the_anchors_of_the_study_and_its_stated_numbers_stay():
    study = study_from(
        AT_75 | {"arm": {"forearm_mass": "1.2 kg", "a1": "50 mm", "b1": ["140 mm", "160 mm"]}}
    )
    worn = person_study(study, "mean-man")
    assert worn.study.numbers["arm.a1"].single == 0.05
    assert worn.study.numbers["arm.b1"].array.tolist() == [0.14, 0.16]
    assert worn.study.axes == ("arm.b1",)
    (mass,) = [step for step in worn.arm if step.quantity == "forearm_mass"]
    assert mass.value == 1.2
    assert mass.formula == "as the study states it"


def forearm_mass_on(page):
    """Return the mass of the forearm on a page, kg."""
    return next(line.values[0] for line in page.lines if line.symbol == "m_f")


def test_a_study_of_people_shows_its_first_person_or_the_one_asked_for(tmp_path):
    (tmp_path / "people.csv").write_text("name,weight (kg)\nAda,62\nBo,90\n", encoding="utf-8")
    study = study_from({"people": {"file": "people.csv"}}, folder=tmp_path)
    first = state_page(study)
    second = state_page(study, person="Bo")
    assert "Body: Ada" in first.text
    assert forearm_mass_on(first) == pytest.approx(0.022 * 62)
    assert forearm_mass_on(second) == pytest.approx(0.022 * 90)


@pytest.mark.parametrize("people", [{}, {"people": {"count": 3}}])
def test_an_unknown_name_is_refused(people):
    with pytest.raises(UsageError, match='no person "mean-mann"') as error:
        state_page(study_from(people), person="mean-mann")
    assert error.value.hint == 'did you mean "mean-man"?'
    with pytest.raises(UsageError) as error:
        state_page(study_from(people), person="x\x1b[2J")
    assert "\x1b" not in error.value.message


def test_uncertain_numbers_are_nominal_or_those_of_a_draw_that_is_asked_for():
    content = AT_75 | {"people": {"count": 3}, "sheath": {"friction": {"mean": 0.07, "std": 0.01}}}
    study = study_from(content | {"uncertainty": {"draws": 4}})
    middle = state_page(study, person="man 2")
    third_draw = state_page(study, person="man 2", draw=3)
    nominal = state_page(study_from(content | {"sheath": {"friction": 0.07}}), person="man 2")
    assert middle.columns == nominal.columns
    plan = Plan(study)
    number = study.people.population.names.index("man 2") * 4 + 2
    (block,) = plan.blocks(range(number, number + 1))
    torque = float(plan.state(block).motor_torque.item())
    assert third_draw.columns["motor_torque"] == pytest.approx(torque, rel=1e-12)
    with pytest.raises(UsageError, match="there is no draw 5"):
        state_page(study, draw=5)


def test_the_page_of_a_draw_says_which_draw_it_is_and_which_numbers_that_has():
    content = {"sheath": {"friction": {"mean": 0.07, "std": 0.01}}, "uncertainty": {"draws": 4}}
    study = study_from(content)
    (draws,) = space_of(study).axes
    for number, friction in enumerate(draws.numbers["sheath.friction"], start=1):
        page = state_page(study, draw=number)
        (note,) = [note for note in page.notes if note.startswith("draw ")]
        assert note == f"draw {number} of 4: sheath.friction = {friction:.6g}"
        assert page.study.numbers["sheath.friction"].single == friction
    for number in (0, 5):
        with pytest.raises(UsageError, match=f"there is no draw {number}") as error:
            state_page(study, draw=number)
        assert error.value.hint == "expected 1 to 4"
