"""Choices solved on a cluster give the answer that they give here, to the byte."""

from pathlib import Path

import pytest

from tendon_cli.answers import choices as choices_module

from .conftest import WINDOWS_PER_PART, in_background, leftovers, wait_for

pytest.importorskip("distributed", reason="distributed is not installed")

DRAWS_USUAL = True  # as workers do, whom no test patches

SUIT = """
name = "suit"
[spring]
stiffness = { from = "3 kN/m", to = "8 kN/m", num = 5 }
[spool]
ratio = { from = 0.5, to = 0.7, num = 4 }
[load]
mass = { from = "0 kg", to = "3 kg", num = 40 }
[motion]
elbow_angle = ["0 deg", "45 deg", "90 deg"]
[design]
maximise = ["tolerance"]
"""
"""20 choices of 40 conditions: four parts."""
STUDY = SUIT + "[uncertainty]\nusual = false\n"

FEWER_LOADS = SUIT.replace("num = 4 }", "num = 2 }").replace('"3 kg", num = 40', '"1 kg", num = 4')
PERSONS = FEWER_LOADS + "[people]\ncount = 20\n[uncertainty]\nusual = false\n"
UNCERTAIN = """
draws = 8
[sheath]
friction = { mean = 0.07, std = 0.005 }
[tendon]
length = { value = "2 m", tolerance = "5 %" }
"""
STUDIES = {
    "persons": PERSONS,
    "persons times draws": PERSONS.replace("count = 20", "count = 5") + UNCERTAIN,
    "draws": FEWER_LOADS + "verify = 100\n[uncertainty]\ndraws = 32\n",
}
"""10 choices of 80 to 160 conditions each, the last with usual deviations."""

DESIGN = ("design", "suit.toml", "--no-figures", "--json")


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch):
    """Make parts as small as the workers have them."""
    monkeypatch.setattr(choices_module, "WINDOWS_PER_PART", WINDOWS_PER_PART)


@pytest.fixture
def same(tendon, workplace, hashes_in):
    """Return a function that solves a study here and on a cluster and compares both to the byte."""

    def solve(text, cluster, *words):
        (workplace / "suit.toml").write_text(text, encoding="utf-8")
        here = tendon(*DESIGN, "--out", "here")
        there = tendon(*DESIGN, "--out", "there", "--scheduler", cluster.address, *words)
        assert (there.exit, there.err) == (here.exit, ""), there.out
        assert len(list(Path("there/choices.parquet").iterdir())) >= 3
        assert hashes_in(Path("there")) == hashes_in(Path("here"))
        record_here = here.json
        record_there = there.json
        for key in ("seconds", "checksum"):
            del record_here[key]
            del record_there[key]
        assert record_there == record_here
        return there

    return solve


def test_the_answer_is_that_of_this_machine_to_the_byte(same, cluster):
    assert same(STUDY, cluster).exit == 0


@pytest.mark.parametrize("name", STUDIES)
def test_so_it_is_with_people_and_draws(same, cluster, name):
    record = same(STUDIES[name], cluster).json
    assert record["population"]["kind"] == {"persons times draws": "pairs"}.get(name, name)
    assert record["population"]["count"] >= 20


def test_the_choices_of_a_worker_that_is_killed_are_solved_by_another(same, start_cluster):
    cluster = start_cluster(2, kill_choices_once=1)
    same(PERSONS, cluster, "--jobs", "2")
    assert sorted(worker.is_alive() for worker in cluster.workers) == [False, True]


def test_an_answer_that_loses_its_scheduler_is_finished_without(
    tendon, workplace, start_cluster, hashes_in
):
    # Slow parts, so that the scheduler is gone long before the last.
    cluster = start_cluster(1, slow=0.3)
    out = workplace / "out"
    (workplace / "suit.toml").write_text(STUDY, encoding="utf-8")

    def kill():
        wait_for(lambda: list(out.glob("unfinished.parquet/part-*.parquet")))
        cluster.scheduler.kill()

    killer = in_background(kill)
    ran = tendon(*DESIGN, "--out", "out", "--scheduler", cluster.address, "--jobs", "1")
    killer.join()
    assert (ran.exit, ran.json["error"]["kind"]) == (6, "workers")
    assert "--resume continues, with or without --scheduler" in ran.json["error"]["hint"]
    assert not (out / "design.json").exists()
    assert leftovers(out) == []
    assert tendon(*DESIGN, "--out", "whole").exit == 0
    assert tendon(*DESIGN, "--out", "out", "--resume").exit == 0
    assert hashes_in(out) == hashes_in(workplace / "whole")
