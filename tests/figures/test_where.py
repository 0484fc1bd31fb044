"""Filters are read by a strict grammar, with units and a tolerance."""

from __future__ import annotations

import numpy as np
import pytest

from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.errors import UsageError
from tests.figures.runs import LOADS, grid, states


@pytest.fixture(scope="module")
def cube(tmp_path_factory: pytest.TempPathFactory) -> Cube:
    content = {
        "cases": [
            {"name": "child, 7", "arm": {"b1": "88 mm"}, "spring": {"at": "motor"}},
            {"name": "adult"},
        ],
        "tendon": {"pretension": grid("0 N", "100 N", 4)},
        "load": {"mass": LOADS},
    }
    return cube_of(states(tmp_path_factory.mktemp("where") / "run", content))


@pytest.mark.parametrize(
    ("text", "column", "left"),
    [
        ("load_mass = 5 kg", "load_mass", [2]),
        ("load.mass==5kg", "load_mass", [2]),
        ("load_mass = 5000 g", "load_mass", [2]),
        ("load_mass != 5 kg", "load_mass", [0, 1, 3]),
        ("load_mass in 3 kg, 10 kg", "load_mass", [1, 3]),
        ("load_mass in [3 kg, 10 kg]", "load_mass", [1, 3]),
        ("load_mass <= 5 kg", "load_mass", [0, 1, 2]),
        ("load_mass < 5 kg", "load_mass", [0, 1]),
        ("load_mass >= 5 kg", "load_mass", [2, 3]),
        ("load_mass > 5 kg", "load_mass", [3]),
        ("pretension = 33.33 N", "pretension", [1]),
        ("pretension >= 33.333333333333 N", "pretension", [1, 2, 3]),
        ("elbow_angle < 6.1 deg", "elbow_angle", [0, 1]),
        ("elbow_angle = 0.1047197551 rad", "elbow_angle", [1]),
        ("direction = flexion", "direction", [0]),
        ('case = "child, 7"', "case", [0]),
        ("case != adult", "case", [0]),
        ("arm.b1 = 88 mm", "case", [0]),
        ("arm_b1 > 88 mm", "case", [1]),
        ("spring_at = motor", "case", [0]),
    ],
)
def test_what_is_left(cube: Cube, text: str, column: str, left: list[int]) -> None:
    chosen = cube.choose(cube.conditions([text]))
    assert list(chosen[column]) == left
    unfiltered = {name: positions for name, positions in chosen.items() if name != column}
    for name, positions in unfiltered.items():
        assert len(positions) == cube.axis(name).length


@pytest.mark.parametrize(
    ("text", "problem", "hint"),
    [
        ("laod_mass = 5 kg", "no column", "load_mass"),
        ("load_mass = 5", "no unit", "5 kg"),
        ("load_mass = 5 N", "is a force", "mass"),
        ("load_mass = 1,5 kg", "not one number", "decimal sign"),
        ("load_mass", "not a filter", "such as"),
        ("load_mass = 5 kg or 1 == 1", "unknown unit", ""),
        ("__import__('os').system('true')", "not a filter", "such as"),
        ("load_mass = __import__('os')", "not one number", ""),
        ("direction < flexion", "no order", "="),
        ("direction = up", "never", "flexion, extension"),
        ("load_mass = " + "9" * 600, "not a filter", "such as"),
    ],
)
def test_what_is_refused(cube: Cube, text: str, problem: str, hint: str) -> None:
    with pytest.raises(UsageError) as refused:
        cube.choose(cube.conditions([text]))
    assert problem in refused.value.message
    assert hint in (refused.value.hint or "")
    assert len(refused.value.message) < 200


def test_filters_add_up_and_if_nothing_is_left_the_values_are_listed(cube: Cube) -> None:
    filters = cube.conditions(["load_mass > 0 kg", "load_mass < 10 kg"])
    assert list(cube.choose(filters)["load_mass"]) == [1, 2]
    hints = {
        "load_mass = 4 kg": "values: 0 kg, 3 kg, 5 kg, 10 kg",
        "elbow_angle = 7 deg": "values: 0 deg, 6 deg, 12 deg, …, 90 deg",
    }
    for text, hint in hints.items():
        with pytest.raises(UsageError) as refused:
            cube.choose(cube.conditions([text]))
        assert refused.value.hint == hint


def test_a_filter_on_a_result_holds_by_its_values(cube: Cube) -> None:
    at_least, unequal = cube.conditions(["motor_torque >= 2 N m", "motor_torque != 2 N m"])
    assert list(at_least.holds(np.array([1.0, 2.0, 3.0, np.nan]))) == [False, True, True, False]
    assert list(unequal.holds(np.array([1.0, 2.0, np.nan]))) == [True, False, False]
