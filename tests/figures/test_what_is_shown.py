"""A figure says what it shows: what it was drawn with, what is slack, unstable or out of limits, and whose it is."""

from __future__ import annotations

import re
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from PIL import Image

from tendon_cli.errors import UsageError
from tendon_cli.figures.draw import plot, table_of
from tendon_cli.figures.style import load_colours
from tendon_cli.studies.figures import figure_spec
from tests.figures.runs import (
    LOADS,
    by_gid,
    designs,
    figure_of,
    grid,
    lines,
    panels,
    states,
    study_of,
    sweep,
    table,
    words,
)

PRETENSION = {"pretension": grid("20 N", "260 N", 13)}
RATIO = {"ratio": grid("0.5", "1.2", 8)}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    motion = {"elbow_angle": grid("0 deg", "90 deg", 31)}
    content = {
        "tendon": {"pretension": ["100 N", "200 N"]},
        "load": {"mass": LOADS},
        "motion": motion,
    }
    return sweep(tmp_path_factory.mktemp("display") / "run", content)


def rows_of(folder: Path, **equal: Any) -> Any:
    read = table(folder, "states").read().to_pandas()
    for name, value in equal.items():
        read = read[read[name] == value]
    return read


# --- Captions and metadata ------------------------------------------------------------------------


def test_filters_and_what_is_common_stand_in_the_caption(run: Path) -> None:
    figure = figure_of(
        table(run, "states"),
        quantity="motor_torque",
        where=["load_mass = 5 kg", "pretension = 200 N"],
    )
    (notes,) = by_gid(figure, "notes")
    assert "Only where load_mass = 5 kg and pretension = 200 N." in notes.get_text()
    assert "At F₀ = 200 N, K = 3 kN/m, η = 1, 5 kg load, μ = 0.07, φ = 180 deg." in notes.get_text()
    other = figure_of(
        table(run, "states"),
        quantity="motor_torque",
        panels="pretension",
        where="direction = flexion",
    )
    assert "At flexion, K = 3 kN/m, η = 1, μ = 0.07, φ = 180 deg." in words(other)
    assert "--" not in words(figure) + words(other)


def test_sides_that_differ_are_named(tmp_path: Path) -> None:
    content = {
        "tendon": {"pretension": "100 N", "extensor": {"pretension": "80 N"}},
        "spool": RATIO,
    }
    of = designs(tmp_path / "run", content)
    figure = figure_of(of)
    assert "F₀ = 100 N (flexor), F₀ = 80 N (extensor)" in words(figure)
    assert panels(figure)[0].get_ylabel() == "common margin of both pretensions (N)"
    assert "F₀*" not in words(figure)
    # What the caption says of it: lowered together by their margin, the sides are at the edge of slack.
    margin = of.read(["margin"])["margin"][0].as_py()
    lowered = {"pretension": 100.0 - margin, "extensor": {"pretension": 80.0 - margin}}
    edge = designs(tmp_path / "edge", {"tendon": lowered, "spool": {"ratio": [0.5]}})
    assert edge.read(["margin"])["margin"][0].as_py() == pytest.approx(0.0, abs=1e-9)


def test_every_format_knows_its_study(run: Path, tmp_path: Path) -> None:
    of = table(run, "states")
    spec = figure_spec(
        quantity="flexor_tension_proximal",
        where="load_mass = 5 kg",
        size="column",
        format=["png", "svg", "pdf"],
    )
    png, svg, pdf = plot(of, spec, tmp_path)
    with Image.open(png) as image:
        told: list[Any] = [image.info, svg.read_text(encoding="utf-8"), pdf.read_bytes()]
    assert told[0]["Title"] == "test"
    assert "Only where load_mass = 5 kg." in told[0]["Description"]
    assert told[0]["Source"] == f"tendon study test {of.facts['study_hash']}"
    assert f"tendon study test {of.facts['study_hash']}" in told[1]
    assert of.facts["study_hash"].encode() in told[2] + b"".join(
        zlib.decompress(found)
        for found in re.findall(rb"stream\r?\n(x.*?)\r?\nendstream", told[2], re.DOTALL)
    )
    assert "elbow angle θ (deg)" in told[1]  # text, which can be searched and edited
    assert "<text" in told[1]


def test_a_key_too_long_for_a_small_figure_is_broken(tmp_path: Path) -> None:
    figure = figure_of(
        designs(tmp_path / "run", {"tendon": PRETENSION, "spool": RATIO}), size="60 x 70 mm"
    )
    figure.draw_without_rendering()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert figure.bbox.x0 <= box.x0
    assert box.x1 <= figure.bbox.x1
    (notes,) = by_gid(figure, "notes")
    assert notes.get_window_extent().y1 <= box.y0 + 1.0


