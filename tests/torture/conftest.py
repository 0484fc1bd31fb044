"""What the runs of this folder are compared with."""

import pytest

from tendon_cli import terminal

from .tools import STATES, STUDY, SWEEP, launched, study_in


@pytest.fixture(scope="session")
def uninterrupted(tmp_path_factory, hashes_in):
    """SHA-256 of every table of a run that nobody disturbed."""
    folder = study_in(tmp_path_factory.mktemp("uninterrupted"), STUDY)
    code, _, said = launched(folder, {"states": STATES}, *SWEEP)
    assert code == 0, said
    return hashes_in(folder / "run")


@pytest.fixture
def place(tmp_path):
    """A folder of its own with the study in it."""
    return study_in(tmp_path / "place", STUDY)


@pytest.fixture(autouse=True)
def whole_stdout(monkeypatch):
    """Standard output as it is at the start of a process, whatever an earlier command of this one did to it."""
    monkeypatch.setattr(terminal._stdout, "lost", False)
