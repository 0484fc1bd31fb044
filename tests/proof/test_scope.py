"""Scopes of certificates against dense loads, and what a share may be asked of."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.proof.arcs import ConditionArcs
from tendon_cli.proof.certify import certify

SPRINGS = (2e3, 5e3, 9e3)  # N/m
DRAWN = {"sheath": {"friction": "0.07 +/- 0.02"}, "uncertainty": {"draws": 4}}


def random_question(rng, number):
    """Return the content of a study of several loads, some in cases."""
    loads = np.sort(rng.uniform(0.0, 14.0, rng.integers(2, 6))).round(2)
    content = {
        "spring": {"stiffness": float(rng.choice(SPRINGS))},
        "spool": {"ratio": rng.uniform(0.4, 0.8)},
        "sheath": {"friction": rng.uniform(0.0, 0.15)},
        "load": {"mass": np.unique(loads).tolist()},
        "limits": {"max_tension": rng.uniform(250.0, 700.0)},
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


def check_scopes(seed, count):
    """Check scopes of random questions; return how many windows are proved."""
    rng = np.random.default_rng(seed)
    proved = 0
    for number in range(count):
        content = random_question(rng, number)
        certificate = certified(content)
        if certificate.status != "proven":
            continue
        proved += 1
        listed = content["load"]["mass"]
        if len(listed) < 2:
            assert certificate.scope.ranges == {}
            continue
        stated = certificate.scope.ranges["load.mass"]
        assert stated == (min(listed), max(listed))
        dense = {**content, "load": {"mass": np.linspace(*stated, 31).tolist()}}
        question = question_of(tendon.study(dense))
        ends = Solver(question).windows(question.all_points())
        assert ends.low.max() <= certificate.solution.pretension_from.item() + certificate.margin
        assert ends.high.min() >= certificate.solution.pretension_to.item() - certificate.margin
    return proved


def test_a_window_suits_every_load_of_its_scope():
    assert check_scopes(1, 15) > 4


@pytest.mark.torture
def test_a_thousand_windows_suit_every_load_of_their_scopes():
    assert check_scopes(2, 1000) > 200


@pytest.mark.parametrize(
    ("key", "design"),
    [
        ("design.serve", {"serve": 0.5}),
        ("design.maximise", {"maximise": ["tolerance", "served"]}),
        ("design.minimise", {"minimise": "served_at"}),
    ],
)
def test_no_share_of_conditions_is_asked_for(key, design):
    content = {"load": {"mass": [0.0, 5.0]}, "design": design}
    with pytest.raises(tendon.StudyError, match="counts persons or draws") as caught:
        tendon.design(content)
    assert key in str(caught.value)
    assert caught.value.exit == 2
    for whom in ({"people": {"count": 2}}, DRAWN):
        assert question_of(tendon.study({**content, **whom})).conditions.groups is not None
    question_of(tendon.study({**content, "design": {"serve": 1.0}}))


def test_weights_of_an_arc_of_postures_stand_where_its_tangents_meet(monkeypatch):
    """Limits are linear in the direction of gravity: there they bound all postures of the arc."""
    study = {
        "arm": {"upper_arm_angle": {"from": "-20 deg", "to": "70 deg"}},
        "spring": {"stiffness": 5e3},
        "spool": {"ratio": 0.6},
    }
    question = question_of(tendon.study(study))
    arcs = ConditionArcs.of(question, question.all_points())
    cells = arcs.first_cells(arcs.row)
    asked = []
    design = ConditionArcs.design

    def told(self, row, shares=0.0, posture=np.nan, growth=None):
        asked.append((posture, growth))
        return design(self, row, shares, posture, growth)

    monkeypatch.setattr(ConditionArcs, "design", told)
    arcs.judge(cells, np.full(len(arcs.row), 100.0), np.full(len(arcs.row), 200.0))
    posture, growth = next((posture, growth) for posture, growth in asked if growth is not None)
    first = cells.low[:, -1]
    last = cells.high[:, -1]
    assert (last - first).max() > 0.5
    for end in (first, last):
        # A point lies on the tangent at the end if its share along the end's direction is 1.
        np.testing.assert_allclose(growth * np.cos(posture - end), 1.0, rtol=1e-9)
