"""How many of a crowd one pretension serves: counted one by one, and as the survey's facts have it."""

import numpy as np
import pytest

from tendon_cli.answers.people import person_of
from tendon_cli.answers.problem import question
from tendon_cli.answers.solve import solve
from tendon_cli.errors import StudyError
from tendon_cli.model import limits, window
from tendon_cli.space.axis import scale_of
from tendon_cli.studies.load import study_from
from tendon_cli.studies.people.person import worn_by
from tendon_cli.studies.spaces import named_axes
from tests.model import designs

LOADS = {"load": {"mass": [0.0, 3.0, 5.0, 10.0]}}


def solved(*contents, folder=None):
    study = study_from(
        {key: value for content in contents for key, value in content.items()}, folder=folder
    )
    problem = question(study)
    count = len(problem.choices)
    return problem, solve(problem, problem.choices.numbers(np.arange(count)), count)


def suit(stiffness, ratio):
    return {"spring": {"stiffness": stiffness}, "spool": {"ratio": ratio}}


@pytest.mark.parametrize(
    ("stiffness", "ratio", "share"),
    [
        (3e3, 1.0, 0.0),
        (1e3, 1.0, 0.0),
        (3e3, 0.7, 0.04),
        (5e3, 0.6, 0.70),
        (8e3, 0.6, 0.92),
        (5e3, 0.5, 0.975),
    ],
)
def test_the_share_that_one_pretension_serves_of_men_and_women_for_0_to_10_kg(
    stiffness, ratio, share
):
    _, found = solved({"people": {"count": 1000}}, LOADS, suit(stiffness, ratio))
    error = np.sqrt(max(share, 0.002) * (1.0 - share) / 1000)
    assert found["served"][0] == pytest.approx(share, abs=3.5 * error + 0.005)


def test_the_served_share_is_that_of_windows_counted_one_by_one(tmp_path):
    rows = ["name,weight (kg),stature (cm),weighting"]
    rows += [f"p{at},{55 + 2 * at},{155 + 1.5 * at},{at % 4}" for at in range(20)]
    (tmp_path / "people.csv").write_text("\n".join(rows), encoding="utf-8")
    problem, found = solved(
        {"people": {"file": "people.csv"}, "design": {"serve": 0.9}},
        LOADS,
        suit(5e3, [0.6, 0.65]),
        folder=tmp_path,
    )
    people = problem.study.people.population
    (axis,) = named_axes(problem.study)
    anchors = ("a1", "b1", "a2", "b2", "elbow_radius")
    scales = {f"arm.{name}": axis.numbers[scale_of(f"arm.{name}")] for name in anchors}
    numbers = {key: axis.numbers[key] for key in problem.study.of_the_body}
    for choice, ratio in enumerate((0.6, 0.65)):
        low, high = np.empty((20, 4)), np.empty((20, 4))
        for person in range(20):
            arm = {name.removeprefix("arm."): values[person] for name, values in numbers.items()}
            arm |= {
                name: designs.BASELINE[name] * scales[f"arm.{name}"][person]
                for name in ("a1", "b1", "a2", "b2")
            }
            arm["elbow_radius"] = 0.045 * scales["arm.elbow_radius"][person]
            for load, mass in enumerate((0.0, 3.0, 5.0, 10.0)):
                p = designs.baseline(**arm, load_mass=mass, ratio=ratio, spring_stiffness=5e3)
                one = window.window(
                    designs.design(p), problem.angles, problem.flexion, problem.bounds
                )
                low[person, load], high[person, load] = one.low, one.high
        most = low.max(axis=1)
        least = high.min(axis=1)
        shares = [people.weighting[(most <= at) & (at <= least)].sum() for at in [*most, *least]]
        assert found["served"][choice] == pytest.approx(
            max(shares) / people.weighting.sum(), abs=1e-12
        )


def test_a_person_without_equilibrium_is_not_served_and_not_dropped(tmp_path):
    text = "name,biceps circumference (cm),acromion radiale length (cm)\nAda,30,32\nOdd,75,13\n"
    (tmp_path / "people.csv").write_text(text, encoding="utf-8")
    arm = {
        "arm": {"a1": 0.08}
    }  # far in front of a short arm, the flexor passes the joint's centre before 90 degrees
    problem, found = solved(
        {"people": {"file": "people.csv"}}, arm, suit(5e3, 0.6), folder=tmp_path
    )
    windows = problem.windows(problem.choices.numbers(np.arange(1)), 1)
    assert np.isnan(windows.low[0]).tolist() == [False, True]
    assert limits.LIMIT_NAMES[windows.low_by[0, 1]] == "no equilibrium"
    assert found["served"][0] == 0.5


