"""`tendon show` and `tendon export`: the rows asked for, as the table has them, whatever reads them."""

import csv
import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

STUDY = """
[tendon]
pretension = ["90 N", "130 N", "170 N"]
[load]
mass = ["0 kg", "5 kg"]
[motion]
elbow_angle = { from = "0 deg", to = "170 deg", num = 18 }
[[cases]]
name = '=HYPERLINK("http://x")'
[[cases]]
name = "@sum"
[cases.arm]
b1 = "140 mm"
[[cases]]
name = 'say "a, b"'
"""


@pytest.fixture
def run(tendon, workplace):
    (workplace / "study.toml").write_text(STUDY, encoding="utf-8")
    assert (
        tendon("sweep", "study.toml", "--no-figures", "--out", "run", "--allow-no-equilibrium").exit
        == 0
    )
    return workplace / "run"


def read_csv(text):
    header, *rows = csv.reader(io.StringIO(text))
    return [name.partition(" (")[0] for name in header], rows


@pytest.mark.parametrize("table", ["designs", "states"])
def test_an_export_says_every_value_as_the_table_does(tendon, run, table):
    ran = tendon("export", run, "all.csv", "--table", table, "--json")
    expected = pd.read_parquet(run / f"{table}.parquet")
    assert (ran.exit, ran.json["rows"], ran.json["columns"]) == (
        0,
        len(expected),
        list(expected.columns),
    )
    names, _ = read_csv(Path("all.csv").read_text("utf-8"))
    assert names == list(expected.columns)
    found = pd.read_csv("all.csv")
    found.columns = names
    for name in names:
        column = expected[name]
        if column.dtype == "category":
            words = (
                column.astype(object)
                .where(column.notna(), "")
                .str.replace(r"^([=+\-@])", r"'\1", regex=True)
            )
            assert list(found[name].fillna("")) == list(words)
        else:
            np.testing.assert_array_equal(found[name].to_numpy(), column.to_numpy(), strict=False)
    assert expected.attrs["units"]["pretension"] == "N"
    assert '"pretension (N)"' in Path("all.csv").read_text("utf-8").splitlines()[0]


def test_an_export_has_the_numbers_of_a_language_and_the_units_of_studies(tendon, run):
    assert tendon("export", run, "si.csv").exit == 0
    assert tendon("export", run, "de.csv", "--locale", "de", "--units", "study").exit == 0
    first, second = pd.read_csv("si.csv"), pd.read_csv("de.csv", sep=";", decimal=",")
    assert "bend_angle (deg)" in second
    for name, factor in (
        ("pretension (N)", 1.0),
        ("max_tension (N)", 1.0),
        ("spring_stiffness (N/m)", 1e3),
    ):
        other = name.replace("N/m", "kN/m")
        assert second[other].to_numpy() * factor == pytest.approx(first[name].to_numpy(), rel=1e-12)


@pytest.mark.parametrize("part", ["spring", "anchor"])
def test_what_is_rigid_is_called_so_everywhere(tendon, workplace, part):
    (workplace / "s.toml").write_text(
        f'[{part}]\nstiffness = ["3 kN/m", "rigid"]\n', encoding="utf-8"
    )
    assert tendon("sweep", "s.toml", "--out", "run").exit == 0
    only = ("--where", f"{part}_stiffness = rigid", "--columns", f"{part}_stiffness")
    assert "rigid" in tendon("show", "run", *only).out
    assert tendon("show", "run", *only, "--json").json["data"] == [{f"{part}_stiffness": "rigid"}]
    assert (
        len(tendon("show", "run", "--where", f"{part}.stiffness != 3 kN/m", "--json").json["data"])
        == 1
    )
    assert tendon("export", "run", "run.csv", "--columns", f"{part}_stiffness").exit == 0
    assert [row[0] for row in read_csv(Path("run.csv").read_text("utf-8"))[1]] == ["3000", "rigid"]
    assert tendon("plot", "run", "-y", "max_tension", "--x", f"{part}.stiffness").exit == 0
    assert tendon("report", "run").exit == 0


def test_nothing_in_an_export_is_run_by_a_spreadsheet(tendon, run):
    assert tendon("export", run, "all.csv").exit == 0
    cells = {cell for row in read_csv(Path("all.csv").read_text("utf-8"))[1] for cell in row}
    assert {"'@sum", '\'=HYPERLINK("http://x")'} <= cells
    assert all(float(cell) < 0 for cell in cells if cell[:1] == "-")
    assert not [cell for cell in cells if cell[:1] in ("=", "+", "@", "\t")]


