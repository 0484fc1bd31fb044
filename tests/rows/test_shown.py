"""Rows in figures, on the page of a state and in a dry run: every row, and never joined."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import tendon_cli
from tendon_cli.cube.cube import cube_in
from tendon_cli.errors import UsageError
from tendon_cli.figures.answer_figures import answer_figure

ANGLES = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 3}}


def study(count, **more):
    rows = {
        "name": [f"S{at}" for at in range(count)],
        "spring.stiffness": np.linspace(2e3, 9e3, count),
        "spool.ratio": np.linspace(0.5, 0.8, count),
        "price (EUR)": [float(at % 7) for at in range(count)],
    }
    loads = {"mass": ["0 kg", "5 kg"]}
    table = {"name": "spring", "rows": rows}
    return tendon_cli.study({"table": [table], "motion": ANGLES, "load": loads, **more})


def figure(answer, name):
    cube = cube_in(answer, "choices")
    page = answer_figure(name, cube, answer.record)
    return None if page is None else page.figure


@pytest.fixture(scope="module")
def answer_of(tmp_path_factory):
    """Return a function that designs with so many rows, once for each number."""

    @cache
    def design(count):
        return tendon_cli.design(study(count), tmp_path_factory.mktemp("rows") / str(count))

    return design


@pytest.fixture(params=[7, 50])
def answer(request, answer_of):
    return answer_of(request.param)


def test_every_row_stands_in_the_figure_by_name_or_as_a_point(answer):
    panels = [axes for axes in figure(answer, "rows").axes if axes.get_visible()]
    count = len(answer.choices)
    if count <= 40:
        labels = [text.get_text() for text in panels[0].get_xticklabels()]
        assert labels == list(answer.choices.spring)
        return
    assert [axes.get_xlabel().split()[0] for axes in panels] == ["spring", "spool", "price"]
    for axes in panels:
        lines = [line for line in axes.lines if line.get_marker() == "o"]
        assert all(line.get_linestyle() == "None" for line in lines)
        assert sum(len(line.get_xdata()) for line in lines) == count


def test_points_stand_at_the_numbers_of_their_rows(answer_of):
    done = answer_of(50)
    first = figure(done, "rows").axes[0]
    lines = [line for line in first.lines if line.get_marker() == "o"]
    drawn = np.sort(np.concatenate([line.get_xdata() for line in lines]))
    assert np.allclose(drawn, np.linspace(2.0, 9.0, 50))
    width = np.concatenate([line.get_ydata() for line in lines])
    expected = done.choices.pretension_to - done.choices.pretension_from
    assert np.allclose(np.sort(width), np.sort(expected))


def test_a_front_of_parts_has_names_and_no_line(tmp_path):
    goals = {"minimise": ["price"], "maximise": ["tolerance_length"]}
    done = tendon_cli.design(study(7, design=goals), tmp_path / "front")
    axes = figure(done, "front").axes[0]
    texts = [text.get_text() for text in axes.texts]
    for row in done.front:
        assert any(text.startswith(f"{row['spring']}: ") for text in texts)
    assert all(line.get_linestyle() == "None" for line in axes.lines if len(line.get_xdata()) > 1)


def test_many_rows_of_a_sweep_are_points_over_each_number(tmp_path):
    tendon_cli.sweep(study(50), tmp_path / "run", figures=True)
    assert len(list((tmp_path / "run").glob("slack_map*.png"))) == 3


# --- One row, and the ends of a table -------------------------------------------------------------


def test_a_state_is_that_of_the_row_that_is_asked_for():
    several = study(7, sheath={"friction": 0.05})
    page = tendon_cli.state(several, rows={"spring": "S5"})
    numbers = several.row_tables[0].numbers
    alone = tendon_cli.study(
        {
            "spring": {"stiffness": float(numbers["spring.stiffness"][5])},
            "spool": {"ratio": float(numbers["spool.ratio"][5])},
            "motion": ANGLES,
            "load": {"mass": "0 kg"},
            "sheath": {"friction": 0.05},
        }
    )
    assert page.columns == tendon_cli.state(alone).columns


@pytest.mark.parametrize(
    ("rows", "problem"),
    [({"spring": "S9"}, 'no spring "S9"'), ({"sprin": "S1"}, 'no table "sprin"')],
)
def test_a_row_that_is_not_there_is_refused_with_the_nearest(rows, problem):
    with pytest.raises(UsageError, match=problem) as caught:
        tendon_cli.state(study(7), rows=rows)
    assert "did you mean" in caught.value.hint


@pytest.fixture
def springs(workplace):
    """Write a study of three springs and return the folder."""
    (workplace / "springs.csv").write_text("name,spring.stiffness (kN/m)\nA,2\nB,3\nC,9\n")
    (workplace / "study.toml").write_text('[[table]]\nname = "spring"\nfile = "springs.csv"\n')
    return workplace


@pytest.mark.parametrize("verb", ["sweep", "design"])
def test_a_dry_run_shows_the_first_and_the_last_row(springs, tendon, verb):
    ran = tendon(verb, "study.toml", "--dry-run")
    assert "spring A (K 2 kN/m) to spring C (K 9 kN/m)" in ran.out


def test_commands_take_a_row_by_its_table(springs, tendon):
    ran = tendon("state", "study.toml", "--row", "spring=C")
    assert ran.exit == 0
    assert "C (K 9 kN/m)" in ran.out
    assert tendon("state", "study.toml", "--row", "C").exit == 2
    assert tendon("state", "study.toml", "--row", "spring=A", "--row", "spring=B").exit == 2


def test_a_shell_completes_rows_and_tables(springs, completed):
    rows = completed("tendon state study.toml --row ")
    assert rows == ["spring=A", "spring=B", "spring=C"]
    assert completed("tendon export study.toml x.csv --table ") == ["spring"]


def test_faults_of_the_rows_are_faults_of_input(springs, tendon):
    (springs / "springs.csv").write_text("name,spring.stiffness (kN/m)\nA,two\nA,-3\n")
    ran = tendon("sweep", "study.toml", "--json")
    assert ran.exit == 3
    assert "springs.csv, line 2" in ran.out
    assert "springs.csv, line 3" in ran.out
