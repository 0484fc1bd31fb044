"""The geometry of a study file as figures: the arm, and each route in three views with how its curvature adds up."""

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
from tendon_cli.figures.frame import Page, framed
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, SEQUENTIAL, house_style
from tendon_cli.space.axis import SIDES
from tendon_cli.studies.load import load_study
from tendon_cli.studies.spaces import case_place
from tendon_cli.studies.study import Study
from tendon_cli.studies.study_file import read_document
from tendon_cli.studies.way_points import MAX_BYTES, read_route, smooth

Floats = npt.NDArray[np.float64]

_VIEWS = ((0, 1, "seen along z"), (0, 2, "seen along y"), (1, 2, "seen along x"))


@dataclass(frozen=True)
class RouteCurve:
    """A route's points and the turns between its chords."""

    points: Floats
    """In mm."""
    at: Floats
    """Arc length at the inner points, mm."""
    curvature: Floats
    """Turn over the mean of its two chords, 1/m."""
    turned: Floats
    """Sum of the turns up to there, deg."""
    length: float
    """mm."""


def route_page(
    measured: npt.ArrayLike,
    route: npt.ArrayLike,
    title: str,
    notes: tuple[str, ...] = (),
    study: str = "",
) -> Page:
    """Three views to one scale, coloured by curvature, and curvature and turn along the route.

    `measured` are the way-points, `route` what the model takes for them: themselves, or smoothed; both of shape (n, 3)
    in m. Raises InputError for fewer than two different points.
    """
    curve, marks = route_curve(route), 1e3 * np.asarray(measured, dtype=np.float64)
    count = (
        f"{len(marks)} way-points over {number(curve.length / 1e3)} m; the views are to one scale."
    )
    with house_style():
        page = framed(title, 118.0, notes=(count, *notes), study=study)
        grid = page.figure.add_gridspec(2, 3, height_ratios=(1.2, 1.0))
        shown = float(np.quantile(curve.curvature, 0.98)) if len(curve.curvature) else 0.0
        colour = mpl.cm.ScalarMappable(mpl.colors.Normalize(0.0, shown or 1.0), SEQUENTIAL)
        views = [page.figure.add_subplot(grid[0, at]) for at in range(3)]
        for axes, (across, up, name) in zip(views, _VIEWS, strict=True):
            _draw_view(axes, curve, marks, (across, up), colour)
            axes.set_title(name)
        page.figure.colorbar(colour, ax=views, pad=0.02, aspect=20, extend="max").set_label(
            "curvature κ (1/m)"
        )
        _draw_along(page.figure.add_subplot(grid[1, :]), curve)
    return page


def route_curve(points: npt.ArrayLike) -> RouteCurve:
    """Arc length, curvature and turn along points in m; raises InputError for fewer than two different ones."""
    route = np.asarray(points, dtype=np.float64)
    if route.ndim != 2 or route.shape[1] != 3 or not np.isfinite(route).all():
        raise InputError("a route is a list of finite points x, y, z")
    steps = np.linalg.norm(np.diff(route, axis=0), axis=1)
    route, steps = route[np.append(True, steps > 0.0)], steps[steps > 0.0]
    if not len(steps):
        raise InputError("holds fewer than two different way-points")
    chords = np.diff(route, axis=0)
    across = np.linalg.norm(np.cross(chords[:-1], chords[1:]), axis=1)
    turns = np.arctan2(across, np.sum(chords[:-1] * chords[1:], axis=1))
    spans = (steps[:-1] + steps[1:]) / 2.0
    at = np.cumsum(steps)[:-1]
    return RouteCurve(
        1e3 * route, 1e3 * at, turns / spans, np.degrees(np.cumsum(turns)), 1e3 * float(steps.sum())
    )


