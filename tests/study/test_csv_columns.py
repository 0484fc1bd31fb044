"""CSVs beside a study: all faults of a file at once, a note on what is not read, other kinds."""

import numpy as np
import pytest

from tendon_cli.cells import MOST_FAULTS, lines_of
from tendon_cli.errors import InputError, StudyError
from tendon_cli.studies.csv_columns import read_columns
from tendon_cli.studies.load import any_study, load_study
from tendon_cli.studies.people.persons_csv import read_persons

CURVE = {"angle": "angle", "torque": "torque"}


def read(text):
    return read_columns(text.encode(), "joint.csv", CURVE, "angle")


def test_every_fault_of_the_numbers_is_told_with_its_line():
    with pytest.raises(InputError) as raised:
        read("angle (deg),torque (N m)\n0,x\n10,1\ny,2\n30,1e99\n")
    for place in ("line 2: torque", "line 4: angle", "line 5: torque"):
        assert place in raised.value.message
    assert "3 faults" in raised.value.message


def test_every_row_of_another_length_is_told():
    with pytest.raises(InputError) as raised:
        read("angle (deg),torque (N m)\n0\n10,1\n20,2,3\n")
    assert "line 2: 1 cell" in raised.value.message
    assert "line 4: 3 cells" in raised.value.message


def test_a_file_full_of_faults_lists_the_first_and_counts_the_others():
    rows = "\n".join("0,x" for _ in range(1000))
    with pytest.raises(InputError) as raised:
        read(f"angle (deg),torque (N m)\n{rows}\n")
    assert len(raised.value.message.splitlines()) == MOST_FAULTS + 2
    assert f"and {1000 - MOST_FAULTS} more" in raised.value.message


def test_one_fault_alone_is_told_as_before():
    with pytest.raises(InputError, match='torque is "x", expected a number') as raised:
        read("angle (deg),torque (N m)\n0,x\n10,1\n")
    assert raised.value.where == "joint.csv, line 2"


def test_every_fault_of_persons_is_told():
    with pytest.raises(InputError) as raised:
        read_persons(b"weight (kg),stature (cm),sex\n70,x,m\n-7,180,q\n", "people.csv")
    for words in ('stature is "x"', "weight is -7 kg"):
        assert words in raised.value.message


FAULTY_FILES = {
    "people.file": (
        "name,weight (kg),stature (mm),sex,weighting",
        "A,70,1750,male,1",
        ("B,7000,1750,male,1", "weight of 7000 kg is far"),
        ("C,70,17,male,1", "stature of 17 mm is far"),
        ("D,70,1750,foo,1", 'sex is "foo"'),
        ("E,70,1750,fem,1", 'sex is "fem"'),
        ("F,-3,1750,male,1", "weight is -3 kg"),
        ("G,0,1750,male,1", "weight is 0 kg"),
        ("A,70,1750,male,1", '"A" is the name of two persons'),
        ("H,,,male,1", "without any dimension"),
        ("I,70", "2 cells where the header has 5"),
    ),
    "joint.torque": (
        "angle (deg),torque (N m)",
        "0,1",
        ("10,x", 'torque is "x"'),
        ("20", "1 cell where the header has 2"),
        ("30,1e99", "torque is 1e+99"),
        ("40,9000", "torque of 9000 N m is far"),
        ("35,1", "go back and forth"),
        ("y,1", 'angle is "y"'),
        ('60,"1', "not a row of CSV"),
        ("40,1", "the same angle twice"),
        ("140,1", None),
    ),
    "sheath.path": (
        "x (mm),y (mm),z (mm)",
        "0,0,0",
        ("1,a,0", 'y is "a"'),
        ("2,,0", 'y is ""'),
        ("3,1", "2 cells where the header has 3"),
        ("4,1,1e99", "z is 1e+99"),
    ),
    "table": (
        "name,spring.stiffness (kN/m),spool.ratio",
        "A,3,0.6",
        ("B,x,0.6", '"x" is not one number'),
        ("C,3", "2 cells where the header has 3"),
        ("A,3,0.6", '"A" is the name of two rows'),
        ("D,3,0", "0 is impossible"),
        ("E,90000,0.6", '"90000 kN/m" is far from any arm'),
    ),
}
"""Header, a good line, and lines at fault with words for each, by the key that names the file."""


