"""A figure says what it shows: its settings, what is slack, unstable or over a limit, its study."""

from __future__ import annotations

import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex
from PIL import Image

from tendon_cli.errors import UsageError
from tendon_cli.figures.draw import plot, table_of
from tendon_cli.figures.style import load_colours
from tendon_cli.studies.figures import figure_spec
from tendon_cli.tables.read import TableFiles
from tests.figures.runs import (
    LOADS,
    by_gid,
    designs,
    figure_of,
    grid,
    lines,
    panels,
    select,
    states,
    study_of,
    sweep,
    table,
    words,
)

PRETENSION = {"pretension": grid("20 N", "260 N", 13)}
RATIO = {"ratio": grid("0.5", "1.2", 8)}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> TableFiles:
    """Return the states of 2 pretensions and 4 loads over 31 angles."""
    content = {
        "tendon": {"pretension": ["100 N", "200 N"]},
        "load": {"mass": LOADS},
        "motion": {"elbow_angle": grid("0 deg", "90 deg", 31)},
    }
    return table(sweep(tmp_path_factory.mktemp("display") / "run", content), "states")


# --- Captions and metadata ------------------------------------------------------------------------


def test_filters_and_what_is_common_stand_in_the_caption(run: TableFiles) -> None:
    where = ["load_mass = 5 kg", "pretension = 200 N"]
    filtered = figure_of(run, quantity="motor_torque", where=where)
    (notes,) = by_gid(filtered, "notes")
    assert "Only where load_mass = 5 kg and pretension = 200 N." in notes.get_text()
    assert "At F₀ = 200 N, K = 3 kN/m, η = 1, 5 kg load, μ = 0.07, φ = 180 deg." in notes.get_text()
    flexion = figure_of(
        run, quantity="motor_torque", panels="pretension", where="direction = flexion"
    )
    assert "At flexion, K = 3 kN/m, η = 1, μ = 0.07, φ = 180 deg." in words(flexion)
    assert "--" not in words(filtered) + words(flexion)


def test_sides_that_differ_are_named(tmp_path: Path) -> None:
    content = {
        "tendon": {"pretension": "100 N", "extensor": {"pretension": "80 N"}},
        "spool": RATIO,
    }
    files = designs(tmp_path / "run", content)
    figure = figure_of(files)
    assert "F₀ = 100 N (flexor), F₀ = 80 N (extensor)" in words(figure)
    assert panels(figure)[0].get_ylabel() == "common margin of both pretensions (N)"
    assert "F₀*" not in words(figure)
    # As the caption says: lowered together by their margin, the sides are at the edge of slack.
    margin = files.read(["margin"])["margin"][0].as_py()
    lowered = {"pretension": 100.0 - margin, "extensor": {"pretension": 80.0 - margin}}
    edge = designs(tmp_path / "edge", {"tendon": lowered, "spool": {"ratio": [0.5]}})
    assert edge.read(["margin"])["margin"][0].as_py() == pytest.approx(0.0, abs=1e-9)


def test_every_format_knows_its_study(run: TableFiles, tmp_path: Path) -> None:
    spec = figure_spec(
        quantity="flexor_tension_proximal",
        where="load_mass = 5 kg",
        size="column",
        format=["png", "svg", "pdf"],
    )
    png, svg, pdf = plot(run, spec, tmp_path)
    study_hash = run.facts["study_hash"]
    source = f"tendon study test {study_hash}"
    with Image.open(png) as image:
        facts = image.info
    assert facts["Title"] == "test"
    assert "Only where load_mass = 5 kg." in facts["Description"]
    assert facts["Source"] == source
    text = svg.read_text(encoding="utf-8")
    assert source in text
    assert "elbow angle θ (deg)" in text  # text, which can be searched and edited
    assert "<text" in text
    written = pdf.read_bytes()
    packed = re.findall(rb"stream\r?\n(x.*?)\r?\nendstream", written, re.DOTALL)
    streams = b"".join(zlib.decompress(stream) for stream in packed)
    assert study_hash.encode() in written + streams


def test_a_key_too_long_for_a_small_figure_is_broken(tmp_path: Path) -> None:
    files = designs(tmp_path / "run", {"tendon": PRETENSION, "spool": RATIO})
    figure = figure_of(files, size="60 x 70 mm")
    figure.draw_without_rendering()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert figure.bbox.x0 <= box.x0
    assert box.x1 <= figure.bbox.x1
    (notes,) = by_gid(figure, "notes")
    assert notes.get_window_extent().y1 <= box.y0 + 1.0


