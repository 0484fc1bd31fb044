"""Figures of `tendon plot` show the tables, as read from the figures themselves."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendon_cli.errors import UsageError
from tendon_cli.figures.draw import plot
from tendon_cli.figures.layout import STATE_PAIRS
from tendon_cli.figures.style import render
from tendon_cli.studies.figures import FigureSpec, figure_spec
from tendon_cli.tables.read import open_table
from tests.figures.runs import (
    LOADS,
    designs,
    figure_of,
    figures_of,
    grid,
    lines,
    panels,
    select,
    states,
    sweep,
    table,
    words,
)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    content = {
        "spool": {"ratio": [0.7, 0.8, 1.0]},
        "load": {"mass": LOADS},
        "motion": {"elbow_angle": grid("0 deg", "90 deg", 16)},
    }
    return sweep(tmp_path_factory.mktemp("plot") / "run", content)


def test_states_by_default(run: Path) -> None:
    figure = figure_of(table(run, "states"))
    shown = panels(figure)
    assert len(shown) == len(STATE_PAIRS) == 8
    assert shown[0].get_title() == "flexor tension at the elbow $F_{o}^{f}$"
    labels = [axes.get_ylabel() for axes in shown[::2]]
    assert labels == ["force (N)", "force (N)", "torque (N m)", "length (mm)"]
    assert shown[-1].get_xlabel() == "elbow angle θ (deg)"
    np.testing.assert_allclose(shown[0].get_xlim(), (0.0, 90.0))
    assert "At F₀ = 100 N, K = 3 kN/m, η = 0.8, μ = 0.07, φ = 180 deg." in words(figure)
    assert "--where" not in words(figure)
    directions = ("flexion", "extension")
    assert [line.get_label() for line in lines(shown[0])] == [
        f"{mass} load, {direction}" for mass in LOADS for direction in directions
    ]
    flexion, extension, next_load = lines(shown[0])[:3]
    assert flexion.get_linestyle() == "-"
    assert extension.get_linestyle() == "--"
    assert flexion.get_color() == extension.get_color() != next_load.get_color()


def test_lines_are_the_columns(run: Path) -> None:
    files = table(run, "states")
    figure = figure_of(files, quantity=("motor_torque",), panels="spool_ratio", colour="load_mass")
    columns = ["spool_ratio", "load_mass", "direction", "elbow_angle", "motor_torque"]
    read = files.read(columns).to_pandas()
    shown = panels(figure)
    assert [axes.get_title() for axes in shown] == ["η = 0.7", "η = 0.8", "η = 1"]
    for ratio, axes in zip((0.7, 0.8, 1.0), shown, strict=True):
        for line in lines(axes):
            mass, direction = line.get_label().split(" load, ")
            rows = select(
                read,
                spool_ratio=ratio,
                load_mass=float(mass.removesuffix(" kg")),
                direction=direction,
            )
            np.testing.assert_allclose(line.get_xdata(), np.degrees(rows.elbow_angle))
            np.testing.assert_allclose(line.get_ydata(), rows.motor_torque)


def test_slack_is_shown_by_a_band_of_its_own_side(run: Path) -> None:
    files = table(run, "states")
    where = ("spool_ratio = 1", "load_mass = 10 kg")
    extensor = figure_of(files, quantity=("extensor_tension_distal",), where=where)
    read = files.read(["spool_ratio", "load_mass", "direction", "status"]).to_pandas()
    rows = select(read, spool_ratio=1.0, load_mass=10.0, direction="flexion")
    slack = (rows.status == "extensor slack").to_numpy()
    band = lines(panels(extensor)[0], "slack")[0]
    is_drawn = np.isfinite(band.get_ydata())  # points, and the middles between them
    np.testing.assert_array_equal(is_drawn[::2], slack)
    np.testing.assert_array_equal(is_drawn[1::2], slack[:-1] | slack[1:])
    assert is_drawn[-1]  # up to the last point
    assert "a tendon is slack" in words(extensor)
    flexor = figure_of(files, quantity=("flexor_tension_distal",), where=where)
    assert not lines(panels(flexor)[0], "slack")


def test_units_and_any_x(run: Path) -> None:
    files = table(run, "states")
    figure = figure_of(
        files,
        quantity=("motor_torque",),
        x="elbow_torque",
        unit=("N·mm",),
        where=("spool_ratio = 1",),
    )
    (axes,) = panels(figure)
    assert axes.get_xlabel() == "elbow torque $τ_{a}$ (N·mm)"
    columns = ["spool_ratio", "load_mass", "direction", "elbow_torque", "motor_torque"]
    rows = select(
        files.read(columns).to_pandas(), spool_ratio=1.0, load_mass=3.0, direction="flexion"
    )
    line = next(line for line in lines(axes) if line.get_label() == "3 kg load, flexion")
    np.testing.assert_allclose(line.get_xdata(), 1e3 * rows.elbow_torque)
    np.testing.assert_allclose(line.get_ydata(), 1e3 * rows.motor_torque)


def test_designs_by_default_are_slack_maps_or_lines(run: Path, tmp_path: Path) -> None:
    over_ratio = figure_of(table(run, "designs"))
    assert panels(over_ratio)[0].get_xlabel() == "spool ratio η"
    content = {
        "tendon": {"pretension": grid("0 N", "300 N", 5)},
        "spring": {"stiffness": ["1 kN/m", "3 kN/m"]},
        "load": {"mass": LOADS},
    }
    files = designs(tmp_path / "map", content)
    assert len(panels(figure_of(files))) == 4
    one_load = figure_of(files, where=("load_mass = 3 kg", "pretension > 0 N"))
    assert "3 kg load" in words(one_load)
    (map_panel,) = panels(one_load)
    assert map_panel.get_xlim() == (37.5, 337.5)  # whole cells
    quantities = ("max_tension", "max_spring_extension")
    over_pretension = figure_of(files, quantity=quantities, x="pretension")
    assert panels(over_pretension)[0].get_title() == "max tension"
    over_load = figure_of(designs(tmp_path / "load", {"load": {"mass": LOADS}}))
    np.testing.assert_allclose(lines(panels(over_load)[0])[0].get_xdata(), [0.0, 3.0, 5.0, 10.0])


def test_several_quantities_and_panels_give_pages(run: Path) -> None:
    files = table(run, "states")
    figures = figures_of(files, panels="spool_ratio")
    assert len(figures) == 3
    assert "η = 0.7" in words(figures[0])
    torques = figure_of(files, panels="spool_ratio", quantity=("elbow_torque", "motor_torque"))
    assert len(panels(torques)) == 6


@pytest.mark.parametrize(
    ("options", "hint"),
    [
        ({"quantity": ("motor_tork",)}, "motor_torque"),
        ({"quantity": ("status",)}, None),
        ({"colour": "motor_torque"}, "axes: spool_ratio"),
        ({"colour": "load_mass", "panels": "load_mass"}, "different axes"),
        ({"unit": ("Nmm",)}, "N·mm"),
        ({"size": "huge"}, "column"),
        ({"size": "3 mm"}, "40 mm"),
        ({"format": "gif"}, None),
        ({"where": ("motor_torque > 1 kN m",)}, "values: "),
        ({"quantity": (*STATE_PAIRS, "spool_angle")}, None),
    ],
)
def test_what_does_not_fit_is_one_clear_error(
    run: Path, tmp_path: Path, options: dict[str, Any], hint: str | None
) -> None:
    with pytest.raises(UsageError) as refused:
        plot(table(run, "states"), figure_spec(**options), tmp_path)
    assert hint is None or hint in (refused.value.hint or "")
    assert not list(tmp_path.iterdir())


def test_files_and_their_names(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A table that has left the folder of its run is drawn as well.
    moved = tmp_path / "moved.parquet"
    shutil.copy(run / "states.parquet", moved)
    files = open_table(moved)
    monkeypatch.chdir(tmp_path)
    small = {"quantity": ("motor_torque",), "size": "column"}
    assert plot(files, figure_spec(**small)) == [Path("test-states-motor_torque.png")]
    (pdf,) = plot(files, figure_spec(**small, format="pdf"), tmp_path)
    assert pdf.read_bytes()[:5] == b"%PDF-"
    (svg,) = plot(files, figure_spec(**small), tmp_path / "a.svg")
    assert b"<svg" in svg.read_bytes()[:1000]
    several = figure_spec(quantity=STATE_PAIRS[:5], panels="spool_ratio", size="80 x 120 mm")
    pages = plot(files, several, tmp_path / "b.png")
    assert [page.name for page in pages] == ["b.png", "b_2.png"]
    with pytest.raises(UsageError, match="do not fit"):
        plot(files, figure_spec(size="40 x 60 mm"), tmp_path / "c.png")
    with pytest.raises(UsageError, match="does not end like a figure file"):
        plot(files, FigureSpec(), tmp_path / "a.gif")


def test_one_row(tmp_path: Path) -> None:
    content = {"motion": {"elbow_angle": ["60 deg"], "direction": ["flexion"]}}
    folder = sweep(tmp_path / "run", content)
    for axes in panels(figure_of(table(folder, "states"))):
        (line,) = lines(axes)
        assert line.get_marker() != "None"
    with pytest.raises(UsageError, match="no axis with several"):
        figures_of(table(folder, "designs"))


def test_only_nulls(tmp_path: Path) -> None:
    content = {
        "motion": {"elbow_angle": grid("165 deg", "170 deg", 3)},
        "tendon": {"pretension": ["50 N", "90 N"]},
    }
    folder = sweep(tmp_path / "run", content)
    for name in ("states", "designs"):
        with pytest.raises(UsageError, match=r"no row of the table has|no design has a margin"):
            figures_of(table(folder, name))


def test_a_filter_that_leaves_no_rows_is_refused_with_the_values_there_are(tmp_path: Path) -> None:
    files = states(tmp_path / "run", {"tendon": {"pretension": "120 N"}})
    torques = files.read(["motor_torque"])["motor_torque"].to_numpy()
    ends = f"values: {torques.min():.4g} N m to {torques.max():.4g} N m"
    for where, hint in {
        "motor_torque > 900 N m": ends,
        "status = flexor slack": "values: taut",
    }.items():
        with pytest.raises(UsageError, match=f'"{where}" leaves no rows') as refused:
            figure_of(files, quantity=("motor_torque",), where=(where,))
        assert refused.value.hint == hint


def test_some_nulls_are_hatched(tmp_path: Path) -> None:
    files = states(tmp_path / "run", {"motion": {"elbow_angle": grid("90 deg", "170 deg", 17)}})
    figure = figure_of(files, quantity=("motor_torque",))
    assert "no value" in words(figure)
    assert any(patch.get_hatch() for patch in panels(figure)[0].patches)


def test_formulas_and_hostile_names_are_drawn_as_meant(tmp_path: Path) -> None:
    content = {
        "title": "$a_{ " + "$" * 295,
        "cases": [{"name": "_a $x^"}, {"name": "$" * 199}],
        "arm": {"elbow_radius": ["45 mm", "50 mm"]},
        "tendon": {"pretension": ["50 N", "90 N"]},
    }
    files = states(tmp_path / "run", content)
    first, second = figures_of(files, panels="arm_elbow_radius", colour="case")
    assert "$R_{elb}$ = 45 mm" in words(first)
    fixed = figure_of(files, colour="case", quantity=("motor_torque",), panels="pretension")
    for radius in (45, 50):
        assert f"$R_{{elb}}$ = {radius} mm" in words(fixed)
    assert fixed.legends[0].get_texts()[0].get_text() == r"_a \$x^"
    for figure in (first, second, fixed):
        assert render(figure, "svg")[:5] == b"<?xml"


def test_many_angles_are_thinned_and_it_says_so(tmp_path: Path) -> None:
    files = states(tmp_path / "run", {"motion": {"elbow_angle": grid("0 deg", "90 deg", 5001)}})
    figure = figure_of(files, quantity=("motor_torque",))
    line = lines(panels(figure)[0])[0]
    assert len(line.get_xdata()) == 1000
    assert line.get_xdata()[-1] == pytest.approx(90.0)
    assert "1,000 of 5,001 values of elbow angle" in words(figure)
