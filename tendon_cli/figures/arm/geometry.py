"""The geometry of a study file as figures: the arm, and the route of each sheath that it names."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from tendon_cli.cube.labels import number
from tendon_cli.figures.arm.draw import arm_page
from tendon_cli.figures.arm.route import route_page
from tendon_cli.figures.arm.shape import chosen_case
from tendon_cli.figures.frame import Page
from tendon_cli.space.axis import SIDES
from tendon_cli.studies.load import load_study
from tendon_cli.studies.reading import read_document
from tendon_cli.studies.route import MAX_BYTES, read_route, smooth
from tendon_cli.studies.study import Study


def draw_geometry(
    file: Path, settings: tuple[str, ...] = (), angles: Sequence[float] = (), out: Path | None = None,
    case: str | None = None,
) -> list[Path]:  # fmt: skip
    """Draw the arm of a study file at some elbow angles in rad, and the routes of its sheaths beside it.

    `case` takes the arm and the sheaths of one of its cases. Routes are drawn as the model takes them, smoothed alike.
    Returns the files. Raises StudyError, InputError, UsageError for an unknown case or format, OutputError.
    """
    study = load_study(file, settings)
    target = out or Path(f"{study.name}-arm.png")
    drawn = [arm_page(study, angles, case).save(target, must_fit=False)]
    for name, page in _routes(study, file, settings, case):
        drawn.append(page.save(target.with_stem(f"{target.stem}-{name}"), must_fit=False))
    return drawn


def _routes(study: Study, file: Path, settings: tuple[str, ...], case: str | None) -> Iterator[tuple[str, Page]]:
    """The route of both sheaths, or of either side, each with the end of its file's name."""
    chosen = chosen_case(study, case)
    of_case = f"cases.{study.cases.index(chosen)}." if chosen is not None else None
    for side in ("", *SIDES):
        key = ".".join(filter(None, ("sheath", side, "path")))
        key = f"{of_case}{key}" if of_case and f"{of_case}{key}" in study.sources else key
        if key in study.sources:
            yield f"route{side and '-'}{side}", _route(study, file, settings, key, side)


def _route(study: Study, file: Path, settings: tuple[str, ...], key: str, side: str) -> Page:
    source = study.sources[key]
    name = _said(file, settings, key)
    with (file.parent / name).open("rb") as opened:
        points = read_route(opened.read(MAX_BYTES), name)
    noise = float(source.get("path_smoothing") or 0.0)
    angle = number(math.degrees(source["bend_angle"]))
    smoothed = f", smoothed for a noise of {number(1e3 * noise)} mm" if noise else ""
    notes = (f"Total curvature taken by the model: φ = {angle} deg{smoothed}.", *source.get("warnings", ()))
    title = f"Route of the {side and side + ' '}sheath: {source['file']}"
    return route_page(points, smooth(points, noise), title, notes, f"tendon study {study.name} {study.hash}")


def _said(file: Path, settings: tuple[str, ...], key: str) -> str:
    """The path that a setting, or else the study file, gives a key."""
    given = [
        text.strip().strip("\"'") for name, _, text in (each.partition("=") for each in settings) if name.strip() == key
    ]
    said: Any = read_document(file).content
    for part in () if given else key.split("."):
        said = said[int(part) if isinstance(said, list) else part]
    return str(given[-1] if given else said)
