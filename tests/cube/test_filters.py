"""A filter is a statement on one row: it divides rows, and no other row changes it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tendon_cli as tendon
from tendon_cli.cube.columns import TableColumns
from tendon_cli.cube.cube import axis_values_of
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.filters import read_filter

FORCE = QUANTITIES["max_tension"]
CLOSE = st.sampled_from([0.0, 4.9996, 5.0, 5.0001, 5.004, 33.33, 100 / 3, -5.0, 1e12, np.inf])
NUMBERS = st.one_of(CLOSE, st.floats(-1e3, 1e3), st.just(np.nan))
COLUMNS = st.lists(NUMBERS, min_size=1, max_size=30).map(np.array)
TYPED = st.one_of(
    st.sampled_from(["0 N", "5 N", "5.00 N", "33.33 N", "0.005 kN", "1e12 N", "-5 N"]),
    st.floats(-1e3, 1e3).map(lambda value: f"{value:.4g} N"),
    st.floats(-1e3, 1e3).map(lambda value: f"{value!r} N"),
)
AXES = st.one_of(st.none(), COLUMNS.map(lambda values: values[~np.isnan(values)]))


def holds(relation, typed, values, axis_values):
    """Return where a filter on a column of forces holds."""
    condition = read_filter(f"max_tension {relation} {typed}").condition_on(
        "max_tension", FORCE, axis_values
    )
    return condition.holds(values)


@given(COLUMNS, TYPED, AXES)
def test_less_equal_and_more_divide_all_rows_that_have_a_value(values, typed, axis_values):
    counts = sum(holds(sign, typed, values, axis_values).astype(int) for sign in "<=>")
    np.testing.assert_array_equal(counts, ~np.isnan(values))


@given(COLUMNS, TYPED, AXES)
def test_a_relation_and_its_opposite_complement_each_other(values, typed, axis_values):
    for sign, opposite in {"=": "!=", "<": ">=", ">": "<="}.items():
        kept = holds(sign, typed, values, axis_values)
        left = holds(opposite, typed, values, axis_values)
        np.testing.assert_array_equal(kept ^ left, ~np.isnan(values))


@given(COLUMNS, COLUMNS, TYPED, AXES, st.sampled_from(["=", "!=", "<", "<=", ">", ">="]))
def test_no_other_row_and_no_order_changes_a_row(values, others, typed, axis_values, sign):
    alone = holds(sign, typed, values, axis_values)
    beside = holds(sign, typed, np.concatenate([values, others])[::-1], axis_values)[::-1]
    np.testing.assert_array_equal(beside[: len(values)], alone)


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30), st.data())
def test_a_value_of_an_axis_written_in_full_is_that_value_alone(numbers, data):
    axis_values = np.array(numbers)
    value = data.draw(st.sampled_from(numbers))
    is_equal = holds("=", f"{value!r} N", axis_values, axis_values)
    np.testing.assert_array_equal(is_equal, axis_values == value)


@given(st.lists(st.integers(-(10**6), 10**6), min_size=1, max_size=30, unique=True), st.data())
def test_a_value_of_an_axis_as_figures_print_it_is_that_value(thirds, data):
    axis_values = np.array(thirds) / 3.0
    value = data.draw(st.sampled_from(axis_values.tolist()))
    printed = f"{value:.4g}"
    has_one_meaning = sum(f"{other:.4g}" == printed for other in axis_values) == 1
    is_equal = holds("=", f"{printed} N", axis_values, axis_values)
    if has_one_meaning:
        np.testing.assert_array_equal(is_equal, axis_values == value)
    else:
        assert not is_equal[axis_values != float(printed)].any()


STUDIES = {
    "persons": {"people": {"count": 5}},
    "cases": {"cases": [{"name": "short", "arm": {"b1": "88 mm"}}, {"name": "paper"}]},
    "draws": {"arm": {"b1": {"value": "150 mm", "tolerance": "5 %"}}, "uncertainty": {"draws": 4}},
}


@pytest.fixture(scope="module", params=STUDIES)
def results(request, tmp_path_factory):
    """Return the run and the answer of a study."""
    content = STUDIES[request.param] | {
        "spring": {"stiffness": {"from": "3 kN/m", "to": "5 kN/m", "num": 4}},
        "load": {"mass": ["0 kg", "5 kg"]},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    }
    folder = tmp_path_factory.mktemp("filtered")
    study = tendon.study(content)
    return tendon.sweep(study, folder / "run"), tendon.design(study, folder / "answer")


@pytest.mark.parametrize("table", ["designs", "states", "choices", "conditions"])
def test_the_values_that_a_filter_may_mean_are_those_of_the_table(results, table):
    run, answer = results
    is_answer = table in ("choices", "conditions")
    kept = (answer if is_answer else run).kept(table)
    axis_values = axis_values_of(kept)
    columns = kept.read().to_pandas()
    common = [column for column in axis_values if column in columns]
    assert common
    for column in common:
        assert set(columns[column].dropna()) <= set(axis_values[column].tolist()), column


def test_columns_of_the_motion_are_called_by_their_keys_too(results):
    run, _ = results
    columns = TableColumns.of(run.kept("states").schema)
    for name in ("elbow_angle", "direction"):
        assert columns.find(f"motion.{name}", "--where") == columns.find(name, "--where") == name
