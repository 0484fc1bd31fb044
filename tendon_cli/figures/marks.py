"""Signs that figures of lines have in common."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tendon_cli.figures.engine import Axes
from tendon_cli.figures.scales import Scale
from tendon_cli.figures.style import FAINT


def hatch_unknown(axes: Axes, x: Scale, unknown: npt.NDArray[np.bool_]) -> None:
    """Hatch the stretches of x on which no line has a value; `unknown` is in the order of the scale's places."""
    changes = np.flatnonzero(np.diff(np.concatenate(([False], unknown, [False])).astype(np.int8)))
    for start, stop in changes.reshape(-1, 2):
        left, right = x.edges[start], x.edges[stop]
        axes.axvspan(left, right, facecolor="#efefef", hatch="////", edgecolor=FAINT, linewidth=0.0, zorder=0.6)
