"""Runs that are killed, stopped, raced, or out of room leave only what resumes to the same bytes.

Every run is a process of its own.
"""

import json
import os
import random
import resource
import shutil
import signal
import subprocess
import time
from types import SimpleNamespace

import pytest

from tests.sampled import quick_and_torture
from tools.torture.runs import (
    PARTS,
    QUIET,
    SMALL,
    STUDIES,
    SWEEP,
    command,
    launched,
    left_of,
    running,
    study_in,
    temporary_files,
    wait_for,
    wait_for_end,
)

RECORDS = {"sweep": "run.json", "design": "design.json"}
KILL = signal.SIGKILL
TERM = signal.SIGTERM
INTERRUPT = signal.SIGINT
HANG_UP = signal.SIGHUP


def assert_resumes(verb, place, expected, hashes_in, words=QUIET):
    """Resume a run to the expected hashes; return its record."""
    run = place / "run"
    code, out, err = launched(place, SMALL, verb, "study.toml", *words, "--resume", "--json")
    assert code == 0, out + err
    assert hashes_in(run) == expected
    assert (run / RECORDS[verb]).exists()
    assert not temporary_files(run)
    return json.loads(out)


# --- Signals --------------------------------------------------------------------------------------


def held_at(point, rng):
    """Return settings that hold a run at a point, so that a signal meets it there."""
    if point == "any":
        return SMALL
    skip = rng.randrange(5) if point == "part" else 0
    return SMALL | {"hold": point, "skip": skip, "seconds": 1.0}


def signalled(place, settings, words, numbers, rng, **options):
    """Run a command that gets signals, and return its exit code."""
    held = place / "held"
    lock = place / "run/.lock"
    held.unlink(missing_ok=True)
    is_one_kill = numbers == [KILL]
    with running(place, settings, *words, **options) as process:
        if "hold" in settings:
            wait_for(lambda: held.exists() or process.poll() is not None)
        elif is_one_kill:
            time.sleep(rng.uniform(0.0, 2.0))
        else:  # before there is a lock, a signal may meet Python while it starts
            wait_for(lambda: lock.exists() or process.poll() is not None)
            time.sleep(rng.uniform(0.0, 0.5))
        for number in numbers:
            process.send_signal(number)
            time.sleep(0.1)
        code, _, err = wait_for_end(process)
    assert "Traceback" not in err
    assert left_of(process.pid) == []
    return code


SEEDS = {"any": range(3), "part": range(3), "figures": range(1), "record": range(1)}
CASES = [
    (verb, point, numbers, seed)
    for verb in RECORDS
    for numbers in ([KILL], [KILL, KILL, KILL], [TERM], [INTERRUPT], [HANG_UP])
    for point in SEEDS
    for seed in SEEDS[point]
]
SAMPLE = [("sweep", "part", [KILL], 0)]
REST = [case for case in CASES if case not in SAMPLE]


@pytest.mark.parametrize(("verb", "point", "numbers", "seed"), quick_and_torture(SAMPLE, REST))
def test_a_run_that_gets_a_signal_resumes_to_the_same_bytes(
    tmp_path, undisturbed, hashes_in, verb, point, numbers, seed
):
    """Several signals go to runs that are resumed one after the other."""
    rng = random.Random(seed)  # noqa: S311 - a repeatable sample
    place = study_in(tmp_path / "place", STUDIES[verb])
    run = place / "run"
    options = list(QUIET)
    if point == "figures":
        options.remove("--no-figures")
    words = [verb, "study.toml", *options, "--resume"]
    for number in numbers:
        code = signalled(place, held_at(point, rng), words, [number], rng)
        expected_code = -number if number == KILL else 128 + number
        is_whole = (run / RECORDS[verb]).exists()  # if so, the signal may have met the exit
        assert is_whole or code == expected_code
        assert number == KILL or not temporary_files(run)
    assert_resumes(verb, place, undisturbed(verb), hashes_in, options)
    assert point != "figures" or list(run.glob("*.png"))


def test_a_second_interrupt_does_not_wait_for_the_part(place, undisturbed, hashes_in):
    settings = SMALL | {"hold": "part", "skip": 3, "seconds": 60.0}
    code = signalled(place, settings, SWEEP, [INTERRUPT, INTERRUPT], None)
    assert code == 130  # or `wait_for_end` runs out of time
    assert_resumes("sweep", place, undisturbed("sweep"), hashes_in)


def test_a_run_that_ignores_hang_ups_goes_on(place):
    ignore = {"preexec_fn": lambda: signal.signal(HANG_UP, signal.SIG_IGN)}
    settings = SMALL | {"hold": "part", "skip": PARTS - 1, "seconds": 1.0}
    assert signalled(place, settings, SWEEP, [HANG_UP], None, **ignore) == 0


# --- Two runs on one folder -----------------------------------------------------------------------

RACES = [(verb, mode) for verb in RECORDS for mode in ("", "--resume", "--overwrite")]
QUICK_RACES = [("sweep", "")]


