"""A figure shows every point of what has no order, or says how many it shows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendon_cli.figures import layout
from tendon_cli.figures.draw import pages_of
from tendon_cli.figures.served import for_whom
from tendon_cli.figures.style import house_style
from tendon_cli.tables.read import TableFiles
from tests.figures.runs import designs, figure_of, grid, lines, panels, states, words
from tests.figures.test_population import record

TWO_LOADS = {"load": {"mass": ["2 kg", "5 kg"]}}


def cases(count: int) -> TableFiles | dict[str, Any]:
    """Return content with so many cases of the forearm's mass."""
    return {
        **TWO_LOADS,
        "cases": [
            {"name": f"arm {place}", "arm": {"forearm_mass": f"{1.0 + 0.1 * place!r} kg"}}
            for place in range(count)
        ],
    }


def draws(count: int) -> dict[str, Any]:
    """Return content with so many draws of the friction."""
    return {
        **TWO_LOADS,
        "sheath": {"friction": {"mean": 0.07, "std": 0.005}},
        "uncertainty": {"draws": count},
    }


def points_drawn(figure: Any) -> int:
    """Return the number of points with a marker in a figure whose lines have no dashes."""
    total = 0
    for axes in panels(figure):
        for line in lines(axes):
            assert line.get_linestyle() == "None"
            assert line.get_markevery() in (1, None)
            total += int(np.isfinite(line.get_ydata()).sum())
    return total


@pytest.mark.parametrize("count", [3, 12, 13, 24, 40])
def test_every_case_under_every_load_is_a_point(count: int, tmp_path: Path) -> None:
    run = designs(tmp_path / "run", cases(count))
    assert points_drawn(figure_of(run)) == 2 * count
    assert points_drawn(figure_of(run, quantity="peak_motor_torque", x="case")) == 2 * count


def test_every_draw_is_a_point_also_against_the_number_drawn(tmp_path: Path) -> None:
    run = designs(tmp_path / "run", draws(1024))
    for x in ("draw", "friction"):
        figure = figure_of(run, quantity="margin", x=x)
        assert points_drawn(figure) == 2048
        assert "evenly spaced" not in words(figure)
    (axes,) = panels(figure_of(run, quantity="margin", x="friction"))
    friction = np.array(run.read(["friction"])["friction"], dtype=float)
    np.testing.assert_array_equal(lines(axes)[0].get_xdata(), friction[::2])


def test_a_figure_of_fewer_points_says_of_how_many(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = designs(tmp_path / "run", draws(64))
    monkeypatch.setattr(layout, "MARKS", 50)
    (page,) = pages_of(run)
    assert points_drawn(page.figure) == 100
    assert "Shown: 50 of 64 values of draw, evenly spaced." in page.says


def test_the_only_angle_of_many_that_is_drawn_is_named(tmp_path: Path) -> None:
    springs = {"stiffness": grid("3 kN/m", "5 kN/m", 3)}
    ratios = {"ratio": [0.5, 0.75, 1.0]}
    content = {"load": {"mass": ["0 kg", "5 kg"]}, "spring": springs, "spool": ratios}
    run = states(tmp_path / "run", content)
    figure = figure_of(run, quantity="motor_torque", x="spring.stiffness")
    assert "1 of 16 values of elbow angle (θ = 48 deg)" in words(figure)
    rows = run.read().to_pandas()
    drawn = lines(panels(figure)[0])[0].get_ydata()
    torques = rows.loc[np.isclose(np.degrees(rows["elbow_angle"]), 48.0), "motor_torque"]
    assert np.isin(drawn, torques).all()


def test_numbers_in_order_are_lines(tmp_path: Path) -> None:
    run = designs(tmp_path / "run", {"tendon": {"pretension": grid("50 N", "200 N", 40)}})
    (axes,) = panels(figure_of(run))
    assert lines(axes)[0].get_linestyle() == "-"


def test_windows_left_out_are_counted() -> None:
    low = np.linspace(90.0, 120.0, 5000)
    rows = {"pretension_from": low, "pretension_to": low + 30.0, "served": np.ones(5000)}
    with house_style():
        text = words(for_whom(record(), rows).figure)
    assert "4,000 of 5,000 windows" in text
