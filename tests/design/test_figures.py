"""The figures of an answer show what its table says, and nothing makes them fail."""

import re

import numpy as np
import pytest
from matplotlib.text import Text

from tendon_cli import say
from tendon_cli.cube.cube import cube_in
from tendon_cli.figures.answer_figures import FIGURES, answer_figure
from tendon_cli.figures.choice_maps import axes_of_choices, grid_of_choices
from tests.answers import answered

from .studies import NO_UPPER_END

LOADS = {
    "load": {"mass": ["0 kg", "10 kg"]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
}
SPRINGS = {"spring": {"stiffness": ["8 kN/m", "3 kN/m", "5 kN/m"]}}
SPOOLS = {"spool": {"ratio": [0.6, 1.0]}}
STIFF = {"spool": {"ratio": 0.6}}
SUITS = {**LOADS, **SPRINGS, **SPOOLS}
NO_STIFFNESS = {"limits": {"min_elbow_stiffness": -1e3}}
THIN = {"limits": {"min_spool_to_tendon": 30, "max_tension": "380 N"}}
CASES = {
    "cases": [
        {"name": "short", "arm": {"b1": "120 mm"}},
        {"name": "lo$ng", "arm": {"b1": "180 mm"}},
    ]
}
AS_CHOICE = {"design": {"conditions": ["load.mass"]}}
GOALS = {"design": {"minimise": ["max_tension"], "maximise": ["tolerance"]}}


def cube_of(answer):
    """Return the choices of an answer by their axes."""
    return cube_in(answer, "choices")


def drawn(answer, name, record=None):
    """Return a figure of an answer, and its texts."""
    figure = answer_figure(name, cube_of(answer), record or answer.record).figure
    return figure, [text.get_text() for text in figure.findobj(Text)]


@pytest.mark.parametrize(
    ("content", "figures"),
    [
        ({"spring": {"stiffness": "8 kN/m"}, "spool": {"ratio": 0.5}}, set()),
        ({**SPRINGS, **STIFF}, {"window"}),
        ({**SUITS, **NO_STIFFNESS}, {"window", "tolerance_map"}),
        ({**SUITS, **THIN}, {"window", "tolerance_map"}),
        ({**SUITS, **GOALS}, {"window", "tolerance_map", "front"}),
        ({**SPRINGS, **STIFF, **CASES, **AS_CHOICE}, {"window", "tolerance_map"}),
    ],
)
def test_every_answer_has_the_figures_that_its_axes_allow(content, figures):
    answer = answered({**LOADS, **content})
    cube = cube_of(answer)
    names = [name for name in FIGURES if name != "between"]
    assert {name for name in names if answer_figure(name, cube, answer.record)} == figures


def test_a_map_outlines_what_can_be_set_and_says_to_what_the_best_is_set():
    answer = answered(SUITS)
    choices = answer.choices
    enough = choices[choices["tolerance_length"] >= 6e-3]
    assert len(enough) == 1 < choices["feasible"].sum()
    figure, texts = drawn(answer, "tolerance_map")
    panel = figure.axes[0]
    (outline,) = panel.findobj(lambda artist: artist.get_gid() == "settable")
    ends = np.concatenate([path.vertices for path in outline.get_paths()])
    at = {}
    for column, axis in (("spring_stiffness", panel.xaxis), ("spool_ratio", panel.yaxis)):
        names = [label.get_text() for label in axis.get_ticklabels()]
        value = enough[column].item() * (1e-3 if column == "spring_stiffness" else 1.0)
        at[column] = names.index(say.number(value))
    middle = np.array([at["spring_stiffness"], at["spool_ratio"]])
    np.testing.assert_allclose(ends.min(axis=0), middle - 0.5)
    np.testing.assert_allclose(ends.max(axis=0), middle + 0.5)
    best = answer.record["best"]
    flexor = say.number(best["set_flexor_tension"])
    pretension = say.number(best["pretension"])
    in_order = re.compile(rf": {flexor} N in the flexor, .* \(F₀ = {pretension} N\)")
    assert any(in_order.search(text.replace("\n", " ")) for text in texts)
    assert sum("mm (" in text for text in texts) == choices["feasible"].sum()


def test_a_map_never_says_a_share_where_a_window_has_no_upper_end():
    _, texts = drawn(answered({**SUITS, "joint": NO_UPPER_END}), "tolerance_map")
    assert sum("no upper end" in text for text in texts) >= 6
    assert not any("%" in text for text in texts)


TOLERANCE_GOALS = {"design": {"minimise": ["max_tension"], "maximise": ["tolerance_length"]}}


def test_a_front_without_an_upper_end_is_not_drawn_empty():
    answer = answered({**SUITS, **TOLERANCE_GOALS, "joint": NO_UPPER_END})
    assert [choice["tolerance_length"] for choice in answer.record["front"]] == [None]
    assert answer_figure("front", cube_of(answer), answer.record) is None


def test_choices_of_the_front_without_an_upper_end_are_counted():
    answer = answered({**SUITS, **TOLERANCE_GOALS})
    front = answer.record["front"]
    best = answer.record["best"]
    others = [choice for choice in front if choice["choice"] != best["choice"]]
    assert others
    for endless, has_star in ((others[0], True), (best, False)):
        open_ended = {**endless, "tolerance_length": None}
        rows = [open_ended if row["choice"] == endless["choice"] else row for row in front]
        record = {**answer.record, "front": rows}
        if not has_star:
            record["best"] = open_ended
        figure, texts = drawn(answer, "front", record)
        assert any("1 choice of the front whose window has no upper end" in text for text in texts)
        (panel,) = figure.axes
        markers = [line.get_marker() for line in panel.lines if np.isfinite(line.get_xdata()).any()]
        assert ("*" in markers) == has_star
        assert any("best compromise" in text for text in texts) == has_star


def test_both_maps_of_choices_are_darker_where_there_is_more():
    answer = answered({**SUITS, "people": {"count": 20}, "design": {"serve": 0.7}})
    for name in ("tolerance_map", "served_map"):
        figure, _ = drawn(answer, name)
        panel = figure.axes[0]
        mesh = next(drawn for drawn in panel.collections if drawn.get_array().max() > 0.0)
        colours = mesh.to_rgba(np.sort(mesh.get_array().compressed()))
        assert (np.diff(colours[:, :3].sum(axis=1)) <= 0.0).all()


def test_a_map_has_every_choice_at_its_place_in_panels_for_the_other_axes():
    content = {**SUITS, "sheath": {"friction": [0.05, 0.07]}}
    answer = answered(content)
    cube = cube_of(answer)
    grid, read = grid_of_choices(cube, axes_of_choices(cube))
    assert (grid.x.names, grid.y.names) == (("3", "5", "8"), ("0.6", "1"))
    assert len(grid.titles) == 2
    choices = answer.choices
    for panel, friction in enumerate((0.05, 0.07)):
        assert f"{friction}" in grid.titles[panel]
        for (row, column), low in np.ndenumerate(read["pretension_from"][panel]):
            stiffness = 1e3 * float(grid.x.names[column])
            is_there = np.isclose(choices["spring_stiffness"], stiffness)
            is_there &= np.isclose(choices["spool_ratio"], float(grid.y.names[row]))
            is_there &= np.isclose(choices["friction"], friction)
            np.testing.assert_equal(low, choices["pretension_from"][is_there].item())


def test_a_caption_has_no_pretension_of_designs_which_an_answer_does_not_use():
    pretensions = {"tendon": {"pretension": ["20 N", "200 N"]}}
    _, texts = drawn(answered({**SUITS, **pretensions}), "tolerance_map")
    assert not any("200 N" in text for text in texts)
