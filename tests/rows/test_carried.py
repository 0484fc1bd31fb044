"""Columns that rows carry along: in every table, summed, as goals and filters, and in words."""

from __future__ import annotations

import json
import re
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.answers.phrases import sums_words
from tendon_cli.cube.rows import export, rows_in
from tendon_cli.errors import StudyError
from tendon_cli.verbs.answer_record import CarriedRecord

SPRINGS = """\
name,spring.stiffness (kN/m),price (EUR),supplier
S3,3,40,B
S5,5,30,A
S8,8,21,C
"""
MOTORS = """\
name;spool.ratio;price (EUR);mass (g)
M12;0,6;120;410
M20;0,7;100;
"""
STUDY = """\
name = "parts"
[[table]]
name = "spring"
file = "springs.csv"
[[table]]
name = "motor"
file = "motors.csv"
[load]
mass = ["0 kg", "10 kg"]
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 5 }
"""
PRICES = {"S3": 40, "S5": 30, "S8": 21, "M12": 120, "M20": 100}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("parts")
    (folder / "springs.csv").write_text(SPRINGS)
    (folder / "motors.csv").write_text(MOTORS)
    (folder / "study.toml").write_text(STUDY)
    return folder


@pytest.fixture(scope="module")
def run(folder):
    return tendon.sweep(tendon.study(folder / "study.toml"), folder / "run")


@pytest.fixture(scope="module")
def answer(folder):
    goals = {"design.minimise": ["price", "max_tension"]}
    study = tendon.study(folder / "study.toml").vary(**goals)
    return tendon.design(study, folder / "answer")


@pytest.mark.parametrize("table", ["designs", "states"])
def test_prices_stand_in_every_table_and_are_summed(run, table):
    rows = getattr(run, table)
    assert list(rows.spring_price) == [PRICES[name] for name in rows.spring]
    assert list(rows.price) == [
        2 * PRICES[spring] + PRICES[motor]
        for spring, motor in zip(rows.spring, rows.motor, strict=True)
    ]
    assert set(rows.spring_supplier) == {"A", "B", "C"}
    assert rows.attrs["units"]["price"] == "EUR"


def test_what_is_not_known_of_a_part_is_not_known_of_the_sum(run):
    rows = run.designs
    has_mass = rows.motor == "M12"
    assert list(rows.motor_mass[has_mass].unique()) == [410.0]
    assert rows.mass[~has_mass].isna().all()


def test_a_dataset_has_them_along_their_own_axes(run):
    pytest.importorskip("xarray")
    dataset = run.to_xarray()
    assert dataset["price"].dims == ("spring", "motor")
    assert dataset["spring_price"].dims == ("spring",)
    assert dataset["price"].attrs["units"] == "EUR"
    assert float(dataset["price"].sel(spring="S5", motor="M12")) == 180.0


@pytest.mark.parametrize(
    ("where", "left"),
    [
        ("price < 161 EUR", {"S5 M20", "S8 M20"}),
        ("price < 161", {"S5 M20", "S8 M20"}),
        ("spring_supplier = B", {"S3 M12", "S3 M20"}),
        ("motor_mass = 410 g", {"S3 M12", "S5 M12", "S8 M12"}),
    ],
)
def test_filters_take_them(folder, run, where, left):
    rows, _ = rows_in(folder / "run", "designs", [where]).head(100)
    frame = rows.to_pandas()
    assert set(frame.spring.astype(str) + " " + frame.motor.astype(str)) == left


def test_a_front_over_price_and_tension_is_the_one_of_all_choices(answer):
    choices = answer.choices
    good = choices[choices.feasible & (choices.tolerance_length >= 2e-3)]  # as they can be set
    front = {
        row.Index
        for row in good.itertuples()
        if not any(
            (other.price <= row.price and other.max_tension <= row.max_tension)
            and (other.price < row.price or other.max_tension < row.max_tension)
            for other in good.itertuples()
        )
    }
    found = {(row["spring"], row["motor"]) for row in answer.front}
    assert found == {(good.spring[row], good.motor[row]) for row in front}
    assert len(front) > 1


def test_the_answer_names_parts_and_their_price(answer):
    best = answer.best
    words = " ".join(answer.short.split())
    spring = f"Spring {best['spring']} ({best['spring_supplier']}, {best['spring_price']:.0f} EUR)"
    assert words.startswith(f"{spring} with motor {best['motor']} (")
    assert ": set " in words
    assert f"price {best['price']:.0f} EUR" in words


