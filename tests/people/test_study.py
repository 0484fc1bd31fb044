"""`[people]` in a study: whose arms, which keys, and a sweep over them against the model."""

import hashlib
import json
import re
from importlib import resources

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.engine.plan import Plan
from tendon_cli.errors import StudyError
from tendon_cli.model import actuator
from tendon_cli.model.body import Body
from tendon_cli.studies.file_content import FileContent
from tendon_cli.studies.load import study_from
from tendon_cli.studies.people.person import person_study
from tendon_cli.studies.people.population import draw
from tendon_cli.studies.people.survey import ansur2
from tendon_cli.studies.spaces import space_of
from tests.model import designs
from tests.people.own_statistics import written

FILE = "name,weight (kg),stature (cm),weighting\nAda,62.5,168,1\nBo,90,181.5,3\n"

BOTH_DIRECTIONS = np.array([[True], [False]])


def from_file(tmp_path, text=FILE, **content):
    """Return a study of the persons of a file given as text."""
    (tmp_path / "people.csv").write_text(text, encoding="utf-8")
    return study_from({"people": {"file": "people.csv"} | content}, folder=tmp_path)


def test_persons_are_the_slowest_axis_after_cases():
    study = study_from(
        {"people": {"count": 5}, "arm": {"b1": [0.15, 0.16]}, "cases": [{"name": "a"}]}
    )
    assert study.axes == ("case", "person", "arm.b1")
    assert study.conditions == study.axes
    assert study.serve == 0.95


def arm_on(body, reference, b1):
    """Return the numbers of the paper's arm, with another b1, on a body."""
    forearm = body.forearm_circumference / reference.forearm_circumference
    return {
        "a1": 0.040 * body.biceps_circumference / reference.biceps_circumference,
        "b1": b1 * body.acromion_radiale_length / reference.acromion_radiale_length,
        "a2": 0.020 * forearm,
        "b2": 0.150 * body.radiale_stylion_length / reference.radiale_stylion_length,
        "elbow_radius": 0.045 * forearm,
        "forearm_mass": 0.022 * body.weight,
        "forearm_com": 0.682 * body.radiale_stylion_length,
        "load_distance": body.forearm_grip_length,
    }


def test_a_sweep_over_persons_is_the_model_of_the_arm_of_each():
    study = study_from(
        {"people": {"count": 6, "seed": 4}, "arm": {"b1": [0.15, 0.16]}, "load": {"mass": 5.0}}
    )
    plan = Plan(study)
    (block,) = plan.blocks(range(plan.designs))
    swept = plan.state(block)
    people = draw(ansur2(), "both", 6, seed=4)
    for person in range(6):
        body = Body(*people.values[person])
        for index, b1 in enumerate((0.15, 0.16)):
            arm = arm_on(body, people.reference, b1)
            design = designs.design(designs.baseline(**arm, load_mass=5.0))
            state = actuator.evaluate(design, plan.elbow_angles[np.newaxis], BOTH_DIRECTIONS)
            np.testing.assert_allclose(
                swept.balance.flexor[person, index], state.balance.flexor, rtol=1e-12
            )
            np.testing.assert_allclose(
                swept.motor_torque[person, index], state.motor_torque, rtol=1e-9
            )


def test_numbers_of_the_forearm_that_the_study_states_are_not_taken_from_the_body():
    from_body = study_from({"people": {"count": 3}})
    stated = study_from({"people": {"count": 3}, "arm": {"forearm_mass": "1.6 kg"}})
    assert set(from_body.body_numbers) == {
        "arm.forearm_mass",
        "arm.forearm_com",
        "arm.load_distance",
    }
    assert set(stated.body_numbers) == {"arm.forearm_com", "arm.load_distance"}
    drawn = space_of(stated).axes[0].numbers.keys()
    assert set(from_body.body_numbers) - drawn == {"arm.forearm_mass"}
    for study in (from_body, stated):
        again = study_from(study.document())
        assert again.hash == study.hash
        assert set(space_of(again).axes[0].numbers) == set(space_of(study).axes[0].numbers)


def test_a_study_of_real_persons_carries_them_along(tmp_path):
    study = from_file(tmp_path)
    (tmp_path / "people.csv").unlink()
    again = study_from(json.loads(json.dumps(study.record))["study"])
    assert again.hash == study.hash
    people = again.people.population
    assert people.persons == again.people.nominal.names == ("Ada", "Bo")
    np.testing.assert_array_equal(people.values, study.people.population.values)
    assert again.people.nominal.weighting.tolist() == [1.0, 3.0]
    source = study.sources["people.file"]
    assert source["persons"] == 2
    assert any("drawn from men and women mixed" in warning for warning in source["warnings"])


def test_statistics_of_ones_own_complete_the_persons_of_a_file(tmp_path):
    """They are of persons 1 m large with lengths of 33 cm, which differ by 1 or 2 mm."""
    statistics = written()
    (tmp_path / "own.toml").write_text(statistics, encoding="utf-8")
    (tmp_path / "people.csv").write_text(FILE, encoding="utf-8")
    people = {"file": "people.csv", "statistics": "own.toml"}
    study = study_from({"people": people}, folder=tmp_path)
    drawn = study_from({"people": {"statistics": "own.toml", "count": 30}}, folder=tmp_path)
    (tmp_path / "own.toml").unlink()
    (tmp_path / "people.csv").unlink()
    measured = study.people.nominal.values
    np.testing.assert_allclose(measured[:, :2], [[1.68, 62.5], [1.815, 90.0]])
    np.testing.assert_allclose(measured[:, 2:], 0.33, atol=0.015)
    bodies = drawn.people.population.values
    np.testing.assert_allclose(bodies[:, 0], 1.0, atol=0.015)
    np.testing.assert_allclose(bodies[:, 2:], 0.33, atol=0.015)
    assert set(study.sources) == {"people.file", "people.statistics"}
    source = study.sources["people.statistics"]
    assert (source["file"], source["men"], source["women"]) == ("own.toml", 10, 5)
    assert source["sha256"] == hashlib.sha256(statistics.encode()).hexdigest()


