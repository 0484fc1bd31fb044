"""Hostile files bred by what they reach, and those that reached something new tried again."""

import json
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from .hostile.attempts import ATTEMPTS
from .hostile.tally import LONGEST, MOST_MEGABYTES
from .tools import some

HERE = Path(__file__).parent
CORPUS = HERE / "corpus"
LARGEST_CORPUS = 500_000
REACHED = re.compile(r"cov: (\d+)")


def run(module, *words):
    """A module of `hostile`, in a process of its own."""
    return subprocess.run(
        [sys.executable, "-W", "error", "-m", f"hostile.{module}", *map(str, words)],
        check=False, capture_output=True, text=True, errors="replace", timeout=3000, cwd=HERE,
    )  # fmt: skip


def tally_in(folder):
    return json.loads((folder / "tally.json").read_text("utf-8"))


def assert_sound(tally):
    assert tally["faults"] == {}
    assert tally["peak_megabytes"] < MOST_MEGABYTES


@pytest.mark.skipif(find_spec("atheris") is None, reason="atheris is not installed; it has no wheel for every system")
@pytest.mark.parametrize("cases", some([200], [20_000]))
@pytest.mark.parametrize("kind", ATTEMPTS)
def test_files_bred_by_what_they_reach_end_in_one_message_or_are_taken(tmp_path, kind, cases):
    ran = run("guided", kind, cases, tmp_path, CORPUS / kind)
    said = ran.stderr[-2000:]
    assert ran.returncode == 0, f"the process itself ended or hung, on the file in its folder: {ran.returncode} {said}"
    tally = tally_in(tmp_path)
    assert_sound(tally)
    assert (tally["cases"], tally["taken"] > 0) == (cases, True)
    reached = [int(count) for count in REACHED.findall(ran.stderr)]
    assert reached[0] > 200, "the modules are not watched"


def test_what_once_reached_something_new_ends_in_one_message_or_is_taken(tmp_path):
    ran = run("replay", CORPUS, tmp_path)
    assert ran.returncode == 0, ran.stderr
    tally = tally_in(tmp_path)
    assert_sound(tally)
    assert tally["slowest"] < LONGEST
    assert tally["cases"] == sum(1 for kind in ATTEMPTS for _ in (CORPUS / kind).iterdir())
    assert tally["taken"] > 0


def test_the_corpus_is_small():
    assert sum(file.stat().st_size for file in CORPUS.rglob("*") if file.is_file()) < LARGEST_CORPUS
