"""The journal may be cut off anywhere, and broken anywhere: the run still comes to the same bytes."""

import random
import shutil
import threading
from dataclasses import replace

import pytest

from tendon_cli.engine.folder import RunFolder
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.run import worked_out
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import Stopped
from tendon_cli.studies.load import load_study

from .tools import some

STUDY = """
[tendon]
pretension = ["60 N", "120 N", "180 N", "240 N"]
[motion]
direction = "flexion"
elbow_angle = "50 deg"
"""
PARTS = 4
CHUNKS = 12


@pytest.fixture
def folder(tmp_path, small_parts):
    """A run folder of four parts of one state each."""
    small_parts(1)
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    found = RunFolder(tmp_path / "run", Sweep(Plan(load_study(tmp_path / "study.toml"))))
    assert found.task.parts == PARTS
    return found


def advance(folder, stop_after=None):
    """Go on with a run; it is stopped after so many parts in all, or ends. Returns its record."""
    stop = threading.Event()

    def progress(done, _all):
        if stop_after is not None and done >= stop_after:
            stop.set()

    folder = replace(folder, task=replace(folder.task, stop=stop))
    with folder.locked():
        record, stands = worked_out(folder, jobs=1, progress=progress, resume=True)
        if not stands:
            folder.finish(record)
    return record, stands


def stopped(folder, parts):
    with pytest.raises(Stopped):
        advance(folder, parts)
    return (folder.path / "journal.jsonl").read_bytes()


@pytest.fixture
def whole(folder, hashes_in):
    """The bytes of an uninterrupted run."""
    advance(folder)
    found = hashes_in(folder.path)
    shutil.rmtree(folder.path)
    return found


def whole_lines(content):
    return max(0, content.count(b"\n") - 1)


def set_back(folder, content):
    """The folder as if the run had never been finished, with this as its journal."""
    (folder.path / "run.json").unlink(missing_ok=True)
    (folder.path / "journal.jsonl").write_bytes(content)


def assert_resumes_twice(folder, journal, cut, again, whole, hashes_in):
    """Cut the journal, go on for one part, cut the new journal, go on to the end."""
    set_back(folder, journal[:cut])
    known = whole_lines(journal[:cut])
    if known + 1 < PARTS:
        second = stopped(folder, known + 1)
        assert whole_lines(second) == known + 1
        kept = second[: int(again * (len(second) + 1))]
        set_back(folder, kept)
        known = whole_lines(kept)
    record, _ = advance(folder)
    assert record["resumed_parts"] == known, cut
    assert hashes_in(folder.path) == whole, cut
    assert not (folder.path / "journal.jsonl").exists()
    assert advance(folder)[1]


def test_a_journal_cut_at_sampled_bytes_resumes_twice(folder, whole, hashes_in):
    journal = stopped(folder, 3)
    chance = random.Random(6)  # noqa: S311 - a repeatable sample
    ends = [place for place, byte in enumerate(journal) if byte == ord("\n")]
    edges = [0, 1, 8, 9, len(journal), *(place + shift for place in ends for shift in (0, 1))]
    for cut in [*edges, *chance.sample(range(len(journal)), 25 - len(edges))]:
        assert_resumes_twice(folder, journal, cut, chance.random(), whole, hashes_in)


@pytest.mark.torture
@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_a_journal_cut_at_every_byte_resumes_twice(folder, whole, hashes_in, chunk):
    journal = stopped(folder, 3)
    chance = random.Random(chunk)  # noqa: S311 - a repeatable sample
    for cut in range(chunk, len(journal) + 1, CHUNKS):
        assert_resumes_twice(folder, journal, cut, chance.random(), whole, hashes_in)


def broken(journal, chance):
    """A journal with a flipped bit, a line twice, lines in another order, noise between or after them."""
    lines = journal.split(b"\n")[:-1]
    kind = chance.randrange(5)
    if kind == 0:
        content = bytearray(journal)
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        return bytes(content)
    if kind == 1:
        lines.insert(chance.randrange(1, len(lines) + 1), chance.choice(lines[1:]))
    elif kind == 2:
        lines[1:] = chance.sample(lines[1:], len(lines) - 1)
    elif kind == 3:
        lines.insert(chance.randrange(len(lines) + 1), chance.randbytes(chance.randrange(100)))
    else:
        return journal + bytes(chance.randrange(4096))  # as a power cut leaves a file that had been made longer
    return b"\n".join(lines) + b"\n"


@pytest.mark.parametrize("seed", some([0], range(1, 11)))
def test_a_broken_journal_still_resumes_to_the_same_bytes(folder, whole, hashes_in, seed):
    journal = stopped(folder, 3)
    chance = random.Random(seed)  # noqa: S311 - a repeatable sample
    for _ in range(20):
        content = broken(journal, chance)
        set_back(folder, content)
        advance(folder)
        assert hashes_in(folder.path) == whole, content
        assert advance(folder)[1]
