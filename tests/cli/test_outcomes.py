"""Exit codes are reached for real, JSON is one object whatever happens, an error one message."""

import errno
import gc
import json
import os
import subprocess
from pathlib import Path

import pytest

from tendon_cli.engine import sweep as sweep_module
from tendon_cli.studies import load
from tests.cli.conftest import set_options

STUDY = '[load]\nmass = ["0 kg", "3 kg"]\n[motion]\nelbow_angle = ["10 deg", "80 deg"]\n'
RECORD_KEYS = {
    "study_hash",
    "designs",
    "states",
    "taut",
    "stable",
    "feasible",
    "slack",
    "no_equilibrium",
    "unstable",
    "files",
    "seconds",
    "versions",
    "warnings",
}


@pytest.fixture
def study(write_study):
    """Return the file of a study of four states."""
    return write_study(STUDY)


def test_states_without_equilibrium_are_exit_4_unless_allowed(tendon, study):
    words = ["sweep", study, "--no-figures", "--json"]
    words += set_options('motion.elbow_angle=["10 deg", "170 deg"]')
    first = tendon(*words, "--out", "a")
    assert (first.exit, first.json["no_equilibrium"]) == (4, 4)
    assert any("no equilibrium" in warning for warning in first.json["warnings"])
    assert tendon(*words, "--out", "b", "--allow-no-equilibrium").exit == 0
    again = tendon(*words, "--out", "a")
    assert again.exit == 4
    assert tendon(*words, "--out", "a", "--allow-no-equilibrium").exit == 0


def test_a_part_that_fails_is_exit_6_and_named_by_case_and_axes(
    tendon, study, monkeypatch, muttered
):
    def fails(_inputs, _block, _keys):
        raise FloatingPointError("something odd")

    study.write_text(STUDY + '[[cases]]\nname = "tall"\n', encoding="utf-8")
    monkeypatch.setattr(sweep_module, "state_rows", fails)
    ran = tendon("sweep", study, "--no-figures", "--json")
    gc.collect()  # while `muttered` still collects the messages of finalizers
    assert (ran.exit, ran.json["error"]["kind"]) == (6, "workers")
    assert "tall" in ran.json["error"]["message"]
    assert "load.mass=" in ran.json["error"]["message"]


def test_a_bug_is_exit_1_and_says_so(tendon, study, monkeypatch):
    def broken(*_args, **_options):
        raise ZeroDivisionError("oops")

    monkeypatch.setattr(load, "read_document", broken)
    ran = tendon("sweep", study, "--json")
    assert (ran.exit, ran.json["error"]["kind"]) == (1, "bug")
    assert "--debug" in ran.json["error"]["hint"]


# --- Output that cannot be written ----------------------------------------------------------------


def assert_one_error(text):
    """Assert that a text is one error message of one line, and perhaps a hint on a second."""
    assert text.startswith("tendon: error: "), text
    assert len(text.strip().splitlines()) <= 2, text
    assert "Traceback" not in text


UNWRITABLE = [
    ("full", "state study.toml"),
    ("full", "sweep study.toml --no-figures --json"),
    ("full", "--version"),
    ("full", "sweep --help"),
    ("full", "unbuffered --help"),
    ("closed", "--version"),
    ("closed", "sweep study.toml --no-figures"),
    ("left", "init --schema"),
    ("left", "sweep --help"),
    ("left", ""),
]
"""Standard output as a full device, closed, or a pipe whose reader has left; a command line."""


@pytest.mark.parametrize(("stdout", "line"), UNWRITABLE)
def test_a_stdout_that_takes_nothing_is_exit_5_and_one_line(outside, study, stdout, line):
    if stdout == "full" and not Path("/dev/full").exists():
        pytest.skip("the system has no /dev/full")
    words = line.split()
    is_unbuffered = "unbuffered" in words
    unbuffered = ""
    if is_unbuffered:
        words.remove("unbuffered")
        unbuffered = "1"
    environment = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    options = {"capture_output": False, "stderr": subprocess.PIPE, "env": environment}
    if stdout == "left":
        reading, writing = os.pipe()
        os.close(reading)
        options["stdout"] = writing
    elif stdout == "full":
        options["stdout"] = os.open("/dev/full", os.O_WRONLY)
    else:
        options["stdout"] = subprocess.PIPE
        options["preexec_fn"] = lambda: os.close(1)
    ran = outside(*words, **options)
    if stdout != "closed":
        os.close(options["stdout"])
    assert ran.exit == 5
    is_help = "--help" in line or not line
    if stdout == "left" and is_help:
        assert ran.err == ""
    else:
        assert_one_error(ran.err)
    if stdout == "full" and not is_unbuffered:
        assert "standard output cannot be written" in ran.err


