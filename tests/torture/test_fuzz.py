"""Hostile files are taken or refused with one message, soon and in little memory."""

import json
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tools.torture.hostile.attempts import ATTEMPTS
from tools.torture.hostile.tally import LONGEST, MOST_MEGABYTES

ROOT = Path(__file__).parents[2]
CORPUS = ROOT / "tools" / "torture" / "corpus"
REACHED = re.compile(r"cov: (\d+)")
HUNG = 3 * 3600  # seconds: no process of these takes as long on a busy machine


def fuzzed(folder, *words, warn="error", longest=LONGEST, most=MOST_MEGABYTES):
    """Run the fuzzer in a process of its own; return its tally and stderr."""
    ran = subprocess.run(
        [sys.executable, "-W", warn, "-m", "tools.torture.hostile.fuzz", *map(str, words)],
        check=False,
        capture_output=True,
        text=True,
        errors="replace",
        timeout=HUNG,
        cwd=ROOT,
    )
    assert ran.returncode == 0, (
        "the process itself ended or hung, on the file in its folder: "
        f"{ran.returncode} {ran.stderr[-2000:]}"
    )
    tally = json.loads((folder / "tally.json").read_text("utf-8"))
    assert tally["faults"] == {}
    assert tally["peak"] < most
    assert tally["slowest"] < longest
    return tally, ran.stderr


@pytest.mark.torture
@pytest.mark.parametrize("kind", ATTEMPTS)
def test_files_bred_by_chance_end_in_one_message_or_are_taken(tmp_path, kind):
    cases = 15_000
    tally, _ = fuzzed(tmp_path, kind, cases, tmp_path)
    assert tally["cases"] == cases
    assert tally["taken"] > cases // 50, (
        "nearly nothing was valid: such cases go no deeper than the parser"
    )


@pytest.mark.torture
@pytest.mark.skipif(
    find_spec("atheris") is None,
    reason="atheris is not installed; it has no wheel for every system",
)
@pytest.mark.parametrize("kind", ATTEMPTS)
def test_files_bred_by_what_they_reach_end_in_one_message_or_are_taken(tmp_path, kind):
    cases = 20_000
    tally, err = fuzzed(
        tmp_path, kind, cases, tmp_path, "--guided", CORPUS / kind, warn="default", longest=60.0
    )
    assert tally["cases"] == cases
    assert tally["taken"] > 0
    assert int(REACHED.search(err)[1]) > 200, "the modules are not watched"


def test_files_that_once_reached_something_new_end_in_one_message_or_are_taken(tmp_path):
    tally, _ = fuzzed(tmp_path, "replay", CORPUS, tmp_path)
    files = [file for kind in ATTEMPTS for file in (CORPUS / kind).iterdir()]
    assert tally["cases"] == len(files)
    assert tally["taken"] > 0