# --- Slack and instability in curves --------------------------------------------------------------


def test_unstable_stretches_are_marked_where_the_stiffness_is_negative(run: Path) -> None:
    figure = figure_of(
        table(run, "states"),
        quantity="motor_torque",
        where=["load_mass = 0 kg", "pretension = 200 N"],
    )
    (axes,) = panels(figure)
    rows = rows_of(run, load_mass=0.0, pretension=200.0, direction="flexion")
    unstable = (rows.elbow_stiffness < 0.0).to_numpy()
    assert 0 < unstable.sum() < len(unstable)
    marked = lines(axes, "unstable")[0]
    np.testing.assert_array_equal(np.isfinite(marked.get_ydata())[::2], unstable)
    np.testing.assert_allclose(marked.get_ydata()[::2][unstable], rows.motor_torque[unstable])
    assert "unstable elbow" in words(figure)
    calm = figure_of(
        table(run, "states"),
        quantity="motor_torque",
        where=["load_mass = 10 kg", "pretension = 100 N"],
    )
    assert not lines(panels(calm)[0], "unstable")
    assert "unstable" not in words(calm)


def test_kinks_stand_where_a_tendon_goes_slack_on_either_side_s_lines(run: Path) -> None:
    rows = rows_of(run, load_mass=10.0, pretension=200.0, direction="flexion")
    slack = (rows.status != "taut").to_numpy()
    degrees = np.degrees(rows.elbow_angle.to_numpy())
    at = np.flatnonzero(np.diff(slack.astype(int)))
    assert len(at) == 1
    chosen = {"where": ["load_mass = 10 kg", "pretension = 200 N", "direction = flexion"]}
    for quantity in ("flexor_tension_distal", "extensor_tension_distal", "motor_torque"):
        (axes,) = panels(figure_of(table(run, "states"), quantity=quantity, **chosen))
        (kink,) = lines(axes, "kink")
        np.testing.assert_allclose(kink.get_xdata(), (degrees[at] + degrees[at + 1]) / 2.0)


def test_bilateral_lines_have_no_kink_and_are_shaded_below_zero_others_the_other_way_round(
    tmp_path: Path,
) -> None:
    content = {"model": {"slack": "bilateral"}, "load": {"mass": ["10 kg"]}}
    for model, is_shaded in ((content, True), ({"load": content["load"]}, False)):
        folder = tmp_path / str(is_shaded)
        (axes,) = panels(figure_of(states(folder, model), quantity="extensor_tension_distal"))
        assert bool(by_gid(axes, "slack area")) == bool(by_gid(axes, "slack word")) == is_shaded
        assert bool(lines(axes, "kink")) != is_shaded


def test_open_and_filled_markers_are_in_the_key(run: Path) -> None:
    figure = figure_of(table(run, "states"), quantity="motor_torque", where="pretension = 100 N")
    key = dict(
        zip(
            [text.get_text() for text in figure.legends[0].get_texts()],
            figure.legends[0].legend_handles,
            strict=True,
        )
    )
    assert to_hex(key["extension, open"].get_markerfacecolor()) == "#ffffff"
    assert to_hex(key["flexion, filled"].get_markerfacecolor()) == "#000000"
    for line in lines(panels(figure)[0], "curve"):
        is_open = to_hex(line.get_markerfacecolor()) == "#ffffff"
        assert is_open == line.get_label().endswith("extension")


def test_a_load_has_its_colour_in_every_figure(run: Path) -> None:
    def colours(figure: Any) -> dict[str, str]:
        return {
            line.get_label(): to_hex(line.get_color()) for line in lines(panels(figure)[0], "curve")
        }

    every = colours(
        figure_of(table(run, "states"), quantity="motor_torque", where="pretension = 100 N")
    )
    where = ["pretension = 100 N", "load_mass in 3 kg, 10 kg"]
    some = colours(figure_of(table(run, "states"), quantity="elbow_torque", where=where))
    assert len(some) == 4
    assert some.items() <= every.items()
    assert len({to_hex(colour) for colour in load_colours(np.array([5.0, 5.1, 5.2]))}) == 3


def test_quantities_of_another_size_have_their_own_axis(run: Path) -> None:
    for names, alike in (
        (("flexor_tendon_stretch", "flexor_spring_stretch"), False),
        (("flexor_tension_distal", "extensor_tension_distal"), True),
    ):
        first, second = panels(
            figure_of(table(run, "states"), quantity=names, where="pretension = 100 N")
        )
        sizes = [
            max(np.nanmax(np.abs(line.get_ydata())) for line in lines(axes))
            for axes in (first, second)
        ]
        assert (max(sizes) < 5.0 * min(sizes)) == (first.get_ylim() == second.get_ylim()) == alike
        assert bool(second.get_ylabel()) != alike


