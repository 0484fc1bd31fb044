"""Answers: best, refined, front, fixes, conflicts, sensitivities, and that they hold when applied."""

import json

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.answers import choices as choices_module
from tendon_cli.answers.problem import question
from tendon_cli.answers.question import goals_of
from tendon_cli.answers.sensitivity import sensitivities
from tendon_cli.answers.solve import of_columns, of_rows

from .studies import CATALOGUE, LOADS, RANGES, asked

PAPER = {"load": {"mass": ["0 kg", "3 kg", "5 kg", "10 kg"]}}
SPRINGS = {"spring": {"stiffness": {"from": "1 kN/m", "to": "6 kN/m", "num": 6}}}
SPOOLS = {"spool": {"ratio": {"from": 0.55, "to": 1.0, "num": 4}}}


def scored(rows, goals):
    """The scores of rows of an answer."""
    return np.column_stack(
        [goal.score(np.array([row[goal.column] for row in rows], float)) for goal in goals]
    )


def answered(text, folder):
    """The answer, its goals, and the scores of a grid of four times its density."""
    fine = asked(text.replace("num = 8", "num = 29").replace("num = 6", "num = 21"), folder)
    goals, study = goals_of(fine.study), asked(text, folder).study
    return tendon.design(study), goals, of_rows(fine, np.arange(len(fine.choices))).scores(goals)


def solved_alone(content):
    """A study's one choice, solved."""
    return of_columns(question(tendon.study(content)), {}, 1)


@pytest.fixture(scope="module")
def paper():
    return tendon.design(PAPER)


# --- The paper's arm ------------------------------------------------------------------------------


def test_no_pretension_suits_the_papers_arm(paper):
    assert paper.feasible == 0
    assert paper.best is None
    (conflict,) = paper.conflicts
    assert conflict["limits"] == ["extensor slack", "min_elbow_stiffness"]
    assert conflict["gap"] == pytest.approx(220.32 - 122.8, abs=0.06)
    assert paper.choices["served"].item() == 0.75


def test_a_stiffer_spring_with_a_smaller_spool_does():
    answer = tendon.design(
        tendon.study({**PAPER, "spring": {"stiffness": "5 kN/m"}, "spool": {"ratio": 0.6}})
    )
    text = " ".join(answer.text.split())
    assert text.startswith(
        "A pretension of 148 N suits all 4 conditions; anything from 122.1 to 173.9 N does, 18 %"
    )


def test_each_fix_opens_a_window_and_a_step_less_does_not(paper):
    helps = [fix for fix in paper.fixes if fix["after"] is not None]
    assert {fix["parameter"] for fix in helps} >= {"spool.ratio", "arm.elbow_radius"}
    for fix in helps:
        for share, feasible in ((1.0, True), (0.999, False)):
            table, name = fix["parameter"].split(".")
            value = fix["before"] + share * (fix["after"] - fix["before"])
            again = solved_alone({**PAPER, table: {name: value}})
            assert again["feasible"][0] == feasible, fix["parameter"]
            if feasible:
                assert (
                    again["pretension_to"][0] - again["pretension_from"][0]
                    <= 1e-9 * again["pretension_to"][0]
                )
                assert again["max_tension"][0] == pytest.approx(fix["max_tension"], rel=1e-9)


@pytest.mark.parametrize(
    "asked",
    [
        {},
        {"limits": {"max_tension": "380 N"}},
        {"load": {"mass": ["0 kg", "7 kg"]}},
        {"people": {"count": 30}},
    ],
    ids=["paper", "limited", "two loads", "people"],
)
def test_every_fix_as_printed_opens_a_window_that_holds_the_printed_pretension(asked):
    content = {
        **PAPER,
        **asked,
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    }
    answer = tendon.design(content)
    helps = [fix for fix in answer.fixes if fix["after"] is not None]
    assert helps
    for fix in helps:
        assert f" to {fix['printed']}  " in answer.text
        table, name = fix["parameter"].split(".")
        typed = {
            **content,
            table: {**content.get(table, {}), name: fix["printed"].replace(",", "")},
        }
        again = solved_alone(typed)
        assert again["feasible"][0], fix
        assert (
            again["pretension_from"][0]
            <= float(fix["printed_pretension"])
            <= again["pretension_to"][0]
        )


