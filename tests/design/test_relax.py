"""What it would take: the least change of one thing that is asked for gives a choice a window, and less gives none."""

import numpy as np
import pytest

import tendon_cli as tendon

SUITS = {"spring": {"stiffness": ["3 kN/m", "5 kN/m"]}, "spool": {"ratio": [0.7, 0.6]}}
ASKED = {
    "arm": {"contact_width": ["30 mm", "40 mm"], "upper_arm_angle": ["-15 deg", "15 deg"]},
    "anchor": {"stiffness": "10 kN/m"},
    "load": {"mass": ["0 kg", "9 kg"]},
    "limits": {"max_contact_pressure": "52.9 kPa"},
}


def with_value(key, value, before):
    """The question with another value of one thing asked for, of several values all drawn together."""
    table, name = key.split(".")
    given = {"load.mass": [0.0, value], "arm.upper_arm_angle": [f"{-value} rad", f"{value} rad"]}.get(key, value)
    return {**SUITS, **ASKED, table: {**ASKED[table], name: given}}


@pytest.fixture(scope="module")
def answer():
    return tendon.design(tendon.study({**SUITS, **ASKED}))


def test_the_least_change_gives_a_window_and_less_gives_none(answer):
    assert answer.feasible == 0
    eased = {each["key"]: each for each in answer.record["would_take"]}
    assert set(eased) == {
        "limits.max_contact_pressure", "arm.contact_width", "anchor.stiffness", "load.mass", "arm.upper_arm_angle",
    }  # fmt: skip
    helps = [each for each in eased.values() if each["after"] is not None]
    assert {"limits.max_contact_pressure", "arm.contact_width", "load.mass"} <= {each["key"] for each in helps}
    for each in helps:
        for value, some in ((each["after"], True), (each["after"] + 0.01 * (each["before"] - each["after"]), False)):
            found = tendon.design(tendon.study(with_value(each["key"], value, each["before"])))
            assert (found.feasible > 0) == some, each
            if some:
                rows = found.choices
                for name, of in each["values"].items():
                    rows = rows[np.isclose(rows[name], of)] if name in rows else rows
                assert (rows["feasible"] & (rows["pretension_from"] <= each["pretension"])).any()


def test_it_is_said_with_the_choice_that_then_works(answer):
    text = " ".join(answer.text.split())
    assert (
        "What it would take, all else equal max_contact_pressure = 99 kPa instead of 52.9 kPa: K 5 kN/m, η 0.6" in text
    )
    assert "loads of at most 4.42 kg instead of 9 kg" in text
    assert "not enough alone: tissue and cuffs of 100 kN/m behind each anchor, an upper arm tilted by at" in text
