"""A command shows how far it is, says only what it knows, and leaves a question alone."""

from __future__ import annotations

import io
import re
from types import SimpleNamespace

import pytest

from tendon_cli import terminal
from tendon_cli.commands import compute

MOST_CELLS = 131_072
_TIME = re.compile(r"\d:\d\d:\d\d|-:--:--")


class Terminal(io.StringIO):
    """Standard error of a terminal, which keeps all that is written to it."""

    def isatty(self):
        return True


def screen_of(monkeypatch):
    """Return a terminal that stands in for standard error from now on."""
    stream = Terminal()
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "200")
    return stream


@pytest.fixture
def clock(monkeypatch):
    """Return a clock whose time, s, a test sets."""
    hand = SimpleNamespace(now=0.0)
    monkeypatch.setattr(terminal.time, "monotonic", lambda: hand.now)
    return hand


def shown_on(screen):
    """Return all that is written on a terminal, without its colours, and clear the terminal."""
    written = screen.getvalue()
    screen.seek(0)
    screen.truncate()
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "\r", written)
    lines = [line for line in re.split(r"[\r\n]", plain) if line.strip()]
    return " ".join(lines)


def test_no_bar_is_drawn_before_something_is_computed(monkeypatch):
    screen = screen_of(monkeypatch)
    with terminal.progress("study", quiet=False) as show:
        assert screen.getvalue() == ""
        show.parts(0, 3)
        assert "0/3 parts" in shown_on(screen)


@pytest.mark.parametrize("verb", ["sweep", "design"])
def test_no_bar_is_drawn_below_a_question(verb, tendon, write_study, monkeypatch):
    screen = screen_of(monkeypatch)
    study = write_study('spring.stiffness = ["5 kN/m", "6 kN/m"]\n')
    seen = []

    def is_confirmed(_question, _stop):
        seen.append(screen.getvalue())
        return True

    monkeypatch.setattr(compute, "_WORTH_A_NOTE", 1)
    monkeypatch.setattr(compute, "_WORTH_A_QUESTION", 1)
    monkeypatch.setattr(compute, "can_ask", lambda: True)
    monkeypatch.setattr(compute, "is_confirmed", is_confirmed)
    tendon(verb, study, "--out", "run", "--no-figures")
    assert seen == [""]
    assert "/1 parts" in shown_on(screen)


def test_no_time_left_is_shown_during_a_proof(monkeypatch):
    screen = screen_of(monkeypatch)
    with terminal.progress("study", quiet=False) as show:
        show.parts(0, 1)
        show.parts(1, 1)
        shown_on(screen)
        show.cells(500, MOST_CELLS)
        show.cells(2_500, MOST_CELLS)
    text = shown_on(screen)
    assert "2,500 of at most 131,072 cells" in text
    assert "left" not in text
    assert "parts" not in text
    assert len(_TIME.findall(text)) == text.count("cells")  # the time since the start alone


def test_a_time_left_is_shown_once_it_is_known(monkeypatch):
    screen = screen_of(monkeypatch)
    with terminal.progress("study", quiet=False) as show:
        show.parts(0, 3)
        assert "left" not in shown_on(screen)
        for done in (1, 2):
            show.parts(done, 3)
    assert re.search(r"2/3 parts +\d:\d\d:\d\d +\d:\d\d:\d\d +left", shown_on(screen))


def test_nobody_waits_longer_than_ten_seconds_for_a_line(clock, capsys):
    with terminal.progress("study", quiet=False) as show:
        for second in range(1, 41):
            clock.now = float(second)
            show.cells(60 * second, MOST_CELLS)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 4
    for line, second in zip(lines, (10, 20, 30, 40), strict=True):
        assert line == f"study: proof: {60 * second:,} of at most 131,072 cells"


def test_a_long_run_does_not_fill_a_log(clock, capsys):
    parts = 36_000
    with terminal.progress("study", quiet=False) as show:
        for done in range(1, parts + 1):
            clock.now = float(done)  # a part each second, for ten hours
            show.parts(done, parts)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) < 100
    for tenth in range(1, 11):
        assert f"study: {10 * tenth} % ({3_600 * tenth:,} of 36,000 parts)" in lines


def test_a_quick_run_has_a_line_for_every_tenth_alone(clock, capsys):
    with terminal.progress("study", quiet=False) as show:
        for done in range(101):
            clock.now = 0.05 * done
            show.parts(done, 100)
    assert len(capsys.readouterr().err.splitlines()) == 10
