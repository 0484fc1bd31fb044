"""A design is feasible if its columns in the tables are within every limit of the study."""

import numpy as np
import pytest

from tendon_cli.quantities import OF_STATES

STUDY = """
[arm]
contact_width = "40 mm"
[tendon]
pretension = { from = "60 N", to = "260 N", num = 21 }
[spool]
ratio = [0.6, 0.8, 1.0]
[load]
mass = ["0 kg", "5 kg"]
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 10 }
"""
LIMITS = {
    "min_flexor_tension = '30 N'": lambda d: d["min_flexor_tension"] >= 30.0,
    "min_extensor_tension = '20 N'": lambda d: d["min_extensor_tension"] >= 20.0,
    "max_tension = '300 N'": lambda d: d["max_tension"] <= 300.0,
    "max_spring_extension = '75 mm'": lambda d: d["max_spring_extension"] <= 0.075,
    "peak_motor_torque = '6 N m'": lambda d: d["peak_motor_torque"].abs() <= 6.0,
    "min_elbow_stiffness = '3 N m/rad'": lambda d: d["min_elbow_stiffness"] >= 3.0,
    "max_pretension = '150 N'": lambda d: d["pretension"] <= 150.0 + 1e-6,
    "min_spool_to_tendon = 30": lambda d: d["spool_ratio"] * 60.0 / 1.5 >= 30.0,
    "max_contact_pressure = '80 kPa'": lambda d: d["most_distal"] / (0.045 * 0.04) <= 80e3,
}


@pytest.mark.parametrize("limit", LIMITS)
def test_a_limit_leaves_out_just_the_designs_beyond_it(new_sweep, tmp_path, limit):
    swept = new_sweep(f"{STUDY}[limits]\n{limit}\n".replace("'", '"'), tmp_path)
    designs = swept.designs
    pressed = swept.states[swept.states["elbow_angle"] > np.radians(9.99)]
    designs["most_distal"] = pressed.groupby("design")["extensor_tension_distal"].max()
    within = LIMITS[limit](designs)
    assert 0 < within.sum() < len(designs)
    assert (designs["feasible"] == (designs["taut"] & designs["stable"] & within)).all()
    assert swept.record["feasible"] == designs["feasible"].sum()


def test_a_column_is_null_only_where_its_schema_says_so(new_sweep, tmp_path):
    """A tension is never null, and its field says so, if the arm never reaches its dead centre."""
    everywhere = new_sweep(STUDY, tmp_path).table("states").read().schema
    assert not everywhere.field("flexor_tension_distal").nullable
    assert not everywhere.field("pretension").nullable
    assert everywhere.field("flexor_slack").nullable
    past_the_centre = STUDY.replace('"90 deg"', '"170 deg"')
    beyond = new_sweep(past_the_centre, tmp_path, out="beyond").table("states").read()
    assert beyond.schema.field("flexor_tension_distal").nullable
    assert beyond.column("flexor_tension_distal").null_count > 0
    for field in beyond.schema:
        assert field.nullable or beyond.column(field.name).null_count == 0


def test_only_the_columns_asked_for_are_kept_and_they_are_the_same(new_sweep, tmp_path):
    whole = new_sweep(STUDY, tmp_path).states
    output = '[output]\nstates = ["status", "motor_torque"]\n'
    kept = new_sweep(STUDY + output, tmp_path, out="kept").states
    keys = [name for name in whole.columns if name not in ("status", *OF_STATES)]
    assert kept.columns.tolist() == [*keys, "status", "motor_torque"]
    for name in kept.columns:
        assert np.array_equal(kept[name], whole[name]), name
