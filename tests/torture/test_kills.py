"""A run that is killed, wherever it is, goes on where it stopped; two runs never write to one folder."""

import json
import random
import time

import pytest

from .tools import (
    PARTS,
    SLOW,
    SMALL,
    SWEEP,
    group_members,
    journalled,
    kill_group,
    launched,
    running,
    some,
    start,
    temporary_files,
    wait_for,
)

JOBS = 2
IN_FLIGHT = 2 * JOBS
"""Parts that may be out at once: each thread has one, and one more is handed to it beforehand."""


def kill_somewhen(process, run, chance):
    """Kill a run at a random moment: at any time after its start, or at a random number of finished parts."""
    if chance.random() < 0.2:
        time.sleep(chance.uniform(0.0, 1.2))
    else:
        parts = chance.randrange(PARTS)
        wait_for(lambda: journalled(run) >= parts or process.poll() is not None)
        time.sleep(chance.uniform(0.0, 0.012))
    kill_group(process)


def standing_parts(run):
    """Parts whose files are all in place, recorded or not."""
    tables = [
        {file.name for file in (run / f"{table}.parquet").glob("part-*.parquet")} for table in ("designs", "states")
    ]
    return len(set.intersection(*tables))


def modified(run):
    return {
        file: file.stat().st_mtime_ns
        for file in run.rglob("*")
        if file.suffix == ".parquet" or file.suffix.startswith(".json")
    }


def assert_resumes_to(expected, place, hashes_in, tendon):
    """Resume once: the same bytes, nothing redone but what was in flight. Resume twice: nothing at all is done."""
    run = place / "run"
    was_finished, recorded, standing = (run / "run.json").exists(), journalled(run), standing_parts(run)
    code, out, said = launched(place, SMALL, *SWEEP, "--resume", "--json")
    assert code == 0, said
    record = json.loads(out)
    if not was_finished:
        assert record["resumed_parts"] == recorded
        assert standing - recorded <= IN_FLIGHT
    assert hashes_in(run) == expected
    assert not temporary_files(run)
    assert was_finished or not (run / "journal.jsonl").exists()
    before = modified(run)
    again = tendon("sweep", place / "study.toml", "--out", run, "--no-figures", "--resume")
    assert (again.exit, "up to date" in again.out) == (0, True)
    assert modified(run) == before


@pytest.mark.parametrize("seed", some(range(4), range(4, 54)))
def test_a_run_killed_at_a_random_moment_resumes_to_the_same_bytes(place, uninterrupted, hashes_in, tendon, seed):
    with running(place, SLOW, *SWEEP) as process:
        kill_somewhen(process, place / "run", random.Random(seed))  # noqa: S311 - a repeatable sample
    assert group_members(process.pid) == []
    assert_resumes_to(uninterrupted, place, hashes_in, tendon)


@pytest.mark.parametrize("seed", some([0], range(1, 8)))
def test_a_run_killed_again_and_again_still_comes_to_its_end(place, uninterrupted, hashes_in, tendon, seed):
    chance, run = random.Random(seed), place / "run"  # noqa: S311 - a repeatable sample
    done = 0
    for _ in range(4):
        with running(place, SLOW, *SWEEP, "--resume") as process:
            wanted = min(PARTS - 1, done + chance.randrange(1, 15))
            wait_for(lambda wanted=wanted, process=process: journalled(run) >= wanted or process.poll() is not None)
            kill_group(process)
        assert journalled(run) >= done, "a part that had been recorded was lost"
        done = journalled(run)
    assert_resumes_to(uninterrupted, place, hashes_in, tendon)


@pytest.mark.parametrize("point", some(["record"], ["rows", "journal", "rename", "figures"]))
def test_a_run_killed_at_a_certain_point_resumes_to_the_same_bytes(place, uninterrupted, hashes_in, tendon, point):
    words = [word for word in SWEEP if word != "--no-figures"] if point == "figures" else SWEEP
    with running(place, SMALL | {"hold": point, "held": "held"}, *words) as process:
        wait_for((place / "held").exists)
        kill_group(process)
    assert not (place / "run/run.json").exists()
    assert_resumes_to(uninterrupted, place, hashes_in, tendon)


def test_a_run_killed_while_it_replaces_another_can_be_started_again(place, uninterrupted, hashes_in):
    assert launched(place, SMALL, *SWEEP)[0] == 0
    with running(place, SMALL | {"hold": "delete", "held": "held"}, *SWEEP, "--overwrite") as process:
        wait_for((place / "held").exists)
        kill_group(process)
    for words in (("--overwrite",), ("--resume",)):
        code, out, said = launched(place, SMALL, *SWEEP, *words, "--json")
        assert code == 0, out + said
    assert hashes_in(place / "run") == uninterrupted


# --- Two runs on one folder ------------------------------------------------------------------------------------------


RACES = {"empty": (), "resume": ("--resume",), "overwrite": ("--overwrite",)}


@pytest.mark.parametrize("seed", some(range(3), range(3, 23)))
def test_of_two_runs_on_one_folder_exactly_one_proceeds(place, uninterrupted, hashes_in, seed):
    kind = list(RACES)[seed % 3]
    if kind == "resume":
        with running(place, SLOW, *SWEEP) as process:
            wait_for(lambda: journalled(place / "run") >= 5)
            kill_group(process)
    elif kind == "overwrite":
        assert launched(place, SMALL, *SWEEP)[0] == 0
    both = [start(place, SLOW | {"go": "go", "runner": runner}, *SWEEP, *RACES[kind], "--json") for runner in "ab"]
    try:
        wait_for(lambda: all((place / f"go-{runner}").exists() for runner in "ab"))
        (place / "go").touch()
        results = [process.communicate(timeout=60) for process in both]
    finally:
        for process in both:
            if process.poll() is None:
                kill_group(process)
    assert sorted(process.returncode for process in both) == [0, 7], results
    loser = json.loads(next(out for process, (out, _) in zip(both, results, strict=True) if process.returncode == 7))
    assert "another run is writing here" in loser["error"]["message"]
    assert hashes_in(place / "run") == uninterrupted
    assert not temporary_files(place / "run")


def test_the_second_run_leaves_at_once_and_a_killed_holder_leaves_no_lock(place, uninterrupted, hashes_in, tendon):
    with running(place, SMALL | {"hold": "rows", "held": "held"}, *SWEEP, "--jobs", "1") as holder:
        wait_for((place / "held").exists)
        before = modified(place / "run")
        for words in ((), ("--resume",), ("--overwrite",)):
            code, out, _ = launched(place, SMALL, *SWEEP, *words, "--json")
            assert (code, json.loads(out)["error"]["exit"]) == (7, 7)
        assert modified(place / "run") == before
        kill_group(holder)
    assert_resumes_to(uninterrupted, place, hashes_in, tendon)
