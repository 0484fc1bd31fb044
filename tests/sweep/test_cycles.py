"""The columns of designs that a speed adds, against the cycle of each design alone, and against its states."""

import numpy as np
import pytest

import tendon_cli as tendon_library
from tendon_cli.engine import folds
from tendon_cli.quantities import OF_CYCLES
from tendon_cli.tables.read import open_table

STUDY = {
    "tendon": {"pretension": ["80 N", "160 N"]},
    "spool": {"ratio": {"from": 0.6, "to": 1.0, "num": 3}},
    "load": {"mass": ["0 kg", "3 kg", "10 kg"]},
    "motion": {"speed": "60 deg/s", "elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
}


ANGLES = ("spool_travel", "max_backlash")


@pytest.fixture(scope="module")
def run():
    return tendon_library.sweep(tendon_library.study(STUDY))


@pytest.mark.parametrize("states", [1, 40, folds.VALUES_AT_ONCE])
def test_every_design_has_what_it_has_alone(monkeypatch, states):
    """However many are worked out at once."""
    monkeypatch.setattr(folds, "VALUES_AT_ONCE", states)
    run = tendon_library.sweep(tendon_library.study(STUDY))
    assert set(OF_CYCLES) <= set(run.designs)
    for design in (0, 7, 17):
        row = run.designs.iloc[design]
        alone = {
            **STUDY,
            "tendon": {"pretension": float(row["pretension"])},
            "spool": {"ratio": float(row["spool_ratio"])},
            "load": {"mass": float(row["load_mass"])},
        }
        single = tendon_library.sweep(tendon_library.study(alone)).designs.iloc[0]
        for name in OF_CYCLES:
            assert row[name] == pytest.approx(single[name], rel=1e-9, abs=1e-12, nan_ok=True), name


def test_the_columns_agree_with_the_states(run):
    for design, states in run.states.groupby("design"):
        row = run.designs.iloc[design]
        there, back = (
            states[states["direction"] == way].sort_values("elbow_angle")
            for way in ("flexion", "extension")
        )
        band = np.abs(there["motor_torque"].to_numpy() - back["motor_torque"].to_numpy()).max()
        assert row["max_torque_band"] == pytest.approx(band, rel=1e-9)
        assert 0.0 < row["max_backlash"] < 0.05
        # The zero of the angle differs between the directions by less than a hundredth of a radian.
        span = states["spool_angle"].max() - states["spool_angle"].min()
        assert row["spool_travel"] == pytest.approx(span, abs=0.02)
        assert row["efficiency"] == pytest.approx(1.0 - row["friction_loss"] / row["motor_work_in"])
        assert row["peak_motor_power"] <= row["peak_motor_speed"] * states[
            "motor_torque"
        ].abs().max() * (1 + 1e-12)


def test_without_a_speed_there_are_no_such_columns_and_with_one_units_stand_beside_them(run):
    still = {**STUDY, "motion": {"elbow_angle": "45 deg"}}
    assert not set(OF_CYCLES) & set(tendon_library.sweep(tendon_library.study(still)).designs)
    units = run.designs.attrs["units"]
    assert (units["peak_motor_speed"], units["friction_loss"], units["max_backlash"]) == (
        "rad/s",
        "J",
        "rad",
    )


def test_works_are_null_without_equilibrium_and_everything_where_nothing_moves(tmp_path):
    asked = {**STUDY, "motion": {"speed": "60 deg/s", "elbow_angle": ["90 deg", "170 deg"]}}
    designs = tendon_library.sweep(tendon_library.study(asked), tmp_path / "run").designs
    assert designs[["motor_work_in", "friction_loss", "efficiency"]].isna().all(axis=None)
    assert designs["peak_motor_speed"].notna().all()
    stored = open_table(tmp_path / "run" / "designs.parquet").read()
    assert stored["motor_work_in"].null_count == len(designs)


@pytest.mark.parametrize(
    ("limit", "column"),
    [
        ("max_spool_travel", "spool_travel"),
        ("max_backlash", "max_backlash"),
        ("max_torque_band", "max_torque_band"),
        ("peak_motor_speed", "peak_motor_speed"),
        ("peak_motor_power", "peak_motor_power"),
        ("max_motor_work_in", "motor_work_in"),
        ("max_friction_loss", "friction_loss"),
        ("min_efficiency", "efficiency"),
    ],
)
def test_feasible_designs_keep_every_limit_of_the_motor(run, limit, column):
    """Half of those that are feasible without the limit, and the window says the same of each."""
    feasible = run.designs[run.designs["feasible"]]
    value = float(feasible[column].median())
    held = tendon_library.sweep(
        tendon_library.study(
            {**STUDY, "limits": {limit: f"{value!r} rad" if column in ANGLES else value}}
        )
    ).designs
    kept = held[column] >= value if limit.startswith("min") else held[column] <= value
    expected = run.designs["feasible"] & kept
    assert held["feasible"].tolist() == expected.tolist()
    assert 0 < expected.sum() < run.designs["feasible"].sum()
    at_the_limit = held[column] == value
    inside = (held["pretension_from"] <= held["pretension"]) & (
        held["pretension"] <= held["pretension_to"]
    )
    assert (inside == expected)[~at_the_limit].all()


def test_a_limit_on_a_difference_that_is_none_holds_nobody_back():
    one_way = {**STUDY["motion"], "direction": "flexion"}
    free, held = (
        tendon_library.sweep(
            tendon_library.study({**STUDY, "motion": one_way, "limits": limits})
        ).designs["feasible"]
        for limits in ({}, {"max_backlash": "1e-9 rad"})
    )
    assert free.any()
    assert free.tolist() == held.tolist()
