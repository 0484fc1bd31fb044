"""The table of persons under the choice named first, against solving each person alone."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.figures.served import members
from tendon_cli.tables.schema import as_numpy
from tendon_cli.verbs.answer_record import as_answer

COARSE = {
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    "load": {"mass": [0.0, 10.0]},
}
SUIT = {**COARSE, "spring": {"stiffness": [5e3, 8e3]}, "spool": {"ratio": 0.6}}
STIFF_SUIT = {**SUIT, "spring": {"stiffness": 5e3}}
FEW_ARE_ENOUGH = {
    "design": {"serve": 0.3, "verify": 0},
    "setting": {"read": "pretension"},
}
"""So that there is a feasible choice, set by these persons and at one F0 for all."""
FORTY = {"people": {"count": 40, "seed": 3}, **FEW_ARE_ENOUGH}
RUBBING = {"sheath": {"friction": {"mean": 0.08, "std": 0.04}}, "uncertainty": {"draws": 32}}
FEW = {
    **SUIT,
    "people": {"count": 4},
    **RUBBING,
    **FEW_ARE_ENOUGH,
    "limits": {"max_tension": "520 N"},
}


@pytest.fixture(scope="module")
def answer():
    """Return the answer for forty persons."""
    return tendon.design(tendon.study({**SUIT, **FORTY}))


@pytest.fixture
def best_suit(answer):
    """Return the study of the best suit alone at its pretension, for the same persons."""
    return {
        **SUIT,
        **FORTY,
        "spring": {"stiffness": answer.best["spring_stiffness"]},
        "tendon": {"pretension": answer.best["pretension"]},
    }


def test_a_person_in_the_table_is_the_person_alone(answer, best_suit):
    swept = tendon.sweep(tendon.study(best_suit)).designs
    for row in answer.persons.sample(4, random_state=1).itertuples():
        designs = swept[swept["person"] == row.person]
        assert designs["pretension_from"].max() == pytest.approx(row.pretension_from, rel=1e-12)
        assert designs["pretension_to"].min() == pytest.approx(row.pretension_to, rel=1e-12)
        assert designs["feasible"].all() == (row.served == 1.0)


def test_shares_of_the_record_are_those_of_the_table(answer):
    population = as_answer(answer.record).population
    persons = answer.persons
    assert len(persons) == population.count == 40
    assert persons["served"].mean() == pytest.approx(population.served, abs=1e-12)
    assert set(persons["sex"]) == {"male", "female"}
    table = answer.table("persons")
    rows = {name: as_numpy(table.column(name)) for name in table.column_names}
    groups = []
    for reason in population.not_served:
        group = members(rows, reason, population.pretension)
        assert len(group) == reason.count
        groups.append(group)
    left_out = np.unique(np.concatenate([np.empty(0), *groups]))
    assert len(left_out) == (persons["served"] < 1.0).sum()


def test_the_tensions_to_set_are_those_of_each_body(answer, best_suit):
    persons = answer.persons
    assert persons["set_flexor_tension"].nunique() == 40
    setting = {
        "load": {"mass": 0.0},
        "motion": {"direction": "extension", "elbow_angle": 0.0},
    }
    states = tendon.sweep(tendon.study({**best_suit, **setting})).states
    for end, place in (("", "distal"), ("_motor", "proximal")):
        expected = states[f"extensor_tension_{place}"].to_numpy()
        np.testing.assert_allclose(persons[f"set_extensor_tension{end}"], expected, rtol=1e-12)


def test_few_persons_are_served_by_the_share_of_their_draws():
    answer = tendon.design(tendon.study(FEW))
    population = answer.record["population"]
    persons = answer.persons
    assert population["kind"] == "pairs"
    assert population["count"] == 4 * 32
    assert len(persons) == 4
    assert persons["served"].mean() == pytest.approx(population["served"], abs=1e-12)
    assert ((persons["served"] * 32) % 1.0 < 1e-9).all()
    assert "128 pairs of 4 persons and 32 draws" in " ".join(answer.text.split())


def test_one_person_is_this_person_with_and_without_draws():
    def text_for_one(suit):
        alone = {"people": {"count": 1}, "design": {"verify": 0, "serve": 0.3}}
        answer = tendon.design(tendon.study({**suit, **alone}))
        return " ".join(answer.short.split())

    with_draws = text_for_one(FEW)
    assert "this person's 32 draws" in with_draws
    assert "1 person" not in with_draws
    alone = text_for_one(SUIT)
    assert "work for this person" in alone


def test_a_person_of_several_bodies_has_one_row_over_them(tmp_path):
    (tmp_path / "people.csv").write_text("name,sex,weight (kg),weighting\nAda,f,62,1\nBo,m,84,3\n")
    people = {"file": str(tmp_path / "people.csv")}
    answer = tendon.design(tendon.study({**STIFF_SUIT, "people": people, **FEW_ARE_ENOUGH}))
    persons = answer.persons
    population = answer.record["population"]
    assert list(persons["person"]) == ["Ada", "Bo"]
    np.testing.assert_allclose(persons["weighting"], [1.0, 3.0])
    np.testing.assert_allclose(persons["weight"], [62.0, 84.0], rtol=1e-12)
    assert ((persons["served"] * 128) % 1.0 < 1e-9).all()
    served = np.average(persons["served"], weights=persons["weighting"])
    assert served == pytest.approx(population["served"], abs=1e-12)
    again = tendon.design(
        tendon.study(
            {
                **STIFF_SUIT,
                "people": people | {"sex": "female"},
                "setting": {"read": "pretension"},
                "design": {"pretension": population["pretension"], "serve": 0.3, "verify": 0},
            }
        )
    )
    np.testing.assert_allclose(
        again.persons["set_flexor_tension"], persons["set_flexor_tension"], rtol=1e-9
    )


def test_draws_have_a_table_of_their_own():
    answer = tendon.design(tendon.study({**SUIT, **RUBBING}))
    draws = answer.table("draws")
    assert draws.num_rows == 32
    assert "weight" not in draws.schema.names


def test_shares_by_sex_are_those_of_the_table():
    content = {**STIFF_SUIT, "people": {"count": 40, "seed": 3}}
    content["design"] = {"by": "sex", "verify": 0, "serve": 0.3}
    answer = tendon.design(tendon.study(content))
    shares = {share["sex"]: share for share in answer.record["population"]["by"]}
    served = answer.persons.groupby("sex", observed=True)["served"]
    for sex, mean in served.mean().items():
        low, high = shares[sex]["interval_95"]
        assert shares[sex]["served"] == pytest.approx(mean, abs=1e-12)
        assert low <= mean <= high
        assert shares[sex]["persons"] == served.count()[sex]
    assert "  female  " in answer.text


def test_the_reading_that_is_set_is_the_same_on_everyone_and_the_other_one_is_not(tmp_path):
    (tmp_path / "people.csv").write_text("name,weight (kg),stature (cm)\nAda,62,168\nBob,85,181\n")
    people = {"file": str(tmp_path / "people.csv")}
    answer = tendon.design(
        tendon.study(
            {**SUIT, "people": people, **FEW_ARE_ENOUGH, "setting": {"read": "flexor at joint"}}
        )
    )
    population = answer.record["population"]
    flexor = answer.persons["set_flexor_tension"]
    extensor = answer.persons["set_extensor_tension"]
    np.testing.assert_allclose(flexor, population["pretension"], rtol=1e-12)
    assert extensor.nunique() == 2
    low, high = population["set"]["set_extensor_tension"]
    assert low < extensor.min() < extensor.max() < high
    assert "in the flexor at the joint" in " ".join(answer.text.split())
    for table in ("choices", "persons"):
        field = answer.table(table).schema.field("pretension_from")
        meaning = field.metadata[b"long_name"].decode()
        assert meaning.endswith("read as flexor at joint")
