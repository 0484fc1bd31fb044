"""A fresh sample judges what was chosen: it has no part in the choice, and so it is not biased."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli import say
from tendon_cli.engine.windows.coverage import (
    effective_count,
    effective_count_of_strata,
)
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve, solve_windows
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.verification import Verifier
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.studies.fresh_sample import fresh_sample
from tendon_cli.studies.load import study_from
from tendon_cli.studies.values import OF_FRESH_DRAWS, draw_numbers
from tendon_cli.verbs.answer_record import named_first
from tests.people.in_full import in_full

MOTION = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}}
LOADS = {"load": {"mass": [0.0, 10.0]}, "motion": MOTION}
SUIT = {"spring": {"stiffness": 5e3}, "spool": {"ratio": 0.5}}
SIXTEEN = {
    "spring": {"stiffness": [4.6e3, 4.8e3, 5.0e3, 5.2e3]},
    "spool": {"ratio": [0.49, 0.5, 0.51, 0.52]},
}
ROUGH = {"sheath": {"friction": "0.09 +/- 0.02"}, "uncertainty": {"draws": 64}}
FILE = {"people": {"file": "people.csv"}}
THREE = "name,weight (kg),stature (cm),weighting\nAda,55,158,1\nBo,95,192,3\nCy,75,176,2\n"

JUDGED_BY_ALL = True


def study_of(*contents, folder=None):
    """Return a study of several parts, of which a later one goes before."""
    content = {}
    for part in contents:
        for key, value in part.items():
            content[key] = {**content.get(key, {}), **value}
    return study_from(content, folder=folder)


def people(count, seed=1, **design):
    """Return parts of a study about persons that are drawn."""
    return {"people": {"count": count, "seed": seed}, "design": design}


def group_windows(study):
    """Return the ends of the windows of a study's groups, (choices, groups) each."""
    question = question_of(study)
    solver = Solver(question)
    ends = solver.ends(question.all_points())
    return question.groups.windows(ends.low, ends.high)


def judged(study):
    """Return the first choice of a study, solved, and the judgement of the fresh sample on it."""
    solver = Solver(question_of(study))
    choice = solve(solver, solver.question.points(np.array([0])))
    (verdict,) = Verifier.of(solver).judge(choice.points, choice.pretension)
    return choice, verdict


# --- The sample -----------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [500, 1000, 20_000])
@pytest.mark.parametrize("seed", [1, 2**40])
def test_no_fresh_body_is_among_those_of_the_study_however_many_it_has(count, seed):
    study = study_of(people(count, seed), SUIT)
    fresh = study.people.fresh(10_000)
    own = study.people.population
    assert not set(map(bytes, fresh.values)) & set(map(bytes, own.values))
    error = own.values.std(axis=0) * np.sqrt(1.0 / count + 1e-4)
    assert np.all(np.abs(fresh.values.mean(axis=0) - own.values.mean(axis=0)) < 4.5 * error)


def test_the_fresh_sample_does_not_depend_on_the_number_of_persons_of_the_study():
    few = fresh_sample(study_of(people(10), SUIT))
    many = fresh_sample(study_of(people(3000), SUIT))
    assert len(few) == len(many) == 10_000
    for key, values in few.axis.numbers.items():
        np.testing.assert_array_equal(values, many.axis.numbers[key])
    other = fresh_sample(study_of(people(10, seed=2), SUIT))
    assert any((other.axis.numbers[key] != few.axis.numbers[key]).any() for key in few.axis.numbers)


def fresh_numbers(uncertain, count, seed):
    return draw_numbers(uncertain, count, seed, sampler="random", stream=OF_FRESH_DRAWS)


def test_fresh_draws_are_independent_of_each_other_and_of_the_studys():
    uncertain = study_of(ROUGH, SUIT).uncertain
    fresh = fresh_numbers(uncertain, 4096, 1)["sheath.friction"]
    own = draw_numbers(uncertain, 4096, 1)["sheath.friction"]
    assert not np.isin(fresh, own).any()
    # Sobol points are spread evenly, and their mean is known far better than that of others.
    error = own.std() / 64
    errors = [
        fresh_numbers(uncertain, 64, seed)["sheath.friction"].mean() - own.mean()
        for seed in range(200)
    ]
    assert np.std(errors) == pytest.approx(own.std() / 8, rel=0.2)
    assert abs(fresh.mean() - own.mean()) < 4.0 * error


def test_each_fresh_person_has_a_draw_of_its_own():
    study = study_of(people(20), ROUGH, SUIT)
    sample = fresh_sample(study)
    assert len(sample) == 10_000
    friction = sample.axis.numbers["sheath.friction"]
    bodies = sample.axis.numbers["arm.forearm_mass"]
    assert len(np.unique(friction)) == 10_000
    assert abs(np.corrcoef(friction, bodies)[0, 1]) < 0.04


