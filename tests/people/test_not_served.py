"""Who is left out, and why: every person counted once, each with a reason that the model itself confirms."""

import numpy as np
import pytest

from tendon_cli.answers.population import LESS, MORE, NEITHER, not_served, windows_of
from tendon_cli.answers.question import question
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
    return problem, windows_of(problem, problem.choices.numbers(np.arange(1)))


@pytest.mark.parametrize("pretension", [100.0, 148.0, 260.0, np.nan])
def test_everyone_is_served_or_left_out_once(found, pretension):
    problem, windows = found
    reasons = not_served(problem, windows, pretension, problem.study.people.population)
    out = np.concatenate([np.empty(0, dtype=int), *(reason.members for reason in reasons)])
    served = np.flatnonzero((windows.low <= pretension) & (pretension <= windows.high))
    assert sorted([*out, *served]) == list(range(200))
    assert sum(reason.share for reason in reasons) == pytest.approx(len(out) / 200)
    shares = [reason.share for reason in reasons]
    assert shares == sorted(shares, reverse=True)


def test_a_reason_says_what_is_needed_and_where_it_binds(found):
    problem, windows = found
    reasons = {reason.needs: reason for reason in not_served(problem, windows, 148.0, problem.study.people.population)}
    assert set(reasons) == {MORE, LESS, NEITHER}
    assert np.all(windows.low[reasons[MORE].members] > 148.0)
    assert np.all(windows.high[reasons[LESS].members] < 148.0)
    assert np.all(windows.low[reasons[NEITHER].members] > windows.high[reasons[NEITHER].members])
    assert reasons[MORE].limits == ("extensor slack",)
    assert reasons[LESS].limits == ("min_elbow_stiffness",)
    assert reasons[NEITHER].limits == ("extensor slack", "min_elbow_stiffness")
    masses = problem.condition_numbers["load.mass"]
    assert [masses[reasons[MORE].conditions[0]], masses[reasons[LESS].conditions[0]]] == [10.0, 0.0]


def test_members_stand_in_the_order_of_what_they_miss(found):
    problem, windows = found
    (reason, *_) = [each for each in not_served(problem, windows, 148.0, None) if each.needs == MORE]
    missing = windows.low[reason.members] - 148.0
    assert np.all(np.diff(missing) <= 0.0)


def test_bodies_left_out_differ_as_their_means_say(found):
    problem, windows = found
    people = problem.study.people.population
    for reason in not_served(problem, windows, 148.0, people):
        first = reason.differences[0]
        of_all = getattr(people.body, first.dimension)
        theirs = of_all[reason.members]
        assert (first.theirs, first.of_all) == pytest.approx((theirs.mean(), of_all.mean()))
        assert first.deviations == pytest.approx((theirs.mean() - of_all.mean()) / of_all.std())
        assert abs(first.deviations) == max(abs(each.deviations) for each in reason.differences)
