"""A run.json or a journal that somebody changed ends in one message, or in a run that stands; never in a bug."""

import copy
import errno
import json
import os
import random

import pytest

from tendon_cli.engine import journal as journal_module
from tendon_cli.engine.journal import _line
from tendon_cli.errors import TendonError

from .test_journal import PARTS, advance, folder, stopped, whole  # noqa: F401 - fixtures
from .tools import some, study_in

VALUES = [None, True, -1, 0, 1.5, 10**9, 10**30, "", "x", "../../x", "/", [], {}, [[]], {"path": 1}]


def places(tree, path=()):
    """Every place in a JSON document."""
    yield path
    if isinstance(tree, dict | list):
        for key in tree if isinstance(tree, dict) else range(len(tree)):
            yield from places(tree[key], (*path, key))


def changed(tree, chance):
    """A document with one value exchanged, or one key taken away, outside of what says which study it is."""
    found = copy.deepcopy(tree)
    *above, last = chance.choice([path for path in places(tree) if path and path[0] not in ("study", "study_hash")])
    owner = found
    for key in above:
        owner = owner[key]
    if chance.random() < 0.3:
        del owner[last]
    else:
        owner[last] = copy.deepcopy(chance.choice(VALUES))
    return found


def end_of(folder):  # noqa: F811
    """What a resumed run ends in: nothing, an error with its code, or what would be called a bug."""
    try:
        advance(folder)
    except TendonError as error:
        return None if error.exit in (5, 7) else repr(error)
    except Exception as error:  # noqa: BLE001 - just what is looked for
        return f"{type(error).__name__}: {error}"
    return None


@pytest.mark.parametrize("seed", some([0], range(1, 6)))
def test_a_changed_record_is_no_bug(folder, whole, hashes_in, tmp_path, seed):  # noqa: F811
    advance(folder)
    record = json.loads((folder.path / "run.json").read_text("utf-8"))
    chance, faults = random.Random(seed), {}  # noqa: S311 - a repeatable sample
    for _ in range(150):
        content = changed(record, chance)
        (folder.path / "run.json").write_text(json.dumps(content), encoding="utf-8")
        fault = end_of(folder)
        if fault is not None:
            faults.setdefault(fault, [key for key in content if content[key] != record.get(key)])
        assert hashes_in(folder.path) == whole
        assert {item.name for item in tmp_path.iterdir()} == {"run", "study.toml"}
    assert faults == {}


@pytest.mark.parametrize("seed", some([0], range(1, 6)))
def test_a_changed_journal_is_no_bug(folder, whole, hashes_in, tmp_path, seed):  # noqa: F811
    entries = [json.loads(line.partition(b" ")[2]) for line in stopped(folder, PARTS - 1).splitlines()]
    chance, faults = random.Random(seed), {}  # noqa: S311 - a repeatable sample
    for _ in range(60):
        at = chance.randrange(len(entries))
        content = [changed(entry, chance) if index == at else entry for index, entry in enumerate(entries)]
        (folder.path / "run.json").unlink(missing_ok=True)
        (folder.path / "journal.jsonl").write_bytes(b"".join(map(_line, content)))
        fault = end_of(folder)
        if fault is not None:
            faults.setdefault(fault, content[at])
        elif (folder.path / "run.json").exists():
            assert hashes_in(folder.path) == whole
        assert {item.name for item in tmp_path.iterdir()} == {"run", "study.toml"}
    assert faults == {}


# --- A journal that cannot be read ------------------------------------------------------------------------------------


def a_folder(journal, _patch):
    """Where the journal should be."""
    journal.unlink()
    journal.mkdir()
    return "it is a folder, expected a file"


def forbidden(journal, patch):
    """The superuser may read everything, so it is injected."""
    read = journal_module.read_file

    def call(path, most):
        if path.name == journal.name:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return read(path, most)

    patch.setattr(journal_module, "read_file", call)
    return os.strerror(errno.EACCES)


@pytest.mark.parametrize("words", [(), ("--resume",), ("--overwrite",)], ids=" ".join)
@pytest.mark.parametrize("harm", [a_folder, forbidden])
@pytest.mark.parametrize("state", ["finished", "unfinished"])
def test_a_journal_that_cannot_be_read_is_named_and_nothing_is_touched(
    tendon, workplace, monkeypatch, hashes_in, state, harm, words
):
    study_in(workplace, "")
    sweep = ("sweep", "study.toml", "--out", "run", "--no-figures", *words)
    assert tendon(*sweep).exit == 0
    run, journal = workplace / "run", workplace / "run/journal.jsonl"
    journal.touch()
    if state == "unfinished":
        (run / "run.json").unlink()
    before = hashes_in(run), sorted(run.iterdir())
    reason = harm(journal, monkeypatch)
    ran = tendon(*sweep, "--json")
    error = ran.json["error"]
    assert (ran.exit, ran.err, error["exit"], error["kind"], error["where"]) == (
        7,
        "",
        7,
        "folder",
        "run/journal.jsonl",
    )
    assert error["message"] == f"cannot be read: {reason}"
    ran = tendon(*sweep)
    assert (ran.exit, ran.out) == (7, "")
    assert ran.err == f"tendon: error: run/journal.jsonl: cannot be read: {reason}\n  hint: {error['hint']}\n"
    assert (hashes_in(run), sorted(run.iterdir())) == before