def _draw_view(
    axes: Axes, curve: RouteCurve, marks: Floats, plane: tuple[int, int], colour: Any
) -> None:
    """The route seen along one axis, with its way-points."""
    axes.plot(*curve.points[:, plane].T, color=FAINT, linewidth=0.8, zorder=1, gid="route")
    axes.plot(
        *marks[:, plane].T,
        color=FAINT,
        marker="+",
        markersize=3.0,
        markeredgewidth=0.5,
        linestyle="none",
        zorder=1.5,
        gid="way-points",
    )
    inner = curve.points[1:-1]
    axes.scatter(
        inner[:, plane[0]],
        inner[:, plane[1]],
        c=curve.curvature,
        s=5.0,
        cmap=colour.cmap,
        norm=colour.norm,
        linewidths=0.0,
        zorder=2,
        rasterized=len(inner) > 2000,
    )
    for at, text in ((0, "first"), (-1, "last")):
        end = tuple(curve.points[at, list(plane)])
        axes.plot(
            *end,
            marker="o" if at == 0 else "s",
            markersize=4.5,
            color="white",
            markeredgecolor=INK,
            zorder=3,
        )
        axes.annotate(text, end, xytext=(4, 4), textcoords="offset points", size=6.5)
    axes.set(xlabel=f"{'xyz'[plane[0]]} (mm)", ylabel=f"{'xyz'[plane[1]]} (mm)", aspect="equal")
    low, high = curve.points.min(axis=0), curve.points.max(axis=0)
    # All views take a stretch of the same length, so that they are to one scale.
    reach = 0.6 * float((high - low).max())
    limits = [(middle - reach, middle + reach) for middle in ((low + high) / 2.0)[list(plane)]]
    axes.set(xlim=limits[0], ylim=limits[1])


def _draw_along(axes: Axes, curve: RouteCurve) -> None:
    """Curvature as columns, and the turn so far as a line, along the route."""
    axes.plot(
        curve.at, curve.curvature, color=INK, linewidth=0.8, drawstyle="steps-mid", gid="curvature"
    )
    axes.fill_between(curve.at, curve.curvature, color="#e4e4e4", step="mid", linewidth=0.0)
    axes.set(
        xlabel="distance along the route (mm)", ylabel="curvature κ (1/m)", xlim=(0.0, curve.length)
    )
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
) -> list[Path]:
    """Draw the arm of a study file at some elbow angles in rad, and the routes of its sheaths next to it.

    `case` takes the arm and the sheaths of one of its cases. Routes are drawn as the model takes them, smoothed alike.
    Returns the files. Raises StudyError, InputError, UsageError for an unknown case or format, OutputError.
    """
    study = load_study(file, settings)
    target = out or Path(f"{study.name}-arm.png")
    drawn = [arm_page(study, angles, case).save(target)]
    for name, page in _routes(study, file, settings, case):
        drawn.append(page.save(target.with_stem(f"{target.stem}-{name}")))
    return drawn


def _routes(
    study: Study, file: Path, settings: tuple[str, ...], case: str | None
) -> Iterator[tuple[str, Page]]:
    """The route of both sheaths, or of either side, each with the end of its file's name."""
    of_case = "" if case is None else f"cases.{case_place(study, case)}."
    for side in ("", *SIDES):
        key = ".".join(filter(None, ("sheath", side, "path")))
        key = f"{of_case}{key}" if f"{of_case}{key}" in study.sources else key
        if key not in study.sources:
            continue
        source, name = study.sources[key], _given(file, settings, key)
        with (file.parent / name).open("rb") as opened:
            points = read_route(opened.read(MAX_BYTES), name)
        noise = float(source.get("path_smoothing") or 0.0)
        smoothed = f", smoothed for a noise of {number(1e3 * noise)} mm" if noise else ""
        angle = number(math.degrees(source["bend_angle"]))
        notes = (
            f"Total curvature taken by the model: φ = {angle} deg{smoothed}.",
            *source.get("warnings", ()),
        )
        title = f"Route of the {side and side + ' '}sheath: {source['file']}"
        page = route_page(
            points, smooth(points, noise), title, notes, f"tendon study {study.name} {study.hash}"
        )
        yield f"route{side and '-'}{side}", page


def _given(file: Path, settings: tuple[str, ...], key: str) -> str:
    """The path that a setting, or else the study file, gives a key."""
    given = [
        text.strip().strip("\"'")
        for name, _, text in (each.partition("=") for each in settings)
        if name.strip() == key
    ]
    value: Any = read_document(file).content
    for part in () if given else key.split("."):
        value = value[int(part) if isinstance(value, list) else part]
    return str(given[-1] if given else value)
