"""A run folder and all that may happen to it, each with what must hold afterwards."""

import errno
import fcntl
import functools
import os
import shutil
import sys
import tempfile
import threading
from contextlib import closing, contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from tendon_cli.answers import choices
from tendon_cli.answers.choices import Choices
from tendon_cli.engine import plan
from tendon_cli.engine.folder import RunFolder
from tendon_cli.engine.run import RunOptions, run_task
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import Stopped, TendonError
from tendon_cli.studies.load import load_study
from tendon_cli.tables.digest import file_sha256
from tendon_cli.tables.footer import read_footer

from .disk import ERRORS, Disk, Killed
from .hostile.breed import stamped
from .runs import QUESTION, temporary_files

STUDY = """
[tendon]
pretension = ["60 N", "120 N", "180 N", "240 N"]
[motion]
direction = "flexion"
elbow_angle = "50 deg"
"""
"""Four parts of one state each."""
VERBS = {"sweep": (Sweep, STUDY, "run.json"), "design": (Choices, QUESTION, "design.json")}
"""Task, study and name of the record, by command."""
MODES = ("", "resume", "overwrite")
NUMBER = st.integers(0, 60)
"""Number of an operation, or of a file."""
RNG = st.randoms(use_true_random=True)
FIGURE = "figure.svg"
MEMORY = "/dev/shm"  # noqa: S108 - folders of random names
FAST = MEMORY if os.access(MEMORY, os.W_OK) else None
"""Folder in which a flush costs nothing."""


def draw(study, _folder, place, _record):
    """Write a stand-in for figures, which are slow to draw."""
    source = f"<dc:source>tendon study {study.name} {study.hash}</dc:source>"
    figure = f"<svg><metadata>{source}</metadata></svg>"
    (place / FIGURE).write_text(figure, encoding="utf-8")
    return [FIGURE], [], None


def outcome(record, _out, **more):
    return SimpleNamespace(record=record, **more)


# --- Harm -----------------------------------------------------------------------------------------


def delete(file, _rng):
    file.unlink()


def truncate(file, rng):
    os.truncate(file, rng.randrange(file.stat().st_size or 1))


def flip(file, rng):
    content = bytearray(file.read_bytes() or b"\0")
    content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    file.write_bytes(content)


def lengthen(file, rng):
    with file.open("ab") as end:
        end.write(rng.randbytes(rng.randrange(1, 600)))


def swap(file, _rng):
    """Put the same part of another table in its place, or nothing if that table has none."""
    other_table = "designs.parquet" if file.parent.name == "states.parquet" else "states.parquet"
    other = file.parents[1] / other_table / file.name
    file.write_bytes(other.read_bytes() if other.exists() else b"")


HARMS = [delete, truncate, flip, lengthen, swap]


# --- Reasons to refuse a run ----------------------------------------------------------------------
# Each obstacle yields a piece of the hint that the refusal gives.


