"""The one opener: files are read, and nothing else is waited for."""

import errno
import os
import socket
from pathlib import Path

import pytest

from tendon_cli.errors import InputError
from tendon_cli.files import open_file, read_file
from tendon_cli.tables.read import open_table

from .study.malformed.row import at_most


def test_a_file_is_read_whole_up_to_what_is_allowed_and_a_terabyte_is_not(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert read_file(path, 5) == b"12345"
    with pytest.raises(OSError, match="it is larger than 0 kB") as caught:
        read_file(path, 4)
    assert caught.value.errno == errno.EFBIG
    with path.open("wb") as file:
        file.truncate(10**12)
    with at_most(1), pytest.raises(OSError, match="larger than 2 MB"):
        read_file(path, 2_000_000)


def not_files(folder):
    os.mkfifo(folder / "pipe")
    (folder / "folder").mkdir()
    listening = socket.socket(socket.AF_UNIX)
    listening.bind(str(folder / "socket"))
    (folder / "zero").symlink_to("/dev/zero")
    (folder / "pipe again").symlink_to(folder / "pipe")
    return listening, {
        name: folder / name for name in ("pipe", "folder", "socket", "zero", "pipe again")
    }


def test_what_is_no_file_is_refused_at_once_and_left_open_nowhere(tmp_path):
    listening, found = not_files(tmp_path)
    descriptors = Path("/proc/self/fd")
    before = len(list(descriptors.iterdir())) if descriptors.is_dir() else 0
    for name, path in found.items():
        kind = {"zero": "device"}.get(name, name.partition(" ")[0])
        with at_most(1), pytest.raises(OSError, match=f"it is a {kind}, expected a file"):
            open_file(path)
    if before:
        assert len(list(descriptors.iterdir())) == before
    listening.close()


def test_a_pipe_that_takes_a_file_s_place_after_the_first_look_is_refused(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "file").touch()
    before = (tmp_path / "file").stat()
    monkeypatch.setattr(type(tmp_path), "stat", lambda _, **__: before)
    with at_most(1), pytest.raises(OSError, match="it is a pipe"):
        open_file(tmp_path / "pipe")


@pytest.mark.parametrize("name", ["designs.parquet", "states.parquet/part-00000.parquet"])
def test_a_pipe_is_no_table_and_no_part_of_one(tmp_path, name):
    pipe = tmp_path / name
    pipe.parent.mkdir(exist_ok=True)
    os.mkfifo(pipe)
    with at_most(1), pytest.raises(InputError, match="it is a pipe, expected a file"):
        open_table(tmp_path / name.partition("/")[0])
