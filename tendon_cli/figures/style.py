"""How all figures look, and how they are written: the same input gives the same bytes, whatever surrounds it."""

from __future__ import annotations

import contextlib
import io
import struct
import warnings
import zlib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import Figure, FigureCanvasAgg, LinearSegmentedColormap, Patch, mpl
from tendon_cli.studies.figures import WIDTHS

MM = 1.0 / 25.4
COLUMN_WIDTH, PAGE_WIDTH = WIDTHS["column"], WIDTHS["page"]
PAGE_HEIGHT = 230.0

Colour = tuple[float, float, float, float] | str

INK = "#1a1a1a"
FAINT = "#8a8a8a"

OKABE_ITO = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5a5a5a", "#000000")
"""Colours that everybody tells apart, for values without an order."""
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
"""How each format calls what a figure says of itself; what is left out would differ from one day to the next."""
_DPI = 250

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


@contextlib.contextmanager
def house_style() -> Iterator[None]:
    """Matplotlib as it ships, with the style of this project on top; whatever was set before comes back after."""
    with warnings.catch_warnings(), mpl.rc_context():
        # A title may hold signs that the font does not: they are drawn as boxes, which needs no further words.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        settings: Any = mpl.rcParams
        dict.update(
            settings, _settings()
        )  # what is in it was checked once, which takes longer than setting it
        yield


@cache
def _settings() -> dict[str, Any]:
    """All settings of this style, as matplotlib reads them; called within `rc_context`."""
    settings: Any = mpl.rcParams
    shipped = dict(
        mpl.rcParamsDefault
    )  # not by rcdefaults(), which reads all styles that matplotlib ships
    dict.update(settings, {name: value for name, value in shipped.items() if name != "backend"})
    settings.update(_STYLE)
    kept = dict(settings.copy())
    del kept["backend"]
    return kept


def render(figure: Figure, kind: str, about: Mapping[str, str] | None = None) -> bytes:
    """The bytes of a figure as PNG, SVG or PDF, with what it says of itself (`title`, `says`, `study`) inside."""
    buffer = io.BytesIO()
    facts = about or {}
    metadata = {
        name or key: facts.get(key)
        for key, name in FORMATS[kind].items()
        if name is None or facts.get(key)
    }
    with house_style():
        warnings.filterwarnings("ignore", message="constrained_layout not applied")
        canvas: Any = FigureCanvasAgg(figure)
        if kind == "png":
            _write_png(canvas, metadata, buffer)
        else:
            figure.savefig(buffer, facecolor="white", format=kind, metadata=metadata)
    return buffer.getvalue()


def _write_png(canvas: Any, metadata: Mapping[str, str | None], buffer: io.BytesIO) -> None:
    """Draw once: matplotlib by itself draws twice, the first time to see where things are.

    The rows are compressed as they stand: looking for the best of the format's filters for each takes three times as
    long, and for a drawing's plain areas there is none.
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
    header = struct.pack(
        ">IIBBBBB", width, height, 8, 2, 0, 0, 0
    )  # eight bits of red, green and blue
    size = struct.pack(">IIB", *2 * [round(_DPI / 0.0254)], 1)
    texts = ((kind, data) for kind, data, _ in info.chunks)
    buffer.write(b"\x89PNG\r\n\x1a\n")
    for chunk in (
        (b"IHDR", header),
        (b"pHYs", size),
        *texts,
        (b"IDAT", zlib.compress(rows.data, 3)),
        (b"IEND",),
    ):
        PngImagePlugin.putchunk(buffer, *chunk)


def format_of(path: Path, where: str) -> str:
    """The format that a file's ending means; raises UsageError for none of a figure."""
    if path.suffix[1:].lower() not in FORMATS:
        raise UsageError(
            f'"{path.name}" has no ending of a figure', where=where, hint=".png, .svg or .pdf"
        )
    return path.suffix[1:].lower()


def unknown_hatch() -> dict[str, Any]:
    """How an area looks in which there is no value."""
    return {"facecolor": "#efefef", "hatch": "////", "edgecolor": FAINT, "linewidth": 0.0}


def hatch_key(label: str) -> Patch:
    """The sign of what has no value, for the key."""
    return Patch(**unknown_hatch(), label=label)


def sequence(count: int) -> list[Colour]:
    """Colours for values with an order, from light to dark so that they are distinguished in grey print too."""
    return (
        [SEQUENTIAL(float(at)) for at in np.linspace(0.0, 1.0, count)]
        if count > 1
        else [SEQUENTIAL(1.0)]
    )


def load_colours(masses: npt.ArrayLike) -> list[Colour]:
    """Colours of loads in kg, each the same in every figure; where some lie too close, those of `sequence`."""
    at = 1.0 - np.exp(-np.asarray(masses, dtype=np.float64) / 6.0)
    is_told_apart = len(at) < 2 or float(np.diff(np.sort(at)).min()) > 0.1
    return [SEQUENTIAL(float(each)) for each in at] if is_told_apart else sequence(len(at))


def wrapped(text: str, width: int) -> str:
    """A title of ours, which may hold formulas, broken at its commas to about `width` signs."""
    lines: list[str] = []
    for piece in text.split(", "):
        if lines and len(lines[-1]) + len(piece) + 2 <= width:
            lines[-1] = f"{lines[-1]}, {piece}"
        else:
            lines.append(piece)
    return ",\n".join(lines)


def broken(label: str, width: int) -> str:
    """The label of an axis on two lines where it is longer than about `width` signs: name, then symbol and unit."""
    words = label.split(" ")
    if len(label.replace("$", "")) <= width or len(words) < 3:
        return label
    middle = min(
        range(1, len(words)), key=lambda at: abs(len(" ".join(words[:at])) - len(label) / 2)
    )
    return f"{' '.join(words[:middle])}\n{' '.join(words[middle:])}"
