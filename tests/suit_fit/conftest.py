"""Logs of a suit of elastic links, which shares nothing with the model."""

import numpy as np
import pandas as pd
import pytest

from verification.rigs.elastic_links import Motion, simulate
from verification.rigs.plain_dictionary import make_rig

TRUTH = {
    "sheath.friction": 0.09,
    "tendon.pretension": 150.0,
    "anchor.stiffness": 12e3,
    "joint.stiffness": 1.3,
}
"""Numbers of the suit that the study leaves open, SI."""
STUDY = {
    "sheath": {"friction": "0.03 to 0.25"},
    "tendon": {"pretension": "60 N to 300 N"},
    "spring": {"stiffness": "5 kN/m"},
    "anchor": {"stiffness": "5 kN/m to 30 kN/m"},
    "joint": {"stiffness": "1.1 N m/rad +/- 0.5 N m/rad", "rest_angle": "73 deg"},
    "spool": {"ratio": 0.6},
}
"""Study of the suit, which leaves these numbers open."""
LOADS = (0.0, 2.0, 4.0)
"""Masses of the loads, kg."""
TIME = np.linspace(0.0, 24.0, 360)
"""Instants of each log, s: three cycles of 8 s."""


def suit(load, **changes):
    """Return the suit with a load, as the rig takes it."""
    given = TRUTH | changes
    return {
        "sheath": {"friction": given["sheath.friction"]},
        "tendon": {"pretension": given["tendon.pretension"]},
        "spring": {"stiffness": 5000.0},
        "anchor": {"stiffness": given["anchor.stiffness"]},
        "joint": {"stiffness": given["joint.stiffness"], "rest_angle": np.radians(73.0)},
        "spool": {"ratio": 0.6},
        "load": {"mass": load},
    }


def logs_of(histories, loads, seed):
    """Return logs of histories, as sensors with noise and a gear show them."""
    random = np.random.default_rng(seed)
    rows = len(TIME)
    logs = []
    for history, load in zip(histories, loads, strict=True):
        way = np.where(np.sin(2.0 * np.pi * TIME / 8.0) >= 0.0, 1.0, -1.0)
        logs.append(
            pd.DataFrame(
                {
                    "time (s)": TIME,
                    "elbow_angle (rad)": history.angle + 1e-3 * random.normal(size=rows),
                    "spool_angle (rad)": history.spool_angle
                    + 0.3
                    + 1e-3 * random.normal(size=rows),
                    "motor_torque (N m)": history.motor_torque
                    + 0.1 * way
                    + 0.02 * random.normal(size=rows),
                    "load_mass (kg)": np.full(rows, load),
                }
            )
        )
    return logs


@pytest.fixture(scope="session")
def histories():
    """Courses of the suit with each load, and with the heavier ones a fifth heavier than stated."""
    angle = np.radians(45.0 - 40.0 * np.cos(2.0 * np.pi * TIME / 8.0))
    motion = Motion(TIME, angle, np.zeros_like(angle))
    loads = (*LOADS, 2.6, 5.2)
    rigs = [make_rig(suit(load)) for load in loads]
    return dict(zip(loads, simulate(rigs, [motion] * len(rigs), nodes=16), strict=True))


@pytest.fixture(scope="session")
def logs(histories):
    """Logs of the suit, one for each load."""
    return logs_of([histories[load] for load in LOADS], LOADS, seed=1)


@pytest.fixture(scope="session")
def fit(logs):
    """The suit fitted to its logs."""
    import tendon_cli as tendon

    return tendon.fit_suit(STUDY, logs)
