"""The geometry of a study file as figures.

They show the arm, and each route in three views with how its curvature adds up.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.labels import number
from tendon_cli.errors import InputError
from tendon_cli.figures.arm import arm_page
from tendon_cli.figures.backend import Axes, mpl
from tendon_cli.figures.frame import Page, framed, save_pages, source_of_study
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, SEQUENTIAL, house_style, key_line
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import SIDES
from tendon_cli.studies.load import load_study, named_path
from tendon_cli.studies.space.axis import CASE_AXIS
from tendon_cli.studies.spaces import row_place
from tendon_cli.studies.study import Study
from tendon_cli.studies.way_points import MAX_BYTES, read_route, smooth

_END: dict[str, Any] = {
    "markersize": 4.5,
    "color": "white",
    "markeredgecolor": INK,
    "linestyle": "",
}
_ENDS: tuple[dict[str, Any], ...] = (
    {**_END, "marker": "o", "label": "first way-point"},
    {**_END, "marker": "s", "label": "last way-point"},
)
"""Style of the ends of a route."""
_VIEWS = ((0, 1, "seen along z"), (0, 2, "seen along y"), (1, 2, "seen along x"))


@dataclass(frozen=True)
class RouteCurve:
    """A route's points and the turns between its chords."""

    points: Array
    """Points of the route (points, 3), mm."""
    at: Array
    """Arc length at the inner points, mm."""
    curvature: Array
    """Turn over the mean of its two chords, 1/m."""
    turned: Array
    """Sum of the turns up to each inner point and at it, deg."""
    length: float
    """Length of the route, mm."""


def route_page(
    measured: npt.ArrayLike,
    route: npt.ArrayLike,
    title: str,
    notes: tuple[str, ...] = (),
    study: str = "",
) -> Page:
    """Draw three views of a route to one scale, coloured by curvature.

    Below them are curvature and turn along the route.

    Args:
        measured: Way-points (points, 3), m.
        route: The route that the model takes for them, themselves or smoothed (points, 3), m.
        title: Title of the page.
        notes: Sentences below the panels.
        study: Name and hash of the study for the file's metadata.

    Raises:
        InputError: The route has fewer than two different points.
    """
    curve = route_curve(route)
    marks = 1e3 * np.asarray(measured, dtype=np.float64)
    metres = number(curve.length / 1e3)
    count = f"{len(marks)} way-points over {metres} m; the views are to one scale."
    with house_style():
        key = [key_line(**style) for style in _ENDS]
        page = framed(title, 118.0, key, (count, *notes), study=study)
        grid = page.figure.add_gridspec(2, 3, height_ratios=(1.2, 1.0))
        # A few sharp turns do not set the scale of colours.
        most = float(np.quantile(curve.curvature, 0.98)) if len(curve.curvature) else 0.0
        colour = mpl.cm.ScalarMappable(mpl.colors.Normalize(0.0, most or 1.0), SEQUENTIAL)
        views = [page.figure.add_subplot(grid[0, column]) for column in range(len(_VIEWS))]
        for axes, (across, up, name) in zip(views, _VIEWS, strict=True):
            _draw_view(axes, curve, marks, (across, up), colour)
            axes.set_title(name)
        bar = page.figure.colorbar(colour, ax=views, pad=0.02, aspect=20, extend="max")
        bar.set_label("curvature κ (1/m)")
        _draw_along(page.figure.add_subplot(grid[1, :]), curve)
    return page


def route_curve(points: npt.ArrayLike) -> RouteCurve:
    """Return arc length, curvature and turn along a route.

    Args:
        points: Points of the route (points, 3), m.

    Raises:
        InputError: There are fewer than two different points.
    """
    route = np.asarray(points, dtype=np.float64)
    if route.ndim != 2 or route.shape[1] != 3 or not np.isfinite(route).all():
        raise InputError("a route is a list of finite points x, y, z")
    steps = np.linalg.norm(np.diff(route, axis=0), axis=1)
    is_moved = steps > 0.0
    route = route[np.append(True, is_moved)]
    steps = steps[is_moved]
    if not len(steps):
        raise InputError("the route has fewer than two different way-points")
    chords = np.diff(route, axis=0)
    across = np.linalg.norm(np.cross(chords[:-1], chords[1:]), axis=1)
    turns = np.arctan2(across, np.sum(chords[:-1] * chords[1:], axis=1))
    spans = (steps[:-1] + steps[1:]) / 2.0
    return RouteCurve(
        points=1e3 * route,
        at=1e3 * np.cumsum(steps)[:-1],
        curvature=turns / spans,
        turned=np.degrees(np.cumsum(turns)),
        length=1e3 * float(steps.sum()),
    )


