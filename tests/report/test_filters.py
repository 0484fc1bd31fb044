"""A filter means the same in a terminal, in a CSV file, in a figure and on a page."""

import csv

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.cube.cube import cube_of
from tendon_cli.cube.rows import export, rows_in
from tendon_cli.errors import UsageError
from tendon_cli.reports.report import write_report

MOTION = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}}


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    """Return the folder of a run whose axes have close, huge, infinite and endless values."""
    folder = tmp_path_factory.mktemp("filters") / "run"
    study = {
        "allow_implausible": True,  # a spring of 1e12 N/m
        "cases": [
            {"name": "child, 7", "arm": {"b1": "88 mm"}, "spring": {"at": "motor"}},
            {"name": "b; adult"},
        ],
        "tendon": {"pretension": {"from": "0 N", "to": "100 N", "num": 4}},
        "spring": {"stiffness": ["3 kN/m", "4 kN/m", "5 kN/m", "1e12 N/m", "rigid"]},
        "load": {"mass": ["0 kg", "4.9996 kg", "5 kg", "5.004 kg", "10 kg"]},
        "motion": MOTION,
    }
    tendon.sweep(study, folder)
    return folder


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """Return the folder of a run of more than 50,000 designs."""
    folder = tmp_path_factory.mktemp("many") / "run"
    study = {
        "tendon": {"pretension": {"from": "20 N", "to": "300 N", "num": 41}},
        "spring": {"stiffness": {"from": "1 kN/m", "to": "9 kN/m", "num": 50}},
        "load": {"mass": {"from": "0 kg", "to": "10 kg", "num": 25}},
        "motion": {"elbow_angle": ["0 deg", "90 deg"]},
    }
    tendon.sweep(study, folder)
    return folder


def single(values, unit=1.0):
    """Return values in a unit, in single precision."""
    return (values.to_numpy() / unit).astype(np.float32)


TRUTHS = {
    "spring_stiffness < 3.5 kN/m": lambda t: t.spring_stiffness == 3e3,
    "spring_stiffness >= 4.5 kN/m": lambda t: t.spring_stiffness >= 5e3,
    "spring_stiffness = 1e12 N/m": lambda t: t.spring_stiffness == 1e12,
    "spring_stiffness = rigid": lambda t: t.spring_stiffness == np.inf,
    "spring_stiffness != rigid": lambda t: t.spring_stiffness < np.inf,
    "spring_stiffness > 1e12 N/m": lambda t: t.spring_stiffness == np.inf,
    "spring_stiffness in 3 N/mm, rigid": lambda t: t.spring_stiffness.isin([3e3, np.inf]),
    "load_mass = 5 kg": lambda t: t.load_mass == 5.0,
    "load_mass == 5000 g": lambda t: t.load_mass == 5.0,
    "load.mass != 5 kg": lambda t: t.load_mass != 5.0,
    "load_mass = 5.004 kg": lambda t: t.load_mass == 5.004,
    "load_mass = 5.00 kg": lambda t: t.load_mass == 5.0,
    "load_mass = 4 kg": lambda t: t.load_mass == 4.0,
    "load_mass != 4 kg": lambda t: t.load_mass >= 0.0,
    "load_mass < 5 kg": lambda t: t.load_mass < 5.0,
    "load_mass <= 5 kg": lambda t: t.load_mass <= 5.0,
    "load_mass > 0 kg": lambda t: t.load_mass > 0.0,
    "load_mass in [0 kg, 5 kg]": lambda t: t.load_mass.isin([0.0, 5.0]),
    "pretension = 33.33 N": lambda t: t.pretension.between(33.0, 34.0),
    "pretension < 33.33 N": lambda t: t.pretension == 0.0,
    "pretension <= 0.033333 kN": lambda t: t.pretension < 34.0,
    "pretension = 33 N": lambda t: t.pretension < 0.0,
    "pretension > 33 N": lambda t: t.pretension > 33.0,
    "arm.b1 = 88 mm": lambda t: t.case == "child, 7",
    "arm_b1 > 88 mm": lambda t: t.case == "b; adult",
    "spring_at = motor": lambda t: t.case == "child, 7",
    "friction = 0.07": lambda t: t.load_mass >= 0.0,
    'case = "child, 7"': lambda t: t.case == "child, 7",
    'case in "child, 7", "b; adult"': lambda t: t.case != "",
    'case != "child, 7"': lambda t: t.case == "b; adult",
    "max_tension <= 300 N": lambda t: single(t.max_tension) <= np.float32(300.0),
    "max_tension > 0.3 kN": lambda t: single(t.max_tension) > np.float32(300.0),
    "margin != 0 N": lambda t: t.margin.notna() & (t.margin != 0.0),
    "margin < -12.5 N": lambda t: single(t.margin) < np.float32(-12.5),
    "feasible = yes": lambda t: t.feasible,
    "taut != true": lambda t: ~t.taut,
    "stable = 0": lambda t: ~t.stable,
}
"""Filters, with the rows of a table that they leave."""
REFUSED = [
    "load_mass = 4",
    "load_mass = 4 N",
    "load_mass = 1,5 kg",
    "load_mass = constructor",
    "load_mass = 4 constructor",
    "load mass = 4 kg",
    "feasible",
    "feasible = constructor",
    "feasible > no",
    "case > b",
    "spring_at = foot",
    "spring_at < motor",
    "case = child",
    "max = 3",
    "constructor = 3",
    "Load_Mass = 5 kg",
    "load_mass in ,",
]


