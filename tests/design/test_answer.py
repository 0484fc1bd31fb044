"""Answers: best, front, fixes, conflicts and sensitivities, which hold when applied."""

import json

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.answers import choices as choices_module
from tendon_cli.answers.notes import notes_of
from tendon_cli.answers.sensitivity import sensitivities
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.verbs.typed_record import to_json
from tests.answers import answered, solved

COARSE = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}}
PAPER = {
    "load": {"mass": ["0 kg", "3 kg", "5 kg", "10 kg"]},
    "motion": COARSE,
    "design": {"advice": False},  # whether springs for 10 kg can be wound
}
CATALOGUE = {
    "spring": {"stiffness": ["1 kN/m", "3 kN/m", "5 kN/m"]},
    "spool": {"ratio": [1.0, 0.7, 0.6]},
}
SPRINGS = {"spring": {"stiffness": {"from": "1 kN/m", "to": "6 kN/m", "num": 6}}}
SPOOLS = {"spool": {"ratio": {"from": 0.55, "to": 1.0, "num": 3}}}

MOTORS = [
    {"name": "weak", "limits.peak_motor_torque": "9 N m", "price (EUR)": 80},
    {"name": "middle", "limits.peak_motor_torque": "12 N m", "price (EUR)": 105},
    {"name": "strong", "limits.peak_motor_torque": "16 N m", "price (EUR)": 130},
]


def with_value(content, key, value):
    """Return the content of a study with one number, such as "spool.ratio", replaced."""
    table, name = key.split(".")
    return {**content, table: {**content.get(table, {}), name: value}}


# --- The paper's arm ------------------------------------------------------------------------------


def test_no_pretension_suits_the_papers_arm():
    paper = answered(PAPER)
    assert paper.feasible == 0
    assert paper.best is None
    (conflict,) = paper.conflicts
    assert conflict["limits"] == ["extensor slack", "min_elbow_stiffness"]
    assert conflict["gap"] == pytest.approx(220.32 - 122.8, abs=0.06)
    assert conflict["fails"] == [{"load_mass": 0.0}]
    assert paper.choices[["served", "served_at"]].isna().all(axis=None)


def test_a_pretension_suits_a_stiffer_spring_with_a_smaller_spool():
    answer = answered({**PAPER, "spring": {"stiffness": "5 kN/m"}, "spool": {"ratio": 0.6}})
    text = " ".join(answer.short.split())
    assert text.startswith("Set 168 N in the flexor (111.9 N in the extensor) at the joint, ")
    assert "a pretension of 131.7 N;" in text
    assert "(122.1 to 173.9 N works)" in text


def test_each_fix_opens_a_window_and_a_step_less_does_not():
    fixes = [fix for fix in answered(PAPER).fixes if fix["after"] is not None]
    assert {fix["parameter"] for fix in fixes} >= {"spool.ratio", "arm.elbow_radius"}
    for fix in fixes:
        key = fix["parameter"]
        sign = np.sign(fix["after"] - fix["before"])
        # It is printed with three digits, rounded away from the study's own value.
        less = solved(with_value(PAPER, key, fix["after"] * (1.0 - 0.011 * sign)))
        assert not less.feasible[0], key
        fixed = solved(with_value(PAPER, key, fix["after"]))
        assert fixed.feasible[0], key
        assert fixed.worst.max_tension[0] == pytest.approx(fix["max_tension"], rel=1e-9)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"limits": {"max_tension": "380 N"}},
        {"people": {"count": 8}, "load": {"mass": ["0 kg", "7 kg"]}},
    ],
    ids=["paper", "limited", "people"],
)
def test_every_fix_as_printed_opens_a_window_that_holds_the_printed_pretension(changes):
    content = {**PAPER, **changes}
    answer = answered(content)
    fixes = [fix for fix in answer.fixes if fix["after"] is not None]
    assert fixes
    for fix in fixes:
        assert f"  {fix['printed']}  " in answer.text
        printed_value = fix["printed"].replace(",", "")
        fixed = solved(with_value(content, fix["parameter"], printed_value))
        assert fixed.feasible[0], fix
        pretension = float(fix["printed_pretension"])
        assert fixed.pretension_from[0] <= pretension <= fixed.pretension_to[0]


def test_scanning_the_whole_range_finds_no_fix_that_the_answer_does_not():
    idle = [fix for fix in answered(PAPER).fixes if fix["after"] is None]
    assert {"spring.stiffness", "sheath.friction"} <= {fix["parameter"] for fix in idle}
    question = question_of(tendon.study(PAPER))
    for fix in idle:
        low, high = fix["plausible"]
        key = fix["parameter"]
        values = np.geomspace(low, high, 500)
        points = question.points(np.zeros(len(values), dtype=int)).with_numbers({key: values})
        windows = Solver(question).windows(points)
        has_window = windows.low.max(axis=1) <= windows.high.min(axis=1)
        assert not has_window.any(), key


