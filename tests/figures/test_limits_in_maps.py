"""Every limit of a study is in its slack map, or the figure says that it leaves nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.contour import ContourSet

from tendon_cli.cube.cube import cube_of
from tendon_cli.figures.draw import draw_run
from tendon_cli.figures.maps import limit_text
from tendon_cli.model.limits import LIMITS
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.figures import figure_spec
from tendon_cli.tables.read import TableFiles
from tests.figures.runs import by_gid, designs, figure_of, grid, panels, study_of, sweep, words

STUDY: dict[str, Any] = {
    "arm": {"contact_width": "40 mm"},
    "motion": {"elbow_angle": grid("0 deg", "90 deg", 7), "speed": "60 deg/s"},
    "load": {"mass": ["2 kg"]},
    "spring": {"free_length": "73 mm"},
    "tendon": {"pretension": grid("150 N", "270 N", 6)},
    "spool": {"flexor_radius": grid("20 mm", "60 mm", 5)},
}
"""A study in which every limit differs between the designs."""


def with_limit(study: Mapping[str, Any], name: str, bound: float) -> dict[str, Any]:
    """Return a study with one limit, SI."""
    text = f"{float(bound)!r} {QUANTITIES[LIMITS[name].column].unit}"
    is_number = QUANTITIES[LIMITS[name].column].unit == "1"
    return {**study, "limits": {name: float(bound) if is_number else text}}


def values_of(run: TableFiles, name: str) -> np.ndarray:
    """Return what a limit bounds in each design, SI, as a limit sees it."""
    values = np.array(run.read([LIMITS[name].column])[LIMITS[name].column], dtype=float)
    return np.abs(values) if LIMITS[name].in_magnitude else values


def bounds(run: TableFiles, name: str) -> tuple[float, float, float]:
    """Return a bound that some designs keep, one that none keeps, and one that all keep."""
    values = np.sort(values_of(run, name))
    span = np.ptp(values)
    assert span > 0.0, name
    below = float(values[0] - 0.1 * min(span, values[0]) if values[0] > 0.0 else values[0] - span)
    middle = float((values[len(values) // 2] + values[len(values) // 2 - 1]) / 2.0)
    if middle in values:
        middle = float((values[0] + values[-1]) / 2.0)
    above = float(values[-1] + 0.1 * span)
    return (middle, above, below) if LIMITS[name].from_below else (middle, below, above)


@pytest.fixture(scope="module")
def free(tmp_path_factory: pytest.TempPathFactory) -> TableFiles:
    """Return the designs of the study without a limit."""
    return designs(tmp_path_factory.mktemp("limits") / "run", STUDY)


def said(figure: Any) -> str:
    """Return every text of a figure on one line."""
    return " ".join(words(figure).split())


def keys(figure: Any) -> list[str]:
    """Return the texts of the key of a figure."""
    return [text.get_text().replace("\n", " ") for text in figure.legends[0].get_texts()]


def with_limits(study: Mapping[str, Any], bounds: Mapping[str, float]) -> dict[str, Any]:
    """Return a study with several limits, SI."""
    limits = [with_limit(study, name, bound)["limits"] for name, bound in bounds.items()]
    return {**study, "limits": {name: text for limit in limits for name, text in limit.items()}}


def test_every_limit_is_drawn_or_said_to_leave_nothing(free: TableFiles, tmp_path: Path) -> None:
    faults = []
    for place, kind in enumerate(("some", "none", "every")):
        content = with_limits(STUDY, {name: bounds(free, name)[place] for name in LIMITS})
        run = designs(tmp_path / kind, content)
        figure = figure_of(run)
        (axes,) = panels(figure)
        start, _, rest = said(figure).partition("design keeps")
        assert start.endswith({"some": "", "none": "No ", "every": "Every "}[kind]), kind
        assert bool(rest) == (kind != "some")
        for name in LIMITS:
            text = limit_text(cube_of(run), figure_spec(), name)
            mark = "unstable" if name == "min_elbow_stiffness" else name
            if kind == "some":
                is_right = by_gid(axes, mark) and text in keys(figure)
            else:
                is_right = text in rest and (kind == "none" or not by_gid(axes, mark))
            if not is_right:
                faults.append(f"{name}, which {kind} of the designs keep")
    assert not faults


def test_room_is_negative_just_where_a_limit_makes_a_design_infeasible(
    free: TableFiles, tmp_path: Path
) -> None:
    for name in LIMITS:
        run = designs(tmp_path / name, with_limit(STUDY, name, bounds(free, name)[0]))
        cube = cube_of(run)
        rows = np.arange(run.rows)
        truths = cube.gather(rows, ["taut", "stable", "feasible"])
        within = np.ones(run.rows, dtype=np.bool_)
        for limit in cube.limits:
            within &= ~(cube.room(limit, rows) < 0.0)
        assert 0 < (cube.room(name, rows) < 0.0).sum() < run.rows
        np.testing.assert_array_equal(truths["feasible"] == 1.0, (truths["taut"] == 1.0) & within)


def test_limits_are_marked_on_lines_of_the_margin(free: TableFiles, tmp_path: Path) -> None:
    one_spool = {**STUDY, "spool": {"flexor_radius": "30 mm"}}
    content = {
        **one_spool,
        "limits": {"max_tension": "300 N", "peak_motor_speed": "1 deg/s", "max_pretension": "1 kN"},
    }
    run = designs(tmp_path / "run", content)
    figure = figure_of(run)
    (axes,) = panels(figure)
    is_broken = np.array(run.read(["max_tension"])["max_tension"], dtype=float) > 300.0
    assert 0 < is_broken.sum() < run.rows
    (marks,) = by_gid(axes, "max tension ≤ 300 N")
    marked = marks.get_xdata()[np.isfinite(marks.get_ydata())]
    pretensions = np.linspace(150.0, 270.0, 6)
    assert set(pretensions[is_broken]) == {*pretensions} & {*marked.tolist()}
    assert "breaks max tension ≤ 300 N" in keys(figure)
    assert "No design keeps peak motor speed ≤ 1 deg/s." in said(figure)
    assert "Every design keeps pretension ≤ 1,000 N." in said(figure)


def test_a_run_whose_only_limit_leaves_nothing_says_so(tmp_path: Path) -> None:
    """Nothing of such a limit was in the map: no line, no shade, no key."""
    content = with_limit(STUDY, "peak_motor_speed", 0.02)
    folder = sweep(tmp_path / "run", {**content, "output": {"tables": ["designs"]}})
    figure = figure_of(designs(tmp_path / "again", content))
    assert "No design keeps peak motor speed ≤" in said(figure)
    assert draw_run(study_of(content), folder)[0] == ["slack_map.png"]


def test_what_leaves_nothing_at_one_load_or_in_one_case_is_named(tmp_path: Path) -> None:
    loads = {**STUDY, "load": {"mass": ["1 kg", "10 kg"]}, "limits": {"peak_motor_torque": "4 N m"}}
    figure = figure_of(designs(tmp_path / "loads", loads))
    assert "At 10 kg load, no design keeps peak motor torque ≤ 4 N m" in said(figure)
    cases = {
        "cases": [
            {"name": "thick", "tendon": {"diameter": "3 mm"}},
            {"name": "thin", "tendon": {"diameter": "1 mm"}},
        ],
        "tendon": STUDY["tendon"],
        "limits": {"min_spool_to_tendon": 50.0},
    }
    figure = figure_of(designs(tmp_path / "cases", cases))
    assert "inside breaks min spool to tendon ≥ 50" in keys(figure)
    (outline,) = by_gid(panels(figure)[0], "min_spool_to_tendon")
    (path,) = outline.get_paths()
    ends = path.vertices[:, 1]  # around the upper of two rows, of the first case
    assert (ends.min(), ends.max()) == (0.5, 1.5)


def test_a_limit_on_pretension_holds_for_the_larger_of_two(tmp_path: Path) -> None:
    tendon = {
        "flexor": {"pretension": grid("100 N", "200 N", 5)},
        "extensor": {"pretension": grid("120 N", "240 N", 4)},
    }
    content = {"tendon": tendon, "limits": {"max_pretension": "170 N"}}
    run = designs(tmp_path / "run", content)
    cube = cube_of(run)
    larger = np.maximum.outer(np.linspace(100.0, 200.0, 5), np.linspace(120.0, 240.0, 4)).ravel()
    room = cube.room("max_pretension", np.arange(run.rows))
    np.testing.assert_allclose(room, 170.0 - larger, rtol=1e-12)
    assert by_gid(panels(figure_of(run))[0], "max_pretension")


# --- Lines and their key --------------------------------------------------------------------------

MAPS: dict[str, dict[str, Any]] = {
    "uneven": {
        "spring": {"stiffness": grid("3 kN/m", "5 kN/m", 2)},
        "spool": {"ratio": grid("0.6", "0.8", 4)},
        "tendon": {"pretension": grid("100 N", "350 N", 6)},
        "load": {"mass": ["0 kg", "5 kg"]},
    },
    "unstable alone": {
        "spring": {"stiffness": grid("3 kN/m", "5 kN/m", 2)},
        "spool": {"ratio": grid("0.6", "0.7", 2)},
        "tendon": {"pretension": "150 N"},
    },
    "without equilibrium": {
        "arm": {"a1": grid("10 mm", "80 mm", 8), "b1": grid("60 mm", "250 mm", 9)},
        "motion": {"elbow_angle": grid("0 deg", "170 deg", 18)},
        "tendon": {"pretension": ["90 N", "150 N"]},
    },
    "many limits": {
        **STUDY,
        "load": {"mass": ["0 kg", "5 kg"]},
        "limits": {
            "min_elbow_stiffness": "1 N m/rad",
            "max_tension": "300 N",
            "max_pretension": "200 N",
            "peak_motor_torque": "8 N m",
            "peak_motor_speed": "3 rad/s",
            "peak_motor_power": "6 W",
            "max_spring_extension": "40 mm",
        },
    },
}
"""Studies whose maps have lines in some panels and none in others, or hatches without a line."""

Style = tuple[str, float]
"""Colour and width, pt."""


def lines_of(axes: Any) -> Iterator[tuple[str, Style]]:
    """Yield the name and the style of each line in a panel of a map."""
    for line in axes.lines:
        yield str(line.get_gid()), (to_hex(line.get_color()), line.get_linewidth())
    for lines in axes.collections:
        is_line = isinstance(lines, LineCollection | ContourSet) and not getattr(
            lines, "filled", False
        )
        if is_line and any(len(path.vertices) for path in lines.get_paths()):
            (colour,) = {to_hex(each) for each in lines.get_edgecolor()}
            yield str(lines.get_gid()), (colour, float(lines.get_linewidth()[0]))


@pytest.mark.parametrize("name", MAPS)
def test_the_key_has_every_line_that_is_drawn_and_no_other(name: str, tmp_path: Path) -> None:
    figure = figure_of(designs(tmp_path / "run", MAPS[name]))
    styles: dict[str, set[Style]] = {}
    for axes in panels(figure):
        for gid, style in lines_of(axes):
            styles.setdefault(gid, set()).add(style)
    assert styles
    assert all(len(of_limit) == 1 for of_limit in styles.values())  # alike in each panel
    drawn = sorted(style for of_limit in styles.values() for style in of_limit)
    entries = [
        (to_hex(handle.get_color()), handle.get_linewidth())
        for handle in figure.legends[0].legend_handles
        if hasattr(handle, "get_color")
    ]
    assert drawn == sorted(entries)
    assert len({colour for colour, _ in drawn}) == min(len(drawn), 7)


@pytest.mark.parametrize("name", ["uneven", "unstable alone"])
def test_what_is_hatched_ends_at_a_line_or_at_the_edge_of_the_panel(
    name: str, tmp_path: Path
) -> None:
    kinds = set()  # (is hatched, has a line) of each panel
    for axes in panels(figure_of(designs(tmp_path / "run", MAPS[name]))):
        areas = by_gid(axes, "unstable")
        has_line = "min_elbow_stiffness" in dict(lines_of(axes))
        kinds.add((bool(areas), has_line))
        if areas and not has_line:
            (mesh,) = by_gid(axes, "value")
            assert len(areas[0].get_paths()) == mesh.get_array().size  # every cell
        assert areas or not has_line
    assert (True, True) in kinds
