"""Commands answer alike to names that no file can have, other writers, and signals."""

import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import tendon_cli as tendon_library
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import TendonError
from tendon_cli.files import path_of, result_path, whole_file, write_whole
from tests.sampled import check_all, quick_and_torture

STUDY = '[load]\nmass = ["0 kg", "5 kg"]\n[motion]\nspeed = "60 deg/s"\n'
PLACES = [
    ("sweep", "study.toml", "--out"),
    ("design", "study.toml", "--out"),
    ("check",),
    ("check", "run", "--baseline"),
    ("show",),
    ("export",),
    ("export", "run"),
    ("plot",),
    ("plot", "run", "--out"),
    ("report",),
    ("report", "run", "--out"),
    ("state",),
    ("state", "study.toml", "--plot"),
    ("sweep",),
    ("init",),
    ("fit-friction",),
    ("fit-friction", "r.csv", "--plot"),
    ("fit-friction", "r.csv", "--out"),
]


@pytest.fixture
def study(write_study):
    return write_study(STUDY)


# --- Names ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("", "the name is empty"),
        ("x" * 300, "the name is too long"),
        (f"a/{'ä' * 128}", "the name is too long"),
        ("b/" * 2100, "the name is too long"),
    ],
)
def test_a_name_that_no_file_can_have_is_refused_alike_in_every_command(
    tendon, study, name, problem
):
    before = sorted(study.parent.rglob("*"))

    def check(*words):
        line = [*words, name]
        if words == ("export",):
            line.append("x.csv")
        ran = tendon(*line)
        assert ran.exit == 2, ran.err
        assert problem in ran.err
        assert sorted(study.parent.rglob("*")) == before

    check_all(check, PLACES)


def test_a_name_that_is_not_utf_8_is_refused_alike(tendon, study):
    for words in PLACES:
        if words[-1] in ("--out", "--plot", "check", "report"):
            ran = tendon(*words, os.fsdecode(b"a\xff"))
            assert ran.exit == 2, words
            assert "the name is not UTF-8" in ran.err, words


@pytest.mark.parametrize(
    "name", [None, 3, b"x", [], "", " ", "a\0b", "x" * 300, "\ud800", "y/" * 3000], ids=ascii
)
@pytest.mark.parametrize(
    "function", [path_of, result_path, tendon_library.open, tendon_library.study]
)
def test_from_python_it_is_a_tendon_error_too(workplace, name, function):
    with pytest.raises(TendonError) as fault:
        function(name)
    assert fault.value.exit == 2


# --- Writers --------------------------------------------------------------------------------------


def test_a_file_that_is_called_as_a_temporary_one_is_not_touched(tendon, study, blank_figures):
    assert tendon("sweep", study, "--out", "run", "--no-figures").exit == 0
    for name in (".designs.csv.tmp", ".f.png.tmp", "run/.report.html.tmp"):
        Path(name).write_text("mine", encoding="utf-8")
    for line in ("export run designs.csv", "plot run --out f.png -y max_tension", "report run"):
        assert tendon(*line.split()).exit == 0
    texts = [path.read_text(encoding="utf-8") for path in Path().rglob(".*.tmp")]
    assert texts == ["mine", "mine", "mine"]


def test_of_two_writers_of_one_file_each_writes_it_whole(tmp_path):
    path = tmp_path / "table.csv"
    with whole_file(path) as first:
        first.write_bytes(b"first")
        write_whole(path, b"second")
        assert path.read_bytes() == b"second"
    assert path.read_bytes() == b"first"
    assert [item.name for item in tmp_path.iterdir()] == ["table.csv"]


def test_a_table_is_not_exported_over_itself(tendon, workplace):
    people = workplace / "people.csv"
    people.write_text("name,weight (kg)\nAda,62.5\n", encoding="utf-8")
    for name in ("people.csv", "./people.csv"):
        ran = tendon("export", "people.csv", name)
        assert ran.exit == 2
        assert "would be overwritten" in ran.err
    assert people.read_text(encoding="utf-8").startswith("name,weight")


# --- Signals --------------------------------------------------------------------------------------

HELD = """
import sys, time
from pathlib import Path
from tendon_cli import files

write = files._write

def write_slowly(temporary, content):
    write(temporary, content)
    Path("held").touch()
    time.sleep(30)

files._write = write_slowly
from tendon_cli.__main__ import main
main()
"""
PLOT = ("plot", "run", "-y", "max_tension", "--out", "f.png")
REPORT = ("report", "run")
SIGNALS = [(PLOT, signal.SIGINT), (REPORT, signal.SIGTERM)]
MORE_SIGNALS = [
    (REPORT, signal.SIGHUP),
    (REPORT, signal.SIGINT),
    (PLOT, signal.SIGTERM),
    (PLOT, signal.SIGHUP),
]


@pytest.mark.parametrize(("words", "number"), quick_and_torture(SIGNALS, MORE_SIGNALS))
def test_a_signal_while_a_file_is_written_leaves_none(tendon, study, words, number):
    assert tendon("sweep", study, "--out", "run", "--no-figures").exit == 0
    held = Path("held").absolute()
    before = {*study.parent.rglob("*"), held}
    command = [sys.executable, "-c", HELD, *words]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        while not held.exists() and process.poll() is None:
            time.sleep(0.01)
        process.send_signal(number)
        _, messages = process.communicate(timeout=60)
    assert (process.returncode, messages) == (128 + number, "")
    assert set(study.parent.rglob("*")) == before


def test_a_run_that_is_stopped_says_how_to_go_on(tendon, study, small_parts, monkeypatch):
    fill = Sweep.fill

    def stop_at_the_second(self, tables, index):
        if index == 1:
            os.kill(os.getpid(), signal.SIGTERM)
            while True:
                self.check_stopped()
                time.sleep(0.01)
        return fill(self, tables, index)

    small_parts(200)
    out = ("--out", "my run", "--jobs", 1)
    with monkeypatch.context() as patch:
        patch.setattr(Sweep, "fill", stop_at_the_second)
        ran = tendon("sweep", study, "--set", "sheath.friction=0.1", *out, "--no-figures", "-q")
    assert ran.exit == 143
    assert ran.err.startswith("tendon: error: my run: stopped by SIGTERM; ")
    (command,) = re.findall(r"hint: `tendon (.*)` continues where it stopped", ran.err)
    resumed = tendon(*shlex.split(command), "--no-figures", "--json")
    assert (resumed.exit, resumed.json["resumed_parts"]) == (0, 1)
