"""Extreme studies that are valid print no warning of Python's, whatever is done with them."""

import json

import pytest

from tests.sampled import quick_and_torture

RIGID_AT_MOTOR = {"spring": {"stiffness": "rigid", "at": "motor"}}
STUDIES = {
    "rigid spring at the motor": RIGID_AT_MOTOR,
    "rigid spring at one speed": {**RIGID_AT_MOTOR, "motion": {"speed": "60 deg/s"}},
    "least friction": {"sheath": {"friction": 5e-324}},
    "frictions that look alike": {"sheath": {"friction": [0, 5e-324, 1e-200, 1e-9, 3.0]}},
    "ratios": {"spool": {"ratio": [1e-3, 1.0, 1e3]}},
    "one angle": {"motion": {"elbow_angle": "0 deg"}},
    "one state": {"motion": {"elbow_angle": "75 deg", "direction": ["flexion"]}},
    "softest and stiffest spring": {"spring": {"stiffness": ["1 mN/m", "1e12 N/m", "rigid"]}},
    "no pretension": {"tendon": {"pretension": ["0 N", "1e7 N"]}},
}
AT_ONCE = {
    **RIGID_AT_MOTOR,
    "sheath": {"friction": [0, 5e-324, 3.0]},
    "spool": {"ratio": [1e-3, 1e3]},
    "motion": {"elbow_angle": "0 deg"},
}
LOADS = {"load": {"mass": ["0 kg", "5 kg", "10 kg"]}}
LINES = """
state study.yaml --reversal
state study.yaml --reversal --plot state.png
sweep study.yaml --dry-run
sweep study.yaml --out run
check run
show run
export run rows.csv
plot run --out map.png
plot run -y motor_torque --out curves.png
plot study.yaml --arm --out arm.png
report run
design study.yaml --out answer
check answer
show answer
plot answer --between --out between.png
report answer
""".strip().splitlines()


@pytest.mark.parametrize("study", quick_and_torture([AT_ONCE], STUDIES.values()))
def test_an_extreme_study_prints_no_warning_of_python(tendon, workplace, study):
    """Warnings are errors in the tests, so one ends a command with 1, or costs it a figure."""
    (workplace / "study.yaml").write_text(json.dumps({**LOADS, **study}))
    for line in LINES:
        ran = tendon(*line.split())
        assert ran.exit != 1, f"{line}: {ran.err}"
        assert "Warning" not in ran.out + ran.err, line
        assert "this is a bug" not in ran.out + ran.err, line
