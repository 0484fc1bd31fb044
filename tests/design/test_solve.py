"""Choices over conditions.

The check values of the paper's arm, the limits that bind, and the share one pretension serves.
"""

from dataclasses import asdict

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.answers.notes import notes_of
from tendon_cli.engine.windows import solutions as solutions_module
from tendon_cli.engine.windows import solver as solver_module
from tendon_cli.engine.windows.solutions import Solutions
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.model import actuator
from tendon_cli.model.limits import LIMIT_NAMES

from .studies import CATALOGUE, LOADS, RANGES, question_from, solved

PAPER = 3  # row of CATALOGUE with the paper's spring and spool, 3 kN/m and 1
LAST = 8  # row with 5 kN/m and 0.6


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    """Return the question of the catalogue and its solutions."""
    question = question_from(CATALOGUE, tmp_path_factory.mktemp("catalogue"))
    return question, solved(question)


def test_the_windows_of_the_papers_arm_over_its_loads_and_the_limits_that_bind(catalogue):
    _, solutions = catalogue
    columns = [
        *solutions.points.columns.values(),
        solutions.pretension_from,
        solutions.pretension_to,
    ]
    windows = np.column_stack(columns)[solutions.feasible].round(1)
    assert windows.tolist() == [
        [3e3, 0.6, 113.5, 116.9],
        [5e3, 0.7, 167.4, 176.5],
        [5e3, 0.6, 122.1, 173.9],
    ]
    assert LIMIT_NAMES[solutions.from_binding.by[LAST]] == "extensor slack"
    assert LIMIT_NAMES[solutions.to_binding.by[LAST]] == "min_elbow_stiffness"
    assert solutions.from_binding.condition[LAST] == 3
    assert solutions.to_binding.condition[LAST] == 0
    tolerance = (173.934 - 122.121) / (173.934 + 122.121)
    assert solutions.tolerance[LAST] == pytest.approx(tolerance, abs=1e-5)
    # The paper's window is empty: 96.8 to 122.8, 133.9 and more, 158.6 to 296.6, 220.3 and more.
    assert solutions.pretension_from[PAPER] == pytest.approx(220.32, abs=0.05)
    assert solutions.pretension_to[PAPER] == pytest.approx(122.8, abs=0.05)
    assert np.isnan(solutions.tolerance[PAPER])
    assert solutions.served[PAPER] == 0.75


def state_at(question, row, pretension):
    """Return the states of a choice at a pretension, N."""
    points = question.points(np.array([row]))
    design = question.designs(points.at_pretension(np.array([pretension])))
    return actuator.evaluate(design, question.angles, question.flexion)


def test_the_worst_values_at_a_pretension_are_those_of_the_states(catalogue):
    question, solutions = catalogue
    state = state_at(question, LAST, solutions.pretension[LAST])
    tensions = (state.balance.flexor, state.balance.extensor)
    proximal = (state.flexor_tension_proximal, state.extensor_tension_proximal)
    torque = state.motor_torque.ravel()
    assert solutions.worst.max_tension[LAST] == np.max([*tensions, *proximal])
    assert solutions.worst.min_elbow_stiffness[LAST] == state.elbow_stiffness.min() > 0.0
    assert solutions.worst.peak_motor_torque[LAST] == torque[np.argmax(np.abs(torque))]
    assert solutions.worst.max_spring_extension[LAST] * 5e3 == pytest.approx(np.max(tensions))
    assert np.isnan(solutions.worst.max_contact_pressure[LAST])


def test_at_the_least_pretension_the_binding_state_is_just_taut(tmp_path):
    question = question_from('[design]\npretension = "least"\n' + CATALOGUE, tmp_path)
    solutions = solved(question)
    assert solutions.pretension[LAST] == solutions.pretension_from[LAST]
    state = state_at(question, LAST, solutions.pretension[LAST])
    extensor = state.balance.extensor[0, solutions.from_binding.condition[LAST]].ravel()
    assert np.argmin(extensor) == solutions.from_binding.state[LAST]
    assert extensor.min() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("module", "name", "few"),
    [
        (solver_module, "_STATES_AT_ONCE", 500),  # 2 conditions at once
        (solutions_module, "WINDOWS_AT_ONCE", 30),  # 7 choices at once
    ],
    ids=["states", "windows"],
)
def test_blocks_of_choices_and_conditions_do_not_matter(tmp_path, monkeypatch, module, name, few):
    whole = solved(question_from(RANGES, tmp_path))
    monkeypatch.setattr(module, name, few)
    cut = solved(question_from(RANGES, tmp_path))
    assert_same(asdict(cut), asdict(whole))


def assert_same(values, others):
    """Assert that arrays are equal, in dictionaries that may hold others."""
    assert values.keys() == others.keys()
    for name, value in values.items():
        if isinstance(value, dict):
            assert_same(value, others[name])
        else:
            np.testing.assert_array_equal(value, others[name], err_msg=name)


