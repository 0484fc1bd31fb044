"""What a figure of curves shows, read from a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.figures.curve_plan import CurvePlan
from tendon_cli.figures.labels import Shown, shown
from tendon_cli.figures.map_data import title_of, value_texts
from tendon_cli.figures.product import Columns, Product
from tendon_cli.figures.scales import Scale, scale_of
from tendon_cli.figures.where import Filter

Floats = npt.NDArray[np.float64]
Truth = npt.NDArray[np.bool_]

_SLACK_OF = {"flexor": ("flexor slack", "both slack"), "extensor": ("extensor slack", "both slack")}
_ANY_SLACK = ("flexor slack", "extensor slack", "both slack")


@dataclass(frozen=True)
class Curves:
    """One quantity over panels, colours, dashes and x."""

    quantity: Shown
    values: Floats
    """In the unit shown, NaN where there is none."""
    slack: Truth
    """Where a tendon that the quantity speaks of is slack."""


@dataclass(frozen=True)
class CurveData:
    """Everything that the pages of curves show."""

    title: str
    x: Scale | None
    """None where x is not an axis but a column that changes along one."""
    x_label: str
    x_values: Floats
    """Of the shape of the curves."""
    curves: tuple[Curves, ...]
    colours: tuple[str, ...]
    is_ordered: bool
    """Whether the colours stand for numbers."""
    dashes: tuple[str, ...]
    panels: tuple[str, ...]
    notes: tuple[str, ...]


def curve_data(product: Product, plan: CurvePlan, filters: Sequence[Filter], units: Mapping[str, str]) -> CurveData:
    """Read the lines of a plan; raises UsageError where the filters, or nulls, leave nothing to draw."""
    schema = product.table.schema
    status = next((name for name in ("status", "taut") if name in schema.names), None)
    masks = [found for found in filters if product.axis(found.column) is None]
    names = [*plan.quantities, *([status] if status else []), *(found.column for found in masks), plan.x_column]
    read = product.gather(plan.rows(product), names)
    kept = np.ones(next(iter(read.values())).shape, dtype=np.bool_)
    for found in masks:
        kept &= found.holds(read[found.column])
    curves = tuple(_curves(shown(schema, name, units), read, status, kept) for name in plan.quantities)
    if not any(np.isfinite(found.values).any() for found in curves):
        _raise_empty(plan, filters)
    scale, label, x_values = _along_x(product, plan, read, units)
    return CurveData(
        title_of(product.table),
        scale,
        label,
        x_values,
        curves,
        _texts(product, plan, 1, units),
        plan.colour is not None and not plan.colour.is_text,
        _texts(product, plan, 2, units),
        _texts(product, plan, 0, units),
        (*_fixed(product, plan, units), *plan.notes),
    )


def _curves(quantity: Shown, read: Columns, status: str | None, kept: Truth) -> Curves:
    values = np.where(kept, quantity.scaled(read[quantity.column]), np.nan)
    if status == "status":
        side = next((side for side in _SLACK_OF if quantity.column.startswith(side)), None)
        slack = np.isin(read[status], _SLACK_OF.get(side or "", _ANY_SLACK))
    else:
        slack = np.zeros(values.shape, dtype=np.bool_) if status is None else read[status] == 0.0
    return Curves(quantity, values, slack & np.isfinite(values))


def _along_x(
    product: Product, plan: CurvePlan, read: Columns, units: Mapping[str, str]
) -> tuple[Scale | None, str, Floats]:
    shape = read[plan.x_column].shape
    quantity = None if product.is_text(plan.x_column) else shown(product.table.schema, plan.x_column, units)
    if plan.x_column != plan.x.column and quantity is not None:
        return None, quantity.label, quantity.scaled(read[plan.x_column])
    scale = scale_of(product.values(plan.x, plan.positions[plan.x.column]), quantity, is_log=plan.x.is_log)
    places = np.empty(len(scale.places))
    places[scale.order] = scale.places
    label = scale.label if quantity else plan.x.column
    return scale, label, np.broadcast_to(places, shape)


def _texts(product: Product, plan: CurvePlan, part: int, units: Mapping[str, str]) -> tuple[str, ...]:
    """The values that panels, colours or dashes stand for."""
    axis = plan.parts[part]
    return () if axis is None else tuple(value_texts(product, axis, plan.positions[axis.column], units))


def _fixed(product: Product, plan: CurvePlan, units: Mapping[str, str]) -> list[str]:
    texts = [value_texts(product, axis, plan.positions[axis.column], units)[0] for axis in plan.fixed]
    return [f"At {', '.join(texts)}; --where chooses other values."] if texts else []


def _raise_empty(plan: CurvePlan, filters: Sequence[Filter]) -> None:
    names = ", ".join(plan.quantities)
    if filters:
        texts = " and ".join(f'"{found.text}"' for found in filters)
        raise UsageError(f"nothing is left of {names} by {texts}", where="--where", hint="fewer or wider filters")
    hint = "they have no equilibrium; --where chooses other rows"
    raise UsageError(f"{names}: all null in the rows drawn", hint=hint)
