"""`tendon show` and `tendon export` give the rows asked for as the table has them."""

import csv
import io
import re
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
def run(tendon, workplace, write_study):
    write_study(STUDY)
    words = ("--no-figures", "--out", "run", "--allow-no-equilibrium")
    assert tendon("sweep", "study.toml", *words).exit == 0
    return workplace / "run"


def read_csv(name):
    """Return the names of the columns without units, and the rows as text."""
    text = Path(name).read_text("utf-8")
    header, *rows = csv.reader(io.StringIO(text))
    names = [title.partition(" (")[0] for title in header]
    return names, rows


def exported_words(column):
    """Return the words of a column as exported: an empty text for null, a formula quoted."""
    words = column.astype(object).where(column.notna(), "")
    return list(words.str.replace(r"^([=+\-@])", r"'\1", regex=True))


@pytest.mark.parametrize("table", ["designs", "states"])
def test_an_export_says_every_value_as_the_table_does(tendon, run, table):
    ran = tendon("export", run, "all.csv", "--table", table, "--json")
    expected = pd.read_parquet(run / f"{table}.parquet")
    assert ran.exit == 0
    assert ran.json["rows"] == len(expected)
    assert ran.json["columns"] == list(expected.columns)
    names, rows = read_csv("all.csv")
    assert names == list(expected.columns)
    texts = dict(zip(names, zip(*rows, strict=True), strict=True))
    exported = pd.read_csv("all.csv")
    exported.columns = names
    for name in names:
        column = expected[name]
        if column.dtype == "category":
            assert list(exported[name].fillna("")) == exported_words(column)
        else:
            values = exported[name].to_numpy()
            if column.dtype == np.float64:  # to the last digit, whatever pandas makes of it
                values = np.array([float(text or "nan") for text in texts[name]])
            np.testing.assert_array_equal(values, column.to_numpy(), strict=False)
    assert expected.attrs["units"]["pretension"] == "N"
    assert '"pretension (N)"' in Path("all.csv").read_text("utf-8").splitlines()[0]


def test_an_export_has_the_numbers_of_a_language_and_the_units_of_studies(tendon, run):
    assert tendon("export", run, "si.csv").exit == 0
    assert tendon("export", run, "de.csv", "--locale", "de", "--units", "study").exit == 0
    in_si = pd.read_csv("si.csv")
    german = pd.read_csv("de.csv", sep=";", decimal=",")
    assert "bend_angle (deg)" in german
    pairs = [
        ("pretension (N)", "pretension (N)", 1.0),
        ("max_tension (N)", "max_tension (N)", 1.0),
        ("spring_stiffness (N/m)", "spring_stiffness (kN/m)", 1e3),
    ]
    for name, german_name, factor in pairs:
        converted = german[german_name].to_numpy() * factor
        assert converted == pytest.approx(in_si[name].to_numpy(), rel=1e-12)


@pytest.mark.parametrize("part", ["spring", "anchor"])
def test_what_is_rigid_is_called_so_everywhere(tendon, write_study, blank_figures, part):
    write_study(f'[{part}]\nstiffness = ["3 kN/m", "rigid"]\n')
    assert tendon("sweep", "study.toml", "--out", "run").exit == 0
    only = ("--where", f"{part}_stiffness = rigid", "--columns", f"{part}_stiffness")
    assert "rigid" in tendon("show", "run", *only).out
    assert tendon("show", "run", *only, "--json").json["data"] == [{f"{part}_stiffness": "rigid"}]
    soft_left_out = ("--where", f"{part}.stiffness != 3 kN/m")
    assert len(tendon("show", "run", *soft_left_out, "--json").json["data"]) == 1
    assert tendon("export", "run", "run.csv", "--columns", f"{part}_stiffness").exit == 0
    _, rows = read_csv("run.csv")
    assert rows == [["3000"], ["rigid"]]
    assert tendon("plot", "run", "-y", "max_tension", "--x", f"{part}.stiffness").exit == 0
    assert tendon("report", "run").exit == 0


