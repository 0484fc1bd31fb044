"""A worker, without a cluster around it."""

import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from tendon_cli.answers.choices import Choices
from tendon_cli.engine.cluster import worker
from tendon_cli.engine.cluster.worker import Assignment, Refusal, check_versions, halt, make_part
from tendon_cli.engine.folder import RunFolder, look
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.sweep import Sweep
from tendon_cli.engine.task import PartMaker, PartResult
from tendon_cli.files import locked, mark_lock
from tendon_cli.studies.load import load_study


@pytest.fixture
def maker(study):
    """Yield a run that has been begun in a locked folder, as the client sees it."""
    folder = RunFolder(Path("run"), Sweep(Plan(load_study(study))))
    with locked(folder.path):
        folder.prepare()
        yield PartMaker(folder.task, folder.path)


@pytest.fixture
def assignment(maker):
    """Return what a worker needs of a run that holds the lock."""
    assignment = Assignment.of(maker)
    mark_lock(maker.folder, assignment.run)
    return assignment


def names():
    """Return the names of the files in both tables."""
    return sorted(path.name for path in Path("run").glob("*.parquet/*"))


def test_every_shipped_study_is_the_same_when_a_worker_rebuilds_it(configs, tmp_path):
    for path in sorted(configs.rglob("*.toml")):
        for kind in (Sweep, Choices):
            ours = kind.of(load_study(path))
            theirs = Assignment.of(PartMaker(ours, tmp_path)).task()
            assert theirs.study.hash == ours.study.hash
            for table in ours.tables:
                schema = theirs.layout(table, 0).schema
                assert schema.equals(ours.layout(table, 0).schema, check_metadata=True)


@pytest.mark.parametrize("end", ["another run", "over", "gone"])
def test_a_worker_that_comes_too_late_changes_nothing(assignment, end, monkeypatch):
    """It was thought dead, and the run went on without it.

    Perhaps another run goes on in the folder by now.
    """
    fill = Sweep.fill

    def slowly(self, tables, index):
        totals = fill(self, tables, index)
        if end == "gone":
            Path("run/.lock").unlink()
        else:
            mark_lock(Path("run"), "another" if end == "another run" else "")
        return totals

    monkeypatch.setattr(Sweep, "fill", slowly)
    refusal = make_part(assignment, 1)
    assert isinstance(refusal, Refusal)
    assert refusal.kind == "unfit"
    assert names() == []


def test_two_workers_on_one_part_do_not_meet(assignment, monkeypatch, local):
    fill = Sweep.fill

    def meanwhile(self, tables, index):
        monkeypatch.setattr(Sweep, "fill", fill)
        monkeypatch.setattr(worker, "_MAKERS", {})  # as in another process
        assert isinstance(make_part(assignment, 1), PartResult)
        return fill(self, tables, index)

    monkeypatch.setattr(Sweep, "fill", meanwhile)
    result = make_part(pickle.loads(pickle.dumps(assignment)), 1)  # noqa: S301 - our own
    assert isinstance(result, PartResult)
    for name, file in result.files.items():
        assert file.sha256 == local.hashes[name]
    assert names() == ["part-00001.parquet"] * 2
    assert RunFolder(Path("run"), Sweep(local.plan)).standing(look(Path("run"))) == {1: result}


def test_a_part_that_is_halted_leaves_nothing(assignment):
    assert worker.prepare_worker(assignment) is None
    halt(assignment.run)
    refusal = make_part(assignment, 1)
    assert isinstance(refusal, Refusal)
    assert refusal.kind == "stopped"
    assert names() == []


def test_another_plan_is_refused(assignment):
    """Workers of a cluster also refuse other versions and a folder that they do not see."""
    assert check_versions(assignment.versions) is None
    refusal = make_part(replace(assignment, parts=5), 0)
    assert isinstance(refusal, Refusal)
    assert refusal.kind == "unfit"
    assert "reads the study differently" in refusal.reason
    assert names() == []


def test_what_dead_workers_left_is_removed_and_nothing_else(maker):
    states = Path("run/states.parquet")
    expected = [
        states / "part-00000.parquet",
        states / ".part-00001.parquet.tmp",
        states / ".tendon-0123456789ab.tmp",
    ]
    of_dead_workers = [
        states / ".tendon-run-0123456789ab.tmp",
        Path("run/.tendon-run-ba9876543210.tmp"),
    ]
    for file in expected + of_dead_workers:
        file.touch()
    maker.tidy()
    assert set(states.iterdir()) == set(expected)
    assert not list(Path("run").glob(".tendon*"))
