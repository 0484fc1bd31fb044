"""Answers draw whatever a study does not call exact: chosen, set and judged by three samples.

Shares are compared with suits in plain NumPy (`plain_suit`), of which nothing is tendon's.
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli import say
from tendon_cli.answers.text_assumed import cuffs_words
from tendon_cli.engine.windows.coverage import upper_quantile
from tendon_cli.engine.windows.question import least_share_for, question_of
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.verification import Verifier
from tendon_cli.model.winding import least_free_length
from tendon_cli.studies.answer_draws import for_answer
from tendon_cli.studies.load import study_from
from tendon_cli.studies.space.axis import factor_of, shift_of
from tests.answers import answered, merged
from tests.people import plain_suit

DRAWS_USUAL = True

SUIT = {
    "spring": {"stiffness": 3e3},
    "spool": {"ratio": 0.4},
    "anchor": {"stiffness": 2e3},
    "load": {"mass": [0.0, 3.0]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    "setting": {"accuracy": "4 N"},
    "uncertainty": {"draws": 64},
    "design": {"verify": 500},
}
"""A worn suit for 0 to 3 kg."""
TAPE = ("arm.a1", "arm.b1", "arm.a2", "arm.b2", "arm.elbow_radius")


def usual_of(*more):
    """Return the keys of the usual deviations that are drawn for the suit."""
    return {*for_answer(study_from(merged(SUIT, *more))).usual}


def question_with(*more):
    return question_of(study_from(merged(SUIT, *more)))


# --- What is drawn --------------------------------------------------------------------------------


def test_deviations_are_of_each_side_and_of_whatever_value_a_design_has():
    """Values of an axis, a row and a case are multiplied or shifted alike."""
    question = question_with(
        {
            "uncertainty": {"draws": 512},
            "spring": {"stiffness": [2e3, 5e3]},
            "cases": [{"name": "far", "arm": {"b1": 0.17}}, {"name": "near", "arm": {"b1": 0.13}}],
            "table": [
                {
                    "name": "sheath",
                    "role": "choice",
                    "rows": [
                        {"name": "new", "sheath.friction": 0.05},
                        {"name": "worn", "sheath.friction": 0.1},
                    ],
                }
            ],
        }
    )
    of_choices = question.choices.columns(np.arange(len(question.choices)))
    numbers = question.condition_numbers
    design = question.designs(question.all_points())

    def column(values):
        """Return a number of designs, (choices, conditions)."""
        shape = (len(question.choices), len(question.conditions), 1, 1)
        return np.broadcast_to(values, shape)[..., 0, 0]

    factors = []
    for side, of_side in (("flexor", design.flexor), ("extensor", design.extensor)):
        factor = numbers[factor_of(f"spring.{side}.stiffness")]
        expected = np.multiply.outer(of_choices["spring_stiffness"], factor)
        np.testing.assert_allclose(column(of_side.spring_stiffness), expected, rtol=1e-12)
        factors.append(factor)
        stated = np.where(of_choices["sheath"] == 0, 0.05, 0.1)
        rubbing = np.multiply.outer(stated, numbers[factor_of(f"sheath.{side}.friction")])
        np.testing.assert_allclose(column(of_side.friction), rubbing, rtol=1e-12)
    of_case = question.conditions.columns(np.arange(len(question.conditions)))["case"]
    shift = numbers[shift_of("arm.b1")]
    expected = np.where(of_case == 0, 0.17, 0.13) + shift
    np.testing.assert_allclose(column(design.arm.joint.b1), expected[np.newaxis] + np.zeros((4, 1)))
    assert np.mean(factors) == pytest.approx(1.0, abs=1e-3)
    assert np.std(factors) == pytest.approx(0.05, rel=0.02)
    assert shift.std() == pytest.approx(5e-3, rel=0.02)
    each = question.groups.of
    firsts = np.flatnonzero(np.diff(each, prepend=-1))
    assert abs(np.corrcoef(factors[0][firsts], factors[1][firsts])[0, 1]) < 0.2


def test_what_is_exact_or_has_a_deviation_of_its_own_has_no_usual_one():
    assert {*TAPE, "spring.flexor.stiffness", "sheath.extensor.friction"} <= usual_of()
    exact = usual_of({"uncertainty": {"exact": ["spring.stiffness", "arm"]}})
    assert exact == {key for key in usual_of() if not key.startswith(("arm.", "spring."))}
    own = {"sheath": {"friction": "0.07 +/- 0.01"}}
    assert usual_of(own) == {key for key in usual_of() if not key.endswith(".friction")}
    numbers = question_with(own).condition_numbers
    flexor, extensor = (numbers[f"sheath.{side}.friction"] for side in ("flexor", "extensor"))
    for friction in (flexor, extensor):
        assert friction.std() == pytest.approx(0.01, rel=0.05)
    assert abs(np.corrcoef(flexor, extensor)[0, 1]) < 0.5
    assert usual_of({"uncertainty": {"usual": False}}) == set()
    assert question_with({"uncertainty": {"usual": False}}).groups.noun == "conditions"


def test_conditions_are_not_drawn_nor_is_what_a_survey_scatters_itself():
    posture = {"arm": {"upper_arm_angle": ["0 deg", "10 deg"]}}
    assert not usual_of(posture) & {"load.mass", "arm.upper_arm_angle", "tendon.pretension"}
    varied = {"arm": {"b1": [0.14, 0.16]}}
    assert "arm.b1" not in usual_of(varied)
    of_survey = usual_of({"people": {"count": 5}})
    assert not [key for key in of_survey if key.startswith("arm.")]
    assert "spring.flexor.stiffness" in of_survey


def test_a_sweep_draws_no_usual_deviations():
    assert len(tendon.sweep(SUIT).designs) == 2
    drawn = merged(SUIT, {"sheath": {"friction": "0.07 +/- 0.01"}})
    assert [*study_from(drawn).to_draw] == ["sheath.friction"]


# --- Three samples --------------------------------------------------------------------------------


@dataclass
class Line:
    """One side of drawn suits, (suits, 1) each: sheath, rope, spring and cuffs in series."""

    friction: np.ndarray
    bend: np.ndarray
    length: np.ndarray
    modulus: np.ndarray
    spring: np.ndarray
    cuffs: np.ndarray


class DrawnArms(plain_suit.Arms):
    """Arms whose sides differ: both tissues are a `Line`."""

    def compliance(self, sign, tissue):
        exponent = sign * tissue.friction * tissue.bend
        area = np.pi / 4.0 * self.diameter**2
        rope = tissue.length / (tissue.modulus * area) * -np.expm1(-exponent) / exponent
        return rope + 1.0 / tissue.spring + 1.0 / tissue.cuffs


def drawn_arms(count, seed, stiffness=3e3, ratio=0.4, cuffs=2e3):
    """Draw arms with the usual deviations of `model.md`, section 22, from plain NumPy."""
    random = np.random.default_rng(seed)

    def around(value, share):
        return value * (1.0 + share * random.standard_normal((count, 1)))

    def tape(value, deviation):
        return value + deviation * random.standard_normal((count, 1))

    def line():
        return Line(
            friction=around(0.07, 0.2),
            bend=around(np.pi, 0.05),
            length=around(2.0, 0.02),
            modulus=around(145e9, 0.1),
            spring=around(stiffness, 0.05),
            cuffs=cuffs * np.exp(np.log(1.4) * random.standard_normal((count, 1))),
        )

    return DrawnArms(
        a1=tape(0.04, 5e-3),
        b1=tape(0.15, 5e-3),
        a2=tape(0.02, 5e-3),
        b2=tape(0.15, 5e-3),
        radius=tape(0.045, 3e-3),
        forearm_mass=around(1.54, 0.05),
        forearm_com=around(0.174, 0.02),
        load_distance=around(0.32, 0.02),
        joint_stiffness=0.0,
        rest_angle=0.0,
        flexor_tissue=line(),
        extensor_tissue=line(),
        ratio=around(ratio, 0.01),
    )


def plain_share(arms, reading):
    """Return the share of arms that one reading of the flexor's gauge serves."""
    angles = np.linspace(0.0, np.pi / 2.0, 46)
    pretension = arms.pretension(reading, "flexor at joint")
    return arms.keeps(pretension, angles, [0.0], (0.0, 3.0), 1.0, np.inf).mean()


