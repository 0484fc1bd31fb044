"""A run folder and all that may happen to it, each with what must be so afterwards."""

import errno
import fcntl
import functools
import json
import os
import shutil
import sys
import tempfile
import threading
import zlib
from contextlib import closing, contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from tendon_cli.answers import choices
from tendon_cli.answers.choices import Choices
from tendon_cli.engine import journal as journal_module
from tendon_cli.engine import plan
from tendon_cli.engine.run import How, run_task
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import Stopped, TendonError
from tendon_cli.studies.load import load_study
from tendon_cli.tables.digest import file_sha256

from .disk import ERRORS, Disk, Killed
from .hostile.breed import regrown
from .tools import QUESTION, temporary_files

STUDY = """
[tendon]
pretension = ["60 N", "120 N", "180 N", "240 N"]
[motion]
direction = "flexion"
elbow_angle = "50 deg"
"""
"""Four parts of one state each."""
VERBS = {"sweep": (Sweep, STUDY, "run.json"), "design": (Choices, QUESTION, "design.json")}
"""What carries it out, a study, its record."""
WAYS = ("", "resume", "overwrite")
PLACE, CHANCE = st.integers(0, 60), st.randoms(use_true_random=True)
FIGURE = "figure.png"
FAST = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # noqa: S108 - folders of random names
"""Where a flush costs nothing."""


def draw(_study, _folder, place, _record):
    """Stands in for figures, which are slow to draw."""
    (place / FIGURE).write_bytes(b"drawn")
    return [FIGURE], [], None


def outcome(record, _out, **more):
    return SimpleNamespace(record=record, **more)


# --- Harm -----------------------------------------------------------------------------------------


def delete(file, _chance):
    file.unlink()


def truncate(file, chance):
    os.truncate(file, chance.randrange(file.stat().st_size or 1))


def flip(file, chance):
    content = bytearray(file.read_bytes() or b"\0")
    content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    file.write_bytes(content)


def lengthen(file, chance):
    with file.open("ab") as end:
        end.write(chance.randbytes(chance.randrange(1, 600)))


def swap(file, _chance):
    """A whole part, but that of another table."""
    other = file.parents[1] / (
        "designs.parquet" if file.parent.name == "states.parquet" else "states.parquet"
    )
    file.write_bytes((other / file.name).read_bytes() if (other / file.name).exists() else b"")


HARMS = [delete, truncate, flip, lengthen, swap]


def broken(journal, chance):
    """A journal that is cut off, or has a flipped bit, a line twice, lines in another order, noise between or after."""
    lines = journal.split(b"\n")[:-1]
    match chance.randrange(6):
        case 0:
            return journal[: chance.randrange(len(journal) + 1)]
        case 1 if journal:
            content = bytearray(journal)
            content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
            return bytes(content)
        case 2 if len(lines) > 1:
            lines.insert(chance.randrange(1, len(lines) + 1), chance.choice(lines[1:]))
        case 3:
            lines[1:] = chance.sample(lines[1:], len(lines[1:]))
        case 4:
            lines.insert(chance.randrange(len(lines) + 1), chance.randbytes(chance.randrange(100)))
        case _:
            return journal + bytes(
                chance.randrange(4096)
            )  # as a power cut leaves a file that had been made longer
    return b"\n".join(lines) + b"\n"


def entries(content):
    """What the whole lines of a journal say."""
    pairs = (line.split(b" ", 1) for line in content.split(b"\n")[:-1] if b" " in line)
    return [json.loads(text) for crc, text in pairs if crc == b"%08x" % zlib.crc32(text)]


def has_header(known):
    return any("tables" in entry for entry in known)


# --- Why a run may be refused ---------------------------------------------------------------------


