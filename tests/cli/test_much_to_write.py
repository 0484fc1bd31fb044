"""A command that will write much says so before it starts, and asks on a terminal."""

import os
import threading
from pathlib import Path

import pytest

from tendon_cli import terminal
from tendon_cli.commands import compute
from tendon_cli.errors import Stopped

STUDY = """
[spring]
stiffness = ["5 kN/m", "6 kN/m", "7 kN/m"]
[spool]
ratio = 0.6
[load]
mass = ["0 kg", "2 kg"]
"""
VERBS = pytest.mark.parametrize("verb", ["sweep", "design"])
WORDS = ("study.toml", "--out", "run", "--no-figures")


@pytest.fixture
def ask(tendon, write_study, monkeypatch):
    """Return a function that runs a verb for which little is much, and counts its questions.

    Its answer is None where there is no terminal.
    """
    write_study(STUDY)
    questions = []

    def run(verb, *words, note=1, question=1, answer=None):
        def answered(text, _stop):
            questions.append(text)
            return answer

        monkeypatch.setattr(compute, "_WORTH_A_NOTE", note)
        monkeypatch.setattr(compute, "_WORTH_A_QUESTION", question)
        monkeypatch.setattr(compute, "can_ask", lambda: answer is not None)
        monkeypatch.setattr(compute, "is_confirmed", answered)
        return tendon(verb, *WORDS, *words)

    run.questions = questions
    return run


@VERBS
def test_who_says_no_finds_nothing_written(ask, verb):
    ran = ask(verb, answer=False)
    assert ran.exit == 2
    assert "nothing is written" in ran.err
    assert "--yes" in ran.err
    assert not Path("run").exists()
    assert ask(verb, answer=True).exit == 0
    assert len(ask.questions) == 2
    # A run that stands or is resumed was agreed to; one that replaces it was not.
    assert "up to date" in ask(verb, answer=False).out
    assert len(ask.questions) == 2
    assert ask(verb, "--overwrite", answer=False).exit == 2
    assert "up to date" in ask(verb).out


@VERBS
def test_without_a_terminal_it_is_said_and_yes_asks_nothing(ask, verb):
    ran = ask(verb)
    assert (ran.exit, ask.questions) == (0, [])
    assert "run: about " in ran.err
    assert " will be written" in ran.err
    ran = ask(verb, "--overwrite", "--yes", answer=False)
    assert (ran.exit, ask.questions) == (0, [])
    assert " will be written" in ran.err
    assert ask(verb, "--overwrite", "--quiet").err == ""


@VERBS
def test_what_is_said_is_what_is_written(ask, tendon, verb):
    expected = tendon(verb, *WORDS, "--dry-run", "--json").json["bytes"]
    assert "will be written" not in ask(verb, note=expected).err
    assert "will be written" in ask(verb, "--overwrite", note=expected - 1).err


def test_a_choice_takes_as_much_as_is_said(tendon, write_study):
    grid = '{ from = "3 kN/m", to = "9 kN/m", num = 800 }'
    write_study(STUDY.replace('["5 kN/m", "6 kN/m", "7 kN/m"]', grid))
    few = ("--set", 'motion.elbow_angle=["0 deg", "90 deg"]')
    expected = tendon("design", *WORDS, *few, "--dry-run", "--json").json["bytes"]
    record = tendon("design", *WORDS, *few, "--json").json
    written = sum(file["size"] for file in record["files"])
    assert 0.4 * written < expected < 2.0 * written


@pytest.mark.parametrize("text", ["y", "yes", "n", ""])
def test_only_yes_is_yes(monkeypatch, capsys, text):
    read, write = os.pipe()
    with os.fdopen(read) as answers:
        os.write(write, f"{text}\n".encode())
        os.close(write)
        monkeypatch.setattr("sys.stdin", answers)
        assert terminal.is_confirmed("Go on?", threading.Event()) is text.startswith("y")
    assert capsys.readouterr().err == "Go on? [y/N] "


def test_a_signal_is_an_answer(monkeypatch):
    read, write = os.pipe()
    stop = threading.Event()
    stop.set()
    with os.fdopen(read) as answers:
        monkeypatch.setattr("sys.stdin", answers)
        with pytest.raises(Stopped):
            terminal.is_confirmed("Go on?", stop)
    os.close(write)
