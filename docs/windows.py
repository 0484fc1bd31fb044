"""Draw windows of pretension as bars: `... | python docs/windows.py FILE`.

Reads a table as `docs/from-model-to-suit.md` prints it.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from tendon_cli.figures.backend import Line2D, Patch
from tendon_cli.figures.frame import framed
from tendon_cli.figures.style import FAINT, OKABE_ITO, house_style

SUITS = ("K 5 kN/m, η 0.6", "K 8 kN/m, η 0.5")
TITLE = "What each effect does to the window"
NOTE = "Pretensions that work for an empty hand and 10 kg at every angle, one effect at a time."
_WINDOW = re.compile(r"([\d.]+) to ([\d.]+) N|none")
_DASHED = (0, (3, 2))
_OFFSETS = (-0.19, 0.19)
"""Places of the suits' bars within a row."""


def draw(table: str, path: Path) -> Path:
    """Draw a row of bars for each line of a table: an effect, and the window of each suit.

    The first line is the model without these effects, marked by lines through all rows.

    Args:
        table: Lines of an effect and a window for each suit, such as "91 to 180 N" or "none".
        path: File to write.
    """
    effects = []
    windows_of_suits = []
    for line in table.splitlines():
        windows = list(_WINDOW.finditer(line))
        effects.append(line[: windows[0].start()].strip())
        windows_of_suits.append(windows)
    colours = OKABE_ITO[: len(SUITS)]
    key = [Patch(facecolor=colour, label=suit) for suit, colour in zip(SUITS, colours, strict=True)]
    key.append(
        Line2D([], [], color=FAINT, linestyle=_DASHED, linewidth=0.8, label="as in the model")
    )
    with house_style():
        page = framed(TITLE, 8.0 * len(effects) + 12.0, key, [NOTE])
        panel = page.figure.subplots()
        for row, windows in enumerate(windows_of_suits):
            for window, offset, colour in zip(windows, _OFFSETS, colours, strict=True):
                _draw_window(panel, window, row + offset, colour)
        for window, colour in zip(windows_of_suits[0], colours, strict=True):
            for end in window.groups():
                panel.axvline(
                    float(end), color=colour, linestyle=_DASHED, linewidth=0.6, zorder=0.5
                )
        panel.set_yticks(range(len(effects)), effects)
        panel.set(xlabel="pretension F₀ (N)", xlim=(0.0, 460.0), ylim=(len(effects) - 0.5, -0.5))
    return page.save(path)


def _draw_window(panel: Any, window: re.Match[str], y: float, colour: str) -> None:
    """Draw a bar with its numbers, or a text if there is no window."""
    if window[1] is None:
        panel.text(4.0, y, "no window", color=colour, va="center", size=6.5)
        return
    low = float(window[1])
    high = float(window[2])
    panel.barh(y, high - low, 0.34, low, color=colour)
    panel.text(
        high + 3.0,
        y,
        f"{low:.0f} to {high:.0f} N",
        va="center",
        size=6.5,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4},
    )


if __name__ == "__main__":
    draw(sys.stdin.read(), Path(sys.argv[1]))
