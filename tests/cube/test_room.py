"""The room that a limit leaves is the same in designs and in their states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.errors import UsageError
from tendon_cli.model.limits import LIMITS
from tests.figures.runs import grid, sweep, table

STUDY: dict[str, Any] = {
    "arm": {"contact_width": "40 mm"},
    "motion": {"elbow_angle": grid("0 deg", "90 deg", 7), "speed": "60 deg/s"},
    "load": {"mass": ["0 kg", "5 kg"]},
    "spring": {"free_length": "73 mm"},
    "tendon": {"pretension": grid("150 N", "270 N", 4)},
    "limits": {
        "min_flexor_tension": "30 N",
        "min_extensor_tension": "20 N",
        "max_tension": "300 N",
        "max_spring_extension": "75 mm",
        "peak_motor_torque": "6 N m",
        "max_contact_pressure": "80 kPa",
        "min_spring_room": "20 mm",
        "min_elbow_stiffness": "1 N m/rad",
        "max_pretension": "200 N",
        "min_spool_to_tendon": 50.0,
        "peak_motor_speed": "100 deg/s",
        "peak_motor_power": "6 W",
    },
}


@pytest.fixture(scope="module")
def cubes(tmp_path_factory: pytest.TempPathFactory) -> tuple[Cube, Cube]:
    """Return the designs and the states of a study with limits of every kind."""
    folder = sweep(tmp_path_factory.mktemp("room") / "run", STUDY)
    return cube_of(table(folder, "designs")), cube_of(table(folder, "states"))


def alone() -> list[str]:
    """Return the limits of the study whose quantity of a single state is known."""
    return [name for name in STUDY["limits"] if name != "peak_motor_power"]


@pytest.mark.parametrize("name", alone())
def test_a_design_has_the_least_room_of_its_states(cubes: tuple[Cube, Cube], name: str) -> None:
    designs, states = cubes
    of_designs = designs.room(name, np.arange(8).reshape(2, 4))
    of_states = states.room(name, np.arange(8 * 14).reshape(2, 4, 14))
    least = of_states.min(axis=-1)
    if name == "peak_motor_speed":  # a limit on forms of taut states
        is_taut = designs.gather(np.arange(8).reshape(2, 4), ["taut"])["taut"] == 1.0
        assert is_taut.sum() > 5
        least = least[is_taut]
        of_designs = of_designs[is_taut]
    np.testing.assert_allclose(least, of_designs, rtol=1e-12, atol=1e-12)
    assert of_designs.min() < of_designs.max() or name == "min_spool_to_tendon"


def test_rows_may_be_in_any_order_and_shape(cubes: tuple[Cube, Cube]) -> None:
    _, states = cubes
    rows = np.array([[97, 3], [15, 97]])
    every = states.room("max_tension", np.arange(8 * 14))
    np.testing.assert_array_equal(states.room("max_tension", rows), every[rows])


def test_room_is_zero_within_rounding_of_the_bound() -> None:
    bound = 0.3
    values = np.array([bound * (1.0 + 1e-12), bound * (1.0 - 1e-12), 0.4, np.nan])

    def room(name: str, values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        return LIMITS[name].room(values, bound)

    np.testing.assert_allclose(room("max_tension", values), [0, 0, -0.1, np.nan])
    np.testing.assert_allclose(room("min_flexor_tension", values)[2], 0.1)
    np.testing.assert_allclose(room("peak_motor_torque", -values)[2], -0.1)


def test_states_have_no_column_of_power(cubes: tuple[Cube, Cube]) -> None:
    designs, states = cubes
    assert np.isfinite(designs.room("peak_motor_power", np.arange(8))).all()
    with pytest.raises(UsageError, match=r"which limits\.peak_motor_power bounds$"):
        states.room("peak_motor_power", np.arange(3))
