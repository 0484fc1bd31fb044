"""The reader of tables by itself: every way to write one, hostile files, times and encoders."""

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

from tendon_cli.errors import InputError, UsageError
from tendon_cli.readers.file_text import MOST_FAULTS
from tendon_cli.readers.heading import Heading
from tendon_cli.readers.table import read_table

from .files import Written, good, hostile

ROWS = [["0.0", "-8.53", "90"], ["0.5", "8.9", "45"], ["1.0", "9.26", "30"], ["1.5", "9.65", "0"]]
TABLE = Written(["time", "force", "elbow angle"], ["s", "N", "deg"], ROWS)
GOOD = good(TABLE)
HOSTILE = hostile(TABLE, 1)
NUMBERS = np.array([[float(cell) for cell in row] for row in ROWS]).T


def known(columns):
    return [column for column in columns if column.words & {"time", "force", "elbow"}]


def read(given, **options):
    given = given.encode() if isinstance(given, str) else given
    return read_table(given, known, source="log.csv", **options)


def values(table):
    """Return time, force and angle in SI."""
    found = [table.named(name)[0] for name in ("time", "force", "elbow_angle")]
    numbers = [
        table.quantity(column, dimension)[0]
        for column, dimension in zip(found, ("time", "force", "angle"), strict=True)
    ]
    table.raise_faults()
    return np.array(numbers)


@pytest.mark.parametrize("way", GOOD)
def test_a_table_is_the_same_however_it_is_written(way):
    table = read(GOOD[way])
    assert np.array_equal(values(table), NUMBERS * [[1.0], [1.0], [np.pi / 180.0]])
    assert table.unread(table.columns[:3]) == []


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_refused_with_its_place(name):
    content, where, message = HOSTILE[name]
    with pytest.raises(InputError) as caught:
        values(read(content))
    assert message in caught.value.message
    assert (caught.value.where or "").startswith("log.csv")
    assert where in f"{caught.value.where}"
    assert all(len(line) < 400 for line in caught.value.message.splitlines())


def test_a_frame_is_read_as_a_file_is():
    columns = dict(zip(TABLE.headers, NUMBERS, strict=True))
    texts = {name: [f"{value}" for value in numbers] for name, numbers in columns.items()}
    for frame in (columns, pd.DataFrame(columns), pa.table(columns), pd.DataFrame(texts)):
        assert np.array_equal(
            values(read_table(frame, known)), values(read(TABLE.text())), equal_nan=True
        )
    for wrong in (7, {"a": [1, 2], "b": [1]}, {"a": [[1, 2], [3, 4]]}):
        with pytest.raises(UsageError, match="mapping of arrays"):
            read_table(wrong, known)
    with pytest.raises(InputError, match="0 rows"):
        read_table({"force (N)": []}, known)


def test_a_name_that_stands_twice_is_refused_with_both_places():
    twice = pd.DataFrame([[1.0, 2.0]], columns=["force (N)", "force (N)"])
    for read_twice in (
        lambda: read_table(twice, known),
        lambda: read("force (N),force (N)\n1,2\n"),
    ):
        with pytest.raises(InputError, match="stands twice, in columns 1 and 2"):
            read_twice()
    table = read("force (N),force (kN)\n1,2\n")
    with pytest.raises(InputError, match="two columns give the force") as caught:
        table.only(table.named("force"), "force")
    assert "(column 1)" in caught.value.message
    assert "(column 2)" in caught.value.message


HEADERS = {
    "cell_1_kg": ("cell_1", "kg"),
    "Force [N]": ("Force", "N"),
    "Kraft / N": ("Kraft", "N"),
    "force in kilograms": ("force", "kg"),
    "motor_torque_N_m": ("motor_torque", "N m"),
    "torque (mNm)": ("torque", "mNm"),
    "speed rad/s": ("speed", "rad/s"),
    "x": ("x", ""),
    "price (EUR)": ("price", "EUR"),
    "force (flexor) (N)": ("force (flexor)", "N"),
    "cell A": ("cell A", ""),
    "motor current A": ("motor current", "A"),
    "force in": ("force in", ""),
    "tension_min": ("tension_min", ""),
    "time_min": ("time", "min"),
    "cell (1)": ("cell", "1"),
    "Load cell \u2161": ("Load cell II", ""),
    "t / \u00b5s": ("t", "us"),
}
"""Name and unit of a header."""


