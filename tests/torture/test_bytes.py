"""The same bytes for every number of jobs and every length of blocks."""

import pytest

from .tools import PARTS, STATES, STUDY

JOBS = (1, 2, 4, 8)
BLOCKS = (1, 7, 32, 2**15)


def combinations():
    sample = {(1, 2**15), (8, 7), (4, 1), (2, 32)}
    for jobs in JOBS:
        for block in BLOCKS:
            yield (jobs, block) if (jobs, block) in sample else pytest.param(jobs, block, marks=pytest.mark.torture)


@pytest.mark.parametrize(("jobs", "block_states"), list(combinations()))
def test_the_bytes_do_not_know_jobs_or_blocks(new_sweep, tmp_path, small_parts, uninterrupted, jobs, block_states):
    small_parts(STATES)
    swept = new_sweep(STUDY, tmp_path, jobs=jobs, block_states=block_states)
    assert swept.plan.parts == PARTS
    assert swept.hashes == uninterrupted
