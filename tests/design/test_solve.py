"""Choices over conditions: the check values of the paper's arm, what binds, and what one pretension serves."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.answers import problem as problem_module
from tendon_cli.answers import solve as solve_module
from tendon_cli.model import actuator
from tendon_cli.model.limits import LIMIT_NAMES

from .studies import CATALOGUE, LOADS, RANGES, asked, solved


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    made = asked(CATALOGUE, tmp_path_factory.mktemp("catalogue"))
    return made, solved(made)


def test_the_windows_of_the_papers_arm_over_its_loads_and_what_binds(catalogue):
    problem, found = catalogue
    columns = problem.choices.columns(np.arange(9)) | found.results
    names = ("spring_stiffness", "spool_ratio", "pretension_from", "pretension_to")
    windows = np.column_stack([columns[name] for name in names])[found["feasible"]].round(1)
    assert windows.tolist() == [
        [3e3, 0.6, 113.5, 116.9],
        [5e3, 0.7, 167.4, 176.5],
        [5e3, 0.6, 122.1, 173.9],
    ]
    at = 8  # 5 kN/m and 0.6
    assert [LIMIT_NAMES[found[f"{end}_by"][at]] for end in ("from", "to")] == [
        "extensor slack",
        "min_elbow_stiffness",
    ]
    assert (found["from_condition"][at], found["to_condition"][at]) == (3, 0)
    assert found["tolerance"][at] == pytest.approx(
        (173.934 - 122.121) / (173.934 + 122.121), abs=1e-5
    )
    at = 3  # empty, the paper's: 96.8 to 122.8, 133.9 and more, 158.6 to 296.6, 220.3 and more
    assert (found["pretension_from"][at], found["pretension_to"][at]) == pytest.approx(
        (220.32, 122.8), abs=0.05
    )
    assert (np.isnan(found["tolerance"][at]), found["served"][at]) == (True, 0.75)


def test_the_worst_at_a_pretension_is_that_of_the_states(catalogue):
    problem, found = catalogue
    at = np.array([8])
    design = problem.design(problem.choices.numbers(at), pretension=found["pretension"][at])
    state = actuator.evaluate(design, problem.angles, problem.flexion)
    tensions, torque = (state.balance.flexor, state.balance.extensor), state.motor_torque.ravel()
    proximal = (state.flexor_tension_proximal, state.extensor_tension_proximal)
    assert found["max_tension"][8] == np.max([*tensions, *proximal])
    assert found["min_elbow_stiffness"][8] == state.elbow_stiffness.min() > 0.0
    assert found["peak_motor_torque"][8] == torque[np.argmax(np.abs(torque))]
    assert found["max_spring_extension"][8] * 5e3 == pytest.approx(np.max(tensions))
    assert np.isnan(found["max_contact_pressure"][8])


def test_at_least_pretension_the_binding_state_is_just_taut(tmp_path):
    problem = asked('[design]\npretension = "least"\n' + CATALOGUE, tmp_path)
    found = solved(problem)
    assert found["pretension"][8] == found["pretension_from"][8]
    design = problem.design(
        problem.choices.numbers(np.array([8])), pretension=found["pretension"][[8]]
    )
    state = actuator.evaluate(design, problem.angles, problem.flexion)
    extensor = state.balance.extensor[0, found["from_condition"][8]].ravel()
    assert np.argmin(extensor) == found["from_state"][8]
    assert extensor.min() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("module", "name", "few"),
    [
        (problem_module, "_STATES_AT_ONCE", 500),
        (solve_module, "_WINDOWS_AT_ONCE", 30),
    ],  # 2 conditions; 7 choices
    ids=["states", "windows"],
)
def test_blocks_of_choices_and_conditions_do_not_matter(tmp_path, monkeypatch, module, name, few):
    whole = solved(asked(RANGES, tmp_path))
    monkeypatch.setattr(module, name, few)
    cut = solved(asked(RANGES, tmp_path))
    for column, values in whole.results.items():
        np.testing.assert_array_equal(cut[column], values, err_msg=column)


def test_enough_may_be_less_than_all(tmp_path):
    problem = asked("[design]\nserve = 0.75\n" + CATALOGUE, tmp_path)
    found, rows = solved(problem), np.arange(9)
    each = problem.windows(problem.choices.numbers(rows), 9)
    middle = found["pretension"][:, np.newaxis]
    assert found["feasible"].all()
    assert (((each.low <= middle) & (middle <= each.high)).mean(axis=1) >= 0.75).all()
    np.testing.assert_array_equal(each.low[rows, found["from_condition"]], found["pretension_from"])
    np.testing.assert_array_equal(each.high[rows, found["to_condition"]], found["pretension_to"])


def test_cases_are_conditions_with_every_number_they_set(tmp_path):
    cases = (
        '[[cases]]\nname = "small"\narm = { b1 = "140 mm" }\n'
        '[[cases]]\nname = "rough"\nsheath = { extensor = { friction = 0.2 } }\n'
        '[[cases]]\nname = "initial"\nmodel = { reference = "initial" }\n'
    )
    found = asked(LOADS + cases, tmp_path).windows({}, 1)
    changes = (
        '[arm]\nb1 = "140 mm"\n',
        "[sheath.extensor]\nfriction = 0.2\n",
        '[model]\nreference = "initial"\n',
    )
    alone = [asked(change + LOADS, tmp_path).windows({}, 1) for change in changes]
    for end in ("low", "high"):
        np.testing.assert_array_equal(
            getattr(found, end), np.hstack([getattr(each, end) for each in alone])
        )


def test_what_the_study_says_of_pretension_is_left_out_and_said(tmp_path):
    problem = asked(
        '[tendon]\npretension = ["90 N", "200 N"]\n[tendon.flexor]\npretension = "80 N"\n' + LOADS,
        tmp_path,
    )
    assert len(problem.choices) == 1
    assert len(problem.notes) == 2
    np.testing.assert_array_equal(
        solved(problem)["pretension_to"], solved(asked(LOADS, tmp_path))["pretension_to"]
    )


def test_limits_that_no_pretension_keeps_are_the_reason(tmp_path):
    found = solved(asked("[limits]\nmin_spool_to_tendon = 30\n" + CATALOGUE, tmp_path))
    thin = np.tile([False, True, True], 3)
    np.testing.assert_array_equal(np.isnan(found["pretension_from"]), thin)
    assert {LIMIT_NAMES[code] for code in found["from_by"][thin]} == {"min_spool_to_tendon"}
    assert (found["served"][thin] == 0.0).all()
    assert np.isnan(found["pretension"][thin]).all()
    answer = tendon.design({"limits": {"min_spool_to_tendon": 60}})
    assert answer.conflicts[0]["limits"] == ["min_spool_to_tendon"]
    assert "at any pretension a spool is less than 60 tendon diameters wide" in " ".join(
        answer.text.split()
    )
