"""The paper reproduced, once for all tests of it."""

from __future__ import annotations

import pytest

from verification.paper.reproduce import evaluate, reproduce


@pytest.fixture(scope="session")
def steps():
    """Return the list of what the progress bar was called with."""
    return []


@pytest.fixture(scope="session")
def reproduced(tmp_path_factory, steps):
    """Reproduce the paper: run its studies, draw its figures and write its ledger."""
    folder = tmp_path_factory.mktemp("reproduced")

    def progress(*counts):
        steps.append(counts)

    return reproduce(folder / "out", jobs=1, runs=folder / "runs", progress=progress)


@pytest.fixture(scope="session")
def again(reproduced):
    """Judge the finished runs once more, without drawing: the paper's tables and its ledger."""
    return evaluate(reproduced.out.parent / "runs")


@pytest.fixture(scope="session")
def paper(again):
    """Return the paper's runs, by the name of their figure."""
    runs, _ = again
    return runs
