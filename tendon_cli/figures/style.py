"""How all figures look, and how they are written: the same input gives the same bytes, whatever surrounds it."""

from __future__ import annotations

import contextlib
import io
import textwrap
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.errors import UsageError
from tendon_cli.figures.engine import ConstrainedLayoutEngine, Figure, FigureCanvasAgg, LinearSegmentedColormap, mpl
from tendon_cli.files import write_whole

MM = 1.0 / 25.4
COLUMN_WIDTH = 85.0
PAGE_WIDTH = 175.0
PAGE_HEIGHT = 230.0

INK = "#1a1a1a"
FAINT = "#8a8a8a"
PALE = "#e4e4e4"

OKABE_ITO = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#5a5a5a", "#000000")
"""Colours that everybody tells apart, for values without an order."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")

DIVERGING = LinearSegmentedColormap.from_list(
    "tendon_margin", ("#6b2203", "#b4480f", "#e38a4f", "#f5c9a8", "#f7f6f4", "#b4d4ea", "#6aaad6", "#2472b0", "#08396b")
)
"""Orange below zero, blue above: told apart by every kind of colour vision."""
_SEQUENTIAL = LinearSegmentedColormap.from_list(
    "tendon_sequence", ("#f0a01e", "#ed7953", "#bd3786", "#7201a8", "#1c0a66")
)

FORMATS: dict[str, dict[str, Any]] = {
    "png": {"format": "png", "metadata": {"Software": None}},
    "svg": {"format": "svg", "metadata": {"Date": None, "Creator": None}},
    "pdf": {"format": "pdf", "metadata": {"CreationDate": None, "Creator": None, "Producer": None}},
}
_DPI = 250

_STYLE: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],  # ships with matplotlib
    "mathtext.fontset": "dejavusans",
    "mathtext.default": "regular",
    "font.size": 7.5,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "legend.title_fontsize": 7.5,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
    "figure.titlesize": 9.0,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "axes.titlepad": 4.0,
    "axes.labelpad": 3.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.major.size": 3.0,
    "ytick.major.size": 3.0,
    "xtick.minor.size": 1.8,
    "ytick.minor.size": 1.8,
    "lines.linewidth": 1.1,
    "lines.markersize": 3.0,
    "hatch.linewidth": 0.5,
    "hatch.color": "#777777",
    "axes.grid": False,
    "figure.dpi": _DPI,
    "figure.constrained_layout.h_pad": 0.03,
    "figure.constrained_layout.w_pad": 0.03,
    "svg.hashsalt": "tendon",
    "svg.fonttype": "path",
    "pdf.fonttype": 42,
    "pdf.compression": 6,
}


@contextlib.contextmanager
def house_style() -> Iterator[None]:
    """Matplotlib as it ships, with the style of this project on top; whatever was set before comes back after."""
    with warnings.catch_warnings(), mpl.rc_context():
        # A title may hold signs that the font does not: they are drawn as boxes, which needs no further words.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        mpl.rcdefaults()
        settings: Any = mpl.rcParams
        settings.update(_STYLE)
        yield


def new_figure(width: float, height: float, rect: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0)) -> Figure:
    """An empty figure of a size in mm, its panels arranged within `rect` (a share of it) so that nothing overlaps."""
    return Figure(figsize=(width * MM, height * MM), layout=ConstrainedLayoutEngine(rect=rect))


def check_format(name: str) -> str:
    """A format that figures are written in; raises UsageError."""
    if name.lower() not in FORMATS:
        raise UsageError(f'"{name}" is not a format of figures', where="--format", hint="png, svg or pdf")
    return name.lower()


def render(figure: Figure, kind: str, *, must_fit: bool = False) -> bytes:
    """The bytes of a figure as PNG, SVG or PDF; raises UsageError where its panels have no room and `must_fit`."""
    buffer = io.BytesIO()
    with house_style():
        warnings.filterwarnings("error" if must_fit else "ignore", message="constrained_layout not applied")
        FigureCanvasAgg(figure)
        try:
            figure.savefig(buffer, dpi=_DPI, facecolor="white", **FORMATS[kind])
        except UserWarning:
            hint = "a larger one, or fewer panels and quantities"
            raise UsageError("the panels do not fit into this size", where="--size", hint=hint) from None
    return buffer.getvalue()


def save(figure: Figure, path: Path, *, must_fit: bool = False) -> Path:
    """Write a figure whole or not at all, in the format of the path's ending; raises OutputError, UsageError."""
    write_whole(path, render(figure, check_format(path.suffix[1:]), must_fit=must_fit))
    return path


def plain(text: str, *, width: int | None = None, lines: int = 3) -> str:
    """Text of a user as it stands: no formula is made of a dollar sign, no line is broken by a control character."""
    clean = " ".join("".join(sign if sign.isprintable() else " " for sign in text).split())
    if width is not None:
        clean = "\n".join(textwrap.wrap(clean, width, max_lines=lines, placeholder=" …", break_long_words=True))
    return clean.replace("$", r"\$")


def sequence(count: int) -> list[tuple[float, float, float, float]]:
    """Colours for values with an order, from light to dark so that they are told apart in grey print too."""
    return [_SEQUENTIAL(float(at)) for at in np.linspace(0.0, 1.0, count)] if count > 1 else [_SEQUENTIAL(1.0)]


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
    middle = min(range(1, len(words)), key=lambda at: abs(len(" ".join(words[:at])) - len(label) / 2))
    return f"{' '.join(words[:middle])}\n{' '.join(words[middle:])}"


def sequential_map() -> LinearSegmentedColormap:
    """The colours of `sequence`, for values in between."""
    return _SEQUENTIAL
