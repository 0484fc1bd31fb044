"""Scales of a figure's axes, and the caption below its panels."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import ColumnLabel, as_read, drawn_name, number, plain
from tendon_cli.figures.backend import Axes, ticker
from tendon_cli.figures.frame import text_width
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.quantities import SIDES
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.studies.space.axis import Axis
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.values import StudyNumber

_LONGEST_NAME = 40
"""Most characters of the name of a cell."""
_MOST_NAMES = 40
"""Largest number of names of rows that are all written along an axis."""
_NAME_SIZE = 7.0
_NAME_GAP = 1.2
"""Space between names side by side, mm."""
_NAME_HEIGHT = 3.0
"""Height of the name of a cell, mm."""


@dataclass(frozen=True)
class Scale:
    """The values of an axis in the unit shown, ascending.

    Listed values and names have the places 0, 1, 2, ..., and cells of one size: there is nothing
    between them.
    """

    label: str
    places: Array
    order: npt.NDArray[np.intp]
    """Position of each place among the values as they were given."""
    is_log: bool = False
    names: tuple[str, ...] = ()

    @cached_property
    def edges(self) -> Array:
        """Borders of the cells around the places (places + 1)."""
        places = np.log(self.places) if self.is_log else self.places
        if len(places) == 1:
            half = 0.5 if self.names else 0.05 * max(abs(float(places[0])), 1.0)
            edges = np.array([places[0] - half, places[0] + half])
        else:
            middles = (places[:-1] + places[1:]) / 2.0
            first = 2.0 * places[0] - middles[0]
            last = 2.0 * places[-1] - middles[-1]
            edges = np.concatenate(([first], middles, [last]))
        return np.exp(edges) if self.is_log else edges

    def reversed(self) -> Scale:
        """Return a scale of names in the opposite order."""
        return replace(self, order=self.order[::-1], names=self.names[::-1])

    def apply(
        self, axes: Axes, which: Literal["x", "y"], room: float = 60.0, *, cells: bool = False
    ) -> None:
        """Set scale, limits and ticks of an axis of a panel.

        Args:
            axes: The panel.
            which: The axis.
            room: About the length of the axis, mm, by which names are turned and cut.
            cells: True if the panel is drawn in cells, which are to be whole.
        """
        if self.is_log:
            axes.set(**{f"{which}scale": "log"})
        self._set_ticks(axes.xaxis if which == "x" else axes.yaxis, which, room)
        has_cells = cells or bool(self.names) or len(self.places) == 1
        ends = self.edges if has_cells else self.places
        if ends[0] < ends[-1]:  # in a table that tendon wrote, always
            axes.set(**{f"{which}lim": (ends[0], ends[-1])})

    def _set_ticks(self, axis: Any, which: str, room: float) -> None:
        if self.names:
            self._name_ticks(axis, which, room)
        elif self.is_log:
            decades = math.log10(self.places[-1] / self.places[0])
            steps = (1.0, 2.0, 5.0) if decades < 1.2 * room / 20.0 else (1.0,)
            axis.set_major_locator(ticker.LogLocator(subs=steps, numticks=12))
            axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: number(value)))
            axis.set_minor_formatter(ticker.NullFormatter())
        else:
            axis.set_major_locator(ticker.MaxNLocator("auto", steps=_steps(self.label)))

    def _name_ticks(self, axis: Any, which: str, room: float) -> None:
        """Name the cells: upright if they have no room side by side, some of very many."""
        along = _NAME_HEIGHT
        if which == "x" and self.height_of_names(room):
            axis.set_tick_params(labelrotation=90)
        elif which == "x":
            along = self._widest + _NAME_GAP
        size = _NAME_SIZE
        every = max(1, math.ceil(along * len(self.names) / max(room, along)))
        # A number that is left out is read from its neighbours, but not a name.
        if not self.are_numbers and len(self.names) <= _MOST_NAMES:
            size = min(size, size * room / (along * len(self.names)))
            every = 1
        axis.set_major_locator(ticker.FixedLocator(list(self.places[::every])))
        axis.set_major_formatter(ticker.FixedFormatter(self._texts[::every]))
        axis.set_tick_params(labelsize=size)

    def height_of_names(self, room: float) -> float:
        """Return the height of names below a panel of a width in mm; 0 if they are not turned."""
        if not self.names or (self._widest + _NAME_GAP) * len(self.names) <= room:
            return 0.0
        return self._widest

    @cached_property
    def _texts(self) -> list[str]:
        return short_names(self.names, _LONGEST_NAME)

    @cached_property
    def _widest(self) -> float:
        return max(text_width(text, _NAME_SIZE) for text in self._texts)

    @cached_property
    def are_numbers(self) -> bool:
        """True for names that are listed numbers."""
        return all(re.fullmatch(r"[−\d.,e]+", name) for name in self.names)


def axis_scale(
    cube: Cube, axis: Axis, at: Rows | slice, units: Mapping[str, str], *, has_cells: bool = False
) -> Scale:
    """Return the scale of some values of an axis.

    Args:
        cube: The table.
        axis: The axis.
        at: Positions of the values.
        units: Units to show, by dimension.
        has_cells: True if listed values stand in cells; they have their places otherwise.
    """
    values = axis.values[at]
    if axis.is_text:
        label = say.spaced(axis.column)
        return scale_of_names(label, list(map(str, values)), np.arange(len(values)))
    shown = cube.shown(axis.column, units)
    order = np.argsort(values, kind="stable")
    if not np.isfinite(values).all():  # a rigid spring is off every scale
        names = [shown.text(float(value)) for value in values[order]]
        return scale_of_names(shown.titled, names, order)
    places = shown.scaled(values)[order]
    if has_cells and not axis.is_range:
        return scale_of_names(shown.label, list(map(number, places.tolist())), order)
    return Scale(shown.label, places, order, axis.is_log and bool(np.all(values > 0.0)))


def scale_of_names(label: str, names: Sequence[str], order: npt.NDArray[np.intp]) -> Scale:
    """Return a scale of names, one place apart, in this order."""
    return Scale(label, np.arange(len(names), dtype=np.float64), order, names=tuple(names))


def short_names(names: Sequence[str], width: int) -> list[str]:
    """Return names ready to be drawn, those longer than so many characters cut in the middle.

    Names often differ in their ends only, as "spring 2024 lot 1" does.
    """
    head = width // 2
    return [
        plain(name, lines=1)
        if len(name) <= width
        else f"{plain(name[: head - 1])}…{plain(name[head - width :])}"
        for name in names
    ]


def plain_numbers() -> Any:
    """Return a formatter that writes all ticks with equally many decimals, without an offset."""
    return ticker.ScalarFormatter(useOffset=False)


def _steps(label: str) -> list[float]:
    """Return round steps for ticks; those of degrees divide a right angle."""
    if "(deg)" in label or "(°)" in label:
        return [1, 1.5, 3, 4.5, 6, 9, 10]
    return [1, 2, 2.5, 5, 10]


def caption(
    cube: Cube, spec: FigureSpec, read: Mapping[str, ColumnArray], *, varied: Collection[str]
) -> tuple[list[str], list[str]]:
    """Return the caption of a figure.

    Args:
        cube: The table.
        spec: The figure as the user asks for it.
        read: Defining columns of the rows drawn.
        varied: Columns that vary in the figure.

    Returns:
        The lines of the caption, and the fixed values in them.
    """
    fixed = []
    for axis in cube.axes:
        if axis.is_text and axis.column in read and axis.column not in varied and axis.length > 1:
            names = np.unique(read[axis.column])
            if len(names) == 1:
                fixed.append(drawn_name(axis, str(names[0]), spec.units))
    of_names = [name for name, (_, axis) in cube.columns_of_names.items() if not axis.is_text]
    known = [name for name in dict.fromkeys([*cube.defining, *of_names]) if name in read]
    for name in known:
        if name in varied:
            continue
        values = np.unique(read[name])
        if len(values) == 1 and np.isfinite(values[0]):
            fixed.append(cube.shown(name, spec.units).equation(float(values[0])))
    fixed += off_default(cube.study, {*known, *varied}, spec.units)
    lines = []
    if spec.where:
        lines.append(f"Only where {plain(' and '.join(spec.where))}.")
    if fixed:
        lines.append(f"At {', '.join(fixed)}.")
    return lines, fixed


def off_default(study: Study, named: Collection[str], units: Mapping[str, str]) -> list[str]:
    """Return the values of a study that are not the default, such as "K_A = 10 kN/m".

    Args:
        study: The study.
        named: Columns that a figure names anyway, which are left out.
        units: Units to show, by dimension.
    """
    document = study.document()
    defaults = dict(_values_of(_defaults()))
    texts = []
    for path, value in _values_of(document):
        key = keys().get(path)
        if defaults.get(path) == value or (key is not None and key.column in named):
            continue
        if key is None:
            text = f"{path} = {value}" if isinstance(value, str) else f"{path} as in the study"
            texts.append(plain(text))
        else:
            shown = ColumnLabel.of(key.column, as_read(key.quantity, document), units)
            texts.append(_number_text(shown, study.numbers.get(path)))
    return texts


def _number_text(shown: ColumnLabel, values: StudyNumber | None) -> str:
    """Write a number of a study with its symbol; None means a curve over the angle."""
    if values is None:
        return f"{shown.symbol} over the angle"
    if values.uncertain is not None:
        middle = shown.equation(values.uncertain.middle)
        spread = shown.text(values.uncertain.spread)
        uniform = " (uniform)" if values.uncertain.kind == "uniform" else ""
        return f"{middle} ± {spread}{uniform}"
    first = shown.equation(float(values.array[0]))
    if len(values) == 1:
        return first
    last = shown.text(float(values.array[-1]))
    if first.endswith(" load"):
        return f"{first.removesuffix(' load')} to {last} load"
    return f"{first} to {last}"


_SUIT_TABLES = (
    "arm",
    "sheath",
    "tendon",
    "spring",
    "spool",
    "anchor",
    "joint",
    "load",
    "setting",
    "model",
)
"""Tables of a study that describe the suit and its load."""


def _values_of(study: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield every value of a resolved study that describes the suit and its load, by key."""
    tables = SIDES if prefix else _SUIT_TABLES
    for name, value in study.items():
        key = f"{prefix}{name}"
        if name in tables:
            yield from _values_of(value, f"{key}.")
        elif prefix and key != "joint.name":
            yield key, value


@cache
def _defaults() -> dict[str, Any]:
    """Return the resolved study in which everything is the default."""
    return Study().document()


def value_texts(cube: Cube, axis: Axis, at: Rows, units: Mapping[str, str]) -> list[str]:
    """Return the values at some positions of an axis, as a title or a key names them."""
    values = axis.values[at]
    if axis.is_text:
        return [drawn_name(axis, str(value), units) for value in values]
    return [cube.shown(axis.column, units).equation(float(value)) for value in values]