def test_where_no_fix_is_found_scanning_the_whole_range_finds_none(paper, tmp_path):
    idle = [fix for fix in paper.fixes if fix["after"] is None]
    assert {"spring.stiffness", "sheath.friction"} <= {fix["parameter"] for fix in idle}
    problem = asked(LOADS, tmp_path)
    for fix in idle:
        (low, high), key = fix["plausible"], fix["parameter"]
        values = np.geomspace(low, high, 1500)
        found = problem.windows({key: values}, len(values))
        assert not (found.low.max(axis=1) <= found.high.min(axis=1)).any(), key


RELAXED = {
    "spring": {"stiffness": ["3 kN/m", "5 kN/m"]},
    "spool": {"ratio": [0.7, 0.6]},
    "arm": {"contact_width": ["30 mm", "40 mm"], "upper_arm_angle": ["-15 deg", "15 deg"]},
    "anchor": {"stiffness": "10 kN/m"},
    "load": {"mass": ["0 kg", "9 kg"]},
    "limits": {"max_contact_pressure": "52.9 kPa"},
}


@pytest.mark.parametrize(
    ("content", "keys"),
    [
        (PAPER, {"limits.min_elbow_stiffness", "load.mass"}),
        (RELAXED, {"limits.max_contact_pressure", "arm.contact_width", "load.mass"}),
    ],
    ids=["paper", "several choices"],
)
def test_the_least_change_of_what_is_asked_for_gives_a_window_and_less_gives_none(content, keys):
    answer = tendon.design(content)
    assert answer.feasible == 0
    helps = {each["key"]: each for each in answer.record["would_take"] if each["after"] is not None}
    assert set(helps) >= keys
    for key, each in helps.items():
        table, name = key.split(".")
        for value, some in (
            (each["after"], True),
            (each["after"] + 0.01 * (each["before"] - each["after"]), False),
        ):
            # Several values are drawn together.
            given = {
                "load.mass": [0.0, value],
                "arm.upper_arm_angle": [f"{-value} rad", f"{value} rad"],
            }.get(key, value)
            found = tendon.design({**content, table: {**content.get(table, {}), name: given}})
            assert (found.feasible > 0) == some, each
            if some:
                rows = found.choices
                for column, of in each["values"].items():
                    rows = rows[np.isclose(rows[column], of)] if column in rows else rows
                assert (rows["feasible"] & (rows["pretension_from"] <= each["pretension"])).any()
    text = " ".join(answer.text.split())
    if content is RELAXED:
        assert "max_contact_pressure = 99 kPa instead of 52.9 kPa: K 5 kN/m, η 0.6" in text
        assert "loads of at most 4.42 kg instead of 9 kg" in text
        assert (
            "not enough alone: tissue and cuffs of 100 kN/m behind each anchor, an upper arm tilted by at"
            in text
        )


# --- Best -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("column", ["pretension", "max_tension", "peak_motor_torque", "tolerance"])
def test_no_grid_of_four_times_the_density_beats_the_refined_best(column, tmp_path):
    goal = "maximise" if column == "tolerance" else "minimise"
    answer, goals, rivals = answered(f'[design]\n{goal} = "{column}"\n' + RANGES, tmp_path)
    rival = rivals.max()
    assert scored([answer.best], goals).item() >= rival - 1e-9 * abs(rival)


def test_no_finer_grid_dominates_the_front(tmp_path):
    goals = '[design]\nminimise = ["max_tension"]\nmaximise = ["tolerance"]\n'
    answer, goals, rivals = answered(goals + RANGES, tmp_path)
    assert len(answer.front) > 4
    for row in scored(answer.front, goals):
        margin = 2e-3 * np.abs(row)
        assert not ((rivals >= row).all(axis=1) & (rivals > row + margin).any(axis=1)).any()