def test_panels_that_repeat_are_drawn_once(run: Path, tmp_path: Path) -> None:
    once = figure_of(table(run, "states"), quantity="flexor_moment_arm", panels="pretension")
    assert len(panels(once)) == 1
    assert "The same picture for F₀ = 100 N, F₀ = 200 N." in words(once)
    content = {
        "tendon": PRETENSION,
        "spool": {"ratio": [0.7, 1.0], "flexor_radius": ["30 mm", "40 mm"]},
    }
    maps = figure_of(designs(tmp_path / "run", content))
    assert len(panels(maps)) == 1
    assert "The same picture for $R_{f}$ = 30 mm, $R_{f}$ = 40 mm." in words(maps)


# --- Maps -----------------------------------------------------------------------------------------


def test_a_map_hatches_just_the_unstable_designs(tmp_path: Path) -> None:
    of = designs(
        tmp_path / "run",
        {"tendon": PRETENSION, "spool": RATIO, "load": {"mass": ["0 kg", "10 kg"]}},
    )
    figure = figure_of(of)
    stable = np.array(of.read(["stable"])["stable"]).reshape(13, 8, 2)
    assert 0 < stable[..., 0].sum() < stable[..., 0].size
    assert stable[..., 1].all()
    light, heavy = panels(figure)
    (area,) = by_gid(light, "unstable")
    paths = area.get_paths()
    for at, force in enumerate(np.linspace(20.0, 260.0, 13)):
        for level, ratio in enumerate(np.linspace(0.5, 1.2, 8)):
            inside = any(path.contains_point((force, ratio)) for path in paths)
            assert inside != stable[at, level, 0]
    assert not by_gid(heavy, "unstable")
    assert "unstable: elbow stiffness below 0 N m/rad at some angle" in words(figure)


def test_each_limit_has_its_line_and_its_name(tmp_path: Path) -> None:
    limits = {"max_tension": "300 N", "peak_motor_torque": "8 N m", "max_pretension": "203 N"}
    content = {
        "tendon": {"pretension": grid("20 N", "260 N", 25)},
        "spool": RATIO,
        "limits": limits,
    }
    of = designs(tmp_path / "run", {**content, "load": {"mass": ["5 kg"]}})
    figure = figure_of(of)
    (axes,) = panels(figure)
    for words_ in ("max tension ≤ 300 N", "peak motor torque ≤ 8 N m", "pretension ≤ 203 N"):
        assert words_ in words(figure)
    read = of.read(["max_tension"]).to_pandas().max_tension.to_numpy().reshape(25, 8)
    forces = np.linspace(20.0, 260.0, 25)
    for gid, wanted in (
        ("max_tension", [np.interp(300.0, read[:, level], forces) for level in range(8)]),
        ("max_pretension", [203.0] * 8),
    ):
        (line,) = by_gid(axes, gid)
        vertices = np.concatenate([path.vertices for path in line.get_paths()])
        for ratio, force in zip(np.linspace(0.5, 1.2, 8), wanted, strict=True):
            at = vertices[np.isclose(vertices[:, 1], ratio)]
            assert np.abs(at[:, 0] - force).min() < 1e-6 * 260.0


def test_truths_are_filtered_by_their_word(tmp_path: Path) -> None:
    of = designs(tmp_path / "run", {"tendon": PRETENSION})
    stable = np.array(of.read(["stable"])["stable"])
    assert 0 < stable.sum() < stable.size
    for text, kept in (("stable = true", True), ("stable = false", False), ("stable != 1", False)):
        figure = figure_of(of, quantity="margin", where=text)
        (line,) = lines(panels(figure)[0], "curve")
        np.testing.assert_array_equal(np.isfinite(line.get_ydata()), stable == kept)
        assert "no value" in words(figure)
    with pytest.raises(UsageError, match="no order"):
        figure_of(of, quantity="margin", where="stable > 0")


# --- Asking ---------------------------------------------------------------------------------------


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
    run: Path, text: str, same: tuple[float, float | None]
) -> None:
    figure = figure_of(
        table(run, "states"), quantity="motor_torque", size=text, where="pretension = 100 N"
    )
    width, height = 25.4 * figure.get_size_inches()
    assert (width, height) == (pytest.approx(same[0]), pytest.approx(same[1] or height))
    assert (
        study_of({"figure": [{"name": "a", "quantity": "motor_torque", "size": text}]})
        .figure[0]
        .size
        == text
    )
