"""A comparison finds every change, nothing else, and matches designs by the values of their axes."""

import re

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.checks.compare import compare, difference
from tendon_cli.errors import UsageError
from tests.check.conftest import swept


@pytest.fixture(scope="session")
def rougher(tmp_path_factory):
    return swept(tmp_path_factory.mktemp("check") / "rougher", sheath={"friction": 0.0705})


def test_a_run_is_as_it_is(plain):
    found = compare(plain, plain, tolerance=0.0)
    assert found.holds
    assert "nothing changed" in found.text
    assert re.search(
        r"compared: \d+ columns of 18 designs and \d+ columns of 684 states", found.text
    )
    assert found.record["within"] is None


def test_another_study_is_refused_unless_the_key_is_named(plain, rougher):
    with pytest.raises(UsageError, match=r"sheath\.friction was 0\.07, now 0\.0705"):
        compare(rougher, plain, tolerance=1e-9)
    assert not compare(rougher, plain, tolerance=1e-9, apart=["sheath.friction"]).holds


@pytest.mark.parametrize(
    ("key", "near"), [("sheat.friction", "sheath.friction"), ("limit", "limits")]
)
def test_a_key_that_no_study_has_is_told(plain, rougher, key, near):
    with pytest.raises(UsageError) as refused:
        compare(rougher, plain, tolerance=1e-9, apart=[key])
    assert refused.value.hint == f'did you mean "{near}"?'


def test_each_column_is_told_by_its_own_largest_difference(plain, rougher):
    before, now = tendon.open_run(plain), tendon.open_run(rougher)
    found = compare(rougher, plain, tolerance=0.0, apart=["sheath.friction"]).record["changes"]
    told = {(change["table"], change["column"]): change for change in found}
    for table in ("designs", "states"):
        first, second = getattr(now, table), getattr(before, table)
        for column in ("max_tension", "margin", "motor_torque", "spool_angle"):
            if column in first:
                difference = (first[column] - second[column]).abs().max()
                scale = max(first[column].abs().max(), second[column].abs().max())
                assert told[table, column]["difference"] == pytest.approx(difference, rel=1e-12)
                assert told[table, column]["share"] == pytest.approx(difference / scale, rel=1e-12)


def test_a_tolerance_just_holds_and_just_fails(plain, rougher):
    found = compare(rougher, plain, tolerance=0.0, apart=["sheath.friction"]).record["changes"]
    worst = max(change["share"] for change in found if change["difference"] is not None)
    exact = {change["column"] for change in found if change["difference"] is None}
    held = compare(rougher, plain, tolerance=worst * (1 + 1e-9), apart=["sheath.friction"])
    wide = held.record["changes"]
    assert {change["column"] for change in wide} == exact
    assert held.record["within"] == max(
        (change for change in found if change["difference"] is not None),
        key=lambda change: change["share"],
    )
    assert "within the tolerance, the largest difference: " in held.text
    tight = compare(rougher, plain, tolerance=worst * (1 - 1e-9), apart=["sheath.friction"]).record[
        "changes"
    ]
    assert len(tight) == len(wide) + 1


def test_feasibility_that_flipped_is_named_design_by_design(plain, tmp_path):
    stiffer = swept(tmp_path / "stiffer", spring={"stiffness": "3.4 kN/m"})
    before, now = (tendon.open_run(folder).designs for folder in (plain, stiffer))
    found = compare(stiffer, plain, tolerance=1e9, apart=["spring.stiffness"], worst=1000).record
    assert {"feasible", "status"} <= {
        change["column"] for change in found["changes"]
    }  # flags have no tolerance
    differs = now[now["feasible"] != before["feasible"]]
    assert found["flipped"] == len(differs) > 0
    told = {
        (flip["where"]["pretension"], flip["where"]["load_mass"]): flip["now"]
        for flip in found["flips"]
    }
    assert told == {(row.pretension, row.load_mass): row.feasible for row in differs.itertuples()}


def test_runs_of_other_axes_compare_on_what_they_share(plain, tmp_path):
    fewer = swept(
        tmp_path / "fewer", tendon={"pretension": ["160 N", "100 N"]}, load={"mass": "5 kg"}
    )
    for one, other in ((fewer, plain), (plain, fewer)):
        found = compare(one, other, tolerance=0.0)
        assert not found.holds
        assert (found.record["designs"], found.record["changes"]) == (2, [])
        assert {text.partition(":")[0] for text in found.record["missing"]} == {
            "load.mass",
            "tendon.pretension",
        }
        excepted = compare(one, other, tolerance=0.0, apart=["tendon", "load.mass"])
        assert excepted.holds
        assert "load.mass: 1 value in " in excepted.text


@pytest.mark.parametrize(
    ("output", "missing"),
    [
        ({"tables": ["designs"]}, "states: a table in the baseline only"),
        (
            {"states": ["status", "motor_torque"]},
            "states.elbow_torque: a column in the baseline only",
        ),
    ],
)
def test_what_only_one_run_keeps_is_a_change(plain, tmp_path, output, missing):
    found = compare(swept(tmp_path / "less", output=output), plain, tolerance=0.0)
    assert not found.holds
    assert missing in found.record["missing"]
    assert f"not compared: {missing}" in found.text


def test_runs_with_nothing_in_common_are_refused(plain, tmp_path):
    other = swept(tmp_path / "other", tendon={"pretension": ["161 N", "163 N"]})
    with pytest.raises(UsageError, match=r"no value of tendon\.pretension in common"):
        compare(other, plain, tolerance=0.0)
    alone = swept(tmp_path / "alone", load={"mass": "4 kg"})
    with pytest.raises(UsageError, match=r"only one of the runs has the axis load\.mass"):
        compare(alone, plain, tolerance=0.0)


def test_a_null_against_a_number_is_a_change():
    first, second = np.array([1.0, np.nan, np.nan, 1.0]), np.array([np.nan, 1.0, np.nan, 1.0])
    assert difference(first, second, is_flag=False).tolist() == [np.inf, np.inf, 0.0, 0.0]
