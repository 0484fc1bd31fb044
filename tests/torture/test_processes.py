"""Runs in processes of their own that are killed, stopped, raced, or out of room: nothing is left of them but what can
be resumed to the same bytes."""

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

from .conftest import STUDIES
from .tools import (
    PARTS,
    QUIET,
    SMALL,
    SWEEP,
    command,
    ended,
    launched,
    left_of,
    running,
    some,
    study_in,
    temporary_files,
    wait_for,
)

RECORDS = {"sweep": "run.json", "design": "design.json"}
KILL, TERM, INTERRUPT, HANG_UP = signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP


def assert_resumes(verb, place, expected, hashes_in, *words):
    run = place / "run"
    code, out, said = launched(
        place, SMALL, verb, "study.toml", *(words or QUIET), "--resume", "--json"
    )
    assert code == 0, out + said
    assert hashes_in(run) == expected
    assert ((run / RECORDS[verb]).exists(), (run / "journal.jsonl").exists()) == (True, False)
    assert not temporary_files(run)
    return json.loads(out)


# --- Signals --------------------------------------------------------------------------------------


def moment(point, chance):
    """As if something took a while, so that a run is met at a moment that is chosen."""
    skip = chance.randrange(5) if point == "part" else 0
    return SMALL | ({} if point == "any" else {"hold": point, "skip": skip, "seconds": 1.0})


def signalled(place, settings, words, numbers, chance, **options):
    """The exit code of a run that gets signals, and what is left of it."""
    (place / "held").unlink(missing_ok=True)
    with running(place, settings, *words, **options) as process:
        if "hold" in settings:
            wait_for(lambda: (place / "held").exists() or process.poll() is not None)
        else:  # before there is a journal, a signal may meet Python while it starts
            wait_for(
                lambda: (
                    numbers == [KILL]
                    or (place / "run/journal.jsonl").exists()
                    or process.poll() is not None
                )
            )
            time.sleep(chance.uniform(0.0, 2.0 if numbers == [KILL] else 0.5))
        for number in numbers:
            process.send_signal(number)
            time.sleep(0.1)
        code, _, said = ended(process)
    assert ("Traceback" in said, left_of(process.pid)) == (False, [])
    return code


CASES = [
    (verb, point, numbers, seed)
    for verb in RECORDS
    for numbers in ([KILL], [KILL, KILL, KILL], [TERM], [INTERRUPT], [HANG_UP])
    for point in ("any", "part", "figures", "record")
    for seed in range(3 if point in ("any", "part") else 1)
]
STOPS = [TERM, INTERRUPT, HANG_UP]
SAMPLE = [
    ("sweep", "part", [KILL, KILL, KILL], 0),
    ("design", "part", [KILL], 0),
    ("sweep", "figures", STOPS, 0),
]


@pytest.mark.parametrize(
    ("verb", "point", "numbers", "seed"),
    some(SAMPLE, [case for case in CASES if case not in SAMPLE]),
)
def test_a_run_that_gets_a_signal_resumes_to_the_same_bytes(
    tmp_path, undisturbed, hashes_in, verb, point, numbers, seed
):
    """Several kills are of runs that are resumed one after the other."""
    chance = random.Random(seed)  # noqa: S311 - a repeatable sample
    place = study_in(tmp_path / "place", STUDIES[verb])
    words = [
        word
        for word in (verb, "study.toml", *QUIET)
        if word != "--no-figures" or point != "figures"
    ]
    for number in numbers:
        code = signalled(place, moment(point, chance), [*words, "--resume"], [number], chance)
        is_whole = (
            place / "run" / RECORDS[verb]
        ).exists()  # if so, the signal may have met the exit
        assert is_whole or code == (-number if number == KILL else 128 + number)
        assert number == KILL or not temporary_files(place / "run")
    assert_resumes(verb, place, undisturbed(verb), hashes_in, *words[2:])
    assert point != "figures" or list((place / "run").glob("*.png"))


def test_a_second_interrupt_does_not_wait_for_the_part(place, undisturbed, hashes_in):
    settings = SMALL | {"hold": "part", "skip": 3, "seconds": 60.0}
    assert (
        signalled(place, settings, SWEEP, [INTERRUPT, INTERRUPT], None) == 130
    )  # or `ended` runs out of time
    assert_resumes("sweep", place, undisturbed("sweep"), hashes_in)


def test_a_run_that_was_told_to_ignore_hang_ups_goes_on(place):
    ignore = {"preexec_fn": lambda: signal.signal(HANG_UP, signal.SIG_IGN)}
    settings = SMALL | {"hold": "part", "skip": PARTS - 1, "seconds": 1.0}
    assert signalled(place, settings, SWEEP, [HANG_UP], None, **ignore) == 0


