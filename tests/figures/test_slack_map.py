"""Slack maps show margins, boundaries and what is unstable, as read from the figures themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendon_cli.figures import slices
from tendon_cli.figures.draw import draw_run
from tendon_cli.figures.maps import colour_scale
from tendon_cli.tables.read import TableFiles
from tests.figures.runs import (
    LOADS,
    by_gid,
    covers,
    designs,
    figure_of,
    figures_of,
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
        np.testing.assert_allclose(axes.get_xlim(), (0.0, 300.0))  # beyond it nothing is known
        np.testing.assert_allclose(axes.get_ylim(), (0.5, 6.0))
        (mesh,) = by_gid(axes, "value")
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
    assert panel.get_xlabel() == "spring stiffness K (kN/m)"
    assert panel.get_ylabel() == "tension in the flexor at the joint $F_{set}$ (N)"
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
    (mesh,) = by_gid(axes, "value")
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


def test_cases_are_cells_hatched_whole_with_a_letter_each(tmp_path: Path) -> None:
    cases = [
        {"name": "light", "arm": {"forearm_mass": "0.6 kg"}},
        {"name": "a $50 man", "arm": {"forearm_mass": "9 kg"}},
    ]
    table = designs(tmp_path / "run", {"cases": cases, "tendon": PRETENSION})
    (axes,) = panels(figure_of(table))
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == [r"a \$50 man", "light"], "the first is the top one"
    is_stable = column(table, "stable", (2, 31))
    is_taut = column(table, "taut", (2, 31))
    (area,) = by_gid(axes, "unstable")
    assert not by_gid(axes, "boundary")
    for row, place in np.ndindex(2, 31):
        is_hatched = covers(area, 10.0 * place, 1.0 - row)
        assert is_hatched != is_stable[row, place]
    letters = {}
    for text in by_gid(axes, "text"):
        across, up = text.get_position()
        letters[1 - round(up), round(across / 10.0)] = text.get_text()
    for row, place in np.ndindex(2, 31):
        letter = letters[row, place]
        assert letter.startswith("S") != is_taut[row, place]
        assert (letter[0] == "U") == bool(is_taut[row, place] and not is_stable[row, place])
    (axes,) = panels(figure_of(designs(tmp_path / "cases", {"cases": cases})))
    assert axes.lines[0].get_linestyle() == "None"


def test_two_by_two(tmp_path: Path) -> None:
    content = {
        "tendon": {"pretension": ["200 N", "100 N"]},
        "spring": {"stiffness": ["1 kN/m", "3 kN/m"]},
        "load": {"mass": ["5 kg"]},
    }
    (axes,) = panels(figure_of(designs(tmp_path / "run", content)))
    (mesh,) = by_gid(axes, "value")
    assert mesh.get_array().shape == (2, 2)
    assert mesh.get_array()[1, 0] < 0.0 < mesh.get_array()[1, 1]
    assert list(axes.get_xticks()) == [0.0, 1.0], "listed values have cells of one size"
    assert [label.get_text() for label in axes.get_xticklabels()] == ["100", "200"]


def test_a_slack_flexor_is_told_from_a_slack_extensor(tmp_path: Path) -> None:
    content = {
        "tendon": {
            "flexor": {"pretension": grid("5 N", "100 N", 6)},
            "extensor": {"pretension": grid("5 N", "100 N", 6)},
        },
        "load": {"mass": ["0 kg"]},
        "arm": {"upper_arm_angle": "150 deg"},
    }
    table = designs(tmp_path / "run", content)
    flexor = column(table, "min_flexor_tension", (6, 6)) <= 1e-6
    extensor = column(table, "min_extensor_tension", (6, 6)) <= 1e-6
    alone = flexor & ~extensor
    assert 0 < alone.sum() < alone.size
    figure = figure_of(table)
    (axes,) = panels(figure)
    (mesh,) = by_gid(axes, "other")
    is_drawn = ~np.ma.getmaskarray(mesh.get_array()).reshape(6, 6)
    np.testing.assert_array_equal(is_drawn.T, alone)
    _, green, blue, _ = mesh.cmap(0.3)
    assert blue > green, "a red that is no orange"
    _, green, blue, _ = by_gid(axes, "value")[0].cmap(0.3)
    assert green > blue
    assert "flexor slack" in words(figure)


def test_the_long_axes_are_the_map_s_and_nothing_is_left_out(tmp_path: Path) -> None:
    content = {
        "spring": {"stiffness": ["3 kN/m", "8 kN/m"]},
        "spool": {"ratio": [0.5, 0.6]},
        "tendon": {"pretension": grid("60 N", "210 N", 16)},
        "load": {"mass": ["0 kg", "10 kg"]},
    }
    table = designs(tmp_path / "run", content)
    figure = figure_of(table)
    shown = panels(figure)
    assert len(shown) == 4
    assert "pretension" in shown[-1].get_xlabel()
    assert "ratio" in shown[0].get_ylabel()
    drawn = np.sort(np.concatenate([by_gid(axes, "value")[0].get_array() for axes in shown], None))
    np.testing.assert_allclose(drawn, np.sort(column(table, "margin", (128,))))
    assert "evenly spaced" not in words(figure)
    turned = figures_of(table, x="spool.ratio", quantity="spring.stiffness")
    assert len(turned) == 2
    assert "spool ratio" in panels(turned[0])[-1].get_xlabel()
    assert "spring stiffness" in panels(turned[0])[0].get_ylabel().replace("\n", " ")


def test_more_panels_than_pages_are_chosen_evenly_and_it_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slices, "MOST_PAGES", 1)
    content = {
        "tendon": {"pretension": grid("0 N", "300 N", 13)},
        "spring": {"stiffness": grid("1 kN/m", "5 kN/m", 9)},
        "spool": {"ratio": grid("0.5", "0.9", 8)},
        "load": {"mass": LOADS},
        "motion": {"elbow_angle": grid("0 deg", "90 deg", 2)},
    }
    (figure,) = figures_of(designs(tmp_path / "run", content))
    titles = [axes.get_title() for axes in panels(figure)]
    assert len(set(titles)) == len(titles) == 24
    assert "6 of 8 values of spool ratio, evenly spaced" in " ".join(words(figure).split())


def test_more_panels_than_a_page_go_on_a_second(tmp_path: Path) -> None:
    content = {
        "tendon": {"pretension": ["50 N", "150 N"]},
        "spring": {"stiffness": ["1 kN/m", "3 kN/m"]},
        "sheath": {"friction": [0.05, 0.07, 0.09, 0.1]},
        "spool": {"ratio": [0.6, 0.7, 0.8]},
        "arm": {"elbow_radius": ["40 mm", "45 mm"]},
        "load": {"mass": LOADS},
    }
    drawn = draw_run(study_of(content), sweep(tmp_path / "run", content))
    assert drawn == (["slack_map.png", "slack_map_2.png"], [], None)


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