@pytest.mark.parametrize("seed", quick_and_torture([0], range(1, 8)))
@pytest.mark.parametrize(("verb", "mode"), quick_and_torture(QUICK_RACES, RACES))
def test_of_two_runs_on_one_folder_exactly_one_proceeds(
    tmp_path, undisturbed, hashes_in, verb, mode, seed
):
    place = study_in(tmp_path / "place", STUDIES[verb])
    rng = random.Random(seed)  # noqa: S311 - a repeatable sample
    words = [verb, "study.toml", *QUIET]
    if mode == "--resume":
        signalled(place, held_at("part", rng), words, [KILL], rng)
    elif mode == "--overwrite":
        code, _, _ = launched(place, SMALL, *words)
        assert code == 0
    if mode:
        words.append(mode)
    words.append("--json")
    slow = SMALL | {"hold": "part", "skip": 0, "seconds": 0.05}
    with (
        running(place, slow | {"go": "a"}, *words) as first,
        running(place, slow | {"go": "b"}, *words) as second,
    ):
        wait_for(lambda: all((place / f"go-{runner}").exists() for runner in "ab"))
        (place / "go").touch()
        results = [wait_for_end(process) for process in (first, second)]
    assert sorted(code for code, _, _ in results) == [0, 7], results
    loser = json.loads(next(out for code, out, _ in results if code == 7))
    assert "another run is writing here" in loser["error"]["message"]
    assert hashes_in(place / "run") == undisturbed(verb)
    assert not temporary_files(place / "run")


# --- No room --------------------------------------------------------------------------------------

FULL = """
mount -t tmpfs -o size=$1k tmpfs disk || exit 99
shift
for step in first again second; do
    [ $step = second ] && mount -o remount,size=64m disk
    "$@" > $step.out 2> $step.err
    echo $? > $step.exit
    cp -a disk $step
done
"""
"""A command on a small disk, twice, then with more room; what stands on it each time is kept."""
STEPS = ("first", "again", "second")
SIZES = [60, 80, 120, 200, 300, 400, 600]
"""Sizes of a disk, kB.

A whole run takes about 1 MB; the least that is asked for beforehand is under 40 kB.
"""


def can_mount(words):
    """Return True if a file system can be mounted by a command."""
    if shutil.which("unshare") is None:
        return False
    probe = [*words, "mount", "-t", "tmpfs", "tmpfs", "/mnt"]
    return subprocess.run(probe, check=False, capture_output=True).returncode == 0


@pytest.mark.torture
@pytest.mark.parametrize("kilobytes", SIZES)
def test_a_full_disk_is_exit_5_and_the_run_goes_on_with_more_room(
    undisturbed, hashes_in, tmp_path, kilobytes
):
    """The disk is in a name space of mounts of its own."""
    alone = ["unshare", "--mount"]
    if os.geteuid() != 0:
        alone.append("--map-root-user")
    if not can_mount(alone):
        pytest.skip("no file system can be mounted here")
    study_in(tmp_path)
    (tmp_path / "disk").mkdir()
    words = ("sweep", "study.toml", "--out", "disk/run", "--jobs", "2", "--resume", "--json")
    script = [*alone, "sh", "-c", FULL, "sh", str(kilobytes), *command(SMALL, *words)]
    subprocess.run(script, check=True, cwd=tmp_path, timeout=180)
    assert [int((tmp_path / f"{step}.exit").read_text()) for step in STEPS] == [5, 5, 0]
    whole = undisturbed("sweep")
    tables = {step: hashes_in(tmp_path / step / "run") for step in STEPS}
    for step in ("first", "again"):
        error = json.loads((tmp_path / f"{step}.out").read_text())["error"]
        assert (error["exit"], error["kind"]) == (5, "output")
        assert "space" in error["message"]
        assert "Traceback" not in (tmp_path / f"{step}.err").read_text()
        assert not (tmp_path / step / "run/run.json").exists()
        assert not temporary_files(tmp_path / step)
        assert tables[step].items() <= whole.items()
    assert tables["first"].items() <= tables["again"].items()
    assert tables["second"] == whole
    record = json.loads((tmp_path / "second.out").read_text())
    assert record["resumed_parts"] >= len(tables["first"]) // 2 - 4


def test_a_disk_that_cannot_hold_the_run_is_reported_beforehand(tendon, place, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=16_000))
    ran = tendon("sweep", place / "study.toml", "--out", place / "run", "--json")
    assert (ran.exit, ran.json["error"]["kind"]) == (2, "size")
    assert not (place / "run").exists()


@pytest.mark.parametrize("kilobytes", quick_and_torture([4], [1, 2, 8, 16]))
def test_files_that_may_not_grow_are_exit_5(place, undisturbed, hashes_in, kilobytes):
    """The length of each file is limited, as quotas do."""
    limits = (kilobytes * 1024, kilobytes * 1024)
    limit = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limits)}
    code, out, err = launched(place, SMALL, *SWEEP, "--json", **limit)
    assert (code, json.loads(out)["error"]["kind"], err) == (5, "output", "")
    assert not (place / "run/run.json").exists()
    assert not temporary_files(place / "run")
    assert hashes_in(place / "run").items() <= undisturbed("sweep").items()
    record = assert_resumes("sweep", place, undisturbed("sweep"), hashes_in)
    assert record["parts"] == PARTS
