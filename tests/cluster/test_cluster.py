"""A sweep on a cluster gives what a local one gives, and ends as cleanly."""

import signal
import threading
import time
from pathlib import Path

import pytest

from .conftest import PARTS, wait_for

pytest.importorskip("distributed", reason="distributed is not installed")

SWEEP = ("sweep", "study.toml", "--no-figures", "--out", "run")


def leftovers(folder):
    return [str(path) for path in Path(folder).rglob(".*") if path.name != ".lock"]


def recorded(folder="run"):
    """Parts that stand in the journal of an unfinished run."""
    return len((Path(folder) / "journal.jsonl").read_bytes().splitlines()) - 1


@pytest.mark.parametrize("jobs", [(), ("--jobs", "1")], ids=["default", "one in flight"])
def test_the_bytes_are_those_of_a_local_run(tendon, local, cluster, hashes_in, jobs):
    before = set(threading.enumerate())
    ran = tendon(*SWEEP, "--json", "--scheduler", cluster.address, *jobs)
    assert (ran.exit, ran.err) == (0, ""), ran.out
    idle = (
        "TCP-Executor",
        "Dask-Offload",
    )  # threads of the library's pools, which end with the process
    after = [thread.name for thread in set(threading.enumerate()) - before]
    assert [name for name in after if not name.startswith(idle)] == []
    assert hashes_in(Path("run")) == local.hashes
    assert len(local.hashes) == 2 * PARTS
    differ = {"seconds", "checksum", "warnings", "figures"}  # the last two are the command's
    assert {key: ran.json[key] for key in local.record.keys() - differ} == {
        key: local.record[key] for key in local.record.keys() - differ
    }
    assert leftovers("run") == []
    assert not Path("run/journal.jsonl").exists()


def test_a_study_with_files_has_the_same_bytes_though_workers_do_not_see_them(
    tendon, study, cluster, new_sweep, hashes_in
):
    text = '[sheath]\nfriction_from = "fit.toml"\npath = "route.csv"\n[[cases]]\nname = "a"\n[[cases]]\nname = "b"\n'
    text += 'tendon = { flexor = { length = "1.7 m" } }\n' + study.read_text("utf-8").replace(
        "[tendon]", "[tendon]\n"
    )
    for folder in (study.parent, study.parent / "here"):
        folder.mkdir(exist_ok=True)
        (folder / "fit.toml").write_text(
            "[friction]\ncoefficient = 0.0813\nstandard_error = 0.002\n", "utf-8"
        )
        (folder / "route.csv").write_text(
            "x,y,z\n0,0,0\n0.1,0,0\n0.1,0.1,0\n0.1,0.1,0.1\n", "utf-8"
        )
    study.write_text(text, encoding="utf-8")
    local = new_sweep(text, study.parent / "here")
    assert set(local.record["sources"]) == {"sheath.path", "sheath.friction_from"}
    ran = tendon(*SWEEP, "--scheduler", cluster.address)
    assert ran.exit == 0
    assert [line.split()[1] for line in ran.err.splitlines()] == [
        str(tenth) for tenth in range(10, 101, 10)
    ]
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
    assert (again.exit, "up to date" in again.out) == (0, True)
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
    for words in (
        "part 3 (designs 9 to 11",
        "tendon.pretension=105",
        "FloatingPointError: something odd",
        "on worker",
    ):
        assert words in ran.json["error"]["message"]
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
    assert leftovers("run") == []


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
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
    assert err.splitlines()[-1] == "  hint: --resume goes on where it stopped"
    done = recorded()
    assert done < PARTS
    time.sleep(0.6)  # a part that went on would be finished by now
    assert leftovers("run") == []
    assert len(hashes_in(Path("run"))) == 2 * done
    cluster.set()
    ran = tendon(*SWEEP, "--resume", "--json", "--scheduler", cluster.address)
    assert (ran.exit, ran.json["resumed_parts"]) == (0, done)
    assert hashes_in(Path("run")) == local.hashes
