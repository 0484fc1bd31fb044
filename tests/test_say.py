"""Words: numbers that can be read back, shares that claim no more than a sample shows, limits."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import tendon_cli as tendon
from tendon_cli import say
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies import limit_phrases
from tendon_cli.units import parse_measure

finite = st.floats(min_value=-1e12, max_value=1e12, allow_subnormal=False)


def read(text):
    return float(text.replace(",", ""))


@given(finite, st.integers(1, 9))
def test_a_number_reads_back_to_its_significant_digits(value, digits):
    assert read(say.number(value, digits)) == pytest.approx(
        value, rel=0.51 * 10 ** (1 - digits), abs=1e-300
    )


@given(finite, st.integers(1, 9))
def test_a_direction_of_rounding_is_kept(value, digits):
    above, below = (read(say.number(value, digits, toward=way)) for way in (math.inf, -math.inf))
    assert below <= value <= above


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (1234567, 4, "1,235,000"),
        (12500, 4, "12,500"),
        (1000, 4, "1,000"),
        (0.07, 4, "0.07"),
        (1e-9, 4, "1e-09"),
        (99.996, 4, "100"),
        (0.0, 4, "0"),
        (-0.0, 3, "0"),
        (65.825, 3, "65.8"),
        (math.inf, 3, "any"),
        (math.nan, 3, "-"),
    ],
)
def test_numbers_are_written_as_people_write_them(value, digits, text):
    assert say.number(value, digits) == text


@given(st.floats(0.0, 1e6), st.floats(0.0, 1e6), st.floats(0.0, 1.0), st.integers(1, 5))
def test_a_number_of_an_interval_lies_in_it_as_printed(low, width, share, digits):
    value = min(low + share * width, low + width)
    assert low <= read(say.number_within(value, low, low + width, digits)) <= low + width


def test_a_quantity_as_shown_is_one_that_a_study_can_read():
    for quantity in [each for each in QUANTITIES.values() if each.unit != "1"]:
        text = say.quantity(quantity, 0.012345, 6)
        assert parse_measure(text, quantity.dimension).si == pytest.approx(0.012345, rel=1e-5)


@given(st.integers(2, 10**6), st.floats(0.0, 1.0))
def test_the_interval_of_a_share_holds_it_and_narrows_with_the_sample(count, share):
    served = round(share * count) / count
    low, high = say.interval(served, count)
    wider = say.interval(served, count / 2)
    assert 0.0 <= wider[0] <= low <= served <= high <= wider[1] <= 1.0


def test_all_of_a_sample_is_not_everyone():
    assert say.sampled_share(1.0, 1000, "person") == "all 1,000 persons (at least 99.6 %)"
    assert say.sampled_share(0.0, 40, "draw") == "none of 40 draws (at most 8.8 %)"
    assert say.sampled_share(0.975, 1000, "person") == "97.5 % of 1,000 persons (96.3 to 98.4 %)"
    assert say.sampled_share(1.0, 1, "person") == "this person"


@given(st.floats(0.0, 1.0, exclude_max=True, exclude_min=True), st.sampled_from([2, 3]))
def test_nearly_all_is_not_all_and_hardly_any_is_not_none(share, digits):
    assert say.percent(share, digits) not in ("100 %", "0 %")


def test_every_limit_has_words_and_none_is_its_key():
    for limit in sorted(set(LIMIT_NAMES)):
        for bounds in ({}, {limit: 12.5} if limit in QUANTITIES else {}):
            for text in vars(limit_phrases.limit_words(limit, bounds)).values():
                assert text
                assert not set("_{}") & set(text)


def test_two_limits_that_exclude_each_other_are_named():
    pair = ("extensor slack", "min_elbow_stiffness")
    assert limit_phrases.conflict_label(pair, {}) == "slack and stability conflict"
    assert limit_phrases.conflict_label(("max_tension",), {}) == "tension too high"


def test_lines_end_between_quantities():
    lines = say.wrap("word " * 14 + "of 1,024 N m and K 3 kN/m", "  ")
    assert all(len(line) <= say.WIDTH for line in lines)
    assert not [line for line in lines if re.search(r"(\d|K)$", line)]


def test_columns_are_words():
    assert say.column("flexor_tension_distal") == "flexor tension at the elbow"
    assert say.column("motor_work_in") == "motor work"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Tension near the elbow", "Tension near the ankle"),
        ("Elbow angle", "Ankle angle"),
        ("an elbow bends", "an ankle bends"),
        ("`peak_elbow_torque` of elbow_angle", "`peak_elbow_torque` of elbow_angle"),
    ],
)
def test_texts_name_the_joint_of_the_study(text, shown):
    study = tendon.study({"joint": {"name": "ankle"}})
    assert (
        say.name_joint(text, study)
        == say.name_joint(text, study.record)
        == say.name_joint(text, "ankle")
        == shown
    )
    assert say.name_joint(text, tendon.study({})) == text
    assert say.name_joint("an elbow", "wrist") == "a wrist"
