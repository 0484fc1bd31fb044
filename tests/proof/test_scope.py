"""Scopes of certificates against dense loads."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.proof.certify import certify
from tendon_cli.windows.question import question_of
from tendon_cli.windows.solutions import solve
from tendon_cli.windows.solver import Solver

SPRINGS = (2e3, 5e3, 9e3)  # N/m


def random_question(rng, number):
    """Return the content of a study that need serve only a share of its loads, some in cases."""
    loads = np.sort(rng.uniform(0.0, 14.0, rng.integers(2, 6))).round(2)
    content = {
        "spring": {"stiffness": float(rng.choice(SPRINGS))},
        "spool": {"ratio": rng.uniform(0.4, 0.8)},
        "sheath": {"friction": rng.uniform(0.0, 0.15)},
        "load": {"mass": np.unique(loads).tolist()},
        "limits": {"max_tension": rng.uniform(250.0, 700.0)},
        "design": {"serve": rng.uniform(0.2, 0.9)},
    }
    if number % 3 == 0:
        angles = rng.uniform(-20.0, 40.0, 2).round(1)
        content["cases"] = [
            {"name": name, "arm": {"upper_arm_angle": f"{angle} deg"}}
            for name, angle in zip("ab", angles, strict=True)
        ]
    return content


def certified(content):
    """Return the certificate of the only choice of a study."""
    question = question_of(tendon.study(content))
    solver = Solver(question)
    return certify(solver, solve(solver, question.all_points()))


def windows_at_loads(content, loads):
    """Return the ends of windows at loads, (cases, loads) each."""
    dense = {**content, "load": {"mass": loads.tolist()}, "design": {"serve": 1.0}}
    dense_question = question_of(tendon.study(dense))
    keys = [axis.key for axis in dense_question.conditions.axes]
    shape = tuple(len(axis) for axis in dense_question.conditions.axes)
    ends = Solver(dense_question).ends_over_all_angles(dense_question.all_points())
    return [
        np.moveaxis(values.reshape(shape), keys.index("load.mass"), -1).reshape(-1, len(loads))
        for values in (ends.low, ends.high)
    ]


def check_scopes(seed, count):
    """Check scopes of random questions; return how many have a range that is not all loads."""
    rng = np.random.default_rng(seed)
    narrower = 0
    for number in range(count):
        content = random_question(rng, number)
        certificate = certified(content)
        if certificate.status != "proven" or len(content["load"]["mass"]) < 2:
            continue
        listed = np.array(content["load"]["mass"])
        stated = certificate.scope.ranges.get("load.mass")
        narrower += stated != (listed.min(), listed.max())
        solution = certificate.solution
        low = solution.pretension_from.item() + certificate.margin
        high = solution.pretension_to.item() - certificate.margin
        high = min(high, 1e3)
        if stated is None:
            continue
        listed_low, listed_high = windows_at_loads(content, listed)
        dense_low, dense_high = windows_at_loads(content, np.linspace(*stated, 31))
        for pretension in np.linspace(low, high, 5):
            serves_any = (listed_low <= pretension) & (pretension <= listed_high)
            is_served = (dense_low <= pretension) & (pretension <= dense_high)
            cases = serves_any.any(axis=1)
            assert is_served[cases].all(), (number, stated, pretension)
    return narrower


def test_every_load_of_a_scope_is_served_wherever_the_pretension_serves_any():
    assert check_scopes(1, 15) > 4


@pytest.mark.torture
def test_every_load_of_a_thousand_scopes_is_served():
    assert check_scopes(2, 1000) > 200


def test_a_load_that_is_not_served_is_not_among_what_is_proved():
    content = {"load": {"mass": [0.0, 5.0, 10.0]}, "design": {"serve": 0.6}}
    answer = tendon.design(content)
    best = answer.record["best"]
    known = answer.record["between_samples"]
    assert best["served_at"] == pytest.approx(2.0 / 3.0)
    assert known["status"] == "proven"
    assert "from 0 to 10 kg" not in known["scope"]
    assert known["scope"].endswith("for all conditions that are served")


def test_a_middle_load_that_alone_is_served_is_proved_without_a_range():
    content = {
        "spring": {"stiffness": 5e3},
        "spool": {"ratio": 0.6},
        "load": {"mass": [0.0, 6.0, 30.0]},
        "limits": {"max_tension": "300 N"},
        "design": {"serve": 0.3},
    }
    certificate = certified(content)
    assert certificate.status == "proven"
    assert certificate.cells > 0
    listed_low, listed_high = windows_at_loads(content, np.array([0.0, 6.0, 30.0]))
    pretension = certificate.solution.pretension.item()
    is_served = (listed_low <= pretension) & (pretension <= listed_high)
    assert is_served.sum() >= 1


@pytest.mark.parametrize("key", ["load.mass", "arm.elbow_radius"])
def test_an_interval_is_refused_where_a_share_of_conditions_is_enough(key):
    table, name = key.split(".")
    content = {"design": {"serve": 0.5}}
    content[table] = {name: {"from": 0.04, "to": 0.05}}
    with pytest.raises(tendon.StudyError, match="of which no share can be counted") as caught:
        tendon.design(content)
    assert caught.value.exit == 2
    with_people = tendon.study({**content, "people": {"count": 2}})
    assert question_of(with_people).serve == 0.5


def test_one_condition_of_twenty_that_is_not_served_leaves_the_others_proved():
    """The window of nineteen cases is proved for these, though the twentieth needs less tension."""
    b1 = [*np.linspace(150.0, 152.0, 19), 100.0]  # mm
    cases = [{"name": str(place), "arm": {"b1": f"{value} mm"}} for place, value in enumerate(b1)]
    content = {
        "spring": {"stiffness": "5 kN/m"},
        "spool": {"ratio": 0.6},
        "load": {"mass": "10 kg"},
        "cases": cases,
        "limits": {"max_tension": "400 N"},
        "design": {"serve": 0.95, "conditions": ["case"]},
    }
    question = question_of(tendon.study(content))
    solver = Solver(question)
    certificate = certify(solver, solve(solver, question.all_points()))
    solution = certificate.solution
    assert solution.served.item() == pytest.approx(0.95)
    assert certificate.status == "proven"
    low, high = windows_at_loads(content, np.array([10.0]))
    assert high[-1] < solution.pretension_from.item()
    assert solution.pretension_from.item() == pytest.approx(low[:-1].max())