def test_the_share_told_is_that_of_suits_drawn_and_tried_one_by_one():
    question = question_with({"design": {"verify": 2000}})
    points = question.all_points()
    judge = Verifier.of(Solver(question))
    arms = drawn_arms(8000, seed=11)
    shares = []
    for reading in (28.0, 35.0, 50.0, 66.0, 80.0):
        truth = plain_share(arms, reading)
        (judged,) = judge.judge(points, np.array([reading]))
        error = np.sqrt(truth * (1.0 - truth) * (1 / 2000 + 1 / 8000))
        assert judged.value == pytest.approx(truth, abs=4.0 * error + 1e-3), reading
        shares.append(truth)
    assert min(shares) < 0.8
    assert max(shares) > 0.98


def test_the_first_sentence_has_the_share_of_suits_so_built():
    answer = answered(SUIT)
    best = answer.best
    verdict = best["served_verified"]
    truth = plain_share(drawn_arms(8000, seed=12), best["set_flexor_tension"])
    low, high = verdict["interval_95"]
    assert low - 0.01 <= truth <= high + 0.01
    assert f"this suit works in {100 * verdict['value']:.0f} of 100 suits so built" in answer.short


def test_no_draw_of_one_sample_is_in_another():
    question = question_with()
    solver = Solver(question)
    second = Verifier.of(solver, second=True).solver.question
    third = Verifier.of(solver).solver.question
    key = factor_of("spring.flexor.stiffness")
    samples = [np.unique(of.condition_numbers[key]) for of in (question, second, third)]
    assert [*map(len, samples)] == [64, 500, 500]
    assert len(np.unique(np.concatenate(samples))) == 64 + 500 + 500
    again = Verifier.of(Solver(question_with()), second=True).solver.question
    np.testing.assert_array_equal(again.condition_numbers[key], second.condition_numbers[key])