ROUGH = {
    "sheath": {"friction": {"mean": 0.09, "std": 0.02}},
    "uncertainty": {"draws": 64},
    "load": {"mass": [0.0, 5.0]},
}


def windows(problem):
    """The windows of pairs of person and draw, over their other conditions."""
    ends = problem.windows(problem.choices.numbers(np.arange(1)), 1)
    return ends.low.reshape(-1, 2).max(axis=1), ends.high.reshape(-1, 2).min(axis=1)


def test_few_persons_meet_every_draw_and_a_share_is_of_the_pairs(tmp_path):
    (tmp_path / "people.csv").write_text(
        "name,weight (kg),weighting\nAda,58,3\nBo,84,1\nCy,110,0\n"
    )
    problem, found = solved(
        ROUGH, {"people": {"file": "people.csv"}}, suit(5e3, 0.6), folder=tmp_path
    )
    assert (problem.counted, problem.counts) == ("pairs", {"person": 3, "draw": 64})
    low, high = windows(problem)
    serves = [
        ((low <= at) & (at <= high)).reshape(3, 64).mean(axis=1) @ [0.75, 0.25, 0.0]
        for at in np.sort(low)
    ]
    assert 0.0 < found["served"][0] == pytest.approx(max(serves), abs=1e-12)
    np.testing.assert_array_equal(person_of(problem, np.arange(192)), np.repeat(np.arange(3), 64))


def test_one_person_with_draws_is_as_their_arm_typed_in_with_draws(tmp_path):
    (tmp_path / "people.csv").write_text("name,weight (kg)\nAda,62\n")
    study = study_from({"people": {"file": "people.csv"}}, folder=tmp_path)
    arm = {
        name: values.array[0]
        for name, values in worn_by(study, "Ada").study.numbers.items()
        if "arm." in name
    }
    typed = {
        "arm": {
            name.removeprefix("arm."): float(value)
            for name, value in arm.items()
            if "angle" not in name
        }
    }
    of_person, one = solved(
        ROUGH, {"people": {"file": "people.csv"}}, suit(5e3, 0.6), folder=tmp_path
    )
    of_arm, other = solved(ROUGH, typed, suit(5e3, 0.6))
    assert (of_person.counted, of_arm.counted) == ("pairs", "draws")
    assert one["served"] == pytest.approx(other["served"], abs=1e-12)
    assert one["pretension"] == pytest.approx(other["pretension"], rel=1e-9)


def test_only_ratios_of_weightings_count(tmp_path):
    served = []
    for scale in (1.0, 1e-300, 1e308):
        rows = [
            f"p{at},{58 + 9 * at},{scale * weight!r}"
            for at, weight in enumerate((1.0, 0.5, 0.25, 0.75))
        ]
        (tmp_path / "people.csv").write_text("\n".join(["name,weight (kg),weighting", *rows]))
        limit = {"limits": {"max_tension": 450.0}, "design": {"serve": 0.3}}
        _, found = solved(
            LOADS, limit, {"people": {"file": "people.csv"}}, suit(5e3, 0.6), folder=tmp_path
        )
        served.append(float(found["served"][0]))
    assert 0.0 < served[0] < 1.0
    np.testing.assert_allclose(served, served[0], rtol=1e-12)


def test_bodies_drawn_of_a_person_are_pairs_of_the_person_and_a_draw(tmp_path):
    (tmp_path / "people.csv").write_text("name,sex,weight (kg),weighting\nAda,f,62,1\nBo,m,84,3\n")
    people = {"people": {"file": "people.csv", "completions": 32, "seed": 5}}
    problem, found = solved(
        LOADS, {**people, "design": {"by": "sex"}}, suit(5e3, 0.6), folder=tmp_path
    )
    assert (problem.counted, problem.counts) == ("pairs", {"person": 2, "draw": 32})
    ends = problem.windows(problem.choices.numbers(np.arange(1)), 1)
    low, high = ends.low.reshape(64, 4).max(axis=1), ends.high.reshape(64, 4).min(axis=1)
    serves = [
        ((low <= at) & (at <= high)).reshape(2, 32).mean(axis=1) @ [0.25, 0.75]
        for at in np.sort(low)
    ]
    assert found["served"][0] == pytest.approx(max(serves), abs=1e-12)
    assert study_from(problem.study.document()).hash == problem.study.hash
    with pytest.raises(StudyError, match=r"design\.by: gives shares of people"):
        study_from({"design": {"by": "sex"}})
    with pytest.raises(StudyError, match=r"people\.completions: .*names no file"):
        study_from({"people": {"completions": 8}})
