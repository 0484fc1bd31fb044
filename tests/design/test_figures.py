"""The figures of an answer show what its table says, and nothing makes them fail."""

import shutil

import numpy as np
import pytest
from matplotlib.text import Text

import tendon_cli as tendon
from tendon_cli import say
from tendon_cli.cube.cube import choices_of
from tendon_cli.figures.answer_figures import answer_figure, draw_answer
from tendon_cli.figures.choice_maps import Slice
from tendon_cli.tables.read import open_table

from .studies import NO_UPPER_END

LOADS = {"load": {"mass": ["0 kg", "10 kg"]}}
SPRINGS = {"spring": {"stiffness": ["8 kN/m", "3 kN/m", "5 kN/m"]}}
SPOOLS = {"spool": {"ratio": [0.6, 1.0]}}
NO_STIFFNESS = {"limits": {"min_elbow_stiffness": -1e3}}
THIN = {"limits": {"min_spool_to_tendon": 30, "max_tension": "300 N"}}
CASES = {
    "cases": [
        {"name": "short", "arm": {"b1": "120 mm"}},
        {"name": "lo$ng", "arm": {"b1": "180 mm"}},
    ]
}
AS_CHOICE = {"design": {"conditions": ["load.mass"]}}
GOALS = {"design": {"minimise": ["max_tension"], "maximise": ["tolerance"]}}


def drawn(content, folder):
    """Return an answer with figures and their names."""
    answer = tendon.design(tendon.study({**LOADS, **content}), folder / "out", figures=True)
    notes = answer.record["notes"]
    assert not [note for note in notes if "cannot be drawn" in note], notes
    return answer, {name.removesuffix(".png") for name in answer.record["figures"]}


@pytest.mark.parametrize(
    ("content", "figures"),
    [
        ({}, set()),
        (SPRINGS, {"window"}),
        ({**SPRINGS, **SPOOLS}, {"window", "tolerance_map"}),
        ({**SPRINGS, **SPOOLS, **GOALS}, {"window", "tolerance_map", "front"}),
        ({**SPRINGS, **SPOOLS, **NO_STIFFNESS}, {"window", "tolerance_map"}),
        ({**SPRINGS, **SPOOLS, **THIN}, {"window", "tolerance_map"}),
        ({**SPRINGS, **CASES, **AS_CHOICE}, {"window", "tolerance_map"}),
    ],
)
def test_every_answer_has_the_figures_that_its_axes_allow(content, figures, tmp_path):
    answer, names = drawn(content, tmp_path)
    assert names == figures
    out = tmp_path / "out"
    assert {file.stem for file in out.glob("*.png")} == figures
    again = tmp_path / "again"
    again.mkdir()
    shutil.copy(out / "choices.parquet", again)
    draw_answer(answer.study, again, again, answer.record)
    for name in names:
        assert (again / f"{name}.png").read_bytes() == (out / f"{name}.png").read_bytes()


def test_a_map_outlines_what_can_be_set_and_says_to_what_the_best_is_set(tmp_path):
    answer, _ = drawn({**SPRINGS, **SPOOLS}, tmp_path)
    choices = answer.choices
    enough = choices[choices["tolerance_length"] >= 6e-3]
    assert len(enough) == 1 < choices["feasible"].sum()
    cube = choices_of(open_table(tmp_path / "out" / "choices.parquet"))
    page = answer_figure("tolerance_map", cube, answer.record)
    panel = page.figure.axes[0]
    (outline,) = [line for line in panel.lines if line.get_gid() == "settable"]
    springs, spools = Slice.of(cube, cube.axes, choices.iloc[0].to_dict()).scales
    for scale, column, factor, coordinates in (
        (springs, "spring_stiffness", 1e-3, outline.get_xdata()),
        (spools, "spool_ratio", 1.0, outline.get_ydata()),
    ):
        place = int(np.flatnonzero(scale.places == factor * enough[column].item())[0])
        ends = [np.nanmin(coordinates), np.nanmax(coordinates)]
        np.testing.assert_allclose(ends, np.sort(scale.edges[place : place + 2]))
    texts = [text.get_text() for text in page.figure.findobj(Text)]
    pretension = say.number(answer.record["best"]["pretension"])
    assert any(f": F₀ = {pretension} N" in text for text in texts)
    assert sum("mm (" in text for text in texts) == choices["feasible"].sum()


