"""Commands end quietly on Ctrl-C, by a code of their own, with nothing raw on a terminal."""

import json
import resource
import shutil
import signal
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

import tendon_cli as tendon_library
from tendon_cli import terminal
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import is_memory_short
from tests.cli import endings
from tests.cli.conftest import set_options
from tests.sampled import quick_and_torture

INTERRUPTED = """
import os, sys

module = sys.argv.pop(1)
number = int(sys.argv.pop(1))

class Interrupts:
    def find_spec(self, name, *_):
        if name == module:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), number)

sys.meta_path.insert(0, Interrupts())
from tendon_cli.__main__ import main
main()
"""
STUDY = '[load]\nmass = ["0 kg", "5 kg"]\n'


@pytest.fixture
def study(write_study):
    return write_study(STUDY)


# --- Signals --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("module", "number"),
    [
        ("typer", signal.SIGINT),
        ("tendon_cli.commands.studies", signal.SIGINT),
        ("numpy", signal.SIGINT),
        ("pyarrow.lib", signal.SIGINT),
        ("tendon_cli.commands.cli", signal.SIGINT),
        ("tendon_cli.commands.cli", signal.SIGTERM),
        ("tendon_cli.commands.cli", signal.SIGHUP),
    ],
)
@pytest.mark.parametrize("command", ["sweep", "state"])
def test_a_signal_while_modules_are_read_ends_quietly(outside, study, module, number, command):
    words = (command, "study.toml")
    if command == "state" and module == "pyarrow.lib":  # `state` imports no pyarrow
        module = "matplotlib"
        words = ("plot", "study.toml", "--arm")
    ran = outside("-c", INTERRUPTED, module, int(number), *words, python=True)
    assert (ran.exit, ran.out) == (128 + number, "")
    assert "Traceback" not in ran.err
    assert not (study.parent / "results").exists()


# --- Threads --------------------------------------------------------------------------------------