@pytest.mark.parametrize("named", [True, False])
def test_any_oserror_is_one_message_and_one_object(tendon, study, monkeypatch, named):
    file = "some/file" if named else None

    def failing(*_args, **_options):
        raise OSError(errno.EIO, os.strerror(errno.EIO), file)

    monkeypatch.setattr(load, "read_document", failing)
    ran = tendon("sweep", study, "--json")
    assert (ran.exit, ran.err) == (5, "")
    assert ran.json["error"]["where"] == file
    assert os.strerror(errno.EIO) in ran.json["error"]["message"]
    assert tendon("sweep", study).err.count("tendon: error: ") == 1
    assert tendon("--version").exit == 0, "stdout was given up"


def test_a_closed_stderr_changes_nothing(outside, study):
    ran = outside("sweep", study, "--no-figures", "--json", preexec_fn=lambda: os.close(2))
    assert ran.exit == 0
    assert ran.json["designs"] == 2


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is forbidden to this user")
def test_a_folder_without_permission_is_exit_5(tendon, study):
    Path("closed").mkdir(mode=0o500)
    assert tendon("sweep", study, "--no-figures", "--out", "closed/run").exit == 5


# --- Printed text ---------------------------------------------------------------------------------


@pytest.mark.parametrize("words", [(), ("--quiet",), ("--dry-run",)])
def test_json_is_exactly_one_object_and_stderr_silent(tendon, study, words):
    ran = tendon("sweep", study, "--no-figures", "--json", *words)
    assert (ran.exit, ran.err) == (0, "")
    assert ran.json["designs"] == 2


def test_json_of_a_sweep_is_run_json(tendon, study):
    ran = tendon("sweep", study, "--no-figures", "--json")
    assert set(ran.json) >= RECORD_KEYS
    assert json.loads(Path("results/study/run.json").read_text("utf-8")) == ran.json


def test_quiet_says_nothing_but_errors(tendon, study):
    long = tendon("sweep", study, "--no-figures", "--quiet")
    short = tendon("sweep", study, "--no-figures", "-q")
    assert long == short
    ran = tendon("sweep", study, "--no-figures", "--quiet", "--out", "other")
    assert (ran.exit, ran.out, ran.err) == (0, "", "")
    ran = tendon("sweep", "none.toml", "--quiet")
    assert (ran.exit, ran.out) == (2, "")
    assert "none.toml" in ran.err


def test_the_summary_is_short_and_has_the_warnings(tendon, study):
    settings = [
        "model.slack=bilateral",
        "load.mass=[0, 10]",
        'motion.elbow_angle=["0 deg", "10 deg", "80 deg", "170 deg"]',
        "tendon.pretension=200 N",
    ]
    ran = tendon("sweep", study, "--no-figures", "--jobs", "1", *set_options(*settings))
    assert (ran.exit, ran.err) == (4, "")
    assert len(ran.out.splitlines()) < 12
    for word in ("no equilibrium", "bilateral", "unstable", "results/study"):
        assert word in ran.out, word


def test_progress_off_a_terminal_is_a_plain_line_per_tenth_on_stderr(tendon, study, small_parts):
    small_parts(4)
    masses = "load.mass={ from = 0, to = 9, num = 100 }"
    ran = tendon("sweep", study, "--no-figures", "--set", masses)
    lines = ran.err.splitlines()
    assert [line.split()[1] for line in lines] == [str(tenth) for tenth in range(10, 101, 10)]
    assert "\x1b" not in ran.err + ran.out
    assert "\r" not in ran.err


@pytest.mark.parametrize(
    "words", [("--debug", "sweep", "none.toml"), ("sweep", "none.toml", "--debug")]
)
def test_debug_shows_the_traceback(tendon, words):
    ran = tendon(*words)
    assert (ran.exit, "Traceback" in ran.err) == (2, True)
    assert "StudyError" in ran.err
