"""matplotlib, imported so that nothing in the working directory or the environment reaches a figure.

A `matplotlibrc` in the working directory, MATPLOTLIBRC and MPLBACKEND can change every figure, and some values stop
the import itself. The canvases are used directly, so no backend is ever chosen. Only figures modules import this one.
"""

from __future__ import annotations

import contextlib
import importlib.util
import logging
import os
import sys
from collections.abc import Iterator
from pathlib import Path

_VARIABLES = ("MATPLOTLIBRC", "MPLBACKEND")


@contextlib.contextmanager
def _undisturbed() -> Iterator[None]:
    """Let matplotlib read its own defaults: it looks for settings in the working directory before anywhere else."""
    # Notes on caches and settings files are not for the people who asked for a figure.
    logging.getLogger("matplotlib").setLevel(logging.CRITICAL)
    spec = importlib.util.find_spec("matplotlib")
    if "matplotlib" in sys.modules or spec is None or spec.origin is None:
        yield
        return
    kept = {name: os.environ.pop(name) for name in _VARIABLES if name in os.environ}
    here = _open_folder()
    try:
        if here is not None:
            os.chdir(Path(spec.origin).parent / "mpl-data")
        yield
    finally:
        os.environ.update(kept)
        if here is not None:
            os.fchdir(here)
            os.close(here)


def _open_folder() -> int | None:
    try:
        return os.open(".", os.O_RDONLY)
    except OSError:
        return None


with _undisturbed():
    import matplotlib as mpl
    from matplotlib import ticker
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.colors import LinearSegmentedColormap, ListedColormap, TwoSlopeNorm
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.lines import Line2D
    from matplotlib.patches import Arc, Circle, FancyArrowPatch, Patch
    from matplotlib.patheffects import Normal, TickedStroke, withStroke

__all__ = [
    "Arc",
    "Artist",
    "Axes",
    "Circle",
    "ConstrainedLayoutEngine",
    "FancyArrowPatch",
    "Figure",
    "FigureCanvasAgg",
    "Line2D",
    "LinearSegmentedColormap",
    "ListedColormap",
    "Normal",
    "Patch",
    "TickedStroke",
    "TwoSlopeNorm",
    "mpl",
    "ticker",
    "withStroke",
]