def test_persons_of_a_file_are_the_same_with_draws_of_their_own(tmp_path):
    (tmp_path / "people.csv").write_text(THREE, encoding="utf-8")
    drawn = {"people": {"file": "people.csv", "seed": 3}, "design": {"verify": 100}}
    study = study_of(drawn, SUIT, folder=tmp_path)
    sample = fresh_sample(study)
    assert (len(sample), sample.persons) == (102, 3)
    np.testing.assert_array_equal(sample.strata, np.repeat([0, 1, 2], 34))
    np.testing.assert_allclose(sample.weighting * 34 * 6, np.repeat([1, 3, 2], 34) * 6)
    fresh = study.people.fresh(100).values
    own = study.people.population.values
    weight = fresh[:, DIMENSIONS.index("weight")]
    np.testing.assert_allclose(weight, np.repeat([55.0, 95.0, 75.0], 34))
    is_missing = np.ptp(own[:16], axis=0) > 0.0
    assert is_missing.sum() == 6
    assert not np.isin(fresh[:, is_missing], own[:, is_missing]).any()


def test_without_draws_a_file_has_no_fresh_sample_and_the_answer_says_so(tmp_path):
    (tmp_path / "people.csv").write_text(in_full(THREE), encoding="utf-8")
    study = study_of(FILE, LOADS, SUIT, folder=tmp_path)
    assert fresh_sample(study) is None
    answer = tendon.design(study)
    assert answer.best["served_verified"] is None
    assert "nothing is drawn for these persons" in " ".join(answer.text.split())


# --- The judgement --------------------------------------------------------------------------------


@pytest.mark.parametrize("serve", [0.9, 1.0])
@pytest.mark.parametrize("more", [{}, ROUGH], ids=["persons", "persons with draws"])
def test_the_judgement_is_that_of_a_large_independent_population(serve, more):
    choice, verdict = judged(study_of(people(50, serve=serve), more, LOADS, SUIT))
    once = {"uncertainty": {"draws": 64}} if more else {}
    low, high = group_windows(study_of(people(10_000, seed=99), more, once, LOADS, SUIT))
    pretension = choice.pretension[0]
    truth = np.mean((low[0] <= pretension) & (pretension <= high[0]))
    error = np.sqrt(truth * (1.0 - truth) * (1.0 / 10_000 + 1.0 / 10_000))
    assert verdict.value == pytest.approx(truth, abs=4.0 * error + 1e-4)
    if serve == 1.0:
        assert np.isnan(verdict.low) or verdict.value <= 1.0
        return
    for end in (verdict.low, verdict.high):
        of_truth = np.mean((low[0] <= end) & (end <= high[0]))
        assert of_truth == pytest.approx(serve, abs=0.012)


def test_the_judgement_of_draws_is_that_of_many_others():
    study = study_of(ROUGH, LOADS, SUIT, {"design": {"serve": 0.9}})
    choice, verdict = judged(study)
    numbers = draw_numbers(study.uncertain, 2**15, 7)
    many = {"uncertainty": {"draws": 2**15, "seed": 7}}
    low, high = group_windows(study_of(ROUGH, many, LOADS, SUIT))
    assert low.shape == (1, len(numbers["sheath.friction"]))
    pretension = choice.pretension[0]
    truth = np.mean((low[0] <= pretension) & (pretension <= high[0]))
    assert verdict.value == pytest.approx(truth, abs=0.02)
    assert verdict.interval[0] <= truth <= verdict.interval[1]


def test_weights_count_in_the_share_and_its_interval(tmp_path):
    (tmp_path / "people.csv").write_text(THREE, encoding="utf-8")
    parts = (FILE, ROUGH, LOADS, SUIT)
    choice, verdict = judged(study_of(*parts, {"design": {"serve": 0.5}}, folder=tmp_path))
    pretension = choice.pretension[0]
    low, high = verdict.windows
    is_served = (low <= pretension) & (pretension <= high)
    of_each = is_served.reshape(3, -1).mean(axis=1)
    assert verdict.value == pytest.approx(of_each @ [1 / 6, 3 / 6, 2 / 6], abs=1e-3)
    # The persons are known, so that only their draws make the share uncertain.
    simple = say.interval(verdict.value, effective_count(verdict.sample.weighting))
    assert np.diff(verdict.interval) <= np.diff(simple)


