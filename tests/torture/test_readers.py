"""Every reader of tables, not `plot` alone, names the table that was harmed and takes nothing from it."""

import re
from pathlib import Path

import pytest

import tendon_cli
from tendon_cli.engine import run as verb
from tendon_cli.engine.run import worked_out

from .test_damage import flip, parts_of, truncate
from .tools import STATES, some, study_in

PACKAGE = Path(tendon_cli.__file__).parent
OPENS = re.compile(r"pq\.|read_parquet|ParquetFile|parquet\.read|pyarrow\.dataset|memory_map")
FIGURE = """
[[figure]]
name = "curves"
quantity = "motor_torque"
"""


def test_tables_are_opened_in_few_places_only():
    """Whoever opens one elsewhere goes round what verifies it: the reader, its counts, the writer's check, memory."""
    found = {
        str(file.relative_to(PACKAGE))
        for file in PACKAGE.rglob("*.py")
        if OPENS.search(re.sub(r"import .*", "", file.read_text(encoding="utf-8")))
    }
    assert found == {"tables/read.py", "tables/write.py", "face/pictures.py"}


class Chance:
    """Always the same byte, somewhere in the pages."""

    def randrange(self, stop):
        return min(stop - 1, 100)


def harmed_run(harm, table, monkeypatch):
    """Let a table be harmed right after it was written, before anybody reads it back."""

    def then_harmed(folder, *arguments, **options):
        outcome = worked_out(folder, *arguments, **options)
        parts = [file for file in parts_of(folder.path) if file.parent.name == f"{table}.parquet"]
        harm(parts[1] if parts else folder.path / f"{table}.parquet", Chance())
        return outcome

    monkeypatch.setattr(verb, "worked_out", then_harmed)


@pytest.mark.parametrize("harm", some([flip], [truncate]), ids=lambda harm: harm.__name__)
@pytest.mark.parametrize("table", some(["designs"], ["states"]))
def test_paper_refuses_a_harmed_table_by_name(tendon, workplace, monkeypatch, harm, table):
    harmed_run(harm, table, monkeypatch)
    ran = tendon("paper", "--out", "paper", "--json")
    assert (ran.exit, ran.json["error"]["kind"]) == (3, "input")
    assert f"{table}.parquet" in ran.json["error"]["where"]
    assert not list(workplace.glob("paper/*"))


@pytest.mark.parametrize("harm", some([flip], [truncate]), ids=lambda harm: harm.__name__)
@pytest.mark.parametrize("table", some(["designs"], ["states"]))
def test_the_figures_of_a_sweep_are_not_drawn_from_a_harmed_table(
    tendon, tmp_path, monkeypatch, small_parts, harm, table
):
    small_parts(STATES)
    place = study_in(tmp_path / "place")
    words = ("sweep", place / "study.toml", "--out", place / "run", "--json")
    if table == "states":
        with (place / "study.toml").open("a", encoding="utf-8") as end:
            end.write(FIGURE)
    with monkeypatch.context() as patch:
        harmed_run(harm, table, patch)
        ran = tendon(*words)
    assert (ran.exit, ran.json["error"]["kind"]) == (3, "input")
    assert f"{table}.parquet/part-00001.parquet" in ran.json["error"]["where"]
    assert not (place / "run/run.json").exists()
    assert not (place / "run/curves.png").exists()
    assert tendon(*words, "--resume").exit == 0


@pytest.mark.parametrize("words", some([()], [("--quantity", "motor_torque"), ("--format", "svg")]), ids=" ".join)
def test_plot_of_a_run_whose_tables_are_both_harmed_draws_nothing(tendon, workplace, new_sweep, words):
    folder = new_sweep("[load]\nmass = [0.0, 3.0]\n", workplace).folder
    for table in ("designs", "states"):
        flip(folder / f"{table}.parquet", Chance())
    before = sorted(workplace.rglob("*"))
    ran = tendon("plot", folder, *words, "--json")
    assert (ran.exit, ran.json["error"]["kind"]) == (3, "input")
    assert ".parquet" in ran.json["error"]["where"]
    assert sorted(workplace.rglob("*")) == before
