"""A disk that is full, or fails: exit 5, nothing that looks finished, and the run goes on where there is room again."""

import errno
import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from .tools import STATES, SWEEP, command, launched, some, temporary_files

SMALL_DISK = Path(__file__).with_name("small_disk.py")


def own_mounts():
    """How to start a process that may mount for itself alone, where the system lets us."""
    words = ["unshare", "--mount"] if os.geteuid() == 0 else ["unshare", "--mount", "--map-root-user"]
    if shutil.which("unshare") is None:
        return None
    probe = subprocess.run([*words, "mount", "-t", "tmpfs", "tmpfs", "/mnt"], check=False, capture_output=True)
    return None if probe.returncode else words


@pytest.fixture(scope="session")
def namespace():
    words = own_mounts()
    if words is None:
        pytest.skip("no file system can be mounted here")
    return words


# A whole run takes about 1.1 MB; the least that is asked for beforehand is under 40 kB.
SIZES = some([300], [60, 80, 120, 200, 400, 600, 800, 1000])


@pytest.mark.parametrize("figures", [False, pytest.param(True, marks=pytest.mark.torture)], ids=["tables", "figures"])
@pytest.mark.parametrize("kilobytes", SIZES)
def test_a_full_disk_is_exit_5_and_the_run_goes_on_with_more_room(
    namespace, place, uninterrupted, tmp_path, kilobytes, figures
):
    point = tmp_path / "disk"
    point.mkdir()
    words = command({"states": STATES}, "sweep", place / "study.toml", "--jobs", "2")
    words += [] if figures else ["--no-figures"]
    ran = subprocess.run(
        [*namespace, sys.executable, SMALL_DISK, point, str(kilobytes), *words],
        check=True, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    found = json.loads(ran.stdout)
    for name in ("first", "again"):
        failed = found[name]
        error = json.loads(failed["out"])["error"]
        assert (failed["exit"], error["exit"], error["kind"]) == (5, 5, "output"), failed
        assert "space" in error["message"]
        assert "Traceback" not in failed["err"]
        assert "run.json" not in failed["files"]
        assert not [file for file in failed["files"] if file.endswith(".tmp")]
        assert failed["hashes"].items() <= uninterrupted.items()
    assert found["first"]["hashes"].items() <= found["again"]["hashes"].items()
    assert found["second"]["exit"] == 0, found["second"]
    assert found["second"]["hashes"] == uninterrupted
    assert json.loads(found["second"]["out"])["resumed_parts"] >= len(found["first"]["hashes"]) // 2 - 4


def test_a_disk_that_cannot_hold_the_run_is_told_beforehand(namespace, place, tmp_path):
    point = tmp_path / "disk"
    point.mkdir()
    words = command({"states": STATES}, "sweep", place / "study.toml", "--no-figures")
    ran = subprocess.run(
        [*namespace, sys.executable, SMALL_DISK, point, "16", *words],
        check=True, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    first = json.loads(ran.stdout)["first"]
    assert (first["exit"], first["files"]) == (2, [])
    assert json.loads(first["out"])["error"]["kind"] == "size"


INIT = """
mount -t tmpfs -o size=64k tmpfs "$0" && cd "$0" || exit 99
cat /dev/zero 2>/dev/null > filler
"$@"; echo "exit $?"; ls -A
rm filler
"$@"; echo "exit $?"; ls -A
"""


def test_a_starter_that_does_not_fit_leaves_nothing_and_fits_when_there_is_room(namespace, tmp_path):
    point = tmp_path / "disk"
    point.mkdir()
    words = [*namespace, "sh", "-c", INIT, point, *command({}, "init", "mine.toml")]
    ran = subprocess.run(words, check=True, capture_output=True, text=True, timeout=60)
    said = "mine.toml written; next: tendon sweep mine.toml"
    assert ran.stdout.splitlines() == ["exit 5", "filler", said, "exit 0", "mine.toml"]
    first, *hint = ran.stderr.splitlines()
    assert first == f"tendon: error: mine.toml: cannot be written: {os.strerror(errno.ENOSPC)}"
    assert len(hint) == 1


@pytest.mark.parametrize("kilobytes", some([4], [1, 2, 8, 16]))
def test_files_that_may_not_grow_are_exit_5(place, uninterrupted, hashes_in, kilobytes):
    """A limit on the length of each file, as quotas set."""

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (kilobytes * 1024, kilobytes * 1024))

    code, out, said = launched(place, {"states": STATES}, *SWEEP, "--json", preexec_fn=limit)
    assert (code, json.loads(out)["error"]["kind"], said) == (5, "output", "")
    assert not (place / "run/run.json").exists()
    assert not temporary_files(place / "run")
    assert hashes_in(place / "run").items() <= uninterrupted.items()
    assert launched(place, {"states": STATES}, *SWEEP, "--resume")[0] == 0
    assert hashes_in(place / "run") == uninterrupted