COUNTED_LIBRARY = """
import os, sys
from tendon_cli.commands.startup import spare_time
spare_time()  # else NumPy starts threads, too
import pandas, xarray, pyarrow.compute, pyarrow.parquet

def threads():
    return len(os.listdir("/proc/self/task"))

before = threads()
import tendon_cli as tendon
run = tendon.open("run")
columns = len(run.designs.columns) + len(run.states.columns)
dataset = run.to_xarray()
answer = tendon.design({"uncertainty": {"usual": False}}, jobs=1)
assert columns and len(answer.choices) and dataset
print(threads() - before, file=sys.stderr)
"""
COUNTED = """
import json, os, sys
from tendon_cli.commands.startup import spare_time
spare_time()  # else NumPy starts threads, too
import pyarrow.compute, pyarrow.csv, pyarrow.parquet
import matplotlib.figure, pandas, scipy.optimize, scipy.stats, tendon_cli.studies.load
from tendon_cli.commands.cli import main

def threads():
    return len(os.listdir("/proc/self/task"))

for words in json.loads(sys.argv[1]):
    child = os.fork()
    if child == 0:
        before = threads()
        try:
            main(words)
        except SystemExit as end:
            with open("counted", "a") as file:
                print(json.dumps([words, end.code, threads() - before]), file=file)
        os._exit(0)
    os.waitpid(child, 0)
"""
"""Runs each command in a process of its own, and counts the threads that it leaves."""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return a folder with the files that commands read, and the run of the study."""
    folder = tmp_path_factory.mktemp("made")
    endings.write_inputs(folder)
    tendon_library.sweep(folder / "study.toml", folder / "run")
    return folder


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux lists the threads of a process")
def test_no_command_ends_while_threads_of_arrow_run(outside, made, workplace):
    """They may need Python when it is gone, and then end the process by abort()."""
    shutil.copytree(made, workplace, dirs_exist_ok=True)
    ran = outside("-c", COUNTED, json.dumps(endings.WORDS), python=True)
    counted = [json.loads(line) for line in (workplace / "counted").read_text().splitlines()]
    assert [words for words, _, _ in counted] == [[*words] for words in endings.WORDS], ran.err
    assert {code for _, code, _ in counted} <= endings.EXITS, ran.err
    assert [words for words, _, threads in counted if threads] == []


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux lists the threads of a process")
def test_no_session_ends_while_threads_of_arrow_run(outside, made, workplace):
    pytest.importorskip("xarray")
    shutil.copytree(made, workplace, dirs_exist_ok=True)
    ran = outside("-c", COUNTED_LIBRARY, python=True)
    assert ran.exit == 0, ran.err
    assert ran.err.splitlines()[-1] == "0"


@pytest.mark.torture
@pytest.mark.parametrize("words", endings.WORDS, ids=lambda words: " ".join(words[:2]))
def test_four_hundred_commands_end_on_a_busy_machine(outside, workplace, words):
    endings.write_inputs(workplace)
    if words[0] in endings.READERS:
        assert outside("sweep", "study.toml", "--no-figures", "--out", "run").exit == 0

    def run(number):
        place = workplace / str(number)
        shutil.copytree(workplace, place, ignore=lambda _, names: {*filter(str.isdigit, names)})
        ran = outside("-m", "tendon_cli", *words, python=True, cwd=place)
        shutil.rmtree(place)
        return ran

    with ThreadPoolExecutor(8) as pool:
        ends = list(pool.map(run, range(endings.TIMES)))
    assert {ran.exit for ran in ends} <= endings.EXITS
    assert not any("terminate" in ran.err for ran in ends)


# --- Memory ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_part_without_memory_says_so_and_resumes(tendon, study, monkeypatch, jobs):
    def short(*_):
        raise MemoryError("Unable to allocate 9.00 GiB")

    with monkeypatch.context() as patch:
        patch.setattr(Sweep, "fill", short)
        ran = tendon("sweep", study, "--json", "--jobs", jobs)
    error = ran.json["error"]
    assert (ran.exit, error["kind"]) == (6, "memory")
    assert "memory" in error["message"]
    assert "--resume" in error["hint"]
    assert tendon("sweep", study, "--resume", "--no-figures").exit == 0


@pytest.mark.skipif(sys.platform != "linux", reason="limits of addresses are Linux's")
@pytest.mark.parametrize("megabytes", quick_and_torture([260], [420, 700]))
def test_under_a_limit_of_addresses_the_message_says_memory(outside, write_study, megabytes):
    write_study('[tendon]\npretension = { from = "60 N", to = "240 N", num = 400 }\n')
    limit = megabytes * 10**6

    def restrict():
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

    words = ("sweep", "study.toml", "--no-figures", "--out", "run")
    ran = outside(*words, preexec_fn=restrict)
    assert ran.exit in (0, 6), ran.err
    if ran.exit == 6:
        assert "memory" in ran.err
    assert "Traceback" not in ran.err
    assert outside(*words, "--resume").exit == 0


def test_what_the_system_says_of_memory_is_known():
    assert is_memory_short(MemoryError())
    assert is_memory_short(OSError(12, "Cannot allocate memory"))
    assert is_memory_short(RuntimeError("can't start new thread"))
    assert not is_memory_short(OSError(28, "No space left on device"))
    assert not is_memory_short(ValueError("malloc of size 5 failed"))


# --- Text on a terminal ---------------------------------------------------------------------------

RAW = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202e"


@pytest.mark.parametrize(
    "words",
    [
        ("sweep", f"{RAW}.toml"),
        ("state", "study.toml", "--case", RAW),
        ("sweep", "study.toml", "--set", f"{RAW}=1"),
        ("sweep", "study.toml", "--scheduler", f"tcp://{RAW}:1"),
        ("plot", RAW),
        ("fit-friction", RAW, "--bend-angle", "1 rad"),
        ("sweep", "study.toml", "--out", f"{RAW}/run", "--no-figures"),
        ("sweep", "study.toml", "--out", "run"),
    ],
    ids=lambda words: " ".join(words[:1] + words[2:3]),
)
@pytest.mark.parametrize("as_json", [False, True])
def test_no_raw_escape_reaches_a_terminal(tendon, study, words, as_json):
    (study.parent / "run").mkdir()
    (study.parent / "run" / RAW).touch()
    if as_json:
        words += ("--json",)
    ran = tendon(*words)
    printed = ran.out + ran.err
    assert printed
    assert all(character.isprintable() or character == "\n" for character in printed)
    if as_json:
        assert ran.json


@pytest.mark.parametrize("text", ["plain", "Bärbel 力 μφ\nsecond", RAW, "\udcff", "\U000e0041"])
def test_harmless_text_says_the_same_as_json_would(text):
    shown = json.loads('"' + terminal.harmless(text).replace("\n", "\\n") + '"')
    assert shown.encode("utf-16", "surrogatepass") == text.encode("utf-16", "surrogatepass")


# --- No equilibrium -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("angle", "mass", "code", "shown"),
    [
        ("75 deg", "5 kg", 0, "Status: extensor slack"),
        ("170 deg", "5 kg", 4, "no pair of tensions balances"),
        ("-60 deg", "0 kg", 4, "need not be the only one"),
    ],
)
def test_a_state_without_equilibrium_is_exit_4_and_says_what_that_means(
    tendon, study, angle, mass, code, shown
):
    settings = (f"motion.elbow_angle={angle}", f"load.mass={mass}", "model.slack=bilateral")
    words = ("state", study, *set_options(*settings))
    ran = tendon(*words)
    assert ran.exit == code
    assert shown in ran.out
    assert tendon(*words, "--json").exit == code


def test_the_summary_says_what_feasible_means_and_how_long_figures_took(tendon, write_study):
    write_study('[tendon]\npretension = ["90 N", "130 N"]\n[spool]\nratio = [0.7, 1.0]\n')
    lines = tendon("sweep", "study.toml").out.splitlines()
    run = tendon("sweep", "study.toml", "--json").json
    assert run["figure_seconds"] > 0.0
    assert "figures in " in lines[0]
    for name in ("feasible", "taut", "stable"):
        (line,) = (line for line in lines if line.strip().startswith(name))
        assert f"{run[name]} of 4 designs" in line
    dry_run = ("sweep", "study.toml", "--dry-run")
    assert "for figures" in tendon(*dry_run).out
    assert "for figures" not in tendon(*dry_run, "--no-figures").out
