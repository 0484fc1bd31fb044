"""Every reader of tables names the one that was harmed, and takes nothing from it."""

import random
import re
from pathlib import Path

import pytest

import tendon_cli
from tendon_cli.engine import run as verb
from tendon_cli.engine.run import compute_parts
from tendon_cli.errors import InputError
from tendon_cli.tables.read import open_table

from .folders import HARMS, STUDY, delete, flip, truncate
from .tools import STATES, some, study_in

PACKAGE = Path(tendon_cli.__file__).parent
OPENS = re.compile(r"pq\.|read_parquet|ParquetFile|parquet\.read|pyarrow\.dataset|memory_map")
FIGURE = '\n[[figure]]\nname = "curves"\nquantity = "motor_torque"\n'


def test_tables_are_opened_in_few_places_only():
    """Whoever opens one elsewhere goes round what verifies it: the reader and the writer's check."""
    sources = {
        file: re.sub(r"import .*", "", file.read_text(encoding="utf-8"))
        for file in PACKAGE.rglob("*.py")
    }
    openers = {
        str(file.relative_to(PACKAGE)) for file, source in sources.items() if OPENS.search(source)
    }
    assert openers == {"tables/read.py", "tables/write.py"}


def fold(file, _chance):
    """A folder where the file was."""
    delete(file, None)
    file.mkdir()


@pytest.mark.parametrize("harm", [*HARMS, fold], ids=lambda harm: harm.__name__)
@pytest.mark.parametrize("table", some(["states"], ["designs"]))
def test_a_harmed_part_is_refused_by_name(tendon, workplace, new_sweep, small_parts, harm, table):
    small_parts(1)
    run = new_sweep(STUDY, workplace).folder
    file = run / f"{table}.parquet/part-00002.parquet"
    harm(file, random.Random(5))  # noqa: S311 - a repeatable sample
    for source, words in ((run, ("--table", table)), (file.parent, ())):
        ran = tendon("plot", source, *words, "--out", "figure.png", "--json")
        assert (ran.exit, ran.json["error"]["kind"]) == (3, "input")
        assert f"{table}.parquet" in ran.json["error"]["where"]
        assert (
            "part-00002" in ran.json["error"]["where"] + ran.json["error"]["message"]
            or "part 2" in ran.out
        )
        assert not Path("figure.png").exists()
    with pytest.raises(InputError):
        open_table(file.parent)
    ran = tendon("sweep", "study.toml", "--out", "run", "--resume", "--no-figures", "--json")
    assert (ran.exit in (5, 7) and "part-00002" in ran.out) if harm is fold else ran.exit == 0


def harmed_run(harm, table, patch):
    """Let a table be harmed right after it was written, before anybody reads it back."""

    def then_harmed(folder, *how):
        worked = compute_parts(folder, *how)
        files = sorted(folder.path.glob(f"{table}.parquet/part-*.parquet")) or [
            folder.path / f"{table}.parquet"
        ]
        harm(files[min(1, len(files) - 1)], random.Random(5))  # noqa: S311 - a repeatable sample
        return worked

    patch.setattr(verb, "compute_parts", then_harmed)


CASES = [(flip, "designs"), (flip, "states"), (truncate, "designs"), (truncate, "states")]


@pytest.mark.parametrize(("harm", "table"), some(CASES[:1], CASES[1:]))
@pytest.mark.parametrize("verb", ["sweep", "paper"])
def test_figures_are_not_drawn_from_a_harmed_table(
    tendon, place, monkeypatch, small_parts, verb, harm, table
):
    run, words = place / "run", (verb, "--out", place / "run", "--json")
    if verb == "sweep":
        small_parts(STATES)
        study_in(place, (place / "study.toml").read_text("utf-8") + FIGURE)
        words = (*words, place / "study.toml")
    with monkeypatch.context() as patch:
        harmed_run(harm, table, patch)
        ran = tendon(*words)
    assert (ran.exit, ran.json["error"]["kind"]) == (3, "input")
    assert f"{table}.parquet" in ran.json["error"]["where"]
    assert not [file for name in ("*.png", "run.json", "ledger.*") for file in run.glob(name)]
    assert verb == "paper" or tendon(*words, "--resume").exit == 0
