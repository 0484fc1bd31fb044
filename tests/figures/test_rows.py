"""Figures of rows of a table show every row and mark only what was computed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex

import tendon_cli as tendon
from tendon_cli.figures.style import COLOUR_OF_LIMIT, OKABE_ITO, limit_colours
from tests.figures.runs import (
    EXACT,
    by_gid,
    covers,
    figure_of,
    grid,
    lines,
    panels,
    sweep,
    table,
    words,
)

ROWS = [
    {
        "name": "Heron",
        "spring.stiffness": "4.5 kN/m",
        "spool.ratio": 0.5909,
        "spool.flexor_radius": "22 mm",
        "tendon.pretension": "60 N",
    },
    {
        "name": "Ibis",
        "spring.stiffness": "6.5 kN/m",
        "spool.ratio": 0.6,
        "spool.flexor_radius": "25 mm",
        "tendon.pretension": "150 N",
    },
    {
        "name": "Kite",
        "spring.stiffness": "2 kN/m",
        "spool.ratio": 0.9,
        "spool.flexor_radius": "20 mm",
        "tendon.pretension": "140 N",
    },
]
MASSES = ["0 kg", "3 kg", "6 kg"]
STUDY = {
    "table": [{"name": "prototype", "rows": ROWS}],
    "load": {"mass": MASSES},
    "motion": {"elbow_angle": grid("0 deg", "90 deg", 19)},
}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a run of three prototypes under three loads."""
    return sweep(tmp_path_factory.mktemp("rows") / "run", STUDY)


def test_a_map_of_rows_has_every_margin_and_hatches_what_is_unstable(run: Path) -> None:
    designs = table(run, "designs")
    read = designs.read(["margin", "stable"])
    margins = np.array(read["margin"], dtype=np.float64).reshape(3, 3)  # (rows, loads), N
    unstable = np.array(read["stable"]).reshape(3, 3) == 0
    assert (margins < 0.0).any()
    assert (margins > 0.0).any()
    assert unstable.any()
    figure = figure_of(designs)
    (axes,) = panels(figure)
    names = [text.get_text() for text in axes.get_yticklabels()]
    assert names == ["Kite", "Ibis", "Heron"], "the first row of the table is the top one"
    for text in by_gid(axes, "text"):
        across, up = text.get_position()
        place = (2 - round(up), round(across))
        letter, _, number = text.get_text().partition(" ")
        assert float(number.replace("−", "-")) == pytest.approx(margins[place], rel=5e-3)
        wanted = "U" if unstable[place] else "F"
        assert letter == ("S" if margins[place] < 0.0 else wanted)
    (hatched,) = by_gid(axes, "unstable")
    for row, load in np.ndindex(3, 3):
        assert covers(hatched, load, 2 - row) == unstable[row, load]


def test_a_broken_limit_is_a_line_around_its_cells(tmp_path: Path) -> None:
    limited = {**STUDY, "limits": {"max_tension": "200 N"}}
    designs = table(sweep(tmp_path / "run", limited), "designs")
    most = np.array(designs.read(["max_tension"])["max_tension"]).reshape(3, 3)
    figure = figure_of(designs)
    (outline,) = by_gid(panels(figure)[0], "max_tension")
    for row, load in np.ndindex(3, 3):
        assert covers(outline, load, 2 - row) == (most[row, load] > 200.0)
    assert "inside breaks max tension ≤ 200 N" in words(figure)


def test_states_of_all_rows_are_drawn_side_by_side(run: Path) -> None:
    figure = figure_of(table(run, "states"))
    shown = panels(figure)
    for row in ROWS:
        assert sum(str(row["name"]) in axes.get_title() for axes in shown) == 3
    assert "evenly spaced" not in words(figure)
    assert by_gid(figure, "slack")


def test_a_figure_of_one_row_says_all_that_its_row_sets(run: Path) -> None:
    text = words(figure_of(table(run, "states"), where=["prototype = Ibis"]))
    for value in ("Ibis", "F₀ = 150 N", "K = 6.5 kN/m", "η = 0.6", "= 25 mm"):
        assert value in text


@pytest.mark.parametrize("quantity", ["min_elbow_stiffness", "peak_motor_torque"])
def test_between_few_points_nothing_is_said_to_be_slack_or_unstable(
    run: Path, quantity: str
) -> None:
    designs = table(run, "designs")
    read = designs.read(["taut", "stable"])
    figure = figure_of(designs, quantity=quantity, x="load_mass", colour="prototype")
    (axes,) = panels(figure)
    for gid, column in (("slack", "taut"), ("unstable", "stable")):
        marked = [x for line in lines(axes, gid) for x in line.get_xdata()]
        assert set(marked) <= {0.0, 3.0, 6.0}
        assert len(marked) == int((np.array(read[column]) == 0).sum()) > 0
        assert all(line.get_linestyle() == "None" for line in lines(axes, gid))
    assert "one goes slack" not in words(figure)