# --- Slack and instability in curves --------------------------------------------------------------


def test_unstable_stretches_are_marked_where_the_stiffness_is_negative(run: TableFiles) -> None:
    light = ["load_mass = 0 kg", "pretension = 200 N"]
    figure = figure_of(run, quantity="motor_torque", where=light)
    (axes,) = panels(figure)
    all_rows = run.read().to_pandas()
    rows = select(all_rows, load_mass=0.0, pretension=200.0, direction="flexion")
    unstable = (rows.elbow_stiffness < 0.0).to_numpy()
    assert 0 < unstable.sum() < len(unstable)
    marked = lines(axes, "unstable")[0]
    np.testing.assert_array_equal(np.isfinite(marked.get_ydata())[::2], unstable)
    np.testing.assert_allclose(marked.get_ydata()[::2][unstable], rows.motor_torque[unstable])
    assert "unstable elbow" in words(figure)
    heavy = ["load_mass = 10 kg", "pretension = 100 N"]
    stable = figure_of(run, quantity="motor_torque", where=heavy)
    assert not lines(panels(stable)[0], "unstable")
    assert "unstable" not in words(stable)


def test_lines_of_tendons_that_push_are_shaded_below_zero(tmp_path: Path) -> None:
    unilateral = {"load": {"mass": ["10 kg"]}}
    bilateral = {"model": {"slack": "bilateral"}, **unilateral}
    for content, is_shaded in ((bilateral, True), (unilateral, False)):
        files = states(tmp_path / str(is_shaded), content)
        (axes,) = panels(figure_of(files, quantity="extensor_tension_distal"))
        assert bool(by_gid(axes, "slack area")) == is_shaded
        assert bool(by_gid(axes, "slack word")) == is_shaded


def test_open_and_filled_markers_are_in_the_key(run: TableFiles) -> None:
    figure = figure_of(run, quantity="motor_torque", where="pretension = 100 N")
    legend = figure.legends[0]
    labels = [text.get_text() for text in legend.get_texts()]
    key = dict(zip(labels, legend.legend_handles, strict=True))
    assert to_hex(key["extension, open"].get_markerfacecolor()) == "#ffffff"
    assert to_hex(key["flexion, filled"].get_markerfacecolor()) == "#000000"
    for line in lines(panels(figure)[0], "curve"):
        is_open = to_hex(line.get_markerfacecolor()) == "#ffffff"
        assert is_open == line.get_label().endswith("extension")


def test_a_load_has_its_colour_in_every_figure(run: TableFiles) -> None:
    def colours(quantity: str, *where: str) -> dict[str, str]:
        figure = figure_of(run, quantity=quantity, where=where)
        curves = lines(panels(figure)[0], "curve")
        return {line.get_label(): to_hex(line.get_color()) for line in curves}

    all_loads = colours("motor_torque", "pretension = 100 N")
    two_loads = colours("elbow_torque", "pretension = 100 N", "load_mass in 3 kg, 10 kg")
    assert len(two_loads) == 4
    assert two_loads.items() <= all_loads.items()
    assert len({to_hex(colour) for colour in load_colours(np.array([5.0, 5.1, 5.2]))}) == 3


def test_quantities_of_another_size_have_their_own_axis(run: TableFiles) -> None:
    stretches = ("flexor_tendon_stretch", "flexor_spring_stretch")
    tensions = ("flexor_tension_distal", "extensor_tension_distal")
    for names, alike in ((stretches, False), (tensions, True)):
        first, second = panels(figure_of(run, quantity=names, where="pretension = 100 N"))
        sizes = [
            max(np.nanmax(np.abs(line.get_ydata())) for line in lines(axes))
            for axes in (first, second)
        ]
        assert (max(sizes) < 5.0 * min(sizes)) == alike
        assert (first.get_ylim() == second.get_ylim()) == alike
        assert bool(second.get_ylabel()) != alike


def test_an_axis_of_pure_numbers_has_their_name(tmp_path: Path) -> None:
    content = {
        "spring": {"stiffness": ["3 kN/m", "5 kN/m", "7 kN/m"]},
        "motion": {"elbow_angle": grid("0 deg", "90 deg", 7), "speed": "60 deg/s"},
    }
    names = ("efficiency", "slack_fraction", "peak_motor_power", "unstable_fraction")
    shown = panels(figure_of(designs(tmp_path / "run", content), quantity=names))
    labels = [axes.get_ylabel() for axes in shown]
    assert labels == ["efficiency", "slack fraction", "power (W)", "unstable fraction"]


