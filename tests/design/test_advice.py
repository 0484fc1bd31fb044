"""Advice on parts: what cannot be built is not named first, and what is ordered is enough."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.engine.windows.advice import HURTS, NARROW, NO_ROOM, WEAK
from tendon_cli.engine.windows.question import question_of
from tendon_cli.model.actuator import evaluate
from tendon_cli.model.winding import least_free_length
from tests.answers import answered as known_answer
from tests.answers import merged, solved

COARSE = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}}
SUIT = {
    "spring": {"stiffness": "5 kN/m"},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "5 kg"]},
}
LONG_SPRING = {
    "motion": COARSE,
    "arm": {"b1": "110 mm", "b2": "90 mm"},
    "spool": {"ratio": 0.5},
    "load": {"mass": ["0 kg", "5 kg"]},
}
"""Anchors so near to the elbow that only stiff springs fit between them."""
NO_SPRING = "no spring for the flexor can be wound in its room"


def answered(*contents):
    return known_answer(merged(*contents))


def codes(content):
    return solved(content).advice


def worst_spring(content, pretension, free_length=0.0):
    """Return the least of L_c − L_free − x/K and the largest travel, m, over all states.

    They are worked out from the model's states alone.
    """
    study = tendon.study(content)
    question = question_of(study)
    points = question.all_points().at_pretension(np.atleast_1d(pretension))
    angles = np.linspace(question.angles.min(), question.angles.max(), 901)[np.newaxis]
    state = evaluate(question.designs(points), angles, question.flexion)
    stretch = state.balance.flexor / state.design.flexor.spring_stiffness
    others = state.balance.extensor / state.design.extensor.spring_stiffness
    room = (state.motion.flexor_path - free_length - stretch).min(axis=(1, 2, 3))
    return room, np.maximum(stretch, others).max(axis=(1, 2, 3))


def test_a_spring_stretched_beyond_its_anchors_is_not_named_if_another_choice_can_be_built():
    soft = {"spring": {"stiffness": "0.6 kN/m"}}
    alone = answered(LONG_SPRING, soft)
    room, _ = worst_spring({**LONG_SPRING, **soft}, alone.best["pretension"])
    assert room.item() < 0.0
    assert alone.best["advice"] == NO_SPRING
    text = " ".join(alone.text.split())
    but = text.index("but it cannot be built: the flexor's spring is stretched by")
    assert but < text.index("Why")
    assert "between anchors" in text

    both = answered(LONG_SPRING, {"spring": {"stiffness": ["0.6 kN/m", "8 kN/m"]}})
    assert both.feasible == 2
    assert both.best["spring_stiffness"] == 8e3
    assert both.best["advice"] is None
    assert "cannot be built" not in both.text
    assert both.choices.advice.tolist() == [NO_SPRING, ""]


@pytest.mark.parametrize("free_length", [None, 0.07])
def test_a_spring_can_be_built_if_one_that_can_be_wound_has_room(free_length):
    """A stated spring must be as long as its winding needs; another may be as long as its room."""
    spring = {"stiffness": {"from": "0.5 kN/m", "to": "12 kN/m", "num": 24}}
    if free_length is not None:
        spring["free_length"] = free_length
    content = {**LONG_SPRING, "spring": spring}
    choices = solved(content)
    room, travel = worst_spring(content, choices.pretension, free_length or 0.0)
    np.testing.assert_allclose(choices.worst.spring_room, room, atol=2e-6)
    stiffness = choices.points.numbers["spring.stiffness"]
    needed = least_free_length(stiffness, stiffness * travel)
    if free_length is None:
        spare = np.minimum(room - needed, 1.2 * room - travel)
    else:
        of_spring = np.minimum(free_length - needed, 1.2 * free_length - travel)
        spare = np.minimum(room, of_spring)
    sure = np.abs(spare) > 1e-5
    has_no_room = (choices.advice & NO_ROOM) > 0
    assert has_no_room[sure].tolist() == (spare < 0.0)[sure].tolist()
    assert 0 < has_no_room.sum() < len(room)


@pytest.mark.parametrize(
    "spring", [{"stiffness": "rigid"}, {"stiffness": "0.6 kN/m", "at": "motor"}], ids=str
)
def test_a_rigid_spring_and_one_at_the_motor_need_no_room(spring):
    given = {"pretension": "60 N"}
    content = {**LONG_SPRING, "spring": spring, "design": given}
    assert not (codes(content) & NO_ROOM).any()


def test_parts_of_the_study_are_judged_on_either_side_of_their_bound():
    needed = answered(SUIT).record["parts_needed"]
    strap = needed["strap"]["least_width"]
    rope = needed["rope"]["least_breaking_force"]
    for part, key, value, code in (
        ("arm", "contact_width", strap, HURTS),
        ("tendon", "breaking_force", rope, WEAK),
    ):
        for factor, failing in ((1.0001, 0), (0.9999, code)):
            found = codes({**SUIT, part: {key: value * factor}})
            assert found.tolist() == [failing], (key, factor)
    spool = 0.036  # of the extensor
    for rope, ratio in (("7x7", 28.0), ("7x19", 18.0)):
        for factor, failing in ((0.9999, 0), (1.0001, NARROW)):
            tendons = {"rope": rope, "diameter": spool / ratio * factor}
            assert codes({**SUIT, "tendon": tendons}).tolist() == [failing], (rope, factor)


def test_what_is_needed_is_enough_once_the_study_states_it():
    answer = answered(SUIT)
    needed = answer.record["parts_needed"]
    assert needed["fails"] == []
    assert answer.best["advice"] is None
    stated = {
        "arm": {"contact_width": needed["strap"]["least_width"] * 1.0001},
        "tendon": {
            "breaking_force": needed["rope"]["least_breaking_force"] * 1.0001,
            "rope": "7x7",
            "diameter": "1.5 mm",
        },
        "spring": {"free_length": needed["spring"]["room"] - 1e-6},
        "spool": {"flexor_radius": needed["spool"]["least_diameter"] / 1.2 * 1.0001},
    }
    kept = answered(SUIT, stated)
    assert kept.best["advice"] is None
    assert kept.record["parts_needed"]["fails"] == []
    longer = answered(SUIT, stated, {"spring": {"free_length": needed["spring"]["room"] + 1e-3}})
    assert longer.record["parts_needed"]["fails"] == ["spring"]
    assert "but it cannot be built: the flexor's spring of" in " ".join(longer.short.split())


def test_no_window_depends_on_advice_and_without_it_nothing_is_judged():
    catalogue = {
        **LONG_SPRING,
        "spring": {"stiffness": ["0.6 kN/m", "2 kN/m", "8 kN/m"]},
        "tendon": {"rope": "7x7", "breaking_force": "900 N"},
    }
    plain = {**LONG_SPRING, "spring": catalogue["spring"]}
    answers = [
        answered(catalogue),
        answered(catalogue, {"design": {"advice": False}}),
        answered(plain),
    ]
    for other in answers[1:]:
        for name in ("pretension_from", "pretension_to", "pretension"):
            np.testing.assert_array_equal(answers[0].choices[name], other.choices[name])
        # Between the angles only the choices that are named have their worst values.
        tensions = [of.choices["max_tension"] for of in (answers[0], other)]
        np.testing.assert_allclose(*tensions, rtol=1e-4)
    assert (answers[0].choices.advice != "").all()
    assert (answers[1].choices.advice == "").all()
    assert answers[1].record["parts_needed"]["fails"] == []
    assert " but " not in answers[1].short.split("Why")[0]
    swept = [
        tendon.sweep({**content, "design": {"advice": advice}}).designs
        for content, advice in ((catalogue, True), (catalogue, False))
    ]
    assert swept[0].equals(swept[1])


def test_the_rest_of_the_advice_decides_between_choices_that_can_be_built():
    ropes = {"tendon": {"rope": "7x19", "diameter": "1.5 mm"}}
    choice = {"spool": {"ratio": [0.4, 0.6]}, "spring": {"stiffness": "5 kN/m"}}
    loads = {"load": {"mass": ["0 kg", "5 kg"]}}
    advised = answered(choice, loads, ropes).best
    unadvised = answered(choice, loads).best
    assert advised["spool_ratio"] == 0.6  # 24 rope diameters; 0.4 has 16, and needs less tension
    assert unadvised["spool_ratio"] == 0.4
    assert unadvised["max_tension"] < advised["max_tension"]


def test_the_motor_needs_what_a_sweep_over_the_same_states_finds():
    answer = answered(SUIT, {"motion": {"speed": "60 deg/s"}})
    needed = answer.record["parts_needed"]["motor"]
    best = answer.best
    swept = tendon.sweep(
        {**SUIT, "motion": {"speed": "60 deg/s"}, "tendon": {"pretension": best["pretension"]}}
    ).designs
    assert needed["speed"] == pytest.approx(swept.peak_motor_speed.abs().max(), rel=1e-12)
    assert needed["power"] == pytest.approx(swept.peak_motor_power.max(), rel=1e-12)
    assert needed["torque"] == pytest.approx(abs(best["peak_motor_torque"]))
    slow = answered(SUIT).record["parts_needed"]["motor"]
    assert slow["speed"] is None
    assert slow["power"] is None


def test_the_parts_are_those_for_the_persons_that_are_served():
    people = {"people": {"count": 40, "seed": 3}, "design": {"serve": 0.8}}
    strap = {"arm": {"contact_width": ["60 mm", "120 mm"]}}
    answer = answered(SUIT, people, strap)
    needed = answer.record["parts_needed"]
    best = answer.best
    assert needed["strap"]["pressure"] == best["max_contact_pressure"]
    per_width = best["max_contact_pressure"] * best["arm_contact_width"]
    assert needed["strap"]["least_width"] == pytest.approx(per_width / 52.9e3, rel=1e-9)
    assert needed["rope"]["tension"] == best["max_tension"]


def test_measured_travels_have_no_anchors_between_which_a_spring_could_lack_room():
    angle = np.linspace(0.0, 1.6, 9)
    table = {
        "angle": [f"{value} rad" for value in angle],
        "flexor": [f"{0.04 * value} m" for value in angle],
        "extensor": [f"{0.045 * value} m" for value in angle],
    }
    answer = answered(
        {
            "joint": {"excursion": table},
            "spring": {"stiffness": "0.5 kN/m"},
            "spool": {"ratio": 0.6},
        }
    )
    needed = answer.record["parts_needed"]
    assert needed["strap"] is None
    assert needed["spring"]["room"] is None
    assert answer.best["advice"] is None


# --- What would help ------------------------------------------------------------------------------

STIFF_ELBOW = {
    **LONG_SPRING,
    "arm": {"b1": "100 mm", "b2": "80 mm"},
    "spring": {"stiffness": ["0.3 kN/m", "2 kN/m"]},
    "load": {"mass": [0.0, 10.0]},
    "limits": {"min_elbow_stiffness": "3 N m/rad"},
}
"""No choice has a window; lighter loads open one, but the springs are stretched too far."""
UNADVISED = {"design": {"advice": False}}


def test_what_it_takes_names_a_choice_that_can_be_built():
    demands = {demand["key"]: demand for demand in answered(STIFF_ELBOW).record["would_take"]}
    lighter = demands["load.mass"]
    relaxed = {**STIFF_ELBOW, "load": {"mass": [0.0, lighter["after"]]}}
    rows = answered(relaxed).choices
    named = rows[rows["spring_stiffness"] == lighter["values"]["spring_stiffness"]]
    assert named["feasible"].all()
    assert (named["advice"] == "").all()
    # Heavier loads are suited, too, by a choice that cannot be built.
    heavier = {**STIFF_ELBOW, "load": {"mass": [0.0, 1.02 * lighter["after"]]}}
    choices = solved(heavier)
    assert choices.feasible.any()
    assert (choices.advice[choices.feasible] & NO_ROOM).all()
    unadvised = answered(STIFF_ELBOW, UNADVISED).record["would_take"]
    least = next(demand for demand in unadvised if demand["key"] == "load.mass")
    assert least["after"] > 2.0 * lighter["after"]


def test_only_fixes_that_can_be_built_are_named():
    def changes(answer):
        return {fix["parameter"]: fix for fix in answer.fixes if fix["after"] is not None}

    nearest = {**STIFF_ELBOW, "spring": {"stiffness": "2 kN/m"}}
    named = changes(answered(nearest))
    of_all = changes(answered(nearest, UNADVISED))
    assert {*named} < {*of_all}
    for fixes, can_be_built in ((named, True), (of_all, False)):
        for key, fix in fixes.items():
            table, name = key.split(".")
            values = {**nearest.get(table, {}), name: fix["printed"]}
            choices = solved({**nearest, table: values})
            assert choices.feasible.all(), key
            assert ((choices.advice & NO_ROOM) == 0).all() == can_be_built, key
