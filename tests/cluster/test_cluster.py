"""A sweep on a cluster gives what a local one gives, and ends as cleanly."""

import signal
import threading
import time
from pathlib import Path

import pytest

from tests.sampled import quick_and_torture

from .conftest import PARTS, STUDY, SWEEP, leftovers, recorded, wait_for

pytest.importorskip("distributed", reason="distributed is not installed")

# Threads of the library's pools, which end with the process.
IDLE = ("TCP-Executor", "Dask-Offload")

FIT = "[friction]\ncoefficient = 0.0813\nstandard_error = 0.002\n"
ROUTE = "x,y,z\n0,0,0\n0.1,0,0\n0.1,0.1,0\n0.1,0.1,0.1\n"
WITH_FILES = f"""
[sheath]
friction_from = "fit.toml"
path = "route.csv"
[[cases]]
name = "a"
[[cases]]
name = "b"
tendon = {{ flexor = {{ length = "1.7 m" }} }}
{STUDY}
"""


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")], ids=["default", "one in flight"])
def test_the_bytes_are_those_of_a_local_run(tendon, local, cluster, hashes_in, jobs):
    before = set(threading.enumerate())
    ran = tendon(*SWEEP, "--json", "--scheduler", cluster.address, *jobs)
    assert (ran.exit, ran.err) == (0, ""), ran.out
    started = [thread.name for thread in set(threading.enumerate()) - before]
    assert [name for name in started if not name.startswith(IDLE)] == []
    assert hashes_in(Path("run")) == local.hashes
    assert len(local.hashes) == 2 * PARTS
    record = ran.json
    differ = {"seconds", "checksum", "warnings", "figures"}  # the last two are the command's
    for key in local.record.keys() - differ:
        assert record[key] == local.record[key]
    assert leftovers() == []
    assert Path("run/.lock").read_text("utf-8") == ""


def test_a_study_with_files_has_the_same_bytes_though_workers_do_not_see_them(
    tendon, study, cluster, new_sweep, hashes_in
):
    study.write_text(WITH_FILES, encoding="utf-8")
    here = study.parent / "here"
    here.mkdir()
    for folder in (study.parent, here):
        (folder / "fit.toml").write_text(FIT, "utf-8")
        (folder / "route.csv").write_text(ROUTE, "utf-8")
    local = new_sweep(WITH_FILES, here)
    assert set(local.record["sources"]) == {"sheath.path", "sheath.friction_from"}
    ran = tendon(*SWEEP, "--scheduler", cluster.address)
    assert ran.exit == 0
    progress = [int(line.split()[1]) for line in ran.err.splitlines()]
    assert progress == list(range(10, 101, 10))
    assert hashes_in(Path("run")) == local.hashes


def test_a_local_run_is_finished_and_repaired_on_the_cluster(
    tendon, study, cluster, local, hashes_in, monkeypatch
):
    from tendon_cli.engine.task import PartMaker

    make = PartMaker.make

    def fails(self, index, working=None):
        if index >= 5:
            raise FloatingPointError
        return make(self, index, working)

    with monkeypatch.context() as patch:
        patch.setattr(PartMaker, "make", fails)
        assert tendon(*SWEEP).exit == 6
    ran = tendon(*SWEEP, "--resume", "--json", "--scheduler", cluster.address)
    assert (ran.exit, ran.json["resumed_parts"]) == (0, 5)
    assert hashes_in(Path("run")) == local.hashes
    again = tendon(*SWEEP, "--scheduler", cluster.address)
    assert again.exit == 0
    assert "up to date" in again.out
    Path("run/states.parquet/part-00003.parquet").write_bytes(b"nothing")
    Path("run/designs.parquet/part-00007.parquet").unlink()
    ran = tendon(*SWEEP, "--resume", "--json", "--scheduler", cluster.address)
    assert (ran.exit, len(ran.json["repaired"])) == (0, 2)
    assert hashes_in(Path("run")) == local.hashes


def test_a_part_that_fails_is_named_with_its_worker_and_the_others_are_kept(
    tendon, study, cluster, local, hashes_in
):
    cluster.set(fail=9)
    ran = tendon(*SWEEP, "--json", "--scheduler", cluster.address)
    assert (ran.exit, ran.json["error"]["kind"]) == (6, "workers")
    message = ran.json["error"]["message"]
    assert "part 3 (designs 9 to 11" in message
    assert "tendon.pretension=105" in message
    assert "FloatingPointError: something odd" in message
    assert "on worker" in message
    assert recorded() == PARTS - 1
    cluster.set()
    assert tendon(*SWEEP, "--resume", "--scheduler", cluster.address).exit == 0
    assert hashes_in(Path("run")) == local.hashes


def test_a_full_disk_on_a_worker_is_exit_5_and_ends_the_run(tendon, study, cluster):
    cluster.set(full=0, slow=0.1)
    ran = tendon(*SWEEP, "--json", "--jobs", "2", "--scheduler", cluster.address)
    assert (ran.exit, ran.json["error"]["kind"]) == (5, "output")
    assert "No space left on device, on worker" in ran.json["error"]["message"]
    assert recorded() < PARTS - 1
    assert leftovers() == []


@pytest.mark.parametrize(
    ("number", "code"),
    quick_and_torture([(signal.SIGINT, 130)], [(signal.SIGTERM, 143)]),
)
def test_a_signal_ends_the_run_soon_and_cleanly(
    tendon, outside_sweep, cluster, local, hashes_in, number, code
):
    cluster.set(slow=0.5)
    running = outside_sweep("--out", "run", "--scheduler", cluster.address)
    wait_for(lambda: recorded() >= 2, OSError)
    running.send_signal(number)
    sent = time.monotonic()
    out, err = running.communicate(timeout=20)
    assert (running.returncode, out) == (code, "")
    assert time.monotonic() - sent < 30  # only what hangs needs it
    assert "Traceback" not in err
    assert err.splitlines()[-1].endswith("--out run --resume` continues where it stopped")
    done = recorded()
    assert done < PARTS
    time.sleep(0.6)  # a part that went on would be finished by now
    assert leftovers() == []
    assert len(hashes_in(Path("run"))) == 2 * done
    cluster.set()
    ran = tendon(*SWEEP, "--resume", "--json", "--scheduler", cluster.address)
    assert (ran.exit, ran.json["resumed_parts"]) == (0, done)
    assert hashes_in(Path("run")) == local.hashes