def _draw_view(
    axes: Axes, curve: RouteCurve, marks: Array, plane: tuple[int, int], colour: Any
) -> None:
    """Draw the route seen along one axis, with its way-points.

    Args:
        axes: The panel.
        curve: The route.
        marks: Way-points (points, 3), mm.
        plane: Axis that points across and axis that points up: 0 for x, 1 for y, 2 for z.
        colour: Colours of curvature.
    """
    across, up = plane
    route = curve.points
    axes.plot(route[:, across], route[:, up], color=FAINT, linewidth=0.8, zorder=1, gid="route")
    axes.plot(
        marks[:, across],
        marks[:, up],
        zorder=1.5,
        gid="way-points",
        color=FAINT,
        marker="+",
        markersize=3.0,
        markeredgewidth=0.5,
        linestyle="none",
    )
    inner = route[1:-1]
    axes.scatter(
        inner[:, across],
        inner[:, up],
        c=curve.curvature,
        s=5.0,
        cmap=colour.cmap,
        norm=colour.norm,
        linewidths=0.0,
        zorder=2,
        rasterized=len(inner) > 2000,
    )
    for end, style in zip(route[[0, -1]], _ENDS, strict=True):
        axes.plot(end[across], end[up], zorder=3, **style)
    axes.set(xlabel=f"{'xyz'[across]} (mm)", ylabel=f"{'xyz'[up]} (mm)", aspect="equal")
    low = route.min(axis=0)
    high = route.max(axis=0)
    middle = (low + high) / 2.0
    # All views show a stretch of the same length, so that they are to one scale.
    reach = 0.63 * float((high - low).max())
    axes.set_xlim(middle[across] - reach, middle[across] + reach)
    axes.set_ylim(middle[up] - reach, middle[up] + reach)


def _draw_along(axes: Axes, curve: RouteCurve) -> None:
    """Draw curvature as columns, and the turn so far as a line, along the route."""
    axes.plot(
        curve.at, curve.curvature, color=INK, gid="curvature", linewidth=0.8, drawstyle="steps-mid"
    )
    axes.fill_between(curve.at, curve.curvature, color="#e4e4e4", step="mid", linewidth=0.0)
    axes.set_xlabel("distance along the route (mm)")
    axes.set_ylabel("curvature κ (1/m)")
    axes.set_xlim(0.0, curve.length)
    axes.set_ylim(0.0, 1.1 * curve.curvature.max(initial=0.0) or 1.0)
    turn = axes.twinx()
    turn.plot(curve.at, curve.turned, color=OKABE_ITO[1], gid="turned")
    turn.set_ylabel("turned so far, ∫κ ds (deg)", color=OKABE_ITO[1])
    turn.tick_params(colors=OKABE_ITO[1])
    turn.set_ylim(0.0, 1.1 * curve.turned.max(initial=0.0) or 1.0)


def draw_geometry(
    file: Path,
    settings: tuple[str, ...] = (),
    angles: Sequence[float] = (),
    out: Path | None = None,
    case: str | None = None,
    *,
    overwrite: bool = False,
) -> list[Path]:
    """Draw the arm of a study file, and the routes of its sheaths, each into a file.

    Routes are drawn as the model takes them, smoothed if the study says so. Their files are next to
    that of the arm.

    Args:
        file: The study file.
        settings: Settings "key=value" that override the file.
        angles: Elbow angles, rad; by default some of the study's.
        out: File of the arm; by default in the working directory.
        case: Name of one of the study's cases, whose arm and sheaths are drawn.
        overwrite: True to replace files that tendon did not write.

    Returns:
        The files.

    Raises:
        StudyError: The study has faults.
        InputError: A file is damaged or missing.
        UsageError: The study does not have this case, the ending is not that of a figure, or
            tendon did not write a file.
        OutputError: A file cannot be written.
    """
    study = load_study(file, settings)
    target = out or Path(f"{study.name}-arm.png")
    pages = [(arm_page(study, angles, case), target)]
    for name, page in _routes(study, file, settings, case):
        pages.append((page, target.with_stem(f"{target.stem}-{name}")))
    return save_pages(pages, overwrite=overwrite)


def _routes(
    study: Study, file: Path, settings: tuple[str, ...], case: str | None
) -> Iterator[tuple[str, Page]]:
    """Yield the page of each route, after the ending of its name: "route", "route-flexor"."""
    case_prefix = "" if case is None else f"cases.{row_place(study, CASE_AXIS, case, '--case')}."
    for side in ("", *SIDES):
        key = f"sheath.{side}.path" if side else "sheath.path"
        if f"{case_prefix}{key}" in study.sources:
            key = f"{case_prefix}{key}"
        if key not in study.sources:
            continue
        source = study.sources[key]
        path = named_path(file, settings, key)
        with path.open("rb") as opened:
            points = read_route(opened.read(MAX_BYTES), path.name).points
        noise = float(source.get("path_smoothing") or 0.0)
        smoothed = f", smoothed for a noise of {number(1e3 * noise)} mm" if noise else ""
        angle = number(math.degrees(source["bend_angle"]))
        total = f"Total curvature taken by the model: φ = {angle} deg{smoothed}."
        notes = (total, *source.get("warnings", ()))
        sheath = f"{side} sheath" if side else "sheath"
        title = f"Route of the {sheath}: {source['file']}"
        about = source_of_study(study)
        page = route_page(points, smooth(points, noise), title, notes, about)
        yield f"route-{side}" if side else "route", page
