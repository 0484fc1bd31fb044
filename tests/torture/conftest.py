"""What the runs of this folder are compared with."""

import sys

import pytest

from .tools import QUESTION, QUIET, SMALL, STUDY, launched, study_in

STUDIES = {"sweep": STUDY, "design": QUESTION}


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory, hashes_in):
    """SHA-256 of every table of a run that nobody disturbed, by its command."""
    known = {}

    def of(verb):
        if verb not in known:
            folder = study_in(tmp_path_factory.mktemp(verb), STUDIES[verb])
            code, out, said = launched(folder, SMALL, verb, "study.toml", *QUIET)
            assert code == 0, out + said
            known[verb] = hashes_in(folder / "run")
        return known[verb]

    return of


@pytest.fixture
def place(tmp_path):
    """A folder of its own with the study in it."""
    return study_in(tmp_path / "place", STUDY)


@pytest.fixture(autouse=True)
def whole_stdout(monkeypatch):
    """Standard output as it is at the start of a process, whatever an earlier command of this one did to it."""
    monkeypatch.setattr(sys, "stdout", sys.stdout)
