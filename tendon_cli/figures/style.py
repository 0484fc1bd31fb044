"""The style of all figures, their colours, and how they are written.

The same input gives the same bytes, whatever the surroundings.
"""

from __future__ import annotations

import contextlib
import io
import itertools
import re
import threading
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.cube.outcomes import EXTENSOR_SLACK, FLEXOR_SLACK, TAUT
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import (
    Figure,
    FigureCanvasAgg,
    Line2D,
    LinearSegmentedColormap,
    Patch,
    mpl,
)
from tendon_cli.studies.figures import WIDTHS

MM = 1.0 / 25.4
"""Inches in a millimetre."""
COLUMN_WIDTH = WIDTHS["column"]
PAGE_WIDTH = WIDTHS["page"]
PAGE_HEIGHT = 230.0
"""Largest height of the panels of a page, mm."""

Colour = tuple[float, float, float, float] | str

INK = "#1a1a1a"
FAINT = "#8a8a8a"
WINDOW = "#b4d4ea"
"""Area of a window of pretension."""
NO_WINDOW = "#f6d9c5"
OKABE_ITO = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5a5a5a", "#000000")
"""Colours that everybody tells apart, for values without an order."""
LIMIT_COLOURS = ("#4d4d4d", "#006b4e", "#8f2d72", "#5a4a00", "#003a70", "#3d0a66")
"""Dark colours of limits, none of them INK. The first is that of the limit on stiffness."""
COLOUR_OF_LIMIT = {
    "extensor slack": OKABE_ITO[1],
    "flexor slack": FLEXOR_SLACK.colour,
    "min_elbow_stiffness": OKABE_ITO[0],
    "peak_motor_torque": OKABE_ITO[2],
    "peak_motor_speed": OKABE_ITO[3],
    "max_tension": OKABE_ITO[5],
    "max_spring_extension": OKABE_ITO[6],
}
"""Colours of the limits that bind most often, the same in every figure of an answer."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")
WHOLE: dict[str, Any] = {"clip_on": False, "in_layout": False}
"""Style of markers that stand whole at the edge of a panel."""
STAR: dict[str, Any] = {
    "marker": "*",
    "color": INK,
    "markersize": 10.0,
    "markeredgecolor": "white",
    "markeredgewidth": 0.8,
    "linestyle": "",
    "zorder": 5,
    **WHOLE,
}
"""Style of the choice that an answer names first, which stands whole at the edge of a panel."""


def largest(values: npt.ArrayLike) -> float:
    """Return the largest finite value; 0 if none is above it."""
    array = np.asarray(values, dtype=np.float64)
    return float(np.max(array[np.isfinite(array)], initial=0.0))


def shades(colour: str) -> list[str]:
    """Return a few colours from nearly white to very dark: dark is more in every figure."""
    middle = np.array(mpl.colors.to_rgb(colour))
    pale = 1.0 - 0.18 * (1.0 - middle)
    dark = 0.55 * middle
    shades: list[Any] = [pale, 0.5 * (pale + middle), middle, dark]
    return [mpl.colors.to_hex(shade) for shade in shades]


def diverging(slack: str) -> LinearSegmentedColormap:
    """Return colours of the margin: blue above zero, those of a slack tendon below."""
    below = shades(slack)[::-1]
    return LinearSegmentedColormap.from_list("margin", [*below, "#f7f6f4", *shades(TAUT.colour)])


MARGIN = diverging(EXTENSOR_SLACK.colour)
MARGIN_FLEXOR = diverging(FLEXOR_SLACK.colour)
BLUES = LinearSegmentedColormap.from_list("blues", shades(TAUT.colour))
SEQUENTIAL = LinearSegmentedColormap.from_list(
    "sequence", ("#f0a01e", "#ed7953", "#bd3786", "#7201a8", "#1c0a66")
)

FORMATS: dict[str, dict[str, str | None]] = {
    "png": {"title": "Title", "says": "Description", "study": "Source", "Software": None},
    "svg": {
        "title": "Title",
        "says": "Description",
        "study": "Source",
        "Date": None,
        "Creator": None,
    },
    "pdf": {
        "title": "Title",
        "says": "Subject",
        "study": "Keywords",
        "CreationDate": None,
        "Creator": None,
        "Producer": None,
    },
}
"""Names in each format for the text about a figure.

