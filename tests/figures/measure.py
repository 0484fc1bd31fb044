"""Measure every text of a figure against its canvas and against the other texts.

`faults_of` draws a figure once with Agg and says in a sentence each what is wrong: a text beyond
the canvas, texts that overlap, a formula that is not set. `capture` collects every figure that the
tool draws, so that commands can be run as users run them.
"""

from __future__ import annotations

import contextlib
import importlib
import itertools
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import numpy.typing as npt
from matplotlib.text import Text
from matplotlib.transforms import Affine2D

import tendon_cli
from tendon_cli.figures import frame
from tendon_cli.figures.backend import FigureCanvasAgg
from tendon_cli.figures.style import house_style
from tendon_cli.quantities import QUANTITIES

BEYOND = 0.5
"""Length by which a box may lie beyond the canvas, pt; a box is a little larger than its ink."""
TOUCH = 0.6
"""Depth to which two boxes may overlap, pt."""
SMALLEST = 10.0
"""Least width and height of a panel, pt."""
_DOLLAR = re.compile(r"(?<!\\)\$")
_UNSET = re.compile(r"[_^]\{|\\mathit")


def _words_of_code() -> set[str]:
    """Return the names and the symbols of quantities that a figure shows in other letters."""
    symbols = {word for quantity in QUANTITIES.values() for word in quantity.symbol.split()}
    return {word for word in (*symbols, *QUANTITIES) if "_" in word or "^" in word}


_RAW = re.compile(
    rf"(?<!\w)({'|'.join(map(re.escape, sorted(_words_of_code(), key=len, reverse=True)))})(?!\w)"
)
"""A symbol such as R_f, or the name of a column such as max_tension, as it is in the code."""

_CURVE = re.compile(r"(curve|binds|from .*|to .*)$")
"""Names of the lines that show results."""
_MAY_BE_CROSSED = ("slack word",)
"""Texts that name an area, before the curves of which they stand."""
_SHARED = ("answer_page", "_draw_map", "begin", "draw_pages")
"""Functions that begin the pages of several figures."""
_CALL = re.compile(r"= (?:framed|answer_page)\(|return (?:_draw_map|draw_pages)\(")
_DEFINITION = re.compile(r"^def (\w+)", re.MULTILINE)


