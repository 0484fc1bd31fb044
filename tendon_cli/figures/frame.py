"""A page with a figure: a title above the panels, the key and a few sentences below, and its file.

Every figure begins here, in `house_style()`: `framed` gives a page to draw on, `Page.save` writes
it with its caption and its study in the file's metadata. Matplotlib lays out the panels.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from os import PathLike
from pathlib import Path
from typing import Any

from tendon_cli.cube.labels import plain, with_symbols, without_formulas
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import (
    ConstrainedLayoutEngine,
    Figure,
    FigureCanvasAgg,
    FontProperties,
    is_math_text,
    text_to_path,
)
from tendon_cli.figures.style import MM, PAGE_WIDTH, format_of, named, preview, render
from tendon_cli.files import check_output, is_figure, result_path, write_output
from tendon_cli.studies.study import Study
from tendon_cli.verbs.answer_record import AnswerRecord

_POINT = 25.4 / 72.0
"""A point, mm."""
_TITLE_SIZE = 9.0
_NOTE_SIZE = 6.5
_KEY_SIZE = 7.0
_LINE = 1.25
"""Height of a line of text, as a factor of its size."""
_PAD = 1.5
"""Space around title, key and notes, mm."""
_KEY_HANDLE = 11.0
"""Width of the sample in the key, with the space around it, mm."""
_LOWEST_PANELS = 30.0
"""Least height of all panels if the page has a given height, mm."""
_NO_BREAK = "\u00a0"
_IN_EQUATION = re.compile(
    r" (?=[=±≤≥])|(?<=[=±≤≥]) |(?<=\d) (?=[A-Za-z%°])|(?<=\d N) (?=m\b)| (?=[^()\s]{1,6}\))"
)
"""Spaces in an equation, before a unit and in one, at which no line is broken."""


@dataclass(frozen=True)
class Page:
    """A figure, and the text about it that its file holds."""

    figure: Figure
    title: str
    says: str
    """Caption, without formulas, for the file's metadata."""
    study: str
    """Name and hash of the study shown."""
    width: float
    """Width, mm."""
    inner: float
    """Height of all panels, mm."""

    def check_fits(self) -> None:
        """Raise UsageError if the panels do not fit into the size of the page."""
        FigureCanvasAgg(self.figure)
        with warnings.catch_warnings():
            warnings.filterwarnings("error", message="constrained_layout not applied")
            try:
                self.figure.draw_without_rendering()
            except UserWarning:
                raise _too_small() from None

    def save(self, path: Path, *, overwrite: bool = False) -> Path:
        """Write the file whole or not at all, in the format of its ending.

        Args:
            path: The file.
            overwrite: True to replace a file that tendon did not write.

        Raises:
            OutputError: The file cannot be written.
            UsageError: The ending is not that of a figure, or tendon did not write the file.
        """
        kind = format_of(path, "--out")
        check_output(path, is_figure, overwrite=overwrite)
        about = {"title": self.title, "says": self.says, "study": self.study}
        content = render(self.figure, kind, about)
        write_output(path, content, is_figure, overwrite=overwrite)
        return path

    def png(self) -> bytes:
        """Return the page as a small PNG, for a notebook."""
        return preview(self.figure)

    def shown(self, out: str | PathLike[str] | None = None, *, overwrite: bool = False) -> Figure:
        """Return the figure, which a notebook shows as a PNG; write it to a file as well.

        Args:
            out: The file; None for none.
            overwrite: True to replace a file that tendon did not write.

        Raises the errors of `save`.
        """
        if out is not None:
            self.save(result_path(out), overwrite=overwrite)
        self.figure._repr_png_ = self.png  # type: ignore[attr-defined]
        return self.figure


def _too_small() -> UsageError:
    hint = "choose a larger size, or fewer panels and quantities"
    return UsageError("the panels do not fit into this size", where="--size", hint=hint)


def save_pages(pages: Sequence[tuple[Page, Path]], *, overwrite: bool = False) -> list[Path]:
    """Write pages to their files, or none of them if a file is not tendon's.

    Raises the errors of `Page.save`.
    """
    for _, path in pages:
        check_output(path, is_figure, overwrite=overwrite)
    return [page.save(path, overwrite=overwrite) for page, path in pages]


