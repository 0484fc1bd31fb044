"""The route of a sheath in two views, and how its curvature adds up along it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.figures.engine import Axes, Figure, mpl
from tendon_cli.figures.frame import Frame
from tendon_cli.figures.labels import number
from tendon_cli.figures.style import FAINT, INK, PAGE_WIDTH, house_style, save, sequential_map

Floats = npt.NDArray[np.float64]

_MOST_DRAWN = 20_000


@dataclass(frozen=True)
class RouteCurve:
    """A route's way-points and the turns between its chords."""

    points: Floats
    """In mm."""
    at: Floats
    """Arc length at the inner way-points, mm."""
    curvature: Floats
    """Turn over the mean of the two chords beside it, 1/m."""
    turned: Floats
    """Sum of the turns up to there, deg."""
    length: float
    """mm."""


def draw_route(points: npt.ArrayLike, out: Path, *, bend_angle: float | None = None, title: str = "") -> Path:
    """Write the drawing of a route given as way-points of shape (n, 3) in m.

    `bend_angle` in rad is what the model takes for its total curvature, named in the figure. Raises InputError for
    fewer than two different way-points, UsageError for an unknown format, OutputError.
    """
    return save(route_figure(points, bend_angle=bend_angle, title=title), out)


def route_figure(points: npt.ArrayLike, *, bend_angle: float | None = None, title: str = "") -> Figure:
    """Two views to one scale, coloured by curvature, and curvature and turn along the route."""
    curve = route_curve(points)
    notes = [f"{len(curve.points)} way-points over {number(curve.length / 1e3)} m; the views are to one scale."]
    if bend_angle is not None:
        notes.append(f"Total curvature taken by the model: φ = {number(float(np.degrees(bend_angle)))} deg.")
    with house_style():
        figure = Frame(PAGE_WIDTH, title or "Route of the sheath", notes=notes).figure(125.0)
        grid = figure.add_gridspec(2, 2, height_ratios=(1.5, 1.0))
        shown = float(np.quantile(curve.curvature, 0.98)) if len(curve.curvature) else 0.0
        colour = mpl.cm.ScalarMappable(mpl.colors.Normalize(0.0, shown or 1.0), sequential_map())
        views = [figure.add_subplot(grid[0, at]) for at in range(2)]
        for axes, other in zip(views, (1, 2), strict=True):
            _draw_view(axes, curve, other, colour)
        figure.colorbar(colour, ax=views, pad=0.02, aspect=20, extend="max").set_label("curvature κ (1/m)")
        _draw_along(figure.add_subplot(grid[1, :]), curve)
    return figure


def route_curve(points: npt.ArrayLike) -> RouteCurve:
    """Arc length, curvature and turn along way-points in m; raises InputError for fewer than two different ones."""
    route = np.asarray(points, dtype=np.float64)
    if route.ndim != 2 or route.shape[1] != 3 or not np.isfinite(route).all():
        raise InputError("a route is a list of finite points x, y, z")
    steps = np.linalg.norm(np.diff(route, axis=0), axis=1)
    route = route[np.append(True, steps > 0.0)]
    steps = steps[steps > 0.0]
    if not len(steps):
        raise InputError("holds fewer than two different way-points")
    chords = np.diff(route, axis=0)
    across = np.linalg.norm(np.cross(chords[:-1], chords[1:]), axis=1)
    turns = np.arctan2(across, np.sum(chords[:-1] * chords[1:], axis=1))
    spans = (steps[:-1] + steps[1:]) / 2.0
    at = np.cumsum(steps)[:-1]
    return RouteCurve(1e3 * route, 1e3 * at, turns / spans, np.degrees(np.cumsum(turns)), 1e3 * float(steps.sum()))


def _draw_view(axes: Axes, curve: RouteCurve, other: int, colour: Any) -> None:
    """The route seen along one axis: x against another."""
    every = max(1, len(curve.points) // _MOST_DRAWN)
    across, along = curve.points[::every, 0], curve.points[::every, other]
    axes.plot(across, along, color=FAINT, linewidth=0.8, zorder=1, gid="route")
    inner = curve.points[1:-1:every]
    axes.scatter(inner[:, 0], inner[:, other], c=curve.curvature[::every], s=6.0, cmap=colour.cmap, norm=colour.norm,
                 linewidths=0.0, zorder=2, rasterized=len(inner) > 2000)  # fmt: skip
    for at, text in ((0, "first"), (-1, "last")):
        end = (curve.points[at, 0], curve.points[at, other])
        axes.plot(*end, marker="o" if at == 0 else "s", markersize=4.5, color="white", markeredgecolor=INK, zorder=3)
        axes.annotate(text, end, xytext=(4, 4), textcoords="offset points", size=6.5)
    axes.set(xlabel="x (mm)", ylabel=f"{'xyz'[other]} (mm)", aspect="equal")
    axes.set_title(("seen along z", "seen along y")[other - 1])
    low, high = curve.points.min(axis=0), curve.points.max(axis=0)
    middle, reach = (low + high) / 2.0, 0.6 * (high - low)
    # Both views take the same stretch, so that they are to one scale; a flat route keeps some height.
    tall = max(reach[1], reach[2], 0.35 * reach.max())
    wide = max(reach[0], 0.35 * reach.max())
    axes.set(xlim=(middle[0] - wide, middle[0] + wide), ylim=(middle[other] - tall, middle[other] + tall))


def _draw_along(axes: Axes, curve: RouteCurve) -> None:
    """Curvature as columns, and the turn so far as a line, along the route."""
    axes.plot(curve.at, curve.curvature, color=INK, linewidth=0.8, drawstyle="steps-mid", gid="curvature")
    axes.fill_between(curve.at, curve.curvature, color="#e4e4e4", step="mid", linewidth=0.0)
    axes.set(xlabel="distance along the route (mm)", ylabel="curvature κ (1/m)", xlim=(0.0, curve.length))
    axes.set_ylim(0.0, 1.1 * curve.curvature.max(initial=0.0) or 1.0)
    turn = axes.twinx()
    turn.plot(curve.at, curve.turned, color="#d55e00", gid="turned")
    turn.set_ylabel("turned so far, ∫κ ds (deg)", color="#d55e00")
    turn.tick_params(colors="#d55e00")
    turn.set_ylim(0.0, 1.1 * curve.turned.max(initial=0.0) or 1.0)
