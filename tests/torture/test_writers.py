"""Other files are written whole, too: an error at any step is exit 5, and what was there before stays."""

import errno
import os
from pathlib import Path

import pytest

from tendon_cli import files

from .disk import ERRORS, Disk
from .tools import STATES, some, study_in

READINGS = "cell 1,cell 2\n1.2,1\n2.4,2\n1,1.2\n2,2.4\n"
FIT = ("fit-friction", "cells.csv", "--bend-angle", "144 deg")
WRITERS = {
    "friction.toml": (*FIT, "--out", "friction.toml"),
    "fit.png": (*FIT, "--plot", "fit.png"),
    "arm.svg": ("plot", "study.toml", "--arm", "--out", "arm.svg"),
}
STEPS = ("open", "write", "fsync file", "rename")
BEFORE = b"what was there before"


def failing(tendon, words, place, at, number):
    """A command whose step of that number fails."""
    with pytest.MonkeyPatch.context() as patch:
        disk = Disk(patch, place)
        patch.chdir(place)
        disk.begin(at, number)
        ran = tendon(*words[:-1], place / words[-1], "--json")
        return ran, [kind for kind, _ in disk.seen][: at + 1]


@pytest.mark.parametrize("stands", [True, False], ids=["replaced", "new"])
@pytest.mark.parametrize("name", some(["friction.toml"], ["fit.png", "arm.svg"]))
def test_an_error_at_any_step_of_any_file_is_exit_5_and_changes_nothing(tendon, workplace, muttered, name, stands):
    study_in(workplace, "")
    (workplace / "cells.csv").write_text(READINGS, encoding="utf-8")
    file = workplace / name
    assert tendon(*WRITERS[name]).exit == 0  # what is made at the first import only is made here
    whole = file.read_bytes()
    if not stands:
        file.unlink()
    before = sorted(workplace.iterdir())
    for at in range(len(STEPS)):
        for number in ERRORS if name == "friction.toml" else ERRORS[:2]:
            ran, seen = failing(tendon, WRITERS[name], workplace, at, number)
            assert seen == list(STEPS[: at + 1])
            assert (ran.exit, ran.json["error"]["kind"], ran.err) == (5, "output", "")
            assert os.strerror(number) in ran.json["error"]["message"]
            assert name in ran.json["error"]["where"]
            assert sorted(workplace.iterdir()) == before
            assert not stands or file.read_bytes() == whole
    assert tendon(*WRITERS[name]).exit == 0
    assert file.read_bytes() == whole


@pytest.mark.parametrize("kind", some(["write"], ["open", "fsync file", "rename"]))
@pytest.mark.parametrize("name", ["slack_map.png", "run.json", "journal.jsonl"])
def test_an_error_with_a_record_is_exit_5_and_with_a_figure_a_warning(
    tendon, place, undisturbed, monkeypatch, small_parts, kind, name, hashes_in
):
    small_parts(STATES)
    words = ("sweep", place / "study.toml", "--out", place / "run", "--json", "--jobs", "2")
    with monkeypatch.context() as patch:
        disk, named = Disk(patch, place / "run"), files.temporary_of
        patch.setattr(files, "temporary_of", lambda path, **how: named(path, **how).with_suffix(f".{path.name}.tmp"))

        def meet(operation, where):
            disk.seen.append((operation, str(where)))
            if operation == kind and (name in str(where) or (kind == "fsync file" and name in disk.seen[-2][1])):
                raise OSError(errno.EIO, os.strerror(errno.EIO))

        disk.meet = meet
        ran = tendon(*words)
    if name == "slack_map.png":
        assert ran.exit == 0
        assert any(os.strerror(errno.EIO) in warning for warning in ran.json["warnings"])
    else:
        assert (ran.exit, ran.json["error"]["kind"], ran.err) == (5, "output", "")
        assert not (place / "run/run.json").exists()
    assert not (place / "run" / name).exists() or name == "journal.jsonl"
    assert not list((place / "run").glob("**/*.tmp"))
    assert tendon(*words, "--resume").exit == 0
    assert hashes_in(place / "run") == undisturbed("sweep")
    assert (place / "run/slack_map.png").exists()


# --- A starter, which is put in place where nothing stands ------------------------------------------------------------

INIT = ("init", "mine.toml")
INIT_STEPS = {"links": ("open", "write", "fsync file"), "no links": (*STEPS[:3], "open", "rename")}
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


@pytest.mark.parametrize("links", INIT_STEPS)
def test_an_error_at_any_step_of_a_starter_leaves_nothing(tendon, workplace, monkeypatch, muttered, links):
    if links == "no links":
        linking(monkeypatch, errno.EPERM)
    steps = INIT_STEPS[links]
    for at in range(len(steps)):
        for number in ERRORS:
            with monkeypatch.context() as patch:
                disk = Disk(patch, workplace)
                disk.begin(at, number)
                ran = tendon("init", workplace / "mine.toml")
            assert [kind for kind, _ in disk.seen][: at + 1] == list(steps[: at + 1])
            assert (ran.exit, ran.out) == (5, "")
            assert ran.err.startswith(
                f"tendon: error: {workplace}/mine.toml: cannot be written: {os.strerror(number)}\n"
            )
            assert list(workplace.iterdir()) == []
    assert tendon(*INIT).exit == 0
    assert [file.name for file in workplace.iterdir()] == ["mine.toml"]


@pytest.mark.parametrize("number", NO_LINKS)
def test_a_starter_is_the_same_where_there_are_no_links(tendon, workplace, monkeypatch, number):
    assert tendon(*INIT).exit == 0
    with_links = (workplace / "mine.toml").read_bytes()
    (workplace / "mine.toml").unlink()
    linking(monkeypatch, number)
    assert tendon(*INIT).exit == 0
    assert (workplace / "mine.toml").read_bytes() == with_links
    assert [file.name for file in workplace.iterdir()] == ["mine.toml"]


@pytest.mark.parametrize("number", [None, *NO_LINKS])
def test_a_file_that_appears_while_a_starter_is_written_stays(tendon, workplace, monkeypatch, number):
    linking(monkeypatch, number, appears=BEFORE)
    assert tendon(*INIT).exit == 2
    assert (workplace / "mine.toml").read_bytes() == BEFORE
    assert [file.name for file in workplace.iterdir()] == ["mine.toml"]
