"""Studies of many small parts, and runs of them in processes of their own."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

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
"""Study of 60 parts of 3 designs and 30 states, where a part has 30 states."""
QUESTION = """
name = "torture"
[spring]
stiffness = ["3 kN/m", "5 kN/m"]
[spool]
ratio = [0.5, 0.6, 0.7]
[load]
mass = ["0 kg", "5 kg"]
[motion]
elbow_angle = { from = "10 deg", to = "90 deg", num = 3 }
[design]
maximise = ["tolerance"]
"""
"""Six parts of a choice; the best is said when all are solved."""
STUDIES = {"sweep": STUDY, "design": QUESTION}
READINGS = "cell 1,cell 2\n1.2,1\n2.4,2\n1,1.2\n2,2.4\n"
SMALL = {"parts": STATES}
QUIET = ("--out", "run", "--no-figures", "--jobs", "2")
SWEEP = ("sweep", "study.toml", *QUIET)


def command(settings, *words):
    """Return the words that start the launcher."""
    return [sys.executable, str(LAUNCHER), json.dumps(settings), *map(str, words)]


@contextmanager
def running(folder, settings, *words, **options):
    """Yield a run that leads a process group of its own; it is certainly over afterwards."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    options = pipes | {"cwd": folder} | options
    with subprocess.Popen(command(settings, *words), start_new_session=True, **options) as process:
        try:
            yield process
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def wait_for_end(process):
    """Wait for a run; return its exit code, stdout and stderr."""
    out, err = process.communicate(timeout=60)
    return process.returncode, out, err


def launched(folder, settings, *words, **options):
    """Run a command to its end; return its exit code, stdout and stderr."""
    with running(folder, settings, *words, **options) as process:
        return wait_for_end(process)


def wait_for(condition):
    """Wait until a condition is true."""
    until = time.monotonic() + 60
    while not condition():
        if time.monotonic() > until:
            raise TimeoutError(condition)
        time.sleep(0.002)


def left_of(leader):
    """Return processes that are left of a process group, and what it left in shared memory."""
    processes = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = stat.read_text().rpartition(")")[2].split()
            state = fields[0]
            group = int(fields[2])
            if group == leader and state != "Z":
                processes.append(stat)
    shared = Path("/dev/shm")  # noqa: S108 - only looked at
    names = [item.name for item in shared.iterdir()] if shared.exists() else []
    return processes + [name for name in names if str(leader) in re.split("[^0-9A-Za-z]", name)]


def study_in(folder, text=STUDY):
    """Put a study into a folder; return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "study.toml").write_text(text, encoding="utf-8")
    return folder


def temporary_files(run):
    """Return files of a run under the names that they bear until they are whole."""
    return [file for file in run.rglob(".*") if file.name.endswith(".tmp")]
