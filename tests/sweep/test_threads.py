"""Parts in threads are computed ahead of the disk, but not far, and stop if nobody listens."""

import threading
import time
from pathlib import Path

import pytest

from tendon_cli.engine import sweep as sweep_module
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.sweep import Sweep
from tendon_cli.engine.task import PartFailure, PartMaker
from tendon_cli.engine.threads import in_threads
from tendon_cli.errors import OutputError, Stopped
from tendon_cli.studies.load import study_from
from tendon_cli.tables.footer import read_whole
from tendon_cli.tables.write import TableFile
from tests.si import with_units

PARTS = 12
STUDY = {
    "name": "threads",
    "tendon": {"pretension": [float(force) for force in range(10, 10 + PARTS)]},
    "motion": {"elbow_angle": [0.1, 0.5, 1.0]},
}


@pytest.fixture
def maker(small_parts, tmp_path):
    """Return a maker of twelve parts of one design each."""
    small_parts(6)
    plan = Plan(study_from(with_units(STUDY)))
    assert plan.parts == PARTS
    for table in ("states", "designs"):
        (tmp_path / f"{table}.parquet").mkdir()
    return PartMaker(Sweep(plan), tmp_path)


def files(maker):
    """Return the time of the last change of each file."""
    return {
        path.relative_to(maker.folder): path.stat().st_mtime_ns
        for path in maker.folder.rglob("*.*")
        if path.is_file()
    }


def settled(count, least):
    """Wait until a count is at least this and stays. Return it."""
    before = None
    now = count()
    while now != before or now < least:
        time.sleep(0.1)
        before = now
        now = count()
    return now


@pytest.mark.parametrize("jobs", [1, 2, 3])
def test_a_failure_is_a_result_like_others(maker, jobs, monkeypatch):
    rows = sweep_module.state_rows
    rename = Path.replace

    def fails(inputs, block, keys):
        if block.first_design == 3:
            raise FloatingPointError
        return rows(inputs, block, keys)

    def fails_to_finish(self, target):
        if target.stem == "part-00007":
            raise OSError("no space")
        return rename(self, target)

    monkeypatch.setattr(sweep_module, "state_rows", fails)
    monkeypatch.setattr(Path, "replace", fails_to_finish)
    results = list(in_threads(jobs)(maker, iter(range(PARTS))))
    assert sorted(result.index for result in results) == list(range(PARTS))
    failures = {}
    names = set()
    for result in results:
        if isinstance(result, PartFailure):
            failures[result.index] = type(result.error)
        else:
            names |= set(result.files)
    assert failures == {3: FloatingPointError, 7: OutputError}
    assert {name for name in map(str, files(maker)) if "00007" not in name} == names


def test_a_slow_disk_holds_up_the_computing(maker, monkeypatch):
    """Otherwise a run would pile up results in memory, and lose them all if it is killed."""
    flush = TableFile.flush
    fill = Sweep.fill
    computed = []
    gate = threading.Event()

    def waits(self):
        gate.wait()
        flush(self)

    def counted(self, tables, index):
        computed.append(index)
        return fill(self, tables, index)

    monkeypatch.setattr(TableFile, "flush", waits)
    monkeypatch.setattr(Sweep, "fill", counted)
    results = in_threads(2)(maker, iter(range(PARTS)))
    asking = threading.Thread(target=lambda: next(results))
    asking.start()
    assert settled(lambda: len(computed), 4) == 4
    gate.set()
    asking.join()
    assert len(list(results)) == PARTS - 1


@pytest.mark.parametrize("received", [1, 3])
def test_no_part_is_worked_on_when_nobody_listens_any_more(maker, received, monkeypatch):
    rows = sweep_module.state_rows

    def slow(inputs, block, keys):
        time.sleep(0.02)
        return rows(inputs, block, keys)

    monkeypatch.setattr(sweep_module, "state_rows", slow)
    results = in_threads(3)(maker, iter(range(PARTS)))
    for _ in range(received):
        next(results)
    results.close()
    at_close = files(maker)
    assert not [path for path in at_close if path.suffix == ".tmp"]
    assert all(read_whole(maker.folder / path) for path in at_close)
    assert received <= len(at_close) / 2 < PARTS
    time.sleep(0.2)
    assert files(maker) == at_close


def test_a_stop_ends_all_parts_that_are_not_written(maker):
    results = in_threads(2)(maker, iter(range(PARTS)))
    first = next(results)
    maker.task.stop.set()
    rest = list(results)
    assert len(rest) == PARTS - 1
    stopped = [result for result in rest if isinstance(result, PartFailure)]
    assert stopped
    assert all(isinstance(result.error, Stopped) for result in stopped)
    assert len(files(maker)) == 2 * (1 + len(rest) - len(stopped)), first