def shown(run, filters):
    """Return the rows that `show` selects, True or False for each row of the table."""
    return kept(run, list(rows_in(run, where=filters).head(10**6)[0].to_pylist()))


def kept(run, selected):
    """Return True for each row of the designs that is among some rows, known by their axes."""
    names = [axis.column for axis in cube_of(tendon.open(run).kept("designs")).axes]
    designs = rows_in(run).head(10**6)[0].select(names).to_pylist()
    found = {tuple(row[name] for name in names) for row in selected}
    return [tuple(row.values()) in found for row in designs]


def exported(run, filters, folder):
    """Return the number of rows that `export` writes, as the file has them."""
    count = export(rows_in(run, where=filters), folder / "rows.csv")
    with (folder / "rows.csv").open(newline="") as file:
        assert len(list(csv.reader(file))) == count + 1
    return count


def drawn(cube, filters):
    """Return the rows of the table that a figure draws, True or False for each."""
    conditions = cube.conditions(filters)
    is_drawn = np.zeros(cube.table.rows, dtype=bool)
    try:
        positions = cube.choose(conditions)
    except UsageError:  # it leaves nothing of an axis
        return is_drawn
    rows = cube.rows(list(positions), positions).ravel()
    values = cube.gather(rows, [condition.column for condition in conditions])
    is_kept = np.ones(rows.shape, dtype=bool)
    for condition in conditions:
        is_kept &= condition.holds(values[condition.column])
    is_drawn[rows[is_kept]] = True
    return is_drawn


@pytest.mark.parametrize("text", TRUTHS)
def test_a_filter_leaves_the_rows_that_it_means(compared, tmp_path, text):
    designs = tendon.open(compared).designs
    expected = np.asarray(TRUTHS[text](designs))
    np.testing.assert_array_equal(shown(compared, [text]), expected)
    assert exported(compared, [text], tmp_path) == expected.sum()
    cube = cube_of(tendon.open(compared).kept("designs"))
    np.testing.assert_array_equal(drawn(cube, [text]), expected)


@pytest.mark.parametrize("text", REFUSED)
def test_a_text_that_is_no_filter_is_refused_everywhere(compared, tmp_path, text):
    cube = cube_of(tendon.open(compared).kept("designs"))
    with pytest.raises(UsageError):
        shown(compared, [text])
    with pytest.raises(UsageError):
        exported(compared, [text], tmp_path)
    with pytest.raises(UsageError):
        drawn(cube, [text])


PASSED = "Array.from({ length: page.table.rows }, (_, row) => rowsOfTable().includes(row))"


def test_a_page_takes_the_same_filters_and_leaves_the_same_rows(opened, compared):
    designs = tendon.open(compared).designs
    with opened(write_report(compared)) as page:
        for text, truth in TRUTHS.items():
            page.locator("#filter").fill(text)
            assert page.locator("#filter-fault").inner_text() == "", text
            np.testing.assert_array_equal(page.evaluate(PASSED), truth(designs), err_msg=text)
        for text in REFUSED:
            page.locator("#filter").fill(text)
            assert page.locator("#filter-fault").inner_text() != "", text
        page.locator("#filter").fill('case = "b; adult"; load_mass = 5 kg')
        assert page.evaluate("rowsOfTable().length") == len(designs) / 10


def test_a_page_of_many_rows_counts_them_exactly(opened, many):
    designs = tendon.open(many).designs
    bounds = designs[["margin", "max_tension"]].quantile(np.linspace(0.05, 0.95, 8))
    filters = [f"{name} >= {value:.8g} N" for name in bounds for value in bounds[name]]
    with opened(write_report(many)) as page:
        assert page.evaluate("page.table.rows") == len(designs) > 50_000
        for text in filters:
            page.locator("#filter").fill(text)
            _, count = rows_in(many, where=[text]).head(0)
            assert page.evaluate("rowsOfTable().length") == count, text


def test_numbers_that_all_rows_share_are_filtered_on_a_page_too(opened, tmp_path):
    study = {"spring": {"stiffness": "rigid"}, "load": {"mass": ["0 kg", "5 kg"]}, "motion": MOTION}
    tendon.sweep(study, tmp_path / "run")
    counts = {"spring_stiffness = rigid": 2, "spring.stiffness < 5 kN/m": 0, "friction > 0.07": 0}
    with opened(write_report(tmp_path / "run")) as page:
        for text, count in counts.items():
            page.locator("#filter").fill(text)
            assert page.locator("#filter-fault").inner_text() == "", text
            assert page.evaluate("rowsOfTable().length") == count, text
            assert rows_in(tmp_path / "run", where=[text]).head(0)[1] == count


def test_angles_close_to_each_other_are_told_apart(tmp_path):
    angles = {"from": "0 deg", "to": "90 deg", "num": 1001}
    tendon.sweep({"motion": {"elbow_angle": angles}}, tmp_path / "run")
    _, count = rows_in(tmp_path / "run", "states", ["elbow_angle = 90 deg"]).head(0)
    assert count == 2  # in both directions
