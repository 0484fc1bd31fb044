"""The order of choices: what is named first, by which rule, and that no list's order decides.

The order is checked against an independent one, worked out from the table of all choices.
"""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.answers import choices as choices_module
from tendon_cli.engine.windows.order import Order
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.verbs.answer_record import named_first
from tests.answers import answered

from .studies import NO_UPPER_END

STEPS = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 4}}
UNADVISED = {"advice": False}
LOADS = {
    "load": {"mass": ["0 kg", "10 kg", "3 kg"]},
    "motion": STEPS,
    # Springs for 10 kg that cannot be wound are as good as others here.
    "design": UNADVISED,
}
SUITS = {
    **LOADS,
    "spring": {"stiffness": ["3 kN/m", "12 kN/m", "5 kN/m"]},
    "spool": {"ratio": [0.6, 0.5], "flexor_radius": ["40 mm", "30 mm"]},
}
TIED = {
    **LOADS,
    "spring": {"stiffness": ["5 kN/m", "8 kN/m"]},
    "spool": {"ratio": 0.5},
    # Nothing that a limit needs follows from the strap, and all are wide enough for the pressure
    # that is advised, so that its widths tie in everything.
    "arm": {"contact_width": ["220 mm", "200 mm", "210 mm"]},
}
PEOPLE = {**SUITS, "people": {"count": 4}}
OPEN = {**SUITS, "joint": NO_UPPER_END}
ACCURACY = 2e-3
"""Accuracy of setting by default, m."""
CASES = {
    **LOADS,
    "cases": [
        {"name": "long", "arm": {"b1": "150 mm"}},
        {"name": "short", "arm": {"b1": "120 mm"}},
    ],
    "anchor": {"stiffness": ["100 kN/m", "20 kN/m"]},
    "spring": {"stiffness": ["8 kN/m", "5 kN/m"]},
    "spool": {"ratio": [0.5, 0.45]},
}
FRONT = {**SUITS, "design": {**UNADVISED, "minimise": ["max_tension", "max_spring_extension"]}}
NONE = {
    "motion": STEPS,
    "load": {"mass": 5.0},
    "spring": {"stiffness": ["3 kN/m", "2 kN/m"]},
    "limits": {"max_tension": "100 N"},
}


def listed(content, path=()):
    """Yield the path of every list of a study."""
    for key, value in content.items():
        if isinstance(value, dict) and key != "joint":
            yield from listed(value, (*path, key))
        elif isinstance(value, list):
            yield (*path, key)


def with_list(content, path, values):
    """Return a study with one of its lists replaced."""
    key, *rest = path
    inner = with_list(content[key], rest, values) if rest else values
    return {**content, key: inner}


def at(content, path):
    """Return the list of a study at a path."""
    for key in path:
        content = content[key]
    return content


def told(content):
    """Return the choice named first without its row, and the first sentences."""
    answer = answered(content)
    best = answer.record["best"]
    if best is not None:
        by_place = ("choice", "from_condition", "to_condition")
        best = {key: value for key, value in best.items() if key not in by_place}
    return best, answer.record["blocks"][0], answer.record["decided"]


KINDS = {
    "suits": SUITS,
    "tied": TIED,
    "people": PEOPLE,
    "open": OPEN,
    "cases": CASES,
    "front": FRONT,
    "none": NONE,
}


@pytest.mark.parametrize("name", ["suits", "tied", "people", "cases", "front"])
def test_the_order_of_lists_decides_nothing(name):
    """All lists are turned round together."""
    turned = KINDS[name]
    for path in listed(KINDS[name]):
        turned = with_list(turned, path, at(turned, path)[::-1])
    assert told(turned) == told(KINDS[name])


@pytest.mark.torture
@pytest.mark.parametrize("name", KINDS)
def test_the_order_of_a_list_decides_nothing(name):
    content = KINDS[name]
    expected = told(content)
    for path in listed(content):
        values = at(content, path)
        for order in (values[::-1], [*values[1:], values[0]])[: len(values) - 1]:
            assert told(with_list(content, path, order)) == expected, (path, order)


