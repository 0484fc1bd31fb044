"""Slack maps show margins, boundaries and what is unstable, as read from the figures themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendon_cli.figures.draw import draw_run
from tendon_cli.figures.maps import colour_scale
from tendon_cli.tables.read import TableFiles
from tests.figures.runs import (
    LOADS,
    by_gid,
    designs,
    figure_of,
    grid,
    panels,
    study_of,
    sweep,
    words,
)

STIFFNESS = {"stiffness": grid("0.5 kN/m", "6 kN/m", 12)}
PRETENSION = {"pretension": grid("0 N", "300 N", 31)}


@pytest.fixture(scope="module")
def springs(tmp_path_factory: pytest.TempPathFactory) -> TableFiles:
    """Return the designs of 31 pretensions, 12 springs and 4 loads."""
    content = {
        "title": "Springs & $ons",
        "tendon": PRETENSION,
        "spring": STIFFNESS,
        "load": {"mass": LOADS},
    }
    return designs(tmp_path_factory.mktemp("map") / "run", content)


def column(files: TableFiles, name: str, shape: tuple[int, ...]) -> np.ndarray:
    """Return a column of a table in the shape of its axes."""
    return np.array(files.read([name])[name]).reshape(shape)


def test_panels_axes_units_and_colours(springs: TableFiles) -> None:
    figure = figure_of(springs)
    shown = panels(figure)
    assert [axes.get_title() for axes in shown] == [f"{mass} load" for mass in LOADS]
    assert shown[2].get_xlabel() == "pretension F₀ (N)"
    assert shown[0].get_ylabel() == "spring stiffness K (kN/m)"
    text = words(figure)
    for part in ("Springs & \\$ons", "F₀ − F₀* (N)", "ticks on the slack side"):
        assert part in text
    assert "no equilibrium" not in text
    margins = column(springs, "margin", (31, 12, 4))  # (pretensions, springs, loads), N
    for load, axes in enumerate(shown):
        np.testing.assert_allclose(axes.get_xlim(), (-5.0, 305.0))  # whole cells
        np.testing.assert_allclose(axes.get_ylim(), (0.25, 6.25))
        (mesh,) = by_gid(axes, "margin")
        np.testing.assert_allclose(np.asarray(mesh.get_array()), margins[:, :, load].T)
        assert mesh.norm(0.0) == pytest.approx(0.5)
        assert mesh.norm.vmin == -mesh.norm.vmax
        red, _, blue, _ = mesh.cmap(mesh.norm(-mesh.norm.vmax / 2))
        assert red > blue


def test_axes_and_captions_name_the_tension_that_the_study_reads(tmp_path: Path) -> None:
    content = {
        "setting": {"read": "flexor at joint"},
        "tendon": {"pretension": grid("9 N", "90 N", 4)},
        "spring": STIFFNESS,
        "load": {"mass": ["3 kg"]},
    }
    figure = figure_of(designs(tmp_path / "run", content))
    (panel,) = panels(figure)
    assert panel.get_xlabel() == "tension in the flexor at the joint $F_{set}$ (N)"
    text = " ".join(words(figure).split())
    assert "margin $F_{set}$ − $F_{set}^{*}$ (N)" in text
    assert "Margin: how far the tension in the flexor at the joint is above $F_{set}^{*}$" in text
    assert "F₀" not in text


def test_the_boundary_is_the_required_pretension_with_ticks_on_the_slack_side(
    springs: TableFiles,
) -> None:
    required = column(springs, "required_pretension", (31, 12, 4))[0, :, 1]  # (springs,) at 3 kg, N
    (axes,) = panels(figure_of(springs, where="load_mass = 3 kg"))
    (boundary,) = by_gid(axes, "boundary")
    vertices = np.concatenate([path.vertices for path in boundary.get_paths()])
    for stiffness, pretension in zip(np.linspace(0.5, 6.0, 12), required, strict=True):
        nearest = vertices[np.isclose(vertices[:, 1], stiffness)]
        assert np.abs(nearest[:, 0] - pretension).min() < 1e-6 * 300.0
    (ticks,) = [effect for effect in boundary.get_path_effects() if hasattr(effect, "_angle")]
    assert ticks._angle == -90.0  # to the right of the line
    # More pretension, which is along x, is a larger margin: on the left going down.
    for path in boundary.get_paths():
        assert (np.diff(path.vertices[:, 1]) < 0.0).all()


@pytest.mark.parametrize(("first", "last"), [(5.0, 65.0), (-65.0, -5.0)])
def test_the_boundary_goes_on_to_the_edges_of_the_outermost_cells(
    first: float, last: float, springs: TableFiles, tmp_path: Path
) -> None:
    """The margin is linear in the pretension, and so is what is drawn in the outer half cells."""
    # The required pretension of 3 kN/m and 3 kg lies less than half a cell outside of the grid.
    place = column(springs, "required_pretension", (31, 12, 4))[0, 5, 1]
    content = {
        "tendon": {"pretension": grid(f"{place + first} N", f"{place + last} N", 4)},
        "spring": STIFFNESS,
        "load": {"mass": ["3 kg"]},
    }
    (axes,) = panels(figure_of(designs(tmp_path / "run", content)))
    (boundary,) = by_gid(axes, "boundary")
    vertices = np.concatenate([path.vertices for path in boundary.get_paths()])
    there = vertices[np.isclose(vertices[:, 1], 3.0)]
    np.testing.assert_allclose(there[:, 0], place, atol=1e-6)


def test_logarithmic_axis(tmp_path: Path) -> None:
    content = {
        "spring": {"stiffness": grid("0.3 kN/m", "30 kN/m", 9, spacing="log")},
        "spool": {"ratio": [0.7, 1.0, 1.3]},
    }
    (axes,) = panels(figure_of(designs(tmp_path / "run", content)))
    assert axes.get_xscale() == "log"
    assert axes.get_yscale() == "linear"
    assert axes.get_ylabel() == "spool ratio η"
    half_cell = 100.0 ** (1 / 16)
    np.testing.assert_allclose(axes.get_xlim(), (0.3 / half_cell, 30.0 * half_cell))


def test_designs_without_equilibrium_are_hatched_and_explained(tmp_path: Path) -> None:
    content = {
        "arm": {"a1": grid("10 mm", "80 mm", 8), "b1": grid("60 mm", "250 mm", 9)},
        "motion": {"elbow_angle": grid("0 deg", "170 deg", 18)},
    }
    table = designs(tmp_path / "run", content)
    margins = np.array(table.read(["margin"])["margin"], dtype=float)
    assert 0 < np.isnan(margins).sum() < margins.size
    figure = figure_of(table)
    (axes,) = panels(figure)
    assert axes.patch.get_hatch()
    (mesh,) = by_gid(axes, "margin")
    assert np.ma.getmaskarray(mesh.get_array()).sum() == np.isnan(margins).sum()
    assert "no equilibrium at some elbow angle" in words(figure)


def test_one_axis_gives_lines_with_the_slack_side_shaded(springs: TableFiles) -> None:
    (axes,) = panels(figure_of(springs, where="spring_stiffness = 3 kN/m"))
    lines = by_gid(axes, "curve")
    assert [line.get_label() for line in lines] == [f"{mass} load" for mass in LOADS]
    assert len({line.get_color() for line in lines}) == 4
    assert len({line.get_marker() for line in lines}) == 4
    (shade,) = by_gid(axes, "slack area")
    shaded = shade.get_extents().transformed(axes.transData.inverted())
    assert shaded.y1 == pytest.approx(0.0, abs=1e-9)


def test_over_cases_the_map_has_cells_and_a_stroke_for_each(tmp_path: Path) -> None:
    cases = [
        {"name": "light", "arm": {"forearm_mass": "0.6 kg"}},
        {"name": "a $50 man", "arm": {"forearm_mass": "9 kg"}},
    ]
    table = designs(tmp_path / "run", {"cases": cases, "tendon": PRETENSION})
    required = column(table, "required_pretension", (2, 31))[:, 0]
    (axes,) = panels(figure_of(table))
    assert [label.get_text() for label in axes.get_xticklabels()] == ["light", r"a \$50 man"]
    strokes = by_gid(axes, "boundary")
    np.testing.assert_allclose([stroke.get_ydata()[0] for stroke in strokes], required, rtol=1e-9)
    # More pretension, along y, is on the left.
    assert all(np.diff(stroke.get_xdata()) > 0.0 for stroke in strokes)
    (area,) = by_gid(axes, "unstable")
    is_stable = column(table, "stable", (2, 31))
    assert len(area.get_paths()) == int((~is_stable).sum()) > 0
    (axes,) = panels(figure_of(designs(tmp_path / "cases", {"cases": cases})))
    assert axes.lines[0].get_linestyle() == "None"


def test_two_by_two(tmp_path: Path) -> None:
    content = {
        "tendon": {"pretension": ["200 N", "100 N"]},
        "spring": {"stiffness": ["1 kN/m", "3 kN/m"]},
        "load": {"mass": ["5 kg"]},
    }
    (axes,) = panels(figure_of(designs(tmp_path / "run", content)))
    (mesh,) = by_gid(axes, "margin")
    assert mesh.get_array().shape == (2, 2)
    assert mesh.get_array()[1, 0] < 0.0 < mesh.get_array()[1, 1]
    assert list(axes.get_xticks()) == [100.0, 200.0]


def test_many_combinations_are_chosen_evenly_and_it_says_so(tmp_path: Path) -> None:
    content = {
        "tendon": {"pretension": grid("0 N", "300 N", 401), "length": ["1 m", "2 m", "3 m"]},
        "spring": {"stiffness": grid("1 kN/m", "5 kN/m", 3)},
        "spool": {"ratio": [0.7, 0.8, 0.9]},
        "load": {"mass": LOADS},
    }
    figure = figure_of(designs(tmp_path / "run", content))
    assert len(panels(figure)) == 12
    fewer = "400 of 401 values of pretension and 1 of 3 values of spool ratio, evenly spaced."
    assert fewer in " ".join(words(figure).split())
    assert "At η = 0.8, μ = 0.07, φ = 180 deg." in words(figure)
    titles = [axes.get_title().replace("\n", " ") for axes in panels(figure)]
    assert titles[4] == "0 kg load, K = 3 kN/m"
    assert len(set(titles)) == 12


def test_more_panels_than_a_page_go_on_a_second(tmp_path: Path) -> None:
    content = {
        "tendon": {"pretension": ["50 N", "150 N"]},
        "spring": {"stiffness": ["1 kN/m", "3 kN/m"]},
        "sheath": {"friction": [0.05, 0.07, 0.09, 0.1]},
        "load": {"mass": LOADS},
    }
    drawn = draw_run(study_of(content), sweep(tmp_path / "run", content))
    assert drawn == (["slack_map.png", "slack_map-2.png"], [], None)


def test_no_map_has_a_reason(tmp_path: Path) -> None:
    only_loads: dict[str, Any] = {"load": {"mass": LOADS}}
    drawn = draw_run(study_of(only_loads), sweep(tmp_path / "run", only_loads))
    assert drawn == ([], [], "no axis other than the load has more than one value")
    motion = {"elbow_angle": grid("160 deg", "170 deg", 2)}
    for name, more in (("line", {}), ("map", {"spring": STIFFNESS})):
        content = {"tendon": PRETENSION, "motion": motion, **more}
        _, _, reason = draw_run(study_of(content), sweep(tmp_path / name, content))
        assert "no design has a margin" in str(reason)


def test_the_colour_scale_is_round_and_keeps_the_near_of_zero_visible() -> None:
    margins = np.array([-7000.0, *np.linspace(-80.0, 110.0, 50), np.nan])
    limit, levels, extend = colour_scale(margins)
    assert (limit, extend) == (125.0, "min")
    assert 0.0 in levels
    assert colour_scale(np.array([-90.0, 110.0]))[2] == "neither"
    assert colour_scale(np.zeros(3))[0] > 0.0
