"""Bodies drawn from the survey are those of the survey, and the same ones for the same seed."""

import numpy as np
import pytest

from tendon_cli.errors import InputError
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.studies.people.population import draw, standard_person
from tendon_cli.studies.people.survey import SEXES, ansur2, cholesky, read_survey
from tests.people.own_statistics import MEAN, SIZE, written

SURVEY = ansur2()
MANY = 100_000


def deviations(statistics):
    """Return the standard deviation of every dimension, SI."""
    return np.sqrt(np.diag(statistics.covariance))


def correlations(covariance):
    """Return the matrix of correlations of a covariance."""
    scale = np.sqrt(np.diag(covariance))
    return covariance / np.outer(scale, scale)


@pytest.mark.parametrize("sex", SEXES)
def test_means_deviations_and_all_correlations_are_within_sampling_error(sex):
    statistics = SURVEY.of(sex)
    bodies = draw(SURVEY, sex, MANY, seed=3).values
    true_deviations = deviations(statistics)
    error = true_deviations / np.sqrt(MANY)
    assert np.all(np.abs(bodies.mean(axis=0) - statistics.mean) < 4.0 * error)
    relative = bodies.std(axis=0) / true_deviations - 1.0
    assert np.all(np.abs(relative) < 4.0 / np.sqrt(2 * MANY))
    true = correlations(statistics.covariance)
    difference = np.abs(np.corrcoef(bodies.T) - true)
    assert np.all(difference <= 4.5 * (1.0 - true**2) / np.sqrt(MANY) + 1e-12)


def test_the_survey_is_in_si_and_of_thousands():
    assert SURVEY.male.persons == 4082
    assert SURVEY.female.persons == 1986
    assert SURVEY.male.mean[DIMENSIONS.index("stature")] == pytest.approx(1.75621)
    assert SURVEY.female.mean[DIMENSIONS.index("weight")] == 67.76
    assert deviations(SURVEY.male)[DIMENSIONS.index("weight")] == pytest.approx(14.221)


def count_women(population):
    """Return how many women a drawn population has."""
    return sum(name.startswith("woman") for name in population.names)


def test_men_and_women_are_in_the_proportion_of_the_survey_unless_it_is_given():
    people = draw(SURVEY, "both", 6068, seed=1)
    assert count_women(people) == 1986
    assert count_women(draw(SURVEY, "both", 10, 1, women=0.5)) == 5
    assert len(set(people.names)) == 6068


def test_a_seed_gives_the_same_bodies_and_a_larger_count_begins_with_those_of_a_smaller():
    few = draw(SURVEY, "male", 10, seed=7)
    many = draw(SURVEY, "male", 1000, seed=7)
    np.testing.assert_array_equal(few.values, many.values[:10])
    assert not np.any(few.values == draw(SURVEY, "male", 10, seed=8).values)
    both = draw(SURVEY, "both", 10, seed=7)
    np.testing.assert_array_equal(both.values[:7], few.values[:7])
    np.testing.assert_array_equal(both.values[7:], draw(SURVEY, "female", 3, seed=7).values)


def test_men_and_women_mixed_have_the_moments_of_a_mixed_crowd():
    crowd = draw(SURVEY, "both", MANY, seed=5, women=0.4).values
    mixed = SURVEY.both(0.4)
    error = deviations(mixed) / np.sqrt(MANY)
    assert np.all(np.abs(crowd.mean(axis=0) - mixed.mean) < 4.0 * error)
    np.testing.assert_allclose(np.cov(crowd.T), mixed.covariance, rtol=0.03)


def test_the_mean_man_is_the_one_for_whom_the_anchors_are_given():
    man = standard_person(SURVEY, "mean-man")
    assert man.body.weight == [85.52]
    reference = [getattr(man.reference, name) for name in DIMENSIONS]
    np.testing.assert_array_equal(man.values[0], reference)
    assert standard_person(SURVEY, "mean-woman").body.weight == [67.76]


# --- Faulty statistics ----------------------------------------------------------------------------


def with_correlation(value, *places):
    """Return a matrix of correlations that are zero but for some places and their mirrors."""
    matrix = np.eye(SIZE)
    for row, column in places:
        matrix[row, column] = value
        matrix[column, row] = value
    return matrix.tolist()


def test_statistics_of_ones_own_are_read():
    survey = read_survey(written().encode(), "own.toml")
    assert survey.male.mean[0] == 1.0
    assert survey.share_of_women == pytest.approx(1 / 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (written(with_correlation(-0.9, (0, 1), (0, 2), (1, 2))), "not positive definite"),
        (written(with_correlation(1.0, (3, 4))), "forearm_grip_length follows from the others"),
        (written((np.eye(SIZE) + np.eye(SIZE, k=1) * 0.1).tolist()), "not symmetric"),
        (written(standard_deviation=[0.0] * SIZE), "not above 0"),
        (written(mean=[1.0]), "does not have persons, 8 means"),
        (written(mean=[3000.0, *MEAN[1:]]), "the mean stature is 3000 mm, expected 800 to 2500 mm"),
        (
            written(standard_deviation=[1.0, 30.0, *[1.0] * (SIZE - 2)]),
            "the deviation of weight is 30 kg",
        ),
        (written(persons=0), "does not have persons, 8 means"),
        ("[[[[" * 20, "not statistics"),
        (written(mean="nan"), "does not have persons, 8 means"),
        (written().replace("stature", "size"), "its dimensions lack stature"),
        ("[male", "not statistics"),
        ("dimensions = 5", "not statistics"),
    ],
)
def test_faulty_statistics_are_refused(text, message):
    with pytest.raises(InputError, match=message):
        read_survey(text.encode(), "own.toml")


def test_the_factor_of_a_matrix_gives_it_back():
    random = np.random.default_rng(0)
    half = random.normal(size=(SIZE, SIZE))
    matrix = half @ half.T
    factor = cholesky(matrix)
    np.testing.assert_allclose(factor @ factor.T, matrix, rtol=1e-10, atol=1e-12)
    assert np.all(np.triu(factor, 1) == 0.0)
