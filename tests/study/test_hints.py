"""Hints of a study's faults: what was probably meant, in the field's own unit and words."""

import pytest

from tendon_cli.errors import StudyError
from tendon_cli.studies.load import any_study


def fault_of(content):
    """Return the only fault of a study."""
    with pytest.raises(StudyError) as raised:
        any_study(content)
    (fault,) = raised.value.faults
    return fault


@pytest.mark.parametrize(
    ("key", "value", "hint"),
    [
        ("arm.b1", "110", '"110 mm"'),
        ("arm.b1", "110 m", '"110 mm"'),
        ("load.mass", "4", '"4 kg"'),
        ("spring.stiffness", "3", '"3 kN/m"'),
        ("motion.elbow_angle", "4", '"4 deg" or "4 rad"'),
    ],
)
def test_the_hint_has_the_usual_unit_of_the_field(key, value, hint):
    table, name = key.split(".")
    assert hint in fault_of({table: {name: value}}).hint


def test_a_number_that_no_unit_makes_possible_has_no_such_hint():
    assert fault_of({"load": {"mass": "-4 kg"}}).hint is None


def test_a_name_that_several_keys_say_with_more_words_may_be_any_of_them():
    hint = fault_of({"limits": {"max_motor": "3 N m"}}).hint
    assert "peak_motor_torque" in hint
    assert "peak_motor_speed" in hint


def test_a_name_means_one_that_ends_in_its_noun_before_one_that_only_has_it():
    hint = fault_of({"limits": {"max_torque": "3 N m"}}).hint
    assert hint == 'did you mean "peak_motor_torque"?'


def test_the_radius_of_the_extensor_is_told_by_the_ratio():
    hint = fault_of({"spool": {"extensor_radius": "30 mm"}}).hint
    assert "spool.ratio times spool.flexor_radius" in hint


def test_an_interval_with_equal_ends_is_told_the_one_value():
    fault = fault_of({"arm": {"b1": {"from": 0.07, "to": 0.07}}})
    assert fault.hint == 'write "0.07 m" for this one value'
    assert any_study({"arm": {"b1": "0.07 m"}}).arm.b1.single == 0.07
    turned = fault_of({"arm": {"b1": {"from": 0.08, "to": 0.07}}})
    assert 'from = "0.07 m", to = "0.08 m"' in turned.hint


@pytest.mark.parametrize("prove", [[1, 2], ["1", "2"], [1, "2"]])
def test_rows_to_prove_are_numbers_or_words(prove):
    assert any_study({"design": {"prove": prove}}).design.prove == ("1", "2")


def test_one_row_to_prove_needs_no_list():
    assert any_study({"design": {"prove": 3}}).design.prove == ("3",)
    fault_of({"design": {"prove": [True]}})


def test_nobody_is_no_share_to_serve():
    assert "0 is impossible" in fault_of({"design": {"serve": 0}}).problem
    assert any_study({"design": {"serve": 0.5}}).serve == 0.5