@pytest.mark.parametrize("units", ["si", "study"])
def test_an_export_for_a_paper_is_rounded_to_significant_digits(tendon, run, units):
    words = ("export", run, "--units", units)
    assert tendon(*words[:2], "whole.csv", *words[2:]).exit == 0
    assert tendon(*words[:2], "paper.csv", *words[2:], "--round", 4).exit == 0
    heads, whole = read_csv("whole.csv")
    rounded_heads, rounded = read_csv("paper.csv")
    assert rounded_heads == heads
    differ = 0
    for row, short in zip(whole, rounded, strict=True):
        for cell, text in zip(row, short, strict=True):
            differ += cell != text
            if cell != text:
                assert len(text.replace(".", "").strip("-0").partition("e")[0]) <= 4
                assert float(text) == pytest.approx(float(cell), rel=5e-4)
    assert differ > 0
    assert tendon(*words[:2], "paper.csv", "--round", 0).exit == 2


def test_nothing_in_an_export_is_run_by_a_spreadsheet(tendon, run):
    assert tendon("export", run, "all.csv").exit == 0
    _, rows = read_csv("all.csv")
    cells = {cell for row in rows for cell in row}
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
    show = ("show", run, *words, "--json")
    shown = tendon(*show, "--columns", "design").json
    assert shown["rows"] == len(expected)
    assert [row["design"] for row in shown["data"]] == list(expected["design"])
    for sort, rising in (("max_tension", True), ("-max_tension", False)):
        shown = tendon(*show, "--columns", "max_tension", "--sort", sort, "--head", 3).json
        tensions = [row["max_tension"] for row in shown["data"]]
        column = expected["max_tension"].sort_values(ascending=rising).head(3)
        assert tensions == list(column.where(column.notna(), None))


