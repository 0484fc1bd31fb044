"""Other files are written whole, too: an error at any step is exit 5, and what was there before stays."""

import errno
import os
from pathlib import Path

import pytest

from .disk import ERRORS, Disk
from .tools import READINGS, some, study_in

FIT = ("fit-friction", "cells.csv", "--bend-angle", "144 deg")
WRITERS = {
    "friction.toml": (*FIT, "--out"),
    "fit.png": (*FIT, "--plot"),
    "arm.svg": ("plot", "study.toml", "--arm", "--out"),
    "mine.toml": ("init",),
}
STEPS = ("open", "write", "fsync file", "rename")
STARTER, WITHOUT_LINKS = STEPS[:3], (*STEPS[:3], "open", "rename")
"""A starter is put in place only if nothing stands there: by a link, or if there are none by a second opening."""
NO_LINKS = (errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS)


def linking(patch, number=None, appears=None):
    """Links that fail as on a file system that has none, perhaps after somebody else has made the file."""
    link = Path.hardlink_to

    def call(path, target):
        if appears is not None:
            path.write_bytes(appears)
        if number is not None:
            raise OSError(number, os.strerror(number))
        link(path, target)

    patch.setattr(Path, "hardlink_to", call)


def assert_fails(tendon, file, steps, errors):
    """An error at any step of writing a file is one message, and leaves what was there."""
    before = {item: item.read_bytes() for item in file.parent.iterdir()}
    for at in range(len(steps)):
        for number in errors:
            with pytest.MonkeyPatch.context() as patch:
                disk = Disk(patch, file.parent)
                disk.begin(at, number)
                ran = tendon(*WRITERS[file.name], file)
            assert [kind for kind, _ in disk.seen][: at + 1] == list(steps[: at + 1])
            assert (ran.exit, ran.out) == (5, "")
            assert ran.err.startswith(
                f"tendon: error: {file}: cannot be written: {os.strerror(number)}\n"
            )
            assert {item: item.read_bytes() for item in file.parent.iterdir()} == before


@pytest.mark.parametrize("stands", [True, False], ids=["replaced", "new"])
@pytest.mark.parametrize("name", some(["friction.toml"], ["fit.png", "arm.svg"]))
def test_an_error_at_any_step_of_any_file_is_exit_5_and_changes_nothing(
    tendon, workplace, muttered, name, stands
):
    study_in(workplace, "")
    (workplace / "cells.csv").write_text(READINGS, encoding="utf-8")
    file = workplace / name
    assert (
        tendon(*WRITERS[name], file).exit == 0
    )  # what is made at the first import only is made here
    whole = file.read_bytes()
    if not stands:
        file.unlink()
    assert_fails(tendon, file, STEPS, ERRORS if name == "friction.toml" else ERRORS[:2])
    assert tendon(*WRITERS[name], file).exit == 0
    assert file.read_bytes() == whole


@pytest.mark.parametrize(
    ("number", "steps"), [(None, STARTER), *((number, WITHOUT_LINKS) for number in NO_LINKS)]
)
def test_an_error_at_any_step_of_a_starter_leaves_nothing(
    tendon, workplace, monkeypatch, muttered, number, steps
):
    linking(monkeypatch, number)
    assert_fails(tendon, workplace / "mine.toml", steps, ERRORS)
    assert tendon("init", "mine.toml").exit == 0
    assert [file.name for file in workplace.iterdir()] == ["mine.toml"]


@pytest.mark.parametrize("number", [None, *NO_LINKS])
def test_a_file_that_appears_while_a_starter_is_written_stays(
    tendon, workplace, monkeypatch, number
):
    linking(monkeypatch, number, appears=b"what was there before")
    assert tendon("init", "mine.toml").exit == 2
    assert (workplace / "mine.toml").read_bytes() == b"what was there before"
    assert [file.name for file in workplace.iterdir()] == ["mine.toml"]
