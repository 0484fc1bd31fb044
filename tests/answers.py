"""Answers that several tests look at, each worked out once in a process."""

from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp

import tendon_cli as tendon
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver

_FOLDER = TemporaryDirectory(prefix="answers-")
_KNOWN = {}


def answered(content):
    """Return the answer to a study, in a folder of its own, which no test changes.

    Tests that patch the package call `tendon.design` themselves.
    """
    written = repr(content)
    if written not in _KNOWN:
        folder = Path(mkdtemp(dir=_FOLDER.name)) / "answer"
        _KNOWN[written] = tendon.design(content, folder, jobs=1)
    return _KNOWN[written]


def solved(content):
    """Return all choices of a study as they are solved, without an answer about them."""
    question = question_of(tendon.study(content))
    return solve(Solver(question), question.all_points())


def merged(*contents):
    """Return one study of several, of which a later one replaces single keys of tables."""
    study = {}
    for content in contents:
        for name, value in content.items():
            is_table = isinstance(value, dict)
            study[name] = {**study.get(name, {}), **value} if is_table else value
    return study