def served_at(readings, low, high):
    return np.mean((low <= readings[:, np.newaxis]) & (readings[:, np.newaxis] <= high), axis=1)


def test_a_number_of_one_side_is_told_and_a_bend_that_follows_the_joint_does_not_deviate():
    bend = {"angle": ["0 deg", "90 deg"], "bend": ["90 deg", "150 deg"]}
    content = merged(SUIT, {"sheath": {"extensor": {"bend_angle": bend}}})
    rope = {"tendon": {"breaking_force": "2.6 kN +/- 0.4 kN"}}
    answer = answered(merged(content, rope))
    told = {record["key"] for record in answer.record["assumed"]}
    assert "tendon.flexor.breaking_force" in told
    assert not any("bend_angle" in key and "flexor" not in key for key in told)


def test_the_setting_is_the_reserve_above_the_lower_end_of_the_second_sample():
    """The window is the widest interval of readings that serves 95 % of the second sample."""
    for accuracy in (4.0, 100.0):
        content = merged(SUIT, {"setting": {"accuracy": f"{accuracy} N"}})
        question = question_of(study_from(content))
        second = Verifier.of(Solver(question), second=True)
        (judged,) = second.judge(question.all_points(), np.array([40.0]))
        low, high = judged.windows
        readings = np.arange(20.0, 90.0, 0.01)
        enough = readings[served_at(readings, low, high) >= 0.95]
        assert np.ptp(enough) == pytest.approx(0.01 * (len(enough) - 1))  # a single interval
        best = answered(content).best
        assert best["set_flexor_tension_from"] == pytest.approx(enough[0], abs=0.011)
        assert best["set_flexor_tension_to"] == pytest.approx(enough[-1], abs=0.011)
        middle = 0.5 * (enough[0] + enough[-1])
        expected = min(enough[0] + accuracy, middle)
        assert best["set_flexor_tension"] == pytest.approx(expected, abs=0.02)


def test_other_draws_give_the_same_choice_and_setting():
    catalogue = {"spring": {"stiffness": [2e3, 3e3, 5e3]}}
    found = []
    for seed in (1, 2):
        sampled = {"uncertainty": {"draws": 128, "seed": seed}, "design": {"verify": 2000}}
        found.append(answered(merged(SUIT, catalogue, sampled)).best)
    first, other = found
    assert first["choice"] == other["choice"]
    assert first["set_flexor_tension"] == pytest.approx(other["set_flexor_tension"], rel=0.02)


# --- Shares and quantiles of samples --------------------------------------------------------------


def test_worst_values_are_quantiles_that_one_in_twenty_may_exceed():
    random = np.random.default_rng(3)
    for count in (1, 2, 19, 20, 21, 40, 101):
        values = random.normal(size=(5, count))
        weighting = np.ones(count)
        expected = np.quantile(values, 0.95, axis=-1, method="inverted_cdf")
        np.testing.assert_array_equal(upper_quantile(values, weighting), expected)
        repeats = random.integers(1, 5, count)
        repeats[0] += 1  # so that weights differ
        repeated = np.repeat(values, repeats, axis=-1)
        expected = np.quantile(repeated, 0.95, axis=-1, method="inverted_cdf")
        found = upper_quantile(values, repeats.astype(float))
        if count > 1:
            np.testing.assert_array_equal(found, expected)
        unknown = np.concatenate([values, np.full((5, 30), -np.inf)], axis=-1)
        known = upper_quantile(unknown, np.ones(count + 30))
        np.testing.assert_array_equal(known, upper_quantile(values, weighting))


