"""Products of many axes give, bit for bit, what one state at a time gives."""

from dataclasses import fields, is_dataclass
from functools import cached_property

import numpy as np
import pytest

from tendon_cli.model import actuator

from .designs import baseline, design, scattered

NOT_ARRAYS = ("read", "given", "knots", "limits")
"""Members that only a following bend has, and that are no arrays of states."""


def members(result):
    """Return the names of fields and properties of a result."""
    properties = [
        name
        for name, member in vars(type(result)).items()
        if isinstance(member, property | cached_property)
    ]
    return [*(field.name for field in fields(result)), *properties]


def leaves(result, prefix=""):
    """Yield name and value of all arrays of a nested result, those of its properties included."""
    for name in members(result):
        value = getattr(result, name)
        if value is None or name in NOT_ARRAYS:
            continue
        if is_dataclass(value):
            yield from leaves(value, f"{prefix}{name}.")
        elif isinstance(value, tuple):
            for place, item in enumerate(value):
                yield f"{prefix}{name}.{place}", item
        else:
            yield prefix + name, value


def assert_identical(result, expected, name):
    assert np.array_equal(result, expected, equal_nan=True), f"{name}: {result} is not {expected}"


@pytest.fixture(scope="module")
def axes():
    """Return names and values of nine axes, each along a dimension of its own."""
    levels = {
        "load_mass": (0.0, 3.0, 10.0),
        "pretension": (20.0, 200.0),
        "ratio": (0.7, 1.0, 1.3),
        "friction": (0.0, 0.07),
        "upper_arm_angle": (-1.0, 0.0),
        "unilateral": (True, False),
        "from_initial": (True, False),
        "flexion": (True, False),
        "angle": (-0.5, 0.0, 0.4, 1.2, 2.9),
    }
    values = np.meshgrid(*levels.values(), indexing="ij", sparse=True)
    return dict(zip(levels, values, strict=True))


def evaluate(numbers):
    """Return the states of numbers by name, angle and direction among them."""
    changes = dict(numbers)
    angle = changes.pop("angle")
    flexion = changes.pop("flexion")
    return actuator.evaluate(design(baseline(**changes)), angle, flexion)


def test_a_product_of_nine_axes_equals_its_states_one_by_one(axes):
    whole = dict(leaves(evaluate(axes)))
    shape = np.broadcast_shapes(*(values.shape for values in axes.values()))
    assert whole["balance.status"].shape == shape
    assert set(range(5)) <= set(whole["balance.status"].ravel().tolist())
    rng = np.random.default_rng(5)
    for flat in rng.choice(np.prod(shape), 250, replace=False):
        index = np.unravel_index(flat, shape)
        numbers = {
            name: values.ravel()[place].item()
            for (name, values), place in zip(axes.items(), index, strict=True)
        }
        for name, expected in leaves(evaluate(numbers)):
            assert_identical(np.broadcast_to(whole[name], shape)[index], expected, name)


def test_inputs_are_left_alone():
    p, angle, flexion = scattered(100, seed=52)
    inputs = p | {"angle": angle, "flexion": flexion}
    before = {name: values.copy() for name, values in inputs.items()}
    actuator.evaluate(design(p), angle, flexion)
    for name, values in inputs.items():
        np.testing.assert_array_equal(values, before[name])


def test_states_at_another_pretension_are_those_of_the_design_with_it():
    """Compare states whose other quantities are worked out once with states solved anew."""
    angles = np.radians(np.linspace(0.0, 90.0, 7)).reshape(1, -1)
    flexion = np.array([[True], [False]])
    unloaded = actuator.evaluate(design(baseline(load_mass=3.0, pretension=0.0)), angles, flexion)
    anew = actuator.evaluate(design(baseline(load_mass=3.0, pretension=250.0)), angles, flexion)
    changed = actuator.at_pretension(unloaded, 250.0)
    for name in ("motor_torque", "elbow_stiffness", "spool_angle", "status"):
        np.testing.assert_array_equal(getattr(changed, name), getattr(anew, name))
    assert not np.array_equal(changed.motor_torque, unloaded.motor_torque)