@contextmanager
def _held(folder, _patch):
    with (folder.run / ".lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield "wait for it"


def _without_locks(number):
    @contextmanager
    def obstacle(_folder, patch):
        def refused(*_arguments):
            raise OSError(number, os.strerror(number))

        patch.setattr(fcntl, "flock", refused)
        yield "--no-lock"

    return obstacle


@contextmanager
def _journal_is_forbidden(folder, patch):
    """The superuser may read everything, so it is injected."""
    read = journal_module.read_file

    def forbidden(path, most):
        if path == folder.journal:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return read(path, most)

    patch.setattr(journal_module, "read_file", forbidden)
    yield "make it a file"


NO_LOCKS = ("ENOLCK", "EOPNOTSUPP", "ENOSYS")
OBSTACLES = {"held": _held, "forbidden": _journal_is_forbidden} | {
    name: _without_locks(getattr(errno, name)) for name in NO_LOCKS
}


# --- The folder -----------------------------------------------------------------------------------


class Folder(RuleBasedStateMachine):
    """A run folder, and beside it files of a stranger that nobody may touch.

    Its runs are finished, stopped, killed, resumed, replaced, harmed, forged and refused.
    """

    home = None

    @classmethod
    def of(cls, name, *, is_first=False):
        """The folder of a verb, to be called step by step; `is_first` where its files are not known yet."""
        folder = cls()
        folder.begin(name, is_first=is_first)
        return folder

    @initialize(name=st.sampled_from(["sweep", "sweep", "design"]))
    def begin(self, name, *, is_first=False):
        (self.task, text, record), self.name, self.patch = VERBS[name], name, pytest.MonkeyPatch()
        for part in ("STATES_PER_PART", "STATES_PER_FILE", "DESIGNS_PER_PART"):
            self.patch.setattr(plan, part, 1)
        self.patch.setattr(choices, "CHOICES_PER_PART", 1)
        self.home = Path(tempfile.mkdtemp(dir=FAST))
        self.run, self.record = self.home / "run", self.home / "run" / record
        self.journal, self.stranger = self.run / "journal.jsonl", self.home / "stranger"
        self.stranger.mkdir()
        (self.home / "study.toml").write_text(text, encoding="utf-8")
        self.study = load_study(self.home / "study.toml")
        self.parts = self.task.of(self.study).parts
        self.forms = {} if is_first else forms_of(name)
        self.whole = {file: forms[-1] for file, forms in self.forms.items()}
        self.harmed, self.strangers, self.seen = set(), {}, []
        self.disk = Disk(self.patch, self.home)
        self.patch.setattr(
            sys, "unraisablehook", lambda _fault: None
        )  # what files say that a kill left open

    def close(self):
        self.disk.begin()
        self.patch.undo()
        shutil.rmtree(self.home)

    def teardown(self):
        if self.home is not None:
            with closing(self):
                if sys.exc_info()[0] is None:
                    self.finish()

    @property
    def finished(self):
        return self.record.exists()

    @property
    def hashes(self):
        return {
            str(file.relative_to(self.run)): file_sha256(file)
            for file in self.run.rglob("*.parquet")
            if file.is_file()
        }

    @property
    def damaged(self):
        """Files that are not as the run wrote them."""
        stand = {
            name: sha256
            for name, sha256 in self.hashes.items()
            if not (self.run / name).is_symlink()
        }
        return sorted(
            name
            for name, forms in self.forms.items()
            if stand.get(name) not in forms[-self.finished :]
        )

    @property
    def kept(self):
        """Parts that need not be made anew."""
        files, damaged, journal = self.task.of(self.study).files, {*self.damaged}, self.entries()
        known = (
            range(self.parts)
            if self.finished
            else {entry["part"] for entry in journal if "part" in entry}
        )
        return [index for index in known if damaged.isdisjoint(files(index).values())]

    def entries(self):
        return entries(self.journal.read_bytes()) if self.journal.exists() else []

    def times(self, parts):
        task = self.task.of(self.study)
        files = [self.run / name for index in parts for name in task.files(index).values()]
        return {file: file.stat().st_mtime_ns for file in files}

    @contextmanager
    def untouched(self):
        """Nothing is written, made or deleted meanwhile but the lock."""

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
        """What is so at any moment: what looks finished is, what stands is of this run, a stranger's is untouched."""
        hashes = self.hashes
        assert [
            name
            for name in hashes
            if name not in self.harmed and hashes[name] not in self.forms[name]
        ] == []
        assert not self.finished or self.harmed or hashes == self.whole
        assert {item.name for item in self.home.iterdir()} <= {"study.toml", "run", "stranger"}
        assert {file: file.read_bytes() for file in self.stranger.iterdir()} == self.strangers

    # --- What is done

    def carry_out(self, way="resume", *, lock=True, stop_after=None):
        """The outcome; stopped after so many parts. Raises TendonError or Killed."""
        stop = threading.Event()

        def progress(done, _all):
            if stop_after is not None and done >= stop_after:
                stop.set()

        ways = {"resume": way == "resume", "overwrite": way == "overwrite"}
        how = How(jobs=1, lock=lock, draw=draw, progress=progress, stop=stop, **ways)
        try:
            return run_task(self.task, outcome, self.study, self.run, how)
        finally:
            self.seen = self.disk.seen
            self.disk.begin()

    def ended(self, *words, **options):
        """The outcome, or the error."""
        try:
            return self.carry_out(*words, **options)
        except (TendonError, Stopped, Killed) as error:
            return error

    def assert_whole(self):
        self.harmed.clear()
        assert (self.finished, self.hashes) == (True, self.whole)
        assert not temporary_files(self.run)

    @rule(way=st.sampled_from(WAYS[1:]))
    def finish(self, way="resume", *, lock=True):
        """To the end: the same bytes, only what was not there is made; and once more: nothing at all is done."""
        was_finished, damaged, kept = self.finished, self.damaged, self.kept
        before = self.times(kept) if self.name == "sweep" or was_finished else {}
        record = self.carry_out(way, lock=lock).record
        self.assert_whole()
        assert ((self.run / FIGURE).exists(), was_finished or not self.journal.exists()) == (
            True,
            True,
        )
        if way == "resume":
            assert before == {file: file.stat().st_mtime_ns for file in before}
            assert not (was_finished and damaged) or sorted(record["repaired"]) == damaged
            assert was_finished or record["resumed_parts"] <= len(kept)
            assert was_finished or self.name == "design" or record["resumed_parts"] == len(kept)
        with self.untouched():
            assert self.carry_out(lock=lock).up_to_date

    @rule(error=st.sampled_from(NO_LOCKS))
    def finish_without_locks(self, error):
        with pytest.MonkeyPatch.context() as patch, OBSTACLES[error](self, patch):
            self.finish(lock=False)

    @rule()
    def ask_plainly(self):
        """Neither to resume nor to overwrite: a whole run is up to date, whatever else stands is refused and stays."""
        was_finished, damaged, drawn = self.finished, self.damaged, (self.run / FIGURE).exists()
        before = self.hashes
        ended = self.ended("")
        if isinstance(ended, TendonError):
            assert (ended.exit, "--resume" in ended.hint, self.hashes) == (7, True, before)
            assert damaged or not was_finished
        else:
            self.assert_whole()
            assert not (was_finished and damaged)
            assert ended.up_to_date == was_finished or not drawn

    @rule(parts=st.integers(0, 5))
    def stop(self, parts):
        if isinstance(self.ended(stop_after=parts), Stopped):
            assert temporary_files(self.run) == []
        else:
            self.assert_whole()

    # --- What happens to it

    @rule(
        at=PLACE,
        error=st.sampled_from([None, None, *ERRORS]),
        lasting=st.booleans(),
        way=st.sampled_from(WAYS[1:]),
    )
    def fail(self, at, error, *, lasting, way="resume"):
        """An operation of the disk fails: exit 5, or what is said to stand is whole; or the process is killed at it."""
        was_finished = self.finished
        self.disk.begin(at, error, lasting=lasting)
        ended = self.ended(way)
        if isinstance(ended, TendonError):
            assert (ended.exit, os.strerror(error or 0) in ended.message) == (5, True), ended
            assert not temporary_files(self.run)
            assert was_finished or not self.finished
        elif not isinstance(ended, Killed):
            self.assert_whole()

    @rule(parts=st.sets(st.integers(0, 5), min_size=1, max_size=3))
    def lose(self, parts):
        """Parts cannot be made: exit 6, all others are kept."""
        fill, lost = self.task.fill, {*parts} & {*range(self.parts)} - {*self.kept}

        def fails(task, tables, index):
            if index in parts:
                raise FloatingPointError("something odd")
            return fill(task, tables, index)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(self.task, "fill", fails)
            ended = self.ended()
        if isinstance(ended, TendonError):
            assert (ended.exit, "--resume" in ended.hint) == (6, True)
            assert any(f"part {part} (" in ended.message for part in parts)
            assert (
                self.name == "design"
                or f"{len(lost)} of {self.parts} parts failed" in ended.message
            )
            assert (
                self.finished or len(self.kept) == self.parts - len(lost) or self.name == "design"
            )
        else:
            assert not lost or self.name == "design"
            self.assert_whole()

    @rule(at=PLACE, how=st.sampled_from(HARMS), chance=CHANCE)
    def harm(self, at, how, chance):
        """A file is not any more as it was written."""
        files = sorted(self.run.glob("**/*.parquet"))
        files = [file for file in files if file.is_file() and not file.is_symlink()]
        if files and (not self.journal.exists() or has_header(self.entries())):
            file = files[at % len(files)]
            self.harmed.add(str(file.relative_to(self.run)))
            how(file, chance)

    @rule(at=PLACE)
    def link(self, at):
        """A part is moved to a stranger's folder, and a link put in its place."""
        files = [
            file for file in sorted(self.run.glob("*.parquet/*.parquet")) if not file.is_symlink()
        ]
        if files:
            file, elsewhere = files[at % len(files)], self.stranger / str(len(self.strangers))
            shutil.move(file, elsewhere)
            file.symlink_to(elsewhere)
            self.strangers[elsewhere] = elsewhere.read_bytes()

    @rule(chance=CHANCE)
    def break_journal(self, chance):
        """It may lose its header only while all else says whose it is: otherwise the folder is a stranger's."""
        before = self.journal.read_bytes() if self.journal.exists() else b""
        content = broken(before, chance)
        known = entries(content)
        is_known = len(known) > 0 or (has_header(self.entries()) and before.startswith(content))
        if (
            before
            and is_known
            and (has_header(known) or not (self.harmed or (self.run / FIGURE).exists()))
        ):
            self.journal.write_bytes(content)

    @rule(chance=CHANCE)
    def forge(self, chance):
        """Somebody changes what a journal says: one message, or a run that stands; never a bug."""
        lines = self.entries()
        if self.finished or not lines or self.name == "design":
            return  # notes of an answer's parts decide on its rows: forged ones give another answer
        before, at = self.journal.read_bytes(), chance.randrange(len(lines))
        whose = {key: lines[at].pop(key) for key in ("study", "study_hash") if key in lines[at]}
        forged = regrown(lines[at], chance)
        lines[at] = whose | forged if isinstance(forged, dict) else forged
        texts = (json.dumps(line).encode() for line in lines)
        self.journal.write_bytes(
            b"".join(b"%08x %s\n" % (zlib.crc32(text), text) for text in texts)
        )
        ended = self.ended()
        if isinstance(ended, TendonError):
            assert ended.exit in (5, 7)
        else:
            assert self.hashes == self.whole
        for file in (self.record, self.run / FIGURE) if self.finished else ():
            file.unlink()
        self.journal.write_bytes(before)

    @rule(why=st.sampled_from(sorted(OBSTACLES)), way=st.sampled_from(WAYS))
    def refuse(self, why, way):
        """Another run writes here, nothing can be locked, no journal can be read: exit 7, and nothing is touched."""
        self.run.mkdir(exist_ok=True)
        with (
            pytest.MonkeyPatch.context() as patch,
            OBSTACLES[why](self, patch) as hint,
            self.untouched(),
        ):
            error = self.ended(way)
            assert (error.exit, hint in error.hint, str(self.run) in error.where) == (7, True, True)


@functools.cache
def forms_of(name):
    """The hashes of every file that an undisturbed run puts in place, by name, in their order."""
    folder, forms, replace = Folder.of(name, is_first=True), {}, Path.replace

    def noted(source, target):
        if Path(target).suffix == ".parquet":
            forms.setdefault(str(Path(target).relative_to(folder.run)), []).append(
                file_sha256(source)
            )
        return replace(source, target)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Path, "replace", noted)
        folder.carry_out()
    folder.close()
    return forms