def test_a_carried_number_is_named_unless_its_unit_is_a_price():
    rows = {"name": ["A"], "spool.ratio": [0.6], "width (mm)": [13], "price (EUR)": [7]}
    short = tendon.design({"table": [{"name": "suit", "rows": rows}]}).short
    told = " ".join(short.split()).partition(")")[0]
    assert told.removeprefix("Suit A (").split(", ") == ["width 13 mm", "7 EUR"]


def test_a_budget_among_the_limits_is_refused_with_the_filter_that_works():
    rows = {"name": ["soft", "firm"], "spring.stiffness": [3e3, 5e3], "price": ["90 EUR", "95 EUR"]}
    springs = {"name": "spring", "rows": rows}
    with pytest.raises(StudyError) as refusal:
        tendon.study({"table": [springs], "limits": {"price": "150 EUR"}})
    name, value = re.search(r'--where "(\w+) < ([^"]+)"', str(refusal.value)).groups()
    assert (name, value) == ("price", "150 EUR")


def test_a_fix_names_the_nearest_row_of_the_catalogue(folder):
    rows = {"name": ["M1", "M2"], "spool.ratio": [0.95, 1.0]}
    study = {"table": [{"name": "motor", "rows": rows}], "load": {"mass": ["0 kg", "10 kg"]}}
    failed = tendon.design({**study, "design": {"advice": False}})  # no such spring can be wound
    assert failed.feasible == 0
    fix = next(fix for fix in failed.fixes if fix["parameter"] == "spool.ratio")
    assert fix["nearest"] == {"table": "motor", "name": "M1", "value": 0.95}
    assert "nearest in the catalogue: motor M1" in " ".join(failed.short.split())


# --- Writing out, reading back --------------------------------------------------------------------


@pytest.mark.parametrize("table", ["spring", "motor"])
def test_an_exported_table_is_the_table(folder, table):
    study = tendon.study(folder / "study.toml")
    file = folder / f"{table}-again.csv"
    export(rows_in(folder / "study.toml", table), file, overwrite=True)
    text = STUDY.replace(f"{table}s.csv", file.name)
    (folder / "again.toml").write_text(text)
    assert tendon.study(folder / "again.toml").hash == study.hash


def test_the_rows_of_a_run_can_be_written_too(folder, run):
    rows, count = rows_in(folder / "run", "spring").head(10)
    assert count == 3
    assert rows["spring.stiffness"].to_pylist() == [3000.0, 5000.0, 8000.0]


def test_a_data_frame_is_a_table(folder):
    frame = pd.read_csv(folder / "springs.csv")
    study = tendon.study(folder / "study.toml")
    of_frame = tendon.study({"table": [{"name": "spring", "rows": frame}]})
    of_index = tendon.study({"table": [{"name": "spring", "rows": frame.set_index("name")}]})
    expected = study.row_tables[0]
    for table in (of_frame.row_tables[0], of_index.row_tables[0]):
        assert table.names == expected.names
        for key, values in expected.numbers.items():
            assert np.array_equal(table.numbers[key], values)
        assert [column.name for column in table.carried] == ["price", "supplier"]


def test_an_empty_cell_of_a_frame_leaves_the_value_of_the_study():
    frame = pd.DataFrame({"name": ["A", "B"], "spring.stiffness": [4000.0, np.nan]})
    rows = tendon.sweep({"table": [{"name": "part", "rows": frame}]}).designs
    assert list(rows.spring_stiffness) == [4000.0, 3000.0]


def test_the_record_reads_back_as_the_same_study(folder, run):
    again = tendon.open(folder / "run").study
    assert again.hash == run.study.hash
    assert [column.name for column in again.row_tables[1].carried] == ["price", "mass"]
    assert json.loads((folder / "run" / "run.json").read_text())["axes"] == list(again.axes)


@pytest.mark.parametrize(
    ("tables", "row", "words"),
    [
        (["spring", "motor"], {"price": 141.0}, "price 141 EUR in all"),
        (["spring"], {"price": 141.0}, ""),
        (["spring", "motor"], {"price": None}, ""),
    ],
    ids=["two parts", "one part", "a price that is not known"],
)
def test_a_sum_is_said_of_several_parts_whose_numbers_are_known(tables, row, words):
    price = CarriedRecord(name="price", unit="EUR", tables=tables)
    question = SimpleNamespace(carried={"price": price})
    assert sums_words(question, row) == words