def test_a_bend_that_follows_the_joint_has_no_fix():
    content = {
        "load": {"mass": ["0 kg", "10 kg"]},
        "motion": COARSE,
        "sheath": {"bend_angle": {"angle": ["0 deg", "90 deg"], "bend": ["180 deg", "220 deg"]}},
    }
    answer = answered(content)
    assert not answer.feasible
    parameters = {fix["parameter"] for fix in answer.fixes}
    assert "sheath.friction" in parameters
    assert "sheath.bend_angle" not in parameters


RELAXED = {
    "motion": COARSE,
    "spring": {"stiffness": ["3 kN/m", "5 kN/m"]},
    "spool": {"ratio": [0.7, 0.6]},
    "arm": {
        "contact_width": ["30 mm", "40 mm"],
        "contact_from": "0 deg",
        "upper_arm_angle": ["-15 deg", "15 deg"],
    },
    "anchor": {"stiffness": "10 kN/m"},
    "load": {"mass": ["0 kg", "9 kg"]},
    "limits": {"max_contact_pressure": "52.9 kPa"},
    "design": {"advice": False},
}


def relaxed(content, key, value):
    """Solve a study with one requirement changed; those of several values change together."""
    if key == "load.mass":
        value = [0.0, value]
    elif key == "arm.upper_arm_angle":
        value = [f"{-value} rad", f"{value} rad"]
    question = question_of(tendon.study(with_value(content, key, value)))
    return solve(Solver(question), question.all_points())


@pytest.mark.parametrize(
    ("content", "keys"),
    [
        (PAPER, {"limits.min_elbow_stiffness", "load.mass"}),
        (RELAXED, {"limits.max_contact_pressure", "arm.contact_width", "load.mass"}),
    ],
    ids=["paper", "several choices"],
)
def test_the_least_change_of_a_requirement_gives_a_window_and_less_gives_none(content, keys):
    answer = answered(content)
    assert answer.feasible == 0
    changes = {
        change["key"]: change
        for change in answer.record["would_take"]
        if change["after"] is not None
    }
    assert set(changes) >= keys
    for key, change in changes.items():
        enough = relaxed(content, key, change["after"])
        is_named = np.ones(len(enough), dtype=bool)
        for column, value in change["values"].items():
            if column in enough.points.columns:
                is_named &= np.isclose(enough.points.columns[column], value)
        named = enough.select(is_named)
        assert (named.feasible & (named.pretension_from <= change["pretension"])).any(), change
        less = change["after"] + 0.01 * (change["before"] - change["after"])
        assert not relaxed(content, key, less).feasible.any(), change
    text = " ".join(answer.text.split())
    if content is RELAXED:
        assert "max_contact_pressure = 98.9 kPa instead of 52.9 kPa: K 5 kN/m, η 0.6" in text
        assert "loads of at most 4.42 kg instead of 9 kg" in text
        assert (
            "not enough on their own: tissue and cuffs of 100 kN/m per tendon, an upper arm tilted"
        ) in text


# --- Best -----------------------------------------------------------------------------------------


def test_the_front_is_what_no_choice_matches_in_all_goals_and_beats_in_one():
    goals = {"design": {"minimise": ["price"], "maximise": ["tolerance_length"]}}
    table = {"table": [{"name": "motor", "rows": MOTORS}]}
    springs = {"spring": {"stiffness": ["3 kN/m", "4 kN/m", "5 kN/m", "6 kN/m"]}}
    spools = {"spool": {"ratio": [0.55, 0.6, 0.7]}}
    answer = answered({**PAPER, **springs, **spools, **table, **goals})
    choices = answer.choices[answer.choices["feasible"]]
    best_first = choices.sort_values("advice", key=lambda advice: advice != "", kind="stable")
    rivals = best_first[best_first["advice"] == best_first["advice"].iloc[0]]
    scores = np.column_stack([-rivals["price"], rivals["tolerance_length"]])
    as_good = (scores[:, np.newaxis] >= scores).all(axis=2)
    better = (scores[:, np.newaxis] > scores).any(axis=2)
    beaten = (as_good & better).any(axis=0)
    expected = {tuple(score) for score in scores[~beaten]}
    on_front = rivals["on_front"].to_numpy(dtype=bool)
    assert {tuple(score) for score in scores[on_front]} == expected
    # Some choices off the front are no worse than any other in all goals: the ends of a tie.
    worse_in_all = (scores[:, np.newaxis] > scores).all(axis=2).any(axis=0)
    assert (beaten & ~worse_in_all).any()