def numbered(pages: Sequence[Page], path: Path) -> list[tuple[Page, Path]]:
    """Return the file of each page: FILE.png, FILE_2.png, FILE_3.png."""
    files = [path.with_stem(f"{path.stem}_{number}") for number in range(2, len(pages) + 1)]
    return list(zip(pages, [path, *files], strict=False))


def source_of(record: AnswerRecord) -> str:
    """Return name and hash of the study of a record, by which `is_figure` knows a figure."""
    return f"tendon study {record.name} {record.study_hash}"


def source_of_study(study: Study) -> str:
    """Return name and hash of a study, for a figure's file."""
    return f"tendon study {study.name} {study.hash}"


def framed(
    title: str,
    panels: float,
    key: Sequence[Any] = (),
    notes: Sequence[str] = (),
    *,
    width: float = PAGE_WIDTH,
    height: float | None = None,
    subtitle: str = "",
    study: str = "",
    is_of_answer: bool = False,
) -> Page:
    """Begin a page with its title, key and notes, and with room for its panels.

    Args:
        title: The title as the user wrote it, or a sentence of an answer.
        panels: Height of all panels, mm.
        key: Artists with a label.
        notes: Sentences below the panels; they may hold formulas.
        width: Width of the page, mm.
        height: Height of the page, mm. If it is given, the panels have what it leaves for them.
        subtitle: Second title, which may hold formulas and line breaks.
        study: Name and hash of the study for the file's metadata.
        is_of_answer: True if the title is a sentence of an answer, whose symbols are to be set as
            formulas.

    Raises:
        UsageError: The height leaves no room for the panels.
    """
    room = width - 2.0 * _PAD
    heading = with_symbols(title) if is_of_answer else plain(title)
    subtitle = named(subtitle)
    notes = [named(note) for note in notes]
    head = [fitted(heading, room, _TITLE_SIZE, "bold")] if heading else []
    head += [fitted(line, room, _TITLE_SIZE, "bold") for line in subtitle.splitlines()]
    foot = [fitted(note, room, _NOTE_SIZE) for note in notes]
    labels = [fitted(str(entry.get_label()), room - _KEY_HANDLE, _KEY_SIZE) for entry in key]
    head_height = _height(head, _TITLE_SIZE)
    notes_height = _height(foot, _NOTE_SIZE)
    key_height = 0.0
    figure = Figure(figsize=(width * MM, 1.0))
    if key:
        legend = figure.legend(
            handles=list(key),
            labels=labels,
            loc="center",
            ncols=_columns_of_key(labels, room),
            borderaxespad=0.0,
            borderpad=0.0,
            columnspacing=1.4,
            handletextpad=0.6,
        )
        legend.set_in_layout(False)
        key_height = legend.get_window_extent(_renderer()).height / figure.dpi / MM + _PAD
    around = head_height + key_height + notes_height
    if height is None:
        height = panels + around
    if height - around < _LOWEST_PANELS and height != panels + around:
        raise _too_small()
    panels = height - around
    rect = (0.0, (key_height + notes_height) / height, 1.0, panels / height)
    layout = ConstrainedLayoutEngine(rect=rect, w_pad=0.03, h_pad=0.03)
    figure.set_size_inches(width * MM, height * MM)
    figure.set_layout_engine(layout)
    top = 1.0 - 0.6 * _PAD / height
    style: dict[str, Any] = {"linespacing": _LINE, "in_layout": False}
    figure.text(
        _PAD / width,
        top,
        "\n".join(head),
        size=_TITLE_SIZE,
        weight="bold",
        va="top",
        gid="title",
        **style,
    )
    figure.text(
        _PAD / width,
        0.6 * _PAD / height,
        "\n".join(foot),
        va="bottom",
        size=_NOTE_SIZE,
        color="#4d4d4d",
        gid="notes",
        **style,
    )
    if key:
        legend.set_bbox_to_anchor((0.0, notes_height / height, 1.0, key_height / height))
    says = without_formulas(" ".join(text for text in (subtitle, *notes) if text))
    return Page(figure, title, says, study, width, panels)


