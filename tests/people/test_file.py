"""Files of real persons are read as they come, completed by regression, or refused."""

import re

import numpy as np
import pytest

from tendon_cli.errors import InputError
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.studies.people.population import draw, read_population
from tendon_cli.studies.people.survey import SEXES, ansur2
from tests.sampled import quick_and_torture

SURVEY = ansur2()
HEADERS = [f"{name} ({'kg' if name == 'weight' else 'mm'})" for name in DIMENSIONS]


def read(text, sex="male", **options):
    """Return the population of a file given as text or bytes."""
    content = text if isinstance(text, bytes) else text.encode()
    return read_population(content, "people.csv", SURVEY, sex, **options)


def written(population):
    """Return a file with every dimension of a population."""
    per_si_unit = np.array([1.0 if name == "weight" else 1e3 for name in DIMENSIONS])
    rows = (population.values * per_si_unit).tolist()
    lines = [",".join(f"{value:.17g}" for value in row) for row in rows]
    return "\n".join([",".join(HEADERS), *lines])


def test_a_written_population_is_read_back():
    people = draw(SURVEY, "both", 50, seed=2)
    again = read(written(people))
    np.testing.assert_allclose(again.values, people.values, rtol=1e-15)
    assert again.names[:2] == ("person 1", "person 2")
    assert not any("expected value" in note for note in again.notes)


def test_missing_dimensions_are_those_of_a_regression_over_many_drawn_bodies():
    crowd = draw(SURVEY, "female", 200_000, seed=4).values
    weight = crowd[:, DIMENSIONS.index("weight")]
    stature = crowd[:, DIMENSIONS.index("stature")]
    known = np.column_stack([np.ones(len(crowd)), weight, stature])
    coefficients, *_ = np.linalg.lstsq(known, crowd, rcond=None)
    people = read("weight (kg),stature (cm)\n55,160\n80,172", sex="female")
    expected = np.array([[1, 55, 1.60], [1, 80, 1.72]]) @ coefficients
    np.testing.assert_allclose(people.values, expected, rtol=1e-3)
    note = next(note for note in people.notes if "expected value for women" in note)
    assert "biceps_circumference" in note
    assert " weight" not in note


def test_single_cells_may_be_missing_and_a_column_may_say_the_sex():
    people = read("sex,weight (kg),stature (cm)\nm,,180\nfemale,60,NA\nf,60,160", sex="both")
    man, woman, short_woman = people.body.weight
    assert man > 85.52  # taller than the mean man, so heavier than he
    assert woman == 60.0
    assert short_woman == 60.0
    assert people.body.stature[1] < SURVEY.female.mean[0]  # lighter than the mean woman, so shorter


def test_people_of_unknown_sex_are_completed_as_men_and_women_mixed():
    def weight(sex, **options):
        return read("stature (cm)\n169", sex=sex, **options).body.weight[0]

    mixed = weight("both")
    assert weight("female") < mixed < weight("male")
    assert mixed < weight("both", women=0.05)


def test_completions_scatter_as_bodies_of_whom_the_same_is_known():
    people = read(
        "name,weight (kg),stature (cm)\nAda,55,160\nBea,80,172",
        sex="female",
        bodies=8192,
        seed=3,
    )
    assert people.persons == ("Ada", "Bea")
    assert people.completions == 4096
    assert len(people) == 8192
    assert people.names[4095:4097] == ("Ada, body 4096", "Bea, body 1")
    assert set(people.sexes) == {"female"}
    expected = read("weight (kg),stature (cm)\n55,160\n80,172", sex="female").values
    known = [DIMENSIONS.index(name) for name in ("weight", "stature")]
    rest = [index for index in range(len(DIMENSIONS)) if index not in known]
    covariance = SURVEY.female.covariance
    # The conditional covariance, by the inverse of a block instead of the Schur complement.
    sigma = np.linalg.inv(np.linalg.inv(covariance)[np.ix_(rest, rest)])
    error = np.sqrt(np.diag(sigma) / 4096)
    least = SURVEY.female.mean - 3.0 * np.sqrt(np.diag(covariance)) - 1e-15
    for bodies, middle in zip(people.values.reshape(2, 4096, -1), expected, strict=True):
        assert np.all(bodies[:, known] == middle[known])
        difference = np.abs(bodies.mean(axis=0) - middle)
        assert np.all(difference[rest] < 4.5 * error)
        scatter = np.cov(bodies[:, rest].T)
        np.testing.assert_allclose(scatter, sigma, atol=0.1 * np.max(sigma), rtol=0.1)
        assert np.all(bodies >= least)


def test_as_many_bodies_as_persons_are_drawn_once_each():
    people = read("weight (kg)\n55\n80", bodies=2, seed=3)
    expected = read("weight (kg)\n55\n80")
    assert people.is_drawn
    assert (people.completions, people.names) == (1, ("person 1", "person 2"))
    assert (people.values != expected.values).any()
    assert len(read("weight (kg)\n55\n80\n70", bodies=4)) == 6


