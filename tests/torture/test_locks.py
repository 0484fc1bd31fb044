"""A file system that cannot lock: the run says so and writes nothing, unless it is told to do without."""

import json

import pytest

from .tools import STATES, SWEEP, launched, some

ERRORS = some(["ENOLCK"], ["EOPNOTSUPP", "ENOSYS"])


def without_locks(error):
    return {"states": STATES, "flock": error}


def standing(run):
    """Every file of a run with its bytes and the time of its last change."""
    return {
        file.name: (file.read_bytes(), file.stat().st_mtime_ns)
        for file in run.rglob("*")
        if file.is_file() and file.name != ".lock"
    }


@pytest.mark.parametrize("error", ERRORS)
def test_a_folder_that_cannot_be_locked_is_exit_7_and_nothing_is_written(place, error):
    code, out, said = launched(place, without_locks(error), *SWEEP)
    assert (code, out) == (7, "")
    assert said.startswith("tendon: error: run: the file system cannot lock: ")
    assert said.count("error") == 1
    assert "--no-lock" in said
    assert "Traceback" not in said
    assert standing(place / "run") == {}


@pytest.mark.parametrize("error", ERRORS)
def test_without_a_lock_the_bytes_are_the_same(place, uninterrupted, hashes_in, error):
    code, out, said = launched(place, without_locks(error), *SWEEP, "--no-lock", "--json")
    assert code == 0, out + said
    assert hashes_in(place / "run") == uninterrupted


@pytest.mark.parametrize("words", some([("--overwrite",)], [("--resume",), ()]), ids=" ".join)
def test_a_run_that_stands_where_nothing_can_be_locked_is_left_as_it_was(place, words):
    assert launched(place, {"states": STATES}, *SWEEP)[0] == 0
    before = standing(place / "run")
    code, out, _ = launched(place, without_locks("ENOLCK"), *SWEEP, *words, "--json")
    error = json.loads(out)["error"]
    assert (code, error["exit"], error["kind"], error["where"]) == (7, 7, "folder", "run")
    assert "--no-lock" in error["hint"]
    assert standing(place / "run") == before


@pytest.mark.parametrize("error", some(["ENOLCK"], ["EOPNOTSUPP", "ENOSYS"]))
def test_the_paper_needs_no_lock(place, error):
    """Its runs stand in a temporary folder that nobody else has."""
    code, out, said = launched(place, without_locks(error), "paper", "--out", "paper", "--json")
    assert (code, said) == (0, "")
    assert sorted(item.name for item in (place / "paper").iterdir()) == sorted(json.loads(out)["files"])
