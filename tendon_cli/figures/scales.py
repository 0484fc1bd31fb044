"""Where the values of an axis stand on a figure, and what a figure says of them below its panels."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import Ints
from tendon_cli.cube.columns import Values
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import Shown, as_read, number, plain
from tendon_cli.figures.backend import Axes, ticker
from tendon_cli.space.axis import SIDES, Axis
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.studies.load import study_from
from tendon_cli.studies.study import Study, keys

_FEW = 6
"""Up to so many values each one has its tick."""
_MOST_NAMES = 12


@dataclass(frozen=True)
class Scale:
    """The values of one axis in the unit shown, ascending; names stand at 0, 1, 2, ..."""

    label: str
    places: npt.NDArray[np.float64]
    order: npt.NDArray[np.intp]
    """Position of each place among the values as they were given."""
    is_log: bool = False
    names: tuple[str, ...] = ()

    @cached_property
    def edges(self) -> npt.NDArray[np.float64]:
        """Borders of the cells around the places."""
        at = np.log(self.places) if self.is_log else self.places
        middles = (at[:-1] + at[1:]) / 2.0
        step = at[1] - at[0] if len(at) > 1 else max(abs(at[0]), 1.0) * 0.1
        last = at[-1] - at[-2] if len(at) > 1 else step
        edges = np.concatenate(([at[0] - step / 2.0], middles, [at[-1] + last / 2.0]))
        return np.exp(edges) if self.is_log else edges

    def limits(self, *, cells: bool = False) -> tuple[float, float]:
        """From the first value to the last; names, a single value and what is drawn in cells with their whole cells."""
        ends = self.edges if cells or self.names or len(self.places) == 1 else self.places
        return float(ends[0]), float(ends[-1])

    def apply(
        self, axes: Axes, which: Literal["x", "y"], *, ticks: int = 6, cells: bool = False
    ) -> None:
        """Set scale, limits and at most so many ticks of the x or y axis of a panel."""
        axis = axes.xaxis if which == "x" else axes.yaxis
        set_scale, set_limits = (
            (axes.set_xscale, axes.set_xlim) if which == "x" else (axes.set_yscale, axes.set_ylim)
        )
        if self.is_log:
            set_scale("log")
        self._set_ticks(axis, which, ticks)
        low, high = self.limits(cells=cells)
        if low < high:  # of a table of ours, always
            set_limits(low, high)

    def _set_ticks(self, axis: Any, which: str, ticks: int) -> None:
        if self.names:
            every = math.ceil(len(self.names) / _MOST_NAMES)
            texts = [plain(name, width=16 if which == "y" else 13, lines=2) for name in self.names]
            axis.set_ticks(self.places[::every], texts[::every])
            return
        axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: number(value)))
        if len(self.places) < _FEW:
            axis.set_major_locator(ticker.FixedLocator(list(self.places)))
            axis.set_minor_locator(ticker.NullLocator())
        elif self.is_log:
            decades = math.log10(self.places[-1] / self.places[0])
            axis.set_major_locator(
                ticker.LogLocator(subs=(1.0, 2.0, 5.0) if decades < 3.5 else (1.0,), numticks=12)
            )
            axis.set_minor_formatter(ticker.NullFormatter())
        else:
            axis.set_major_locator(ticker.MaxNLocator(ticks, steps=_steps(self.label)))
            axis.set_major_formatter(plain_numbers())


def axis_scale(
    cube: Cube, axis: Axis, at: Ints | slice, units: Mapping[str, str], *, is_log: bool = True
) -> Scale:
    """The scale of the values at some positions of an axis; logarithmic, unless forbidden, if the axis is."""
    values = axis.values[at]
    if axis.is_text:
        return _of_names("case", list(map(str, values)), np.arange(len(values)))
    shown, order = cube.shown(axis.column, units), np.argsort(values, kind="stable")
    if not np.isfinite(values).all():  # a rigid spring is off every scale
        return _of_names(shown.titled, [shown.text(float(value)) for value in values[order]], order)
    is_log = is_log and axis.is_log and bool(np.all(values > 0.0))
    return Scale(shown.label, shown.scaled(values)[order], order, is_log)


def _of_names(label: str, names: Sequence[str], order: npt.NDArray[np.intp]) -> Scale:
    return Scale(label, np.arange(len(names), dtype=np.float64), order, names=tuple(names))


def plain_numbers() -> Any:
    """Tick labels with the same number of decimals, without an offset."""
    formatter = ticker.ScalarFormatter(useOffset=False)
    formatter.set_powerlimits((-4, 7))
    return formatter


def _steps(label: str) -> list[float]:
    """Round steps; those of degrees divide a right angle."""
    return [1, 1.5, 3, 4.5, 6, 9, 10] if "(deg)" in label or "(°)" in label else [1, 2, 2.5, 5, 10]


_LONGEST_NAME = 40


def caption(
    cube: Cube, spec: FigureSpec, read: Mapping[str, Values], *, varied: Collection[str]
) -> tuple[list[str], list[str]]:
    """The lines of a caption, and the values in them; `read` has the defining columns of the rows drawn."""
    fixed = []
    for axis in cube.axes:
        if axis.is_text and axis.column in read and axis.column not in varied and axis.length > 1:
            names = np.unique(read[axis.column])
            fixed += [plain(str(names[0]))] if len(names) == 1 else []
    known = [name for name in cube.defining if name in read]
    for name in (name for name in known if name not in varied):
        values = np.unique(read[name])
        if len(values) == 1 and np.isfinite(values[0]):
            fixed.append(cube.shown(name, spec.units).equation(float(values[0])))
    fixed += off_default(cube.asked, {*known, *varied}, spec.units)
    lines = [f"Only where {plain(' and '.join(spec.where))}."] if spec.where else []
    return [*lines, *([f"At {', '.join(fixed)}."] if fixed else [])], fixed


def off_default(study: Study, named: Collection[str], units: Mapping[str, str]) -> list[str]:
    """What a study has otherwise than its defaults, but for columns that are named anyway: "K_A = 10 kN/m"."""
    document, usual, texts = study.document(), dict(_values_of(_defaults())), []
    for key, value in _values_of(document):
        known, values = keys().get(key), study.numbers.get(key)
        if usual.get(key) == value or (known is not None and known.column in named):
            continue
        if known is None:
            texts.append(
                plain(f"{key} = {value}" if isinstance(value, str) else f"{key} as in the study")
            )
            continue
        shown = Shown.of(known.column, as_read(known.number.quantity, document), units)
        if values is None:
            texts.append(f"{shown.symbol} over the angle")
        elif values.uncertain is not None:
            uniform = " (uniform)" if values.uncertain.kind == "uniform" else ""
            texts.append(
                f"{shown.equation(values.uncertain.middle)} ± {shown.text(values.uncertain.spread)}{uniform}"
            )
        else:
            text, last = shown.equation(float(values.array[0])), shown.text(float(values.array[-1]))
            of_load = " load" if text.endswith(" load") else ""
            texts.append(
                f"{text.removesuffix(of_load)} to {last}{of_load}" if len(values) > 1 else text
            )
    return texts


_OF_THE_SUIT = (
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


def _values_of(study: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Everything that a resolved study says of the suit and its load, by key."""
    for name, value in study.items():
        key = f"{prefix}{name}"
        if name in (SIDES if prefix else _OF_THE_SUIT):
            yield from _values_of(value, f"{key}.")
        elif prefix and key != "joint.name":
            yield key, value


@cache
def _defaults() -> dict[str, Any]:
    return study_from({}).document()


def value_texts(cube: Cube, axis: Axis, at: Ints, units: Mapping[str, str]) -> list[str]:
    """The values at some positions of an axis, as a title or a key names them."""
    values = axis.values[at]
    if axis.is_text:
        # A legend leaves out what starts with an underscore.
        texts = [plain(str(value), width=_LONGEST_NAME, lines=1) for value in values]
        return [f" {text}" if text.startswith("_") else text for text in texts]
    return [cube.shown(axis.column, units).equation(float(value)) for value in values]