# --- Answers --------------------------------------------------------------------------------------


def _rows_figure(folder: Path, study: dict[str, Any]) -> Any:
    return tendon.design({"name": "rows", **STUDY, **EXACT, **study}, folder).plot("rows")


def _colours(figure: Any) -> dict[str, str]:
    (legend,) = figure.legends
    texts = [text.get_text() for text in legend.get_texts()]
    handles = legend.legend_handles
    colours = {}
    for text, handle in zip(texts, handles, strict=True):
        is_area = hasattr(handle, "get_facecolor")
        colours[text] = to_hex(handle.get_facecolor() if is_area else handle.get_color())
    return colours


def test_a_limit_has_one_colour_in_all_figures(tmp_path: Path) -> None:
    first = _colours(_rows_figure(tmp_path / "all", {}))
    good = {"table": [{"name": "prototype", "rows": ROWS[:2]}]}
    motor = {**good, "limits": {"peak_motor_torque": "4 N m"}}
    second = _colours(_rows_figure(tmp_path / "motor", motor))
    common = {text: colour for text, colour in first.items() if text in second}
    assert {"ends where: extensor slack", "ends where: elbow unstable"} <= first.keys()
    assert common
    assert all(second[text] == colour for text, colour in common.items())
    assert first["ends where: extensor slack"] == COLOUR_OF_LIMIT["extensor slack"]
    assert "no window: the lower limit is above" in first


def test_rows_beside_a_list_are_named_by_both(tmp_path: Path) -> None:
    beside = {
        "table": [{"name": "prototype", "rows": ROWS[:2]}],
        "sheath": {"friction": [0.05, 0.07]},
    }
    (panel,) = _rows_figure(tmp_path / "beside", beside).axes
    names = [label.get_text() for label in panel.get_xticklabels()]
    assert len(set(names)) == 4
    assert all(name.endswith(("0.05", "0.07")) for name in names)
    (star,) = [line for line in panel.get_lines() if line.get_marker() == "*"]
    assert 0 <= star.get_xdata()[0] < 4


def test_colours_of_limits_differ_whichever_are_drawn() -> None:
    others = ["peak_motor_power", "max_pretension", "min_spring_room"]
    for named in ([], ["extensor slack"], list(COLOUR_OF_LIMIT)[:5]):
        colours = limit_colours([*others, *named])
        assert len(set(colours.values())) == len(colours) <= len(OKABE_ITO)
        assert all(colours[name] == COLOUR_OF_LIMIT[name] for name in named)


def test_key_and_caption_of_rows_agree(tmp_path: Path) -> None:
    good = {"table": [{"name": "prototype", "rows": ROWS[:2]}]}
    answer = tendon.design({"name": "rows", **STUDY, **EXACT, **good}, tmp_path / "answer")
    text = words(answer.plot("rows"))
    assert "no window" not in text
    pretension = f"F₀ = {answer.record['best']['pretension']:.4g} N"
    assert text.count(pretension) == 1
    assert "all else from the table prototype, or by default" in text


def test_rows_without_load_do_not_squeeze_the_loop(tmp_path: Path) -> None:
    lines_of_log = ["time,position,load cell 1,load cell 2,direction"]
    time = 0.0
    for stroke in (None, 1, -1, 1, -1, None):
        for step in range(60):
            time += 0.05
            ripple = 0.05 * np.sin(7.0 * time)
            load = 0.01 + 0.01 * ripple if stroke is None else 49.0 + ripple
            motor = load * np.exp(0.0 if stroke is None else 0.25 * stroke)
            word = {None: "rest", 1: "pull", -1: "release"}[stroke]
            values = f"{time:.3f},{step * (stroke or 0)},{motor:.4f},{load:.4f}"
            lines_of_log.append(f"{values},{word}")
    (tmp_path / "log.csv").write_text("\n".join(lines_of_log), encoding="utf-8")
    fit = tendon.fit_friction(tmp_path / "log.csv", bend_angle="160 deg")
    of_strokes = fit.rows[fit.rows["run"] >= 0]
    assert fit.rows["motor"].min() < 1.0 < of_strokes["motor"].min()
    loop = next(axes for axes in panels(fit.plot()) if "Loop" in axes.get_title(loc="left"))
    low, high = loop.get_ylim()
    reach = float(np.ptp(of_strokes["motor"]))
    assert low > 1.0
    assert high - low < 1.5 * reach
