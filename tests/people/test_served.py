"""Share of a crowd that one pretension serves, counted one by one and over the whole survey."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.answers.people import person_of
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.worst import WORST
from tendon_cli.errors import StudyError
from tendon_cli.model import limits
from tendon_cli.studies.load import study_from
from tendon_cli.studies.people.person import person_study
from tendon_cli.studies.space.axis import scale_of
from tendon_cli.studies.spaces import named_axes
from tests.model import designs
from tests.people.in_full import in_full

MASSES = (0.0, 3.0, 5.0, 10.0)
LOADS = {"load": {"mass": list(MASSES)}}
FILE = {"people": {"file": "people.csv"}}


def solved(*contents, folder=None):
    """Return the question of a study in several parts, and its solutions."""
    content = {key: value for part in contents for key, value in part.items()}
    question = question_of(study_from(content, folder=folder))
    return question, solve(Solver(question), question.all_points())


def suit(stiffness, ratio):
    """Return the spring and the spool of a suit."""
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
    _, solutions = solved({"people": {"count": 1000}}, LOADS, suit(stiffness, ratio))
    error = np.sqrt(max(share, 0.002) * (1.0 - share) / 1000)
    assert solutions.served[0] == pytest.approx(share, abs=3.5 * error + 0.005)


def test_the_served_share_is_that_of_windows_counted_one_by_one(tmp_path):
    rows = ["name,weight (kg),stature (cm),weighting"]
    rows += [
        f"p{person},{55 + 2 * person},{155 + 1.5 * person},{person % 4}" for person in range(20)
    ]
    (tmp_path / "people.csv").write_text(in_full("\n".join(rows)), encoding="utf-8")
    ratios = (0.6, 0.65)
    question, solutions = solved(
        FILE, {"design": {"serve": 0.9}}, LOADS, suit(5e3, list(ratios)), folder=tmp_path
    )
    weighting = question.study.people.population.weighting
    (axis,) = named_axes(question.study)
    arms = {key.removeprefix("arm."): axis.numbers[key] for key in question.study.body_numbers}
    for name in ("a1", "b1", "a2", "b2"):
        arms[name] = designs.BASELINE[name] * axis.numbers[scale_of(f"arm.{name}")]
    arms["elbow_radius"] = 0.045 * axis.numbers[scale_of("arm.elbow_radius")]
    for choice, ratio in enumerate(ratios):
        low = np.empty((20, len(MASSES)))
        high = np.empty((20, len(MASSES)))
        for person in range(20):
            arm = {name: values[person] for name, values in arms.items()}
            for load, mass in enumerate(MASSES):
                design = designs.design(
                    designs.baseline(**arm, load_mass=mass, ratio=ratio, spring_stiffness=5e3)
                )
                ends = designs.window_of(design, question.angles, question.flexion, question.bounds)
                low[person, load] = ends.low
                high[person, load] = ends.high
        lows = low.max(axis=1)
        highs = high.min(axis=1)
        served = [
            weighting[(lows <= pretension) & (pretension <= highs)].sum()
            for pretension in [*lows, *highs]
        ]
        share = max(served) / weighting.sum()
        assert solutions.served[choice] == pytest.approx(share, abs=1e-12)


def test_a_person_without_equilibrium_is_not_served_and_not_dropped(tmp_path):
    text = "name,biceps circumference (cm),acromion radiale length (cm)\nAda,30,32\nOdd,75,13\n"
    (tmp_path / "people.csv").write_text(in_full(text), encoding="utf-8")
    # Far in front of a short arm, the flexor passes the joint's centre before 90 degrees.
    far_in_front = {"arm": {"a1": 0.08, "anchors": "mean man"}}
    question, solutions = solved(FILE, far_in_front, suit(5e3, 0.6), folder=tmp_path)
    ends = Solver(question).windows(question.all_points())
    assert np.isnan(ends.low[0]).tolist() == [False, True]
    assert limits.LIMIT_NAMES[ends.low_by[0, 1]] == "no equilibrium"
    assert solutions.served[0] == 0.5


ROUGH = {
    "sheath": {"friction": {"mean": 0.09, "std": 0.02}},
    "uncertainty": {"draws": 64},
    "load": {"mass": [0.0, 5.0]},
}


def share_of_pairs(question, conditions, weighting):
    """Return the largest share of pairs of person and draw that one pretension serves.

    Each pair has so many conditions; the weighting is that of the persons and sums to 1.
    """
    ends = Solver(question).windows(question.all_points())
    low = ends.low.reshape(-1, conditions).max(axis=1)
    high = ends.high.reshape(-1, conditions).min(axis=1)
    shares = []
    for pretension in np.sort(low):
        is_served = (low <= pretension) & (pretension <= high)
        served = is_served.reshape(len(weighting), -1).mean(axis=1)
        shares.append(served @ weighting)
    return max(shares)


def test_few_persons_meet_every_draw_and_a_share_is_of_the_pairs(tmp_path):
    (tmp_path / "people.csv").write_text(
        in_full("name,weight (kg),weighting\nAda,58,3\nBo,84,1\nCy,110,0\n")
    )
    question, solutions = solved(ROUGH, FILE, suit(5e3, 0.6), folder=tmp_path)
    assert question.groups.noun == "pairs"
    assert question.groups.counts == {"person": 3, "draw": 64}
    share = share_of_pairs(question, 2, [0.75, 0.25, 0.0])
    assert 0.0 < solutions.served[0] == pytest.approx(share, abs=1e-12)
    np.testing.assert_array_equal(person_of(question, np.arange(192)), np.repeat(np.arange(3), 64))


def test_one_person_with_draws_is_as_their_arm_typed_in_with_draws(tmp_path):
    (tmp_path / "people.csv").write_text(in_full("name,weight (kg)\nAda,62\n"))
    study = study_from(FILE, folder=tmp_path)
    arm = {}
    for key, values in person_study(study, "Ada").study.numbers.items():
        if "arm." in key and "angle" not in key:
            arm[key.removeprefix("arm.")] = float(values.array[0])
    # By a gauge, the reserve would be that of the arm on which the suit is set.
    of_f0 = {"setting": {"read": "pretension"}}
    of_person, person = solved(ROUGH, of_f0, FILE, suit(5e3, 0.6), folder=tmp_path)
    of_arm, typed = solved(ROUGH, of_f0, {"arm": arm}, suit(5e3, 0.6))
    assert of_person.groups.noun == "pairs"
    assert of_arm.groups.noun == "draws"
    assert person.served == pytest.approx(typed.served, abs=1e-12)
    assert person.pretension == pytest.approx(typed.pretension, rel=1e-9)


def test_only_ratios_of_weightings_count(tmp_path):
    limited = {"limits": {"max_tension": 450.0}, "design": {"serve": 0.3}}
    shares = []
    for scale in (1.0, 1e-300, 1e308):
        rows = [
            f"p{person},{58 + 9 * person},{scale * weight!r}"
            for person, weight in enumerate((1.0, 0.5, 0.25, 0.75))
        ]
        text = "\n".join(["name,weight (kg),weighting", *rows])
        (tmp_path / "people.csv").write_text(in_full(text))
        _, solutions = solved(LOADS, limited, FILE, suit(5e3, 0.6), folder=tmp_path)
        shares.append(float(solutions.served[0]))
    assert 0.0 < shares[0] < 1.0
    np.testing.assert_allclose(shares, shares[0], rtol=1e-12)


def test_bodies_drawn_of_a_person_are_pairs_of_the_person_and_a_draw(tmp_path):
    (tmp_path / "people.csv").write_text("name,sex,weight (kg),weighting\nAda,f,62,1\nBo,m,84,3\n")
    people = {"people": {"file": "people.csv", "seed": 5}}
    question, solutions = solved(
        LOADS, people, {"design": {"by": "sex"}}, suit(5e3, 0.6), folder=tmp_path
    )
    assert question.groups.noun == "pairs"
    assert question.groups.counts == {"person": 2, "draw": 128}
    share = share_of_pairs(question, 4, [0.25, 0.75])
    assert solutions.served[0] == pytest.approx(share, abs=1e-12)
    assert study_from(question.study.document()).hash == question.study.hash
    with pytest.raises(StudyError, match=r"design\.by: gives shares of people"):
        study_from({"design": {"by": "sex"}})


def test_a_choice_that_serves_nobody_has_no_worst_values():
    """The extensor's spool of the first choice is too thin for its tendon."""
    thin = {"limits": {"min_spool_to_tendon": 30}, "spool": {"ratio": [0.6, 0.8]}}
    content = {**thin, "spring": {"stiffness": [5e3, 8e3]}, "load": {"mass": 1.0}}
    choices = tendon.design({**content, "people": {"count": 3}}).choices
    is_thin = choices["spool_ratio"] == 0.6
    assert choices.loc[is_thin, list(WORST)].isna().all(axis=None)
    assert choices.loc[~is_thin, "max_tension"].notna().any()