def solved_question(content):
    """Return a question and all its choices, solved."""
    question = question_of(tendon.study(content))
    return question, solve(Solver(question), question.all_points())


def first_by_hand(content, accuracy):
    """Return the row that comes first, worked out by sorting all solved choices."""
    question, solved = solved_question(content)
    length = np.minimum(solved.tolerance_length, 3.0 * accuracy)
    axes = {axis.key: solved.points.columns[axis.column] for axis in question.choices.axes}
    columns = [
        np.where(solved.feasible, -length, 1.0).round(12),
        solved.worst.max_tension.round(7),
        np.abs(solved.worst.peak_motor_torque).round(9),
        *(axes[key] for key in sorted(axes)),
    ]
    return int(np.lexsort(columns[::-1])[0])


@pytest.mark.parametrize(
    "content", [SUITS, TIED, PEOPLE, OPEN], ids=["suits", "tied", "people", "open"]
)
@pytest.mark.parametrize("accuracy", [0.0, 0.001, 0.002, 0.02])
def test_the_first_choice_is_that_of_an_independent_sort(content, accuracy):
    with_accuracy = {**content, "setting": {"accuracy": f"{accuracy} m"}}
    question, solved = solved_question(with_accuracy)
    feasible = np.flatnonzero(solved.feasible)
    first = feasible[Order.of(question).best(solved.select(feasible))]
    assert first == first_by_hand(with_accuracy, accuracy)


def test_enough_tolerance_is_enough_and_then_the_tension_decides():
    answer = answered(SUITS)
    enough = answer.choices[answer.choices["tolerance_length"] >= 6e-3]
    decided = answer.record["decided"]
    assert answer.record["best"]["max_tension"] == pytest.approx(
        enough["max_tension"].min(), rel=1e-5
    )
    assert decided["rule"] == "max_tension"
    assert decided["choices"] == len(enough) < answer.record["feasible"]
    tension = f"{answer.record['best']['max_tension']:.0f} N"
    sentence = (
        f"The tension of this choice reaches {tension} in motion, the least of the {len(enough)}"
        " choices whose window is at least 12 mm wide"
    )
    assert sentence in " ".join(answer.text.split())


def test_without_a_choice_that_can_be_set_well_enough_the_widest_comes_first():
    answer = tendon.design({**SUITS, "setting": {"accuracy": "20 mm"}}, jobs=1)
    assert answer.record["decided"]["rule"] == "settable"
    widest = answer.choices["tolerance_length"].max()
    assert answer.record["best"]["tolerance_length"] == pytest.approx(widest, rel=1e-5)
    text = " ".join(answer.text.split())
    assert "None of 12 choices has a window at least 120 mm wide; this one's is the widest" in text


def test_a_window_without_an_upper_end_is_enough_and_never_a_share():
    answer = tendon.design({**OPEN, "setting": {"accuracy": "90 mm"}}, jobs=1)
    best = answer.record["best"]
    assert best["pretension_to"] is None
    assert best["tolerance_length"] is None
    assert answer.record["decided"]["is_settable"]
    assert best["max_tension"] == answer.choices["max_tension"].min()
    assert "100 %" not in answer.text
    assert best["pretension"] > best["pretension_from"]


def test_ties_are_named_with_what_breaks_them_and_numbers_without_effect_too():
    decided = answered(TIED).record["decided"]
    assert decided["ties"] == 3
    assert [row["arm_contact_width"] for row in decided["tied"]] == [0.2, 0.21, 0.22]
    assert decided["broken_by"] == ["arm.contact_width"]
    assert decided["no_effect"] == ["arm.contact_width"]
    answer = answered(SUITS)
    decided = answer.record["decided"]
    assert decided["broken_by"] == ["peak_motor_torque"]
    assert decided["no_effect"] == ["spool.flexor_radius"]
    text = " ".join(answer.text.split())
    assert "R_f does not matter here: no window depends on it" in text
    assert "2 choices tie:" in text
    assert "the least motor torque decides" in text


