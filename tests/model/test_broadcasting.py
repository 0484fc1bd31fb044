"""Products of many axes give, bit for bit, what one state at a time gives."""

from dataclasses import fields, is_dataclass
from functools import cached_property

import numpy as np
import pytest

from tendon_cli.model import actuator

from .designs import baseline, design, scattered


def leaves(result, prefix=""):
    """All arrays of a nested result, also those that are made of its fields, by name."""
    made = [
        name
        for name, each in vars(type(result)).items()
        if isinstance(each, property | cached_property)
    ]
    for name in (*(field.name for field in fields(result)), *made):
        value = getattr(result, name)
        if value is None or name in (
            "read",
            "given",
            "knots",
        ):  # what only a following bend has; no arrays of states
            continue
        if is_dataclass(value):
            yield from leaves(value, f"{prefix}{name}.")
        elif isinstance(value, tuple):
            yield from ((f"{prefix}{name}.{place}", each) for place, each in enumerate(value))
        else:
            yield prefix + name, value


def assert_identical(found, expected, name):
    assert np.array_equal(found, expected, equal_nan=True), f"{name}: {found} is not {expected}"


@pytest.fixture(scope="module")
def axes():
    """One axis each for load, inclination, pretension, ratio, friction, model, reference, direction and angle."""
    values = (
        ("load_mass", (0.0, 3.0, 10.0)),
        ("pretension", (20.0, 200.0)),
        ("ratio", (0.7, 1.0, 1.3)),
        ("friction", (0.0, 0.07)),
        ("upper_arm_angle", (-1.0, 0.0)),
        ("unilateral", (True, False)),
        ("from_initial", (True, False)),
        ("flexion", (True, False)),
        ("angle", (-0.5, 0.0, 0.4, 1.2, 2.9)),
    )
    return [
        (name, np.reshape(levels, [-1 if i == place else 1 for i in range(len(values))]))
        for place, (name, levels) in enumerate(values)
    ]


def apart(changes):
    changes = dict(changes)
    return changes.pop("angle"), changes.pop("flexion"), design(baseline(**changes))


def test_a_product_of_nine_axes_equals_its_states_one_by_one(axes):
    angle, flexion, many = apart(axes)
    whole = dict(leaves(actuator.evaluate(many, angle, flexion)))
    shape = np.broadcast_shapes(*(values.shape for _, values in axes))
    assert whole["balance.status"].shape == shape
    assert set(range(5)) <= set(whole["balance.status"].ravel().tolist())
    rng = np.random.default_rng(5)
    for flat in rng.choice(np.prod(shape), 250, replace=False):
        index = np.unravel_index(flat, shape)
        at, toward, one = apart(
            [
                (name, values.ravel()[place].item())
                for (name, values), place in zip(axes, index, strict=True)
            ]
        )
        for name, expected in leaves(actuator.evaluate(one, at, toward)):
            assert_identical(np.broadcast_to(whole[name], shape)[index], expected, name)


def test_inputs_are_left_alone():
    p, angle, flexion = scattered(100, seed=52)
    before = {name: values.copy() for name, values in p.items()} | {
        "angle": angle.copy(),
        "flexion": flexion.copy(),
    }
    actuator.evaluate(design(p), angle, flexion)
    for name, values in (p | {"angle": angle, "flexion": flexion}).items():
        np.testing.assert_array_equal(values, before[name])
