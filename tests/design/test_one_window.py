"""An answer folds states into windows as a sweep does, and then seeks their ends between these."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.model.design import F0
from tendon_cli.model.whole_motion import ANGLES
from tests.conftest import CONFIGS
from tests.sampled import check_all, quick_and_torture

STUDIES = sorted(
    file.relative_to(CONFIGS)
    for file in CONFIGS.rglob("*.toml")
    if file.parent.name not in ("parts", "suit") and file.name != "large.toml"
)
LIMITS = {
    "max_tension": (250.0, 700.0),
    "min_flexor_tension": (0.0, 5.0),
    "max_spring_extension": (0.05, 0.2),
    "peak_motor_torque": (6.0, 20.0),
    "max_pretension": (80.0, 300.0),
    "max_contact_pressure": (30e3, 200e3),
}


def at_the_angles_of_an_answer(study):
    """Return a study at one pretension and at the angles of `angle_grid`, without deviations."""
    first, last = np.degrees([study.angles.min(), study.angles.max()]).tolist()
    grid = {"from": f"{first!r} deg", "to": f"{last!r} deg", "num": ANGLES}
    changes = {"motion.elbow_angle": grid, "tendon.pretension": "100 N", "uncertainty.usual": False}
    if study.people is not None:
        changes["people.count"] = 20
    return study.vary(**changes, **{"setting.read": study.setting.read})


def windows_of_a_sweep(study, question):
    """Return the lower and upper ends of the windows of choices by a table of designs alone."""
    designs = tendon.sweep(study).designs
    low = designs.pretension_from
    designs["high"] = designs.pretension_to.where(low.isna(), designs.pretension_to.fillna(np.inf))
    columns = [axis.column for axis in question.choices.axes] or (lambda _: 0)
    by_choice = designs.groupby(columns, sort=False, observed=True)
    low = by_choice.pretension_from.agg(lambda ends: ends.max(skipna=False))
    high = by_choice.high.agg(lambda ends: ends.min(skipna=False))
    return low.to_numpy(), high.to_numpy()


def check_windows(study):
    """Check the windows of an answer by a sweep; return how many ends seeking makes tighter."""
    study = at_the_angles_of_an_answer(study)
    question = question_of(study)
    points = question.all_points()
    sampled = Solver(question, seeks=False).ends(points)
    low, high = windows_of_a_sweep(study, question)
    np.testing.assert_allclose(sampled.low.max(axis=1), low, rtol=1e-12)
    answered = sampled.high.min(axis=1)
    if study.setting.read != F0:
        # An answer goes on below what a slack tendon shows, so that a window there is empty.
        answered = np.maximum(answered, 0.0)
    np.testing.assert_allclose(answered, high, rtol=1e-12, atol=1e-12)
    sought = Solver(question).ends(points)
    is_known = ~np.isnan(sampled.low)
    assert (sought.low >= sampled.low)[is_known].all()
    assert (sought.high <= sampled.high)[is_known].all()
    return np.count_nonzero(sought.low > sampled.low) + np.count_nonzero(sought.high < sampled.high)


def random_study(seed):
    """Return a study of random choices, loads, limits and angles."""
    rng = np.random.default_rng([seed, 59])
    names = rng.choice(list(LIMITS), rng.integers(0, 3), replace=False)
    content = {
        "spring": {"stiffness": rng.uniform(1e3, 8e3, rng.integers(1, 4)).tolist()},
        "spool": {"ratio": rng.uniform(0.3, 1.0, rng.integers(1, 4)).tolist()},
        "arm": {"contact_width": 0.04, "contact_from": f"{rng.uniform(0.0, 60.0)} deg"},
        "sheath": {"friction": rng.uniform(0.0, 0.15)},
        "load": {"mass": np.sort(rng.uniform(0.0, 12.0, rng.integers(1, 4))).tolist()},
        "limits": {str(name): rng.uniform(*LIMITS[name]) for name in names},
        "motion": {
            "elbow_angle": [f"{angle} deg" for angle in np.sort(rng.uniform(-5.0, 140.0, 4))]
        },
    }
    if rng.uniform() < 0.3:
        content["joint"] = {
            "stiffness": rng.uniform(0.0, 3.0),
            "rest_angle": f"{rng.uniform(20.0, 90.0)} deg",
        }
    if rng.uniform() < 0.3:
        content["setting"] = {"read": "flexor at joint"}
    return tendon.study(content)


def test_the_windows_of_configured_studies_are_those_of_their_sweeps_or_tighter():
    check_all(lambda file: check_windows(tendon.study(CONFIGS / file)), [(f,) for f in STUDIES])


@pytest.mark.parametrize(("first", "count"), quick_and_torture([(0, 8)], [(8, 200)]))
def test_the_windows_of_random_studies_are_those_of_their_sweeps_or_tighter(first, count):
    tighter = sum(check_windows(random_study(seed)) for seed in range(first, first + count))
    assert tighter > count
