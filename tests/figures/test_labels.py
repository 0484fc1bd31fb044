"""No label is cut off or runs into another, whatever the size of a figure."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text

from tendon_cli import design
from tendon_cli.cube.cube import cube_of
from tendon_cli.figures.answer_figures import answer_figure
from tendon_cli.figures.backend import FigureCanvasAgg
from tendon_cli.figures.frame import fitted, framed, text_width
from tendon_cli.figures.style import house_style
from tendon_cli.tables.read import TableFiles, open_table
from tests.figures.runs import (
    EXACT,
    LOADS,
    by_gid,
    designs,
    figure_of,
    figures_of,
    grid,
    panels,
    study_of,
    words,
)

SIZES = ("page", "column", "96 mm")


def drawn(figure: Any) -> Any:
    """Draw a figure once and return the function that gives the box of an artist, pixels."""
    canvas = FigureCanvasAgg(figure)
    with house_style():
        figure.draw_without_rendering()
    renderer = canvas.get_renderer()
    return lambda artist: artist.get_window_extent(renderer)


def assert_ticks_apart(figure: Any) -> None:
    """Assert that the labels of ticks next to each other do not overlap."""
    box = drawn(figure)
    for axes in panels(figure):
        for labels in (axes.get_xticklabels(), axes.get_yticklabels()):
            boxes = [box(label) for label in labels if label.get_text() and label.get_visible()]
            inside = [each for each in boxes if axes.bbox.padded(60.0).overlaps(each)]
            for one, other in itertools.pairwise(inside):
                assert not one.overlaps(other)


def assert_labels_whole(figure: Any) -> None:
    """Assert that labels of axes lie on the page and do not touch those of other panels."""
    box = drawn(figure)
    page = figure.bbox
    boxes = [box(axes.yaxis.label) for axes in panels(figure) if axes.yaxis.get_visible()]
    for each in boxes:
        assert page.x0 <= each.x0
        assert page.y0 <= each.y0
        assert each.y1 <= page.y1
    for place, each in enumerate(boxes):
        assert not any(each.overlaps(other) for other in boxes[place + 1 :])


@pytest.fixture(scope="module")
def close(tmp_path_factory: pytest.TempPathFactory) -> TableFiles:
    """Return designs over values whose texts are long and lie close together."""
    content = {
        "sheath": {"friction": [0.05, 0.075, 0.1, 0.11]},
        "spring": {"stiffness": ["1 kN/m", "1.15 kN/m", "1.25 kN/m", "4 kN/m"]},
        "load": {"mass": [*LOADS, "12 kg"]},
    }
    return designs(tmp_path_factory.mktemp("close") / "run", content)


@pytest.fixture(scope="module")
def read_at_joint(tmp_path_factory: pytest.TempPathFactory) -> TableFiles:
    """Return designs whose setting has a long name, with every column there is."""
    content = {
        "motion": {"elbow_angle": grid("0 deg", "90 deg", 5), "speed": "60 deg/s"},
        "spring": {"stiffness": ["1 kN/m", "4 kN/m"]},
        "setting": {"read": "flexor at joint"},
        "tendon": {"pretension": grid("20 N", "70 N", 6)},
        "load": {"mass": LOADS},
    }
    return designs(tmp_path_factory.mktemp("joint") / "run", content)


@pytest.mark.parametrize("size", SIZES)
def test_labels_of_ticks_are_apart_in_maps(
    close: TableFiles, read_at_joint: TableFiles, size: str
) -> None:
    for run in (close, read_at_joint):
        for figure in figures_of(run, size=size):
            assert_ticks_apart(figure)
            assert_labels_whole(figure)


def test_labels_of_ticks_are_apart_in_curves(close: TableFiles) -> None:
    for x in ("friction", "peak_motor_torque"):
        figure = figure_of(close, size="column", quantity="margin", x=x)
        assert_ticks_apart(figure)


@pytest.mark.parametrize("size", ["column", "60 mm"])
def test_the_label_of_y_is_whole_for_every_column(read_at_joint: TableFiles, size: str) -> None:
    for name in ("margin", "peak_motor_torque", "min_elbow_stiffness", "unstable_fraction"):
        more = {"panels": "load.mass", "where": "spring_stiffness = 1 kN/m"}
        assert_labels_whole(figure_of(read_at_joint, quantity=name, size=size, **more))


def test_names_are_apart_in_a_narrow_figure(tmp_path: Path) -> None:
    cases = [
        {"name": f"a rather long name {place}", "arm": {"forearm_mass": f"{1 + place} kg"}}
        for place in range(9)
    ]
    run = designs(tmp_path / "run", {"cases": cases})
    assert_ticks_apart(figure_of(run, size="column"))


def test_a_label_is_broken_to_its_room() -> None:
    label = "tension in the flexor at the joint $F_{set}$ (N m)"
    assert fitted(label, 120.0) == label
    for room in (45.0, 30.0, 18.0):
        text = fitted(label, room)
        assert text.replace("\n", " ") == label
        assert text.endswith("(N m)"), "a unit is whole"
        assert all(text_width(line, 8.0) <= room for line in text.split("\n"))
    assert all(text_width(line, 8.0) <= 20.0 for line in fitted("M" * 60, 20.0).split("\n"))


def test_no_line_of_a_caption_ends_within_an_equation() -> None:
    note = "At " + ", ".join(f"b₁ = {100 + place} mm" for place in range(20)) + ", k = 3 N m/rad."
    for width in range(60, 180, 7):
        lines = words(framed("t", 50.0, notes=[note], width=float(width)).figure).splitlines()
        assert len(lines) > 3
        assert not any(line.endswith((" =", "₁", "N", "0")) for line in lines)


GRIDS: dict[str, tuple[Any, Any]] = {
    "few": (grid("0.5 kN/m", "4 kN/m", 5), grid("20 mm", "40 mm", 3)),
    "low rows": (grid("0.5 kN/m", "4 kN/m", 3), grid("20 mm", "40 mm", 20)),
    "narrow columns": (grid("0.5 kN/m", "4 kN/m", 20), grid("20 mm", "40 mm", 2)),
    "listed": (["1 kN/m", "2 kN/m", "4 kN/m"], ["20 mm", "24 mm", "30 mm", "31 mm", "40 mm"]),
}
"""Springs and radii of the choices of an answer."""


@pytest.mark.parametrize("name", GRIDS)
def test_the_star_of_a_map_is_at_its_values_and_covers_no_text(name: str, tmp_path: Path) -> None:
    springs, radii = GRIDS[name]
    content = {
        "spring": {"stiffness": springs},
        "spool": {"flexor_radius": radii},
        "load": {"mass": ["4 kg", "5 kg"]},
        "motion": {"elbow_angle": grid("0 deg", "90 deg", 7)},
        **EXACT,
    }
    answer = design(study_of(content), out=tmp_path / "out")
    cube = cube_of(open_table(tmp_path / "out" / "choices.parquet"), kinds=("choices",))
    page = answer_figure("tolerance_map", cube, answer.record)
    assert page is not None
    box = drawn(page.figure)
    axes = page.figure.axes[0]
    (star,) = by_gid(axes, "best")
    best = answer.record["best"]
    texts_of_ticks = []
    for axis, place in ((axes.xaxis, 0), (axes.yaxis, 1)):
        at = star.get_xydata()[0][place]
        is_listed = name == "listed"
        names = [label.get_text() for label in axis.get_ticklabels()]
        texts_of_ticks.append(float(names[round(at)]) if is_listed else at)
    values = (best["spring_stiffness"] / 1e3, best["spool_flexor_radius"] * 1e3)  # kN/m, mm
    by_column = dict(zip(("stiffness", "radius"), values, strict=True))
    labels = (axes.get_xlabel(), axes.get_ylabel())
    for label, value in zip(labels, texts_of_ticks, strict=True):
        wanted = by_column["stiffness" if "stiffness" in label else "radius"]
        assert value == pytest.approx(wanted, rel=1e-12)
    values = star.get_xydata()[0]
    middle = axes.transData.transform(values)
    half = star.get_markersize() / 2.0 * page.figure.dpi / 72.0
    texts = by_gid(axes, "text")
    for one, other in itertools.combinations(filter(Text.get_text, texts), 2):
        assert not box(one).overlaps(box(other))
    for text in texts:
        extent = box(text)
        apart = np.maximum(extent.min - (middle + half), (middle - half) - extent.max)
        assert apart.max() > 0.0 or not text.get_text()
