"""Figures that a study declares: what they may show, what is refused, and what they leave as it was."""

import shutil
import threading
import tomllib

import jsonschema
import numpy as np
import pytest

from tendon_cli import quantities
from tendon_cli.cube.columns import DERIVED
from tendon_cli.cube.cube import cube_of
from tendon_cli.errors import StudyError
from tendon_cli.figures.draw import check_figures_of, draw_run, pages_of
from tendon_cli.paper.runs import FOLDER, STUDIES, load, swept
from tendon_cli.studies.figures import OF_DESIGNS, OF_STATES
from tendon_cli.studies.load import load_study, study_from
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import open_table
from tests.figures.runs import lines

SMALL = """
[load]
mass = ["0 kg", "5 kg"]
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 7 }
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    area = tmp_path_factory.mktemp("declared")
    return dict(swept(("fig07", "fig10"), area, jobs=1, stop=threading.Event()))


# --- Derived quantities ----------------------------------------------------------------------------------------------


def derived(run, name, rows=None):
    cube = cube_of(open_table(run.folder / "states.parquet"))
    wanted = np.arange(len(run.states)) if rows is None else rows
    return cube.gather(wanted, (name,))[name]


def test_an_elongation_is_what_the_tension_makes_of_the_compliance(runs):
    run = runs["fig10"]
    states = run.states
    spring = states["flexor_tension_distal"] / states["spring_stiffness"]
    np.testing.assert_allclose(derived(run, "flexor_spring_elongation"), spring)
    total = derived(run, "flexor_elongation")
    # From the pretensioned state to here, and from no load to here: the two differ by what pretension alone stretches.
    change = derived(run, "flexor_length_change")
    np.testing.assert_allclose(change, states["flexor_tendon_stretch"] + states["flexor_spring_stretch"])
    at_pretension = (total - change) / states["pretension"]
    np.testing.assert_allclose(at_pretension, total / states["flexor_tension_distal"], rtol=1e-9)
    assert (np.abs(total) > np.abs(spring)).all()


def test_the_ratio_is_null_where_the_extensor_has_not_travelled(runs):
    run = runs["fig07"]
    ratio = derived(run, "radius_ratio")
    assert np.isnan(ratio[run.states["elbow_angle"] == 0.0]).all()
    assert np.isfinite(ratio[run.states["elbow_angle"] > 0.0]).all()


def test_the_side_counts_where_the_sides_differ(new_sweep, tmp_path):
    swept_ = new_sweep(
        SMALL + '[spring.flexor]\nstiffness = "2 kN/m"\n[tendon.extensor]\npretension = "150 N"\n', tmp_path
    )
    cube = cube_of(swept_.table("states"))
    names = ("flexor_spring_elongation", "extensor_spring_elongation", "extensor_elongation")
    read = cube.gather(np.arange(len(swept_.states)), names)
    states = swept_.states
    np.testing.assert_allclose(read["flexor_spring_elongation"], states["flexor_tension_distal"] / 2000.0)
    np.testing.assert_allclose(read["extensor_spring_elongation"], states["extensor_tension_distal"] / 3000.0)
    assert (read["extensor_elongation"] >= read["extensor_spring_elongation"]).all()


def test_what_a_figure_may_show_is_what_the_tables_have():
    assert set(OF_STATES) - set(DERIVED) == set(quantities.OF_STATES)
    assert set(OF_DESIGNS) == {*quantities.OF_DESIGNS, *quantities.OF_CYCLES}


# --- Declaring -------------------------------------------------------------------------------------------------------


def figure(text):
    return f"[[figure]]\n{text}\n"


def drawn(new_sweep, folder, text, **settings):
    run = new_sweep(SMALL + text, folder, **settings)
    return run, draw_run(load_study(folder / "study.toml"), run.folder)


def test_figures_change_neither_hash_nor_tables(new_sweep, tmp_path):
    plain, declared = tmp_path / "plain", tmp_path / "declared"
    plain.mkdir(), declared.mkdir()
    one = new_sweep(SMALL, plain)
    other = new_sweep(SMALL + figure('name = "a"\nquantity = "motor_torque"'), declared)
    assert one.hashes == other.hashes
    assert one.plan.study.hash == other.plan.study.hash
    assert "figure" not in other.plan.study.document()
    assert [each.name for each in other.plan.study.figure] == ["a"]


def test_every_format_of_every_figure_is_written_beside_the_tables(new_sweep, tmp_path):
    text = figure('name = "torque"\nquantity = "motor_torque"\nformat = ["png", "svg"]\nsize = "column"')
    text += figure('name = "need"\nquantity = "required_pretension"\nx = "load_mass"')
    run, files = drawn(new_sweep, tmp_path, text)
    assert [file.name for file in files.files] == ["torque.png", "torque.svg", "need.png"]
    assert all(file.parent == run.folder and file.stat().st_size for file in files.files)


def test_filters_choose_and_an_axis_of_one_value_plays_no_part(new_sweep, tmp_path):
    new_sweep(SMALL, tmp_path)
    text = figure('name = "a"\nquantity = "motor_torque"\ncolour = "load.mass"\nwhere = "load_mass = 5 kg"')
    (tmp_path / "study.toml").write_text(SMALL + text)
    (declared,) = load_study(tmp_path / "study.toml").figure
    (page,) = pages_of(open_table(tmp_path / "run" / "states.parquet"), declared)
    assert len(lines(page.figure.axes[0])) == 2
    (declared,) = load_study(tmp_path / "study.toml", ("load.mass=5 kg",)).figure
    assert declared.colour == "load.mass"


@pytest.mark.parametrize(
    ("text", "key", "says"),
    [
        ('[output]\ntables = ["states"]\n[[figure]]\nname = "a"\nquantity = "margin"\n', "quantity", "not written"),
        (figure('name = "a"\nquantity = "motor_torque"\nwhere = "load_mass = 4 kg"'), "where", "nothing is left by"),
    ],
)
def test_a_figure_that_cannot_be_drawn_is_a_fault_beforehand_and_a_warning_after(new_sweep, tmp_path, text, key, says):
    run, figures = drawn(new_sweep, tmp_path, text)
    assert not [file for file in figures.files if file.name == "a.png"]
    assert figures.warnings[0].startswith('figure "a" is not drawn: ')
    with pytest.raises(StudyError, match=says) as error:
        check_figures_of(run.plan.study)
    assert [fault.key for fault in error.value.faults] == [f"figure.0.{key}"]


def test_all_faults_of_all_figures_come_at_once_with_their_lines(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(
        figure('name = "a b"\nquantity = "motor_torqe"\nsize = "5 mm"\nformat = "jpg"\nwhere = "1 = 2"')
        + figure('name = "b"\nquantity = []\noverlay = "yes"\ncolr = "x"')
        + '[arm]\na1 = "-1 mm"\n'
    )
    with pytest.raises(StudyError) as error:
        load_study(path)
    found = {(fault.key, fault.line) for fault in error.value.faults}
    assert {
        ("figure.0.name", 2),
        ("figure.0.quantity", 3),
        ("figure.0.size", 4),
        ("figure.1.quantity", 9),
        ("figure.1.overlay", 10),
        ("figure.1.colr", 11),
        ("arm.a1", 13),
    } <= found
    assert 'did you mean "motor_torque"?' in str(error.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('name = "a"\nquantity = "elbow_torque"\ncolour = "load_mas"', ("figure.0.colour", 'did you mean "load_mass"')),
        ('name = "a"\nquantity = "elbow_torque"\nwhere = "load_mass = 5 N"', ("figure.0.where", "5 N")),
        ('name = "a"\nquantity = "elbow_torque"\nwhere = "lod = 5 N"', ("figure.0.where", "no column")),
        ('name = "a"\nquantity = ["elbow_torque", "margin"]', ("figure.0.quantity", "one table")),
        (
            'name = "a"\nquantity = ["elbow_torque", "spool_angle"]\noverlay = true',
            ("figure.0.overlay", "angle and torque"),
        ),
        ('name = "a"\nquantity = "elbow_torque"\noverlay = true\ncolour = "load_mass"', ("figure.0.colour", "overlay")),
        ('name = "slack_map"\nquantity = "elbow_torque"', ("figure.0.name", "slack_map")),
        ('name = "a"\nquantity = "margin"\nx = "motor_torque"', ("figure.0.x", "no column")),
        (f'name = "a"\nquantity = "margin"\nx = "{"x" * 100}"', ("figure.0.x", "no column")),
        (f'name = "a"\nquantity = "margin"\nx = "{"x" * 101}"', ("figure.0.x", "is not a name")),
        ('name = "a"\nquantity = "margin"\nx = "margin\\n"', ("figure.0.x", "is not a name")),
        (
            'name = "a"\nquantity = "elbow_torque"\n[[figure]]\nname = "a"\nquantity = "margin"',
            ("figure.1.name", "two"),
        ),
    ],
)
def test_what_a_figure_cannot_be_is_refused(tmp_path, text, says):
    path = tmp_path / "study.toml"
    path.write_text(figure(text))
    with pytest.raises(StudyError) as error:
        load_study(path)
    assert len(error.value.faults) == 1
    assert [part for part in says if part not in str(error.value)] == []


def test_the_schema_takes_the_paper_s_figures_and_no_others():
    check = jsonschema.Draft202012Validator(Study.model_json_schema())
    for name in STUDIES:
        content = tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))
        assert list(check.iter_errors(content)) == []
        assert study_from(content).figure == load(name).figure
    assert not check.is_valid({"figure": [{"name": "a", "quantity": "nothing"}]})
    assert not check.is_valid({"figure": [{"quantity": "margin"}]})


def test_drawing_leaves_the_run_as_it_was(runs, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(runs["fig07"].folder, folder)
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    draw_run(runs["fig07"].study, folder)
    assert {name: (folder / name).read_bytes() for name in before} == before


def test_nothing_is_shaded_where_no_tension_is_negative(new_sweep, tmp_path):
    new_sweep(SMALL + figure('name = "a"\nquantity = "extensor_tension_distal"'), tmp_path)  # unilateral
    (declared,) = load_study(tmp_path / "study.toml").figure
    (page,) = pages_of(open_table(tmp_path / "run" / "states.parquet"), declared)
    assert [text for axes in page.figure.axes for text in axes.texts if text.get_gid() == "slack word"] == []