def test_names_and_units_of_headers():
    found = {header: Heading.of(0, header) for header in HEADERS}
    assert {header: (one.name, one.unit) for header, one in found.items()} == HEADERS


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("force", "the column force has no unit"),
        ("force (foo)", 'force: unknown unit "foo"'),
        ("force_foo", 'force: unknown unit "foo"'),
        ("force (mm)", 'force: "mm" is a length'),
        ("force (MN)", 'force: unknown unit "MN"'),
    ],
)
def test_an_unknown_unit_is_called_so(header, message):
    table = read(f"time (s),{header}\n0,1\n1,2\n")
    table.quantity(table.named("force")[0], "force")
    with pytest.raises(InputError, match=message) as caught:
        table.raise_faults()
    assert caught.value.where == "log.csv, line 1, column 2"


def test_every_fault_is_told_in_the_order_of_the_lines():
    table = read("time (s),force (N)\n0,x\ny,1\n20,z\n30\n")
    for name in ("force", "time"):
        table.numbers(table.named(name)[0])
    with pytest.raises(InputError) as caught:
        table.raise_faults()
    lines = [part.split(",")[0].strip(" :") for part in caught.value.message.splitlines()[1:]]
    assert [line.split(":")[0] for line in lines] == ["line 2", "line 3", "line 4", "line 5"]


def test_of_many_faults_the_first_are_told_and_the_others_counted():
    table = read("time (s),force (N)\n" + "0,x\n" * 1000)
    table.numbers(table.named("force")[0])
    with pytest.raises(InputError) as caught:
        table.raise_faults()
    assert len(caught.value.message.splitlines()) == MOST_FAULTS + 2
    assert f"and {1000 - MOST_FAULTS} more" in caught.value.message


def test_cells_without_a_number_are_nan_where_they_may_be():
    table = read("time (s),force (N)\n0,\n1,NaN\n2,-\n3,1.5\n")
    force = table.named("force")[0]
    assert np.isnan(table.numbers(force, may_lack=True)).tolist() == [True] * 3 + [False]
    table.raise_faults()
    table.numbers(force)
    with pytest.raises(InputError, match="3 faults"):
        table.raise_faults()


def test_a_column_by_its_header_or_its_number():
    table = read("time (s),force (N),3,arm (mm),arm (cm)\n0,1,2,3,4\n")
    for given in ("Force (n)", "force"):
        assert table.called(given, "--cell-1").index == 1
    assert table.called("arm (cm)", "--cell-1").index == 4
    assert table.called("2", "--cell-1").index == 1
    assert table.called("3", "--cell-1").index == 2
    for given in ("6", "0", "load", "arm"):
        with pytest.raises(UsageError, match="no column") as caught:
            table.called(given, "--cell-1")
        assert caught.value.where == "--cell-1"
    numbered = read_table(b"0,1,2\n1,1.5,2.5\n", lambda columns: columns[2:3], source="bare.csv")
    assert len(numbered) == 1  # its first line is taken for the header that it may be
    bare = read_table(
        b"0,1,2\n1,1.5,2.5\n",
        lambda columns: columns[2:3] if columns[0].header == "column 1" else [],
        source="bare.csv",
    )
    assert bare.numbers(bare.columns[2]).tolist() == [2.0, 2.5]


def test_more_rows_than_there_may_be_are_refused_before_cells_are_read():
    with pytest.raises(InputError, match="more than 2 persons") as caught:
        read("time (s),force (N)\n0,x\n1,x\n2,x\n", noun="person", most_rows=2)
    assert caught.value.where == "log.csv, line 4"


