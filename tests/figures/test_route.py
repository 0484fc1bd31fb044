"""A route's drawing shows its curvature."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tendon_cli.errors import InputError
from tendon_cli.figures.geometry import route_curve, route_page
from tests.figures.runs import lines, words


def helix(points: int) -> np.ndarray:
    """Return points on a turn of a helix of radius 0.1 m that rises by 0.03 m a radian."""
    turn = np.linspace(0.0, 2.0 * np.pi, points)
    return np.stack((0.1 * np.cos(turn), 0.1 * np.sin(turn), 0.03 * turn), axis=1)


def test_curvature_of_a_helix() -> None:
    curve = route_curve(helix(200))
    speed = np.hypot(0.1, 0.03)  # length of the helix per radian, m
    np.testing.assert_allclose(curve.curvature, 0.1 / (0.1**2 + 0.03**2), rtol=1e-3)
    assert curve.length == pytest.approx(1e3 * 2.0 * np.pi * speed, rel=1e-3)
    assert np.radians(curve.turned[-1]) == pytest.approx(2.0 * np.pi * 0.1 / speed, rel=0.01)


def test_three_views_to_one_scale_and_what_adds_up() -> None:
    way_points = helix(50)
    route = helix(500)
    figure = route_page(way_points, route, "arm.csv").figure
    views = [axes for axes in figure.axes if axes.get_title().startswith("seen")]
    labels = [(axes.get_xlabel()[0], axes.get_ylabel()[0]) for axes in views]
    assert labels == [("x", "y"), ("x", "z"), ("y", "z")]
    limits = [axes.get_xlim() for axes in views] + [axes.get_ylim() for axes in views]
    assert len({round(np.ptp(ends), 9) for ends in limits}) == 1
    for axes, plane in zip(views, ((0, 1), (0, 2), (1, 2)), strict=True):
        for gid, points in (("route", route), ("way-points", way_points)):
            (line,) = lines(axes, gid)
            np.testing.assert_allclose(np.transpose(line.get_data()), 1e3 * points[:, plane])
    assert all(axes.get_aspect() == 1.0 for axes in views)
    assert "50 way-points" in words(figure)


def test_straight_repeated_and_impossible_routes(tmp_path: Path) -> None:
    straight = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 0.0, 0.0]])
    file = route_page(straight, straight, "").save(tmp_path / "route.png")
    assert file.stat().st_size > 1000
    assert list(route_curve(straight).curvature) == [0.0]
    route_page(straight[:2], straight[:2], "").save(tmp_path / "two.pdf")
    impossible = [
        [[0.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.0]] * 3,
        [[0.0, 1.0]],
        [[0.0, np.nan, 0.0], [1.0, 0.0, 0.0]],
    ]
    for wrong in impossible:
        with pytest.raises(InputError):
            route_page(wrong, wrong, "")
