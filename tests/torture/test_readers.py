"""The readers of tables name the one that was harmed, and take nothing from it."""

import random
import re
from pathlib import Path

import pytest

import tendon_cli
from tendon_cli.engine import run as run_module
from tendon_cli.engine.run import compute_parts
from tests.sampled import quick_and_torture
from tools.torture.folders import flip, truncate
from tools.torture.runs import STATES, study_in

PACKAGE = Path(tendon_cli.__file__).parent
OPENS = re.compile(r"pq\.|read_parquet|ParquetFile|parquet\.read|pyarrow\.dataset|memory_map")
FIGURE = '\n[[figure]]\nname = "curves"\nquantity = "motor_torque"\n'


def test_tables_are_opened_in_few_places_only():
    """A table opened elsewhere would bypass the verification by the reader and the writer."""
    openers = set()
    for file in PACKAGE.rglob("*.py"):
        source = re.sub(r"import .*", "", file.read_text(encoding="utf-8"))
        if OPENS.search(source):
            openers.add(str(file.relative_to(PACKAGE)))
    assert openers == {"tables/footer.py", "tables/read.py", "tables/write.py"}


def harm_after_writing(harm, table, patch):
    """Let a table be harmed right after it was written, before anybody reads it back."""

    def compute_and_harm(folder, *how):
        worked = compute_parts(folder, *how)
        files = sorted(folder.path.glob(f"{table}.parquet/part-*.parquet"))
        file = files[min(1, len(files) - 1)] if files else folder.path / f"{table}.parquet"
        harm(file, random.Random(5))  # noqa: S311 - a repeatable sample
        return worked

    patch.setattr(run_module, "compute_parts", compute_and_harm)


CASES = [(flip, "designs"), (flip, "states"), (truncate, "designs"), (truncate, "states")]


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize(("harm", "table"), quick_and_torture(CASES[:1], CASES[1:]))
def test_figures_are_not_drawn_from_a_harmed_table(
    tendon, place, monkeypatch, small_parts, harm, table
):
    run = place / "run"
    words = ["sweep", "--out", run, "--json", place / "study.toml"]
    small_parts(STATES)
    study_in(place, (place / "study.toml").read_text("utf-8") + FIGURE)
    with monkeypatch.context() as patch:
        harm_after_writing(harm, table, patch)
        ran = tendon(*words)
    assert (ran.exit, ran.json["error"]["kind"]) == (3, "input")
    assert f"{table}.parquet" in ran.json["error"]["where"]
    assert not [file for name in ("*.png", "run.json") for file in run.glob(name)]
    ran = tendon(*words, "--resume")
    if ran.exit == 7:  # a part that no longer says what it is is left alone
        named = ran.json["error"]["message"].split()[1].rstrip(",")
        (run / named).unlink()
        ran = tendon(*words, "--resume")
    assert ran.exit == 0
