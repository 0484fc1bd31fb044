"""Loaded by the workers of the tests: small parts, and accidents that files in a folder ask for.

`kill`, `fail` and `full` hold the first design of the part that they strike, `slow` the seconds that every part takes
longer, `kill_choices` and `kill_choices_once` a part of the choices of a design, `sparing` is there where the worst of
few choices is to be worked out, `old` the version that pyarrow shall seem to have; `blind` hides the run folder.
"""

import os
import signal
import time
from pathlib import Path

import pyarrow as pa

from tendon_cli.answers import candidates
from tendon_cli.answers import choices as choices_module
from tendon_cli.answers.choices import Choices
from tendon_cli.engine import plan as plan_module
from tendon_cli.engine.cluster import worker as task
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import OutputError, Stopped

HAZARDS = Path(os.environ["TENDON_TEST_HAZARDS"])
fill = getattr(Sweep, "harmless_fill", Sweep.fill)  # this module is loaded twice
solve = getattr(Choices, "harmless_fill", Choices.fill)


def asked(name):
    try:
        return (HAZARDS / name).read_text("utf-8")
    except FileNotFoundError:
        return None


def dangerous(self, tables, index):
    first = str(self.plan.part(index).start)
    if asked("kill") == first:
        os.kill(os.getpid(), signal.SIGKILL)
    if asked("fail") == first:
        raise FloatingPointError("something odd")
    if asked("full") == first:
        raise OutputError("cannot be written: No space left on device")
    end = time.monotonic() + float(asked("slow") or 0)
    while time.monotonic() < end:
        if self.stop.is_set():
            raise Stopped
        time.sleep(0.01)
    return fill(self, tables, index)


def dangerous_choices(self, tables, index):
    if asked("kill_choices") == str(index):
        os.kill(os.getpid(), signal.SIGKILL)
    if asked("kill_choices_once") == str(index):
        (HAZARDS / "kill_choices_once").unlink()
        os.kill(os.getpid(), signal.SIGKILL)
    candidates.STATES_FOR_ALL = 0 if asked("sparing") else 2**30
    return solve(self, tables, index)


Sweep.fill, Sweep.harmless_fill = dangerous, fill
Choices.fill, Choices.harmless_fill = dangerous_choices, solve
plan_module.STATES_PER_FILE = plan_module.STATES_PER_PART = int(
    os.environ["TENDON_TEST_STATES_PER_PART"]
)
choices_module.WINDOWS_PER_PART = int(os.environ["TENDON_TEST_WINDOWS_PER_PART"])
pa.__version__ = asked("old") or pa.__version__
if asked("blind"):
    task.JOURNAL, task.RECORDS = "not-to-be-seen", {}
    task._PATIENCE = 0.3
