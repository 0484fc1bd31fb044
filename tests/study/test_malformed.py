"""A malformed study of any kind ends in one error that says what is wrong and where.

It does so soon, and without a trace.
"""

import os
import resource
from pathlib import Path

import pytest

from tendon_cli.errors import InputError, SizeError, StudyError, TendonError, UsageError
from tendon_cli.studies.load import load_study
from tests.sampled import check_all

from .malformed import ROWS
from .malformed.row import LONGEST_TIME, at_most

MOST_MEMORY_KB = 300_000
LONGEST_MESSAGE = 4000
EXIT_CODES = {StudyError: 2, UsageError: 2, SizeError: 2, InputError: 3}
WORDS_OF_PYTHON = (
    "Traceback",
    "pydantic",
    "validation",
    "<class",
    "loc=",
    "function-",
    "[Errno",
    "object at 0x",
    "sys.",
    "None",
    "True",
    "False",
    "('",
    "{'",
    "['",
)


def peak_memory():
    """Return the largest memory that this process has had, kB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def as_bytes(text):
    return text if isinstance(text, bytes) else text.encode()


def write_files(row, folder):
    """Write the files of a malformed study into a folder and return the path of the study."""
    for name, text in row.files.items():
        (folder / name).write_bytes(as_bytes(text))
    path = folder / f"{row.stem}{row.suffix}"
    path.write_bytes(as_bytes(row.text))
    return path


def content_of(folder):
    """Return the bytes of every file in a folder by its name."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_malformed_study_ends_in_one_error_that_says_what_and_where(tmp_path):
    def check(row):
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        folder.mkdir()
        path = write_files(row, folder)
        content = content_of(folder)
        memory = peak_memory()
        with at_most(LONGEST_TIME), pytest.raises(TendonError) as caught:
            load_study(path, row.settings)
        error = caught.value
        assert peak_memory() - memory < MOST_MEMORY_KB
        assert type(error) is row.kind
        assert error.exit == EXIT_CODES[row.kind]
        assert content_of(folder) == content
        message = f"{error} {error.where}"
        assert [fragment for fragment in row.says if fragment not in message] == []
        if row.line is not None:
            assert error.faults[0].line == row.line
            assert f"line {row.line}: " in str(error)
        source = as_bytes(row.text).decode(errors="replace")
        foreign = [word for word in WORDS_OF_PYTHON if word not in source]
        for text in (str(error), error.where, error.hint or ""):
            assert len(text) < LONGEST_MESSAGE
            assert all(line.isprintable() for line in text.split("\n"))
            assert [word for word in foreign if word in text] == []

    check_all(check, [(row,) for row in ROWS])


# --- Files that are not there or cannot be read ---------------------------------------------------


def test_a_missing_file_is_named_with_what_lies_beside_it(tmp_path):
    (tmp_path / "fig07.toml").write_text("")
    with pytest.raises(StudyError, match="no such file") as caught:
        load_study(tmp_path / "fig08.toml")
    assert caught.value.hint is not None
    assert "fig07.toml" in caught.value.hint
    assert "fig08.toml" in caught.value.where
    with pytest.raises(StudyError, match="no such file"):
        load_study(tmp_path / "nowhere" / "study.toml")


def test_a_folder_is_not_a_study(tmp_path):
    with pytest.raises(StudyError, match="folder"):
        load_study(tmp_path)


@pytest.mark.parametrize(("name", "problem"), [("a" * 5000, "too long"), ("a\0b", "NUL")])
def test_a_file_name_that_cannot_be_is_one_fault(tmp_path, name, problem):
    with pytest.raises(UsageError, match=problem):
        load_study(tmp_path / f"{name}.toml")


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root can read every file")
def test_an_unreadable_file_is_one_fault(tmp_path):
    path = tmp_path / "study.toml"
    path.touch(mode=0o000)
    with pytest.raises(StudyError, match="cannot be read"):
        load_study(path)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="there is no endless file here")
@pytest.mark.parametrize("key", [None, "path", "friction_from"])
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_nothing_that_never_ends_is_waited_for_or_read(tmp_path, key, kind):
    endless = tmp_path / "endless.toml"
    if kind == "pipe":
        os.mkfifo(endless)
    else:
        endless.symlink_to("/dev/zero")
    if key is None:
        path = endless
        expected = ("", None)
    else:
        path = tmp_path / "study.toml"
        path.write_text(f"[sheath]\n{key} = 'endless.toml'\n")
        expected = (f"sheath.{key}", 2)
    problem = f"it is a {kind}, expected a file"
    with at_most(LONGEST_TIME), pytest.raises(StudyError, match=problem) as caught:
        load_study(path)
    assert [(fault.key, fault.line) for fault in caught.value.faults] == [expected]


@pytest.mark.parametrize("suffix", [".toml", ".yaml", ".txt"])
def test_an_empty_file_is_the_baseline(tmp_path, suffix):
    path = tmp_path / f"empty{suffix}"
    path.touch()
    assert load_study(path).name == "empty"


HOSTILE = "a\x1b[31m\x9b2J\r\u202e"


def is_printable(error):
    """Return True if no part of an error has a character that a terminal would obey."""
    parts = [str(error), error.where, error.hint]
    texts = [part.replace("\n", "") for part in parts if part is not None]
    return all(text.isprintable() for text in texts)


@pytest.mark.parametrize("name", [f"{HOSTILE}.toml", f"{HOSTILE}.yaml", os.fsdecode(b"a\xff.toml")])
@pytest.mark.parametrize(
    "text", [None, "colour = 3", "\x1b[31m = 3", "[sheath]\npath = 'r\\u001b.csv'\n"]
)
def test_names_of_files_come_out_harmless(tmp_path, name, text):
    (tmp_path / f"other{HOSTILE}.toml").touch()
    path = tmp_path / name
    if text is not None:
        path.write_text(text)
    with pytest.raises(StudyError) as caught:
        load_study(path)
    assert is_printable(caught.value)


@pytest.mark.parametrize("content", ["", "x,y,z\n\x1b[31m,0,0\n", "x,y,\x1b[2J\n"])
@pytest.mark.parametrize("key", ["path", "friction_from"])
def test_names_and_lines_of_named_files_come_out_harmless(tmp_path, key, content):
    (tmp_path / HOSTILE).write_text(content)
    path = tmp_path / "study.yaml"
    path.write_text(f'sheath: {{ {key}: "a\\x1b[31m\\x9b2J\\r\\u202e" }}\n')
    with pytest.raises(InputError) as caught:
        load_study(path)
    assert is_printable(caught.value)


# --- Nothing is ever executed, and little is needed -----------------------------------------------


def test_nothing_that_a_study_says_is_executed(tmp_path):
    trace = tmp_path / "trace"
    yaml = tmp_path / "study.yaml"
    yaml.write_text(f"load: !!python/object/apply:os.mkdir ['{trace}']\n")
    toml = tmp_path / "study.toml"
    toml.write_text(f"[load]\nmass = \"__import__('os').mkdir('{trace}') kg\"\n")
    for path in (yaml, toml):
        with pytest.raises(StudyError):
            load_study(path)
    assert not trace.exists()


def test_a_grid_as_long_as_an_axis_may_be_costs_neither_time_nor_memory(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text("[load]\nmass = { from = 0, to = 1, num = 10_000_000 }\n")
    memory = peak_memory()
    with at_most(LONGEST_TIME):
        assert len(load_study(path).load.mass) == 10**7
    assert peak_memory() - memory < 20_000
