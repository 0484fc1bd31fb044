"""Marks on a figure over time: where the sheath turns, the ends of the record, and the doubt."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tendon_cli.figures.backend import Axes, Patch
from tendon_cli.figures.style import INK, Colour
from tendon_cli.model.kinematics import Array
from tendon_cli.studies.filters import Truth

TURNING_WORDS = "the tendons turn"
ENDS_WORDS = "end of the record, counts for nothing"
BAND_WORDS = "the torque lies in this band"
_TURNING: dict[str, Any] = {"facecolor": "#c9ced6", "linewidth": 0.0}
_TURNING_OPACITY = 0.55
_ENDS: dict[str, Any] = {
    "facecolor": "#f6f6f6",
    "hatch": "\\\\\\\\",
    "edgecolor": "#b0b0b0",
    "linewidth": 0.0,
}
_BAND_OPACITY = 0.3


def stretches(holds: Truth, edges: Array) -> Iterator[tuple[float, float]]:
    """Yield the first and the last edge of each stretch in which something holds.

    Args:
        holds: True for the points at which it holds, (points,).
        edges: Borders of the cells around the points, (points + 1,).
    """
    bordered = np.concatenate(([False], holds, [False]))
    changes = np.flatnonzero(np.diff(bordered.astype(np.int8)))
    for start, stop in changes.reshape(-1, 2):
        yield float(edges[start]), float(edges[stop])


def cell_edges(times: Array) -> Array:
    """Return the borders of the cells around ascending times, (times + 1,), s."""
    middles = 0.5 * (times[:-1] + times[1:])
    return np.concatenate((times[:1], middles, times[-1:]))


def shade_turning(axes: Axes, turning: Truth, edges: Array, lines: int = 1) -> None:
    """Shade the time in which the sheath turns, paler if the panel has several lines.

    Args:
        axes: The panel.
        turning: True where the sheath turns, (times,).
        edges: Borders of the cells around the times, (times + 1,).
        lines: Number of lines of the panel, each with its own turns.
    """
    opacity = _TURNING_OPACITY / np.sqrt(lines)
    for first, last in stretches(turning, edges):
        axes.axvspan(first, last, alpha=opacity, zorder=0.4, gid="turning", **_TURNING)


def hatch_ends(axes: Axes, at_ends: Truth, edges: Array) -> None:
    """Hatch the ends of the record, whose states count for nothing.

    Args:
        axes: The panel.
        at_ends: True for the samples at the ends, (times,).
        edges: Borders of the cells around the times, (times + 1,).
    """
    for first, last in stretches(at_ends, edges):
        axes.axvspan(first, last, zorder=0.6, gid="record end", **_ENDS)


def draw_band(axes: Axes, times: Array, torque: Array, other: Array, colour: Colour) -> None:
    """Draw the range between both candidates of the torque while the sheath turns.

    The range closes at the samples before and after a turn.

    Args:
        axes: The panel.
        times: Times, (times,).
        torque: Torque of the direction of friction that the model takes.
        other: Torque of the other direction; NaN where the sheath does not turn.
        colour: Colour of the line.
    """
    bound = np.where(np.isfinite(other), other, torque)
    if np.isfinite(other).any():
        axes.fill_between(
            times,
            torque,
            bound,
            facecolor=colour,
            alpha=_BAND_OPACITY,
            linewidth=0.0,
            zorder=1.5,
            gid="torque band",
        )


def turning_key() -> Patch:
    """Return the entry of a key for the time in which the sheath turns."""
    return Patch(alpha=_TURNING_OPACITY, label=TURNING_WORDS, **_TURNING)


def ends_key() -> Patch:
    """Return the entry of a key for the ends of the record."""
    return Patch(label=ENDS_WORDS, **_ENDS)


def band_key() -> Patch:
    """Return the entry of a key for the range between both candidates."""
    return Patch(facecolor=INK, alpha=_BAND_OPACITY, linewidth=0.0, label=BAND_WORDS)
