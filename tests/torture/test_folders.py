"""A run folder that looks finished is finished and has the same bytes, whatever happened to it."""

import functools
from contextlib import closing

import pytest
from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.stateful import run_state_machine_as_test

from tools.torture.disk import ERRORS
from tools.torture.folders import VERBS, Folder


def run_histories(number, count, steps):
    """Run histories of a folder, drawn at random from a seed."""
    machine = seed(number)(type("Runs", (Folder,), {}))
    how = settings(
        max_examples=count,
        stateful_step_count=steps,
        database=None,
        deadline=None,
        report_multiple_bugs=False,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
    )
    run_state_machine_as_test(machine, settings=how)


def test_whatever_happens_to_a_run_it_comes_to_the_same_bytes():
    run_histories(0, 6, 8)


@pytest.mark.torture
@pytest.mark.parametrize("number", range(1, 9))
def test_whatever_happens_for_long_it_comes_to_the_same_bytes(number):
    run_histories(number, 60, 25)


# --- Every place ----------------------------------------------------------------------------------


@functools.cache
def operations(verb):
    """Return the operations on the disk of a run that nobody disturbs."""
    with closing(Folder.of(verb)) as folder:
        folder.carry_out()
        return folder.operations


@pytest.mark.parametrize("verb", VERBS)
def test_the_disk_records_every_kind_of_operation(verb):
    """The tests of failures rest on this."""
    kinds = {"open", "write", "fsync file", "fsync folder", "rename", "mkdir"}
    assert {kind for kind, _ in operations(verb)} == kinds


EVERYWHERE = [
    ("design", None),
    ("design", ERRORS[0]),
    ("sweep", None),
    *(("sweep", error) for error in ERRORS),
]


@pytest.mark.torture
@pytest.mark.parametrize(("verb", "error"), EVERYWHERE)
def test_a_failure_or_a_kill_at_every_operation_leaves_what_can_be_resumed(verb, error):
    is_kill = error is None  # which lasts anyhow
    durations = (True,) if is_kill else (True, False)
    for at in range(len(operations(verb))):
        for lasting in durations:
            with closing(Folder.of(verb)) as folder:
                folder.fail(at, error, lasting=lasting)
                folder.check()
                folder.finish()


@pytest.mark.torture
@pytest.mark.parametrize("chunk", range(4))
@pytest.mark.parametrize(("verb", "step"), [("sweep", 80), ("design", 100)])
def test_a_part_cut_at_any_byte_does_not_stand(verb, step, chunk):
    with closing(Folder.of(verb)) as folder:
        folder.stop(3)
        file = sorted(folder.run.glob("*.parquet/*.parquet"))[1]
        whole = file.read_bytes()
        for cut in range(chunk, len(whole), step):
            file.write_bytes(whole[:cut])
            folder.set_aside_unknown()
            assert not file.exists()
        folder.finish()
