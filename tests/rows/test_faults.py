"""Bad tables: every fault at once, with row and column, what was expected and what helps."""

from __future__ import annotations

import pytest

import tendon_cli as tendon
from tendon_cli.errors import InputError, StudyError

BAD = """\
name,spring.stifness (kN/m),spring.stiffness (kN/m),spool.ratio,arm.b1,\
tendon.diameter (kg),load_mass (kg)
S1,1,-3,0.6,120,5,1
,1,3,abc,120,5,1
S1,1,3 kN/m,=1+2,130,5,x
S4,1,4,0.5,130,5,<script>alert(1)</script>
"""
OF_BAD = [
    ("line 3, name", "missing or empty"),
    ("line 4, name", '"S1" is the name of two rows', "line 2"),
    ("line 1", "spring.stifness", 'did you mean "spring.stiffness (kN/m)"'),
    ("line 2, spring.stiffness", "-3 kN/m is impossible"),
    ("line 3, spool.ratio", '"abc"'),
    ("line 4, spool.ratio", '"=1+2"'),
    ("line 1", '"arm.b1": has no unit', 'write "arm.b1 (mm)"'),
    ("line 1", '"kg" is a mass'),
    ("line 1", '"load_mass (kg)"', 'did you mean "load.mass (kg)"'),
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def faults_of(error, *content, **study):
    with pytest.raises(error) as caught:
        tendon.study({"table": list(content), **study})
    return str(caught.value)


def of_file(name="springs.csv", **more):
    return {"name": "spring", "file": name, **more}


def test_all_faults_of_a_file_are_said_at_once(folder):
    (folder / "springs.csv").write_text(BAD)
    text = faults_of(InputError, of_file())
    for words in OF_BAD:
        line = [line for line in text.splitlines() if all(word in line for word in words)]
        assert line, words
        assert "springs.csv" in line[0]


def test_a_column_of_a_file_that_is_missing_is_no_fault_of_its_own(folder):
    price = {"design": {"minimise": ["price"]}, "load": {"mass": ["0 kg", "5 kg"]}}
    text = faults_of(StudyError, of_file("nowhere.csv"), **price)
    assert "nowhere.csv" in text
    assert "price" not in text
    (folder / "springs.csv").write_text("name,spring.stiffness (kN/m)\nS1,5\nS2,8\n")
    assert '"price"' in faults_of(StudyError, of_file(), **price)


def test_faults_of_the_study_stand_beside_those_of_the_file(folder):
    (folder / "springs.csv").write_text(BAD)
    motor = {"name": "motor", "rows": [{"name": "M", "spool.ratio": 0.6}]}
    text = faults_of(StudyError, of_file(), motor, load={"mass": "3 N"})
    assert "load.mass" in text
    assert 'the table "motor" sets spool.ratio, but so does the table spring' in text
    assert text.count("springs.csv, line") >= len(OF_BAD)


@pytest.mark.parametrize(
    ("study", "other"),
    [
        ({"spring": {"stiffness": ["1 kN/m", "2 kN/m"]}}, "is an axis"),
        ({"spring": {"stiffness": "3 kN/m +/- 0.2 kN/m"}}, "is uncertain"),
        ({"cases": [{"name": "a", "spring": {"stiffness": "4 kN/m"}}]}, "so do the cases"),
    ],
)
def test_a_number_that_something_else_sets_is_refused_with_both_places(study, other):
    table = {"name": "part", "rows": [{"name": "A", "spring.stiffness": "3 kN/m"}]}
    text = faults_of(StudyError, table, **study)
    assert "table.0" in text
    assert 'the table "part" sets spring.stiffness' in text
    assert other in text


def test_the_command_line_is_a_place_too(folder):
    (folder / "springs.csv").write_text("name,spool.ratio\nA,0.6\n")
    (folder / "study.toml").write_text('[[table]]\nname = "part"\nfile = "springs.csv"\n')
    with pytest.raises(StudyError, match=r"--set spool\.ratio does, too"):
        tendon.study("study.toml", ["spool.ratio=0.7"])
    with pytest.raises(StudyError, match=r"spool\.ratio"):
        tendon.study("study.toml").vary(**{"spool.ratio": 0.7})


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ({"name": "load_mass", "rows": [{"name": "A", "spool.ratio": 0.6}]}, "is a column"),
        ({"name": "two words", "rows": [{"name": "A", "spool.ratio": 0.6}]}, "not a name for a"),
        ({"rows": [{"name": "A", "spool.ratio": 0.6}]}, "is missing"),
        ({"name": "a"}, "has no rows"),
        ({"name": "a", "rows": []}, "at least one row"),
        ({"name": "a", "rows": [{"spool.ratio": 0.6}]}, 'no column "name"'),
        ({"name": "a", "file": "none.csv"}, "there is no file"),
        ({"name": "a", "rows": [{"name": "A", "motion.speed": "9 deg/s"}]}, "same for all rows"),
        ({"name": "spring", "rows": [{"name": "A", "stiffness": 3}]}, "spring_stiffness"),
        ({"name": "a", "rows": [{"name": "A", "friction": 3}]}, "sheath.friction"),
        (
            {"name": "a", "rows": [{"name": "A", "spring.stiffness": "8000000 kN/m"}]},
            "far from any arm",
        ),
        ({"name": "a", "rows": [{"name": "A", "arm.upper_arm_angle": 3}]}, "degrees or radians"),
        ({"name": "a", "rows": {"name": ["A"], "spool.ratio": [1, 2]}}, "same number in all"),
        ({"name": "a", "rows": [{"name": "A", "spring.at": "knee"}]}, '"joint" or "motor"'),
        ({"name": "a", "rows": [{"name": "A", "spool.ratio": [1, 2]}]}, "expected one value"),
        ({"name": "a", "rows": {"name": ["A", "B"], "spool.ratio": [1, True]}}, "truth value"),
        ({"name": "a", "rows": [{"name": "A", "spool.ratio": "0.5 to 0.7"}]}, "exact numbers"),
        ({"name": "a", "rows": {"name": ["A"], "part no": ["1"], "part-no": ["2"]}}, "given twice"),
        ({"name": "a", "rows": {"name": ["A"], "": ["1"]}}, "without a header"),
        ({"name": "a", "rows": {"name": ["A"], "price": [3.0], "": [""]}, "count": 3}, "a sample"),
    ],
)
def test_a_bad_table_says_what_helps(folder, table, problem):
    assert problem in faults_of((StudyError, InputError), table)


