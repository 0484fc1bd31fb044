"""An error at any open, write, flush, rename or making of a folder: exit 5, what stood before stays, resumable."""

import errno
import io
import json
import os
import random
import shutil
import stat
from dataclasses import replace
from pathlib import Path

import pytest

from tendon_cli import cli
from tendon_cli import files as files_module
from tendon_cli.engine import run as run_module
from tendon_cli.engine.run import worked_out
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import OutputError

from .test_journal import folder, stopped, whole  # noqa: F401 - fixtures
from .tools import STATES, SWEEP, launched, some, temporary_files


class FaultyFile(io.FileIO):
    """A file whose writes are counted, and fail when it is their turn, after half of what was asked."""

    def __init__(self, name, mode, faults):
        super().__init__(name, mode)
        self.faults = faults

    def write(self, data):
        try:
            self.faults.meet("write", self.name)
        except OSError:
            if len(data) > 1:
                super().write(memoryview(data)[: len(data) // 2])
            raise
        return super().write(data)


class Faults:
    """Every write, flush, rename, making and opening of a file goes by here, and one of them fails."""

    def __init__(self, patch, below):
        self.below = str(below)
        self.seen = []
        self.fail_at = None
        self.lasting = False
        self.number = errno.ENOSPC
        fsync, replace, mkdir, path_open = os.fsync, Path.replace, Path.mkdir, Path.open

        def open_(path, mode="r", buffering=-1, **options):
            if "b" not in mode or mode == "rb" or not str(path).startswith(self.below):
                return path_open(path, mode, buffering, **options)
            self.meet("open", path)
            raw = FaultyFile(path, mode.replace("b", ""), self)
            return io.BufferedWriter(raw, buffering if buffering > 0 else io.DEFAULT_BUFFER_SIZE)

        def guarded_fsync(handle):
            is_folder = stat.S_ISDIR(os.fstat(handle).st_mode)
            self.meet("fsync folder" if is_folder else "fsync file", handle)
            return fsync(handle)

        def guarded(kind, real):
            def call(first, *rest, **options):
                self.meet(kind, first)
                return real(first, *rest, **options)

            return call

        patch.setattr(Path, "open", open_)
        patch.setattr(os, "fsync", guarded_fsync)
        patch.setattr(Path, "replace", guarded("rename", replace))
        patch.setattr(Path, "mkdir", guarded("mkdir", mkdir))

    def meet(self, kind, name):
        self.seen.append((kind, str(name)))
        at = len(self.seen) - 1
        if self.fail_at is not None and (at == self.fail_at or (self.lasting and at > self.fail_at)):
            raise OSError(self.number, os.strerror(self.number))

    def begin(self, fail_at=None, *, lasting=False, number=errno.ENOSPC):
        self.seen, self.fail_at, self.lasting, self.number = [], fail_at, lasting, number


@pytest.fixture
def faults(monkeypatch, tmp_path, muttered):
    return Faults(monkeypatch, tmp_path)


def finish(folder):  # noqa: F811
    with folder.locked():
        record, stands = worked_out(replace(folder, task=Sweep(folder.task.plan)), jobs=1, resume=True)
        if not stands:
            folder.finish(record)


def operations(folder, faults):  # noqa: F811
    """How many operations a run has."""
    faults.begin()
    finish(folder)
    count = len(faults.seen)
    kinds = {kind for kind, _ in faults.seen}
    assert kinds == {"open", "write", "fsync file", "fsync folder", "rename", "mkdir"}
    shutil.rmtree(folder.path)
    return count


def error_of(folder):  # noqa: F811
    """What a run ends in."""
    try:
        finish(folder)
    except OutputError as error:
        return error
    return None


CHOICES = [
    (lasting, number)
    for lasting in (False, True)
    for number in (errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EROFS, errno.EACCES)
]


def assert_survives(folder, faults, whole, hashes_in, at, lasting, number):  # noqa: F811
    faults.begin(at, lasting=lasting, number=number)
    error = error_of(folder)
    if faults.seen[at][0] == "fsync folder" and not lasting:
        assert error is None, "where a system cannot flush a folder, the run goes on"
    else:
        assert error is not None or at > len(faults.seen) - 4, faults.seen[at]
    if error is not None:
        assert (error.exit, os.strerror(number) in error.message) == (5, True)
        assert not (folder.path / "run.json").exists()
        assert hashes_in(folder.path).items() <= whole.items()
    assert not temporary_files(folder.path), faults.seen[at]
    faults.begin()
    finish(folder)
    assert hashes_in(folder.path) == whole, at
    assert (folder.path / "run.json").exists()
    assert not temporary_files(folder.path)
    shutil.rmtree(folder.path)


def test_an_error_at_a_sample_of_operations_is_exit_5(folder, whole, faults, hashes_in):  # noqa: F811
    count, chance = operations(folder, faults), random.Random(3)  # noqa: S311 - a repeatable sample
    for at in sorted(chance.sample(range(count), 25)):
        assert_survives(folder, faults, whole, hashes_in, at, *chance.choice(CHOICES))


@pytest.mark.torture
@pytest.mark.parametrize(("lasting", "number"), CHOICES)
def test_an_error_at_every_operation_is_exit_5(folder, whole, faults, hashes_in, lasting, number):  # noqa: F811
    for at in range(operations(folder, faults)):
        assert_survives(folder, faults, whole, hashes_in, at, lasting, number)


def test_an_error_while_a_finished_run_is_repaired_leaves_the_rest(folder, whole, faults, hashes_in):  # noqa: F811
    finish(folder)
    victim = folder.path / "states.parquet/part-00001.parquet"
    chance = random.Random(4)  # noqa: S311 - a repeatable sample
    for at in range(2, 14):
        victim.write_bytes(b"damaged")
        before = {name: found for name, found in hashes_in(folder.path).items() if not name.endswith("00001.parquet")}
        faults.begin(at, lasting=chance.random() < 0.5)
        error_of(folder)
        assert before.items() <= hashes_in(folder.path).items()
        assert not temporary_files(folder.path)
        faults.begin()
        finish(folder)
        assert hashes_in(folder.path) == whole


@pytest.mark.parametrize("kind", some(["write"], ["open", "fsync file", "rename"]))
@pytest.mark.parametrize("name", ["slack_map.png", "run.json", "journal.jsonl"])
def test_an_error_with_a_record_is_exit_5_and_with_a_figure_a_warning(
    tendon, place, uninterrupted, monkeypatch, small_parts, kind, name, hashes_in
):
    small_parts(STATES)
    words = ("sweep", place / "study.toml", "--out", place / "run", "--json", "--jobs", "1")
    with monkeypatch.context() as patch:
        faults = Faults(patch, place / "run")
        named = files_module.temporary_of
        patch.setattr(
            files_module, "temporary_of", lambda path, **how: named(path, **how).with_suffix(f".{path.name}.tmp")
        )

        def meet(operation, where):
            faults.seen.append((operation, str(where)))
            if operation == kind and (name in str(where) or (kind == "fsync file" and name in faults.seen[-2][1])):
                raise OSError(errno.EIO, os.strerror(errno.EIO))

        faults.meet = meet
        ran = tendon(*words)
    if name == "slack_map.png":
        assert ran.exit == 0
        assert any(os.strerror(errno.EIO) in warning for warning in ran.json["warnings"])
    else:
        assert (ran.exit, ran.json["error"]["kind"], ran.err) == (5, "output", "")
        assert not (place / "run/run.json").exists()
    assert not (place / "run" / name).exists() or name == "journal.jsonl"
    assert not temporary_files(place / "run")
    again = tendon(*words, "--resume")
    assert again.exit == 0
    assert hashes_in(place / "run") == uninterrupted
    assert (place / "run/slack_map.png").exists()


def test_a_figure_that_cannot_be_replaced_stays(tendon, place, monkeypatch, small_parts):
    small_parts(STATES)
    tendon("sweep", place / "study.toml", "--out", place / "run", "--no-figures")
    figure = place / "figure.png"
    words = ("plot", place / "run", "--table", "designs", "--out", figure, "--json")
    assert tendon(*words).exit == 0
    before = figure.read_bytes()
    for number in (errno.ENOSPC, errno.EIO):
        with monkeypatch.context() as patch:
            faults = Faults(patch, place)
            faults.begin(1, lasting=True, number=number)
            ran = tendon(*words)
        assert (ran.exit, figure.read_bytes() == before) == (5, True)
        assert not temporary_files(place)


def test_the_modules_that_write_go_by_the_faults(monkeypatch, tmp_path):
    """What the injection rests on."""
    faults = Faults(monkeypatch, tmp_path)
    from tendon_cli.files import write_whole

    write_whole(tmp_path / "a", b"x")
    assert [kind for kind, _ in faults.seen] == ["open", "write", "fsync file", "rename", "fsync folder"]
    assert run_module.worked_out is worked_out
    assert cli.main


def test_a_journal_that_cannot_be_written_is_one_message_with_several_jobs(place):
    code, out, said = launched(place, {"states": STATES, "fail": "journal"}, *SWEEP, "--json")
    assert (code, json.loads(out)["error"]["kind"]) == (5, "output")
    assert not (place / "run/run.json").exists()
    assert said == ""
