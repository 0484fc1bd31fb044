"""Figures that a study declares: what they may show, what is refused, and what stays untouched."""

import tomllib

import jsonschema
import numpy as np
import pytest

from tendon_cli import quantities
from tendon_cli.cube.columns import DERIVED
from tendon_cli.cube.cube import cube_of
from tendon_cli.errors import StudyError
from tendon_cli.figures.draw import check_figures_of, draw_run, pages_of
from tendon_cli.studies.figures import OF_DESIGNS, OF_STATES
from tendon_cli.studies.load import load_study, study_from
from tendon_cli.studies.study import Study
from tests.figures.runs import grid, lines, states, study_of, sweep, table
from verification.paper.runs import FOLDER, STUDIES, load

MOTION = {"elbow_angle": grid("0 deg", "90 deg", 7)}
SMALL = {"load": {"mass": ["0 kg", "5 kg"]}, "motion": MOTION}


# --- Derived quantities ---------------------------------------------------------------------------


def test_an_elongation_is_what_the_tension_of_its_side_makes_of_the_compliance(tmp_path):
    content = {
        **SMALL,
        "spring": {"flexor": {"stiffness": "2 kN/m"}},
        "tendon": {"extensor": {"pretension": "150 N"}},
        "model": {"slack": "bilateral"},
    }
    cube = cube_of(states(tmp_path / "run", content))
    names = (
        "spring_elongation",
        "elongation",
        "length_change",
        "tension_distal",
        "tendon_stretch",
        "spring_stretch",
    )
    for side, stiffness, pretension in (("flexor", 2000.0, 100.0), ("extensor", 3000.0, 150.0)):
        columns = [f"{side}_{name}" for name in names]
        read = cube.gather(np.arange(cube.table.rows), columns)
        spring, total, change, tension, *stretches = (read[name] for name in columns)
        np.testing.assert_allclose(spring, tension / stiffness)
        # The change is from the pretensioned state, the total from no load:
        # the two differ by what pretension alone does.
        np.testing.assert_allclose(change, sum(stretches), atol=1e-15)
        np.testing.assert_allclose((total - change) / pretension, total / tension, rtol=1e-9)
        assert (np.abs(total) > np.abs(spring)).all()


def test_the_ratio_is_null_where_the_extensor_has_not_travelled(tmp_path):
    cube = cube_of(states(tmp_path / "run", SMALL))
    read = cube.gather(np.arange(cube.table.rows), ["radius_ratio", "elbow_angle"])
    np.testing.assert_array_equal(np.isnan(read["radius_ratio"]), read["elbow_angle"] == 0.0)


def test_what_a_figure_may_show_is_what_the_tables_have():
    assert set(OF_STATES) - set(DERIVED) == set(quantities.OF_STATES)
    assert set(OF_DESIGNS) == {*quantities.OF_DESIGNS, *quantities.OF_CYCLES}


# --- Declaring ------------------------------------------------------------------------------------


def figure(name="a", quantity="motor_torque", **more):
    """Return a figure as a study declares it."""
    return {"name": name, "quantity": quantity, **more}


def test_figures_stand_next_to_the_tables_and_change_neither_these_nor_the_hash(tmp_path):
    figures = [
        figure("torque", format=["png", "svg"], size="column"),
        figure("need", "required_pretension", x="load_mass"),
    ]
    declared = study_of({**SMALL, "figure": figures})
    assert declared.hash == study_of(SMALL).hash
    assert "figure" not in declared.document()
    folder = sweep(tmp_path / "run", SMALL)
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    drawn, _, _ = draw_run(declared, folder)
    assert drawn == ["torque.png", "torque.svg", "need.png"]
    assert all((folder / name).stat().st_size for name in drawn)
    assert {name: (folder / name).read_bytes() for name in before} == before


def test_filters_choose_and_an_axis_of_one_value_plays_no_part(tmp_path):
    content = {**SMALL, "figure": [figure(colour="load.mass", where="load_mass = 5 kg")]}
    files = table(sweep(tmp_path / "run", SMALL), "states")
    (page,) = pages_of(files, study_of(content).figure[0])
    assert len(lines(page.figure.axes[0])) == 2
    (declared,) = study_of({**content, "load": {"mass": "5 kg"}}).figure
    assert declared.colour == "load.mass"


BILATERAL = {"model": {"slack": "bilateral"}}