def test_what_is_shown_fits_the_terminal_in_units_that_people_read(tendon, run, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    shown = tendon("show", run, "--table", "states", "--head", 2).out
    assert max(map(len, shown.splitlines())) <= 80
    assert "2 of 648 rows" in shown
    columns = ("--columns", "elbow_angle,motor_torque")
    # Two columns of 11 and 12 characters, and two spaces.
    for width, both_fit in ((25, True), (24, False)):
        monkeypatch.setenv("COLUMNS", str(width))
        shown = tendon("show", run / "states.parquet", *columns, "--head", "2").out
        lines = [line.split() for line in shown.splitlines()]
        assert (lines[0] == ["elbow_angle", "motor_torque"]) is both_fit
        assert [line[0] for line in lines[1:4]] == ["deg", "0", "10"]


def test_a_wide_table_shows_three_blocks_and_names_the_other_columns(tendon, run, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    every = list(pd.read_parquet(run / "designs.parquet").columns)
    shown, _, below = tendon("show", run).out.partition(" rows\n")
    blocks = shown.split("\n\n")[:-1]
    assert len(blocks) == 3
    in_blocks = [name for block in blocks for name in block.splitlines()[0].split()]
    count, names = re.fullmatch(r"(\d+) more columns?, which .* show: (.*)", said(below)).groups()
    assert int(count) == len(names.split(", "))
    assert sorted([*in_blocks, *names.split(", ")]) == sorted(every)
    asked = tendon("show", run, "--columns", ",".join(every)).out
    assert asked.split()[: len(every[:2])] == every[:2]
    assert all(name in asked for name in every)
    assert "more column" not in asked


def said(text):
    """Return a text without its line ends."""
    return " ".join(text.split())


@pytest.mark.parametrize(
    ("column", "hint"),
    [
        ("peak_motor_power", "if its study states motion.speed or motion.trajectory"),
        ("rms_motor_torque", "if its study states motion.trajectory"),
        ("peak_motor_torqe", 'did you mean "peak_motor_torque"?'),
    ],
)
def test_a_column_of_another_table_is_told_with_its_table(tendon, run, column, hint):
    done = tendon("show", run, "--columns", column)
    assert done.exit == 2
    assert hint in done.err


def test_a_filter_that_leaves_nothing_is_no_error(tendon, run):
    ran = tendon("show", run, "--where", "load_mass > 5 kg", "--json")
    assert ran.exit == 0
    assert ran.json["rows"] == 0
    assert ran.json["data"] == []
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
    heaviest = ("--sort", "-weight", "--head", 1)
    shown = tendon("show", "people.csv", *heaviest, "--columns", "name,weight", "--csv").out
    assert shown.splitlines() == ['"name","weight (kg)"', '"\'=Bo()",90']


def test_an_exported_file_of_people_is_the_same_people(tendon, workplace):
    (workplace / "people.csv").write_text(PEOPLE.replace("=Bo()", "Bo"), encoding="utf-8")
    assert tendon("export", "people.csv", "other.csv").exit == 0
    assert tendon("show", "other.csv", "--json").json == tendon("show", "people.csv", "--json").json


PEAK_AFTER = """
import sys
from pathlib import Path
from tendon_cli.commands.cli import main

try:
    main(sys.argv[1:])
finally:
    lines = Path("/proc/self/status").read_text().splitlines()
    status = dict(line.split(":", 1) for line in lines)
    peak = int(status["VmHWM"].split()[0]) * 1024  # ru_maxrss would count the peak of these tests
    print(peak, file=sys.stderr)
"""
TEN_MILLION_ROWS = """
[tendon]
pretension = { from = "60 N", to = "240 N", num = 55000 }
[output]
tables = ["states"]
"""


@pytest.mark.torture
@pytest.mark.skipif(
    sys.platform != "linux", reason="the peak of a process alone is Linux's to tell"
)
def test_ten_million_rows_are_exported_in_constant_memory(tendon, workplace):
    (workplace / "large.toml").write_text(TEN_MILLION_ROWS, encoding="utf-8")
    assert tendon("sweep", "large.toml", "--out", "large", "--no-figures").exit == 0
    command = [sys.executable, "-c", PEAK_AFTER, "export", "large", "large.csv"]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    assert int(ran.stderr.split()[-1]) < 300e6
    with Path("large.csv").open("rb") as file:
        assert sum(1 for _ in file) == 55000 * 182 + 1


def test_columns_of_a_file_of_people_that_are_not_read_are_named(tendon, tmp_path):
    people = tmp_path / "people.csv"
    people.write_text("name,stature (cm),hair\nAda,168,red\nBob,181,fair\n")
    for words in (("show", people), ("show", people, "--json"), ("export", people, "out.csv")):
        ran = tendon(*map(str, words))
        assert ran.exit == 0
        assert "columns not read: hair" in ran.err
        assert "hair" not in ran.out
    people.write_text("name,stature (cm)\nAda,168\n")
    assert tendon("show", str(people)).err == ""


def test_rows_that_are_not_shown_are_told_with_the_option_that_shows_them(tendon, run):
    some = ("show", run, "--table", "states", "--columns", "elbow_angle", "--head", 2)
    told = "2 of 648 rows; --head 648 shows all"
    assert tendon(*some).out.splitlines()[-1] == told
    assert told in tendon(*some, "--csv").err
    every = (*some[:-1], 648)
    assert tendon(*every).out.splitlines()[-1] == "648 of 648 rows"
    assert tendon(*every, "--csv").err == ""


def test_a_table_of_a_folder_that_is_not_there_is_not_called_a_table(tendon, tmp_path):
    done = tendon("show", tmp_path / "nowhere", "--table", "persons")
    assert done.exit != 0
    assert "is one table" not in done.err
    assert "no such" in done.err


def test_a_price_in_another_currency_is_refused_with_the_unit_of_the_column(tendon, tmp_path):
    (tmp_path / "springs.csv").write_text(
        "name,spring.stiffness (kN/m),price (EUR)\nS4,4,60\nS5,5,75\n"
    )
    study = tmp_path / "catalogue.toml"
    study.write_text('spool.ratio = 0.6\n[[table]]\nname = "spring"\nfile = "springs.csv"\n')
    answer = tmp_path / "answer"
    tendon("design", study, "--no-figures", "--out", answer)
    show = ("show", answer, "--columns", "spring,price", "--json", "--where")
    for text in ("price < 150 EUR", "price < 150", "spring_price <= 74.9 EUR"):
        assert [row["spring"] for row in tendon(*show, text).json["data"]] == ["S4"]
    for text in ("price < 150 USD", "price < 150 N"):
        done = tendon("show", answer, "--where", text)
        assert done.exit == 2
        assert "expected a number in EUR" in done.err
