"""Who is left out, and why: every person counted once, each with a reason that the model itself confirms."""

import numpy as np
import pytest

from tendon_cli.answers.population import GroupWindows, left_out, not_served
from tendon_cli.answers.question import question
from tendon_cli.answers.words import LESS, MORE, NEITHER
from tendon_cli.studies.load import study_from

STUDY = {
    "people": {"count": 200},
    "load": {"mass": [0.0, 10.0]},
    "spring": {"stiffness": "5 kN/m"},
    "spool": {"ratio": 0.6},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 19}},
}


@pytest.fixture(scope="module")
def found():
    problem = question(study_from(STUDY))
    return problem, GroupWindows.of(problem, problem.choices.numbers(np.arange(1)))


@pytest.mark.parametrize("pretension", [100.0, 148.0, 260.0, np.nan])
def test_everyone_is_served_or_left_out_once(found, pretension):
    problem, windows = found
    reasons = not_served(problem, windows, pretension)
    out = np.concatenate([np.empty(0, dtype=int), *(each[-1] for each in left_out(problem, windows, pretension))])
    served = np.flatnonzero((windows.low <= pretension) & (pretension <= windows.high))
    assert sorted([*out, *served]) == list(range(200))
    assert sum(reason["share"] for reason in reasons) == pytest.approx(len(out) / 200)
    shares = [reason["share"] for reason in reasons]
    assert shares == sorted(shares, reverse=True)


def test_a_reason_says_what_is_needed_and_where_it_binds(found):
    problem, windows = found
    reasons = {need: reason for need, *reason in left_out(problem, windows, 148.0)}
    assert set(reasons) == {MORE, LESS, NEITHER}
    assert np.all(windows.low[reasons[MORE][-1]] > 148.0)
    assert np.all(windows.high[reasons[LESS][-1]] < 148.0)
    assert np.all(windows.low[reasons[NEITHER][-1]] > windows.high[reasons[NEITHER][-1]])
    assert reasons[MORE][0] == ["extensor slack"]
    assert reasons[LESS][0] == ["min_elbow_stiffness"]
    assert reasons[NEITHER][0] == ["extensor slack", "min_elbow_stiffness"]
    masses = problem.condition_numbers["load.mass"]
    assert [masses[reasons[MORE][1][0]], masses[reasons[LESS][1][0]]] == [10.0, 0.0]


def test_members_stand_in_the_order_of_what_they_miss(found):
    problem, windows = found
    (members, *_) = [each[-1] for each in left_out(problem, windows, 148.0) if each[0] == MORE]
    missing = windows.low[members] - 148.0
    assert np.all(np.diff(missing) <= 0.0)


def test_bodies_left_out_differ_as_their_means_say(found):
    problem, windows = found
    people = problem.study.people.population
    all_members = {need: members for need, _, _, members in left_out(problem, windows, 148.0)}
    for reason in not_served(problem, windows, 148.0):
        (first, each), *_ = reason["bodies"].items()
        of_all = getattr(people.body, first)
        theirs = of_all[all_members[reason["needs"]]]
        assert (each["theirs"], each["of_all"]) == pytest.approx((theirs.mean(), of_all.mean()))
        assert each["deviations"] == pytest.approx((theirs.mean() - of_all.mean()) / of_all.std())
        assert abs(each["deviations"]) == max(abs(one["deviations"]) for one in reason["bodies"].values())
