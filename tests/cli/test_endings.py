"""How commands end: quietly on Ctrl-C, by their own code without memory or readers, with nothing raw on a terminal."""

import json
import resource
import signal
import sys

import pytest

from tendon_cli import terminal
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import is_memory_short

INTERRUPTED = """
import os, signal, sys
class Interrupts:
    def find_spec(self, name, *_):
        if name == wanted:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), number)
wanted, number = sys.argv.pop(1), int(sys.argv.pop(1))
sys.meta_path.insert(0, Interrupts())
from tendon_cli.__main__ import main
main()
"""
STUDY = '[load]\nmass = ["0 kg", "5 kg"]\n'


@pytest.fixture
def study(workplace):
    (workplace / "study.toml").write_text(STUDY, encoding="utf-8")
    return workplace / "study.toml"


# --- Signals --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("module", "number"),
    [
        *(
            (module, signal.SIGINT)
            for module in ("typer", "tendon_cli.commands.studies", "numpy", "pyarrow.lib")
        ),
        *(("tendon_cli.cli", number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)),
    ],
)
@pytest.mark.parametrize("command", ["sweep", "state"])
def test_a_signal_while_modules_are_read_ends_quietly(outside, study, module, number, command):
    words = (command, "study.toml")
    if command == "state" and module == "pyarrow.lib":
        module, words = "matplotlib", ("plot", "study.toml", "--arm")
    ran = outside("-c", INTERRUPTED, module, int(number), *words, python=True)
    assert (ran.exit, ran.out, "Traceback" in ran.err) == (128 + number, "", False)
    assert not (study.parent / "results").exists()


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
@pytest.mark.parametrize("megabytes", [260, 420, 700])
def test_under_a_limit_of_addresses_the_message_says_memory(outside, workplace, megabytes):
    text = '[tendon]\npretension = { from = "60 N", to = "240 N", num = 4000 }\n'
    (workplace / "study.toml").write_text(text, encoding="utf-8")
    limit = (megabytes * 10**6,) * 2
    words = ("sweep", "study.toml", "--no-figures", "--out", "run")
    ran = outside(*words, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, limit))
    assert ran.exit in (0, 6), ran.err
    assert ran.exit == 0 or "memory" in ran.err
    assert "Traceback" not in ran.err
    assert outside(*words, "--resume").exit == 0


def test_what_the_system_says_of_memory_is_known():
    assert is_memory_short(MemoryError())
    assert is_memory_short(OSError(12, "Cannot allocate memory"))
    assert is_memory_short(RuntimeError("can't start new thread"))
    assert not is_memory_short(OSError(28, "No space left on device"))
    assert not is_memory_short(ValueError("malloc of size 5 failed"))


# --- What reaches a terminal ----------------------------------------------------------------------

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
    ran = tendon(*words, *(["--json"] if as_json else []))
    said = ran.out + ran.err
    assert said
    assert all(sign.isprintable() or sign == "\n" for sign in said)
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
    asked = (
        "--set",
        f"motion.elbow_angle={angle}",
        "--set",
        f"load.mass={mass}",
        "--set",
        "model.slack=bilateral",
    )
    ran = tendon("state", study, *asked)
    assert (ran.exit, shown in ran.out, tendon("state", study, *asked, "--json").exit) == (
        code,
        True,
        code,
    )


def test_the_summary_says_what_feasible_means_and_how_long_figures_took(tendon, workplace):
    text = '[tendon]\npretension = ["90 N", "130 N"]\n[spool]\nratio = [0.7, 1.0]\n'
    (workplace / "study.toml").write_text(text, encoding="utf-8")
    lines = tendon("sweep", "study.toml").out.splitlines()
    run = tendon("sweep", "study.toml", "--json").json
    assert run["figure_seconds"] > 0.0
    assert "figures in " in lines[0]
    for name in ("feasible", "taut", "stable"):
        (line,) = (line for line in lines if line.strip().startswith(name))
        assert f"{run[name]} of 4 designs" in line
    for words, drawn in (((), True), (("--no-figures",), False)):
        assert ("for figures" in tendon("sweep", "study.toml", "--dry-run", *words).out) is drawn