def test_the_hash_of_a_study_changes_with_its_persons(tmp_path):
    studies = [
        study_from({"people": {}}),
        study_from({"people": {"seed": 2}}),
        study_from({"people": {"count": 999}}),
        study_from({"people": {"sex": "male"}}),
        study_from({}),
        from_file(tmp_path),
        from_file(tmp_path, FILE.replace("90", "91")),
    ]
    assert len({study.hash for study in studies}) == 7


@pytest.mark.parametrize(
    ("people", "message"),
    [
        ({"count": 0}, "people.count: 0 is out of range, expected 1"),
        ({"count": True}, "people.count.*not a whole number"),
        ({"source": "anzur"}, "people.source.*ansur2"),
        ({"women": 1.5}, "people.women.*out of range"),
        ({"women": 0.5, "sex": "male"}, "people.women: is a share among both sexes"),
        ({"file": "none.csv"}, 'people.file: there is no file "none.csv"'),
        ({"file": "people.csv", "count": 5}, "people.count: cannot be given with file"),
        ({"statistics": "none.toml"}, 'people.statistics: there is no file "none.toml"'),
        (
            {"statistics": "people.csv", "source": "ansur2"},
            "people.source: cannot be given with statistics",
        ),
        ({"file": "data:;base85,nonsense!"}, "people.file: not the packed content"),
        ({"file": {"name": ["Ada"], "weight (kg)": []}}, "people.file: a table is not possible"),
        ("everyone", "people.*is not a table"),
    ],
)
def test_faulty_people_are_refused(people, message, tmp_path):
    (tmp_path / "people.csv").write_text(FILE, encoding="utf-8")
    with pytest.raises(StudyError) as error:
        study_from({"people": people}, folder=tmp_path)
    assert re.search(message, error.value.message), error.value.message


def test_a_case_cannot_give_a_number_that_comes_from_the_body():
    case = {"name": "splint", "arm": {"forearm_mass": "3 kg", "b1": "160 mm"}}
    with pytest.raises(StudyError, match=r"cases\.0\.arm\.forearm_mass: .* comes from the body"):
        study_from({"people": {"count": 2}, "cases": [case]})
    study = study_from({"people": {"count": 2}, "cases": [case], "arm": {"forearm_mass": "2 kg"}})
    assert "arm.forearm_mass" not in space_of(study).axes[1].numbers


def test_packed_content_comes_back_and_bombs_are_refused():
    assert FileContent.of(FILE.encode()).content == FILE.encode()
    with pytest.raises(ValueError, match="cut short"):
        FileContent(FileContent.of(FILE.encode() * 100).packed[:-10]).content  # noqa: B018


def test_a_data_frame_stands_where_a_file_does(tmp_path):
    (tmp_path / "people.csv").write_text(FILE, encoding="utf-8")
    of_file = study_from({"people": {"file": "people.csv"}}, folder=tmp_path).people.population
    frame = pd.read_csv(tmp_path / "people.csv")
    study = tendon.study({"people": {"file": frame}})
    assert study.people.population.names == of_file.names
    np.testing.assert_allclose(study.people.population.values, of_file.values, rtol=1e-15)
    assert study_from(study.document()).hash == study.hash
    frame.loc[0, frame.columns[1]] = 1e6
    with pytest.raises(tendon.TendonError, match="far from any person"):
        tendon.study({"people": {"file": frame}})


# --- Statistics of one's own ----------------------------------------------------------------------


@pytest.fixture
def ansur2_text():
    """Return the file of the survey that comes with the program."""
    file = resources.files("tendon_cli.studies.people") / "ansur2_arm.toml"
    return file.read_text(encoding="utf-8")


def from_statistics(tmp_path, text, **people):
    """Return a study of people with statistics given as text."""
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    return study_from({"people": {"statistics": "own.toml", **people}}, folder=tmp_path)


def test_persons_of_ones_own_statistics_are_drawn_and_carried_along(tmp_path, ansur2_text):
    same = from_statistics(tmp_path, ansur2_text, count=20)
    drawn = draw(ansur2(), "both", 20, seed=1)
    np.testing.assert_array_equal(same.people.population.values, drawn.values)
    heavy_text = ansur2_text.replace("85.52", "99.5").replace("4082", "100")
    heavy = from_statistics(tmp_path, heavy_text, count=20)
    (tmp_path / "own.toml").unlink()
    again = study_from(json.loads(json.dumps(heavy.record))["study"])
    assert again.hash == heavy.hash != same.hash
    people = again.people.population
    assert people.reference.weight == 99.5
    women = sum(name.startswith("woman") for name in people.names)
    assert women == round(20 * 1986 / 2086)
    assert heavy.sources["people.statistics"]["men"] == 100
    assert person_study(again, "mean-man").body[1].value == 99.5


def test_ones_own_statistics_complete_a_file_of_persons_too(tmp_path, ansur2_text):
    (tmp_path / "people.csv").write_text("weight (kg)\n70\n", encoding="utf-8")

    def stature(text):
        study = from_statistics(tmp_path, text, file="people.csv", sex="male")
        return study.people.population.body.stature[0]

    usual = stature(ansur2_text)
    taller = stature(ansur2_text.replace("1756.21", "1856.21"))
    assert taller - usual == pytest.approx(0.1, abs=1e-9)
