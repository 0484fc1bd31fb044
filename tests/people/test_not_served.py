"""Who is left out, and why: every person counted once, each with a reason that the model itself confirms."""

import numpy as np
import pytest

from tendon_cli.answers.people import GroupWindows, not_served
from tendon_cli.answers.phrases import LESS, MORE, NEITHER
from tendon_cli.answers.problem import question
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
    return problem, GroupWindows.of(problem, {})


def by_need(found):
    """The reasons of those not served at 148 N, and their places among the persons, by what they need."""
    problem, windows = found
    reasons, persons = not_served(problem, windows, 148.0), problem.study.people.population.persons
    places = [np.array([persons.index(name) for name in reason["first"]]) for reason in reasons]
    assert [len(each) for each in places] == [reason["count"] for reason in reasons]
    return {reason["needs"]: (reason, each) for reason, each in zip(reasons, places, strict=True)}


@pytest.mark.parametrize("pretension", [100.0, 148.0, 260.0, np.nan])
def test_everyone_is_served_or_left_out_once(found, pretension):
    problem, windows = found
    reasons = not_served(problem, windows, pretension)
    served = (windows.low <= pretension) & (pretension <= windows.high)
    assert sum(reason["count"] for reason in reasons) == (~served).sum()
    names = [name for reason in reasons for name in reason["first"]]
    assert len(set(names)) == len(names)
    assert not set(names) & {
        problem.study.people.population.persons[at] for at in np.flatnonzero(served)
    }
    shares = [reason["share"] for reason in reasons]
    assert sum(shares) == pytest.approx((~served).mean())
    assert shares == sorted(shares, reverse=True)


def test_a_reason_says_what_is_needed_and_where_it_binds(found):
    problem, windows = found
    (more, low), (less, high), (neither, none) = (
        by_need(found)[need] for need in (MORE, LESS, NEITHER)
    )
    assert np.all(windows.low[low] > 148.0)
    assert np.all(np.diff(windows.low[low]) <= 0.0)  # who misses most stands first
    assert np.all(windows.high[high] < 148.0)
    assert np.all(windows.low[none] > windows.high[none])
    assert (more["limits"], less["limits"]) == (["extensor slack"], ["min_elbow_stiffness"])
    assert neither["limits"] == ["extensor slack", "min_elbow_stiffness"]
    masses = problem.condition_numbers["load.mass"]
    assert [masses[reason["conditions"][0]] for reason in (more, less)] == [10.0, 0.0]


def test_bodies_left_out_differ_as_their_means_say(found):
    body = found[0].study.people.population.body
    for reason, members in by_need(found).values():
        (first, each), *_ = reason["bodies"].items()
        of_all = getattr(body, first)
        theirs = of_all[members]
        assert (each["theirs"], each["of_all"]) == pytest.approx((theirs.mean(), of_all.mean()))
        assert each["deviations"] == pytest.approx((theirs.mean() - of_all.mean()) / of_all.std())
        assert abs(each["deviations"]) == max(
            abs(one["deviations"]) for one in reason["bodies"].values()
        )
