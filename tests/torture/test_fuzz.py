"""Hostile files: whatever they hold, they are taken or refused with one message, soon, and in little memory."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from .hostile.tally import LONGEST, MOST_MEGABYTES
from .tools import some

HERE = Path(__file__).parent
CORPUS = HERE / "corpus/faults"


def fuzzed(kind, cases, folder):
    ran = subprocess.run(
        [sys.executable, "-W", "error", "-m", "hostile.fuzz", kind, str(cases), str(folder)],
        check=False, capture_output=True, text=True, timeout=1500, cwd=HERE,
    )  # fmt: skip
    assert ran.returncode == 0, f"the process itself ended, on the case in its folder: {ran.returncode} {ran.stderr}"
    return json.loads((folder / "tally.json").read_text("utf-8"))


def assert_modest(tally, cases):
    assert tally["cases"] == cases
    assert tally["slowest"] < LONGEST
    assert tally["peak_megabytes"] < MOST_MEGABYTES
    assert tally["taken"] > cases // 50, "nearly nothing was valid: such cases go no deeper than the parser"


CASES = some([300], [20_000])


TEXTS = [
    ("study", 300),
    ("friction", 300),
    pytest.param("study", 20_000, marks=pytest.mark.torture),
    pytest.param("friction", 20_000, marks=pytest.mark.torture),
]


@pytest.mark.parametrize(("kind", "cases"), TEXTS)
def test_text_files_end_in_one_message_or_are_taken(tmp_path, kind, cases):
    tally = fuzzed(kind, cases, tmp_path)
    assert_modest(tally, cases)
    assert tally["faults"] == {}


@pytest.fixture(scope="module", params=CASES)
def parquet_tally(request, tmp_path_factory):
    return fuzzed("parquet", request.param, tmp_path_factory.mktemp("parquet")), request.param


def test_tables_cost_little_time_and_memory(parquet_tally):
    assert_modest(*parquet_tally)


def test_tables_end_in_one_message_or_are_taken(parquet_tally):
    assert parquet_tally[0]["faults"] == {}


@pytest.mark.parametrize("file", sorted(CORPUS.iterdir()), ids=lambda file: file.name)
def test_what_fuzzing_once_found_ends_in_one_message(tendon, file):
    """Files that ended otherwise once."""
    words = {
        ".parquet": ("plot", file, "--out", "figure.png"),
        ".csv": ("fit-friction", file, *(() if b"bend" in file.read_bytes() else ("--bend-angle", "144 deg"))),
    }
    for form in ((), ("--json",)):
        ran = tendon(*words.get(file.suffix, ("state", file)), *form)
        assert ran.exit in (0, 2, 3), ran.out + ran.err