@contextmanager
def _held(folder, _patch):
    with (folder.run / ".lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield "wait for it"


@contextmanager
def _has_a_journal(folder, _patch):
    """Leave what tendon 0.3.0 left of an unfinished run."""
    if folder.is_finished:
        yield None
        return
    journal = folder.run / "journal.jsonl"
    journal.write_text("{}", encoding="utf-8")
    yield "tendon 0.3.0"
    journal.unlink()


@contextmanager
def _has_a_strangers_table(folder, _patch):
    """Leave a file of a stranger at the place of a part."""
    place = folder.run / "conditions.parquet"
    if folder.name == "sweep":
        place = folder.run / "states.parquet/part-00000.parquet"
    if folder.is_finished or os.path.lexists(place):
        yield None
        return
    place.parent.mkdir(exist_ok=True)
    place.write_bytes(b"years of work")
    yield ""
    place.unlink()


NO_LOCKS = ("ENOLCK", "EOPNOTSUPP", "ENOSYS")
OBSTACLES = {"held": _held, "journal": _has_a_journal, "stranger": _has_a_strangers_table}


# --- The folder -----------------------------------------------------------------------------------


class Folder(RuleBasedStateMachine):
    """A run folder, and beside it files of a stranger that nobody may touch.

    Its runs are finished, stopped, killed, resumed, replaced, harmed, forged and refused.
    """

    home = None

    @classmethod
    def of(cls, name, *, is_first=False):
        """Return the folder of a command, to be called step by step.

        `is_first` says that the hashes of its files are not known yet.
        """
        folder = cls()
        folder.begin(name, is_first=is_first)
        return folder

    @initialize(name=st.sampled_from(["sweep", "sweep", "design"]))
    def begin(self, name, *, is_first=False):
        self.name = name
        self.task, text, record = VERBS[name]
        self.patch = pytest.MonkeyPatch()
        for part in ("STATES_PER_PART", "STATES_PER_FILE", "DESIGNS_PER_PART"):
            self.patch.setattr(plan, part, 1)
        self.patch.setattr(choices, "CHOICES_PER_PART", 1)
        # Files that a kill left open raise where nobody can catch it.
        self.patch.setattr(sys, "unraisablehook", lambda _fault: None)

        self.home = Path(tempfile.mkdtemp(dir=FAST))
        self.run = self.home / "run"
        self.record = self.run / record
        self.stranger = self.home / "stranger"
        self.stranger.mkdir()
        study = self.home / "study.toml"
        study.write_text(text, encoding="utf-8")
        self.study = load_study(study)
        self.parts = self.task.of(self.study).parts

        self.whole, self.unfinished = ({}, {}) if is_first else whole_of(name)
        self.harmed = set()
        self.strangers = {}
        self.operations = []
        self.disk = Disk(self.patch, self.home)

    def close(self):
        self.disk.reset()
        self.patch.undo()
        shutil.rmtree(self.home)

    def teardown(self):
        if self.home is not None:
            with closing(self):
                if sys.exc_info()[0] is None:
                    self.finish()

    @property
    def is_finished(self):
        return self.record.exists()

    @property
    def has_figure(self):
        return (self.run / FIGURE).exists()

    @property
    def hashes(self):
        """SHA-256 of every table file, by its name in the run folder."""
        return {
            str(file.relative_to(self.run)): file_sha256(file)
            for file in self.run.rglob("*.parquet")
            if file.is_file()
        }

    @property
    def damaged(self):
        """Names of files that are not as the run wrote them.

        The parts of an unfinished run are among them until it is finished.
        """
        hashes = {
            name: sha256
            for name, sha256 in self.hashes.items()
            if not (self.run / name).is_symlink()
        }
        expected = self.whole if self.is_finished else {**self.whole, **self.unfinished}
        return sorted(name for name, sha256 in expected.items() if hashes.get(name) != sha256)

    def files_of(self, part):
        """Return the files without which a part has to be made anew."""
        task = self.task.of(self.study)
        return task.needed_by(part) if self.is_finished else {*task.files(part).values()}

    @property
    def intact_parts(self):
        """Parts that need not be made anew."""
        damaged = {*self.damaged}
        return [index for index in range(self.parts) if damaged.isdisjoint(self.files_of(index))]

    @property
    def unknown(self):
        """Files among the tables that no longer say what they are of."""
        return [
            file
            for file in self.run.rglob("*.parquet")
            if file.is_file() and not self.says_its_run(file)
        ]

    def says_its_run(self, file):
        """Return True if a file says that it is of this run."""
        footer = read_footer(file)
        origin = None if footer is None else footer.origin
        return origin is not None and origin.run == self.task.of(self.study).run

    def modification_times(self, parts):
        """Return the time at which each file of some parts was written, in ns."""
        needed = {name for index in parts for name in self.files_of(index)}
        return {self.run / name: (self.run / name).stat().st_mtime_ns for name in needed}

    @contextmanager
    def untouched(self):
        """Check that nothing but the lock is written, made or deleted meanwhile."""

        def everything():
            files = (
                file for file in self.home.rglob("*") if file.name != ".lock" and not file.is_dir()
            )
            return {file: (file.lstat().st_mtime_ns, file.read_bytes()) for file in files}

        before = everything()
        yield
        assert everything() == before

    @invariant()
    def check(self):
        """Check what holds at any moment.

        A run that looks finished is finished, every table is of this run, and the files of the
        stranger are untouched.
        """
        hashes = self.hashes
        expected = {**self.whole, **self.unfinished}
        foreign = [
            name for name in hashes if name not in self.harmed and hashes[name] != expected[name]
        ]
        assert foreign == []
        if self.is_finished and not self.harmed:
            # A kill may leave parts that are not needed any more.
            assert {name: hashes.get(name) for name in self.whole} == self.whole
        assert {item.name for item in self.home.iterdir()} <= {"study.toml", "run", "stranger"}
        assert {file: file.read_bytes() for file in self.stranger.iterdir()} == self.strangers

    # --- Runs

    def carry_out(self, mode="resume", *, stop_after=None):
        """Run the study and return the outcome.

        Args:
            mode: One of `MODES`.
            stop_after: Number of parts after which the run is stopped.

        Raises:
            TendonError: The run failed or was refused.
            Stopped: The run was stopped.
            Killed: The process was killed.
        """
        stop = threading.Event()

        def progress(done, _all):
            if stop_after is not None and done >= stop_after:
                stop.set()

        how = RunOptions(
            jobs=1,
            draw=draw,
            progress=progress,
            stop=stop,
            resume=mode == "resume",
            overwrite=mode == "overwrite",
        )
        try:
            return run_task(self.task, outcome, self.study, self.run, how)
        finally:
            self.operations = self.disk.operations
            self.disk.reset()

    def attempt(self, *arguments, **options):
        """Run the study as `carry_out` does, and return the outcome or the error."""
        try:
            return self.carry_out(*arguments, **options)
        except (TendonError, Stopped, Killed) as error:
            return error

    def assert_whole(self):
        self.harmed.clear()
        assert self.is_finished
        assert self.hashes == self.whole
        assert not temporary_files(self.run)

    def set_aside_unknown(self):
        """Set files aside that no longer say whose they are; until then they are no run's.

        Only the record of a finished run knows them by name.
        """
        if self.is_finished or not self.unknown:
            return
        for mode in ("", "resume"):
            with self.untouched():
                assert self.attempt(mode).exit == 7
        for file in self.unknown:
            file.unlink()

    @rule(mode=st.sampled_from(MODES[1:]))
    def finish(self, mode="resume"):
        """Run to the end: the bytes are the same, and only what was missing is made.

        Once more, and nothing at all is done.
        """
        self.set_aside_unknown()
        was_finished = self.is_finished
        damaged = self.damaged
        intact = self.intact_parts
        before = self.modification_times(intact)
        record = self.carry_out(mode).record
        self.assert_whole()
        assert self.has_figure
        if mode == "resume":
            after = {file: file.stat().st_mtime_ns for file in before if file.exists()}
            assert {file: before[file] for file in after} == after
            lost = before.keys() - after.keys()
            assert {str(file.relative_to(self.run)) for file in lost} <= {*self.unfinished}
            if was_finished and damaged:
                assert sorted(record["repaired"]) == damaged
            if not was_finished:
                assert record["resumed_parts"] == len(intact)
        with self.untouched():
            assert self.carry_out().up_to_date

    @rule(error=st.sampled_from(NO_LOCKS))
    def finish_without_locks(self, error):
        def refused(*_arguments):
            raise OSError(getattr(errno, error), error)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(fcntl, "flock", refused)
            self.finish()

    @rule()
    def ask_plainly(self):
        """Run without resuming or overwriting.

        A whole run is up to date; anything else that stands there is refused and stays.
        """
        self.set_aside_unknown()
        was_finished = self.is_finished
        damaged = self.damaged
        had_figure = self.has_figure
        before = self.hashes
        result = self.attempt("")
        if isinstance(result, TendonError):
            assert result.exit == 7
            assert "--resume" in result.hint
            assert self.hashes == before
            assert damaged or not was_finished
        else:
            self.assert_whole()
            assert not (was_finished and damaged)
            assert result.up_to_date == was_finished or not had_figure

    @rule(parts=st.integers(0, 5))
    def stop(self, parts):
        self.set_aside_unknown()
        result = self.attempt(stop_after=parts)
        if isinstance(result, Stopped):
            assert temporary_files(self.run) == []
        else:
            self.assert_whole()

    # --- Accidents

    @rule(
        at=NUMBER,
        error=st.sampled_from([None, None, *ERRORS]),
        lasting=st.booleans(),
        mode=st.sampled_from(MODES[1:]),
    )
    def fail(self, at, error, *, lasting, mode="resume"):
        """Let an operation of the disk fail, or kill the process at it.

        A failure is exit 5, or the run is whole. What a killed process left may stay.
        """
        self.set_aside_unknown()
        was_finished = self.is_finished
        left_before = temporary_files(self.run)
        self.disk.reset(at, error, lasting=lasting)
        result = self.attempt(mode)
        if isinstance(result, TendonError):
            assert result.exit == 5, result
            assert os.strerror(error or 0) in result.message, result
            assert {*temporary_files(self.run)} <= {*left_before}
            assert was_finished or not self.is_finished
        elif not isinstance(result, Killed):
            self.assert_whole()

    @rule(parts=st.sets(st.integers(0, 5), min_size=1, max_size=3))
    def lose(self, parts):
        """Let some parts fail: exit 6, and all others are kept."""
        self.set_aside_unknown()
        fill = self.task.fill
        lost = {*parts} & {*range(self.parts)} - {*self.intact_parts}

        def fail_for_some(task, tables, index):
            if index in parts:
                raise FloatingPointError("something odd")
            return fill(task, tables, index)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(self.task, "fill", fail_for_some)
            result = self.attempt()
        if isinstance(result, TendonError):
            assert result.exit == 6
            assert "--resume" in result.hint
            assert any(f"part {part} (" in result.message for part in parts)
            assert f"{len(lost)} of {self.parts} parts failed" in result.message
            if not self.is_finished:
                assert len(self.intact_parts) == self.parts - len(lost)
        else:
            assert not lost
            self.assert_whole()

    @rule(at=NUMBER, how=st.sampled_from(HARMS), rng=RNG)
    def harm(self, at, how, rng):
        """Change a table file so that it is no longer as it was written."""
        files = sorted(self.run.glob("**/*.parquet"))
        files = [file for file in files if file.is_file() and not file.is_symlink()]
        if files:
            file = files[at % len(files)]
            self.harmed.add(str(file.relative_to(self.run)))
            how(file, rng)

    @rule(at=NUMBER)
    def link(self, at):
        """Move a part to a stranger's folder, and put a link in its place."""
        files = sorted(self.run.glob("*.parquet/*.parquet"))
        files = [file for file in files if not file.is_symlink()]
        if files:
            file = files[at % len(files)]
            elsewhere = self.stranger / str(len(self.strangers))
            shutil.move(file, elsewhere)
            file.symlink_to(elsewhere)
            self.strangers[elsewhere] = elsewhere.read_bytes()

    @rule(at=NUMBER, rng=RNG)
    def forge(self, at, rng):
        """Change a part's note, with the right digest: one message or the same bytes, no bug."""
        self.set_aside_unknown()
        files = sorted(self.run.glob("*.parquet/*.parquet"))
        files = [file for file in files if not file.is_symlink()]
        if self.is_finished or not files or self.name == "design":
            return  # notes of an answer's parts decide on its rows: forged ones give another answer
        file = files[at % len(files)]
        before = file.read_bytes()
        if b"tendon.note" not in before:
            return  # the harm of before
        content = bytearray(before)
        start = before.index(b"{", before.index(b"tendon.note"))
        stop = before.index(b"}}", start) if b"}}" in before[start:] else start + 20
        content[rng.randrange(start, stop)] = rng.choice(b'0123456789"{}[],:-ex')
        file.write_bytes(stamped(bytes(content)))
        result = self.attempt()
        if isinstance(result, TendonError):
            assert result.exit in (5, 7)
        else:
            hashes = self.hashes
            name = str(file.relative_to(self.run))
            assert {**hashes, name: ""} == {**self.whole, name: ""}
        if self.is_finished:
            self.record.unlink()
            (self.run / FIGURE).unlink()
        file.write_bytes(before)

    @rule(why=st.sampled_from(sorted(OBSTACLES)), mode=st.sampled_from(MODES))
    def refuse(self, why, mode):
        """Run while another run writes here, or another's file is in the way.

        This is exit 7, and nothing is touched.
        """
        self.run.mkdir(exist_ok=True)
        with (
            pytest.MonkeyPatch.context() as patch,
            OBSTACLES[why](self, patch) as hint,
            self.untouched(),
        ):
            if hint is None:
                return
            error = self.attempt(mode)
            assert error.exit == 7
            assert hint in error.hint
            assert str(self.run) in error.where


@functools.cache
def whole_of(name):
    """Return the hashes of a run that nobody disturbs, and of the parts that go at its end.

    Each file is put in place once.
    """
    folder = Folder.of(name, is_first=True)
    placed = []
    replace = Path.replace

    def replace_and_note(source, target):
        placed.append(Path(target))
        return replace(source, target)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Path, "replace", replace_and_note)
        with patch.context() as keeping:
            keeping.setattr(RunFolder, "drop_unfinished", lambda _folder: None)
            folder.carry_out()
    assert len(placed) == len({*placed})
    everything = folder.hashes
    assert folder.carry_out().up_to_date
    whole = folder.hashes
    folder.close()
    gone = everything.keys() - whole.keys()
    assert gone == folder.task.of(folder.study).unfinished
    return whole, {name: everything[name] for name in gone}
