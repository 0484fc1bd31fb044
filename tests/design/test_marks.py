"""Every figure in the folder of an answer says which study it is of."""

import pytest

import tendon_cli as tendon
from tendon_cli.files import study_hash_in

QUESTION = {
    "spring": {"stiffness": ["3 kN/m", "5 kN/m"]},
    "spool": {"ratio": [0.5, 0.6]},
    "motion": {"elbow_angle": ["0 deg", "45 deg", "90 deg"]},
    "people": {"count": 8},
    "design": {"maximise": ["tolerance", "served"]},
}


@pytest.mark.usefixtures("blank_figures")
def test_every_figure_of_an_answer_carries_the_hash_of_its_study(tmp_path):
    answer = tendon.design(QUESTION, tmp_path / "answer", figures=True)
    names = {file.name for file in answer.folder.glob("*.png")}
    assert names == set(answer.record["figures"])
    assert {"for_whom.png", "how_sure.png", "tolerance_map.png"} <= names
    for name in names:
        with (answer.folder / name).open("rb") as file:
            assert study_hash_in(file) == answer.record["study_hash"], name


@pytest.mark.usefixtures("blank_figures")
def test_every_figure_of_a_run_does_in_each_format(tmp_path):
    figure = {"name": "torque", "quantity": "motor_torque", "format": ["png", "svg", "pdf"]}
    study = {"tendon": {"pretension": ["60 N", "120 N"]}, "figure": [figure]}
    study |= {"spring": QUESTION["spring"]}
    run = tendon.sweep(study, tmp_path / "run", figures=True)
    assert set(run.record["figures"]) >= {"slack_map.png", "torque.svg", "torque.pdf"}
    for name in run.record["figures"]:
        with (run.folder / name).open("rb") as file:
            assert study_hash_in(file) == run.record["study_hash"], name
