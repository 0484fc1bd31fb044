"""A route's drawing shows its curvature."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Text

from tendon_cli.errors import InputError
from tendon_cli.figures.geometry import route_curve, route_page


def helix(points: int) -> np.ndarray:
    turn = np.linspace(0.0, 2.0 * np.pi, points)
    return np.stack((0.1 * np.cos(turn), 0.1 * np.sin(turn), 0.03 * turn), axis=1)


def test_curvature_of_a_helix() -> None:
    curve = route_curve(helix(200))
    np.testing.assert_allclose(curve.curvature, 0.1 / (0.1**2 + 0.03**2), rtol=1e-3)
    assert curve.length == pytest.approx(1e3 * 2.0 * np.pi * np.hypot(0.1, 0.03), rel=1e-3)
    assert np.radians(curve.turned[-1]) == pytest.approx(
        2.0 * np.pi * 0.1 / np.hypot(0.1, 0.03), rel=0.01
    )


def test_three_views_to_one_scale_and_what_adds_up() -> None:
    figure = route_page(helix(50), helix(500), "arm.csv").figure
    views = [axes for axes in figure.axes if axes.get_title().startswith("seen")]
    labels = [(axes.get_xlabel()[0], axes.get_ylabel()[0]) for axes in views]
    assert labels == [("x", "y"), ("x", "z"), ("y", "z")]
    assert (
        len(
            {
                round(np.ptp(limits), 9)
                for axes in views
                for limits in (axes.get_xlim(), axes.get_ylim())
            }
        )
        == 1
    )
    for axes, plane in zip(views, ((0, 1), (0, 2), (1, 2)), strict=True):
        for gid, points in (("route", helix(500)), ("way-points", helix(50))):
            (line,) = [line for line in axes.lines if line.get_gid() == gid]
            np.testing.assert_allclose(np.transpose(line.get_data()), 1e3 * points[:, plane])
    assert all(axes.get_aspect() == 1.0 for axes in views)
    words = "\n".join(text.get_text() for text in figure.findobj(Text))
    assert "50 way-points" in words


def test_straight_repeated_and_impossible_routes(tmp_path: Path) -> None:
    straight = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert route_page(straight, straight, "").save(tmp_path / "route.png").stat().st_size > 1000
    assert list(route_curve(straight).curvature) == [0.0]
    route_page(straight[:2], straight[:2], "").save(tmp_path / "two.pdf")
    for wrong in (
        [[0.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.0]] * 3,
        [[0.0, 1.0]],
        [[0.0, np.nan, 0.0], [1.0, 0.0, 0.0]],
    ):
        with pytest.raises(InputError):
            route_page(wrong, wrong, "")