def test_parts_jobs_and_the_order_of_axes_do_not_matter(monkeypatch):
    goals = {"design": {"minimise": ["max_tension"], "maximise": ["tolerance"]}}
    content = {**PAPER, **SPRINGS, "spool": {"ratio": [0.6, 0.7]}}
    whole = tendon.design({**content, **goals})
    monkeypatch.setattr(choices_module, "CHOICES_PER_PART", 5)
    for jobs in (1, 3):
        cut = tendon.design({**content, **goals}, jobs=jobs)
        assert whole.choices.equals(cut.choices)
        assert cut.record == whole.record | {
            name: cut.record[name] for name in ("seconds", "parts")
        }
    assert whole.choices["on_front"].sum() == len(whole.front) > 1
    goal = {"design": {"minimise": ["max_tension"]}}
    one, other = (
        tendon.design({**each, **goal})
        for each in ({**PAPER, **SPRINGS, **SPOOLS}, {**SPOOLS, **SPRINGS, **PAPER})
    )
    for name in ("pretension", "max_tension", "peak_motor_torque", "spring_stiffness"):
        assert other.best[name] == pytest.approx(one.best[name], rel=1e-5)


def test_rows_named_best_stand_in_the_table_and_an_edge_is_said_to_be_one(tmp_path):
    answer = tendon.design({**PAPER, **SPRINGS, **SPOOLS}, tmp_path / "out")
    for row in answer.record["best_by"].values():
        stands = answer.choices.iloc[row["choice"]]
        assert [stands[name] for name in ("spring_stiffness", "refined", "pretension")] == [
            row[name] for name in ("spring_stiffness", "refined", "pretension")
        ]
    record = json.loads(
        (tmp_path / "out" / "design.json").read_text(encoding="utf-8"), parse_constant=pytest.fail
    )
    assert record == answer.record
    assert record["feasible"] == int(answer.choices["feasible"][~answer.choices["refined"]].sum())
    assert record["choices"] == 24
    assert "K is at its upper end, K 6 kN/m: widen the range" in answer.text


# --- Sensitivities --------------------------------------------------------------------------------


def test_sensitivities_are_the_slopes_of_the_ends(tmp_path):
    design = (
        '[limits]\nmax_tension = "380 N"\n[spring]\nstiffness = "5 kN/m"\n[spool]\nratio = 0.6\n'
    )
    problem = asked(design + '[load]\nmass = ["1 kg", "8 kg"]\n', tmp_path)
    choice = of_columns(problem, {}, 1)
    found = sensitivities(problem, choice)
    assert {each["end"] for each in found} == {"from", "to"}
    assert len(found) > 30
    for each in found:
        if each["key"].startswith("limits.") or each["key"] == "load.mass" or not each["value"]:
            continue

        def end(factor, each=each):
            moved = problem.saying({each["key"]: np.full(2, each["value"] * factor)})
            return of_columns(moved, {}, 1)[f"pretension_{each['end']}"][0]

        step = 1e-4
        slope = (8 * (end(1 + step) - end(1 - step)) - end(1 + 2 * step) + end(1 - 2 * step)) / (
            12 * step
        )
        assert each["per_percent"] * 100 == pytest.approx(slope, rel=1e-6, abs=1e-6), each["key"]


# --- What cannot be asked, and what is told -------------------------------------------------------


@pytest.mark.parametrize("text", [CATALOGUE, LOADS])
def test_a_screen_of_80_columns_holds_the_answer(text, tmp_path):
    lines = tendon.design(asked(text, tmp_path).study).text.splitlines()
    assert max(map(len, lines)) <= 80
    assert len(lines) <= 48


UNCERTAIN = {"sheath": {"friction": {"value": 0.07, "tolerance": "10 %"}}}
DRAWN = {"uncertainty": {"draws": 4}}


@pytest.mark.parametrize(
    ("content", "noted"),
    [
        ({}, []),
        (UNCERTAIN, ["stand at their middle"]),
        (DRAWN, ["draws nothing"]),
        ({**UNCERTAIN, **DRAWN}, []),
    ],
    ids=["neither", "uncertain", "drawn", "both"],
)
def test_uncertain_numbers_without_draws_and_draws_without_these_are_noted(content, noted):
    notes = " ".join(question(tendon.study({"spring": {"stiffness": "5 kN/m"}, **content})).notes)
    assert [text for text in ("stand at their middle", "draws nothing") if text in notes] == noted
