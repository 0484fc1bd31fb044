"""A run that is killed, wherever it is, goes on where it stopped; two runs never write to one folder."""

import json
import random
import time
from dataclasses import dataclass

import pytest

from .tools import (
    PARTS,
    SLOW,
    SMALL,
    STUDY,
    SWEEP,
    group_members,
    journalled,
    kill_group,
    launched,
    running,
    some,
    start,
    study_in,
    temporary_files,
    wait_for,
)

JOBS = 2
IN_FLIGHT = 2 * JOBS
"""Parts that may be out at once: each thread has one, and one more is handed to it beforehand."""
QUESTION = """
name = "torture"
[spring]
stiffness = { from = "3 kN/m", to = "8 kN/m", num = 6 }
[spool]
ratio = [0.5, 0.55, 0.6, 0.65, 0.7]
[load]
mass = ["0 kg", "5 kg"]
[motion]
elbow_angle = { from = "10 deg", to = "90 deg", num = 5 }
[design]
maximise = ["tolerance"]
"""
"""30 choices; the best lies between two of them, so that a part is written once more."""


@dataclass(frozen=True)
class Verb:
    """A command of the engine, whose runs are killed."""

    study: str
    words: tuple[str, ...]
    settings: dict
    slow: dict
    tables: tuple[str, ...]
    parts: int
    record: str

    def place(self, folder):
        return study_in(folder / "place", self.study)


CHOICES = {"choices": 1}
VERBS = {
    "sweep": Verb(STUDY, SWEEP, SMALL, SLOW, ("designs", "states"), PARTS, "run.json"),
    "design": Verb(
        QUESTION, ("design", *SWEEP[1:]), CHOICES, CHOICES | {"hold": "solve", "held": "held", "seconds": 0.03},
        ("choices",), 30, "design.json",
    ),
}  # fmt: skip


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory, hashes_in):
    """SHA-256 of every table of a run that nobody disturbed, by its command."""
    known = {}

    def of(name):
        if name not in known:
            verb = VERBS[name]
            place = verb.place(tmp_path_factory.mktemp(name))
            code, out, said = launched(place, verb.settings, *verb.words)
            assert code == 0, out + said
            known[name] = hashes_in(place / "run")
        return known[name]

    return of


def kill_somewhen(process, run, parts, chance):
    """Kill a run at a random moment: at any time after its start, or at a random number of finished parts."""
    if chance.random() < 0.2:
        time.sleep(chance.uniform(0.0, 1.2))
    else:
        wanted = chance.randrange(parts)
        wait_for(lambda: journalled(run) >= wanted or process.poll() is not None)
        time.sleep(chance.uniform(0.0, 0.012))
    kill_group(process)


def standing_parts(run, tables):
    """Parts whose files are all in place, recorded or not."""
    return len(
        set.intersection(
            *({file.name for file in (run / f"{table}.parquet").glob("part-*.parquet")} for table in tables)
        )
    )


def modified(run):
    return {
        file: file.stat().st_mtime_ns
        for file in run.rglob("*")
        if file.suffix == ".parquet" or file.suffix.startswith(".json")
    }


def assert_resumes_to(verb, expected, place, hashes_in, tendon):
    """Resume once: the same bytes, nothing redone but what was in flight. Resume twice: nothing at all is done."""
    run = place / "run"
    was_finished, recorded, standing = (run / verb.record).exists(), journalled(run), standing_parts(run, verb.tables)
    code, out, said = launched(place, verb.settings, *verb.words, "--resume", "--json")
    assert code == 0, out + said
    record = json.loads(out)
    if not was_finished:
        assert record["resumed_parts"] == recorded
        assert standing - recorded <= IN_FLIGHT
    assert hashes_in(run) == expected
    assert not temporary_files(run)
    assert was_finished or not (run / "journal.jsonl").exists()
    before = modified(run)
    again = tendon(verb.words[0], place / "study.toml", "--out", run, "--no-figures", "--resume")
    assert (again.exit, "up to date" in again.out) == (0, True)
    assert modified(run) == before


@pytest.mark.parametrize("seed", some(range(2), range(2, 54)))
@pytest.mark.parametrize("name", VERBS)
def test_a_run_killed_at_a_random_moment_resumes_to_the_same_bytes(
    tmp_path, undisturbed, hashes_in, tendon, name, seed
):
    verb, expected = VERBS[name], undisturbed(name)
    place = verb.place(tmp_path)
    with running(place, verb.slow, *verb.words) as process:
        kill_somewhen(process, place / "run", verb.parts, random.Random(seed))  # noqa: S311 - a repeatable sample
    assert group_members(process.pid) == []
    assert_resumes_to(verb, expected, place, hashes_in, tendon)


