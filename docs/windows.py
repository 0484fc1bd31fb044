"""Draws windows as bars, of a table as docs/from-model-to-suit.md prints it: `... | python docs/windows.py FILE`."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from tendon_cli.figures.backend import Line2D, Patch
from tendon_cli.figures.frame import framed
from tendon_cli.figures.style import FAINT, OKABE_ITO, house_style

SUITS = ("K 5 kN/m, η 0.6", "K 8 kN/m, η 0.5")
_ENDS = re.compile(r"([\d.]+) to ([\d.]+) N|none")


def draw(table: str, path: Path) -> Path:
    """A row of bars for each line: its effect, then the window of each suit; the first line is what others go from."""
    rows = [
        (line[: _ENDS.search(line).start()].strip(), [*_ENDS.finditer(line)])
        for line in table.splitlines()
    ]
    key = [
        Patch(facecolor=colour, label=suit) for suit, colour in zip(SUITS, OKABE_ITO, strict=False)
    ]
    key.append(
        Line2D([], [], color=FAINT, linestyle=(0, (3, 2)), linewidth=0.8, label="as in the model")
    )
    notes = ["Pretensions that suit an empty hand and 10 kg at every angle, each effect by itself."]
    with house_style():
        page = framed("What each effect makes of the window", 8.0 * len(rows) + 12.0, key, notes)
        panel = page.figure.subplots()
        for at, (_, windows) in enumerate(rows):
            for suit, (window, shift) in enumerate(zip(windows, (-0.19, 0.19), strict=True)):
                if window[1] is None:
                    panel.text(
                        4.0, at + shift, "no window", color=OKABE_ITO[suit], va="center", size=6.5
                    )
                    continue
                low, high = float(window[1]), float(window[2])
                panel.barh(at + shift, high - low, 0.34, low, color=OKABE_ITO[suit])
                panel.text(
                    high + 3.0,
                    at + shift,
                    f"{low:.0f} to {high:.0f} N",
                    va="center",
                    size=6.5,
                    bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4},
                )
        for suit, window in enumerate(rows[0][1]):
            for end in (window[1], window[2]):
                panel.axvline(
                    float(end),
                    color=OKABE_ITO[suit],
                    linestyle=(0, (3, 2)),
                    linewidth=0.6,
                    zorder=0.5,
                )
        panel.set_yticks(range(len(rows)), [name for name, _ in rows])
        panel.set(xlabel="pretension F₀ (N)", xlim=(0.0, 440.0), ylim=(len(rows) - 0.5, -0.5))
    return page.save(path)


if __name__ == "__main__":
    draw(sys.stdin.read(), Path(sys.argv[1]))
