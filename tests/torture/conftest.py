"""Fixtures of the tests under torture: a folder with a study, and the tables to expect of it."""

import sys

import pytest

from tools.torture.runs import QUIET, SMALL, STUDIES, STUDY, launched, study_in


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory, hashes_in):
    """Return a function that gives the SHA-256 of every table of a run that nobody disturbed."""
    known = {}

    def hashes_of(verb):
        if verb not in known:
            folder = study_in(tmp_path_factory.mktemp(verb), STUDIES[verb])
            code, out, err = launched(folder, SMALL, verb, "study.toml", *QUIET)
            assert code == 0, out + err
            known[verb] = hashes_in(folder / "run")
        return known[verb]

    return hashes_of


@pytest.fixture
def place(tmp_path):
    """Return a folder of its own with the study in it."""
    return study_in(tmp_path / "place", STUDY)


@pytest.fixture(autouse=True)
def whole_stdout(monkeypatch):
    """Restore standard output after each test, since a command may have replaced it."""
    monkeypatch.setattr(sys, "stdout", sys.stdout)
