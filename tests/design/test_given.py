"""A given pretension is used as it is.

The answer has whom it serves, by what margins, and what would help one that does not do.
"""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.errors import StudyError
from tests.answers import answered as known_answer
from tests.answers import solved

SUIT = {
    "spring": {"stiffness": ["3 kN/m", "5 kN/m", "8 kN/m"]},
    "spool": {"ratio": [0.5, 0.6, 0.7]},
    "load": {"mass": ["0 kg", "5 kg", "10 kg"]},
    "motion": {"elbow_angle": {"from": 0.0, "to": "90 deg", "num": 10}},
}


def answered(pretension, **content):
    """Answer the question about the suit at a given pretension."""
    design = {"pretension": pretension, **content.get("design", {})}
    return known_answer({**SUIT, **content, "design": design})


@pytest.mark.parametrize("role", ["condition", "draw"])
@pytest.mark.parametrize(("given", "enough"), [(140.0, 1.0), (140.0, 0.6)])
def test_it_works_as_a_sweep_finds_and_less_than_all_draws_may_be_enough(given, enough, role):
    rows = [{"name": f"{mass}", "load.mass": f"{mass} kg"} for mass in (0, 5, 10)]
    loads = {"load": {}, "table": [{"name": "load", "role": role, "rows": rows}]}
    design = {"serve": enough} if role == "draw" else {}
    choices = answered(f"{given} N", design=design, **loads).choices
    swept = tendon.sweep(tendon.study({**SUIT, "tendon": {"pretension": given}})).designs
    by_choice = swept.groupby(["spring_stiffness", "spool_ratio"], sort=False)["feasible"]
    served = by_choice.mean().to_numpy()
    if role == "draw":
        np.testing.assert_allclose(choices["served_at"], served, atol=1e-12)
        np.testing.assert_array_equal(choices["feasible"], served >= enough)
    else:
        assert choices[["served", "served_at"]].isna().all(axis=None)
        np.testing.assert_array_equal(choices["feasible"], served == 1.0)
    assert (choices["pretension"] == given).all()


def test_the_window_stays_as_it_is_solved():
    given = answered("140 N").choices
    middle = answered("middle").choices
    for name in ("pretension_from", "pretension_to", "tolerance", "windows"):
        np.testing.assert_array_equal(given[name], middle[name])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            "150 N",
            "(122.1 to 173.9 N works)",
        ),
        ("180 N", "180 N is 6.07 N above the window, 122.1 to 173.9 N"),
    ],
)
def test_the_text_has_its_margins_and_the_answer_has_fixes_for_one_that_does_not_do(given, words):
    answer = answered(given, spring={"stiffness": "5 kN/m"}, spool={"ratio": 0.6})
    assert words in " ".join(answer.text.split())
    assert (answer.feasible == 1) == (given == "150 N")
    assert answer.feasible or any(fix["after"] is not None for fix in answer.fixes)


@pytest.mark.parametrize("value", ["midle", "3 mm", "-4 N", ["3 N", "4 N"]])
def test_a_value_that_is_no_pretension_is_refused(value):
    with pytest.raises(StudyError, match=r"design\.pretension"):
        answered(value)


def test_a_pretension_outside_of_the_widest_window_does_not_get_its_proof():
    single = {**SUIT, "spring": {"stiffness": "3 kN/m"}, "spool": {"ratio": 0.6}}
    windows = []
    for mass in ("0 kg", "15 kg"):
        answer = tendon.design(tendon.study({**single, "load": {"mass": mass}}))
        windows.append(answer.choices.loc[0, ["pretension_from", "pretension_to"]].to_numpy(float))
    windows.sort(key=np.ptp)
    narrow, wide = windows
    assert narrow[1] < wide[0] or wide[1] < narrow[0]
    rows = [{"name": mass, "load.mass": mass} for mass in ("0 kg", "15 kg")]
    both = {**single, "load": {}, "table": [{"name": "load", "role": "draw", "rows": rows}]}
    for window, status in ((narrow, "sampled"), (wide, "proven")):
        design = {"pretension": f"{window.mean()} N", "serve": 0.5}
        best = tendon.design(tendon.study({**both, "design": design})).record["best"]
        assert best["feasible"]
        assert best["between_samples"] == status


def test_no_answer_accepts_a_pretension_along_a_motion_that_a_sweep_refuses():
    """Below the end of what samples would tell, one sample more turns and is unstable."""
    time = np.arange(300) / 100.0
    angle = 45.0 - 30.0 * np.cos(2.0 * np.pi * 0.6 * time)
    study = tendon.study(
        {
            "spool": {"ratio": 0.45},
            "spring": {"stiffness": "10 kN/m"},
            "motion": {
                "inertia": "0.06 kg m^2",
                "trajectory": {
                    "time": [f"{at:.2f} s" for at in time],
                    "angle": [f"{at:.5f} deg" for at in angle],
                },
            },
            "uncertainty": {"usual": False},
        }
    )
    pretensions = ["578 N", "581 N"]
    designs = tendon.sweep(study.vary(**{"tendon.pretension": pretensions})).designs
    assert designs["feasible"].tolist() == [True, False]
    for pretension, is_feasible in zip(pretensions, designs["feasible"], strict=True):
        choices = solved(study.vary(**{"design.pretension": pretension}))
        assert choices.feasible[0] == is_feasible, pretension
