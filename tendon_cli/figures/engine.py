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

from tendon_cli.startup import is_ours


@contextlib.contextmanager
def _undisturbed() -> Iterator[None]:
    """Let matplotlib read the settings that it ships, and no others: it looks in the working directory first."""
    # Notes on caches and settings files are not for the people who asked for a figure.
    logging.getLogger("matplotlib").setLevel(logging.CRITICAL)
    spec = importlib.util.find_spec("matplotlib")
    if "matplotlib" in sys.modules or spec is None or spec.origin is None:
        yield
        return
    own = {"MATPLOTLIBRC": str(Path(spec.origin).parent / "mpl-data/matplotlibrc"), "MPLBACKEND": "agg"}
    before = {name: os.environ.get(name) for name in own}
    exists = os.path.exists
    os.environ.update(own)
    os.path.exists = lambda path: path != "matplotlibrc" and exists(path)
    try:
        yield
    finally:
        os.path.exists = exists
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextlib.contextmanager
def _undocumented() -> Iterator[None]:
    """Spare a third of the import: how the properties of each artist are set is not written into its documentation.

    Only in a process of a command, where nobody asks for it; left as it is where matplotlib does it otherwise by now.
    """
    from matplotlib.artist import Artist

    name = "_update_set_signature_and_docstring"
    if not is_ours() or name not in vars(Artist):
        yield
        return
    before = vars(Artist)[name]
    setattr(Artist, name, classmethod(lambda _artist: None))
    try:
        yield
    finally:
        setattr(Artist, name, before)


with _undisturbed(), _undocumented():
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