@pytest.mark.parametrize(
    ("more", "spec", "key", "says"),
    [
        ({}, figure(quantity="margin"), "quantity", "not written"),
        ({}, figure(where="load_mass = 4 kg"), "where", "leaves no rows"),
        (BILATERAL, figure(quantity="flexor_slack"), "quantity", "null in every row"),
        ({"load": {}}, figure(quantity="max_tension"), "x", "no axis with several"),
        ({"spool": {"ratio": [0.7, 1.0]}}, figure(quantity="efficiency"), "quantity", "no column"),
        ({}, figure(colour="elbow_angle", panels="elbow_angle"), "", "two roles"),
    ],
)
def test_a_figure_that_cannot_be_drawn_is_a_fault_beforehand_and_a_warning_after(
    tmp_path, more, spec, key, says
):
    tables = ["states"] if spec["quantity"] == "margin" else ["designs", "states"]
    content = {**SMALL, "output": {"tables": tables}, **more}
    study = study_of({**content, "figure": [spec]})
    with pytest.raises(StudyError, match=says) as error:
        check_figures_of(study)
    place = f"figure.0.{key}" if key else "figure.0"
    assert [fault.key for fault in error.value.faults] == [place]
    files, warnings, _ = draw_run(study, sweep(tmp_path / "run", content))
    assert "a.png" not in files
    assert warnings[0].startswith('figure "a" is not drawn: ')


def test_what_can_be_drawn_is_no_fault():
    without_states = {"tables": ["designs"]}  # they are computed again to be drawn
    few_columns = {"states": ["status", "spool_angle"]}
    for output in (without_states, few_columns):
        check_figures_of(study_of({"output": output, "figure": [figure()]}))


FAULTY = """\
[[figure]]
name = "a b"
quantity = "motor_torqe"
size = "5 mm"
format = "jpg"
where = "1 = 2"
[[figure]]
name = "b"
quantity = []
overlay = "yes"
colr = "x"
[arm]
a1 = "-1 mm"
"""


def test_all_faults_of_all_figures_come_at_once_with_their_lines(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(FAULTY)
    with pytest.raises(StudyError) as error:
        load_study(path)
    expected = {
        ("figure.0.name", 2),
        ("figure.0.quantity", 3),
        ("figure.0.size", 4),
        ("figure.1.quantity", 9),
        ("figure.1.overlay", 10),
        ("figure.1.colr", 11),
        ("arm.a1", 13),
    }
    assert expected <= {(fault.key, fault.line) for fault in error.value.faults}
    assert 'did you mean "motor_torque"?' in str(error.value)


@pytest.mark.parametrize(
    ("spec", "says"),
    [
        (figure(colour="load_mas"), ("figure.0.colour", 'did you mean "load_mass"')),
        (figure(where="load_mass = 5 N"), ("figure.0.where", "5 N")),
        (figure(where="lod = 5 N"), ("figure.0.where", "no column")),
        (figure(quantity=["elbow_torque", "margin"]), ("figure.0.quantity", "one table")),
        (
            figure(quantity=["elbow_torque", "spool_angle"], overlay=True),
            ("figure.0.overlay", "angle and torque"),
        ),
        (figure(overlay=True, colour="load_mass"), ("figure.0.colour", "overlay")),
        (figure("slack_map"), ("figure.0.name", "slack_map")),
        (figure(quantity="margin", x="motor_torque"), ("figure.0.x", "no column")),
        (figure(x="x" * 100), ("figure.0.x", "no column")),
        (figure(x="x" * 101), ("figure.0.x", "at most 100 characters")),
        (figure(x="margin\n"), ("figure.0.x", "is not a name")),
    ],
)
def test_what_a_figure_cannot_be_is_refused(spec, says):
    with pytest.raises(StudyError) as error:
        study_of({"figure": [spec]})
    assert len(error.value.faults) == 1
    assert [part for part in says if part not in str(error.value)] == []
    with pytest.raises(StudyError, match="two"):
        study_of({"figure": [figure(), figure()]})


def test_the_schema_takes_the_paper_s_figures_and_no_others():
    check = jsonschema.Draft202012Validator(Study.model_json_schema())
    for name in STUDIES:
        content = tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))
        assert list(check.iter_errors(content)) == []
        assert study_from(content).figure == load(name).figure
    assert not check.is_valid({"figure": [{"name": "a", "quantity": "nothing"}]})
    assert not check.is_valid({"figure": [{"quantity": "margin"}]})