def test_opensim_says_the_unit_of_its_angles():
    head = "Coordinates\nversion=1\nnRows=2\nnColumns=3\ninDegrees={}\n\nendheader\n"
    rows = "time\tarm_flex_r\telbow_flex_r\n0.0\t1\t2\n0.1\t3\t4\n"
    for word, factor in (("yes", np.pi / 180.0), ("no", 1.0)):
        table = read(head.format(word) + rows)
        angle, _ = table.quantity(table.named("elbow_flex_r")[0], "angle")
        assert np.allclose(angle, np.array([2.0, 4.0]) * factor)


# --- Times and encoders ---------------------------------------------------------------------------


def clock_of(header, cells):
    """Return times, their unit and the notes of a table of one clock."""
    rows = "".join(f"{cell};1\n" for cell in cells)
    table = read(f"{header};force (N)\n{rows}")
    times, unit = table.times(table.columns[0])
    table.raise_faults()
    return times, unit, table.notes


CLOCKS = {
    "s": ("time (s)", ["0.0", "0.5", "1.0"], "s"),
    "us": ("time_us", ["0", "500000", "1000000"], "us"),
    "ns": ("t (ns)", ["0", "500000000", "1000000000"], "ns"),
    "millis": ("millis", ["0", "500", "1000"], "ms"),
    "no unit": ("time", ["0", "1", "2"], ""),
    "stamps": (
        "time",
        ["2026-03-02 14:00:00", "2026-03-02 14:00:00.5", "2026-03-02 14:00:01"],
        "s",
    ),
    "hours": ("time", ["13:59:59.5", "14:00:00.0", "14:00:00.5"], "s"),
    "midnight": ("time", ["23:59:59.5", "00:00:00.0", "00:00:00.5"], "s"),
    "minutes": ("time", ["00:59,5", "01:00,0", "01:00,5"], "s"),
    "rolling over": ("time_us", ["4294500000", "32704", "532704"], "us"),
}
SECONDS = {"": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


@pytest.mark.parametrize("name", CLOCKS)
def test_times(name):
    header, cells, unit = CLOCKS[name]
    times, found, notes = clock_of(header, cells)
    assert found == unit
    step = 1.0 if name == "no unit" else 0.5
    assert np.allclose(np.diff(times) * SECONDS[unit], step)
    assert bool(notes) == (name == "rolling over")
    assert not notes or "line 3" in notes[0]


def test_rows_that_share_a_time_lie_at_equal_steps():
    at = np.arange(20 * 17) / 17.0
    times, _, notes = clock_of("time (s)", [f"{value:.0f}" for value in np.floor(at)])
    assert np.allclose(np.diff(times), 1.0 / 17.0)
    assert "17 rows share each time" in notes[0]
    settled = np.repeat([0, 1, 5], [40, 3, 40])  # no clock is so uneven
    same, _, notes = clock_of("time (s)", map(str, settled))
    assert np.array_equal(same, settled)
    assert notes == []


@pytest.mark.parametrize("low", [0.0, -180.0])
def test_an_encoder_that_wraps_is_counted_on(low):
    true = 300.0 + 400.0 * np.sin(np.linspace(0.0, 6.0, 400))
    shown = (true - low) % 360.0 + low
    rows = "".join(f"{row},{angle:.6f}\n" for row, angle in enumerate(shown))
    table = read(f"time (s),elbow angle (deg)\n{rows}")
    angle = table.named("elbow_angle")[0]
    whole = np.degrees(table.unwrapped(angle, table.quantity(angle, "angle")[0], 2.0 * np.pi))
    assert np.allclose(whole - whole[0], true - true[0], atol=1e-5)
    assert "starts again after one turn" in table.notes[0]
    steady = np.radians(np.linspace(0.0, 350.0, 400))
    assert np.array_equal(table.unwrapped(angle, steady, 2.0 * np.pi), steady)
    assert len(table.notes) == 1
