"""The figures that a study declares (`[[figure]]`), drawn from the tables of its run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from tendon_cli.errors import TendonError, UsageError
from tendon_cli.figures.curve_data import CurveData, Curves, curve_data
from tendon_cli.figures.curve_plan import ANGLE, DIRECTION, CurvePlan, plan_curves
from tendon_cli.figures.curves import draw_curves
from tendon_cli.figures.engine import Axes, Figure
from tendon_cli.figures.labels import Shown
from tendon_cli.figures.map_plan import LOAD
from tendon_cli.figures.product import Columns, Ints, Product, evenly, product_of
from tendon_cli.figures.request import PlotRequest, read_size
from tendon_cli.figures.style import INK, house_style, save
from tendon_cli.figures.where import choose, read_filter
from tendon_cli.quantities import Quantity
from tendon_cli.study.derived import DERIVED
from tendon_cli.study.figures import DeclaredFigure
from tendon_cli.study.study import Study
from tendon_cli.tables.read import TableFiles, open_table
from tendon_cli.units import UNITS

_NEGATIVE_IS_SLACK = ("_tension_distal", "_tension_proximal", "_elongation", "_extensor_tension", "_flexor_tension")
_SLACK_AREA, _SLACK_WORD = "#fbeae0", "#8a3b12"

Finish = Callable[[DeclaredFigure, Figure], None]
"""Adds to a figure before it is written; matplotlib is in the house style then."""


def draw_declared(study: Study, run_folder: Path, out: Path | None = None, finish: Finish | None = None) -> list[Path]:
    """Draw every figure that a study declares of the tables in its run folder, into it unless `out` says where.

    Returns the files written. Raises UsageError where a figure does not fit the study, InputError for a damaged or
    missing table, OutputError; each names its figure.
    """
    written: list[Path] = []
    for figure in study.figure:
        try:
            written += _draw(figure, run_folder, out or run_folder, finish)
        except TendonError as error:
            place = f" ({error.where})" if error.where else ""
            error.where = f'figure "{figure.name}"{place}'
            raise
    return written


def _draw(figure: DeclaredFigure, run_folder: Path, out: Path, finish: Finish | None) -> list[Path]:
    if not (run_folder / f"{figure.table}.parquet").exists():
        hint = f'[output] tables needs "{figure.table}"'
        raise UsageError(f"{figure.quantity[0]} is of {figure.table}, which the run has not written", hint=hint)
    written: list[Path] = []
    pages = pages_of(figure, open_table(run_folder / f"{figure.table}.parquet"), finish)
    for number, page in enumerate(pages, 1):
        stem = figure.name if number == 1 else f"{figure.name}-{number}"
        written += [save(page, out / f"{stem}.{kind}", must_fit=True) for kind in dict.fromkeys(figure.format)]
    return written


def shade_slack(axes: Axes) -> None:
    """Shade and name what lies below zero in a panel, where negative means slack."""
    low, high = axes.get_ylim()
    if low >= 0.0:
        return
    axes.axhspan(low, 0.0, facecolor=_SLACK_AREA, linewidth=0.0, zorder=0.3, gid="slack area")
    axes.axhline(0.0, color=INK, linewidth=0.5, zorder=1.2)
    axes.text(0.02, 0.03, "slack", transform=axes.transAxes, color=_SLACK_WORD, style="italic", gid="slack word")
    axes.set_ylim(low, high)


def _reaches_below_zero(page: Figure) -> bool:
    """Whether a line goes so far below zero that it is seen."""
    least = [np.nanmin(line.get_ydata(), initial=0.0) for axes in page.axes for line in axes.lines]
    return bool(min(least, default=0.0) < -0.01 * max(axes.get_ylim()[1] for axes in page.axes))


def pages_of(figure: DeclaredFigure, table: TableFiles, finish: Finish | None = None) -> list[Figure]:
    """The pages of a figure; raises UsageError where it does not fit the table."""
    product = with_derived(product_of(table))
    request = PlotRequest(figure.quantity, figure.x, _axis(product, figure.colour), _axis(product, figure.panels))
    filters = [read_filter(text, product) for text in figure.where]
    chosen = choose(product, filters)
    if figure.overlay:
        request = replace(request, panels=request.panels or _usual_panels(product, chosen))
    plan = plan_curves(product, chosen, request)
    if figure.overlay:
        plan = _without_colour(plan)
    data = curve_data(product, plan, filters, {})
    data = replace(data, curves=tuple(map(_named, data.curves)))
    data = replace(data, title=figure.title) if figure.title else data
    width, height = read_size(figure.size)
    with house_style():
        pages = draw_curves(_overlaid(data) if figure.overlay else data, width, height)
        for page in pages:
            if all(name.endswith(_NEGATIVE_IS_SLACK) for name in figure.quantity):
                for axes in page.axes if _reaches_below_zero(page) else ():
                    shade_slack(axes)
            if finish is not None:
                finish(figure, page)
    return pages


@dataclass(frozen=True)
class _Table(TableFiles):
    """A table whose schema has the derived quantities too."""

    @cached_property
    def schema(self) -> pa.Schema:
        schema = TableFiles(**_fields_of(self)).schema
        for name, derived in DERIVED.items():
            if set(_needs(name, schema.names)) <= set(schema.names):
                meta = {"unit": derived.quantity.shown_in, "long_name": derived.quantity.long_name}
                schema = schema.append(pa.field(name, pa.float64(), metadata=meta))
        return schema


@dataclass(frozen=True)
class _Product(Product):
    """A product that computes the derived quantities when they are asked for."""

    def gather(self, rows: Ints, columns: Sequence[str]) -> Columns:
        names = self.table.schema.names
        stored = [need for name in columns for need in (_needs(name, names) if name in DERIVED else [name])]
        read = super().gather(rows, stored)
        for name in columns:
            if name in DERIVED:
                values = DERIVED[name].of(*(read[need] for need in _needs(name, names)))
                read[name] = np.asarray(values, dtype=np.float64)
        return {name: read[name] for name in columns}


def with_derived(product: Product) -> Product:
    """The same product, whose table offers the derived quantities as columns."""
    table = _Table(**_fields_of(product.table))
    return _Product(**{**_fields_of(product), "table": table})


def _fields_of(thing: Any) -> dict[str, Any]:
    return {field.name: getattr(thing, field.name) for field in fields(thing)}


def _needs(name: str, columns: Sequence[str]) -> list[str]:
    """The columns that a derived quantity follows from; that of its side where the sides differ."""
    derived = DERIVED[name]
    return [side if (side := f"{need}_{derived.side}") in columns else need for need in derived.needs]


def _axis(product: Product, name: str | None) -> str | None:
    """An axis by name or key; nothing where the study has one value of it, as `--set` may leave."""
    return next((axis.column for axis in product.axes if name in (axis.column, axis.key)), None)


def _usual_panels(product: Product, chosen: Mapping[str, Ints]) -> str | None:
    """The load, or else the first axis of several values that does not run along x or by dashes."""
    names = [axis.column for axis in product.axes if len(chosen[axis.column]) > 1]
    free = [name for name in names if name not in (DIRECTION, ANGLE)]
    return LOAD if LOAD in free else next(iter(free), None)


def _without_colour(plan: CurvePlan) -> CurvePlan:
    """The plan whose axis of colours, if it has one, is held at one value."""
    if plan.colour is None:
        return plan
    at = plan.positions[plan.colour.column]
    positions = {**plan.positions, plan.colour.column: at[evenly(len(at), 1)]}
    return replace(plan, colour=None, positions=positions, fixed=(*plan.fixed, plan.colour))


def _named(curves: Curves) -> Curves:
    """The same curves; a derived quantity by its own name, symbol and dimension."""
    column = curves.quantity.column
    if column not in DERIVED:
        return curves
    quantity = DERIVED[column].quantity
    unit = quantity.shown_in
    return replace(curves, quantity=Shown(column, quantity, unit, float(UNITS[unit].factor)))


def _overlaid(data: CurveData) -> CurveData:
    """All quantities in each panel, a colour each."""
    first = data.curves[0].quantity
    same = Quantity(first.quantity.dimension, "", first.quantity.dimension, first.unit, first.unit, "")
    values, slack = (np.concatenate([getattr(each, part) for each in data.curves], axis=1) for part in _PARTS)
    return replace(
        data,
        curves=(Curves(Shown(same.name, same, first.unit, first.factor), values, slack),),
        x_values=np.concatenate([data.x_values] * len(data.curves), axis=1),
        colours=tuple(each.quantity.titled for each in data.curves),
        is_ordered=False,
    )


_PARTS = ("values", "slack")
