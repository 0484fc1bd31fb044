"""Import matplotlib so that nothing in the working directory or the environment reaches a figure.

A `matplotlibrc` in the working directory, MATPLOTLIBRC and MPLBACKEND could change every figure.
Figures are drawn with the settings that matplotlib ships (`style.house_style`). The canvases are
used directly, so no backend is ever chosen. Modules that draw import matplotlib only from here.
"""

from __future__ import annotations

import contextlib
import importlib.util
import logging
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from tendon_cli.errors import InputError
from tendon_cli.files import open_file

_LOCAL = Path("matplotlibrc")
"""Settings that matplotlib reads before all others."""


@contextlib.contextmanager
def _shipped_settings() -> Iterator[None]:
    """Make matplotlib read the settings that it ships while it is imported.

    Raises:
        InputError: A matplotlibrc in the working directory would stop matplotlib.
    """
    # Whoever asks for a figure need not read matplotlib's notes on caches and settings files.
    logging.getLogger("matplotlib").setLevel(logging.CRITICAL)
    spec = importlib.util.find_spec("matplotlib")
    if "matplotlib" in sys.modules or spec is None or spec.origin is None:
        yield
        return
    shipped = {
        "MATPLOTLIBRC": str(Path(spec.origin).parent / "mpl-data/matplotlibrc"),
        "MPLBACKEND": "agg",
    }
    before = {name: os.environ.get(name) for name in shipped}
    os.environ.update(shipped)
    try:
        if _LOCAL.exists() and not _LOCAL.is_dir():
            # Raises OSError for a pipe or a device, on which matplotlib would wait.
            open_file(_LOCAL).close()
        yield
    except Exception as error:
        if not _LOCAL.exists():
            raise
        hint = "rename it, or start from another folder"
        raise InputError(
            f"matplotlib cannot use these settings: {error}", where=str(_LOCAL), hint=hint
        ) from error
    finally:
        for name in shipped:
            del os.environ[name]
        os.environ.update({name: value for name, value in before.items() if value is not None})


with _shipped_settings():
    import matplotlib as mpl
    from matplotlib import ticker
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cbook import is_math_text
    from matplotlib.colors import LinearSegmentedColormap, ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.font_manager import FontProperties
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.lines import Line2D
    from matplotlib.patches import Arc, Circle, FancyArrowPatch, Patch, PathPatch
    from matplotlib.path import Path as Outline
    from matplotlib.patheffects import Normal, TickedStroke, withStroke
    from matplotlib.text import Text
    from matplotlib.textpath import text_to_path

__all__ = [
    "Arc",
    "Artist",
    "Axes",
    "Circle",
    "ConstrainedLayoutEngine",
    "FancyArrowPatch",
    "Figure",
    "FigureCanvasAgg",
    "FontProperties",
    "Line2D",
    "LinearSegmentedColormap",
    "ListedColormap",
    "Normal",
    "Outline",
    "Patch",
    "PathPatch",
    "Text",
    "TickedStroke",
    "is_math_text",
    "mpl",
    "text_to_path",
    "ticker",
    "withStroke",
]
