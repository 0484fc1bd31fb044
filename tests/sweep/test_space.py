"""Boxes of the product and listed points agree to the bit, over every kind of axis."""

import dataclasses

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.engine.plan import Plan
from tendon_cli.errors import StudyError
from tendon_cli.studies.load import study_from
from tendon_cli.studies.space.axis import Axis, overlay
from tendon_cli.studies.space.space import Space
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


def leaves(node, path=""):
    """Yield every number of a design by its path."""
    for field in dataclasses.fields(node):
        value = getattr(node, field.name)
        name = f"{path}{field.name}"
        if dataclasses.is_dataclass(value):
            yield from leaves(value, f"{name}.")
        elif isinstance(value, dict):
            for key, number in value.items():
                yield f"{name}.{key}", number
        else:
            yield name, value


def assert_same(boxes, points, shape):
    """Raise unless the designs of a box are those at the rows of its points."""
    for (name, boxed), (_, listed) in zip(leaves(boxes), leaves(points), strict=True):
        if boxed is not None:
            expected = np.broadcast_to(boxed, (*shape, 1, 1)).ravel()
            actual = np.broadcast_to(listed, (len(expected), 1, 1)).ravel()
            np.testing.assert_array_equal(actual, expected, err_msg=name)


def design_at(numbers, count, single):
    """Return the designs of a list of points."""
    return Space((Axis.of_points(numbers, count),), single).design()


@pytest.mark.parametrize("content", STUDIES)
def test_boxes_and_points_are_the_same_designs(content):
    plan = Plan(study_from(content))
    space = plan.space
    rows = np.arange(plan.designs)
    listed = design_at(space.numbers(rows), len(rows), space.single)
    assert_same(space.design(), listed, space.shape)
    for row in rows[:: max(1, len(rows) // 7)]:
        box = tuple(slice(index, index + 1) for index in plan.coordinates(int(row)))
        point = design_at(space.numbers(rows[[row]]), 1, space.single)
        assert_same(space.design(box), point, (1,) * len(box))


@pytest.mark.parametrize("content", STUDIES)
def test_choices_under_conditions_are_the_designs_of_the_whole_product(content):
    space = space_of(study_from(content)).without_pretension()
    choices = space.choices
    conditions = space.conditions
    shape = (len(choices), len(conditions))
    axis_of_choices = Axis.of_points(choices.numbers(np.arange(shape[0])), shape[0])
    axis_of_conditions = Axis.of_points(conditions.numbers(np.arange(shape[1])), shape[1])
    crossed = Space((axis_of_choices, axis_of_conditions), space.single)
    choice, condition = np.indices(shape).reshape(2, -1)
    paired = overlay(choices.numbers(choice), conditions.numbers(condition))
    assert_same(crossed.design(), design_at(paired, len(choice), space.single), shape)
    assert len(choice) == len(space)


def test_a_side_goes_before_both_and_a_case_before_the_study():
    space = space_of(study_from(SIDES | CASES))

    def values(key, side):
        return np.ravel(space.number(key, side).within(space.whole))

    flexor_bend = np.degrees(values("sheath.bend_angle", "flexor"))
    extensor_bend = np.degrees(values("sheath.bend_angle", "extensor"))
    np.testing.assert_allclose(flexor_bend, [180.0, 90.0, 180.0])
    np.testing.assert_allclose(extensor_bend, 100.0)
    np.testing.assert_array_equal(values("tendon.length", "flexor"), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(values("tendon.length", "extensor"), [2.5, 2.5, 1.0])


def test_a_side_goes_before_a_bend_that_follows_the_joint(tmp_path):
    """A list of a side's bends gives the designs of each, and its table is read again."""
    curve = {"angle": ["0 deg", "90 deg"], "bend": ["122 deg", "118 deg"]}

    def sweep(bends, folder=None):
        study = {"sheath": {"bend_angle": curve, "extensor": {"bend_angle": bends}}}
        return tendon.sweep({"tendon": {"pretension": "200 N"}} | study, folder)

    listed = sweep(["100 deg", "500 deg"], tmp_path / "run")
    single = [sweep(bend).designs["max_tension"][0] for bend in ("100 deg", "500 deg")]
    np.testing.assert_allclose(listed.designs["max_tension"], single, rtol=1e-12)
    np.testing.assert_allclose(np.degrees(listed.designs["bend_angle_extensor"]), [100.0, 500.0])
    assert listed.designs["bend_angle_flexor"].isna().all()
    tendon.check(tmp_path / "run")


def test_rows_do_not_replace_a_bend_that_follows_the_joint():
    """Rows that set no bend would need the curve, which no row holds."""
    curve = {"angle": ["0 deg", "90 deg"], "bend": ["122 deg", "118 deg"]}
    rows = [{"name": "a", "sheath": {"extensor": {"bend_angle": "500 deg"}}}, {"name": "b"}]
    with pytest.raises(StudyError, match=r"sheath\.bend_angle follows the joint"):
        study_from({"sheath": {"bend_angle": curve}, "cases": rows})
    whole = {"bend_angle": curve, "extensor": {"bend_angle": "100 deg"}}
    assert len(space_of(study_from({"sheath": whole, "cases": rows}))) == 2
