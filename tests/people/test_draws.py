"""Draws of uncertain numbers: distributions, pairing with people, and a sweep over them."""

import numpy as np
import pytest
from scipy import stats

from tendon_cli.engine.plan import Plan
from tendon_cli.errors import StudyError
from tendon_cli.studies.answer_draws import drawn
from tendon_cli.studies.load import study_from
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.values import draw_numbers, quantile

STIFF = {"spring": {"stiffness": {"value": "3 kN/m", "tolerance": "10 %"}}}
ROUGH = {"sheath": {"friction": {"mean": 0.074, "std": 0.02}}}
WIDE = {"sheath": {"friction": {"mean": 0.05, "std": 0.1}}}


def test_draws_have_the_distribution_that_the_study_says():
    study = study_from(STIFF | ROUGH | {"uncertainty": {"draws": 4096}})
    (axis,) = space_of(study).axes
    assert study.axes == ("draw",)
    stiffness = axis.numbers["spring.stiffness"]
    friction = axis.numbers["sheath.friction"]
    uniform = stats.uniform(2700.0, 600.0)
    normal = stats.truncnorm(-3.7, np.inf, 0.074, 0.02)
    assert stats.kstest(stiffness, uniform.cdf).statistic < 0.002
    assert stats.kstest(friction, normal.cdf).statistic < 0.002
    assert abs(np.corrcoef(stiffness, friction)[0, 1]) < 0.005


def test_the_distribution_of_a_number_that_cannot_be_negative_is_cut_off_and_not_moved():
    uncertain = study_from(WIDE | {"uncertainty": {}}).uncertain["sheath.friction"]
    values = quantile(uncertain, (np.arange(10_000) + 0.5) / 10_000)
    assert values.min() > 0.0
    true = stats.truncnorm((0.0 - 0.05) / 0.1, (10.0 - 0.05) / 0.1, 0.05, 0.1)
    assert values.mean() == pytest.approx(true.mean(), rel=1e-3)
    assert np.median(values) == pytest.approx(true.median(), rel=1e-3)


def test_a_seed_gives_the_same_draws_and_another_seed_other_draws():
    uncertain = study_from(STIFF | ROUGH).uncertain

    def stiffness(draws, seed):
        return draw_numbers(uncertain, draws, seed)["spring.stiffness"]

    first = stiffness(64, seed=1)
    np.testing.assert_array_equal(first, stiffness(64, seed=1))
    assert not np.any(first == stiffness(64, seed=2))
    np.testing.assert_array_equal(stiffness(50, seed=1), first[:50])


def test_without_uncertainty_numbers_stand_at_their_middle():
    study = study_from(STIFF)
    space = space_of(study)
    assert study.axes == ()
    assert space.axes == ()
    assert space.number("spring.stiffness", "flexor").within(()) == 3000.0


@pytest.mark.parametrize(
    ("persons", "axes"), [(6, ("person", "draw")), (8, ("person",)), (9, ("person",))]
)
def test_fewer_persons_than_draws_meet_every_draw(persons, axes):
    drawing = {"uncertainty": {"draws": 8}}
    study = study_from(STIFF | {"people": {"count": persons}} | drawing)
    assert study.axes == axes
    designs = Plan(study).designs
    stiffnesses = set(space_of(study).axes[-1].numbers["spring.stiffness"])
    if "draw" in axes:
        assert designs == persons * 8
        assert len(stiffnesses) == 8
    else:
        assert designs == persons
        assert len(stiffnesses) == persons
    assert study_from(study.document()).hash == study.hash


def test_a_sweep_over_draws_is_the_model_at_each_draw():
    content = {
        **STIFF,
        "arm": {"b1": {"value": "150 mm", "tolerance": "5 mm"}},
        "uncertainty": {"draws": 4},
        "people": {"count": 3},
    }
    plan = Plan(study_from(content))
    (block,) = plan.blocks(range(plan.designs))
    together = plan.state(block)
    _, draws = plan.axes
    for draw in range(4):
        numbers = {
            "spring": {"stiffness": draws.numbers["spring.stiffness"][draw]},
            "arm": {"b1": draws.numbers["arm.b1"][draw]},
        }
        alone = Plan(study_from(numbers | {"people": {"count": 3}}))
        state = alone.state(*alone.blocks(range(3)))
        np.testing.assert_allclose(
            together.balance.flexor[:, draw], state.balance.flexor, rtol=1e-12
        )


def test_what_is_exact_is_not_drawn_and_stands_at_its_middle():
    content = STIFF | ROUGH | {"uncertainty": {"draws": 4, "exact": ["spring", "arm.b1"]}}
    study = study_from(content)
    assert set(study.uncertain) == {"sheath.friction"}
    (draws,) = space_of(study).axes
    assert list(draws.numbers) == ["sheath.friction"]
    assert space_of(study).number("spring.stiffness", "flexor").within(()) == 3000.0
    assert study_from(study.document()).hash == study.hash
    middles = study.vary(**{"spring.stiffness": 3000.0, "uncertainty.exact": []})
    (same,) = space_of(middles).axes
    np.testing.assert_array_equal(same.numbers["sheath.friction"], draws.numbers["sheath.friction"])


def test_a_word_on_what_is_exact_draws_nothing_in_a_sweep_and_the_rest_in_an_answer():
    study = study_from(STIFF | ROUGH | {"uncertainty": {"exact": "spring.stiffness"}})
    assert study.axes == study_from(study.document()).axes == ()
    assert drawn(study).draws == 256
    assert set(drawn(study).uncertain) == {"sheath.friction"}
    one_side = {"uncertainty": {"exact": "spring.flexor"}}
    assert "spring.stiffness" in study_from(STIFF | one_side).uncertain


def test_one_side_of_an_uncertain_number_may_have_its_own_value():
    sheath = {"friction": {"mean": 0.07, "std": 0.01}, "extensor": {"friction": 0.1}}
    space = space_of(study_from({"sheath": sheath, "uncertainty": {}}))
    assert space.number("sheath.friction", "extensor").within(space.whole) == 0.1
    assert space.number("sheath.friction", "flexor").within(space.whole).shape == (256, 1, 1)


def test_a_case_cannot_set_a_number_that_is_drawn():
    case = {"name": "a", "spring": {"stiffness": "2 kN/m"}}
    with pytest.raises(StudyError, match=r"cases\.0\.spring\.stiffness: .* is uncertain"):
        study_from(STIFF | {"cases": [case], "uncertainty": {}})
    assert study_from(STIFF | {"cases": [case]}).axes == ("case",)
