"""The corner between a rise and a level in noisy rows."""

from __future__ import annotations

import numpy as np

from tendon_cli.friction.reading.readings import Floats

_BINS = 96


def find_corner(height: Floats) -> int:
    """Row at which a rise turns into a level; 0 where the rows do not bend that way.

    Two straight lines that meet are fitted by least squares, for each meeting point on a grid at once: what a bend at
    one point explains beyond one straight line is its projection.
    """
    size = len(height)
    bins = min(_BINS, size)
    if bins < 4:
        return 0
    edges = np.linspace(0, size, bins + 1).astype(np.int64)
    y = np.add.reduceat(height, edges[:-1]) / np.diff(edges)
    t = (edges[:-1] + edges[1:] - 1) / 2.0
    straight, _ = np.linalg.qr(np.stack([np.ones(bins), t], axis=1))
    bends = np.maximum(t[:, None] - t[None, 1:-1], 0.0)
    bends -= straight @ (straight.T @ bends)
    along = bends.T @ y
    # Only a bend downward, from a rise to a level, is a corner of this kind.
    explained = np.where(along < 0.0, along**2 / np.maximum(np.sum(bends**2, axis=0), 1e-300), 0.0)
    best = int(np.argmax(explained))
    return int(np.ceil(t[best + 1])) + 1 if explained[best] > 0.0 else 0
