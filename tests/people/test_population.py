"""`tendon design` over people and draws: for whom, sizes, and how sure, in text, record and figures."""

import re

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli import say
from tendon_cli.answers import fixes, sensitivity
from tendon_cli.answers import people as people_module
from tendon_cli.answers.problem import question
from tendon_cli.answers.solve import solve
from tendon_cli.studies.load import study_from

COARSE = {"motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}}}
SUITS = {
    "spring": {"stiffness": [3e3, 5e3, 8e3]},
    "spool": {"ratio": [0.6, 0.5]},
    "load": {"mass": [0.0, 10.0]},
}
PEOPLE = COARSE | SUITS | {"people": {"count": 100, "seed": 2}}


@pytest.fixture(scope="module")
def answer(tmp_path_factory):
    folder = tmp_path_factory.mktemp("answers") / "people"
    return tendon.design(tendon.study(PEOPLE), folder, figures=True)


def test_the_choice_that_serves_most_stands_first_and_the_record_counts_whom_it_serves(answer):
    found = answer.record["population"]
    assert answer.best["served"] == answer.choices["served"].max()
    assert (found["choice"], found["kind"]) == (answer.best["choice"], "persons")
    assert (found["count"], found["effective_count"]) == (100, 100.0)
    out = sum(reason["share"] for reason in found["not_served"])
    assert found["served"] + out == pytest.approx(1.0)
    assert found["served"] <= found["largest_share"] == answer.best["served"]
    assert found["interval_95"][0] < found["served"] <= found["interval_95"][1]


def test_sizes_along_an_axis_begin_with_the_best_single_suit(answer):
    found = answer.record["population"]["sizes"]
    best = answer.best
    along = answer.choices[answer.choices["spool_ratio"] == best["spool_ratio"]]
    (one, two, three) = found["spring_stiffness"]
    assert one["served"] == pytest.approx(along["served"].max())
    assert one["served"] <= two["served"] <= three["served"]
    assert {suit["value"] for suit in two["choices"]} <= {3e3, 5e3, 8e3}


def test_text_and_figures_say_it(answer):
    lines = answer.text.splitlines()
    assert max(map(len, lines)) <= 80
    assert "For whom" in lines
    assert say.percent(answer.record["population"]["served"]) in answer.text
    assert {"for_whom.png", "how_sure.png", "served_map.png"} <= set(answer.record["figures"])
    assert all((answer.folder / name).stat().st_size > 10_000 for name in answer.record["figures"])
    again = tendon.design(tendon.study(PEOPLE), answer.folder, figures=True)
    assert again.up_to_date


NOBODY_ENOUGH = PEOPLE | {"spring": {"stiffness": 3e3}, "spool": {"ratio": [1.0, 0.7, 0.6]}}


def test_where_no_choice_serves_enough_the_most_universal_is_told_and_what_would_fix_it():
    found = tendon.design(tendon.study(NOBODY_ENOUGH))
    assert found.feasible == 0
    best = found.choices["served"].idxmax()
    assert found.record["population"]["choice"] == best
    assert 0.0 < found.record["population"]["served"] < 0.95
    assert not any("what would help" in note for note in found.record["notes"])
    helps = [fix for fix in found.fixes if fix["after"] is not None]
    assert {"spool.ratio", "arm.elbow_radius"} <= {fix["parameter"] for fix in helps}
    ratio = found.choices["spool_ratio"][best]
    for fix in helps:
        key, before, after = fix["parameter"], fix["before"], fix["after"]
        table, name = key.split(".")
        for value, enough in ((after, True), (after - 1e-6 * (after - before), False)):
            content = NOBODY_ENOUGH | {"spool": {"ratio": ratio}}
            content |= {table: {**content.get(table, {}), name: value}}
            problem = question(tendon.study(content))
            assert (
                bool(solve(problem, problem.choices.numbers(np.arange(1)), 1)["feasible"][0])
                == enough
            ), key


def test_for_very_many_what_would_fix_it_is_worked_out_for_some_and_said(monkeypatch):
    study = tendon.study(NOBODY_ENOUGH)
    problem = question(study)
    monkeypatch.setattr(
        fixes, "_MOST", 20 * len(problem.conditions) * problem.states_per_design // 100
    )
    found = tendon.design(study)
    note = "what would help is worked out for 20 of the 100 persons: those that bind, and others at random"
    assert note in found.record["notes"]
    assert any(fix["after"] is not None for fix in found.fixes)


DOUBT = {
    "sheath": {"friction": {"mean": 0.07, "std": 0.02}},
    "spring": {"stiffness": {"value": "5 kN/m", "tolerance": "15 %"}},
    "spool": {"ratio": 0.6},
    "load": {"mass": [0.0, 10.0]},
    "uncertainty": {"draws": 256},
}


def test_the_probability_of_a_pretension_is_that_of_a_sweep_over_the_draws(monkeypatch):
    monkeypatch.setattr(sensitivity, "_STATES", 256 * 4 * 28)
    study = study_from(COARSE | DOUBT)
    found = tendon.design(study).record["population"]
    assert (found["kind"], found["count"]) == ("draws", 256)
    at = study_from(COARSE | DOUBT | {"tendon": {"pretension": found["pretension"]}})
    run = tendon.sweep(at)
    feasible = run.designs["feasible"].to_numpy().reshape(256, 2).all(axis=1)
    assert found["served"] == pytest.approx(feasible.mean(), abs=1e-12)
    ends = {each["end"]: each["inputs"] for each in found["sobol"]}
    assert set(ends["pretension_from"]) == {"sheath.friction", "spring.stiffness"}
    for inputs in ends.values():
        assert sum(each["first"] for each in inputs.values()) == pytest.approx(1.0, abs=0.15)


def test_sizes_of_many_persons_are_found_by_the_first(monkeypatch):
    monkeypatch.setattr(people_module, "_MOST_PERSONS", 50)
    found = tendon.design(tendon.study(PEOPLE)).record["population"]["sizes"]["spool_ratio"]
    assert [each["persons"] for each in found] == [50, 50, 50]
    assert np.all(np.diff([each["served"] for each in found]) >= 0.0)


def test_the_pretension_that_would_serve_more_serves_as_many_in_a_sweep():
    asked = {
        "people": {"count": 40},
        "spring": {"stiffness": "5 kN/m"},
        "spool": {"ratio": 0.6},
        "load": {"mass": ["0 kg", "5 kg"]},
        "limits": {"max_tension": "260 N"},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 10}},
    }
    answer = tendon.design(
        tendon.study(asked | {"design": {"serve": "50 %", "pretension": "least"}})
    )
    told = re.search(r"([0-9.]+)\s+N\s+would\s+serve\s+([0-9.]+)\s+%", answer.text)
    assert told is not None
    swept = tendon.sweep(tendon.study(asked | {"tendon": {"pretension": f"{told[1]} N"}})).designs
    served = swept.groupby("person", observed=True)["feasible"].all()
    assert say.percent(served.mean()) == f"{told[2]} %"
    assert served.mean() > answer.record["population"]["served"]
