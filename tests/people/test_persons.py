"""The table of persons: a row each under the choice named first, against solving each person alone."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.figures.served import members
from tendon_cli.tables.schema import as_numpy

COARSE = {
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    "load": {"mass": [0.0, 10.0]},
}
SUIT = {**COARSE, "spring": {"stiffness": [5e3, 8e3]}, "spool": {"ratio": 0.6}}
RUBBING = {"sheath": {"friction": {"mean": 0.08, "std": 0.04}}, "uncertainty": {"draws": 32}}
FEW = {**SUIT, "people": {"count": 4}, **RUBBING, "limits": {"max_tension": "520 N"}}


@pytest.fixture(scope="module")
def answer():
    return tendon.design(tendon.study({**SUIT, "people": {"count": 40, "seed": 3}}))


def test_a_person_in_the_table_is_the_person_alone(answer):
    best = answer.best
    for row in answer.persons.sample(4, random_state=1).itertuples():
        given = {
            **SUIT,
            "spring": {"stiffness": best["spring_stiffness"]},
            "people": {"count": 40, "seed": 3},
        }
        swept = tendon.sweep(
            tendon.study({**given, "tendon": {"pretension": best["pretension"]}})
        ).designs
        mine = swept[swept["person"] == row.person]
        assert mine["pretension_from"].max() == pytest.approx(row.pretension_from, rel=1e-12)
        assert mine["pretension_to"].min() == pytest.approx(row.pretension_to, rel=1e-12)
        assert mine["feasible"].all() == (row.served == 1.0)


def test_shares_of_the_record_are_those_of_the_table(answer):
    population, persons = answer.record["population"], answer.persons
    assert len(persons) == population["count"] == 40
    assert persons["served"].mean() == pytest.approx(population["served"], abs=1e-12)
    assert set(persons["sex"]) == {"male", "female"}
    table = answer.table("persons")
    rows = {name: as_numpy(table.column(name)) for name in table.column_names}
    out = [members(rows, reason, population["pretension"]) for reason in population["not_served"]]
    assert [len(each) for each in out] == [reason["count"] for reason in population["not_served"]]
    assert len(np.unique(np.concatenate([np.empty(0), *out]))) == (persons["served"] < 1.0).sum()


def test_the_tensions_to_set_are_of_each_body(answer):
    best, persons = answer.best, answer.persons
    assert persons["set_flexor_tension"].nunique() == 40
    asked = {
        **SUIT,
        "spring": {"stiffness": best["spring_stiffness"]},
        "people": {"count": 40, "seed": 3},
    }
    asked |= {"load": {"mass": 0.0}, "motion": {"direction": "extension", "elbow_angle": 0.0}}
    states = tendon.sweep(
        tendon.study({**asked, "tendon": {"pretension": best["pretension"]}})
    ).states
    for end, place in (("", "distal"), ("_motor", "proximal")):
        expected = states[f"extensor_tension_{place}"].to_numpy()
        np.testing.assert_allclose(persons[f"set_extensor_tension{end}"], expected, rtol=1e-12)


def test_few_persons_are_served_by_the_share_of_their_draws():
    answer = tendon.design(tendon.study(FEW))
    population, persons = answer.record["population"], answer.persons
    assert (population["kind"], population["count"], len(persons)) == ("pairs", 4 * 32, 4)
    assert persons["served"].mean() == pytest.approx(population["served"], abs=1e-12)
    assert ((persons["served"] * 32) % 1.0 < 1e-9).all()
    assert "128 pairs of 4 persons and 32 draws" in " ".join(answer.text.split())


def test_one_person_is_this_person_with_and_without_draws():
    of_draws, alone = (
        " ".join(tendon.design(tendon.study({**suit, "people": {"count": 1}})).text.split())
        for suit in (FEW, SUIT)
    )
    assert "this person's 32 draws" in of_draws
    assert "1 person" not in of_draws
    assert "N suits this person; anything from" in alone
    assert "N works for this person" in alone
    assert "%" not in alone.split("For whom")[1].split("Sizes")[0].split("Note")[0]


def test_a_person_of_several_bodies_has_one_row_over_them(tmp_path):
    (tmp_path / "people.csv").write_text("name,sex,weight (kg),weighting\nAda,f,62,1\nBo,m,84,3\n")
    people = {"file": str(tmp_path / "people.csv"), "completions": 16}
    answer = tendon.design(tendon.study({**SUIT, "spring": {"stiffness": 5e3}, "people": people}))
    persons, population = answer.persons, answer.record["population"]
    assert list(persons["person"]) == ["Ada", "Bo"]
    np.testing.assert_allclose(persons["weighting"], [1.0, 3.0])
    np.testing.assert_allclose(persons["weight"], [62.0, 84.0], rtol=1e-12)
    assert ((persons["served"] * 16) % 1.0 < 1e-9).all()
    assert np.average(persons["served"], weights=persons["weighting"]) == pytest.approx(
        population["served"], abs=1e-12
    )
    alone = tendon.design(
        tendon.study(
            {
                **SUIT,
                "spring": {"stiffness": 5e3},
                "people": people | {"sex": "female"},
                "design": {"pretension": population["pretension"]},
            }
        )
    ).persons
    np.testing.assert_allclose(
        alone["set_flexor_tension"], persons["set_flexor_tension"], rtol=1e-9
    )


def test_draws_have_a_table_of_their_own():
    answer = tendon.design(tendon.study({**SUIT, **RUBBING}))
    draws = answer.table("draws")
    assert draws.num_rows == 32
    assert "weight" not in draws.schema.names


def test_shares_by_sex_are_those_of_the_table():
    asked = {
        **SUIT,
        "spring": {"stiffness": 5e3},
        "people": {"count": 80, "seed": 3},
        "design": {"by": "sex"},
    }
    answer = tendon.design(tendon.study(asked))
    shares = {each["sex"]: each for each in answer.record["population"]["by"]}
    served = answer.persons.groupby("sex", observed=True)["served"]
    for sex, mean in served.mean().items():
        assert shares[sex]["served"] == pytest.approx(mean, abs=1e-12)
        assert shares[sex]["interval_95"][0] <= mean <= shares[sex]["interval_95"][1]
        assert shares[sex]["persons"] == served.count()[sex]
    assert "women (" in answer.text


def test_the_reading_that_is_set_is_the_same_on_everyone_and_the_other_one_is_not(tmp_path):
    (tmp_path / "people.csv").write_text("name,weight (kg),stature (cm)\nAda,62,168\nBob,85,181\n")
    people = {"file": str(tmp_path / "people.csv"), "completions": 16}
    answer = tendon.design(
        tendon.study({**SUIT, "people": people, "setting": {"read": "flexor at joint"}})
    )
    persons, population = answer.persons, answer.record["population"]
    np.testing.assert_allclose(persons["set_flexor_tension"], population["pretension"], rtol=1e-12)
    assert persons["set_extensor_tension"].nunique() == 2
    low, high = population["set"]["set_extensor_tension"]
    assert (
        low < persons["set_extensor_tension"].min() < persons["set_extensor_tension"].max() < high
    )
    assert "tension in the flexor at the joint" in " ".join(answer.text.split())
    for table in ("choices", "persons"):
        meaning = (
            answer.table(table).schema.field("pretension_from").metadata[b"long_name"].decode()
        )
        assert meaning.endswith("read as flexor at joint")