@cache
def _renderer() -> Any:
    """Return what measures a key before its page has a size."""
    canvas: Any = FigureCanvasAgg(Figure(figsize=(1.0, 1.0)))
    return canvas.get_renderer()


def _height(texts: Sequence[str], size: float) -> float:
    """Return the height of texts below each other, mm; 0 without any."""
    lines = sum(text.count("\n") + 1 for text in texts)
    return lines * _LINE * size * _POINT + 1.2 * _PAD if lines else 0.0


def _columns_of_key(labels: Sequence[str], room: float) -> int:
    """Return how many entries of the key stand side by side."""
    widest = max((text_width(label, _KEY_SIZE) for label in labels), default=0.0)
    return max(1, min(len(labels), int((room + 2.0) / (widest + _KEY_HANDLE))))


def fitted(text: str, room: float, size: float = 8.0, weight: str = "normal") -> str:
    """Break a text, which may hold formulas, into lines that are no wider than `room` mm."""
    lines = [""]
    for word in _IN_EQUATION.sub(_NO_BREAK, named(text)).split(" "):
        longer = f"{lines[-1]} {word}" if lines[-1] else word
        if not lines[-1] or text_width(longer, size, weight) <= room:
            lines[-1] = longer
        else:
            lines.append(word)
    whole = "\n".join(_broken(line, room, size, weight) for line in lines)
    return whole.replace(_NO_BREAK, " ")


def _broken(line: str, room: float, size: float, weight: str) -> str:
    """Break a word of plain text that is wider than `room` mm."""
    width = text_width(line, size, weight)
    if width <= room or is_math_text(line):
        return line
    most = max(4, int(0.9 * len(line) * room / width))
    return "\n".join(line[start : start + most] for start in range(0, len(line), most))


@cache
def text_width(text: str, size: float, weight: str = "normal") -> float:
    """Return the width of the widest line of a text as it is drawn, mm.

    Args:
        text: The text, which may hold formulas.
        size: Size of its letters, pt.
        weight: "normal" or "bold".
    """
    font = FontProperties(family=["DejaVu Sans"], size=size, weight=weight)
    widths = [0.0]
    for line in text.split("\n"):
        is_formula = bool(is_math_text(line))
        words = line if is_formula else line.replace(r"\$", "$")
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Glyph .* missing from")
            width, _, _ = text_to_path.get_text_width_height_descent(words, font, is_formula)
        widths.append(float(width))
    return max(widths) * _POINT


def grid_shape(panels: int, in_row: int = 1, *, most: int = 4) -> tuple[int, int]:
    """Return the rows and columns for panels on a page.

    Args:
        panels: Number of panels.
        in_row: Number of panels that belong side by side. It counts if they fill several rows.
        most: Largest number of columns.
    """
    fits = 2 <= in_row <= most and panels % in_row == 0 and panels > in_row
    usual = {1: 1, 2: 2, 3: 3, 4: 2}.get(panels, 3 if panels <= 9 else most)
    columns = min(most, in_row if fits else usual)
    return math.ceil(panels / columns), columns


def panels_of(page: Page, rows: int, columns: int, count: int, **shared: Any) -> list[Any]:
    """Add a grid of panels to a page, and return the `count` of them that are used.

    Args:
        page: The page.
        rows: Number of rows.
        columns: Number of columns.
        count: Number of panels.
        **shared: Arguments of `Figure.subplots`.
    """
    grid = page.figure.subplots(rows, columns, squeeze=False, **shared)
    for axes in grid.flat[count:]:
        axes.set_visible(False)
    used = list(grid.flat[:count])
    for place, axes in enumerate(used):
        is_lowest = place >= count - columns
        axes.tick_params(labelbottom=True)
        # A shared axis is drawn and measured once in each row and column.
        axes.xaxis.set_visible(is_lowest or "sharex" not in shared)
        axes.yaxis.set_visible(place % columns == 0 or "sharey" not in shared)
        for line in axes.spines.values():
            line.set_in_layout(False)  # they take long to measure, and are no wider than the panel
    return used
