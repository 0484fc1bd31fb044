"""Scales of a figure's axes, and the caption below its panels."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import ColumnLabel, as_read, drawn_name, number, plain
from tendon_cli.figures.backend import Axes, ticker
from tendon_cli.model.kinematics import Rows
from tendon_cli.quantities import SIDES
from tendon_cli.space.axis import Axis
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.values import StudyNumber

_FEW = 6
"""Fewer values than this have a tick each."""
_MOST_NAMES = 12
"""Largest number of names that are all written upright along an axis."""
_MOST_TURNED = 40
"""Largest number of names that are all written along an axis; of more, some are left out."""
_SMALL = 6.5
"""Size of names that are many, pt."""


@dataclass(frozen=True)
class Scale:
    """The values of an axis in the unit shown, ascending; names have the places 0, 1, 2, ..."""

    label: str
    places: npt.NDArray[np.float64]
    order: npt.NDArray[np.intp]
    """Position of each place among the values as they were given."""
    is_log: bool = False
    names: tuple[str, ...] = ()

    @cached_property
    def edges(self) -> npt.NDArray[np.float64]:
        """Borders of the cells around the places (places + 1)."""
        places = np.log(self.places) if self.is_log else self.places
        if len(places) > 1:
            first_step = places[1] - places[0]
            last_step = places[-1] - places[-2]
        else:
            first_step = max(abs(places[0]), 1.0) * 0.1
            last_step = first_step
        middles = (places[:-1] + places[1:]) / 2.0
        first = places[0] - first_step / 2.0
        last = places[-1] + last_step / 2.0
        edges = np.concatenate(([first], middles, [last]))
        return np.exp(edges) if self.is_log else edges

    def by_value(self) -> Scale:
        """Return a scale on which each value stands by name, in cells of one size."""
        names = tuple(map(number, self.places.tolist()))
        return Scale(self.label, np.arange(len(names), dtype=np.float64), self.order, names=names)

    def limits(self, *, cells: bool = False) -> tuple[float, float]:
        """Return the limits of the axis, from the first value to the last.

        With `cells`, and for names or a single value, the first and the last cell are whole.
        """
        has_cells = cells or bool(self.names) or len(self.places) == 1
        ends = self.edges if has_cells else self.places
        return float(ends[0]), float(ends[-1])

    def apply(
        self, axes: Axes, which: Literal["x", "y"], *, ticks: int = 6, cells: bool = False
    ) -> None:
        """Set scale, limits and ticks of an axis of a panel.

        Args:
            axes: The panel.
            which: The axis.
            ticks: Largest number of ticks.
            cells: True if the panel is drawn in cells, which are to be whole.
        """
        set_scale = axes.set_xscale if which == "x" else axes.set_yscale
        set_limits = axes.set_xlim if which == "x" else axes.set_ylim
        if self.is_log:
            set_scale("log")
        self._set_ticks(axes.xaxis if which == "x" else axes.yaxis, which, ticks)
        low, high = self.limits(cells=cells)
        if low < high:  # in a table that tendon wrote, always
            set_limits(low, high)

    def _set_ticks(self, axis: Any, which: str, ticks: int) -> None:
        """Set at most so many ticks, and their labels."""
        if self.names:
            are_many = _MOST_NAMES < len(self.names) <= _MOST_TURNED
            every = 1 if are_many else math.ceil(len(self.names) / _MOST_NAMES)
            width = 16 if which == "y" or are_many else 13
            lines = 1 if are_many else 2
            texts = short_names(self.names, width, lines)
            axis.set_major_locator(ticker.FixedLocator(list(self.places[::every])))
            axis.set_major_formatter(ticker.FixedFormatter(texts[::every]))
            if are_many:
                turned = {"labelrotation": 90} if which == "x" else {}
                axis.set_tick_params(labelsize=_SMALL, **turned)
            return
        axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: number(value)))
        if len(self.places) < _FEW:
            axis.set_major_locator(ticker.FixedLocator(list(self.places)))
            axis.set_minor_locator(ticker.NullLocator())
        elif self.is_log:
            decades = math.log10(self.places[-1] / self.places[0])
            steps = (1.0, 2.0, 5.0) if decades < 3.5 else (1.0,)
            axis.set_major_locator(ticker.LogLocator(subs=steps, numticks=12))
            axis.set_minor_formatter(ticker.NullFormatter())
        else:
            axis.set_major_locator(ticker.MaxNLocator(ticks, steps=_steps(self.label)))
            axis.set_major_formatter(plain_numbers())


def axis_scale(
    cube: Cube, axis: Axis, at: Rows | slice, units: Mapping[str, str], *, is_log: bool = True
) -> Scale:
    """Return the scale of some values of an axis.

    Args:
        cube: The table.
        axis: The axis.
        at: Positions of the values.
        units: Units to show, by dimension.
        is_log: False if the scale must be linear; otherwise it is logarithmic if the axis is.
    """
    values = axis.values[at]
    if axis.is_text:
        label = say.spaced(axis.column)
        return _scale_of_names(label, list(map(str, values)), np.arange(len(values)))
    shown = cube.shown(axis.column, units)
    order = np.argsort(values, kind="stable")
    if not np.isfinite(values).all():  # a rigid spring is off every scale
        names = [shown.text(float(value)) for value in values[order]]
        return _scale_of_names(shown.titled, names, order)
    can_be_log = is_log and axis.is_log and bool(np.all(values > 0.0))
    return Scale(shown.label, shown.scaled(values)[order], order, can_be_log)


def _scale_of_names(label: str, names: Sequence[str], order: npt.NDArray[np.intp]) -> Scale:
    """Return a scale on which names have the places 0, 1, 2, ..."""
    return Scale(label, np.arange(len(names), dtype=np.float64), order, names=tuple(names))


def short_names(names: Sequence[str], width: int, lines: int = 1) -> list[str]:
    """Return names cut to so many characters in each of a few lines, ready to be drawn.

    Names that would look alike without their ends, such as "spring 2024 lot 1", are cut in the
    middle.
    """
    texts = [plain(name, width=width, lines=lines) for name in names]
    alike = {text for text, count in Counter(texts).items() if count > 1}
    return [
        _cut_in_middle(name, width, lines) if text in alike else text
        for name, text in zip(names, texts, strict=True)
    ]


def _cut_in_middle(name: str, width: int, lines: int) -> str:
    """Return the beginning and the end of a name, in one line or two."""
    if lines > 1:
        return f"{plain(name[: width - 2])} …\n{plain(name[-width:])}"
    head = width // 2
    return f"{plain(name[: head - 1])}…{plain(name[head - width :])}"


def plain_numbers() -> Any:
    """Return a formatter that writes all ticks with equally many decimals, without an offset."""
    formatter = ticker.ScalarFormatter(useOffset=False)
    formatter.set_powerlimits((-4, 7))
    return formatter


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
        # A legend leaves out what starts with an underscore.
        texts = [drawn_name(axis, str(value), units) for value in values]
        return [f" {text}" if text.startswith("_") else text for text in texts]
    return [cube.shown(axis.column, units).equation(float(value)) for value in values]
