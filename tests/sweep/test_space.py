"""One place says what a number is: boxes of the product and listed points agree to the bit, over every kind of axis."""

import dataclasses

import numpy as np
import pytest

from tendon_cli.engine.plan import Plan
from tendon_cli.space.axis import Axis, overlay
from tendon_cli.space.space import Space
from tendon_cli.studies.load import study_from
from tendon_cli.studies.spaces import space_of

SIDES = {
    "tendon": {"pretension": [50.0, 90.0], "flexor": {"length": [1.0, 2.0, 3.0]}, "length": 2.5},
    "sheath": {
        "friction": {"from": 0.05, "to": 0.1, "num": 3},
        "extensor": {"bend_angle": "100 deg"},
    },
}
CASES = {
    "cases": [
        {"name": "a", "arm": {"b1": "140 mm"}, "model": {"reference": "initial"}},
        {
            "name": "b",
            "sheath": {"flexor": {"bend_angle": "90 deg"}},
            "spring": {"stiffness": "4 kN/m"},
        },
        {"name": "c", "model": {"slack": "bilateral"}, "tendon": {"extensor": {"length": "1 m"}}},
    ]
}
DOUBT = {
    "spring": {"extensor": {"stiffness": "5 kN/m +/- 1 kN/m"}},
    "arm": {"a1": "35 mm to 45 mm"},
}
STUDIES = [
    SIDES,
    SIDES | CASES,
    CASES | {"people": {"count": 3}, "arm": {"a2": [0.02, 0.03], "forearm_mass": 1.2}},
    DOUBT | {"uncertainty": {"draws": 4}, "spool": {"ratio": [0.6, 1.0]}},
    DOUBT
    | {
        "uncertainty": {"draws": 4},
        "people": {"count": 3},
        "load": {"mass": {"from": 0.0, "to": 5.0}},
    },
    DOUBT | {"uncertainty": {"draws": 2}, "people": {"count": 5}},
]


def leaves(made, path=""):
    """Every number of a design by its path."""
    for each in dataclasses.fields(made):
        value = getattr(made, each.name)
        if dataclasses.is_dataclass(value):
            yield from leaves(value, f"{path}{each.name}.")
        elif isinstance(value, dict):
            yield from ((f"{path}{each.name}.{key}", number) for key, number in value.items())
        else:
            yield f"{path}{each.name}", value


def same(design, whole, shape):
    """Whether designs of a box are those at the rows of its points."""
    for (name, boxed), (_, listed) in zip(leaves(design), leaves(whole), strict=True):
        if boxed is not None:
            expected = np.broadcast_to(boxed, (*shape, 1, 1)).ravel()
            np.testing.assert_array_equal(
                np.broadcast_to(listed, (len(expected), 1, 1)).ravel(), expected, err_msg=name
            )


@pytest.mark.parametrize("content", STUDIES)
def test_boxes_and_points_are_the_same_designs(content):
    plan = Plan(study_from(content))
    space, rows = plan.space, np.arange(plan.designs)
    listed = Space((Axis.of_points(space.numbers(rows), len(rows)),), space.single).design()
    same(space.design(), listed, space.shape)
    for design in rows[:: max(1, len(rows) // 7)]:
        one = tuple(slice(at, at + 1) for at in plan.coordinates(int(design)))
        points = Axis.of_points(space.numbers(rows[[design]]), 1)
        same(space.design(one), Space((points,), space.single).design(), (1,) * len(one))


@pytest.mark.parametrize("content", STUDIES)
def test_choices_under_conditions_are_the_designs_of_the_whole_product(content):
    space = space_of(study_from(content)).without_pretension()
    choices, conditions = space.choices, space.conditions
    shape = len(choices), len(conditions)
    first, second = np.indices(shape).reshape(2, -1)
    sides = choices.numbers(np.arange(shape[0])), conditions.numbers(np.arange(shape[1]))
    crossed = Space(tuple(map(Axis.of_points, sides, shape)), space.single)
    paired = overlay(choices.numbers(first), conditions.numbers(second))
    same(
        crossed.design(), Space((Axis.of_points(paired, len(first)),), space.single).design(), shape
    )
    assert len(first) == len(space)


def test_a_side_goes_before_both_and_a_case_before_the_study():
    space = space_of(study_from(SIDES | CASES))

    def values(key, side):
        return np.ravel(space.number(key, side).within(space.whole))

    np.testing.assert_allclose(
        np.degrees(values("sheath.bend_angle", "flexor")), [180.0, 90.0, 180.0]
    )
    np.testing.assert_allclose(np.degrees(values("sheath.bend_angle", "extensor")), 100.0)
    np.testing.assert_array_equal(values("tendon.length", "flexor"), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(values("tendon.length", "extensor"), [2.5, 2.5, 1.0])