# --- Two runs on one folder -----------------------------------------------------------------------

RACES = [(verb, way) for verb in RECORDS for way in ("", "--resume", "--overwrite")]


@pytest.mark.parametrize("seed", some([0], range(1, 8)))
@pytest.mark.parametrize(("verb", "way"), some([("sweep", ""), ("design", "--resume")], RACES))
def test_of_two_runs_on_one_folder_exactly_one_proceeds(
    tmp_path, undisturbed, hashes_in, verb, way, seed
):
    place = study_in(tmp_path / "place", STUDIES[verb])
    words, chance = (verb, "study.toml", *QUIET), random.Random(seed)  # noqa: S311 - a repeatable sample
    if way == "--resume":
        signalled(place, moment("part", chance), words, [KILL], chance)
    elif way == "--overwrite":
        assert launched(place, SMALL, *words)[0] == 0
    slow = SMALL | {"hold": "part", "skip": 0, "seconds": 0.05}
    words = [*words, *filter(None, [way]), "--json"]
    with (
        running(place, slow | {"go": "a"}, *words) as one,
        running(place, slow | {"go": "b"}, *words) as other,
    ):
        wait_for(lambda: all((place / f"go-{runner}").exists() for runner in "ab"))
        (place / "go").touch()
        results = [ended(process) for process in (one, other)]
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
SIZES = some([300], [60, 80, 120, 200, 400, 600])
"""A whole run takes about 1 MB; the least that is asked for beforehand is under 40 kB."""


@pytest.mark.parametrize("kilobytes", SIZES)
def test_a_full_disk_is_exit_5_and_the_run_goes_on_with_more_room(
    undisturbed, hashes_in, tmp_path, kilobytes
):
    """In a name space of mounts of its own."""
    alone = ["unshare", "--mount", *([] if os.geteuid() == 0 else ["--map-root-user"])]
    probe = [*alone, "mount", "-t", "tmpfs", "tmpfs", "/mnt"]
    if (
        shutil.which("unshare") is None
        or subprocess.run(probe, check=False, capture_output=True).returncode
    ):
        pytest.skip("no file system can be mounted here")
    study_in(tmp_path), (tmp_path / "disk").mkdir()
    words = ("sweep", "study.toml", "--out", "disk/run", "--jobs", "2", "--resume", "--json")
    script = [*alone, "sh", "-c", FULL, "sh", str(kilobytes), *command(SMALL, *words)]
    subprocess.run(script, check=True, cwd=tmp_path, timeout=180)
    assert [int((tmp_path / f"{step}.exit").read_text()) for step in STEPS] == [5, 5, 0]
    whole, kept = undisturbed("sweep"), [hashes_in(tmp_path / step / "run") for step in STEPS]
    for step, tables in zip(STEPS[:2], kept, strict=False):
        error = json.loads((tmp_path / f"{step}.out").read_text())["error"]
        assert (error["exit"], error["kind"], "space" in error["message"]) == (5, "output", True)
        assert "Traceback" not in (tmp_path / f"{step}.err").read_text()
        assert not (tmp_path / step / "run/run.json").exists()
        assert not temporary_files(tmp_path / step)
        assert tables.items() <= whole.items()
    assert kept[0].items() <= kept[1].items()
    assert kept[2] == whole
    assert (
        json.loads((tmp_path / "second.out").read_text())["resumed_parts"] >= len(kept[0]) // 2 - 4
    )


def test_a_disk_that_cannot_hold_the_run_is_told_beforehand(tendon, place, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=16_000))
    ran = tendon("sweep", place / "study.toml", "--out", place / "run", "--json")
    assert (ran.exit, ran.json["error"]["kind"], (place / "run").exists()) == (2, "size", False)


@pytest.mark.parametrize("kilobytes", some([4], [1, 2, 8, 16]))
def test_files_that_may_not_grow_are_exit_5(place, undisturbed, hashes_in, kilobytes):
    """A limit on the length of each file, as quotas set."""
    limits = (kilobytes * 1024, kilobytes * 1024)
    limit = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limits)}
    code, out, said = launched(place, SMALL, *SWEEP, "--json", **limit)
    assert (code, json.loads(out)["error"]["kind"], said) == (5, "output", "")
    assert not (place / "run/run.json").exists()
    assert not temporary_files(place / "run")
    assert hashes_in(place / "run").items() <= undisturbed("sweep").items()
    assert assert_resumes("sweep", place, undisturbed("sweep"), hashes_in)["parts"] == PARTS
