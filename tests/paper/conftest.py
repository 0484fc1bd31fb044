"""The paper reproduced, once for all tests of it."""

from __future__ import annotations

import pytest

from tendon_cli.paper.reproduce import evaluate, reproduce


@pytest.fixture(scope="session")
def steps():
    """What the progress bar was called with."""
    return []


@pytest.fixture(scope="session")
def reproduced(tmp_path_factory, steps):
    folder = tmp_path_factory.mktemp("reproduced")
    return reproduce(
        folder / "out", jobs=1, runs=folder / "runs", progress=lambda *counts: steps.append(counts)
    )


@pytest.fixture(scope="session")
def again(reproduced):
    """The paper's tables, and what is judged of them once more: the finished runs are taken, and nothing is drawn."""
    return evaluate(reproduced.out.parent / "runs")


@pytest.fixture(scope="session")
def paper(again):
    return again[0]