@pytest.mark.parametrize(
    ("words", "query"),
    [
        (("--where", "load_mass = 5 kg"), "load_mass == 5.0"),
        (
            ("--where", "load.mass = 5 kg", "--where", "pretension >= 130 N"),
            "load_mass == 5.0 and pretension >= 130",
        ),
        (("--where", "taut = true"), "taut"),
        (("--where", "required_pretension <= 1 kN"), "required_pretension <= 1000"),
        (("--where", "case = @sum"), "case == '@sum'"),
    ],
)
def test_filters_and_sorting_give_what_pandas_does(tendon, run, words, query):
    expected = pd.read_parquet(run / "designs.parquet").query(query)
    shown = tendon("show", run, *words, "--json", "--columns", "design").json
    assert (shown["rows"], [row["design"] for row in shown["data"]]) == (
        len(expected),
        list(expected["design"]),
    )
    for sort, rising in (("max_tension", True), ("-max_tension", False)):
        shown = tendon(
            "show", run, *words, "--json", "--columns", "max_tension", "--sort", sort, "--head", 3
        ).json
        column = expected["max_tension"].sort_values(ascending=rising).head(3)
        assert [row["max_tension"] for row in shown["data"]] == list(
            column.where(column.notna(), None)
        )


def test_what_is_shown_fits_the_terminal_in_units_that_people_read(tendon, run, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    shown = tendon("show", run, "--table", "states", "--head", 2).out
    assert max(map(len, shown.splitlines())) <= 80
    assert "2 of 648 rows" in shown
    for width, fit in ((25, True), (24, False)):  # two columns of 11 and 12 signs, and two spaces
        monkeypatch.setenv("COLUMNS", str(width))
        shown = tendon(
            "show", run / "states.parquet", "--columns", "elbow_angle,motor_torque", "--head", "2"
        ).out
        lines = [line.split() for line in shown.splitlines()]
        assert (lines[0] == ["elbow_angle", "motor_torque"]) is fit
        assert [line[0] for line in lines[1:4]] == ["deg", "0", "10"]


def test_nothing_is_left_is_no_error(tendon, run):
    ran = tendon("show", run, "--where", "load_mass > 5 kg", "--json")
    assert (ran.exit, ran.json["rows"], ran.json["data"]) == (0, 0, [])
    assert tendon("export", run, "none.csv", "--where", "load_mass > 5 kg").exit == 0
    assert len(Path("none.csv").read_text("utf-8").splitlines()) == 1


PEOPLE = "Name;weight_kg;stature [in];shoe;weighting\nAda;62,5;66;39;1\n=Bo();90;;44;2\n"


def test_a_file_of_people_is_shown_as_it_is_read(tendon, workplace):
    (workplace / "people.csv").write_text(PEOPLE, encoding="utf-8")
    ran = tendon("show", "people.csv")
    assert [line.split() for line in ran.out.splitlines()] == [
        ["name", "weight", "stature", "weighting"],
        ["kg", "mm"],
        ["Ada", "62.5", "1676.4", "1"],
        ["=Bo()", "90", "-", "2"],
        [],
        ["2", "of", "2", "rows"],
    ]
    shown = tendon("show", "people.csv", "--where", "weight > 70 kg", "--json").json
    assert shown["units"] == {"name": "1", "weight": "kg", "stature": "m", "weighting": "1"}
    assert shown["data"] == [{"name": "=Bo()", "weight": 90.0, "stature": None, "weighting": 2.0}]
    sorted_ = tendon(
        "show", "people.csv", "--sort", "-weight", "--columns", "name,weight", "--head", 1, "--csv"
    )
    assert sorted_.out.splitlines() == ['"name","weight (kg)"', '"\'=Bo()",90']


def test_an_exported_file_of_people_is_the_same_people(tendon, workplace):
    (workplace / "people.csv").write_text(PEOPLE.replace("=Bo()", "Bo"), encoding="utf-8")
    assert tendon("export", "people.csv", "other.csv").exit == 0
    assert tendon("show", "other.csv", "--json").json == tendon("show", "people.csv", "--json").json


LIMITED = """
import sys
from pathlib import Path
from tendon_cli.cli import main
try:
    main(sys.argv[1:])
finally:
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    print(int(status["VmHWM"].split()[0]) * 1024, file=sys.stderr)  # ru_maxrss would count the peak of these tests
"""


@pytest.mark.torture
@pytest.mark.skipif(
    sys.platform != "linux", reason="the peak of a process alone is Linux's to tell"
)
def test_ten_million_rows_are_exported_in_constant_memory(tendon, workplace):
    content = '[tendon]\npretension = { from = "60 N", to = "240 N", num = 55000 }\n[output]\ntables = ["states"]\n'
    (workplace / "large.toml").write_text(content, encoding="utf-8")
    assert tendon("sweep", "large.toml", "--out", "large", "--no-figures").exit == 0
    ran = subprocess.run(
        [sys.executable, "-c", LIMITED, "export", "large", "large.csv"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert int(ran.stderr.split()[-1]) < 300e6
    with Path("large.csv").open("rb") as file:
        assert sum(1 for _ in file) == 55000 * 182 + 1
