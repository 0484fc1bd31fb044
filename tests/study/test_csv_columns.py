"""CSVs beside a study: all faults of a file at once, a note on what is not read, other kinds."""

import numpy as np
import pytest

from tendon_cli.cells import MOST_FAULTS, lines_of
from tendon_cli.errors import InputError, StudyError
from tendon_cli.studies.csv_columns import read_columns
from tendon_cli.studies.load import load_study
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
