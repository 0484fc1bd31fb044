"""A comparison finds every change and nothing else; axis values say which designs are the same."""

import re

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.checks.check_text import as_markdown
from tendon_cli.checks.compared import difference
from tendon_cli.errors import UsageError
from tests.check.conftest import swept


@pytest.fixture(scope="session")
def rougher(tmp_path_factory):
    return swept(tmp_path_factory.mktemp("check") / "rougher", sheath={"friction": 0.0705})


def test_a_run_is_as_it_is(plain):
    result = tendon.check(plain, plain, tolerance=0.0)
    assert result.holds
    assert "nothing changed" in result.text
    compared = r"compared: \d+ columns of 18 designs and \d+ columns of 684 states"
    assert re.search(compared, result.text)
    assert result.record["within"] is None


def test_an_edit_is_told_with_what_it_does_unless_the_key_is_named(plain, rougher):
    edited = tendon.check(rougher, plain, tolerance=1e-9)
    accepted = tendon.check(rougher, plain, tolerance=1e-9, apart=["sheath.friction"])
    line = "  sheath.friction was 0.07, now 0.0705 (--except sheath.friction accepts it)\n"
    assert edited.text.replace(line, "") == accepted.text != edited.text
    assert edited.record == accepted.record | {"edits": ["sheath.friction"]}
    assert not edited.holds
    assert not accepted.holds


@pytest.mark.parametrize(
    ("key", "near"), [("sheat.friction", "sheath.friction"), ("limit", "limits")]
)
def test_a_key_that_no_study_has_is_refused_with_the_nearest(plain, rougher, key, near):
    with pytest.raises(UsageError) as refused:
        tendon.check(rougher, plain, tolerance=1e-9, apart=[key])
    assert refused.value.hint == f'did you mean "{near}"?'


def test_each_column_is_named_with_its_largest_difference(plain, rougher):
    before = tendon.open(plain)
    now = tendon.open(rougher)
    record = tendon.check(rougher, plain, tolerance=0.0, apart=["sheath.friction"]).record
    changes = {(change["table"], change["name"]): change for change in record["changes"]}
    for table in ("designs", "states"):
        values_now = getattr(now, table)
        values_before = getattr(before, table)
        for column in ("max_tension", "margin", "motor_torque", "spool_angle"):
            if column not in values_now:
                continue
            largest = (values_now[column] - values_before[column]).abs().max()
            scale = max(values_now[column].abs().max(), values_before[column].abs().max())
            change = changes[table, column]
            assert change["most"] == pytest.approx(largest, rel=1e-12)
            assert change["change"] == pytest.approx(largest / scale, rel=1e-12)


def test_a_tolerance_just_holds_and_just_fails(plain, rougher):
    def compare_within(tolerance):
        return tendon.check(rougher, plain, tolerance=tolerance, apart=["sheath.friction"])

    changes = compare_within(0.0).record["changes"]
    of_numbers = [change for change in changes if change["most"] is not None]
    flags = {change["name"] for change in changes if change["most"] is None}
    worst = max(of_numbers, key=lambda change: change["change"])
    wide = compare_within(worst["change"] * (1 + 1e-9))
    assert {change["name"] for change in wide.record["changes"]} == flags
    assert wide.record["within"] == worst
    assert "within the tolerance, the largest difference: " in wide.text
    tight = compare_within(worst["change"] * (1 - 1e-9))
    assert len(tight.record["changes"]) == len(wide.record["changes"]) + 1


def is_at(breach, place, designs):
    """Return True if a breach is of the design with the values of a place."""
    design = designs.loc[designs["design"] == breach["design"]].iloc[0]
    return all(f"{column} {design[column]:g}" in place for column in ("pretension", "load_mass"))


def test_feasibility_that_flipped_is_named_design_by_design(plain, tmp_path):
    stiffer = swept(tmp_path / "stiffer", spring={"stiffness": "3.4 kN/m"})
    before = tendon.open(plain).designs
    now = tendon.open(stiffer).designs
    result = tendon.check(stiffer, plain, tolerance=1e9, apart=["spring.stiffness"])
    record = result.record
    changed = {change["name"] for change in record["changes"]}
    assert {"feasible", "status"} <= changed  # flags have no tolerance
    counts = {
        "gained": (now["feasible"] & ~before["feasible"]).sum(),
        "lost": (before["feasible"] & ~now["feasible"]).sum(),
    }
    assert sum(counts.values()) > 0
    for name, loses in (("gained", plain), ("lost", stiffer)):
        assert record[name]["count"] == counts[name]
        assert [one["name"] for one in record[name]["why"]] == list(record[name]["names"])
        breaches = tendon.check(loses, worst=1000).record["breaches"]
        for one in record[name]["why"]:
            broken = {found["limit"] for found in breaches if is_at(found, one["name"], before)}
            assert {*one["why"].split(", ")} == broken > set()
            assert f"{one['name']}: {one['why']}" in result.text


def test_runs_of_other_axes_compare_on_what_they_share(plain, tmp_path):
    pretensions = {"pretension": ["160 N", "100 N"]}
    fewer = swept(tmp_path / "fewer", tendon=pretensions, load={"mass": "5 kg"})
    for run, baseline in ((fewer, plain), (plain, fewer)):
        result = tendon.check(run, baseline, tolerance=0.0)
        assert not result.holds
        assert "2 designs" in result.record["compared"]
        assert result.record["changes"] == []
        missing = {text.partition(":")[0] for text in result.record["missing"]}
        assert missing == {"load.mass", "tendon.pretension"}
        excepted = tendon.check(run, baseline, tolerance=0.0, apart=["tendon", "load.mass"])
        assert excepted.holds
        assert "load.mass: 1 value in " in excepted.text


@pytest.mark.parametrize(
    ("output", "missing"),
    [
        ({"tables": ["designs"]}, "states: a table in the first only"),
        (
            {"states": ["status", "motor_torque"]},
            "states.elbow_torque: a column in the first only",
        ),
    ],
)
def test_what_only_one_run_keeps_is_a_change(plain, tmp_path, output, missing):
    less = swept(tmp_path / "less", output=output)
    result = tendon.check(less, plain, tolerance=0.0)
    assert not result.holds
    assert missing in result.record["missing"]
    assert f"not compared: {missing}" in result.text


def test_runs_with_nothing_in_common_are_refused(plain, tmp_path):
    other = swept(tmp_path / "other", tendon={"pretension": ["161 N", "163 N"]})
    with pytest.raises(UsageError, match=r"no value of tendon\.pretension in common"):
        tendon.check(other, plain, tolerance=0.0)
    alone = swept(tmp_path / "alone", load={"mass": "4 kg"})
    with pytest.raises(UsageError, match=r"only one of the runs has the axis load\.mass"):
        tendon.check(alone, plain, tolerance=0.0)


def test_a_null_against_a_number_is_a_change():
    now = np.array([1.0, np.nan, np.nan, 1.0])
    before = np.array([np.nan, 1.0, np.nan, 1.0])
    assert difference(now, before, is_flag=False).tolist() == [np.inf, np.inf, 0.0, 0.0]


def test_markdown_is_headed_by_what_was_found(plain, rougher):
    same = tendon.check(plain, plain)
    assert as_markdown(same.text, same.verdict).startswith("### tendon check: nothing changed\n")
    other = tendon.check(rougher, plain, apart=["sheath.friction"])
    assert as_markdown(other.text, other.verdict).startswith("### tendon check: changed\n")
