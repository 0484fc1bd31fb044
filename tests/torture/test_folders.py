"""Whatever happens to a run folder, in whatever order: what looks finished is finished, and has the same bytes."""

import functools
import sys
from contextlib import closing

import pytest
from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule, run_state_machine_as_test

from .disk import ERRORS
from .folders import FIGURE, HARMS, NO_LOCKS, OBSTACLES, VERBS, WAYS, Folder

PLACE, CHANCE = st.integers(0, 60), st.randoms(use_true_random=True)


class RunFolders(RuleBasedStateMachine):
    """Runs that are finished, stopped, killed, resumed, replaced, harmed, forged and refused."""

    folder = None

    @initialize(verb=st.sampled_from(["sweep", "sweep", "design"]))
    def begin(self, verb):
        self.folder = Folder(verb)

    @rule(way=st.sampled_from(["resume", "overwrite"]))
    def finish(self, way):
        self.folder.finish(way)

    @rule(error=st.sampled_from(NO_LOCKS))
    def finish_without_locks(self, error):
        with pytest.MonkeyPatch.context() as patch, OBSTACLES[error](self.folder, patch):
            self.folder.finish(lock=False)

    @rule()
    def ask_plainly(self):
        self.folder.ask_plainly()

    @rule(parts=st.integers(0, 5))
    def stop(self, parts):
        self.folder.stop(parts)

    @rule(at=PLACE, error=st.sampled_from([None, None, *ERRORS]), lasting=st.booleans(), way=st.sampled_from(WAYS[1:]))
    def fail(self, at, error, lasting, way):
        self.folder.fail(at, error, lasting=lasting, way=way)

    @rule(parts=st.sets(st.integers(0, 5), min_size=1, max_size=3))
    def lose(self, parts):
        self.folder.lose(parts)

    @rule(at=PLACE, how=st.sampled_from(HARMS), chance=CHANCE)
    def harm(self, at, how, chance):
        self.folder.harm(at, how, chance)

    @rule(at=PLACE)
    def link(self, at):
        self.folder.link(at)

    @rule(chance=CHANCE)
    def break_journal(self, chance):
        self.folder.break_journal(chance)

    @rule(chance=CHANCE)
    def forge(self, chance):
        self.folder.forge(chance)

    @rule(why=st.sampled_from(sorted(OBSTACLES)), way=st.sampled_from(WAYS))
    def refuse(self, why, way):
        self.folder.refuse(why, way)

    @invariant()
    def check(self):
        if self.folder is not None:
            self.folder.check()

    def teardown(self):
        if self.folder is not None:
            with closing(self.folder):
                if sys.exc_info()[0] is None:
                    self.folder.finish()


def histories(number, count, steps):
    machine = seed(number)(type("Runs", (RunFolders,), {}))
    how = settings(
        max_examples=count, stateful_step_count=steps, database=None, deadline=None, report_multiple_bugs=False,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    run_state_machine_as_test(machine, settings=how)


def test_whatever_happens_to_a_run_it_comes_to_the_same_bytes():
    histories(0, 20, 8)


@pytest.mark.torture
@pytest.mark.parametrize("number", range(1, 9))
def test_whatever_happens_for_long_it_comes_to_the_same_bytes(number):
    histories(number, 60, 25)


# --- Every place -----------------------------------------------------------------------------------------------------


@functools.cache
def operations(verb):
    """What a run does to the disk, one after the other."""
    with closing(Folder(verb)) as folder:
        folder.carry_out()
        return folder.seen


@pytest.mark.parametrize("verb", VERBS)
def test_every_kind_of_operation_goes_by_the_disk(verb):
    """What all of this rests on."""
    assert {kind for kind, _ in operations(verb)} == {"open", "write", "fsync file", "fsync folder", "rename", "mkdir"}


EVERYWHERE = [("design", None), ("design", ERRORS[0]), ("sweep", None), *(("sweep", error) for error in ERRORS)]


@pytest.mark.torture
@pytest.mark.parametrize(("verb", "error"), EVERYWHERE)
def test_a_failure_or_a_kill_at_every_operation_leaves_what_can_be_resumed(verb, error):
    for at in range(len(operations(verb))):
        for lasting in (True, False) if error else (True,):
            with closing(Folder(verb)) as folder:
                folder.fail(at, error, lasting=lasting)
                folder.check()
                folder.finish()


@pytest.mark.torture
@pytest.mark.parametrize("chunk", range(4))
@pytest.mark.parametrize(("verb", "step"), [("sweep", 4), ("design", 100)])
def test_a_journal_cut_at_any_byte_is_resumed(verb, step, chunk):
    with closing(Folder(verb)) as folder:
        folder.stop(3)
        whole = folder.journal.read_bytes()
        for cut in range(chunk, len(whole) + 1, step):
            for file in (folder.record, folder.run / FIGURE):
                file.unlink(missing_ok=True)
            folder.journal.write_bytes(whole[:cut])
            folder.finish()
