"""Truths that hold of tables of rows, whatever the numbers are."""

from __future__ import annotations

import numpy as np
import pytest

import tendon_cli as tendon

ANGLES = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 5}}
STIFFNESSES = ["1.1 kN/m", "3 kN/m", "5.7 kN/m", "8 kN/m"]
RATIOS = [0.6, 0.7, 1.0]


def springs(values=STIFFNESSES, names="ABCDEFGH", **more):
    rows = [{"name": names[at], "spring.stiffness": value} for at, value in enumerate(values)]
    return {"name": "spring", "rows": rows, **more}


def motors(values=RATIOS):
    return {"name": "motor", "rows": {"name": [f"M{r}" for r in values], "spool.ratio": values}}


def study(**tables):
    base = {"motion": ANGLES, "load": {"mass": ["0 kg", "5 kg", "10 kg"]}}
    return tendon.study({**tables, **base})


def same(first, second, without=()):
    """Hold common columns of two frames to the same bits."""
    names = [name for name in first if name in second and name not in without]
    assert len(names) > 20
    for name in names:
        here = first[name]
        there = second[name]
        if here.dtype.kind in "fib":
            assert here.to_numpy().tobytes() == there.to_numpy().tobytes(), name
        else:
            assert list(here.astype(str)) == list(there.astype(str)), name


# --- A table and an axis --------------------------------------------------------------------------


def test_a_table_of_one_column_has_the_results_of_the_axis_of_its_values():
    as_table = tendon.sweep(study(table=[springs()]))
    as_axis = tendon.sweep(study(spring={"stiffness": STIFFNESSES}))
    same(as_table.designs, as_axis.designs)
    same(as_table.states, as_axis.states)
    assert list(as_table.designs.spring) == [name for name in "ABCD" for _ in range(3)]


@pytest.mark.parametrize("goals", [{}, {"minimise": ["max_tension", "spring_stiffness"]}])
def test_it_has_the_same_windows_and_the_same_best_choice(goals):
    ratio = {"spool": {"ratio": 0.6}, "design": goals}
    as_table = tendon.design(study(table=[springs()], **ratio))
    as_axis = tendon.design(study(spring={"stiffness": STIFFNESSES}, **ratio))
    same(as_table.choices, as_axis.choices)
    bests = [answer.best["spring_stiffness"] for answer in (as_table, as_axis)]
    assert bests[0] == bests[1]
    fronts = [[row["spring_stiffness"] for row in answer.front] for answer in (as_table, as_axis)]
    assert fronts[0] == fronts[1]


def test_conditions_in_a_table_bind_as_conditions_of_an_axis():
    loads = {"rows": {"name": ["none", "some", "much"], "load.mass": [0.0, 5.0, 10.0]}}
    base = {"motion": ANGLES, "spring": {"stiffness": STIFFNESSES}, "spool": {"ratio": 0.6}}
    as_table = tendon.design({**base, "table": [{"name": "carried", **loads}]})
    as_list = tendon.design({**base, "load": {"mass": ["0 kg", "5 kg", "10 kg"]}})
    same(as_table.choices, as_list.choices, without=("between_samples",))
    assert list(as_table.conditions.load_mass) == [0.0, 5.0, 10.0]


def test_a_suit_is_set_on_the_same_arm_whether_arms_are_rows_or_values():
    base = {"motion": ANGLES, "spring": {"stiffness": ["5 kN/m"]}, "spool": {"ratio": 0.6}}
    rows = {"name": ["z", "y", "x"], "arm.b1": [0.14, 0.16, 0.15]}
    as_table = tendon.design({**base, "table": [{"name": "who", "rows": rows}]})
    as_axis = tendon.design({**base, "arm": {"b1": ["140 mm", "160 mm", "150 mm"]}})
    same(as_table.choices, as_axis.choices, without=("between_samples",))


def test_cells_in_another_unit_are_the_numbers_of_the_axis_to_the_last_bit():
    stated = [f"{value} mm" for value in (0.1, 9, 33.3, 117.7)]
    rows = {"name": list("abcd"), "arm.b1 (mm)": ["100.1", "109", "133.3", "117.7"]}
    of_table = tendon.study({"table": [{"name": "arm_of", "rows": rows}]})
    of_axis = tendon.study({"arm": {"b1": ["100.1 mm", "109 mm", "133.3 mm", "117.7 mm"]}})
    assert len(stated) == 4
    values = of_table.row_tables[0].numbers["arm.b1"]
    assert values.tobytes() == of_axis.arm.b1.array.tobytes()


# --- Orders, products and repeats -----------------------------------------------------------------


def test_permuted_rows_permute_results():
    order = [2, 0, 3, 1]
    names = ["ABCD"[at] for at in order]
    before = tendon.sweep(study(table=[springs()])).designs
    after = tendon.sweep(study(table=[springs([STIFFNESSES[at] for at in order], names)])).designs
    rows = [3 * at + load for at in order for load in range(3)]
    same(before.iloc[rows].reset_index(drop=True), after, without=("design",))


def test_permuted_rows_give_the_same_answer():
    order = [2, 0, 3, 1]
    names = ["ABCD"[at] for at in order]
    before = tendon.design(study(table=[springs(), motors()]))
    permuted = springs([STIFFNESSES[at] for at in order], names)
    after = tendon.design(study(table=[permuted, motors()]))
    assert before.best["spring"] == after.best["spring"]
    assert before.short.splitlines()[:4] == after.short.splitlines()[:4]


