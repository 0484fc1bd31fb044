"""Files beside a study: read however they are written, all faults at once, notes on the rest."""

import pytest

import tendon_cli as tendon
from tendon_cli.errors import InputError, StudyError
from tendon_cli.readers.file_text import lines_of
from tendon_cli.studies.load import any_study, load_study
from tendon_cli.studies.people.persons_csv import read_persons
from tests.readers.files import Written, good, hostile

TIMES = [f"{0.01 * row:.2f}" for row in range(200)]
FILES = {
    "joint.torque": Written(
        ("angle", "torque"), ("deg", "N m"), [["-10", "-1.5"], ["40", "0.5"], ["95", "2.5"]]
    ),
    "joint.excursion": Written(
        ("elbow_angle", "flexor_travel", "extensor_travel"),
        ("deg", "mm", "mm"),
        [["-5", "-3.5", "-2.0"], ["45", "30.5", "20.0"], ["95", "60.0", "45.5"]],
    ),
    "motion.trajectory": Written(
        ("time", "elbow_angle"),
        ("s", "deg"),
        [[time, f"{40.0 + 20.0 * (row / 200):.3f}"] for row, time in enumerate(TIMES)],
    ),
    "sheath.path": Written(
        ("x", "y", "z"),
        ("mm", "mm", "mm"),
        [["0.0", "-10", "0"], ["100", "0.5", "0"], ["180", "60", "0"], ["200", "150", "0"]],
    ),
    "people.file": Written(
        ("name", "weight", "stature"),
        ("", "kg", "cm"),
        [["A", "70.5", "175"], ["B", "81", "182.5"], ["C", "64", "168"]],
    ),
    "table": Written(
        ("name", "spring.stiffness", "price"),
        ("", "kN/m", "EUR"),
        [["A", "3.5", "12"], ["B", "5", "14.5"], ["C", "8", "19"]],
    ),
}
"""A good file for each key that names one."""


def study_of(folder, key, content, name="file.csv"):
    """Return a study that names a file of some content."""
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    table, _, inner = key.partition(".")
    if key == "table":
        return any_study({"table": [{"name": "part", "file": name}]})
    return any_study({table: {inner: name}})


@pytest.mark.parametrize("key", FILES)
def test_a_file_is_the_same_however_it_is_written(key, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    written = FILES[key]

    def numbers_of(content):
        """Return the numbers that a study has of its file, as bytes."""
        study = study_of(tmp_path, key, content)
        if key == "people.file":
            return read_persons((tmp_path / "file.csv").read_bytes(), "file.csv").values.tobytes()
        return study.hash

    right = numbers_of(written.text())
    for way, content in good(written).items():
        assert numbers_of(content) == right, way


@pytest.mark.parametrize("key", FILES)
def test_a_hostile_file_is_refused_with_its_place(key, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, (content, where, message) in hostile(FILES[key], 1).items():
        if key == "table" and name in ("zeros in front", "a bomb"):
            continue  # numbers of parts may have them, and tables may be larger
        with pytest.raises((InputError, StudyError)) as caught:
            study_of(tmp_path, key, content)
        told = str(caught.value)
        assert "file.csv" in told, name
        if key == "table" and where.startswith("line 3, column"):
            # A table names its columns, whose cells may have their own units.
            assert "line 3" in told, name
            continue
        assert message in told, name
        assert where in told, name


def test_every_fault_of_persons_is_told():
    with pytest.raises(InputError) as raised:
        read_persons(b"weight (kg),stature (cm),sex\n70,x,m\n-7,180,q\n", "people.csv")
    for words in ('stature is "x"', "weight is -7 kg"):
        assert words in raised.value.message


def test_a_motion_of_opensim_is_a_trajectory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    written = FILES["motion.trajectory"]
    rows = "".join(f"{time}\t1.5\t{angle}\n" for time, angle in written.rows)
    head = "Coordinates\nversion=1\nnRows=200\nnColumns=3\ninDegrees=yes\n\nendheader\n"
    text = f"{head}time\tarm_flex_r\telbow_flex_r\n{rows}"
    study = study_of(tmp_path, "motion.trajectory", text, "ik.mot")
    assert study.hash == study_of(tmp_path, "motion.trajectory", written.text()).hash
    assert 'ik.mot: the angle is "elbow_flex_r"' in study.warnings
    with pytest.raises(InputError, match="no column angle, the header reads: time, arm_flex_r"):
        study_of(tmp_path, "motion.trajectory", text.replace("elbow", "knee"), "ik.mot")


def test_a_motion_of_tendon_is_a_trajectory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study = study_of(tmp_path, "motion.trajectory", FILES["motion.trajectory"].text())
    states = tendon.sweep(study).states
    units = states.attrs["units"]
    text = states.rename(columns=lambda name: f"{name} ({units[name]})").to_csv(index=False)
    again = study_of(tmp_path, "motion.trajectory", text, "states.csv")
    angles = again.motion.trajectory.columns["angle"]
    assert angles == pytest.approx(states["elbow_angle"])


def test_a_clock_that_starts_again_names_the_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = FILES["motion.trajectory"].text()
    twice = text + text.partition("\n")[2]
    with pytest.raises(InputError, match="time starts again in this row") as caught:
        study_of(tmp_path, "motion.trajectory", twice)
    assert caught.value.where == "file.csv, line 202"


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
        ("2,,0", "y is empty"),
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
    with pytest.raises((InputError, StudyError)) as raised:
        study_of(folder, key, "\n".join(lines) + "\n")
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