def test_enough_may_be_less_than_all(tmp_path):
    rows = ", ".join(f'{{ name = "{mass}", "load.mass" = "{mass} kg" }}' for mass in (0, 3, 5, 10))
    drawn = f'[[table]]\nname = "load"\nrole = "draw"\nrows = [{rows}]\n[design]\nserve = 0.75\n'
    question = question_from(CATALOGUE.removesuffix(LOADS) + drawn, tmp_path)
    solutions = solved(question)
    rows = np.arange(9)
    windows = Solver(question).windows(question.all_points())
    pretension = solutions.pretension[:, np.newaxis]
    serves = (windows.low <= pretension) & (pretension <= windows.high)
    assert solutions.feasible.all()
    assert (serves.mean(axis=1) >= 0.75).all()
    binding_low = windows.low[rows, solutions.from_binding.condition]
    binding_high = windows.high[rows, solutions.to_binding.condition]
    np.testing.assert_array_equal(binding_low, solutions.pretension_from)
    np.testing.assert_array_equal(binding_high, solutions.pretension_to)


def test_solutions_selected_and_concatenated_again_are_the_same(catalogue):
    _, solutions = catalogue
    is_even = np.arange(9) % 2 == 0
    parts = [solutions.select(is_even), solutions.select(~is_even)]
    order = np.argsort(np.concatenate([part.row for part in parts]))
    assert_same(asdict(Solutions.concatenate(parts).select(order)), asdict(solutions))


def test_ends_that_may_bind_set_the_windows_that_all_ends_over_all_angles_set(tmp_path):
    limits = '[limits]\nmax_tension = "380 N"\n'
    coarse = '[motion]\nelbow_angle = { from = "0 deg", to = "120 deg", num = 5 }\n'
    question = question_from(limits + coarse + RANGES, tmp_path)
    solver = Solver(question)
    points = question.all_points()
    folded = solver.fold(points)
    solver.seek_everywhere(folded, points)
    of_all = folded.ends
    few = solver.ends(points)
    sampled = solver.fold(points).ends
    np.testing.assert_array_equal(few.low.max(axis=1), of_all.low.max(axis=1))
    np.testing.assert_array_equal(few.high.min(axis=1), of_all.high.min(axis=1))
    assert (sampled.low <= of_all.low).all()
    assert (sampled.high >= of_all.high).all()
    assert (sampled.high > few.high).any()
    assert (few.high > of_all.high).any()


def windows_of(text, folder):
    """Return the windows of all choices of a study given as text."""
    question = question_from(text, folder)
    return Solver(question).windows(question.all_points())


def test_cases_are_conditions_with_every_number_they_set(tmp_path):
    cases = (
        '[[cases]]\nname = "small"\narm = { b1 = "140 mm" }\n'
        '[[cases]]\nname = "rough"\nsheath = { extensor = { friction = 0.2 } }\n'
        '[[cases]]\nname = "initial"\nmodel = { reference = "initial" }\n'
    )
    together = windows_of(LOADS + cases, tmp_path)
    changes = (
        '[arm]\nb1 = "140 mm"\n',
        "[sheath.extensor]\nfriction = 0.2\n",
        '[model]\nreference = "initial"\n',
    )
    alone = [windows_of(change + LOADS, tmp_path) for change in changes]
    for end in ("low", "high"):
        expected = np.hstack([getattr(windows, end) for windows in alone])
        np.testing.assert_array_equal(getattr(together, end), expected)


def test_pretensions_of_a_study_are_no_choices_and_those_of_sides_not_used(tmp_path):
    pretensions = '[tendon]\npretension = ["90 N", "200 N"]\n[tendon.flexor]\npretension = "80 N"\n'
    question = question_from(pretensions + LOADS, tmp_path)
    assert len(question.choices) == 1
    assert any("pretensions per side are not used" in note for note in notes_of(question))
    without = solved(question_from(LOADS, tmp_path))
    np.testing.assert_array_equal(solved(question).pretension_to, without.pretension_to)


def test_limits_that_no_pretension_keeps_are_the_reason(tmp_path):
    solutions = solved(question_from("[limits]\nmin_spool_to_tendon = 30\n" + CATALOGUE, tmp_path))
    thin = np.tile([False, True, True], 3)
    np.testing.assert_array_equal(np.isnan(solutions.pretension_from), thin)
    assert {LIMIT_NAMES[code] for code in solutions.from_binding.by[thin]} == {
        "min_spool_to_tendon"
    }
    assert (solutions.served[thin] == 0.0).all()
    assert np.isnan(solutions.pretension[thin]).all()
    answer = tendon.design({"limits": {"min_spool_to_tendon": 60}})
    assert answer.conflicts[0]["limits"] == ["min_spool_to_tendon"]
    text = " ".join(answer.text.split())
    assert "at any pretension a spool is less than 60 tendon diameters wide" in text


def test_a_limit_that_no_pretension_keeps_is_a_reason_of_its_own():
    springs = {"spring": {"stiffness": ["3 kN/m", "2 kN/m", "8 kN/m"]}, "load": {"mass": 5.0}}
    answer = tendon.design(tendon.study({**springs, "limits": {"max_tension": "100 N"}}))
    by_limits = {tuple(conflict["limits"]): conflict for conflict in answer.conflicts}
    never = by_limits["max_tension",]
    choices = answer.choices
    assert never["choices"] == (choices["pretension_to"] < 0.0).sum() > 0
    assert never["nearest"]["pretension_to"] < 0.0
    both = by_limits["extensor slack", "max_tension"]
    assert both["choices"] == (choices["pretension_to"] >= 0.0).sum() > 0
