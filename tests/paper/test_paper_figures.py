"""Figures that a study declares, told by their data: what is drawn and how it is named."""

import numpy as np
import pytest

from tendon_cli.figures.draw import pages_of
from tendon_cli.paper.reproduce import finisher
from tendon_cli.paper.runs import STUDIES
from tendon_cli.tables.read import open_table


@pytest.fixture(scope="module")
def pages(paper):
    """The one page of each figure of the paper, finished as the ledger has it."""

    def page(name):
        (figure,) = paper[name].study.figure
        table = open_table(paper[name].folder / f"{figure.table}.parquet")
        (drawn,) = pages_of(table, figure, finisher(paper[name]))
        return drawn.figure

    return {name: page(name) for name in STUDIES}


def curves(axes):
    return [line for line in axes.lines if line.get_gid() == "curve"]


def key(page):
    return [text.get_text() for legend in page.legends for text in legend.get_texts()]


# --- The paper's figures --------------------------------------------------------------------------


def test_fig_4_shows_the_ratio_and_where_it_passes_one(pages):
    (axes,) = pages["fig04"].axes
    (line,) = curves(axes)
    assert line.get_ydata()[-1] == pytest.approx(1.835, abs=5e-4)
    texts = [text.get_text() for text in axes.texts]
    assert texts == ["1 at 25.7°", "1.835 at 90°"]


def test_fig_6_has_a_panel_per_load_with_both_torques_in_both_directions(pages, paper):
    axes = pages["fig06"].axes
    assert [one.get_title() for one in axes] == [
        "(a) 0 kg load",
        "(b) 3 kg load",
        "(c) 5 kg load",
        "(d) 10 kg load",
    ]
    assert all(len(curves(one)) == 4 for one in axes)
    elbow, _, motor, back = curves(axes[2])
    run = paper["fig06"]
    np.testing.assert_allclose(elbow.get_ydata(), run.line("elbow_torque", load_mass=5.0))
    np.testing.assert_allclose(motor.get_ydata(), run.line("motor_torque", load_mass=5.0))
    np.testing.assert_allclose(
        back.get_ydata(), run.line("motor_torque", "extension", load_mass=5.0)
    )
    assert (motor.get_linestyle(), back.get_linestyle()) == ("-", "--")
    assert elbow.get_color() != motor.get_color() == back.get_color()
    assert axes[0].get_ylabel() == "torque (N m)"
    assert any("9.2°" in text.get_text() for text in axes[3].texts)


@pytest.mark.parametrize(("name", "end"), [("fig07", "distal"), ("fig08", "proximal")])
def test_figs_7_and_8_show_the_front_and_the_back_of_the_arm(pages, paper, name, end):
    run, page = paper[name], pages[name]
    for axes, muscle, side in zip(
        page.axes, ("flexor", "extensor"), ("front", "back"), strict=True
    ):
        assert axes.get_title().startswith(f"{side} of the arm")
        lines = iter(curves(axes))
        for mass in run.loads:
            for direction, dash in (("flexion", "-"), ("extension", "--")):
                line, wanted = (
                    next(lines),
                    run.line(f"{muscle}_tension_{end}", direction, load_mass=mass),
                )
                np.testing.assert_allclose(line.get_ydata(), wanted)
                assert line.get_linestyle() == dash
    assert page.axes[0].get_ylabel() == "tension (N)"
    assert {f"{mass:g} kg load" for mass in run.loads} | {
        "flexion, filled",
        "extension, open",
    } <= set(key(page))


VARIED = {
    "fig07": "load_mass",
    "fig08": "load_mass",
    "fig09": "load_mass",
    "fig10": "spring_stiffness",
    "fig11": "spool_ratio",
}


@pytest.mark.parametrize("name", VARIED)
def test_what_lies_below_zero_is_slack_shaded_and_called_so(pages, paper, name):
    run, end = paper[name], "proximal" if name == "fig08" else "distal"
    for axes, side in zip(pages[name].axes, ("flexor", "extensor"), strict=True):
        (area,) = [patch for patch in axes.patches if patch.get_gid() == "slack area"]
        (word,) = [text for text in axes.texts if text.get_gid() == "slack word"]
        assert area.get_window_extent().y1 == pytest.approx(axes.transData.transform((0.0, 0.0))[1])
        assert word.get_text() == "slack"
        assert axes.get_ylim()[0] < 0.0
        lines = iter(curves(axes))
        for value in run.values(VARIED[name]):
            for direction in ("flexion", "extension"):
                tension = run.line(f"{side}_tension_{end}", direction, **{VARIED[name]: value})
                np.testing.assert_array_equal(np.sign(next(lines).get_ydata()), np.sign(tension))


@pytest.mark.parametrize("name", STUDIES)
def test_nothing_is_clipped_and_no_title_runs_into_another(pages, name):
    page = pages[name]
    page.draw_without_rendering()
    whole = page.bbox
    boxes = [axes.title.get_window_extent() for axes in page.axes]
    texts = [
        text.get_window_extent()
        for axes in page.axes
        for text in (axes.yaxis.label, axes.xaxis.label, *axes.texts)
    ]
    for box in [*boxes, *texts, *(legend.get_window_extent() for legend in page.legends)]:
        assert box.x0 >= whole.x0 - 0.5
        assert box.x1 <= whole.x1 + 0.5
        assert box.y0 >= whole.y0 - 0.5
        assert box.y1 <= whole.y1 + 0.5
    assert not any(one.overlaps(other) for at, one in enumerate(boxes) for other in boxes[:at])