def test_two_tables_are_their_product():
    both = tendon.sweep(study(table=[springs(), motors()])).designs
    axes = {"spring": {"stiffness": STIFFNESSES}, "spool": {"ratio": RATIOS}}
    base = {"motion": ANGLES, "load": {"mass": ["0 kg", "5 kg", "10 kg"]}}
    same(both, tendon.sweep(tendon.study({**axes, **base})).designs)
    assert len(both) == 4 * 3 * 3


def test_a_row_that_repeats_the_study_changes_nothing():
    plain = tendon.sweep(study(spring={"stiffness": "5.7 kN/m"})).designs
    stated = springs(["5.7 kN/m"])
    same(plain, tendon.sweep(study(spring={"stiffness": "5.7 kN/m"}, table=[stated])).designs)
    empty = {"name": "spring", "rows": [{"name": "A", "spring.stiffness": "", "price": 3}]}
    same(plain, tendon.sweep(study(spring={"stiffness": "5.7 kN/m"}, table=[empty])).designs)


def test_cases_are_the_table_of_their_rows():
    cases = [
        {"name": "short", "arm": {"b1": "120 mm"}},
        {"name": "long", "arm": {"b1": "170 mm"}, "spring": {"stiffness": "4 kN/m"}},
    ]
    rows = [
        {"name": "short", "arm.b1": "120 mm"},
        {"name": "long", "arm.b1": "170 mm", "spring.stiffness": "4 kN/m"},
    ]
    of_cases = tendon.sweep(study(cases=cases)).designs
    of_rows = tendon.sweep(study(table=[{"name": "who", "rows": rows}])).designs
    same(of_cases, of_rows)
    assert list(of_cases.case) == list(of_rows.who)


def test_a_side_may_be_a_column():
    rows = {"name": ["A", "B"], "spring.flexor.stiffness (kN/m)": [2, 6]}
    of_rows = tendon.sweep(study(table=[{"name": "spring", "rows": rows}])).designs
    axis = {"flexor": {"stiffness": ["2 kN/m", "6 kN/m"]}}
    of_axis = tendon.sweep(study(spring=axis)).designs
    same(of_rows, of_axis)


def test_words_of_the_model_may_be_columns():
    rows = {"name": ["near", "far"], "spring.at": ["joint", "motor"]}
    of_rows = tendon.sweep(study(table=[{"name": "spring", "rows": rows}])).designs
    of_axis = tendon.sweep(study(spring={"at": ["joint", "motor"]})).designs
    same(of_rows, of_axis)
    assert list(of_rows.spring_at)[::3] == ["joint", "motor"]


# --- Roles ----------------------------------------------------------------------------------------


def test_a_table_is_a_condition_if_it_sets_nothing_but_conditions():
    arms = {"name": "arm_of", "rows": {"name": ["a"], "arm.b1": [0.12], "load.mass": [3.0]}}
    mixed = {"name": "kit", "rows": {"name": ["a"], "arm.b1": [0.12], "spool.ratio": [0.6]}}
    priced = {"name": "kit", "rows": {"name": ["a"], "spool.ratio": [0.6], "price": [3]}}

    def conditions(*tables, **more):
        return tendon.study({"table": [*tables], **more}).conditions

    assert conditions(arms) == ("arm_of",)
    assert conditions(mixed) == conditions(priced) == ()
    assert conditions({**arms, "role": "choice"}) == ()
    assert conditions({**mixed, "role": "condition"}) == ("kit",)
    assert conditions(mixed, design={"conditions": ["kit"]}) == ("kit",)
    assert conditions(arms, design={"conditions": ["load.mass"]}) == ()


def test_rows_that_are_draws_are_served_as_a_share():
    rows = {"name": list("abcd"), "arm.b1": [0.10, 0.13, 0.15, 0.17]}
    stiff = {"stiffness": ["5 kN/m", "8 kN/m"]}
    spool = {"ratio": 0.6}
    loads = {"mass": ["0 kg", "5 kg"]}
    base = {"motion": ANGLES, "spring": stiff, "spool": spool, "load": loads}
    table = {"name": "prototype", "rows": rows, "role": "draw"}
    drawn = tendon.design({**base, "table": [table], "design": {"serve": 0.5}})
    assert set(np.unique(drawn.choices.served)) <= {0.0, 0.25, 0.5, 0.75, 1.0}
    all_of_them = {**table, "role": "condition"}
    strict = tendon.design({**base, "table": [all_of_them]})
    wider = drawn.choices.pretension_to - drawn.choices.pretension_from
    narrow = strict.choices.pretension_to - strict.choices.pretension_from
    assert (wider >= narrow - 1e-9).all()
    assert drawn.best["served_verified"] is None
    assert tendon.study({**base, "table": [table]}).serve == 0.95


def test_a_limit_that_a_maker_leaves_open(tmp_path, monkeypatch):
    """Cells without a number leave the study's own limit."""
    monkeypatch.chdir(tmp_path)
    rows = ["A,3,30", "B,3,inf", "C,3,nan", "D,3,", "E,3,-"]
    header = "name,spring.stiffness (kN/m),limits.max_spring_extension (mm)"
    (tmp_path / "springs.csv").write_text("\n".join([header, *rows]) + "\n")
    table = [{"name": "part", "file": "springs.csv"}]
    motion = {"elbow_angle": ["0 deg", "45 deg", "90 deg"]}
    for own in (None, 0.02):
        limits = {} if own is None else {"limits": {"max_spring_extension": f"{own} m"}}
        designs = tendon.sweep({"table": table, "motion": motion, **limits}).designs
        of_study = np.nan if own is None else own
        stated = [0.03, of_study, of_study, of_study, of_study]
        assert np.allclose(designs["limit_max_spring_extension"], stated, equal_nan=True)