None leaves out an entry that would differ from one day to the next.
"""
_DPI = 250
_WIDTH_OF_PREVIEW = 860
"""Dots across a figure in a notebook or on a page."""
_COLOURS_OF_PREVIEW = 64
"""Largest number of colours of a figure in a notebook."""

_STYLE: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],  # ships with matplotlib
    "mathtext.fontset": "custom",
    "mathtext.it": "DejaVu Serif",  # only for the I of F_I, which would be a stroke without serifs
    "mathtext.default": "regular",
    "font.size": 7.5,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "legend.handlelength": 2.2,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 7),
    "text.color": INK,
    "axes.titlepad": 4.0,
    "axes.labelpad": 3.0,
    "lines.linewidth": 1.1,
    "lines.markersize": 3.0,
    "hatch.linewidth": 0.5,
    "hatch.color": "#777777",
    "figure.dpi": _DPI,
    "savefig.facecolor": "white",
    "svg.hashsalt": "tendon",
    "svg.fonttype": "none",  # text stays text
    "pdf.fonttype": 42,
    **{f"{axis}tick.labelsize": 7.0 for axis in "xy"},
    **{f"{axis}tick.major.width": 0.6 for axis in "xy"},
    **{f"{axis}tick.major.size": 3.0 for axis in "xy"},
    **{f"{axis}tick.minor.size": 1.8 for axis in "xy"},
}

_JOINT: ContextVar[str] = ContextVar("_JOINT", default="elbow")
"""Name of the joint of the study that is being drawn."""


_MATPLOTLIB = threading.RLock()
"""Lock of matplotlib's settings and of its parser of formulas, which threads share."""


@contextlib.contextmanager
def house_style(joint: str = "elbow") -> Iterator[None]:
    """Set matplotlib as it ships, with the style of this project on top.

    The settings from before come back afterwards.

    Args:
        joint: Name of the study's joint, which texts have instead of "elbow".
    """
    before = _JOINT.set(joint)
    try:
        with _MATPLOTLIB, warnings.catch_warnings(), mpl.rc_context():
            # A title may hold characters that the font lacks. They are drawn as boxes.
            warnings.filterwarnings("ignore", message="Glyph .* missing from")
            settings: Any = mpl.rcParams
            # These settings were checked once. Checking takes longer than setting them.
            dict.update(settings, _settings())
            yield
    finally:
        _JOINT.reset(before)


@cache
def _settings() -> dict[str, Any]:
    """Return all settings of this style, as matplotlib reads them; called within `rc_context`."""
    settings: Any = mpl.rcParams
    # Not by rcdefaults(), which reads all styles that matplotlib ships.
    shipped = dict(mpl.rcParamsDefault)
    dict.update(settings, {name: value for name, value in shipped.items() if name != "backend"})
    settings.update(_STYLE)
    kept = dict(settings.copy())
    del kept["backend"]
    return kept


def render(figure: Figure, kind: str, about: Mapping[str, str] | None = None) -> bytes:
    """Return the bytes of a figure.

    Args:
        figure: The figure.
        kind: One of FORMATS.
        about: Text for the file's metadata: `title`, `says` and `study`.
    """
    buffer = io.BytesIO()
    facts = about or {}
    metadata: dict[str, str | None] = {}
    for key, name in FORMATS[kind].items():
        if name is None:
            metadata[key] = None
        elif facts.get(key):
            metadata[name] = facts[key]
    with house_style():
        warnings.filterwarnings("ignore", message="constrained_layout not applied")
        canvas: Any = FigureCanvasAgg(figure)
        if kind == "png":
            # `savefig` would draw everything twice. More compression takes longer than it is worth.
            canvas.print_png(buffer, metadata=metadata, pil_kwargs={"compress_level": 3})
        else:
            figure.savefig(buffer, format=kind, metadata=metadata)
    return buffer.getvalue()


