"""A study that tendon wrote is built by types and bounds, and not judged again."""

import json

import pytest

import tendon_cli as tendon
from tendon_cli.errors import StudyError
from tendon_cli.studies import load
from tendon_cli.studies.load import recorded_study
from tendon_cli.version import RESULTS_VERSION

STUDY = {
    "load": {"mass": ["0 kg", "2 kg"]},
    "cases": [{"name": "small", "arm": {"b1": "140 mm"}}, {"name": "as it is"}],
    "table": [{"name": "part", "rows": [{"name": "A", "spring.stiffness": "4 kN/m"}]}],
    "joint": {"stiffness": "2 N m/rad", "rest_angle": "30 deg"},
}


@pytest.fixture
def record():
    return json.loads(json.dumps(tendon.study(STUDY).record))


def test_it_is_the_study_that_was_recorded(record):
    again = recorded_study(record)
    assert again.hash == tendon.study(STUDY).hash
    assert again.axes == ("case", "part", "load.mass")


@pytest.mark.parametrize("version", [RESULTS_VERSION, RESULTS_VERSION - 1])
def test_only_a_record_of_another_version_is_judged_again(record, monkeypatch, version):
    judged = []
    contradictions = load.contradictions

    def counted(*arguments):
        judged.append(arguments)
        return contradictions(*arguments)

    monkeypatch.setattr(load, "contradictions", counted)
    recorded_study(record, version)
    assert len(judged) == (version != RESULTS_VERSION)


def test_a_contradiction_that_this_version_recorded_was_accepted(record):
    del record["study"]["joint"]["rest_angle"]
    assert recorded_study(record).joint.rest_angle is None
    with pytest.raises(StudyError, match=r"joint\.stiffness"):
        recorded_study(record, RESULTS_VERSION - 1)


FORGED = [
    ("arm", {"b1": -1.0}),
    ("arm", {"b1": "long"}),
    ("arm", 3),
    ("springs", {}),
    ("load", {"mass": {"from": 0.0, "to": 1.0, "num": 10**9}}),
    ("cases", [{"name": "a", "arm": {"b1": -1.0}}]),
    ("cases", [{"name": "a", "arm": {"b1": [1.0, 2.0]}}]),
    ("cases", [3]),
    ("table", [{"name": "part", "rows": [["name", "A"], ["spring.stiffness", -4e3]]}]),
    ("table", [{"name": "part", "rows": [["name", "A", "A"], ["spring.stiffness", 4e3, 5e3]]}]),
    ("table", [{"name": "part", "rows": [["name", "A"], ["spring.stiffness", 4e3, 5e3]]}]),
    ("uncertainty", {"draws": 2**40}),
    ("people", {"count": 10**9}),
    ("motion", {"trajectory": {"time": [0.0, 1.0], "angle": ["0 rad", "1 rad"]}}),
    ("motion", {"trajectory": {"time": [*range(20)], "angle": ["0 rad"] * 20}, "cutoff": 40.0}),
]


def test_types_sizes_and_bounds_of_a_forged_record_are_always_checked(record):
    accepted = []
    for key, value in FORGED:
        forged = {**record, "study": {**record["study"], key: value}}
        try:
            recorded_study(forged)
        except StudyError:
            continue
        accepted.append((key, value))
    assert accepted == []