def test_a_map_never_says_a_share_where_a_window_has_no_upper_end(tmp_path):
    drawn({**SPRINGS, **SPOOLS, "joint": NO_UPPER_END}, tmp_path)
    record = tendon.open(tmp_path / "out").record
    cube = choices_of(open_table(tmp_path / "out" / "choices.parquet"))
    page = answer_figure("tolerance_map", cube, record)
    texts = [text.get_text() for text in page.figure.findobj(Text)]
    assert sum("no upper end" in text for text in texts) >= 6
    assert not any("%" in text for text in texts)


TOLERANCE_GOALS = {"design": {"minimise": ["max_tension"], "maximise": ["tolerance_length"]}}


def test_a_front_without_an_upper_end_is_not_drawn_empty(tmp_path):
    content = {**SPRINGS, **SPOOLS, **TOLERANCE_GOALS, "joint": NO_UPPER_END}
    answer, names = drawn(content, tmp_path)
    assert [choice["tolerance_length"] for choice in answer.record["front"]] == [None]
    assert "front" not in names


def test_choices_of_the_front_without_an_upper_end_are_counted(tmp_path):
    answer, names = drawn({**SPRINGS, **SPOOLS, **TOLERANCE_GOALS}, tmp_path)
    assert "front" in names
    front = answer.record["front"]
    best = answer.record["best"]
    others = [choice for choice in front if choice["choice"] != best["choice"]]
    assert others
    cube = choices_of(open_table(tmp_path / "out" / "choices.parquet"))
    for endless, has_star in ((others[0], True), (best, False)):
        open_ended = {**endless, "tolerance_length": None}
        rows = [open_ended if row["choice"] == endless["choice"] else row for row in front]
        record = {**answer.record, "front": rows}
        if not has_star:
            record["best"] = open_ended
        page = answer_figure("front", cube, record)
        texts = [text.get_text() for text in page.figure.findobj(Text)]
        assert any("1 choice of the front whose window has no upper end" in text for text in texts)
        (panel,) = page.figure.axes
        markers = [line.get_marker() for line in panel.lines if np.isfinite(line.get_xdata()).any()]
        assert ("*" in markers) == has_star
        assert any("best compromise" in text for text in texts) == has_star


def test_both_maps_of_choices_are_darker_where_there_is_more(tmp_path):
    people = {"people": {"count": 60}, "design": {"serve": 0.9}}
    answer, names = drawn({**SPRINGS, **SPOOLS, **people}, tmp_path)
    assert {"tolerance_map", "served_map"} <= names
    cube = choices_of(open_table(tmp_path / "out" / "choices.parquet"))
    for name in ("tolerance_map", "served_map"):
        panel = answer_figure(name, cube, answer.record).figure.axes[0]
        mesh = next(drawn for drawn in panel.collections if drawn.get_array().max() > 0.0)
        colours = mesh.to_rgba(np.sort(mesh.get_array().compressed()))
        assert (np.diff(colours[:, :3].sum(axis=1)) <= 0.0).all()


def test_a_slice_has_every_choice_at_its_place(tmp_path):
    answer, _ = drawn({**SPRINGS, **SPOOLS}, tmp_path)
    cube = choices_of(open_table(tmp_path / "out" / "choices.parquet"))
    plane = Slice.of(cube, cube.axes, answer.choices.iloc[0].to_dict())
    springs, spools = plane.scales
    np.testing.assert_array_equal(springs.places, [3.0, 5.0, 8.0])
    np.testing.assert_array_equal(spools.places, [0.6, 1.0])
    for row in answer.choices.itertuples():
        column = int(np.flatnonzero(springs.places == row.spring_stiffness / 1e3)[0])
        line = int(np.flatnonzero(spools.places == row.spool_ratio)[0])
        assert plane.low[line, column] == row.pretension_from
        np.testing.assert_equal(plane.columns["tolerance"][line, column], row.tolerance)
        assert (plane.conflicts[line, column] == "") == row.feasible
    assert set(plane.conflicts.ravel()) == {"", "slack and stability conflict"}


def test_a_caption_has_no_pretension_of_designs_which_an_answer_does_not_use(tmp_path):
    pretensions = {"tendon": {"pretension": ["20 N", "200 N"]}}
    answer, _ = drawn({**SPRINGS, **SPOOLS, **pretensions}, tmp_path)
    cube = choices_of(answer.kept("choices"), answer.study)
    page = answer_figure("tolerance_map", cube, answer.record)
    texts = [text.get_text() for text in page.figure.findobj(Text)]
    assert not any("200 N" in text for text in texts)