# --- Maps -----------------------------------------------------------------------------------------

FORCES = np.linspace(20.0, 260.0, 13)
RATIOS = np.linspace(0.5, 1.2, 8)


def test_a_map_hatches_just_the_unstable_designs(tmp_path: Path) -> None:
    content = {"tendon": PRETENSION, "spool": RATIO, "load": {"mass": ["0 kg", "10 kg"]}}
    files = designs(tmp_path / "run", content)
    figure = figure_of(files)
    stable = np.array(files.read(["stable"])["stable"]).reshape(13, 8, 2)  # (…, loads)
    assert 0 < stable[..., 0].sum() < stable[..., 0].size
    assert stable[..., 1].all()
    light, heavy = panels(figure)
    (area,) = by_gid(light, "unstable")
    paths = area.get_paths()
    middle = np.array([np.mean(FORCES), np.mean(RATIOS)])
    for row, force in enumerate(FORCES):
        for level, ratio in enumerate(RATIOS):
            # A hair toward the middle, because the first and last designs lie on the frame.
            point = 0.999 * np.array([force, ratio]) + 0.001 * middle
            inside = any(path.contains_point(point) for path in paths)
            assert inside != stable[row, level, 0]
    assert not by_gid(heavy, "unstable")
    assert "unstable: elbow stiffness below 0 N m/rad at some angle" in words(figure)


def test_each_limit_has_its_line_and_its_name(tmp_path: Path) -> None:
    content = {
        "tendon": {"pretension": grid("20 N", "260 N", 25)},
        "spool": RATIO,
        "limits": {
            "max_tension": "300 N",
            "peak_motor_torque": "8 N m",
            "max_pretension": "203 N",
        },
        "load": {"mass": ["5 kg"]},
    }
    files = designs(tmp_path / "run", content)
    figure = figure_of(files)
    (axes,) = panels(figure)
    for label in ("max tension ≤ 300 N", "peak motor torque ≤ 8 N m", "pretension ≤ 203 N"):
        assert label in words(figure)
    forces = np.linspace(20.0, 260.0, 25)
    tensions = files.read(["max_tension"]).to_pandas().max_tension.to_numpy().reshape(25, 8)
    borders = {
        "max_tension": [np.interp(300.0, tensions[:, level], forces) for level in range(8)],
        "max_pretension": [203.0] * 8,
    }
    for gid, border in borders.items():
        (line,) = by_gid(axes, gid)
        vertices = np.concatenate([path.vertices for path in line.get_paths()])
        for ratio, force in zip(RATIOS, border, strict=True):
            nearest = vertices[np.isclose(vertices[:, 1], ratio)]
            assert np.abs(nearest[:, 0] - force).min() < 1e-6 * 260.0


def test_truths_are_filtered_by_their_word(tmp_path: Path) -> None:
    files = designs(tmp_path / "run", {"tendon": PRETENSION})
    stable = np.array(files.read(["stable"])["stable"])
    assert 0 < stable.sum() < stable.size
    for text, kept in (("stable = true", True), ("stable = false", False), ("stable != 1", False)):
        figure = figure_of(files, quantity="margin", where=text)
        (line,) = lines(panels(figure)[0], "curve")
        np.testing.assert_array_equal(np.isfinite(line.get_ydata()), stable == kept)
        assert "no value" in words(figure)
    with pytest.raises(UsageError, match="no order"):
        figure_of(files, quantity="margin", where="stable > 0")


# --- Requests -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["study.toml", "study.yaml", "study.YML"])
def test_a_study_is_told_to_be_one(tmp_path: Path, name: str) -> None:
    with pytest.raises(UsageError, match="is a study") as refused:
        table_of(tmp_path / name, figure_spec())
    assert "tendon sweep" in str(refused.value.hint)
    assert "--arm" in str(refused.value.hint)


@pytest.mark.parametrize(
    ("text", "same"),
    [("120", (120, None)), ("12 x 9 cm", (120, 90)), ("column", (85, None)), ("page", (175, None))],
)
def test_a_size_is_read_alike_everywhere(
    run: TableFiles, text: str, same: tuple[float, float | None]
) -> None:
    figure = figure_of(run, quantity="motor_torque", size=text, where="pretension = 100 N")
    width, height = 25.4 * figure.get_size_inches()
    wanted_width, wanted_height = same
    assert width == pytest.approx(wanted_width)
    if wanted_height is not None:
        assert height == pytest.approx(wanted_height)
    study = study_of({"figure": [{"name": "a", "quantity": "motor_torque", "size": text}]})
    assert study.figure[0].size == text
