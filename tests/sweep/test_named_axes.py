"""Every number that varies has a column, whatever sets it: a case, a person, a draw or an axis."""

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.engine.table_columns import columns_set_by_names
from tendon_cli.studies.axis_words import name_words
from tendon_cli.studies.load import study_from
from tendon_cli.studies.space.axis import NamedAxis
from tendon_cli.studies.space.space import Space
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import keys

LOADS = {"load": {"mass": [0.0, 3.0]}, "motion": {"elbow_angle": ["0 deg", "60 deg"]}}
LENGTHS = {"d88": 0.088, "d120": 0.12, "d150": 0.15}
CASES = {
    "cases": [{"name": name, "arm": {"b1": length}} for name, length in LENGTHS.items()],
    **LOADS,
}
SIDES = {
    "cases": [
        {"name": "thin", "tendon": {"flexor": {"diameter": 0.001}}},
        {"name": "rigid", "spring": {"stiffness": "rigid", "at": "motor"}},
        {"name": "as it is"},
    ],
    **LOADS,
}
PEOPLE = {"people": {"count": 3}, "joint": {"stiffness": 1.0, "rest_angle": "60 deg"}, **LOADS}
DRAWS = {
    "spring": {"extensor": {"stiffness": "5 kN/m +/- 1 kN/m"}},
    "arm": {"a1": "35 mm to 45 mm"},
    "uncertainty": {"draws": 4},
    **LOADS,
}
TABLE = NamedAxis.of(
    "spring",
    ("S5", "S8"),
    {
        "spring.stiffness": np.array([3000.0, 5000.0]),
        "tendon.extensor.length": np.array([np.nan, 1.5]),
    },
    "choice",
)


@pytest.mark.parametrize("content", [CASES, SIDES, PEOPLE, DRAWS, {**PEOPLE, **DRAWS}])
def test_every_number_that_varies_has_a_column(content):
    run = tendon.sweep(study_from(content))
    space = space_of(study_from(content))
    for key in keys():
        side = "flexor" if key.startswith(("tendon.", "spring.", "sheath.", "anchor.")) else None
        number = space.number(key, side)
        if key.count(".") > 1 or not number.axes:
            continue
        column = keys()[key].column
        if f"{column}_{side}" in run.designs:
            column = f"{column}_{side}"
        expected = np.broadcast_to(number.within(space.whole), (*space.shape, 1, 1)).ravel()
        for table in (run.designs, run.states.drop_duplicates("design")):
            np.testing.assert_array_equal(table[column], expected)
        assert run.designs.attrs["units"][column] == keys()[key].number.quantity.unit


def test_a_case_that_sets_a_number_is_a_row_of_the_axis_of_this_number():
    of_cases = tendon.sweep(study_from(CASES))
    of_axis = tendon.sweep(study_from({"arm": {"b1": [*LENGTHS.values()]}, **LOADS}))
    for table in ("designs", "states"):
        named = getattr(of_cases, table)
        assert named["case"].tolist() == [
            next(name for name, value in LENGTHS.items() if value == length)
            for length in named["arm_b1"]
        ]
        expected = getattr(of_axis, table)
        rows = named.sort_values(["load_mass", "arm_b1"], kind="stable").drop(columns="case")
        other = expected.sort_values(["load_mass", "arm_b1"], kind="stable")
        for name in set(other) - {"design"}:
            assert pd.Series(rows[name].tolist()).equals(pd.Series(other[name].tolist())), name


def test_a_number_that_is_the_same_in_all_cases_has_no_column():
    cases = [{"name": "a", "arm": {"b1": 0.15}}, {"name": "b"}, {"name": "c", "arm": {"b1": 0.15}}]
    assert "arm_b1" not in tendon.sweep(study_from({"cases": cases, **LOADS})).designs
    assert space_of(study_from({"cases": cases, **LOADS})).set_by_names == {}


def test_a_number_of_one_side_and_a_word_have_columns_of_their_sides():
    designs = tendon.sweep(study_from(SIDES)).designs.query("load_mass == 0")
    assert designs["tendon_diameter_flexor"].tolist() == [0.001, 0.0015, 0.0015]
    assert designs["tendon_diameter_extensor"].tolist() == [0.0015] * 3
    assert designs["tendon_diameter"].isna().all()
    assert designs["spring_stiffness"].tolist() == [3000.0, np.inf, 3000.0]
    assert designs["spring_at"].tolist() == ["joint", "motor", "joint"]


def test_columns_lie_along_their_axis_in_a_dataset():
    run = tendon.sweep(study_from(SIDES))
    data = run.to_xarray()
    assert data["tendon_diameter_flexor"].dims == ("case",)
    assert data["spring_at"].sel(case="rigid").item() == "motor"
    assert {"tendon_diameter_flexor", "spring_at"} <= set(data.coords)


def test_rows_of_any_table_are_a_named_axis():
    space = Space((TABLE,), {"spring.stiffness": 1000.0, "tendon.length": 2.0})
    assert [column.name for column in columns_set_by_names(space).values()] == [
        "tendon_length_extensor",
        "spring_stiffness",
    ]
    lengths = space.number("tendon.length", "extensor").within(space.whole)
    assert lengths.ravel().tolist() == [2.0, 1.5]
    assert space.choices.axes == (TABLE,)
    assert name_words(TABLE, "S5") == "spring S5 (K 3 kN/m)"


def test_a_name_is_said_with_what_it_sets_if_that_is_short():
    (cases, *_) = space_of(study_from(CASES)).axes
    assert name_words(cases, "d88") == "d88 (b₁ 88 mm)"
    assert name_words(cases, "d88", in_brackets=True) == "d88: b₁ 88 mm"
    (sides, *_) = space_of(study_from(SIDES)).axes
    assert name_words(sides, "rigid") == "rigid (K rigid, spring at the motor)"
    assert name_words(sides, "as it is") == "as it is"
    (persons, *_) = space_of(study_from(PEOPLE)).axes
    assert name_words(persons, persons.names[0]) == persons.names[0]


OPTIONAL = {
    "arm.contact_width": "40 mm",
    "arm.contact_radius": "45 mm",
    "spring.free_length": "70 mm",
    "spring.extensor.free_length": "70 mm",
}


@pytest.mark.parametrize("key", OPTIONAL)
def test_a_number_that_a_study_need_not_have_is_null_where_a_case_does_not_state_it(key):
    case = {"name": "with"}
    table = case
    *tables, name = key.split(".")
    for part in tables:
        table = table.setdefault(part, {})
    table[name] = OPTIONAL[key]
    designs = tendon.sweep({"cases": [case, {"name": "without"}], **LOADS}).designs
    column = "spring_free_length_extensor" if "extensor" in key else keys()[key].column
    assert designs[column].notna().tolist() == (designs["case"] == "with").tolist()


def test_a_number_that_only_one_side_states_is_null_for_the_other():
    study = {"spring": {"flexor": {"free_length": ["50 mm", "70 mm"]}}, **LOADS}
    designs = tendon.sweep(study).designs
    assert sorted(set(designs["spring_free_length_flexor"])) == [0.05, 0.07]
    assert designs["spring_free_length_extensor"].isna().all()
