"""What the tests of this folder share: a study of many small parts, and runs of it in processes of their own."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

LAUNCHER = Path(__file__).with_name("launcher.py")
STATES = 30
PARTS = 60
STUDY = """
name = "torture"
[tendon]
pretension = { from = "60 N", to = "240 N", num = 10 }
[spring]
stiffness = ["1 kN/m", "2 kN/m", "3 kN/m", "4 kN/m", "5 kN/m", "6 kN/m"]
[load]
mass = ["0 kg", "5 kg", "10 kg"]
[motion]
elbow_angle = { from = "10 deg", to = "90 deg", num = 5 }
"""
"""60 parts of 3 designs and 30 states, where a part has 30 states."""

SMALL = {"states": STATES}
SLOW = SMALL | {"hold": "rows", "held": "held", "seconds": 0.02}
"""Settings of the launcher: parts of so many states; and as if each took a while, so that a run is met midway."""

SWEEP = ("sweep", "study.toml", "--out", "run", "--no-figures", "--jobs", "2")


def some(sample, rest):
    """Values of a test, of which the rest are left to `make torture`."""
    return [*sample, *(pytest.param(value, marks=pytest.mark.torture) for value in rest)]


def command(settings, *words):
    """The words that start the launcher."""
    return [sys.executable, str(LAUNCHER), json.dumps(settings), *map(str, words)]


def start(folder, settings, *words, **options):
    """Start a run as the leader of a process group of its own, in a folder."""
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "cwd": folder} | options
    return subprocess.Popen(command(settings, *words), start_new_session=True, **options)


def ended(process, seconds=60):
    """Wait for a run: its exit code, stdout and stderr."""
    out, err = process.communicate(timeout=seconds)
    return process.returncode, out, err


def launched(folder, settings, *words, seconds=60, **options):
    """Run a command to its end."""
    return ended(start(folder, settings, *words, **options), seconds)


def kill_group(process, number=signal.SIGKILL):
    """End a run and all its processes."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, number)
    return ended(process)


@contextmanager
def running(folder, settings, *words, **options):
    """A run that is certainly over afterwards."""
    process = start(folder, settings, *words, **options)
    try:
        yield process
    finally:
        if process.poll() is None:
            kill_group(process)
        for stream in (process.stdout, process.stderr):
            stream.close()


def wait_for(condition, seconds=30):
    """Wait until something is so."""
    until = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > until:
            raise TimeoutError(condition)
        time.sleep(0.002)


def group_members(leader):
    """Processes that are left of a process group."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[2]) == leader and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found


def study_in(folder, text=STUDY):
    """Put the study into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "study.toml").write_text(text, encoding="utf-8")
    return folder


def journalled(run):
    """How many parts a journal has whole."""
    try:
        return max(0, (run / "journal.jsonl").read_bytes().count(b"\n") - 1)
    except FileNotFoundError:
        return 0


def temporary_files(run):
    """Files of a run under the names that they bear until they are whole."""
    return [file for file in run.rglob(".*") if file.name.endswith(".tmp")]
