"""Runs to check: two loads over nine pretensions, with limits that some break."""

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