def test_completions_are_the_same_for_a_seed_and_leave_measured_dimensions_alone():
    text = "name,weight (kg),weighting\nAda,40,3\nBea,120,1"
    first = read(text, bodies=16, seed=1)
    same = read(text, bodies=16, seed=1)
    other = read(text, bodies=16, seed=2)
    np.testing.assert_array_equal(first.values, same.values)
    assert np.any(first.values != other.values)
    np.testing.assert_allclose(first.weighting, np.repeat([3 / 8, 1 / 8], 8))
    with_third = read(text + "\nCy,80,1", bodies=24)
    np.testing.assert_array_equal(with_third.values[:16], first.values)
    whole = draw(SURVEY, "male", 5, seed=2)
    measured = read(written(whole), bodies=15)
    np.testing.assert_allclose(measured.values, whole.values)
    assert not measured.is_drawn
    for sex in SEXES:
        assert np.all(draw(SURVEY, sex, 20_000, seed=1).values >= SURVEY.of(sex).least)


@pytest.mark.parametrize(
    ("header", "meant"),
    [
        ("Gewicht (kg)", '"weight (kg)"'),
        ("Größe (cm)", '"stature (cm)"'),
        ("Koerpergroesse [m]", '"stature (m)"'),
        ("Unterarmumfang_mm", '"forearm_circumference (mm)"'),
        ("Geschlecht", '"sex"'),
    ],
)
def test_german_headers_are_refused_with_what_they_would_be(header, meant):
    with pytest.raises(InputError, match=re.escape(header)) as error:
        read(f"name,stature (cm),{header}\nAda,168,62")
    assert f"write {meant}" in error.value.hint
    assert "wrist_circumference" in error.value.hint


@pytest.mark.parametrize(
    ("header", "meant"),
    [
        ("height (cm)", '"stature (cm)"'),
        ("heigth (cm)", '"stature (cm)"'),
        ("Body Height [m]", '"stature (m)"'),
        ("height_cm", '"stature (cm)"'),
        ("mass (kg)", '"weight (kg)"'),
        ("body_weight_kg", '"weight (kg)"'),
        ("weigth (kg)", '"weight (kg)"'),
        ("gender", '"sex"'),
    ],
)
def test_headers_by_other_english_words_are_refused_with_what_they_would_be(header, meant):
    with pytest.raises(InputError, match=re.escape(header)) as error:
        read(f"name,wrist_circumference (cm),{header}\nAda,16,62")
    assert f"write {meant}" in error.value.hint


def test_another_word_for_a_column_that_is_there_is_a_column_that_is_not_read():
    people = read("stature (cm),weight (kg),height (in)\n180,80,71")
    assert any(note.endswith("columns not read: height (in)") for note in people.notes)


def test_weighting_counts_as_given_and_one_person_is_enough():
    assert read("weight (kg),weighting\n70,1\n80,0\n90,2.5").weighting.tolist() == [1.0, 0.0, 2.5]
    assert "1 person" in read("weight (kg)\n70").notes[0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("weight (kg)\n70\n-1", "line 3.*weight is -1 kg"),
        (
            "weight (kg)\n70\n9 kg",
            'line 3.*weight is "9 kg", expected a number.*units belong in the header',
        ),
        ("weight (kg),weighting\n70,1\n80,-0.5", "line 3.*weighting is -0.5"),
        ("weight (kg),weighting\n70,1\n80,", "line 3.*weighting is empty"),
        ("weight (kg),weighting\n70,0\n80,0", "every weighting is 0"),
        (
            "name,weight (kg)\nAda,70\nBo,80\nAda,75",
            'line 4.*"Ada" is the name of two persons, the other in line 2',
        ),
        ("name,weight (kg)\nAda,70\n,80", "line 3.*without a name"),
        ("name,age\nAda,30", "no column is a dimension"),
        ("weight\n70", "the column weight has no unit.*kg"),
        ("weight (mm)\n70", '"mm" is a length.*units of mass: kg'),
        ("wieght (kg)\n70", r'not known.*write "weight \(kg\)"'),
        ("weight (kg),weight (lb)\n70,154", "two columns give the weight"),
        ("weight (kg),stature (m)\n70,1.7\nNA,", "line 3.*without any dimension"),
        ("sex,weight (kg)\nx,70", 'line 2.*sex is "x"'),
    ],
)
def test_faulty_files_are_refused_with_line_and_reason(text, message):
    with pytest.raises(InputError) as error:
        read(text)
    parts = (error.value.where, error.value.message, error.value.hint)
    whole = " ".join(filter(None, parts))
    assert re.search(message, whole), whole


@pytest.mark.parametrize("rows", quick_and_torture([50_000], [1_000_000]))
def test_very_many_rows_are_read(rows):
    people = read("weight (kg),stature (cm)\n" + "70.5,175\n80,181\n" * (rows // 2))
    assert len(people) == rows
    np.testing.assert_array_equal(people.values[2], people.values[0])
