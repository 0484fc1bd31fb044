"""`tendon plot`: figures from any one table of a run, by default the right one."""

from __future__ import annotations

import re
from pathlib import Path

from tendon_cli.errors import UsageError
from tendon_cli.figures.curve_data import curve_data
from tendon_cli.figures.curve_plan import plan_curves
from tendon_cli.figures.curves import draw_curves
from tendon_cli.figures.engine import Figure
from tendon_cli.figures.map_data import title_of
from tendon_cli.figures.product import Product, product_of
from tendon_cli.figures.request import PlotRequest, read_size, read_units
from tendon_cli.figures.slack_map import MapStyle, slack_map_figures
from tendon_cli.figures.style import FORMATS, check_format, house_style, save
from tendon_cli.figures.where import choose, read_filter
from tendon_cli.tables.read import TableFiles


def plot(table: TableFiles, request: PlotRequest, out: Path | None = None) -> list[Path]:
    """Draw a table and write the figures; returns them, page by page.

    `out` is a file (its ending gives the format), or a folder; by default the working directory. Further pages get
    -2, -3 before the ending. Raises UsageError, InputError for a table of another kind, OutputError.
    """
    target = _target(table, request, out)
    figures = plot_figures(product_of(table), request)
    paths = [target, *(target.with_stem(f"{target.stem}-{page}") for page in range(2, len(figures) + 1))]
    return [save(figure, path, must_fit=True) for figure, path in zip(figures, paths, strict=True)]


def plot_figures(product: Product, request: PlotRequest) -> list[Figure]:
    """The pages of a figure: of designs slack maps, unless something else is asked for; of states curves."""
    units, (width, height) = read_units(request.units), read_size(request.size)
    filters = [read_filter(text, product) for text in request.where]
    chosen = choose(product, filters)
    on_axes = all(product.axis(found.column) for found in filters)
    if product.table.facts["table"] == "designs" and request.is_plain and on_axes:
        pages = slack_map_figures(product, chosen, MapStyle(width, height, units))
        if not isinstance(pages, str):
            return pages
    plan = plan_curves(product, chosen, request)
    data = curve_data(product, plan, filters, units)
    with house_style():
        return draw_curves(data, width, height)


def _target(table: TableFiles, request: PlotRequest, out: Path | None) -> Path:
    """The first file to write."""
    kind = check_format(request.format)
    if out is not None and not out.is_dir():
        if out.suffix[1:].lower() not in FORMATS:
            raise UsageError(f'"{out.name}" has no ending of a figure', where="--out", hint=".png, .svg or .pdf")
        return out
    try:
        named = title_of(table) and table.facts["study"]["study"]["name"]
        content = table.facts["table"]
    except (KeyError, TypeError):
        named, content = "", "figure"
    stem = "-".join(filter(None, (re.sub(r"[^\w.-]+", "_", str(named)), content, *request.quantities[:3])))
    return (out or Path()) / f"{stem}.{kind}"
