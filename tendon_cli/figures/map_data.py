"""What a slack map shows, read from the table of designs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.figures.labels import Shown, shown
from tendon_cli.figures.map_panel import Floats
from tendon_cli.figures.map_plan import LOAD, MapPlan
from tendon_cli.figures.product import Axis, Ints, Product
from tendon_cli.figures.scales import Scale, scale_of
from tendon_cli.figures.style import plain
from tendon_cli.tables.read import TableFiles

_LONGEST_NAME = 40


@dataclass(frozen=True)
class Panel:
    """What one panel shows."""

    title: str
    margin: Floats
    """In the unit shown, of shape (y, x) in the order of the scales; without y, (x,)."""


@dataclass(frozen=True)
class MapData:
    """Everything that the pages of a slack map show."""

    title: str
    x: Scale
    y: Scale | None
    margin: Shown
    panels: tuple[Panel, ...]
    in_row: int
    """How many neighbouring panels differ in one axis only, the load if there is one."""
    notes: tuple[str, ...]


def map_data(product: Product, plan: MapPlan, units: Mapping[str, str]) -> MapData:
    """Read what the panels show, and nothing else; raises InputError where the table lacks it."""
    schema = product.table.schema
    if not {"margin", LOAD} <= set(schema.names):
        raise InputError("has no column margin", where=str(product.table.files[0]))
    margin = shown(schema, "margin", units)
    x = _scale(product, plan.x, plan, units)
    y = _scale(product, plan.y, plan, units) if plan.y else None
    read = product.gather(np.stack([plan.rows(product, panel) for panel in plan.panels]), ("margin", LOAD))
    ordered = margin.scaled(read["margin"])[..., x.order]
    if y is not None:
        ordered = ordered[:, y.order]
    titles = _titles(product, plan, units)
    if LOAD not in {axis.column for axis in plan.titled}:
        load = shown(schema, LOAD, units)
        loads = [_common_load(values, load) for values in read[LOAD]]
        titles = [", ".join(filter(None, texts)) for texts in zip(loads, titles, strict=True)]
    panels = tuple(Panel(title, values) for title, values in zip(titles, ordered, strict=True))
    in_row = len({panel[plan.titled[0].column] for panel in plan.panels}) if plan.titled else 1
    notes = (*_common(product, plan, units), *plan.notes)
    return MapData(title_of(product.table), x, y, margin, panels, in_row, notes)


def title_of(table: TableFiles) -> str:
    """What a study is called: its title, or its name."""
    study = table.facts["study"]["study"]
    return str(study.get("title") or study.get("name") or "")


def value_texts(product: Product, axis: Axis, at: Ints, units: Mapping[str, str]) -> list[str]:
    """The values at some positions of an axis, as a title or a key names them."""
    values = product.values(axis, at)
    if axis.is_text:
        # A legend leaves out what starts with an underscore.
        texts = [plain(str(value), width=_LONGEST_NAME, lines=1) for value in values]
        return [f" {text}" if text.startswith("_") else text for text in texts]
    quantity = shown(product.table.schema, axis.column, units)
    return [f"{quantity.text(value)} load" if axis.column == LOAD else quantity.equation(value) for value in values]


def _common_load(loads: Floats, quantity: Shown) -> str:
    """The load of a panel that has one."""
    different = np.unique(loads)
    return f"{quantity.text(float(different[0]))} load" if len(different) == 1 and np.isfinite(different[0]) else ""


def _scale(product: Product, axis: Axis, plan: MapPlan, units: Mapping[str, str]) -> Scale:
    values = product.values(axis, plan.positions[axis.column])
    quantity = None if axis.is_text else shown(product.table.schema, axis.column, units)
    return scale_of(values, quantity, is_log=axis.is_log)


def _titles(product: Product, plan: MapPlan, units: Mapping[str, str]) -> list[str]:
    """The values that each panel has on the axes in which the panels differ."""
    texts: dict[str, dict[int, str]] = {}
    for axis in plan.titled:
        at = np.unique([panel[axis.column] for panel in plan.panels])
        texts[axis.column] = dict(zip(at.tolist(), value_texts(product, axis, at, units), strict=True))
    return [", ".join(texts[axis.column][panel[axis.column]] for axis in plan.titled) for panel in plan.panels]


def _common(product: Product, plan: MapPlan, units: Mapping[str, str]) -> list[str]:
    """The values of which only one was chosen."""
    texts = [value_texts(product, axis, np.array([plan.panels[0][axis.column]]), units)[0] for axis in plan.common]
    return [f"All panels at {', '.join(texts)}."] if texts else []
