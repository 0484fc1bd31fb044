"""Runs to check, two loads over nine pretensions with limits that some break; and answers."""

import pytest

import tendon_cli as tendon

STUDY = {
    "name": "suit",
    "tendon": {"pretension": {"from": "80 N", "to": "240 N", "num": 9}},
    "load": {"mass": ["0 kg", "5 kg"]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 19}},
}


def swept(folder, **tables):
    """Sweep the study with some of its tables replaced into a folder, and return the folder."""
    tendon.sweep(tendon.study(STUDY | tables), folder)
    return folder


@pytest.fixture(scope="session")
def plain(tmp_path_factory):
    return swept(tmp_path_factory.mktemp("check") / "plain")


@pytest.fixture(scope="session")
def limited(tmp_path_factory):
    limits = {
        "max_tension": "300 N",
        "peak_motor_torque": "5.8 N m",
        "max_pretension": "230 N",
        "min_flexor_tension": "20 N",
        "min_extensor_tension": "20 N",
        "max_spring_extension": "60 mm",
        "max_contact_pressure": "20 kPa",
    }
    folder = tmp_path_factory.mktemp("check") / "limited"
    return swept(folder, limits=limits, arm={"contact_width": "50 mm"})


ANSWERED = {
    "name": "v1",
    "spring": {"stiffness": "4 kN/m"},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "5 kg"]},
    "sheath": {"friction": "0.07 +/- 0.01"},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    "people": {"count": 12, "seed": 1},
    "uncertainty": {"draws": 4},
    "design": {"verify": 200, "serve": 0.8},
}
"""A suit for persons whose window is narrow."""


@pytest.fixture(scope="session")
def answered(tmp_path_factory):
    """Return folders of answers: v1, v2 with a larger spool, and v1 for other persons."""
    folder = tmp_path_factory.mktemp("answers")
    studies = {
        "v1": ANSWERED,
        "v2": ANSWERED | {"spool": {"ratio": 0.64}},
        "others": ANSWERED | {"people": {"count": 12, "seed": 2}},
    }
    for name, study in studies.items():
        tendon.design(study | {"name": name}, folder / name)
    return {name: folder / name for name in studies}
