"""Limits, conditions and goals of a study, and the states that it keeps."""

import pytest

from tendon_cli.errors import StudyError
from tendon_cli.quantities import OF_STATES
from tendon_cli.studies.design_section import Limits
from tendon_cli.studies.load import load_study, study_from

CASES = [{"name": "a"}, {"name": "b"}]


def test_limits_are_a_mapping_of_what_is_given_in_si_and_the_least_stiffness():
    study = study_from({"limits": {"max_tension": "0.3 kN", "peak_motor_torque": "12 N m"}})
    assert dict(study.limits) == {
        "max_tension": 300.0,
        "peak_motor_torque": 12.0,
        "min_elbow_stiffness": 0.0,
    }
    assert len(study.limits) == 3
    assert "min_flexor_tension" not in study.limits
    assert study.limits.get("min_flexor_tension") is None


def test_a_limit_that_is_not_given_is_no_key():
    assert dict(study_from({}).limits) == {"min_elbow_stiffness": 0.0}
    for name in ("max_pretension", "nothing", "model_fields"):
        with pytest.raises(KeyError):
            study_from({}).limits[name]


@pytest.mark.parametrize("name", list(Limits.model_fields))
def test_every_limit_reads_back_and_changes_the_hash(name):
    content = {
        "arm": {"contact_width": 0.04},
        "motion": {"speed": "60 deg/s"},
        "spring": {"free_length": 0.07},
        "allow_implausible": True,
    }
    study = study_from({**content, "limits": {name: 0.25}})
    assert study.limits[name] == 0.25
    assert study.hash != study_from(content).hash
    assert study_from(study.document()).hash == study.hash


@pytest.mark.parametrize(
    ("conditions", "expected"),
    [
        (None, ("case", "load.mass", "arm.b1")),
        ([], ()),
        (["load.mass"], ("load.mass",)),
        (["spool.ratio", "case"], ("case", "spool.ratio")),
        (["tendon.length", "load.mass"], ("load.mass",)),
    ],
)
def test_conditions_are_the_axes_asked_for_else_those_of_load_arm_and_cases(conditions, expected):
    content = {
        "cases": CASES,
        "load": {"mass": [1, 2]},
        "spool": {"ratio": [0.6, 1]},
        "arm": {"b1": [0.1, 0.2]},
    }
    if conditions is not None:
        content["design"] = {"conditions": conditions}
    assert study_from(content).conditions == expected


def test_a_goal_may_be_a_choice_of_the_study():
    goals = {"minimise": "spool_ratio", "maximise": "tolerance"}
    study = study_from({"spool": {"ratio": [0.6, 1]}, "design": goals})
    assert study.design.minimise == ("spool_ratio",)
    assert study.design.maximise == ("tolerance",)


def test_a_width_in_every_case_is_enough_for_a_pressure():
    cases = [{"name": name, "arm": {"contact_width": "40 mm"}} for name in "ab"]
    study = study_from({"limits": {"max_contact_pressure": "30 kPa"}, "cases": cases})
    assert "arm.contact_width" not in study.numbers


def test_any_result_of_the_states_may_be_kept():
    names = ["status", *OF_STATES]
    assert study_from({"output": {"states": names}}).output.states == tuple(names)
    assert study_from({}).output.states is None


def test_the_command_line_sets_whole_numbers_and_truths(tmp_path):
    path = tmp_path / "study.toml"
    path.touch()
    settings = (
        "uncertainty.draws=64",
        "uncertainty.seed=7",
        "design.advice=false",
        "design.serve=90 %",
    )
    study = load_study(path, settings)
    assert study.uncertainty.draws == 64
    assert study.uncertainty.seed == 7
    assert study.design.advice is False
    assert study.serve == 0.9
    assert study_from({}).serve == 1.0


def test_a_fault_of_what_a_limit_needs_hides_no_other_and_adds_none():
    content = {"limits": {"peak_motor_power": "5 W"}, "motion": {"speed": "60 deg"}}
    with pytest.raises(StudyError, match="the study has 1 fault") as caught:
        study_from(content)
    assert [fault.key for fault in caught.value.faults] == ["motion.speed"]
