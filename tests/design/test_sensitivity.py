"""Sensitivities of a window: what is solved for both ends at once is what each end has alone."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from tendon_cli.answers import sensitivity
from tendon_cli.answers.sensitivity import sensitivities
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.studies.load import study_from
from tendon_cli.verbs.typed_record import to_json

ELBOW = {"speed": "60 deg/s", "elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 4}}
DRAWN = {
    "load": {"mass": "3 kg"},
    "spool": {"ratio": 0.6},
    "spring": {"stiffness": "5 kN/m +/- 0.2 kN/m"},
    "sheath": {"friction": {"mean": 0.07, "std": 0.01}},
    "motion": ELBOW,
    "limits": {"peak_motor_power": "14.6 W"},
    "uncertainty": {"draws": 4},
}
LOADED = {
    "load": {"mass": ["0 kg", "3 kg"]},
    "spool": {"ratio": 0.6},
    "motion": ELBOW,
    "limits": {"max_tension": "700 N"},
}
SIDES = {
    "sheath": {"flexor": {"friction": {"mean": 0.07, "std": 0.01}}},
    "uncertainty": {"draws": 4},
    "motion": ELBOW,
    "limits": {"max_tension": "700 N"},
}
STUDIES = pytest.mark.parametrize("study", [DRAWN, LOADED, SIDES], ids=["draws", "loads", "sides"])


def solved(content):
    """Return the solver of a study with one choice, and this choice."""
    question = question_of(study_from(content))
    solver = Solver(question)
    return solver, solve(solver, question.all_points())


def by_number(records):
    """Return records by their end and key."""
    return {(record["end"], record["key"]): record for record in records}


def check_same(records, expected):
    """Check that records agree to the tolerance of the solver."""
    found = by_number(records)
    known = by_number(expected)
    assert set(found) == set(known)
    for place, record in known.items():
        assert found[place]["steady"] == record["steady"], place
        for name in ("value", "slope", "per_percent"):
            assert found[place][name] == pytest.approx(record[name], rel=1e-9, abs=1e-12), place


@STUDIES
def test_both_ends_at_once_have_what_each_has_alone(study, monkeypatch):
    solver, choice = solved(study)
    together = to_json(sensitivities(solver, choice))
    assert {record["end"] for record in together} == {"from", "to"}
    alone = []
    for end in ("from", "to"):
        with monkeypatch.context() as patch:
            patch.setattr(sensitivity, "ENDS", (end,))
            alone += to_json(sensitivities(solver, choice))
    check_same(together, alone)


@STUDIES
def test_the_order_of_the_conditions_does_not_matter(study):
    """Reverse the draws, or the loads."""
    solver, choice = solved(study)
    question = solver.question
    reverse = np.arange(len(question.conditions))[::-1]
    assert len(reverse) > 1
    backward = Solver(question.for_conditions(reverse))
    backward_choice = solve(backward, choice.points)
    forward = Solver(question.for_conditions(reverse[::-1]))
    forward_choice = solve(forward, choice.points)
    check_same(
        to_json(sensitivities(backward, backward_choice)),
        to_json(sensitivities(forward, forward_choice)),
    )


@STUDIES
def test_a_number_is_steady_if_the_same_limit_binds_once_it_is_changed(study):
    """Change each number in a study of its own, and solve that.

    With draws it is a study of the draw that sets the end.
    """
    solver, choice = solved(study)
    seen = Counter()
    for record in to_json(sensitivities(solver, choice)):
        question = solver.question
        if question.conditions.groups is not None:
            group = question.conditions.groups[choice.binding(record["end"]).condition]
            of_group = np.flatnonzero(question.conditions.groups == group)
            question = replace(question.for_conditions(of_group), serve=1.0)
        key = record["key"]
        if key == "motion.speed" or key.startswith("limits."):
            continue
        before = choice.binding(record["end"])
        is_steady = True
        for factor in (0.99, 1.01):
            given = question.condition_numbers.get(key, np.full(len(question.conditions), np.nan))
            values = np.where(np.isnan(given), record["value"], given)
            changed = Solver(question.with_numbers({key: values * factor}))
            after = solve(changed, choice.points).binding(record["end"])
            is_same_limit = after.by[0] == before.by[0]
            is_steady &= bool(is_same_limit and abs(after.state[0] - before.state[0]) <= 3)
        assert record["steady"] == is_steady, key
        seen[is_steady] += 1
    assert seen[True]


def solved_again(solver, choice, monkeypatch):
    """Return the sensitivities of a choice, and how many windows are solved for them."""
    counts = Counter()
    solve_changes = sensitivity.solve_windows

    def counted(solver, points, ends):
        counts["changes"] += len(points)
        counts["windows"] += len(points) * len(solver.question.conditions)
        return solve_changes(solver, points, ends)

    with monkeypatch.context() as patch:
        patch.setattr(sensitivity, "solve_windows", counted)
        records = to_json(sensitivities(solver, choice))
    return records, counts


def test_a_change_is_solved_once_for_both_ends(monkeypatch):
    solver, choice = solved(LOADED)
    records, counts = solved_again(solver, choice, monkeypatch)
    keys = {record["key"] for record in records}
    changed = [key for key in keys if key != "motion.speed" and not key.startswith("limits.")]
    ends_of = Counter(record["key"] for record in records)
    assert max(ends_of.values()) == 2
    assert counts["changes"] <= 2 * len(changed) + 2


def test_no_more_windows_are_solved_for_more_draws(monkeypatch):
    """Along a motion in time they took most of the time of an answer with many draws."""
    windows = set()
    for draws in (4, 64):
        own_sample = {"uncertainty": {"draws": draws}, "design": {"verify": 0}}
        solver, choice = solved({**DRAWN, **own_sample})
        _, counts = solved_again(solver, choice, monkeypatch)
        windows.add(counts["windows"])
    assert len(windows) == 1
