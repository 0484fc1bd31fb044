"""A real scheduler and real workers, as processes of this machine, with accidents at hand."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from multiprocessing.process import BaseProcess
from pathlib import Path

import pytest

from tests.cluster import processes

STATES_PER_PART = 200
WINDOWS_PER_PART = 2**8
STUDY = """
[tendon]
pretension = { from = "60 N", to = "240 N", num = 13 }
[spring]
stiffness = ["1 kN/m", "2 kN/m", "3 kN/m"]
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 25 }
"""
"""39 designs of 50 states, 3 designs in a part, where the springs end: 13 parts."""
PARTS = 13
SWEEP = ("sweep", "study.toml", "--no-figures", "--out", "run")


@dataclass
class DaskCluster:
    """A scheduler and workers; `hazards` is the folder whose files ask for accidents."""

    folder: Path
    workers: list[BaseProcess] = field(default_factory=list)

    def __post_init__(self):
        self.hazards.mkdir(parents=True)
        file = self.folder / "scheduler.json"
        options = ("--port", "0", "--no-dashboard", "--no-jupyter", "--idle-timeout", "100s")
        self.scheduler = self._start("scheduler", *options, "--scheduler-file", file)

        def address():
            return json.loads(file.read_text("utf-8"))["address"]

        self.address = wait_for(address, OSError, ValueError)

    @property
    def hazards(self):
        return self.folder / "hazards"

    @property
    def processes(self):
        return [self.scheduler, *self.workers]

    def add_workers(self, count):
        """Start so many workers."""
        words = [self.address, "--no-nanny"]
        words += ["--nthreads", "1", "--no-dashboard", "--memory-limit", "0"]
        words += ["--local-directory", self.folder / "spill"]
        words += ["--preload", Path(__file__).with_name("hazards.py")]
        for _ in range(count):
            self.workers.append(self._start("worker", *words))

    def set(self, **accidents):
        """Ask for these accidents, and for no others any more."""
        for old in self.hazards.iterdir():
            old.unlink()
        self.set_more(**accidents)

    def set_more(self, **accidents):
        """Ask for these accidents, too."""
        for name, value in accidents.items():
            (self.hazards / name).write_text(str(value), encoding="utf-8")

    def close(self):
        """End scheduler and workers, and wait until no process of theirs is left."""
        for process in self.processes:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.join(10)
        wait_for(lambda: not any(_is_alive(process.pid) for process in self.processes), seconds=10)

    def _start(self, role, *words):
        log = self.folder / f"{role}-{len(self.workers)}.log"
        environment = {
            "TENDON_TEST_HAZARDS": str(self.hazards),
            "TENDON_TEST_STATES_PER_PART": str(STATES_PER_PART),
            "TENDON_TEST_WINDOWS_PER_PART": str(WINDOWS_PER_PART),
        }
        words = ["--host", "127.0.0.1", *map(str, words)]
        return processes.start(role, words, self.folder, log, environment)


def _is_alive(group):
    """Return True if a process of the group runs."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def wait_for(read, *errors, seconds=30.0):
    """Call a function until it returns something true. Return this."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        with contextlib.suppress(*errors):
            result = read()
            if result:
                return result
        time.sleep(0.02)
    return pytest.fail(f"nothing within {seconds} s")


def in_background(act):
    """Call a function while a command runs in this thread. Return the thread that calls it."""
    thread = threading.Thread(target=act)
    thread.start()
    return thread


def leftovers(folder="run"):
    """Return temporary files that stand in the folder of a run."""
    return [str(path) for path in Path(folder).rglob(".*") if path.name != ".lock"]


def recorded():
    """Return the number of parts that stand in the unfinished run."""
    return len(list(Path("run/designs.parquet").glob("part-*.parquet")))


@pytest.fixture(scope="module")
def start_cluster(tmp_path_factory):
    """Yield a function that starts a scheduler with workers; they are ended after the module."""
    started = []

    def start(workers, **accidents):
        cluster = DaskCluster(tmp_path_factory.mktemp("cluster") / "dask")
        started.append(cluster)
        cluster.set(**accidents)
        cluster.add_workers(workers)
        logs = [cluster.folder / f"worker-{number}.log" for number in range(workers)]
        wait_for(lambda: all("Registered to" in log.read_text("utf-8") for log in logs), OSError)
        return cluster

    yield start
    for cluster in started:
        cluster.close()


@pytest.fixture(scope="module")
def shared_cluster(start_cluster):
    return start_cluster(2)


@pytest.fixture
def cluster(shared_cluster):
    """Yield a cluster of two workers without accidents."""
    shared_cluster.set()
    yield shared_cluster
    shared_cluster.set()


@pytest.fixture
def study(workplace, small_parts):
    """Write a study of 13 parts into the current folder. Return its path."""
    small_parts(STATES_PER_PART)
    path = workplace / "study.toml"
    path.write_text(STUDY, encoding="utf-8")
    return path


@pytest.fixture
def local(study, new_sweep):
    """Compute the same study in this process. Return the run."""
    (study.parent / "here").mkdir()
    return new_sweep(STUDY, study.parent / "here")


@pytest.fixture
def outside_sweep(study):
    """Yield a function that starts a sweep in a process of its own, to be sent signals."""
    code = (
        "import sys; from tendon_cli.commands import cli; from tendon_cli.engine import plan; "
        f"plan.STATES_PER_FILE = plan.STATES_PER_PART = {STATES_PER_PART}; cli.main(sys.argv[1:])"
    )
    started = []

    def start(*words):
        command = [sys.executable, "-c", code, "sweep", str(study), "--no-figures", *words]
        process = subprocess.Popen(
            command,
            text=True,
            cwd=study.parent,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()
