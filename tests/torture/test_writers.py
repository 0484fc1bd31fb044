"""Other files are written whole, too: an error is exit 5, and what was there before stays."""

import errno
import os
from pathlib import Path

import pytest

from tests.sampled import quick_and_torture
from tools.torture.disk import ERRORS, Disk
from tools.torture.runs import READINGS, study_in

FIT = ("fit-friction", "cells.csv", "--bend-angle", "144 deg")
WRITERS = {
    "friction.toml": (*FIT, "--out"),
    "fit.png": (*FIT, "--plot"),
    "arm.svg": ("plot", "study.toml", "--arm", "--out"),
    "mine.toml": ("init",),
}
STEPS = ("open", "write", "fsync file", "rename")
STARTER_STEPS = ("open", "write", "fsync file")
STEPS_WITHOUT_LINKS = ("open", "write", "fsync file", "open", "rename")
"""A starter is put in place only if nothing stands there: by a link, else by a second opening."""
NO_LINKS = (errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS)


def patch_links(patch, number=None, appearing=None):
    """Let somebody else make the file before a link to it, or let links fail with an error.

    Args:
        patch: Patch of the standard library.
        number: Number of the error, as on a file system without links; None if they work.
        appearing: Content of the file that somebody else makes; None if nobody does.
    """
    link = Path.hardlink_to

    def call(path, target):
        if appearing is not None:
            path.write_bytes(appearing)
        if number is not None:
            raise OSError(number, os.strerror(number))
        link(path, target)

    patch.setattr(Path, "hardlink_to", call)


def contents(folder):
    """Return the content of every file in a folder."""
    return {item: item.read_bytes() for item in folder.iterdir()}


def assert_fails(tendon, file, steps, errors):
    """Check that an error at any step of writing is one message, and leaves what was there."""
    before = contents(file.parent)
    for at in range(len(steps)):
        for number in errors:
            with pytest.MonkeyPatch.context() as patch:
                disk = Disk(patch, file.parent)
                disk.reset(at, number)
                ran = tendon(*WRITERS[file.name], file)
            kinds = [kind for kind, _ in disk.operations]
            message = f"tendon: error: {file}: cannot be written: {os.strerror(number)}\n"
            assert kinds[: at + 1] == list(steps[: at + 1])
            assert (ran.exit, ran.out) == (5, "")
            assert ran.err.startswith(message)
            assert contents(file.parent) == before


@pytest.mark.parametrize("exists", [True, False], ids=["replaced", "new"])
@pytest.mark.parametrize("name", quick_and_torture(["friction.toml"], ["fit.png", "arm.svg"]))
def test_an_error_at_any_step_of_any_file_is_exit_5_and_changes_nothing(
    tendon, workplace, muttered, name, exists
):
    study_in(workplace, "")
    (workplace / "cells.csv").write_text(READINGS, encoding="utf-8")
    file = workplace / name
    # The first import makes files, too; this is before the disk is watched.
    assert tendon(*WRITERS[name], file).exit == 0
    whole = file.read_bytes()
    if not exists:
        file.unlink()
    assert_fails(tendon, file, STEPS, ERRORS[:2])
    assert tendon(*WRITERS[name], file).exit == 0
    assert file.read_bytes() == whole


LINKS = [(None, STARTER_STEPS), *((number, STEPS_WITHOUT_LINKS) for number in NO_LINKS)]


@pytest.mark.parametrize(("number", "steps"), quick_and_torture(LINKS[:2], LINKS[2:]))
def test_an_error_at_any_step_of_a_starter_leaves_nothing(
    tendon, workplace, monkeypatch, muttered, number, steps
):
    patch_links(monkeypatch, number)
    assert_fails(tendon, workplace / "mine.toml", steps, ERRORS)
    assert tendon("init", "mine.toml").exit == 0
    assert [file.name for file in workplace.iterdir()] == ["mine.toml"]


@pytest.mark.parametrize("number", [None, *NO_LINKS])
def test_a_file_that_appears_while_a_starter_is_written_stays(
    tendon, workplace, monkeypatch, number
):
    patch_links(monkeypatch, number, appearing=b"what was there before")
    assert tendon("init", "mine.toml").exit == 2
    assert (workplace / "mine.toml").read_bytes() == b"what was there before"
    assert [file.name for file in workplace.iterdir()] == ["mine.toml"]
