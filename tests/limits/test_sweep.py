"""Limits that differ between the designs of a sweep: each design is judged by its own."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli import kernel
from tests.answers import merged

from .suits import LOOSER_AND_TIGHTER, SUIT, limited

PRETENSIONS = {"tendon": {"pretension": ["60 N", "75 N", "90 N", "110 N"]}}


def designs(content):
    """Return the designs of a study without their numbers."""
    return tendon.sweep(merged(PRETENSIONS, content)).designs.drop(columns="design")


def with_limit(table, limit, place):
    """Return the rows of one of two values of a limit, without the column of the limit."""
    column = f"limit_{limit}"
    value = table[column].unique()[place]
    rows = table[table[column] == value]
    return rows.drop(columns=column).reset_index(drop=True)


@cache
def unlimited():
    """Return the designs of the suit without a limit."""
    return designs(SUIT)


@pytest.mark.parametrize("limit", LOOSER_AND_TIGHTER)
def test_a_limit_on_an_axis_or_of_a_case_is_the_study_with_that_limit(limit):
    values = LOOSER_AND_TIGHTER[limit]
    looser, tighter = (designs(limited(limit, value)) for value in values)
    assert not looser.equals(tighter)
    assert (looser["feasible"] | ~tighter["feasible"]).all()
    along_axis = designs(limited(limit, list(values)))
    for place, alone in enumerate((looser, tighter)):
        rows = with_limit(along_axis, limit, place)
        pd.testing.assert_frame_equal(rows, alone, check_exact=True)
    cases = [{"name": "free"}]
    cases += [{"name": f"{value}", "limits": {limit: value}} for value in values]
    table = designs(merged(SUIT, {"cases": cases}))
    for case, alone in zip(cases, (unlimited(), looser, tighter), strict=True):
        rows = table[table["case"] == case["name"]].drop(columns=["case", f"limit_{limit}"])
        pd.testing.assert_frame_equal(rows.reset_index(drop=True), alone, check_exact=True)


def test_the_column_of_a_limit_has_its_unit_and_leaves_the_column_that_it_bounds():
    run = tendon.sweep(limited("max_tension", ["300 N", "400 N"]))
    assert run.designs.attrs["units"]["limit_max_tension"] == "N"
    assert set(run.designs["limit_max_tension"]) == {300.0, 400.0}
    assert set(run.states["limit_max_tension"]) == {300.0, 400.0}
    assert run.designs["max_tension"].nunique() == len(run.designs) // 2


def test_a_limit_is_an_axis_wherever_it_stands_in_the_document():
    spring = {"spring": SUIT["spring"]}
    limit = {"limits": {"max_tension": ["300 N", "200 N"]}}
    rest = {key: value for key, value in SUIT.items() if key != "spring"}
    first = tendon.sweep({**limit, **spring, **rest}).designs.drop(columns="design")
    last = tendon.sweep({**spring, **rest, **limit}).designs.drop(columns="design")
    assert first["limit_max_tension"].is_monotonic_decreasing
    columns = ["limit_max_tension", "spring_stiffness", "load_mass"]
    by_first = first.sort_values(columns, ignore_index=True)
    by_last = last.sort_values(columns, ignore_index=True)
    pd.testing.assert_frame_equal(by_first, by_last[by_first.columns], check_exact=True)


def test_a_limit_on_what_is_read_is_a_reading():
    setting = {"setting": {"read": "extensor at motor"}}
    values = ["70 N", "90 N"]
    both = designs(limited("max_pretension", values, setting))
    for place, value in enumerate(values):
        alone = designs(limited("max_pretension", value, setting))
        rows = with_limit(both, "max_pretension", place)
        pd.testing.assert_frame_equal(rows, alone, check_exact=True)


def test_the_unit_of_a_limit_on_a_torque_that_is_read_is_that_of_the_torque():
    content = limited(
        "max_pretension",
        ["1.5 N m", "2 N m"],
        {"setting": {"read": "motor torque"}, "tendon": {"pretension": "1.8 N m"}},
    )
    assert tendon.sweep(content).designs.attrs["units"]["limit_max_pretension"] == "N m"


def test_ten_limits_take_the_states_of_one(monkeypatch):
    ten_limits = [f"{force} N" for force in range(200, 300, 10)]
    states = []
    fold = kernel.fold_extremes

    def counted(folded, at, angles, shape):
        states.append(np.prod(shape))
        fold(folded, at, angles, shape)

    monkeypatch.setattr(kernel, "fold_extremes", counted)
    designs(limited("max_tension", ten_limits[0]))
    of_one = sum(states)
    states.clear()
    designs(limited("max_tension", ten_limits))
    assert sum(states) == of_one > 0