def faults_of_file(folder, key, *lines):
    """Return the error of a study that names a file of these lines."""
    (folder / "file.csv").write_text("\n".join(lines) + "\n")
    table, _, name = key.partition(".")
    content = {table: {name: "file.csv"}}
    if key == "table":
        content = {"table": [{"name": "part", "file": "file.csv"}]}
    with pytest.raises((InputError, StudyError)) as raised:
        any_study(content)
    return str(raised.value)


@pytest.mark.parametrize("key", FAULTY_FILES)
def test_all_faults_of_any_file_are_told_at_once(key, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    header, good, *faulty = FAULTY_FILES[key]
    text = faults_of_file(tmp_path, key, header, good, *(line for line, _ in faulty))
    for number, (line, words) in enumerate(faulty, start=3):
        told = [part for part in text.splitlines() if f"line {number}" in part]
        assert words is None or any(words in part for part in told), line


@pytest.mark.parametrize("key", FAULTY_FILES)
def test_a_row_of_another_length_hides_no_other_fault(key, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    header, good, *faulty = FAULTY_FILES[key]
    needs_another_row = ("forth", "twice")
    for line, words in faulty:
        if words is None or any(word in words for word in needs_another_row):
            continue
        text = faults_of_file(tmp_path, key, header, good, good + ",1,2,3", line)
        assert words in text
        assert "line 3" in text


def test_faults_are_listed_in_the_order_of_their_lines():
    with pytest.raises(InputError) as raised:
        read("angle (deg),torque (N m)\n0,x\ny,1\n20,z\n30\n")
    lines = [part.split(":")[0].strip() for part in raised.value.message.splitlines()[1:]]
    assert lines == ["line 2", "line 3", "line 4", "line 5"]


def test_values_that_a_study_accepts_are_no_faults_beside_others():
    content = b"weight (kg),sex\n7000,m\n70,q\n"
    with pytest.raises(InputError, match='sex is "q"') as raised:
        read_persons(content, "people.csv", accepts_slips=True)
    assert "7000" not in raised.value.message
    with pytest.raises(InputError, match="7000"):
        read_persons(content, "people.csv", accepts_slips=False)


def test_a_faulty_header_hides_no_faults_of_cells():
    with pytest.raises(InputError) as raised:
        read_persons(b"wieght (kg),stature (cm),sex\n70,175,q\n70,x,m\n", "people.csv")
    for words in ("wieght", 'sex is "q"', 'stature is "x"'):
        assert words in raised.value.message


def test_cells_in_quotes_hold_separators_and_spaces_go():
    read_in = read('angle (deg),"torque (N m)"\n 0 ,"1"\n"10", 2\n')
    assert np.allclose(read_in.values[1], [1.0, 2.0])
    assert read_in.notes == []


def test_columns_that_are_not_read_are_named():
    assert read("angle (deg),torque (N m),speed\n0,1,2\n").notes == [
        "joint.csv: columns not read: speed"
    ]


def test_a_column_in_the_file_of_a_trajectory_that_is_not_read_is_named(tmp_path):
    rows = [f"{0.1 * row:.1f},{40 + row % 20},1" for row in range(40)]
    (tmp_path / "walk.csv").write_text("\n".join(["time (s),angle (deg),force (N)", *rows]))
    (tmp_path / "study.toml").write_text('[motion]\ntrajectory = "walk.csv"\n')
    study = load_study(tmp_path / "study.toml", ["motion.cutoff=2 Hz"])
    assert "walk.csv: columns not read: force (N)" in study.warnings


@pytest.mark.parametrize("name", ["study.toml", "study.yaml", "run.json", "states.parquet"])
def test_a_file_of_another_kind_is_no_csv(name):
    with pytest.raises(InputError, match=r"this is .*, expected a CSV"):
        lines_of(b"load = 1\n", name)


@pytest.mark.parametrize("name", ["log.csv", "states.parquet", "figure.png"])
def test_a_file_of_another_kind_is_no_study(tmp_path, name):
    (tmp_path / name).write_bytes(b"a,b\n1,2\n")
    with pytest.raises(StudyError, match=r"this is .*, expected a study in TOML or YAML"):
        load_study(tmp_path / name)
    with pytest.raises(StudyError, match="no such file"):
        load_study(tmp_path / f"no-{name}")
