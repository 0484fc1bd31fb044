"""Tables agree with the model, state by state, and designs with their states."""

import itertools
import json
import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tendon_cli.model import actuator
from tendon_cli.model.statics import STATUS_NAMES
from tendon_cli.quantities import QUANTITIES

from .studies import (
    CASES,
    NEVER_PAST_THE_CENTRE,
    PRETENSION_PER_SIDE,
    STUDY,
    all_numbers,
    all_numbers_per_side,
    design_of,
    on_side,
)

LEADING = [
    "design",
    "pretension",
    "spring_stiffness",
    "spool_ratio",
    "load_mass",
    "friction",
    "bend_angle",
]
STATE_COLUMNS = [
    "direction",
    "elbow_angle",
    "status",
    "flexor_tension_proximal",
    "flexor_tension_distal",
    "extensor_tension_proximal",
    "extensor_tension_distal",
    "flexor_tendon_stretch",
    "extensor_tendon_stretch",
    "flexor_spring_stretch",
    "extensor_spring_stretch",
    "flexor_slack",
    "extensor_slack",
    "elbow_torque",
    "motor_torque",
    "spool_angle",
    "elbow_stiffness",
    "flexor_moment_arm",
    "flexor_travel",
    "extensor_travel",
]
DESIGN_COLUMNS = [
    "min_flexor_tension",
    "min_extensor_tension",
    "max_tension",
    "max_spring_extension",
    "peak_elbow_torque",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_slack",
    "slack_fraction",
    "unstable_fraction",
    "first_slack_angle",
    "required_pretension",
    "margin",
    "max_contact_pressure",
    "min_spool_to_tendon",
    "pretension_from",
    "pretension_to",
    "taut",
    "stable",
    "feasible",
]
TESTED_WITH_WINDOWS = {
    "pretension_from",
    "pretension_to",
    "max_contact_pressure",
    "min_spool_to_tendon",
}
"""Columns that test_windows.py tests."""
TESTED_BY_BISECTION = {"required_pretension", "margin"}
SIDES = ("flexor", "extensor")
OF_CASES_ALONE = ("arm.b1", "arm.forearm_mass", "arm.upper_arm_angle", "spool.flexor_radius")
"""Numbers that nothing but the cases of the study varies."""
GEOMETRY = ["flexor_moment_arm", "flexor_travel", "extensor_travel"]
RESULTS = [name for name in STATE_COLUMNS[3:] if name not in GEOMETRY]
TENSIONS_OF_FLEXOR = ["flexor_tension_proximal", "flexor_tension_distal"]
TENSIONS_OF_EXTENSOR = ["extensor_tension_proximal", "extensor_tension_distal"]
TENSIONS = TENSIONS_OF_FLEXOR + TENSIONS_OF_EXTENSOR
SLACK_LENGTHS = ["flexor_slack", "extensor_slack"]
SLACK = ("flexor slack", "extensor slack", "both slack")
ANGLES = np.radians([90.0, -30.0, 0.0, 15.0, 60.0, 130.0, 175.0])
MOTION = list(itertools.product(("extension", "flexion"), ANGLES))
FEW_MOTION = [(direction, angle) for direction, angle in MOTION if -0.1 < angle < 3.0]


@pytest.fixture(scope="module")
def full(new_sweep, tmp_path_factory):
    """Run the study with states beyond the joint's centre."""
    return new_sweep(STUDY, tmp_path_factory.mktemp("full"))


@pytest.fixture(scope="module")
def solvable(new_sweep, tmp_path_factory):
    """Run the study whose every state has an equilibrium."""
    return new_sweep(NEVER_PAST_THE_CENTRE, tmp_path_factory.mktemp("solvable"))


@pytest.fixture(scope="module")
def per_side(new_sweep, tmp_path_factory):
    """Run the study in one case of which the sides differ in pretension."""
    return new_sweep(PRETENSION_PER_SIDE, tmp_path_factory.mktemp("per_side"))


