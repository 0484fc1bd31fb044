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

from tendon_cli.answers import parts as parts_module
from tendon_cli.answers import promising
from tendon_cli.answers.parts import Choices
from tendon_cli.engine import plan as plan_module
from tendon_cli.engine.cluster import task
from tendon_cli.engine.part import PartMaker
from tendon_cli.errors import OutputError, Stopped

HAZARDS = Path(os.environ["TENDON_TEST_HAZARDS"])
fill = getattr(PartMaker, "harmless_fill", PartMaker.fill)  # this module is loaded twice
solve = getattr(Choices, "harmless_part", Choices.part)


def asked(name):
    try:
        return (HAZARDS / name).read_text("utf-8")
    except FileNotFoundError:
        return None


def dangerous(self, tables, designs):
    first = str(designs.start)
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
    return fill(self, tables, designs)


def dangerous_choices(self, index):
    if asked("kill_choices") == str(index):
        os.kill(os.getpid(), signal.SIGKILL)
    if asked("kill_choices_once") == str(index):
        (HAZARDS / "kill_choices_once").unlink()
        os.kill(os.getpid(), signal.SIGKILL)
    promising.STATES_FOR_ALL = 0 if asked("sparing") else 2**30
    return solve(self, index)


PartMaker.fill, PartMaker.harmless_fill = dangerous, fill
Choices.part, Choices.harmless_part = dangerous_choices, solve
plan_module.STATES_PER_FILE = plan_module.STATES_PER_PART = int(os.environ["TENDON_TEST_STATES_PER_PART"])
parts_module.WINDOWS_PER_PART = int(os.environ["TENDON_TEST_WINDOWS_PER_PART"])
pa.__version__ = asked("old") or pa.__version__
if asked("blind"):
    task.JOURNAL = task.RECORD = "not-to-be-seen"
    task._PATIENCE = 0.3
