"""Fixtures of all tests: studies as text, run in a folder of their own, and commands."""

from __future__ import annotations

import gc
import json
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import settings

from tendon_cli import files
from tendon_cli.answers import assumed, sensitivity
from tendon_cli.commands import cli, startup
from tendon_cli.engine import plan as plan_module
from tendon_cli.engine.folder import RunFolder
from tendon_cli.engine.plan import STATES_PER_BLOCK, Plan
from tendon_cli.engine.run import RunOptions, compute_parts
from tendon_cli.engine.sweep import Sweep
from tendon_cli.engine.threads import in_threads
from tendon_cli.files import locked
from tendon_cli.fits.suit import parameters
from tendon_cli.studies import fresh_sample as fresh_module
from tendon_cli.studies import usual
from tendon_cli.studies.load import load_study
from tendon_cli.tables.digest import file_sha256
from tendon_cli.tables.read import open_table
from tests.shells import asked_by_bash

CONFIGS = Path(__file__).parents[1] / "configs"

# Commands that the tests start hear signals, though the tests themselves may run under nohup.
if threading.current_thread() is threading.main_thread():
    for number in (signal.SIGINT, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)


# An example may take long on a busy machine.
settings.register_profile("tendon", deadline=None)
settings.load_profile("tendon")

# As every command does: it takes a third of the time from what works with large arrays.
startup.keep_freed_memory()

USUAL = usual.USUAL
"""Usual deviations as they are, for modules that draw them."""
TAKEN_AS_THEY_ARE = (assumed.USUAL, parameters.TOLERANCES)
"""The same in modules that have them by name, imported before any test leaves them out."""
FEW_FRESH = 500
"""Members of fresh samples in tests, of which a study does not state another number."""
FEW_POINTS = 256
"""Points of Sobol indices in tests."""


def _few_fresh(study, fresh_sample=fresh_module.fresh_sample, **which):
    """Return a small fresh sample of a study that leaves its size open."""
    if "verify" in study.design.model_fields_set:
        return fresh_sample(study, **which)
    few = study.design.model_copy(update={"verify": FEW_FRESH})
    return fresh_sample(study.replaced({"design": few}), **which)


@pytest.fixture(scope="session", autouse=True)
def _exact_numbers():
    """Draw no usual deviations: not in answers of a whole session, which come before any module."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(usual, "USUAL", {})
        yield


@pytest.fixture(autouse=True)
def _no_inputs_of_other_commands(monkeypatch):
    """Forget what an earlier command read: the number of a file that is gone is given anew."""
    monkeypatch.setattr(files, "_inputs", None)


@pytest.fixture(scope="module", autouse=True)
def _judged_by_few(request):
    """Judge choices by few fresh persons or draws, but in modules that say JUDGED_BY_ALL.

    Sobol indices have few points, too, but in modules that say ALL_POINTS. Usual deviations are
    drawn in modules that say DRAWS_USUAL alone: most tests are of suits whose numbers are exact.
    """
    with pytest.MonkeyPatch.context() as patch:
        if getattr(request.module, "DRAWS_USUAL", False):
            patch.setattr(usual, "USUAL", USUAL)
        if not getattr(request.module, "JUDGED_BY_ALL", False):
            patch.setattr(fresh_module, "fresh_sample", _few_fresh)
        if not getattr(request.module, "ALL_POINTS", False):
            patch.setattr(sensitivity, "_MOST_POINTS", FEW_POINTS)
        yield


@dataclass(frozen=True)
class Ran:
    """Exit code and output of a command that has ended."""

    exit: int
    out: str
    err: str

    @property
    def json(self):
        """Return the one JSON object on stdout."""
        return json.loads(self.out, parse_constant=pytest.fail)


@dataclass(frozen=True)
class Swept:
    """A finished run and its tables."""

    folder: Path
    plan: Plan
    record: dict

    def table(self, name):
        return open_table(self.folder / f"{name}.parquet")

    @property
    def designs(self):
        return self.table("designs").read().to_pandas()

    @property
    def states(self):
        return self.table("states").read().to_pandas()

    @property
    def hashes(self):
        return table_hashes(self.folder)


def table_hashes(folder):
    """Return the SHA-256 of every table file of a run, by its name in the folder."""
    return {
        str(file.relative_to(folder)): file_sha256(file)
        for file in sorted(folder.rglob("*.parquet"))
        if file.is_file()
    }


def sweep_text(text, folder, *, jobs=1, block_states=STATES_PER_BLOCK, out="run"):
    """Run a study given as TOML text; its tables are written into the subfolder `out`."""
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    plan = Plan(load_study(file), block_states=block_states)
    target = RunFolder(folder / out, Sweep(plan))
    with locked(target.path):
        record, _ = compute_parts(target, RunOptions(), in_threads(jobs))
        target.finish(record)
    return Swept(target.path, plan, record)


@pytest.fixture(scope="session")
def new_sweep():
    """Return `sweep_text`, for tests in any folder."""
    return sweep_text


@pytest.fixture(scope="session")
def hashes_in():
    """Return `table_hashes`, for tests in any folder."""
    return table_hashes


@pytest.fixture(scope="session")
def configs():
    """Return the folder of the shipped studies."""
    return CONFIGS


@pytest.fixture
def workplace(tmp_path, monkeypatch):
    """Change into an empty folder and return it."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def tendon(workplace, capsys):
    """Return a function that runs a command in this process and an empty folder."""

    def call(*words):
        capsys.readouterr()
        with pytest.raises(SystemExit) as end:
            cli.main([str(word) for word in words])
        printed = capsys.readouterr()
        return Ran(end.value.code, printed.out, printed.err)

    return call


@pytest.fixture
def completed(tendon, monkeypatch):
    """Return a function that returns the words with which bash completes a line."""

    def call(line):
        with monkeypatch.context() as patch:
            for name, value in asked_by_bash(line).items():
                patch.setenv(name, value)
            return tendon().out.strip("\n").splitlines()

    return call


@pytest.fixture
def outside(workplace):
    """Return a function that runs a command as a process of its own, in an empty folder.

    It runs the console script, or Python with arguments if `python=True`.
    """

    def call(*words, python=False, **options):
        program = Path(sys.executable) if python else Path(sys.executable).with_name("tendon")
        options = {"capture_output": True, "cwd": workplace} | options
        ended = subprocess.run(
            [program, *map(str, words)], check=False, text=True, timeout=120, **options
        )
        return Ran(ended.returncode, ended.stdout, ended.stderr)

    return call


@pytest.fixture
def small_parts(monkeypatch):
    """Return a function that makes parts so small that small studies have several."""

    def shrink(states, designs=None):
        monkeypatch.setattr(plan_module, "STATES_PER_PART", states)
        monkeypatch.setattr(plan_module, "STATES_PER_FILE", states)
        monkeypatch.setattr(plan_module, "DESIGNS_PER_PART", designs or states)

    return shrink


@pytest.fixture
def blank_figures(monkeypatch):
    """Write every figure as a blank page, for tests of files and not of what is drawn."""
    from matplotlib.figure import Figure

    from tendon_cli.figures import frame, style

    def render_blank(_figure, kind, about=None):
        return style.render(Figure(figsize=(1, 1)), kind, about)

    monkeypatch.setattr(frame, "render", render_blank)


@pytest.fixture
def muttered(monkeypatch):
    """Yield a list of exceptions that nobody can catch, such as those of finalizers."""
    messages = []

    def note(fault):
        messages.append(f"{fault.exc_type.__name__}: {fault.exc_value}")

    monkeypatch.setattr(sys, "unraisablehook", note)
    yield messages
    gc.collect()
