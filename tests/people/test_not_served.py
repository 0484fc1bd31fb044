"""People who are not served: each is counted once, with a reason that the model confirms."""

import numpy as np
import pytest

from tendon_cli.answers.people import GroupWindows, reasons_not_served
from tendon_cli.answers.phrases import LESS, MORE, NEITHER
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.studies.load import study_from

STUDY = {
    "people": {"count": 200},
    "load": {"mass": [0.0, 10.0]},
    "spring": {"stiffness": "5 kN/m"},
    "spool": {"ratio": 0.6},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 19}},
    "setting": {"read": "pretension"},
}


@pytest.fixture(scope="module")
def question():
    """Return the question of one suit for 200 persons."""
    return question_of(study_from(STUDY))


@pytest.fixture(scope="module")
def windows(question):
    """Return the window of every person."""
    return GroupWindows.of(Solver(question), question.all_points())


@pytest.fixture
def by_need(question, windows):
    """Return the reasons at 148 N, each with the indices of its persons, by what they need."""
    persons = question.study.people.population.persons
    reasons = {}
    for reason in reasons_not_served(question, windows, 148.0, {}):
        members = np.array([persons.index(name) for name in reason.first])
        assert len(members) == reason.count
        reasons[reason.needs] = (reason, members)
    return reasons


@pytest.mark.parametrize("pretension", [100.0, 148.0, 260.0, np.nan])
def test_everyone_is_served_or_left_out_once(question, windows, pretension):
    reasons = reasons_not_served(question, windows, pretension, {})
    is_served = (windows.low <= pretension) & (pretension <= windows.high)
    assert sum(reason.count for reason in reasons) == (~is_served).sum()
    names = [name for reason in reasons for name in reason.first]
    assert len(set(names)) == len(names)
    persons = question.study.people.population.persons
    served = {persons[index] for index in np.flatnonzero(is_served)}
    assert not set(names) & served
    shares = [reason.share for reason in reasons]
    assert sum(shares) == pytest.approx((~is_served).mean())
    assert shares == sorted(shares, reverse=True)


def test_a_reason_says_which_pretension_is_needed_and_where_it_binds(question, windows, by_need):
    more, low = by_need[MORE]
    less, high = by_need[LESS]
    neither, empty = by_need[NEITHER]
    assert np.all(windows.low[low] > 148.0)
    assert np.all(np.diff(windows.low[low]) <= 0.0)  # the person who misses most comes first
    assert np.all(windows.high[high] < 148.0)
    assert np.all(windows.low[empty] > windows.high[empty])
    assert more.limits == ["extensor slack"]
    assert less.limits == ["min_elbow_stiffness"]
    assert neither.limits == ["extensor slack", "min_elbow_stiffness"]
    masses = question.condition_numbers["load.mass"]
    assert masses[more.conditions[0]] == 10.0
    assert masses[less.conditions[0]] == 0.0


def test_bodies_left_out_differ_as_their_means_say(question, by_need):
    body = question.study.people.population.body
    for reason, members in by_need.values():
        bodies = reason.bodies
        dimension = next(iter(bodies))
        largest = bodies[dimension]
        of_all = getattr(body, dimension)
        theirs = of_all[members]
        deviations = (theirs.mean() - of_all.mean()) / of_all.std()
        assert largest.theirs == pytest.approx(theirs.mean())
        assert largest.of_all == pytest.approx(of_all.mean())
        assert largest.deviations == pytest.approx(deviations)
        assert abs(largest.deviations) == max(abs(row.deviations) for row in bodies.values())