def test_parts_jobs_and_the_order_of_axes_do_not_matter(monkeypatch):
    goals = {"design": {"minimise": ["max_tension"], "maximise": ["tolerance"]}}
    springs = {"spring": {"stiffness": {"from": "4 kN/m", "to": "6 kN/m", "num": 3}}}
    content = {**PAPER, **springs, "spool": {"ratio": [0.6, 0.7]}, **goals}
    whole = tendon.design(content, jobs=1)
    with monkeypatch.context() as patch:
        patch.setattr(choices_module, "CHOICES_PER_PART", 4)
        cut = tendon.design(content, jobs=3)
    assert whole.choices.equals(cut.choices)
    differences = {name: cut.record[name] for name in ("seconds", "parts")}
    assert cut.record == whole.record | differences
    assert whole.choices["on_front"].sum() == len(whole.front) > 1
    spools = {"spool": {"ratio": {"from": 0.55, "to": 0.65, "num": 2}}}
    goal = {"design": {"minimise": ["max_tension"]}}
    springs_first = tendon.design({**PAPER, **springs, **spools, **goal}, jobs=1)
    spools_first = tendon.design({**spools, **springs, **PAPER, **goal}, jobs=1)
    for name in ("pretension", "max_tension", "peak_motor_torque", "spring_stiffness"):
        assert spools_first.best[name] == pytest.approx(springs_first.best[name], rel=1e-5)


def test_the_best_rows_are_those_of_the_table_and_the_text_names_an_end_of_a_range():
    answer = answered({**PAPER, **SPRINGS, **SPOOLS})
    for best in answer.record["best_by"].values():
        row = answer.choices.iloc[best["choice"]]
        for name in ("spring_stiffness", "pretension"):
            assert row[name] == best[name]
    written = (answer.folder / "design.json").read_text(encoding="utf-8")
    record = json.loads(written, parse_constant=pytest.fail)
    assert record == answer.record
    assert record["feasible"] == int(answer.choices["feasible"].sum())
    assert record["choices"] == 18
    text = " ".join(answer.text.split())
    assert "η is at the lower end of its range, η 0.55: widen the range" in text
    assert "a finer grid of K (now up to 50 % apart) may hold a better choice" in text


# --- Sensitivities --------------------------------------------------------------------------------


def test_sensitivities_are_the_slopes_of_the_ends():
    content = {
        "limits": {"max_tension": "380 N"},
        "spring": {"stiffness": "5 kN/m"},
        "spool": {"ratio": 0.6},
        "load": {"mass": ["1 kg", "8 kg"]},
        "motion": COARSE,
    }
    question = question_of(tendon.study(content))
    rows = to_json(sensitivities(Solver(question), solve(Solver(question), question.all_points())))
    assert {row["end"] for row in rows} == {"from", "to"}
    assert len(rows) > 30

    def end_at(row, factor):
        moved = question.with_numbers({row["key"]: np.full(2, row["value"] * factor)})
        return solve(Solver(moved), moved.all_points()).pretension_at(row["end"])[0]

    step = 1e-4
    for row in rows:
        is_number = not row["key"].startswith("limits.") and row["key"] != "load.mass"
        if not is_number or not row["value"]:
            continue
        near = end_at(row, 1 + step) - end_at(row, 1 - step)
        far = end_at(row, 1 + 2 * step) - end_at(row, 1 - 2 * step)
        slope = (8 * near - far) / (12 * step)
        assert row["per_percent"] * 100 == pytest.approx(slope, rel=1e-6, abs=1e-6), row["key"]


def test_a_rigid_spring_of_a_list_has_the_sensitivities_that_it_has_alone():
    def slopes(stiffness):
        study = {
            "spring": {"flexor": {"stiffness": stiffness}, "extensor": {"stiffness": "20 kN/m"}},
            "spool": {"ratio": 0.6},
            "load": {"mass": ["0 kg", "5 kg"]},
            "limits": {"max_spring_extension": "15 mm"},
            "motion": {"elbow_angle": {"from": "0 deg", "to": "60 deg", "num": 7}},
            "design": {"maximise": "pretension_to"},
        }
        answer = tendon.design(study)
        return {(row["end"], row["key"]): row["slope"] for row in answer.record["sensitivities"]}

    alone = slopes("rigid")
    assert ("to", "limits.max_spring_extension") in alone
    assert slopes(["rigid", "5 kN/m"]) == pytest.approx(alone, rel=1e-9)


# --- Text and notes -------------------------------------------------------------------------------


UNCERTAIN = {"sheath": {"friction": {"value": 0.07, "tolerance": "10 %"}}}
DRAWN = {"uncertainty": {"draws": 4}}
NOT_DRAWN = {"uncertainty": {"draws": 0}}


@pytest.mark.parametrize(
    ("content", "noted"),
    [
        ({}, []),
        (UNCERTAIN, []),
        ({**UNCERTAIN, **NOT_DRAWN}, ["take their middle value"]),
        (NOT_DRAWN, []),
        (DRAWN, ["draws nothing"]),
        ({**UNCERTAIN, **DRAWN}, []),
    ],
    ids=["neither", "uncertain", "not drawn", "nothing to draw", "drawn", "both"],
)
def test_uncertain_numbers_without_draws_and_draws_without_these_are_noted(content, noted):
    notes = " ".join(
        notes_of(question_of(tendon.study({"spring": {"stiffness": "5 kN/m"}, **content})))
    )
    assert [text for text in ("take their middle value", "draws nothing") if text in notes] == noted
