"""A study is validated once in a command, and the record of a folder is read once."""

import inspect
import shlex
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

import tendon_cli
from tendon_cli import files
from tendon_cli.studies.study import Study

STUDY = """
name = "suit"
load.mass = ["0 kg", "2 kg"]
tendon.pretension = ["100 N", "250 N"]
spring.stiffness = ["5 kN/m", "8 kN/m"]
motion.elbow_angle = ["0 deg", "45 deg", "90 deg"]
limits.max_tension = "900 N"
[[figure]]
name = "torque"
quantity = "motor_torque"
[[figure]]
name = "most"
quantity = "max_tension"
x = "load_mass"
"""
pytestmark = pytest.mark.usefixtures("blank_figures")
PACKAGE = str(Path(tendon_cli.__file__).parent)
RECORDS = ("run.json", "design.json")
MOST_LOOKS_OF_A_RUN = 2
"""Looks of a command that computes: before it locks the folder, and behind the lock."""


@pytest.fixture
def counted(monkeypatch):
    """Count the validations of studies and the reads of records."""
    counts = {"studies": 0, "records": 0}
    validate = Study.model_validate
    opened = files.open_file

    def validate_counted(*arguments, **options):
        counts["studies"] += 1
        return validate(*arguments, **options)

    def open_counted(path):
        if path.name == RECORDS[0]:  # who looks for records looks for each once
            counts["records"] += 1
        return opened(path)

    monkeypatch.setattr(Study, "model_validate", validate_counted)
    monkeypatch.setattr(files, "open_file", open_counted)
    return counts


@pytest.fixture
def folders(tendon, workplace):
    """Make a run, a run that keeps no states, and an answer."""
    (workplace / "study.toml").write_text(STUDY)
    tendon("sweep", "study.toml", "--out", "run", "--no-figures", "--allow-no-equilibrium")
    tendon(
        "sweep", "study.toml", "--out", "few", "--no-figures", "--set", 'output.tables=["designs"]'
    )
    tendon("design", "study.toml", "--out", "answer", "--no-figures")


READING = [
    ("show run", 0),
    ("show run --table states", 0),
    ("show few --table states", 1),
    ("show answer", 0),
    ("show run/designs.parquet", 0),
    ("export run rows.csv", 0),
    ("export few rows.csv --table states", 1),
    ("plot run --out a.png", 1),
    ("plot run -y motor_torque --out a.png", 1),
    ("plot few -y motor_torque --out a.png", 1),
    ("plot run/states.parquet --out a.png", 1),
    ("plot answer --between --out a.png", 1),
    ("report run", 1),
    ("report few", 1),
    ("report answer", 1),
    ("check run", 1),
    ("check answer", 0),
]


def test_commands_that_read_validate_one_study_and_read_one_record(tendon, folders, counted):
    for line, studies in READING:
        counted.update(studies=0, records=0)
        done = tendon(*shlex.split(line))
        assert done.exit in (0, 4), (line, done.err)
        assert counted == {"studies": studies, "records": 1}, line


def test_a_completion_validates_nothing_and_reads_no_record(completed, folders, counted):
    counted.update(studies=0, records=0)
    assert "max_tension" in completed("tendon show run --columns m")
    assert counted == {"studies": 0, "records": 0}


def test_a_comparison_validates_the_studies_and_reads_the_records_of_both(tendon, folders, counted):
    tendon("check", "run", "--baseline", "few")
    assert counted == {"studies": 2, "records": 2}


@pytest.mark.parametrize("line", ["state study.toml", "plot --arm study.toml --out a.png"])
def test_commands_on_a_study_validate_it_once(tendon, folders, counted, line):
    tendon(*shlex.split(line))
    assert counted == {"studies": 1, "records": 0}


@pytest.mark.parametrize("verb", ["sweep", "design"])
def test_commands_that_compute_validate_one_study(tendon, folders, counted, verb):
    words = (verb, "study.toml", "--out", "own")
    for more in (("--dry-run",), (), (), ("--resume",), ("--overwrite",)):
        counted.update(studies=0, records=0)
        assert tendon(*words, *more).exit in (0, 4)
        assert counted["studies"] == 1, more
        assert counted["records"] <= MOST_LOOKS_OF_A_RUN, more


MOST_FILES = {
    "show run": 17,
    "show answer": 17,
    "plot run -y motor_torque --out a.png": 48,
    "check run": 52,
    "report run": 52,
    "report answer": 52,
    "compare run few": 45,
    "export run rows.csv": 16,
}
"""Most files of the package of which a command that reads enters any function."""


@contextmanager
def files_entered():
    """Collect the files of the package whose functions are called, other than by an import."""
    entered = set()

    def note(frame, event, _):
        code = frame.f_code
        is_function = code.co_flags & inspect.CO_OPTIMIZED
        if event == "call" and is_function and PACKAGE in code.co_filename:
            if code.co_filename in entered or is_importing(frame):
                return
            entered.add(code.co_filename)

    sys.setprofile(note)
    try:
        yield entered
    finally:
        sys.setprofile(None)


def is_importing(frame):
    while frame is not None:
        if frame.f_code.co_name == "<module>" and PACKAGE in frame.f_code.co_filename:
            return True
        frame = frame.f_back
    return False


def test_commands_that_read_enter_few_files(tendon, folders):
    found = {}
    for line in MOST_FILES:
        with files_entered() as entered:
            assert tendon(*shlex.split(line)).exit in (0, 4)
        found[line] = len(entered)
    assert {line: count for line, count in found.items() if count > MOST_FILES[line]} == {}
    assert min(found.values()) > 10