def test_a_number_that_moves_one_window_of_many_matters():
    limit = {"limits": {"peak_motor_torque": "11 N m"}}
    windows = tendon.design({**SUITS, **limit}, jobs=1)
    depends = windows.choices.pivot_table(
        index=["spring_stiffness", "spool_ratio"],
        columns="spool_flexor_radius",
        values="pretension_to",
    )
    assert (depends.nunique(axis=1) > 1).any()
    decided = windows.record["decided"]
    assert decided is None or decided["no_effect"] == []


def test_the_answer_does_not_depend_on_how_the_work_is_cut(monkeypatch):
    whole = answered(PEOPLE).record
    monkeypatch.setattr(choices_module, "CHOICES_PER_PART", 5)
    cut = tendon.design(PEOPLE, jobs=1).record
    for key in ("best", "best_by", "decided", "front", "conflicts", "text"):
        assert cut[key] == whole[key], key


def test_advice_comes_before_tolerance_and_tension_unless_it_is_off():
    question, solutions = solved_question({**SUITS, "design": {}})
    without = question_of(tendon.study(SUITS))
    no_advice = np.zeros(len(solutions), dtype=np.int64)
    solutions = type(solutions)(**{**vars(solutions), "advice": no_advice})
    feasible = solutions.select(solutions.feasible)
    order = Order.of(question)
    first = order.best(feasible)
    for code in (1, 2, 6):
        advice = np.zeros(len(feasible), dtype=np.int64)
        advice[first] = code
        failing = type(feasible)(**{**vars(feasible), "advice": advice})
        assert order.best(failing) != first
        assert Order.of(without).best(failing) == first
    # What cannot be built comes after what fails the rest of the advice.
    everything = np.full(len(feasible), 1)
    everything[3] = 6
    assert order.best(type(feasible)(**{**vars(feasible), "advice": everything})) == 3


def test_goals_replace_tolerance_and_tension():
    answer = tendon.design(
        {**SUITS, "design": {**UNADVISED, "maximise": ["tolerance_length"]}}, jobs=1
    )
    best = answer.record["best"]
    assert best["tolerance_length"] == pytest.approx(answer.choices["tolerance_length"].max())
    assert answer.record["decided"]["rule"] == "tolerance_length"
    torque = {**UNADVISED, "minimise": ["peak_motor_torque"]}
    best = tendon.design({**SUITS, "design": torque}, jobs=1)
    can_be_set = best.choices["tolerance_length"] >= ACCURACY
    torques = best.choices["peak_motor_torque"].abs()
    assert abs(best.record["best"]["peak_motor_torque"]) == pytest.approx(torques[can_be_set].min())
    # The least torque of all is that of a choice whose window nobody can hit.
    assert torques[best.choices["feasible"]].min() < torques[can_be_set].min()


@pytest.mark.parametrize(
    "goals",
    [
        {},
        {"minimise": ["peak_motor_torque"]},
        {"minimise": ["max_tension"], "maximise": ["min_elbow_stiffness"]},
    ],
    ids=["none", "one", "opposed"],
)
def test_a_choice_that_cannot_be_set_is_not_named_beside_one_that_can(goals):
    lengths = answered(SUITS).choices["tolerance_length"].dropna()
    accuracy = (lengths.min() + lengths.max()) / 2
    content = {**SUITS, "design": {**UNADVISED, **goals}, "setting": {"accuracy": f"{accuracy} m"}}
    answer = tendon.design(content, jobs=1)
    named = [answer.record["best"], *answer.record["best_by"].values(), *answer.record["front"]]
    assert all(row["tolerance_length"] >= accuracy for row in named)
    assert "cannot be set" not in answer.text