@pytest.mark.parametrize("members", [30, 500])
def test_intervals_of_stratified_samples_cover_what_they_say(members):
    random = np.random.default_rng(5)
    shares = np.array([0.999, 0.97, 0.6])
    weights = np.array([1.0, 3.0, 2.0])
    truth = weights @ shares / weights.sum()
    strata = np.repeat([0, 1, 2], members)
    covered = []
    for _ in range(2000):
        is_served = random.random(len(strata)) < shares[strata]
        weighting = weights[strata]
        count = effective_count_of_strata(is_served, weighting, strata)
        share = weighting @ is_served / weighting.sum()
        low, high = say.interval(share, count)
        covered.append(low <= truth <= high)
    assert 0.93 <= np.mean(covered) <= 0.985


# --- Chosen and judged ----------------------------------------------------------------------------


def shares_said(repeats, persons, verify, crowds):
    """Return shares of chosen suits: by their own sample, judged, its interval, and the truth.

    Each repeat chooses from sixteen suits, of which one serves about as many as the next. The truth
    is the share of so many crowds of 20,000.
    """
    seeds = 10**6 + np.arange(crowds)
    crowd = [group_windows(study_of(people(20_000, int(s)), LOADS, SIXTEEN)) for s in seeds]
    low, high = np.concatenate(crowd, axis=2)
    rows = []
    for seed in range(repeats):
        study = study_of(people(persons, seed, verify=verify), LOADS, SIXTEEN)
        solver = Solver(question_of(study))
        choices, _ = solve_windows(solver, solver.question.all_points())
        place = int(np.argmax(choices.served_at))
        pretension = choices.pretension[place]
        chosen = choices.select([place])
        (verdict,) = Verifier.of(solver).judge(chosen.points, chosen.pretension)
        truth = np.mean((low[place] <= pretension) & (pretension <= high[place]))
        rows.append([choices.served_at[place], verdict.value, *verdict.interval, truth])
    return np.array(rows).T


def test_the_share_that_is_said_of_a_chosen_suit_is_not_biased():
    own, value, low, high, truth = shares_said(20, persons=100, verify=1000, crowds=1)
    assert np.mean(own - truth) > 0.0
    assert abs(np.mean(value - truth)) < 0.004
    assert np.mean((low <= truth) & (truth <= high)) >= 0.8


@pytest.mark.torture
def test_over_300_repeats_the_share_is_unbiased_and_its_interval_covers():
    own, value, low, high, truth = shares_said(300, persons=500, verify=10_000, crowds=10)
    assert np.mean(own - truth) > 0.0
    assert abs(np.mean(value - truth)) < 0.002
    assert 0.92 <= np.mean((low <= truth) & (truth <= high)) <= 0.98


# --- The answer -----------------------------------------------------------------------------------

JUDGES = 1000
REFUTED = {"spring": {"stiffness": [4.1e3, 4.2e3]}, "spool": {"ratio": [0.5, 0.51]}}


@pytest.fixture(scope="module")
def too_few():
    """Return an answer of which no choice serves enough."""
    unadvised = {"design": {"advice": False}}
    judged = people(200, verify=JUDGES)
    return tendon.design(study_of(judged, LOADS, REFUTED, unadvised))


def helping(answer):
    """Return the changes that would help, by the key of the number."""
    record = answer.record
    changes = [(fix["parameter"], fix) for fix in record["fixes"] if fix["after"] is not None]
    return changes + [(of["key"], of) for of in record["would_take"] if of["after"] is not None]


def test_a_choice_that_serves_too_few_is_not_named(too_few):
    assert too_few.best is None
    assert too_few.is_negative
    assert too_few.choices["served_at"].max() < 0.98


def test_what_it_would_take_is_judged_by_the_fresh_sample(too_few):
    assert helping(too_few)
    for key, change in helping(too_few):
        assert change["served_verified"]["value"] >= 0.95, key
        assert change["served_verified"]["of"] == JUDGES


def test_what_is_said_to_help_does_so_at_the_pretension_that_is_printed(too_few):
    changes = helping(too_few)
    assert {key for key, _ in changes} >= {"load.mass", "spool.ratio"}
    nearest = named_first(too_few.answer)
    for key, change in changes:
        named = change.get("values") or nearest.columns
        chosen = {
            "spring": {"stiffness": named["spring_stiffness"]},
            "spool": {"ratio": named["spool_ratio"]},
        }
        table, name = key.split(".")
        value = [0.0, change["after"]] if key == "load.mass" else change["after"]
        judged = people(200, verify=JUDGES)
        study = study_of(judged, LOADS, chosen, {table: {name: value}})
        solver = Solver(question_of(study))
        points = solver.question.all_points()
        pretension = float(change["printed_pretension"])
        (again,) = Verifier.of(solver).judge(points, np.array([pretension]))
        assert again.value == change["served_verified"]["value"], key
        own = solve(solver, points)
        assert own.pretension_from[0] <= pretension <= own.pretension_to[0], key


