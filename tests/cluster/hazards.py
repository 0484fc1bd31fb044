"""Small parts and accidents for the workers of the tests, which load this module.

Files in a folder ask for accidents. `kill`, `fail` and `full` hold the first design of the part
that they strike, `hold` that of the only part that is made while the file is there, `slow` the
seconds that every part takes longer, `kill_choices` and `kill_choices_once` a part of the choices
of a design, `old` the version that pyarrow shall seem to have. `blind` hides the run folder.
"""

import os
import signal
import time
from pathlib import Path

import pyarrow as pa

from tendon_cli.answers import choices as choices_module
from tendon_cli.answers.choices import Choices
from tendon_cli.engine import plan as plan_module
from tendon_cli.engine.cluster import worker
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import OutputError, Stopped

HAZARDS = Path(os.environ["TENDON_TEST_HAZARDS"])
STATES_PER_PART = int(os.environ["TENDON_TEST_STATES_PER_PART"])
WINDOWS_PER_PART = int(os.environ["TENDON_TEST_WINDOWS_PER_PART"])

# This module is loaded twice.
fill_sweep = getattr(Sweep, "harmless_fill", Sweep.fill)
fill_choices = getattr(Choices, "harmless_fill", Choices.fill)


def hazard(name):
    """Return the text of the file that asks for an accident, None if there is none."""
    try:
        return (HAZARDS / name).read_text("utf-8")
    except FileNotFoundError:
        return None


def fill_sweep_dangerously(self, tables, index):
    """Fill the tables of a part of a sweep, with accidents."""
    first = str(self.plan.part(index).start)
    if hazard("kill") == first:
        os.kill(os.getpid(), signal.SIGKILL)
    if hazard("fail") == first:
        raise FloatingPointError("something odd")
    if hazard("full") == first:
        raise OutputError("cannot be written: No space left on device")
    end = time.monotonic() + float(hazard("slow") or 0)
    while time.monotonic() < end or hazard("hold") not in (None, first):
        if self.stop.is_set():
            raise Stopped
        time.sleep(0.01)
    return fill_sweep(self, tables, index)


def fill_choices_dangerously(self, tables, index):
    """Fill the tables of a part of the choices, with accidents."""
    if hazard("kill_choices") == str(index):
        os.kill(os.getpid(), signal.SIGKILL)
    if hazard("kill_choices_once") == str(index):
        (HAZARDS / "kill_choices_once").unlink()
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(float(hazard("slow") or 0))
    return fill_choices(self, tables, index)


Sweep.harmless_fill = fill_sweep
Sweep.fill = fill_sweep_dangerously
Choices.harmless_fill = fill_choices
Choices.fill = fill_choices_dangerously
plan_module.STATES_PER_FILE = STATES_PER_PART
plan_module.STATES_PER_PART = STATES_PER_PART
choices_module.WINDOWS_PER_PART = WINDOWS_PER_PART
pa.__version__ = hazard("old") or pa.__version__
if hazard("blind"):
    worker.lock_mark = lambda _folder: ""
    worker._PATIENCE = 0.3