@pytest.mark.parametrize("seed", some([0], range(1, 8)))
@pytest.mark.parametrize("name", VERBS)
def test_a_run_killed_again_and_again_still_comes_to_its_end(tmp_path, undisturbed, hashes_in, tendon, name, seed):
    verb, expected = VERBS[name], undisturbed(name)
    place = verb.place(tmp_path)
    chance, run = random.Random(seed), place / "run"  # noqa: S311 - a repeatable sample
    done = 0
    for _ in range(4):
        with running(place, verb.slow, *verb.words, "--resume") as process:
            wanted = min(verb.parts - 1, done + chance.randrange(1, verb.parts // 4))
            wait_for(lambda wanted=wanted, process=process: journalled(run) >= wanted or process.poll() is not None)
            kill_group(process)
        assert journalled(run) >= done, "a part that had been recorded was lost"
        done = journalled(run)
    assert_resumes_to(verb, expected, place, hashes_in, tendon)


POINTS = {"sweep": ["record", "rows", "journal", "rename", "figures"],
          "design": ["last", "record", "solve", "compare", "journal", "rename", "figures"]}  # fmt: skip


CERTAIN = [(name, point) for name in VERBS for point in POINTS[name][1:]]


@pytest.mark.parametrize("at", some([("sweep", "record"), ("design", "last")], CERTAIN), ids="-".join)
def test_a_run_killed_at_a_certain_point_resumes_to_the_same_bytes(tmp_path, undisturbed, hashes_in, tendon, at):
    name, point = at
    verb, expected = VERBS[name], undisturbed(name)
    place = verb.place(tmp_path)
    words = [word for word in verb.words if word != "--no-figures"] if point == "figures" else verb.words
    with running(place, verb.settings | {"hold": point, "held": "held"}, *words) as process:
        wait_for((place / "held").exists)
        kill_group(process)
    assert not (place / "run" / verb.record).exists()
    assert_resumes_to(verb, expected, place, hashes_in, tendon)


@pytest.mark.parametrize("seed", some([0], range(1, 11)))
def test_an_answer_killed_between_the_last_files_and_their_names_resumes(
    tmp_path, undisturbed, hashes_in, tendon, seed
):
    """The last renames of an answer: of a part that is written once more, and of the record."""
    verb, expected = VERBS["design"], undisturbed("design")
    place = verb.place(tmp_path)
    settings = verb.settings | {"hold": "rename", "held": "held", "seconds": 60.0, "skip": 31 + seed % 4}
    with running(place, settings, *verb.words) as process:
        wait_for(lambda: (place / "held").exists() or process.poll() is not None)
        kill_group(process)
    assert_resumes_to(verb, expected, place, hashes_in, tendon)


@pytest.mark.parametrize("name", VERBS)
def test_a_run_killed_while_it_replaces_another_can_be_started_again(tmp_path, undisturbed, hashes_in, name):
    verb, expected = VERBS[name], undisturbed(name)
    place = verb.place(tmp_path)
    assert launched(place, verb.settings, *verb.words)[0] == 0
    with running(place, verb.settings | {"hold": "delete", "held": "held"}, *verb.words, "--overwrite") as process:
        wait_for((place / "held").exists)
        kill_group(process)
    for words in (("--overwrite",), ("--resume",)):
        code, out, said = launched(place, verb.settings, *verb.words, *words, "--json")
        assert code == 0, out + said
    assert hashes_in(place / "run") == expected


# --- Two runs on one folder ------------------------------------------------------------------------------------------


RACES = {"empty": (), "resume": ("--resume",), "overwrite": ("--overwrite",)}


@pytest.mark.parametrize("seed", some(range(3), range(3, 23)))
@pytest.mark.parametrize("name", VERBS)
def test_of_two_runs_on_one_folder_exactly_one_proceeds(tmp_path, undisturbed, hashes_in, name, seed):
    verb, expected = VERBS[name], undisturbed(name)
    place, kind = verb.place(tmp_path), list(RACES)[seed % 3]
    if kind == "resume":
        with running(place, verb.slow, *verb.words) as process:
            wait_for(lambda: journalled(place / "run") >= 5)
            kill_group(process)
    elif kind == "overwrite":
        assert launched(place, verb.settings, *verb.words)[0] == 0
    words = (*verb.words, *RACES[kind], "--json")
    both = [start(place, verb.slow | {"go": "go", "runner": runner}, *words) for runner in "ab"]
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
    assert hashes_in(place / "run") == expected
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
    assert_resumes_to(VERBS["sweep"], uninterrupted, place, hashes_in, tendon)
