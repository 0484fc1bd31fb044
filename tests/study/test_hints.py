"""Hints of a study's faults: what was probably meant, in the field's own unit and words."""

import re

import pytest

from tendon_cli.errors import StudyError, UsageError
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.filters import read_filter
from tendon_cli.studies.load import any_study
from tendon_cli.studies.study import keys


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


HINTED_VALUE = re.compile(r'"([^"]+)"')


@pytest.mark.parametrize("number", ["0.01", "2", "75", "900", "1e5", "-3"])
def test_a_hint_at_a_unit_leads_to_no_other_error(number):
    """Every value that a hint writes is possible for its key, whatever the key."""
    for key in (*keys(), "setting.accuracy"):
        content = number
        for name in reversed(key.split(".")):
            content = {name: content}
        faults = []
        try:
            any_study(content)
        except StudyError as error:
            faults = [fault for fault in error.faults if fault.key == key]
        for fault in faults:
            if "has no unit" not in fault.problem and "neither a length" not in fault.problem:
                continue
            for value in HINTED_VALUE.findall(fault.hint or ""):
                assert float(value.partition(" ")[0]) == float(number)
                again = again_at(key, value)
                assert "out of range" not in again, (key, value)
                assert "negative" not in again, (key, value)
                assert "impossible" not in again, (key, value)


def again_at(key, value):
    """Return what a study says of a value at a key; empty if nothing."""
    content = value
    for name in reversed(key.split(".")):
        content = {name: content}
    try:
        any_study({**content, "allow_implausible": True})
    except StudyError as error:
        return " ".join(fault.problem for fault in error.faults if fault.key == key)
    return ""


def test_an_accuracy_without_a_unit_may_be_a_length_or_a_tension():
    for value in ("2", 2):
        assert fault_of({"setting": {"accuracy": value}}).hint == 'write "2 mm" or "2 N"'
    assert fault_of({"setting": {"accuracy": "-2"}}).hint is None


@pytest.mark.parametrize(
    ("name", "meant"), [("max_speed", "peak_motor_speed"), ("max_power", "peak_motor_power")]
)
def test_a_limit_may_be_meant_by_its_noun(name, meant):
    assert fault_of({"limits": {name: 3}}).hint == f'did you mean "{meant}"?'


def test_a_column_of_a_table_is_offered_where_there_is_a_table():
    unknown = {"limits": {"price": 3}}
    assert "[[table]]" not in fault_of(unknown).hint
    table = {"name": "motor", "rows": [{"name": "A", "spool.ratio": 0.6, "price": 5}]}
    assert "tendon show RESULTS" in fault_of({**unknown, "table": [table]}).hint


def test_a_filter_without_a_unit_is_told_the_unit_in_which_its_column_is_shown():
    for name, quantity in QUANTITIES.items():
        if quantity.dimension == "number" or quantity.has_own_unit:
            continue
        with pytest.raises(UsageError) as raised:
            read_filter(f"{name} = 3").condition_on(name, quantity)
        assert f'"3 {quantity.shown_in}"' in raised.value.hint


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
