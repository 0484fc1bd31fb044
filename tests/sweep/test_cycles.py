"""The columns that a speed adds agree with the cycle of each design alone, and with its states."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.engine import folds
from tendon_cli.quantities import OF_CYCLES
from tendon_cli.studies.study import keys
from tendon_cli.tables.read import open_table

STUDY = {
    "tendon": {"pretension": ["80 N", "160 N"]},
    "spool": {"ratio": {"from": 0.6, "to": 1.0, "num": 3}},
    "load": {"mass": ["0 kg", "3 kg", "10 kg"]},
    "motion": {"speed": "60 deg/s", "elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
}


AXES = ["pretension", "spool_ratio", "load_mass"]


def sweep_of(content, out=None):
    return tendon.sweep(tendon.study(content), out)


@pytest.fixture(scope="module")
def run():
    """Return the sweep of STUDY."""
    return sweep_of(STUDY)


@pytest.mark.parametrize("states", [1, 40])
def test_every_design_has_what_it_has_alone(monkeypatch, states):
    """It does not matter how many are worked out at once."""
    with monkeypatch.context() as patch:
        patch.setattr(folds, "VALUES_AT_ONCE", states)
        run = sweep_of(STUDY)
    assert set(OF_CYCLES) <= set(run.designs)
    for design in (0, 17):
        row = run.designs.iloc[design]
        alone = {
            **STUDY,
            "tendon": {"pretension": float(row["pretension"])},
            "spool": {"ratio": float(row["spool_ratio"])},
            "load": {"mass": float(row["load_mass"])},
        }
        single = sweep_of(alone).designs.iloc[0]
        for name in OF_CYCLES:
            assert row[name] == pytest.approx(single[name], rel=1e-9, abs=1e-12, nan_ok=True), name


def test_the_columns_agree_with_the_states(run):
    for design, states in run.states.groupby("design"):
        row = run.designs.iloc[design]
        torque = states.sort_values("elbow_angle").set_index("direction")["motor_torque"]
        flexion = torque["flexion"].to_numpy()
        extension = torque["extension"].to_numpy()
        band = np.abs(flexion - extension).max()
        assert row["max_torque_band"] == pytest.approx(band, rel=1e-9)
        assert 0.0 < row["max_backlash"] < 0.05
        # The zero of the angle differs between the directions by less than a hundredth of a radian.
        span = states["spool_angle"].max() - states["spool_angle"].min()
        assert row["spool_travel"] == pytest.approx(span, abs=0.02)
        assert row["efficiency"] == pytest.approx(1.0 - row["friction_loss"] / row["motor_work_in"])
        peak_torque = states["motor_torque"].abs().max()
        assert row["peak_motor_power"] <= row["peak_motor_speed"] * peak_torque * (1 + 1e-12)


def test_without_a_speed_there_are_no_such_columns_and_with_one_units_stand_beside_them(run):
    still = {**STUDY, "motion": {"elbow_angle": "45 deg"}}
    assert not set(OF_CYCLES) & set(sweep_of(still).designs)
    units = run.designs.attrs["units"]
    assert units["peak_motor_speed"] == "rad/s"
    assert units["friction_loss"] == "J"
    assert units["max_backlash"] == "rad"


def test_works_are_null_without_equilibrium_and_everything_where_nothing_moves(tmp_path):
    motion = {"speed": "60 deg/s", "elbow_angle": ["90 deg", "170 deg"]}
    designs = sweep_of({**STUDY, "motion": motion}, tmp_path / "run").designs
    assert designs[["motor_work_in", "friction_loss", "efficiency"]].isna().all(axis=None)
    assert designs["peak_motor_speed"].notna().all()
    stored = open_table(tmp_path / "run" / "designs.parquet").read()
    assert stored["motor_work_in"].null_count == len(designs)


@pytest.mark.parametrize("limit", ["peak_motor_speed", "peak_motor_power"])
def test_feasible_designs_keep_every_limit_of_the_motor(run, limit):
    """Half of those that are feasible without the limit keep it, and the windows agree."""
    feasible = run.designs[run.designs["feasible"]]
    median = float(feasible[limit].median())
    limited = sweep_of({**STUDY, "limits": {limit: median}}).designs
    expected = run.designs["feasible"] & (limited[limit] <= median)
    assert limited["feasible"].tolist() == expected.tolist()
    assert 0 < expected.sum() < run.designs["feasible"].sum()
    pretension = limited["pretension"]
    is_above = limited["pretension_from"] <= pretension
    is_below = pretension <= limited["pretension_to"]
    is_at_the_limit = limited[limit] == median
    assert ((is_above & is_below) == expected)[~is_at_the_limit].all()


@pytest.mark.parametrize("key", ["arm.contact_width", "spring.free_length"])
def test_a_number_that_no_state_depends_on_may_be_an_axis(key):
    table, _, name = key.partition(".")
    with_axis = {**STUDY, table: {name: ["30 mm", "60 mm"]}}
    once = sweep_of(STUDY).designs
    twice = sweep_of(with_axis).designs
    first = twice[twice[keys()[key].column] == 0.03]
    second = twice[twice[keys()[key].column] == 0.06]
    for of_one in (first, second):
        for name in OF_CYCLES:
            by_itself = of_one.sort_values(AXES)[name].to_numpy()
            expected = once.sort_values(AXES)[name].to_numpy()
            assert by_itself == pytest.approx(expected, rel=1e-12, nan_ok=True), name
