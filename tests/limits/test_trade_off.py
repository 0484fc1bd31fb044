"""The trade-off of a limit: the best choice with each of its values, as numbers and a picture."""

import json

import numpy as np
import pytest
from matplotlib.text import Text

import tendon_cli as tendon
from tendon_cli import say
from tendon_cli.cube.cube import cube_in
from tendon_cli.errors import UsageError
from tendon_cli.figures.answer_figures import draw_over
from tendon_cli.figures.windows import draw_trade_off
from tendon_cli.verbs.answer_record import as_answer
from tests.answers import solved

MOTORS = ["10 N m", "11 N m", "12 N m", "16 N m"]
STUDY = {
    "name": "motors",
    "spring": {"stiffness": ["3 kN/m", "5 kN/m", "8 kN/m"]},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "10 kg"]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 5}},
}
WITH_GOALS = {
    **STUDY,
    "design": {"minimise": ["max_tension"], "maximise": ["tolerance_length"]},
}
ROWS = [
    {"name": "M10", "limits.peak_motor_torque": "10 N m"},
    {"name": "M12", "limits.peak_motor_torque": "12 N m"},
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the folder of an answer with four limits on the motor's torque."""
    folder = tmp_path_factory.mktemp("trade_off") / "answer"
    tendon.design({**STUDY, "limits": {"peak_motor_torque": MOTORS}}, folder)
    return folder


@pytest.fixture(scope="module")
def answer(folder):
    """Return that answer."""
    return tendon.open(folder)


@pytest.fixture(scope="module")
def answer_with_goals():
    """Return the answer to the same question with two goals, which a stiff spring parts."""
    return tendon.design({**WITH_GOALS, "limits": {"peak_motor_torque": MOTORS}})


@pytest.fixture(scope="module")
def trade_off(answer):
    """Return its trade-off."""
    (record,) = answer.record["trade_offs"]
    return record


def test_the_best_with_a_limit_is_the_one_that_the_study_with_it_names_first(trade_off):
    assert trade_off["key"] == "limits.peak_motor_torque"
    assert trade_off["values"] == [10.0, 11.0, 12.0, 16.0]
    assert trade_off["best"][0] is None
    for limit, best in zip(MOTORS[1:3], trade_off["best"][1:3], strict=True):
        alone = tendon.design({**STUDY, "limits": {"peak_motor_torque": limit}})
        named = alone.record["best"]
        for name in ("spring_stiffness", "pretension_from", "pretension_to", "pretension"):
            assert best[name] == pytest.approx(named[name], rel=1e-9)


def test_with_several_goals_the_best_with_a_limit_is_the_compromise_of_the_study_with_it(
    answer_with_goals,
):
    (record,) = answer_with_goals.record["trade_offs"]
    named = set()
    for limit, best in zip(MOTORS[1:], record["best"][1:], strict=True):
        alone = tendon.design({**WITH_GOALS, "limits": {"peak_motor_torque": limit}})
        for name in ("spring_stiffness", "pretension_from", "pretension_to", "pretension"):
            assert best[name] == pytest.approx(alone.record["best"][name], rel=1e-9)
        named.add(best["spring_stiffness"])
    assert named & {5e3}  # neither the best by one goal nor that by the other


def test_the_legend_has_a_star_only_if_it_is_drawn(answer, trade_off):
    cube = cube_in(answer, "choices")
    between = {**answer.record["best"], "choice": answer.record["choices"]}
    for best, is_drawn in ((answer.record["best"], True), (between, False)):
        record = {**answer.record, "best": best}
        (of_limit,) = as_answer(record).trade_offs
        page = draw_trade_off(cube, as_answer(record), of_limit, of_limit.column)
        stars = [line for axes in page.figure.axes for line in axes.lines]
        assert any(line.get_marker() == "*" for line in stars) == is_drawn
        texts = " ".join(text.get_text() for text in page.figure.findobj(Text))
        assert "would be named first if the limit had this value alone" in " ".join(texts.split())
        labels = [text.get_text() for key in page.figure.legends for text in key.get_texts()]
        assert any("named first among all" in label for label in labels) == is_drawn


def test_no_best_window_is_narrower_with_a_looser_limit(trade_off):
    """The widest window grows; the choice named first has enough of it."""
    found = [best["tolerance_length"] for best in trade_off["best"] if best is not None]
    needed = 0.006
    assert (np.diff(np.minimum(found, needed)) >= -1e-12).all()


def test_a_question_without_such_a_limit_has_no_trade_off():
    answer = tendon.design({**STUDY, "limits": {"peak_motor_torque": "12 N m"}})
    assert answer.record["trade_offs"] == []
    assert "buys" not in answer.text


def test_the_best_choices_with_each_value_of_a_limit_stand_side_by_side(answer, trade_off):
    lines = answer.text.splitlines()
    start = lines.index("What each limit buys: limits.peak_motor_torque")
    said = next(line.split() for line in lines[start:] if line.split()[:1] == ["max_tension"])
    tensions = [best["max_tension"] for best in trade_off["best"] if best is not None]
    assert said[1] == "N"
    assert {say.number(tension) for tension in tensions} >= set(said[2:])


def test_the_picture_has_a_bar_for_each_window(answer, folder, trade_off):
    cube = cube_in(answer, "choices")
    (of_limit,) = as_answer(answer.record).trade_offs
    page = draw_trade_off(cube, as_answer(answer.record), of_limit, of_limit.column)
    upper, lower = page.figure.axes
    (bars,) = [drawn for drawn in upper.collections if drawn.get_gid() == "windows"]
    best = [choice for choice in trade_off["best"] if choice is not None]
    drawn = sorted((low, high) for (_, low), (_, high) in bars.get_segments())
    expected = sorted((choice["pretension_from"], choice["pretension_to"]) for choice in best)
    np.testing.assert_allclose(drawn, expected)
    tensions = np.concatenate(
        [line.get_ydata() for line in lower.lines if line.get_marker() == "o"]
    )
    known = np.unique(tensions[~np.isnan(tensions)])
    assert {*known} == {choice["max_tension"] for choice in best}


def test_plot_draws_it_on_any_size_and_says_what_else_it_could_draw(tendon, folder, workplace):
    done = tendon("plot", str(folder), "-x", "limits.peak_motor_torque", "--size", "column")
    assert done.exit == 0
    assert (workplace / "motors-peak_motor_torque.png").exists()
    done = tendon("plot", str(folder), "-x", "spring.stiffness")
    assert done.exit == 2
    assert "limits.peak_motor_torque" in done.err
    done = tendon("plot", str(folder), "-x", "limits.max_tension", "--json")
    assert done.exit == 2
    assert "limits.peak_motor_torque" in json.loads(done.out)["error"]["hint"]


def test_rows_that_set_a_limit_are_named_where_they_stand(tmp_path):
    study = {**STUDY, "table": [{"name": "motor", "rows": ROWS}]}
    answer = tendon.design(study, tmp_path / "answer")
    cube = cube_in(answer, "choices")
    draw_over(cube, answer.record, "motor", None, tmp_path / "by_name.png")
    (record,) = as_answer(answer.record).trade_offs
    page = draw_trade_off(cube, as_answer(answer.record), record, "limit_peak_motor_torque")
    _, lower = page.figure.axes
    named = [text.get_text() for text in lower.get_xticklabels()]
    assert named == ["10 N m (M10)", "12 N m (M12)"]
    with pytest.raises(UsageError, match="no trade-off along"):
        draw_over(cube, answer.record, "spring_stiffness", None, None)


def test_rows_that_set_more_than_a_limit_have_a_trade_off_too():
    """A spring of a catalogue has a stiffness, and a limit on how far it may be stretched."""
    springs = [
        {"name": "S3", "spring.stiffness": "3 kN/m", "limits.max_spring_extension": "110 mm"},
        {"name": "S5", "spring.stiffness": "5 kN/m", "limits.max_spring_extension": "70 mm"},
        {"name": "S8", "spring.stiffness": "8 kN/m", "limits.max_spring_extension": "20 mm"},
    ]
    suit = {key: value for key, value in STUDY.items() if key != "spring"}
    suit["spool"] = {"ratio": [0.5, 0.6]}
    answer = tendon.design({**suit, "table": [{"name": "springs", "rows": springs}]})
    (trade_off,) = answer.record["trade_offs"]
    assert trade_off["values"] == ["S3", "S5", "S8"]
    for row, best in zip(springs, trade_off["best"], strict=True):
        alone = {
            **suit,
            "spring": {"stiffness": row["spring.stiffness"]},
            "limits": {"max_spring_extension": row["limits.max_spring_extension"]},
        }
        assert (best is not None) == solved(alone).feasible.any()
        if best is not None:
            named = tendon.design(alone).record["best"]
            for name in ("spool_ratio", "pretension_from", "pretension_to", "pretension"):
                assert best[name] == pytest.approx(named[name], rel=1e-9)
    assert any(trade_off["best"])
    assert not all(trade_off["best"])


def test_the_table_has_the_windows_that_a_second_sample_gave_the_trade_off():
    sample = {"uncertainty": {"draws": 8, "usual": False}, "design": {"verify": 64}}
    study = STUDY | sample | {"limits": {"peak_motor_torque": MOTORS}}
    answer = tendon.design(study | {"sheath": {"friction": "0.07 +/- 0.01"}})
    (limit,) = answer.record["trade_offs"]
    told = [best for best in limit["best"] if best is not None]
    rows = answer.choices.iloc[[best["choice"] for best in told]]
    for name in ("set_flexor_tension", "pretension", "pretension_from", "max_tension"):
        np.testing.assert_allclose(rows[name], [best[name] for best in told], rtol=1e-12)
