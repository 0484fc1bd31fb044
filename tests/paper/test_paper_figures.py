"""The paper's figures draw the tables, mark what the paper says and name it legibly."""

import itertools

import numpy as np
import pytest

from tendon_cli.figures.draw import pages_of
from tendon_cli.tables.read import open_table
from tests.figures.runs import lines
from verification.paper.reproduce import finisher
from verification.paper.runs import STUDIES


@pytest.fixture(scope="module")
def pages(paper):
    """Draw the one page of each figure of the paper, finished as in the ledger."""
    drawn = {}
    for name in STUDIES:
        (figure,) = paper[name].study.figure
        table = open_table(paper[name].folder / f"{figure.table}.parquet")
        (page,) = pages_of(table, figure, finisher(paper[name]))
        drawn[name] = page.figure
    return drawn


def legend_texts(page):
    """Return the texts of all legends."""
    return [text.get_text() for legend in page.legends for text in legend.get_texts()]


# --- The paper's figures --------------------------------------------------------------------------


def test_fig_4_shows_the_ratio_and_where_it_passes_one(pages):
    (axes,) = pages["fig04"].axes
    (line,) = lines(axes)
    assert line.get_ydata()[-1] == pytest.approx(1.835, abs=5e-4)
    texts = [text.get_text() for text in axes.texts]
    assert texts == ["1 at 25.7°", "1.835 at 90°"]


def test_fig_6_has_a_panel_per_load_with_both_torques_in_both_directions(pages, paper):
    panels = pages["fig06"].axes
    titles = ["(a) 0 kg load", "(b) 3 kg load", "(c) 5 kg load", "(d) 10 kg load"]
    assert [axes.get_title() for axes in panels] == titles
    assert all(len(lines(axes)) == 4 for axes in panels)
    elbow, _, motor_flexion, motor_extension = lines(panels[2])
    run = paper["fig06"]
    drawn_and_computed = [
        (elbow, run.line("elbow_torque", load_mass=5.0)),
        (motor_flexion, run.line("motor_torque", load_mass=5.0)),
        (motor_extension, run.line("motor_torque", "extension", load_mass=5.0)),
    ]
    for line, torque in drawn_and_computed:
        np.testing.assert_allclose(line.get_ydata(), torque)
    assert motor_flexion.get_linestyle() == "-"
    assert motor_extension.get_linestyle() == "--"
    assert motor_flexion.get_color() == motor_extension.get_color() != elbow.get_color()
    assert panels[0].get_ylabel() == "torque (N m)"
    assert any("9.2°" in text.get_text() for text in panels[3].texts)


@pytest.mark.parametrize(("name", "end"), [("fig07", "distal"), ("fig08", "proximal")])
def test_figs_7_and_8_show_the_front_and_the_back_of_the_arm(pages, paper, name, end):
    run = paper[name]
    page = pages[name]
    sides = [("flexor", "front"), ("extensor", "back")]
    for axes, (side, of_arm) in zip(page.axes, sides, strict=True):
        assert axes.get_title().startswith(f"{of_arm} of the arm")
        curves = iter(lines(axes))
        for mass in run.loads:
            for direction, dash in (("flexion", "-"), ("extension", "--")):
                tension = run.line(f"{side}_tension_{end}", direction, load_mass=mass)
                curve = next(curves)
                np.testing.assert_allclose(curve.get_ydata(), tension)
                assert curve.get_linestyle() == dash
    assert page.axes[0].get_ylabel() == "tension (N)"
    loads = {f"{mass:g} kg load" for mass in run.loads}
    assert loads | {"flexion, filled", "extension, open"} <= set(legend_texts(page))


VARIED = {
    "fig07": "load_mass",
    "fig08": "load_mass",
    "fig09": "load_mass",
    "fig10": "spring_stiffness",
    "fig11": "spool_ratio",
}


@pytest.mark.parametrize("name", VARIED)
def test_what_lies_below_zero_is_slack_shaded_and_called_so(pages, paper, name):
    run = paper[name]
    end = "proximal" if name == "fig08" else "distal"
    for axes, side in zip(pages[name].axes, ("flexor", "extensor"), strict=True):
        (area,) = [patch for patch in axes.patches if patch.get_gid() == "slack area"]
        (word,) = [text for text in axes.texts if text.get_gid() == "slack word"]
        _, zero = axes.transData.transform((0.0, 0.0))
        assert area.get_window_extent().y1 == pytest.approx(zero)
        assert word.get_text() == "slack"
        assert axes.get_ylim()[0] < 0.0
        curves = iter(lines(axes))
        for value in run.values(VARIED[name]):
            for direction in ("flexion", "extension"):
                tension = run.line(f"{side}_tension_{end}", direction, **{VARIED[name]: value})
                drawn = next(curves).get_ydata()
                np.testing.assert_array_equal(np.sign(drawn), np.sign(tension))


@pytest.mark.parametrize("name", STUDIES)
def test_nothing_is_clipped_and_no_title_runs_into_another(pages, name):
    page = pages[name]
    page.draw_without_rendering()
    titles = [axes.title.get_window_extent() for axes in page.axes]
    boxes = list(titles)
    for axes in page.axes:
        texts = (axes.yaxis.label, axes.xaxis.label, *axes.texts)
        boxes += [text.get_window_extent() for text in texts]
    boxes += [legend.get_window_extent() for legend in page.legends]
    for box in boxes:
        assert box.x0 >= page.bbox.x0 - 0.5
        assert box.x1 <= page.bbox.x1 + 0.5
        assert box.y0 >= page.bbox.y0 - 0.5
        assert box.y1 <= page.bbox.y1 + 0.5
    for title, neighbour in itertools.combinations(titles, 2):
        assert not title.overlaps(neighbour)