def preview(figure: Figure) -> bytes:
    """Return a figure as a small PNG, which a notebook keeps with each result that it shows.

    It has few colours, and no more dots than a screen shows.
    """
    from PIL import Image

    dots = figure.dpi
    figure.dpi = _WIDTH_OF_PREVIEW / figure.get_figwidth()
    try:
        picture = Image.open(io.BytesIO(render(figure, "png"))).convert("RGB")
    finally:
        figure.dpi = dots
    small = io.BytesIO()
    few = picture.quantize(_COLOURS_OF_PREVIEW, dither=Image.Dither.NONE)
    few.save(small, "png", optimize=True)
    return small.getvalue()


def format_of(path: Path, where: str) -> str:
    """Return the format that a file's ending stands for.

    Args:
        path: The file.
        where: Option that a message names.

    Raises:
        UsageError: The ending is not that of a figure.
    """
    kind = path.suffix[1:].lower()
    if kind not in FORMATS:
        raise UsageError(
            f'"{path.name}" does not end like a figure file', where=where, hint=".png, .svg or .pdf"
        )
    return kind


def named(text: str) -> str:
    """Put the name of the study's joint into a text about the elbow.

    Where the name stands already, it stays, as in "left elbow".
    """
    word = _JOINT.get()
    pieces = re.split(rf"(?<!\w)({re.escape(word)})(?!\w)", text, flags=re.IGNORECASE)
    pieces[::2] = [say.name_joint(piece, word) for piece in pieces[::2]]
    return "".join(pieces)


def unknown_hatch() -> dict[str, Any]:
    """Return the style of an area in which there is no value."""
    return {"facecolor": "#efefef", "hatch": "////", "edgecolor": FAINT, "linewidth": 0.0}


def key_line(**style: Any) -> Line2D:
    """Return the sample of a line or marker, for the key."""
    return Line2D([], [], **style)


def hatch_key(label: str) -> Patch:
    """Return the sample of an area without a value, for the key."""
    return Patch(**unknown_hatch(), label=label)


def sequence(count: int) -> list[Colour]:
    """Return colours for values with an order, from light to dark, told apart in grey print too."""
    if count <= 1:
        return [SEQUENTIAL(1.0)]
    return [SEQUENTIAL(float(place)) for place in np.linspace(0.0, 1.0, count)]


def load_colours(masses: npt.ArrayLike) -> list[Colour]:
    """Return colours of loads in kg, each the same in every figure.

    If loads lie too close to each other, the colours are those of `sequence`.
    """
    places = 1.0 - np.exp(-np.asarray(masses, dtype=np.float64) / 6.0)
    if len(places) > 1 and float(np.diff(np.sort(places)).min()) <= 0.1:
        return sequence(len(places))
    return [SEQUENTIAL(float(place)) for place in places]


def limit_colours(limits: Iterable[str]) -> dict[str, Colour]:
    """Return a colour for each limit: its own, or one that no other limit of the figure has.

    If the colours run out, the last limits share the last one.

    Args:
        limits: Names of the limits of a figure, in the order of its key.
    """
    names = list(dict.fromkeys(limits))
    known = [COLOUR_OF_LIMIT[name] for name in names if name in COLOUR_OF_LIMIT]
    free = [colour for colour in reversed(OKABE_ITO) if colour not in known] or [OKABE_ITO[-1]]
    others = itertools.chain(free, itertools.repeat(free[-1]))
    return {name: COLOUR_OF_LIMIT.get(name) or next(others) for name in names}