@pytest.mark.parametrize("serve", [0.5, 0.9, 0.95])
@pytest.mark.parametrize("count", [100, 256, 1000, 10_000])
def test_enough_is_the_least_share_whose_interval_lies_above_what_is_wanted(serve, count):
    share = least_share_for(serve, count)
    assert say.interval(share, count)[0] >= serve
    assert say.interval(share - 1.0 / count, count)[0] < serve


def test_who_asks_for_more_is_not_content_with_less():
    for count in (20, 64, 256, 1000):
        needed = [least_share_for(serve, count) for serve in (0.5, 0.8, 0.9, 0.95, 0.97, 0.99)]
        assert needed == sorted(needed), count


# --- What is said ---------------------------------------------------------------------------------


def test_cuffs_that_a_study_does_not_state_are_told():
    unstated = {key: value for key, value in SUIT.items() if key != "anchor"}
    said = "This is as if cuffs did not give: with cuffs as soft as measured ("
    assert said in " ".join(answered(unstated).short.split())
    for stiffness in ("rigid", "2 kN/m"):
        stated = answered({**unstated, "anchor": {"stiffness": stiffness}})
        assert "as if cuffs" not in " ".join(stated.short.split())
        keys = {of["key"] for of in stated.record["assumed"] if of["kind"] == "given"}
        assert "anchor.stiffness" not in keys


def shortest_spring(stiffness, force):
    """Return the shortest spring that can be wound, m, among all wires that bear the force."""
    shortest = np.inf
    for wire in np.linspace(0.5e-3, 12e-3, 4601):
        strength = 0.45 * 2211e6 * (wire / 1e-3) ** -0.145
        index = np.linspace(4.0, 20.0, 321)
        wahl = (4.0 * index - 1.0) / (4.0 * index - 4.0) + 0.615 / index
        bears = 8.0 * force * index * wahl / (np.pi * wire**2) <= strength
        coils = 79.3e9 * wire / (8.0 * index**3 * stiffness)
        length = (coils + 1.0) * wire + 2.0 * (index - 1.0) * wire
        shortest = min(shortest, length[bears].min(initial=np.inf))
    return shortest


@pytest.mark.parametrize(
    ("stiffness", "force", "length"), [(3e3, 298, 94.5), (5e3, 304, 77.4), (8e3, 315, 65.3)]
)
def test_springs_need_the_length_that_no_winding_undercuts(stiffness, force, length):
    found = float(least_free_length(stiffness, force))
    assert 1e3 * found == pytest.approx(length, abs=0.05)
    assert found == pytest.approx(shortest_spring(stiffness, force), rel=2e-3)


WORN = """
spring.stiffness = "3 kN/m"
spool.ratio = 0.4
anchor.stiffness = "2 kN/m"
load.mass = ["0 kg", "3 kg"]
motion.elbow_angle = { from = "0 deg", to = "90 deg", num = 7 }
design.verify = 500
"""
ENDINGS = {
    "fine": (WORN + "uncertainty.draws = 64\n", 0, 1),
    "too heavy": (WORN.replace("3 kg", "8 kg") + "uncertainty.draws = 64\n", 4, 0),
    "cannot be set": (WORN + 'uncertainty.usual = false\nsetting.accuracy = "80 N"\n', 4, 1),
}


@pytest.mark.parametrize("name", ENDINGS)
def test_a_suit_that_no_reading_serves_or_that_cannot_be_set_ends_with_4(tendon, workplace, name):
    text, code, feasible = ENDINGS[name]
    (workplace / "suit.toml").write_text(text, encoding="utf-8")
    ended = tendon("design", "suit.toml", "--json", "--no-figures")
    assert ended.exit == code
    assert ended.json["feasible"] == feasible
    if feasible:
        assert ended.json["decided"]["can_be_set"] == (code == 0)


def test_softer_cuffs_are_told_by_what_they_leave():
    """Stated rigid, cuffs are held to measured ones: by this setting, by another, or by none."""

    def told(served, best):
        softer = [
            SimpleNamespace(
                key="anchor.stiffness", kind="given", other=stiffness, served=now, served_anew=anew
            )
            for stiffness, now, anew in zip((1.05e3, 2.25e3), served, best, strict=True)
        ]
        return cuffs_words(SimpleNamespace(assumed=softer, serve=0.95))

    assert "(1.05 to 2.25 kN/m per tendon) this setting still serves" in told((0.99, 0.96), (1, 1))
    assert "no setting works" in told((0.0, 0.0), (0.0, 0.004))
    assert "no setting serves more than 80 %" in told((0.1, 0.2), (0.5, 0.8))
    assert "10 % to 97 % as set, and another setting up to 98 %" in told((0.1, 0.97), (0.98, 0.5))