def test_shares_by_sex_and_the_curve_are_those_of_the_fresh_sample():
    stated = {"design": {"by": "sex", "serve": 0.8}, "setting": {"read": "pretension"}}
    answer = tendon.design(study_of(people(40, verify=JUDGES), LOADS, SUIT, stated))
    population = answer.record["population"]
    verdict = answer.best["served_verified"]
    assert population["served_verified"] == verdict
    assert sum(share["persons"] for share in population["by"]) == JUDGES
    of_all = sum(share["persons"] * share["served"] for share in population["by"])
    assert of_all / JUDGES == pytest.approx(verdict["value"], abs=1e-9)
    curve = population["curve"]
    place = np.searchsorted(curve["pretension"], answer.best["pretension"]) - 1
    assert curve["share"][place] == pytest.approx(verdict["value"], abs=0.01)
    assert len(answer.persons) == 40


def test_without_a_fresh_sample_the_answer_is_judged_by_its_own(too_few):
    answer = tendon.design(too_few.study.vary(**{"design.verify": 0, "design.serve": 0.9}))
    assert answer.best["served_verified"] is None
    assert answer.best["served_at"] >= 0.9
    assert not answer.is_negative
    assert "[design] verify = 0" in " ".join(answer.text.split())


def test_every_named_choice_is_judged_and_no_other(tmp_path):
    goals = {
        "design": {
            "minimise": ["max_tension"],
            "maximise": ["served"],
            "prove": ["0"],
            "verify": 400,
        }
    }
    study = study_of(people(60), LOADS, SIXTEEN, goals)
    answer = tendon.design(study, tmp_path / "answer")
    record = answer.record
    named = [record["best"], *record["front"], *record["proved"]]
    for row in named:
        verdict = row["served_verified"]
        assert verdict["of"] == 400
        assert verdict["interval_95"][0] <= verdict["value"] <= verdict["interval_95"][1]
        in_table = answer.choices.loc[row["choice"]]
        assert in_table["served_verified"] == verdict["value"]
        assert in_table["served_verified_low"] == verdict["interval_95"][0]
        assert in_table["served_verified_high"] == verdict["interval_95"][1]
        for end in ("from", "to"):
            expected = np.nan if verdict[end] is None else verdict[end]
            np.testing.assert_equal(in_table[f"verified_{end}"], expected)
        assert row["feasible"] == (verdict["value"] >= 0.95)
    others = answer.choices.index.difference([row["choice"] for row in named])
    assert answer.choices.loc[others, "served_verified"].isna().all()


def test_a_repaired_answer_has_the_same_bytes(tmp_path):
    study = study_of(people(4, verify=100, serve=0.3), ROUGH, LOADS, SUIT)
    first = tendon.design(study, tmp_path / "first")
    again = tendon.design(study, tmp_path / "again", jobs=2)
    (again.folder / "choices.parquet").unlink()
    again = tendon.design(study, again.folder, resume=True)
    for name in ("choices.parquet", "persons.parquet"):
        assert (first.folder / name).read_bytes() == (again.folder / name).read_bytes()
    assert first.record["best"] == again.record["best"]


# --- Fewer judges ---------------------------------------------------------------------------------


def test_a_thinned_sample_is_a_part_of_it():
    sample = fresh_sample(study_of(people(40, by="sex", verify=400), ROUGH, SUIT))
    few = sample.thinned(50)
    assert len(few) == len(few.sexes) == 50
    assert sample.thinned(400) is sample
    rows = np.round(np.linspace(0, 399, 50)).astype(int)
    for key, values in sample.axis.numbers.items():
        np.testing.assert_array_equal(few.axis.numbers[key], values[rows])
    np.testing.assert_array_equal(few.weighting, sample.weighting[rows])
    np.testing.assert_array_equal(few.strata, sample.strata[rows])
    assert few.sexes == tuple(sample.sexes[row] for row in rows)


def test_a_thinned_judge_asks_the_members_that_are_left():
    speed = {"motion": {**MOTION, "speed": "60 deg/s"}}
    parts = (ROUGH, SUIT, LOADS, {"design": {"verify": 5000}})
    for more in ({}, {**speed, "limits": {"peak_motor_power": "20 W"}}):
        judge = Verifier.of(Solver(question_of(study_of(*parts, more))))
        few = judge.thinned(300)
        assert len(few.sample) == len(few.solver.question.groups) == 300
        assert judge.thinned(5000) is judge