def test_sums_of_different_units_name_both_headers():
    first = {"name": "a", "rows": [{"name": "A", "spool.ratio": 0.6, "price (EUR)": 3}]}
    second = {"name": "b", "rows": [{"name": "B", "spool.flexor_radius": 0.03, "price ($)": 4}]}
    text = faults_of(StudyError, first, second)
    assert '"price (EUR)"' in text
    assert '"price ($)"' in text


def test_too_many_rows_are_refused_before_they_are_read(folder, monkeypatch):
    monkeypatch.setattr("tendon_cli.studies.attachments.MOST_ROWS", 1000)
    rows = "x,not a number\n" * 2000
    (folder / "springs.csv").write_text(f"name,spool.ratio\n{rows}")
    text = faults_of(StudyError, of_file())
    assert "more than 1,000 lines" in text
    assert "not a number" not in text


def test_formulas_and_scripts_that_are_carried_are_text(folder):
    cells = ['=HYPERLINK("http://x")', "<script>alert(1)</script>", "@SUM(A1)"]
    rows = {"name": list("abc"), "spool.ratio": [0.6, 0.7, 0.8], "supplier": cells}
    study = tendon.study({"table": [{"name": "part", "rows": rows}]})
    assert list(tendon.sweep(study).designs.part_supplier) == cells


@pytest.mark.parametrize(
    ("header", "sets"), [("price (EUR)", False), ("spring.stiffness (kN/m)", True)]
)
def test_rows_that_set_nothing_are_refused(header, sets):
    rows = [{"name": "A", header: 3}, {"name": "B", header: 4}]
    content = {"table": [{"name": "spring", "rows": rows}]}
    if sets:
        assert tendon.study(content).row_tables[0].numbers
    else:
        with pytest.raises(StudyError, match="no column is a key of the study"):
            tendon.study(content)


def test_a_table_without_a_key_is_refused_with_the_nearest_keys(folder):
    (folder / "suits.csv").write_text("name,Spring rate (N/mm),mu,built by\nHeron,4.5,0.09,Ada\n")
    with pytest.raises(InputError, match=r"suits\.csv, line 1: no column is a key") as caught:
        tendon.study({"table": [of_file("suits.csv")]})
    text = caught.value.hint or ""
    assert '"spring.stiffness" for "Spring rate (N/mm)", "sheath.friction" for "mu"?' in text
    assert "built by" not in text


def test_a_table_with_one_key_carries_its_other_columns(folder):
    (folder / "suits.csv").write_text("name,spool.ratio,built by\nHeron,0.6,Ada\n")
    assert tendon.study({"table": [of_file("suits.csv")]}).axes


@pytest.mark.parametrize(("unit", "hint"), [("(mm)", "extension (mm)"), ("(N)", "extension")])
def test_a_hint_at_a_key_has_the_unit_of_the_header_only_if_it_fits(folder, unit, hint):
    rows = [{"name": "A", f"limits.max_spring_extent {unit}": 30, "spool.ratio": 0.6}]
    told = faults_of((StudyError,), {"name": "a", "rows": rows})
    assert f'did you mean "limits.max_spring_{hint}"?' in told


def test_a_number_set_twice_is_told_with_both_places(folder):
    rows = [{"name": "A", "spring.stiffness": "4 kN/m"}]
    told = faults_of(
        (StudyError,),
        {"name": "part", "rows": rows},
        cases=[{"name": "a", "spring": {"stiffness": "5 kN/m"}}],
        load={"mass": [1, 2]},
    )
    assert 'table.0: the table "part" sets spring.stiffness, but so do the cases (cases.0' in told