def _drawers() -> frozenset[str]:
    """Return the full names of all functions that begin the page of a figure."""
    package = Path(tendon_cli.__file__).parent
    drawers = set()
    for path in sorted(package.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        module = ".".join(path.relative_to(package.parent).with_suffix("").parts)
        for call in _CALL.finditer(text):
            *_, name = _DEFINITION.findall(text[: call.start()])
            if name not in _SHARED:
                drawers.add(f"{module}.{name}")
    return frozenset(drawers)


DRAWERS = _drawers()
"""Every function that lays out a figure of the tool."""

Corners = npt.NDArray[np.float64]


@dataclass(frozen=True)
class _Box:
    """A visible text: its words, what it is, and its corners (4, 2) in points."""

    words: str
    role: str
    """Axis whose tick it labels, or "" for any other text."""
    corners: Corners


@dataclass(frozen=True)
class Drawn:
    """A figure that was drawn, and the function that laid it out."""

    drawer: str
    figure: Any


@contextlib.contextmanager
def capture() -> Iterator[list[Drawn]]:
    """Collect the figures that are written or shown within, in place of rendering them."""
    drawn: list[Drawn] = []
    drawers: dict[int, str] = {}
    begin = frame.framed

    def framed(*args: Any, **more: Any) -> frame.Page:
        page = begin(*args, **more)
        caller = sys._getframe(1)
        while caller.f_code.co_name in _SHARED and caller.f_back:
            caller = caller.f_back
        drawers[id(page.figure)] = f"{caller.f_globals['__name__']}.{caller.f_code.co_name}"
        return page

    def keep(figure: Any, *_: Any) -> bytes:
        if not any(figure is known.figure for known in drawn):
            drawn.append(Drawn(drawers[id(figure)], figure))
        return b""

    def shown(page: frame.Page, *_: Any, **__: Any) -> Any:
        keep(page.figure)
        return page.figure

    with contextlib.ExitStack() as stack:
        modules = {drawer.rpartition(".")[0] for drawer in DRAWERS}
        for name in sorted({*modules, "tendon_cli.figures.answer_page"}):
            module = importlib.import_module(name)
            if hasattr(module, "framed"):
                stack.enter_context(patch.object(module, "framed", framed))
        stack.enter_context(patch.object(frame, "render", keep))
        stack.enter_context(patch.object(frame, "preview", keep))
        stack.enter_context(patch.object(frame.Page, "shown", shown))
        yield drawn


def faults_of(figure: Any) -> list[str]:
    """Return a sentence for each text of a figure that is cut off, overlaps another or is not set.

    Args:
        figure: The figure, as `Page.figure` has it.
    """
    canvas: Any = FigureCanvasAgg(figure)
    with house_style():
        figure.draw_without_rendering()
        renderer = canvas.get_renderer()
        boxes = list(_boxes(figure, renderer))
    width, height = figure.get_size_inches() * 72.0
    faults = [f"a panel of {size:.0f} pt" for size in _sizes(figure) if size < SMALLEST]
    faults += [fault for box in boxes for fault in _formula_faults(box.words)]
    for box in boxes:
        low = box.corners.min(axis=0)
        high = box.corners.max(axis=0)
        beyond = max(-low[0], -low[1], high[0] - width, high[1] - height)
        if beyond > BEYOND:
            faults.append(f"{_short(box)} is cut off by {beyond:.1f} pt")
    faults += _crossed(figure, renderer)
    for one, other in itertools.combinations(boxes, 2):
        depth = _overlap(one.corners, other.corners)
        if depth > TOUCH:
            faults.append(f"{_short(one)} and {_short(other)} overlap by {depth:.1f} pt")
    return faults


def _crossed(figure: Any, renderer: Any) -> Iterator[str]:
    """Yield a sentence for each text written in a panel that one of the panel's curves crosses.

    The curves are crossed as paths, without pixels. Words that name an area may have curves behind
    them; so may the lengths of a drawing and the values in cells, which have no curves.
    """
    for axes in figure.axes:
        if not axes.get_visible():
            continue
        curves = [line for line in axes.lines if _CURVE.match(str(line.get_gid()))]
        for text in axes.texts:
            if not text.get_text().strip() or text.get_gid() in _MAY_BE_CROSSED:
                continue
            box = text.get_window_extent(renderer)
            inner = box.padded(-TOUCH * renderer.dpi / 72.0)
            for curve in curves:
                path = curve.get_path().cleaned(curve.get_transform(), remove_nans=True)
                if path.intersects_bbox(inner, filled=False):
                    yield f'a curve crosses "{text.get_text()[:40]}"'
                    break


def _sizes(figure: Any) -> Iterator[float]:
    """Yield the smaller side of each panel, pt."""
    for axes in figure.axes:
        if axes.get_visible() and axes.get_label() != "<colorbar>":
            yield min(axes.bbox.width, axes.bbox.height) * 72.0 / figure.dpi


def _short(box: _Box) -> str:
    """Return the words of a text for a sentence."""
    words = " ".join(box.words.split())
    role = f" ({box.role})" if box.role else ""
    return f'"{words[:60]}"{role}'


def _formula_faults(words: str) -> Iterator[str]:
    """Yield a sentence for each line of a text that shows the signs of a formula."""
    for line in words.split("\n"):
        pieces = _DOLLAR.split(line)
        outside = " ".join(pieces[::2])
        if len(pieces) % 2 == 0 or _UNSET.search(outside):
            yield f'"{line[:60]}" shows a formula that is not set'
        elif _RAW.search(outside):
            yield f'"{line[:60]}" shows a symbol as it is in the code'


def _boxes(figure: Any, renderer: Any) -> Iterator[_Box]:
    """Yield the visible texts of a figure with words in them."""
    ticks: dict[int, str] = {}
    hidden: set[int] = set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if not axis.get_visible():
                hidden |= {id(text) for text in axis.findobj(Text)}
            in_view = {id(tick) for tick in axis._update_ticks()}
            for tick in (*axis.majorTicks, *axis.minorTicks):
                for label in (tick.label1, tick.label2):
                    ticks[id(label)] = f"{axis.axis_name} of {figure.axes.index(axes)}"
                    if id(tick) not in in_view:
                        hidden.add(id(label))
        if not axes.get_visible():
            hidden |= {id(text) for text in axes.findobj(Text)}
        if not axes.axison:
            hidden |= {id(text) for axis in (axes.xaxis, axes.yaxis) for text in axis.findobj(Text)}
    for text in figure.findobj(Text):
        if id(text) in hidden or not text.get_visible() or not text.get_text().strip():
            continue
        if _is_in_hidden_tick(text, ticks):
            continue
        yield _Box(text.get_text(), ticks.get(id(text), ""), _corners(text, renderer))


def _is_in_hidden_tick(text: Text, ticks: dict[int, str]) -> bool:
    """Return True for the label of a tick on a side that shows none."""
    return id(text) in ticks and not text.get_visible()


def _corners(text: Text, renderer: Any) -> Corners:
    """Return the corners of a text as it is drawn, turned if it is turned, (4, 2) pt."""
    box = text.get_window_extent(renderer)
    turn = text.get_rotation() % 360.0
    per_point = renderer.dpi / 72.0
    if turn % 90.0 == 0.0:
        return np.asarray(box.corners())[[0, 1, 3, 2]] / per_point
    text.set_rotation(0.0)
    flat = text.get_window_extent(renderer)
    text.set_rotation(turn)
    middle = (box.p0 + box.p1) / 2.0
    own = (flat.p0 + flat.p1) / 2.0
    to_place = Affine2D().translate(*-own).rotate_deg(turn).translate(*middle)
    return np.asarray(to_place.transform(np.asarray(flat.corners())[[0, 1, 3, 2]])) / per_point


def _overlap(one: Corners, other: Corners) -> float:
    """Return the depth to which two rectangles overlap, pt; 0 if a line separates them."""
    depth = np.inf
    for corners in (one, other):
        for edge in (corners[1] - corners[0], corners[2] - corners[1]):
            length = float(np.hypot(*edge))
            if length == 0.0:
                return 0.0
            along = edge / length
            first = one @ along
            second = other @ along
            depth = min(depth, first.max() - second.min(), second.max() - first.min())
            if depth <= 0.0:
                return 0.0
    return float(depth)