@pytest.mark.parametrize("accuracy", ["100 mm", "2000 N"], ids=["length", "tension"])
def test_a_first_choice_that_cannot_be_set_is_called_that_at_once(accuracy):
    """No sentence recommends it; the numbers left at their defaults are named."""
    for goals in ({}, {"minimise": ["max_tension", "peak_motor_torque"]}):
        content = {**SUITS, "design": {**UNADVISED, **goals}, "setting": {"accuracy": accuracy}}
        answer = tendon.design(content, jobs=1)
        assert not answer.record["decided"]["can_be_set"]
        for text in (answer.text, answer.short):
            first = " ".join(text.split("Why")[0].split())
            assert "cannot be set: the window is ± " in first
            assert f"the accuracy of setting ± {accuracy.replace('2000', '2,000')}" in first
            assert not first.startswith("Set ")
            assert "None of" in first
            assert "State" not in first
    content = {"load": {"mass": ["0 kg", "2.05 kg"]}, "motion": STEPS}
    short = " ".join(tendon.design(content, jobs=1).short.split())
    assert (
        "Try other values of spool.ratio (now 1, its default) and spring.stiffness (now 3 kN/m"
        in short
    )


@pytest.mark.parametrize("given", [None, "120 N"])
def test_tensions_to_set_are_null_just_where_there_is_no_window(given):
    """A pretension that the study gives is set on every choice."""
    content = {
        "load": {"mass": ["0 kg", "10 kg"]},
        "spring": {"stiffness": ["3 kN/m", "5 kN/m", "8 kN/m"]},
        "spool": {"ratio": [0.6, 1.0]},
    }
    if given is not None:
        content["design"] = {"pretension": given}
    choices = tendon.design(content, jobs=1).choices
    has_window = choices["pretension_from"] <= choices["pretension_to"]
    assert has_window.any()
    assert not has_window.all()
    of_setting = choices.filter(regex="^set_.*_tension(_motor)?$")
    assert of_setting.shape[1] == 4
    for column in of_setting:
        assert (of_setting[column].notna() == (has_window | (given is not None))).all(), column


def test_a_limit_of_a_part_that_ends_the_window_is_said_beside_the_part():
    motors = {
        "name": ["quick", "strong"],
        "limits.peak_motor_torque (N m)": [12, 30],
        "limits.peak_motor_speed (rpm)": [120, 45],
    }
    content = {
        "load": {"mass": ["0 kg", "3 kg"]},
        "motion": {"speed": "60 deg/s"},
        "spring": {"stiffness": "2.5 kN/m"},
        "spool": {"ratio": 0.6, "flexor_radius": "25 mm"},
        "table": [{"name": "motor", "rows": motors}],
    }
    answer = tendon.design(content, jobs=1)
    ended = {
        name: row["from_by"] == "peak_motor_speed"
        for name, row in zip(motors["name"], answer.record["trade_offs"][0]["best"], strict=True)
    }
    assert ended == {"quick": False, "strong": True}


def test_of_choices_that_come_as_near_to_a_window_the_smaller_value_is_named():
    """Neither limit is reached, so both choices lack the same window by as much."""
    answer = tendon.design(
        {
            "motion": STEPS,
            "spring": {"stiffness": "3 kN/m"},
            "spool": {"ratio": 1.0},
            "load": {"mass": ["0 kg", "10 kg"]},
            "limits": {"max_tension": ["6 kN", "5 kN"]},
        }
    )
    assert answer.best is None
    assert named_first(answer.answer).columns["limit_max_tension"] == 5e3


@pytest.mark.parametrize(
    ("ratios", "said"),
    [
        ([1.0, 0.5, 0.6], "Neither choice with a window can be set."),
        ([1.0, 0.5, 0.55, 0.6], "None of the 3 choices with a window can be set."),
    ],
)
def test_how_many_other_choices_cannot_be_set_is_said_as_one_says_it(ratios, said):
    answer = tendon.design(
        {
            "spring": {"stiffness": "5 kN/m"},
            "spool": {"ratio": ratios},
            "load": {"mass": ["0 kg", "10 kg"]},
            "setting": {"accuracy": "20 mm"},
            "design": {"minimise": "max_tension"},
        }
    )
    assert answer.feasible == len(ratios) - 1
    assert said in " ".join(answer.text.split())
