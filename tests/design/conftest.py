"""Answers that several modules look at, each worked out once in a process."""

import pytest

import tendon_cli as tendon

from .test_text import KINDS


@pytest.fixture(scope="session")
def answer_of_kind(tmp_path_factory):
    """Return a function that gives an answer of `KINDS` and the file of its record."""
    known = {}

    def answer_of(name):
        if name not in known:
            folder = tmp_path_factory.mktemp("answers") / "answer"
            answer = tendon.design(tendon.study(KINDS[name]), folder)
            known[name] = answer, folder / "design.json"
        return known[name]

    return answer_of
