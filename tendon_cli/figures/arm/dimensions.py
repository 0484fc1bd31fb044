"""Dimension lines of technical drawings: an arrow at both ends, and what it measures written along it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.figures.engine import Axes, FancyArrowPatch
from tendon_cli.figures.style import INK

Points = npt.NDArray[np.float64]

PAPER: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}


def dimension(axes: Axes, start: Points, end: Points, text: str, *, offset: Points | None = None) -> None:
    """Measure from `start` to `end`, the line moved by `offset`, with thin lines that lead to it."""
    shift = np.zeros(2) if offset is None else offset
    for point in (start, end) if offset is not None else ():
        axes.plot(*np.array([point, point + shift * 1.04]).T, color="#9a9a9a", linewidth=0.35, zorder=1.1)
    arrow(axes, start + shift, end + shift, style="<|-|>")
    middle = (start + end) / 2.0 + shift
    x, y = middle
    axes.text(x, y, text, rotation=_readable(end - start), ha="center", va="center", size=6.5, bbox=PAPER, zorder=6)


def arrow(axes: Axes, start: Points, end: Points, *, style: str = "-|>", color: str = INK) -> None:
    """A thin arrow."""
    patch = FancyArrowPatch(tuple(start), tuple(end), arrowstyle=style, mutation_scale=4.5, linewidth=0.5, color=color,
                            shrinkA=0.0, shrinkB=0.0, zorder=5)  # fmt: skip
    axes.add_patch(patch)


def scale_bar(axes: Axes, at: Points, length: float) -> None:
    """How long `length` mm are in the drawing, the bar ending at `at`."""
    axes.plot([at[0] - length, at[0]], [at[1], at[1]], color=INK, linewidth=1.4, solid_capstyle="butt", gid="scale")
    axes.annotate(f"{length:g} mm", (at[0] - length / 2.0, at[1]), xytext=(0, -2), textcoords="offset points",
                  ha="center", va="top", size=6.5)  # fmt: skip


def round_length(length: float) -> float:
    """The next round length below: 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9))


def _readable(direction: Points) -> float:
    """The angle of a line in degrees, turned so that text along it is not upside down."""
    angle = math.degrees(math.atan2(direction[1], direction[0]))
    return -((90.0 - angle) % 180.0 - 90.0)
