"""Slack maps: which designs keep both tendons taut, and how much pretension they have in hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tendon_cli.figures.engine import Figure
from tendon_cli.figures.map_data import map_data
from tendon_cli.figures.map_page import draw_page
from tendon_cli.figures.map_plan import PANELS_PER_PAGE, plan_maps
from tendon_cli.figures.margin_lines import draw_lines
from tendon_cli.figures.product import Ints, Product, product_of
from tendon_cli.figures.style import PAGE_WIDTH, house_style, save
from tendon_cli.tables.read import TableFiles


@dataclass(frozen=True)
class SlackMaps:
    """The slack maps of a run."""

    files: tuple[Path, ...] = ()
    """The figures written, page by page."""
    reason: str | None = None
    """Why there is none."""


@dataclass(frozen=True)
class MapStyle:
    """What may be chosen about a slack map."""

    width: float = PAGE_WIDTH
    """In mm."""
    height: float | None = None
    """In mm; None where it follows from the panels."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Unit to show, by dimension."""


def draw_slack_maps(designs: TableFiles, out: Path) -> SlackMaps:
    """Write slack_map.png, and slack_map-2.png and so on where the panels need more pages, into the folder `out`.

    x and y are the first two axes, other than the load, with more than one value; panels are for the load and for what
    else varies. Only the rows that are drawn are kept in memory. Raises InputError for a table of another kind,
    OutputError where a figure cannot be written.
    """
    figures = slack_map_figures(product_of(designs))
    if isinstance(figures, str):
        return SlackMaps(reason=figures)
    names = ["slack_map.png", *(f"slack_map-{page}.png" for page in range(2, len(figures) + 1))]
    return SlackMaps(tuple(save(figure, out / name) for figure, name in zip(figures, names, strict=True)))


def slack_map_figures(
    product: Product, chosen: Mapping[str, Ints] | None = None, style: MapStyle | None = None
) -> list[Figure] | str:
    """The pages of a slack map, or why there is none; `chosen` are the positions on each axis to draw from."""
    style = style or MapStyle()
    plan = plan_maps(product, product.positions() if chosen is None else chosen)
    if isinstance(plan, str):
        return plan
    data = map_data(product, plan, style.units)
    if not any(np.isfinite(panel.margin).any() for panel in data.panels):
        return "no design has a margin, each has elbow angles without equilibrium"
    with house_style():
        if data.y is None:
            return [draw_lines(data, style.width, style.height)]
        pages = [data.panels[at : at + PANELS_PER_PAGE] for at in range(0, len(data.panels), PANELS_PER_PAGE)]
        names = [f"{data.title} (page {page} of {len(pages)})" for page in range(1, len(pages) + 1)]
        return [
            draw_page(data, panels, name if len(pages) > 1 else data.title, style.width, style.height)
            for panels, name in zip(pages, names, strict=True)
        ]