def one_state(numbers, direction, angle):
    """Return a row of states, from the model called with plain numbers."""
    design = design_of(numbers)
    state = actuator.evaluate(design, float(angle), direction == "flexion")
    row = {
        "direction": direction,
        "elbow_angle": float(angle),
        "status": STATUS_NAMES[int(state.status)],
    }
    row |= {name: float(values) for name, values in state.columns().items()}
    for side in SIDES:
        properties = getattr(design, side)
        tension = float(getattr(state.balance, side))
        change = tension - properties.pretension
        row[f"{side}_tension_distal"] = tension
        row[f"{side}_tendon_stretch"] = float(getattr(state, side).tendon) * change
        row[f"{side}_spring_stretch"] = change / properties.spring_stiffness
    return row


def assert_same(column, expected, tolerance=1e-10):
    """Raise unless two columns agree, nulls included; zeros within a share of the largest."""
    column = column.to_numpy(float)
    expected = expected.to_numpy(float)
    largest = np.nanmax(np.abs(expected), initial=1e-300)
    atol = 1e-3 * tolerance * largest
    np.testing.assert_allclose(column, expected, rtol=tolerance, atol=atol, equal_nan=True)


# --- Rows -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("run", "numbers", "motion"),
    [
        ("full", all_numbers, MOTION),
        ("solvable", all_numbers, FEW_MOTION),
        ("per_side", all_numbers_per_side, FEW_MOTION),
    ],
)
def test_states_are_those_of_a_plain_loop_over_the_product(request, run, numbers, motion):
    states = request.getfixturevalue(run).states
    rows = [one_state(design, *state) for design in numbers() for state in motion]
    expected = pd.DataFrame(rows)
    assert states["direction"].tolist() == expected["direction"].tolist()
    assert states["status"].tolist() == expected["status"].tolist()
    assert states["design"].tolist() == [row // len(motion) for row in range(len(expected))]
    for name in ["elbow_angle", *STATE_COLUMNS[3:]]:
        assert_same(states[name], expected[name])


def test_the_study_of_these_tests_has_every_status(full):
    assert set(full.states["status"]) == set(STATUS_NAMES)


@pytest.mark.parametrize(
    ("run", "numbers"), [("full", all_numbers), ("per_side", all_numbers_per_side)]
)
@pytest.mark.parametrize("table", ["designs", "states"])
def test_every_row_says_which_design_it_is(request, run, numbers, table):
    frame = request.getfixturevalue(run).table(table).read().to_pandas()
    rows = frame.drop_duplicates("design")
    designs = list(numbers())
    for key in ("spool.ratio", "load.mass", *OF_CASES_ALONE):
        expected = np.array([design[key] for design in designs])
        # "-60 deg" is read to the nearest number, which the radians of 60.0 miss by one.
        np.testing.assert_array_max_ulp(rows[key.replace(".", "_")].to_numpy(), expected, maxulp=1)
    sided = {
        "friction": "sheath.friction",
        "spring_stiffness": "spring.stiffness",
        "tendon_length": "tendon.length",
    }
    for column, key in sided.items():
        for side in SIDES:
            expected = [on_side(design, key, side) for design in designs]
            assert rows[f"{column}_{side}"].tolist() == expected
        assert rows[column].isna().all()
    cases = np.repeat(list(CASES), len(designs) // len(CASES))
    assert rows["case"].tolist() == cases.tolist()
    slack = ["unilateral" if design["unilateral"] else "bilateral" for design in designs]
    reference = ["initial" if design["from_initial"] else "published" for design in designs]
    assert rows["model_slack"].tolist() == slack
    assert rows["model_reference"].tolist() == reference


# --- Reductions -----------------------------------------------------------------------------------


def stiffness_of(states, side):
    """Return the column that holds a side's spring stiffness."""
    return states.get(f"spring_stiffness_{side}", states["spring_stiffness"])


def with_sign(values):
    """Return the value of largest magnitude."""
    if values.isna().all():
        return math.nan
    return values.loc[values.abs().idxmax()]


def reduced(states):
    """Reduce states to the columns of their designs, by pandas."""
    extensions = [states[f"{side}_tension_distal"] / stiffness_of(states, side) for side in SIDES]
    states = states.assign(
        extension=pd.concat(extensions, axis=1).max(axis=1),
        longest=states[SLACK_LENGTHS].max(axis=1),
        least_flexor=states[TENSIONS_OF_FLEXOR].min(axis=1),
        least_extensor=states[TENSIONS_OF_EXTENSOR].min(axis=1),
        most=states[TENSIONS].max(axis=1),
        taut=states["status"] == "taut",
        unstable=states["elbow_stiffness"] < 0.0,
    )
    loose = states[states["status"].isin(SLACK)]
    by = states.groupby("design")
    least_stiffness = by["elbow_stiffness"].min()
    return pd.DataFrame(
        {
            "min_flexor_tension": by["least_flexor"].min(),
            "min_extensor_tension": by["least_extensor"].min(),
            "max_tension": by["most"].max(),
            "max_spring_extension": by["extension"].max(),
            "peak_elbow_torque": by["elbow_torque"].agg(with_sign),
            "peak_motor_torque": by["motor_torque"].agg(with_sign),
            "min_elbow_stiffness": least_stiffness,
            "max_slack": by["longest"].max(),
            "slack_fraction": 1.0 - by["taut"].mean(),
            "unstable_fraction": by["unstable"].mean(),
            "first_slack_angle": loose.groupby("design")["elbow_angle"].min(),
            "taut": by["taut"].all(),
            "stable": least_stiffness.isna() | (least_stiffness >= 0.0),
            "feasible": by["taut"].all() & (least_stiffness >= 0.0),
        }
    )


@pytest.mark.parametrize("run", ["full", "solvable", "per_side"])
def test_designs_hold_what_pandas_finds_in_states(request, run):
    swept = request.getfixturevalue(run)
    expected = reduced(swept.states)
    assert set(expected) == set(DESIGN_COLUMNS) - TESTED_WITH_WINDOWS - TESTED_BY_BISECTION
    for column in expected:
        assert_same(swept.designs[column], expected[column])


def is_taut_at(numbers, pretension, motion):
    """Return True if no state is slack with this pretension on both sides."""
    design = design_of(numbers)
    flexor = replace(design.flexor, pretension=pretension)
    extensor = replace(design.extensor, pretension=pretension)
    design = replace(design, flexor=flexor, extensor=extensor)
    angles = np.array([angle for _, angle in motion])
    flexion = np.array([direction == "flexion" for direction, _ in motion])
    return not actuator.evaluate(design, angles, flexion).status.any()


def bisected(numbers, motion):
    """Return the smallest pretension without slack, by bisection."""
    if is_taut_at(numbers, 0.0, motion):
        return 0.0
    low = 0.0
    high = 1e5
    while high - low > 1e-7:
        middle = 0.5 * (low + high)
        if is_taut_at(numbers, middle, motion):
            high = middle
        else:
            low = middle
    return high


@pytest.mark.parametrize(
    ("run", "numbers"), [("solvable", all_numbers), ("per_side", all_numbers_per_side)]
)
def test_the_required_pretension_is_where_bisection_finds_it(request, run, numbers):
    required = request.getfixturevalue(run).designs["required_pretension"]
    expected = [bisected(design, FEW_MOTION) for design in numbers()]
    np.testing.assert_allclose(required, expected, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("run", ["solvable", "per_side"])
def test_a_design_is_taut_where_its_margin_is_not_negative(request, run):
    designs = request.getfixturevalue(run).designs
    if run == "solvable":
        margin = designs["pretension"] - designs["required_pretension"]
        assert_same(designs["margin"], margin, 1e-12)
    assert (designs["taut"] == (designs["margin"] >= 0.0)).all()
    assert (designs["first_slack_angle"].isna() == designs["taut"]).all()
    assert 0 < designs["taut"].sum() < len(designs)


def test_the_margin_is_what_both_sides_can_lose_before_a_state_goes_slack(per_side):
    designs = per_side.designs
    checked = set()
    rows = zip(all_numbers_per_side(), designs["case"], designs["margin"], strict=True)
    for numbers, case, margin in rows:
        pretensions = {
            f"tendon.{side}.pretension": on_side(numbers, "tendon.pretension", side)
            for side in SIDES
        }
        stays_positive = margin < min(pretensions.values()) - 1e-3
        if not stays_positive:
            continue
        for more in (-1e-6, 1e-6):
            lowered = {key: value - margin - more for key, value in pretensions.items()}
            design = design_of(numbers | lowered)
            statuses = [
                actuator.evaluate(design, float(angle), direction == "flexion").status
                for direction, angle in FEW_MOTION
            ]
            assert any(statuses) == (more > 0)
        checked.add(case)
    assert "rough extensor" in checked


def test_run_json_counts_what_the_tables_hold(full):
    states = full.states
    designs = full.designs
    record = full.record
    assert record["designs"] == len(designs)
    assert record["states"] == len(states)
    for name in ("taut", "stable", "feasible"):
        assert record[name] == designs[name].sum()
    assert record["slack"] == states["status"].isin(SLACK).sum()
    assert record["no_equilibrium"] == (states["status"] == "no equilibrium").sum()
    assert record["unstable"] == (states["elbow_stiffness"] < 0.0).sum()


# --- Nulls ----------------------------------------------------------------------------------------


def test_only_what_has_no_meaning_is_null(full):
    """Results are null without equilibrium, and lengths of slack if tendons can push.

    If both sides are slack, lengths of slack and the spool's angle are null.
    """
    states = full.states
    no_equilibrium = states["status"] == "no equilibrium"
    bilateral = states["case"] == "bilateral"
    both_slack = (states["status"] == "both slack") & ~bilateral
    for rows in (no_equilibrium, bilateral, both_slack):
        assert rows.any()
    expected = pd.DataFrame(False, index=states.index, columns=STATE_COLUMNS)
    expected.loc[no_equilibrium, RESULTS] = True
    expected.loc[bilateral, SLACK_LENGTHS] = True
    expected.loc[both_slack, [*SLACK_LENGTHS, "spool_angle"]] = True
    pd.testing.assert_frame_equal(states[STATE_COLUMNS].isna(), expected)
    assert ((states["flexor_moment_arm"] <= 0.0) == no_equilibrium).all()
    assert full.designs.loc[full.designs["case"] == "bilateral", "max_slack"].isna().all()


def test_status_follows_the_signs_of_tensions_that_may_push_and_others_are_never_negative(full):
    states = full.states
    has_equilibrium = states["status"] != "no equilibrium"
    bilateral = states[(states["case"] == "bilateral") & has_equilibrium]
    for side in SIDES:
        is_slack = bilateral["status"].isin([f"{side} slack", "both slack"])
        assert ((bilateral[f"{side}_tension_distal"] < 0) == is_slack).all()
    tensions = states.loc[states["case"] != "bilateral", TENSIONS]
    assert tensions.min(axis=None) >= -1e-9 * tensions.max(axis=None)


def test_required_pretension_and_margin_are_null_where_a_state_has_no_equilibrium(full):
    designs = full.designs
    assert designs[["required_pretension", "margin"]].isna().all(axis=None)
    assert not designs["feasible"].any()
    assert (designs["slack_fraction"] > 0.0).all()


def test_a_design_without_any_equilibrium_has_no_results_but_its_shares(new_sweep, tmp_path):
    text = '[load]\nmass = [0.0, 3.0]\n[motion]\nelbow_angle = ["165 deg", "170 deg"]\n'
    designs = new_sweep(text, tmp_path).designs
    never_null = {
        "slack_fraction",
        "unstable_fraction",
        "min_spool_to_tendon",
        "taut",
        "stable",
        "feasible",
    }
    results = [name for name in DESIGN_COLUMNS if name not in never_null]
    assert designs[results].isna().all(axis=None)
    assert designs["slack_fraction"].tolist() == [1.0, 1.0]
    assert designs["unstable_fraction"].tolist() == [0.0, 0.0]
    assert not designs[["taut", "feasible"]].any(axis=None)


# --- Columns, units, metadata ---------------------------------------------------------------------


def test_the_tables_of_the_smallest_study_have_the_published_columns_in_order(new_sweep, tmp_path):
    swept = new_sweep("", tmp_path)
    assert list(swept.designs) == LEADING + DESIGN_COLUMNS
    assert list(swept.states) == LEADING + STATE_COLUMNS


def test_other_axes_and_sides_follow_the_six_columns_that_are_always_there(per_side):
    columns = list(per_side.designs)
    leading = columns[: columns.index("min_flexor_tension")]
    assert [name for name in leading if name in LEADING] == LEADING
    further = {"tendon_diameter", "tendon_length", "case", "model_slack", "model_reference"}
    further |= {"arm_b1", "arm_forearm_mass", "arm_upper_arm_angle", "spool_flexor_radius"}
    for name in ("tendon_length", "pretension", "friction", "spring_stiffness"):
        further |= {f"{name}_flexor", f"{name}_extensor"}
    assert set(leading) - set(LEADING) == further
    assert list(per_side.states)[: len(leading)] == leading
    assert columns[len(leading) :] == DESIGN_COLUMNS
    assert list(per_side.states)[len(leading) :] == STATE_COLUMNS


def test_an_axis_of_one_side_alone_is_a_column_of_both_sides(new_sweep, tmp_path):
    text = '[tendon]\npretension = "90 N"\n[tendon.extensor]\npretension = ["70 N", "80 N"]\n'
    designs = new_sweep(text, tmp_path).designs
    assert designs["pretension"].isna().all()
    assert designs["pretension_flexor"].tolist() == [90.0, 90.0]
    assert designs["pretension_extensor"].tolist() == [70.0, 80.0]


@pytest.mark.parametrize("table", ["designs", "states"])
def test_fields_have_their_types_and_with_pandas_attributes_the_units(full, table):
    file = full.folder / f"{table}.parquet"
    schema = pq.read_schema(file)
    frame = pd.read_parquet(file)
    units = frame.attrs["units"]
    types = {
        "design": pa.int64(),
        "taut": pa.bool_(),
        "stable": pa.bool_(),
        "feasible": pa.bool_(),
    }
    assert set(units) == set(schema.names)
    for field in schema:
        unit = field.metadata[b"unit"].decode()
        long_name = field.metadata[b"long_name"].decode()
        quantity = QUANTITIES.get(field.metadata[b"quantity"].decode())
        assert unit == units[field.name]
        if field.name in ("case", "direction", "status", "model_slack", "model_reference"):
            assert isinstance(frame[field.name].dtype, pd.CategoricalDtype)
        else:
            assert field.type == types.get(field.name, pa.float64())
        assert (quantity is None) == (not pa.types.is_floating(field.type))
        assert long_name.strip()
        if quantity:
            without_side = field.name.removesuffix("_flexor").removesuffix("_extensor")
            assert without_side.endswith(quantity.name)
            assert long_name == quantity.long_name
            assert unit == quantity.unit


@pytest.mark.parametrize("table", ["designs", "states"])
def test_a_table_records_its_study_its_hash_and_its_versions(full, table):
    metadata = pq.read_schema(full.folder / f"{table}.parquet").metadata
    texts = [value.decode() for value in metadata.values()]
    assert any(full.plan.study.hash in text for text in texts)
    facts = full.table(table).facts
    assert facts["study"]["study"] == json.loads(json.dumps(full.plan.study.document()))
    assert {"tendon", "numpy", "pyarrow"} <= set(facts["versions"])
    assert facts["table"] == table


def test_only_the_tables_asked_for_are_written(new_sweep, tmp_path):
    swept = new_sweep('[output]\ntables = "designs"\n', tmp_path)
    assert sorted(swept.hashes) == ["designs.parquet"]
    assert [entry["path"] for entry in swept.record["files"]] == ["designs.parquet"]
