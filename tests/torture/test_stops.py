"""Asked to stop, a run leaves nothing behind: no process, no shared memory, no half-written file."""

import os
import re
import signal
import time
from pathlib import Path

import pytest

from .tools import (
    SLOW,
    SMALL,
    SWEEP,
    ended,
    group_members,
    journalled,
    launched,
    running,
    some,
    temporary_files,
    wait_for,
)

WITH_FIGURES = [word for word in SWEEP if word != "--no-figures"]


def shared_memory():
    """What stands in shared memory that belongs to nobody else's tests."""
    shared = Path("/dev/shm")  # noqa: S108 - only looked at
    return {item.name for item in shared.iterdir()} if shared.exists() else set()


def of_process(names, pid):
    """Names that a process has put its number into, as libraries do: whole, not as part of a random name."""
    return [name for name in names if str(pid) in re.split("[^0-9A-Za-z]", name)]


def assert_nothing_left(process, place):
    assert group_members(process.pid) == []
    assert of_process(shared_memory(), process.pid) == []
    assert not temporary_files(place / "run")


def test_a_second_sigint_ends_a_run_at_once(place, uninterrupted, hashes_in):
    with running(place, SMALL | {"hold": "rows", "held": "held"}, *SWEEP) as process:
        wait_for((place / "held").exists)
        os.kill(process.pid, signal.SIGINT)
        time.sleep(0.3)
        assert process.poll() is None, "the first lets the part come to its end"
        began = time.monotonic()
        os.kill(process.pid, signal.SIGINT)
        code, _, said = ended(process)
        assert (code, "Traceback" in said) == (130, False)
        assert time.monotonic() - began < 10.0  # only what hangs needs it
    assert group_members(process.pid) == []
    assert of_process(shared_memory(), process.pid) == []
    assert launched(place, SMALL, *SWEEP, "--resume")[0] == 0
    assert hashes_in(place / "run") == uninterrupted


@pytest.mark.parametrize("number", some([signal.SIGTERM], [signal.SIGINT, signal.SIGHUP]))
def test_a_signal_to_the_parent_alone_stops_at_the_next_part_at_latest(place, uninterrupted, hashes_in, number):
    with running(place, SLOW, *SWEEP) as process:
        wait_for(lambda: journalled(place / "run") >= 5)
        os.kill(process.pid, number)
        left, _, said = ended(process)
    assert (left, "Traceback" in said) == (128 + number, False), said
    assert_nothing_left(process, place)
    assert launched(place, SMALL, *SWEEP, "--resume")[0] == 0
    assert hashes_in(place / "run") == uninterrupted


@pytest.mark.parametrize("number", some([signal.SIGTERM], [signal.SIGINT, signal.SIGHUP]))
def test_a_signal_while_figures_are_drawn_ends_in_a_run_that_is_whole_or_can_be_resumed(place, hashes_in, number):
    settings = SMALL | {"hold": "figures", "held": "held", "seconds": 0.5}
    with running(place, settings, *WITH_FIGURES) as process:
        wait_for((place / "held").exists)
        os.kill(process.pid, number)
        code, _, said = ended(process)
    assert code in (0, 128 + number), said
    assert "Traceback" not in said
    assert (place / "run/run.json").exists() == (code == 0)
    assert_nothing_left(process, place)
    code, _, said = launched(place, SMALL, *WITH_FIGURES, "--resume")
    assert code == 0, said
    assert (place / "run/slack_map.png").exists()
