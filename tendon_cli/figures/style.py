"""The style of all figures, and how they are written.

The same input gives the same bytes, whatever the surroundings.
"""

from __future__ import annotations

import contextlib
import io
import re
import struct
import threading
import warnings
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import (
    Figure,
    FigureCanvasAgg,
    FontProperties,
    LinearSegmentedColormap,
    Patch,
    is_math_text,
    mpl,
    text_to_path,
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

OKABE_ITO = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5a5a5a", "#000000")
"""Colours that everybody tells apart, for values without an order."""
LIMIT_COLOURS = ("#4d4d4d", "#006b4e", "#8f2d72", "#5a4a00", "#7a0019", "#003a70", "#3d0a66")
"""Dark colours of limits, none of them INK. The first is that of the limit on stiffness."""
COLOUR_OF_LIMIT = {
    "extensor slack": OKABE_ITO[1],
    "flexor slack": OKABE_ITO[4],
    "min_elbow_stiffness": OKABE_ITO[0],
    "peak_motor_torque": OKABE_ITO[2],
    "peak_motor_speed": OKABE_ITO[3],
    "max_tension": OKABE_ITO[5],
    "max_spring_extension": OKABE_ITO[6],
}
"""Colours of the limits that bind most often, the same in every figure of an answer."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")

DIVERGING = LinearSegmentedColormap.from_list(
    "tendon_margin",
    (
        "#6b2203",
        "#b4480f",
        "#e38a4f",
        "#f5c9a8",
        "#f7f6f4",
        "#b4d4ea",
        "#6aaad6",
        "#2472b0",
        "#08396b",
    ),
)
"""Orange below zero, blue above: distinguished by every kind of colour vision."""
SEQUENTIAL = LinearSegmentedColormap.from_list(
    "tendon_sequence", ("#f0a01e", "#ed7953", "#bd3786", "#7201a8", "#1c0a66")
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
_DPI_OF_PREVIEW = 125
"""Dots per inch of a figure in a notebook."""
_COLOURS_OF_PREVIEW = 64
"""Largest number of colours of a figure in a notebook."""
_MOST_LABEL_LINES = 4
"""Largest number of lines of the label of an axis."""

_STYLE: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],  # ships with matplotlib
    "mathtext.fontset": "custom",
    "mathtext.it": "DejaVu Serif",  # only for the I of F_I, which would be a stroke without serifs
    "mathtext.default": "regular",
    "font.size": 7.5,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "figure.titlesize": 9.0,
    "legend.fontsize": 7.0,
    "legend.title_fontsize": 7.5,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "axes.titlepad": 4.0,
    "axes.labelpad": 3.0,
    "axes.grid": False,
    "lines.linewidth": 1.1,
    "lines.markersize": 3.0,
    "hatch.linewidth": 0.5,
    "hatch.color": "#777777",
    "figure.dpi": _DPI,
    "figure.constrained_layout.h_pad": 0.03,
    "figure.constrained_layout.w_pad": 0.03,
    "svg.hashsalt": "tendon",
    "svg.fonttype": "none",  # text stays text
    "pdf.fonttype": 42,
    "pdf.compression": 6,
}
_TICKS = {
    "labelsize": 7.0,
    "major.width": 0.6,
    "minor.width": 0.4,
    "major.size": 3.0,
    "minor.size": 1.8,
}
_STYLE |= {f"{axis}tick.{name}": size for axis in "xy" for name, size in _TICKS.items()}


_JOINT: ContextVar[str] = ContextVar("_JOINT", default="elbow")
"""Name of the joint of the study that is being drawn."""


@contextlib.contextmanager
def house_style(joint: str = "elbow") -> Iterator[None]:
    """Set matplotlib as it ships, with the style of this project on top.

    The settings from before come back afterwards.

    Args:
        joint: Name of the study's joint, for texts that are broken into lines.
    """
    before = _JOINT.set(joint)
    try:
        with _settings_in_force():
            yield
    finally:
        _JOINT.reset(before)


_MATPLOTLIB = threading.RLock()
"""Lock of matplotlib's settings and of its parser of formulas, which threads share."""


@contextlib.contextmanager
def _settings_in_force() -> Iterator[None]:
    """Set the settings of this style within, in one thread at a time."""
    with _MATPLOTLIB, warnings.catch_warnings(), mpl.rc_context():
        # A title may hold characters that the font lacks. They are drawn as boxes, which needs no
        # warning.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        settings: Any = mpl.rcParams
        # These settings were checked once. Checking takes longer than setting them.
        dict.update(settings, _settings())
        yield


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
            _write_png(canvas, metadata, buffer)
        else:
            figure.savefig(buffer, facecolor="white", format=kind, metadata=metadata)
    return buffer.getvalue()


def preview(figure: Figure) -> bytes:
    """Return a figure as a small PNG, which a notebook keeps with each result that it shows.

    It has half the dots of a file per length, and few colours.
    """
    from PIL import Image

    dots = figure.dpi
    figure.dpi = _DPI_OF_PREVIEW
    try:
        picture = Image.open(io.BytesIO(render(figure, "png")))
    finally:
        figure.dpi = dots
    small = io.BytesIO()
    few = picture.quantize(_COLOURS_OF_PREVIEW, dither=Image.Dither.NONE)
    few.save(small, "png", optimize=True)
    return small.getvalue()


def _write_png(canvas: Any, metadata: Mapping[str, str | None], buffer: io.BytesIO) -> None:
    """Draw a figure once, and write it as PNG.

    Matplotlib itself would draw twice, the first time to find the extent of everything. The rows
    are compressed without a filter: a search for the best one for each row takes three times as
    long, and none helps in the plain areas of a drawing.
    """
    from PIL import PngImagePlugin

    canvas.draw()
    info = PngImagePlugin.PngInfo()
    for name, text in metadata.items():
        if text:
            info.add_text(name, text)
    pixels = np.asarray(canvas.buffer_rgba())
    height, width, _ = pixels.shape
    rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each begins with its filter: none
    rows[:, 1:].reshape(height, width, 3)[...] = pixels[:, :, :3]
    # Eight bits of red, green and blue.
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    per_metre = round(_DPI / 0.0254)
    buffer.write(b"\x89PNG\r\n\x1a\n")
    PngImagePlugin.putchunk(buffer, b"IHDR", header)
    PngImagePlugin.putchunk(buffer, b"pHYs", struct.pack(">IIB", per_metre, per_metre, 1))
    for kind, data, _ in info.chunks:
        PngImagePlugin.putchunk(buffer, kind, data)
    PngImagePlugin.putchunk(buffer, b"IDAT", zlib.compress(rows.data, 3))
    PngImagePlugin.putchunk(buffer, b"IEND")


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


def text_width(text: str, size: float, weight: str = "normal") -> float:
    """Return the width of the widest line of a text as it is drawn, mm.

    Args:
        text: The text, which may hold formulas.
        size: Size of its letters, pt.
        weight: "normal" or "bold".
    """
    font = FontProperties(family=_STYLE["font.family"], size=size, weight=weight)
    widths = [_line_width(line, font) for line in text.split("\n")]
    return max(widths) / 72.0 / MM


def _line_width(line: str, font: FontProperties) -> float:
    """Return the width of a line of text, pt."""
    is_formula = bool(is_math_text(line))
    words = line if is_formula else line.replace(r"\$", "$")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        width, _, _ = text_to_path.get_text_width_height_descent(words, font, is_formula)
    return float(width)


def named(text: str, joint: str | None = None) -> str:
    """Put the name of the study's joint into a text about the elbow.

    Where the name stands already, it stays, as in "left elbow".

    Args:
        text: The text.
        joint: The name; None for that of `house_style`.
    """
    word = joint or _JOINT.get()
    pieces = re.split(rf"(?<!\w)({re.escape(word)})(?!\w)", text, flags=re.IGNORECASE)
    pieces[::2] = [say.name_joint(piece, word) for piece in pieces[::2]]
    return "".join(pieces)


def unknown_hatch() -> dict[str, Any]:
    """Return the style of an area in which there is no value."""
    return {"facecolor": "#efefef", "hatch": "////", "edgecolor": FAINT, "linewidth": 0.0}


def hatch_key(label: str) -> Patch:
    """Return the sample of an area without a value, for the key."""
    return Patch(**unknown_hatch(), label=label)


def sequence(count: int) -> list[Colour]:
    """Return colours for values with an order.

    They run from light to dark, so that they are distinguished in grey print too.
    """
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
    colours = {name: COLOUR_OF_LIMIT[name] for name in names if name in COLOUR_OF_LIMIT}
    free = [colour for colour in reversed(OKABE_ITO) if colour not in colours.values()]
    others = [name for name in names if name not in colours]
    for place, name in enumerate(others):
        colours[name] = free[min(place, len(free) - 1)] if free else OKABE_ITO[-1]
    return {name: colours[name] for name in names}


def wrapped(text: str, width: int) -> str:
    """Break a title at its commas to about `width` characters; it may hold formulas.

    A piece that is far longer is broken between its words.
    """
    lines: list[str] = []
    for piece in named(text).split(", "):
        if _drawn_length(piece) > 1.3 * width:
            lines.append(broken(piece, width))
            continue
        if lines and len(lines[-1]) + len(piece) + 2 <= width:
            lines[-1] = f"{lines[-1]}, {piece}"
        else:
            lines.append(piece)
    return ",\n".join(lines)


def broken(label: str, width: int) -> str:
    """Break the label of an axis into lines if it is longer than about `width` characters.

    It has as few lines as fit, at most four, about equally long. A label of one or two words is not
    broken.
    """
    label = named(label)
    words = label.split(" ")
    if _drawn_length(label) <= width or len(words) < 3:
        return label
    most = min(_MOST_LABEL_LINES, len(words) - 1)
    for count in range(2, most + 1):
        lines = _balanced(words, count)
        if max(map(_drawn_length, lines)) <= width:
            break
    return "\n".join(lines)


def _balanced(words: Sequence[str], count: int) -> list[str]:
    """Divide words into so many lines, about equally long."""
    if count == 1:
        return [" ".join(words)]
    share = len(" ".join(words)) / count
    firsts = [" ".join(words[:end]) for end in range(1, len(words) - count + 2)]
    first = min(firsts, key=lambda line: abs(len(line) - share))
    return [first, *_balanced(words[first.count(" ") + 1 :], count - 1)]


def _drawn_length(label: str) -> int:
    """Return about the number of characters that a label takes when it is drawn."""
    return len(label.replace("$", ""))
