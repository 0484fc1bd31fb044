"""All faults of a study come at once, in the order of its lines, of whatever kind they are."""

import pytest

from tendon_cli.errors import StudyError
from tendon_cli.studies.load import load_study

from .malformed.row import LONGEST_TIME, at_most

TEN_FAULTS = """\
name = "a/b"
titel = "x"
[arm]
b1 = "1 kg"
b3 = 1
[sheath]
friction = -1
[tendon.flexor]
lenght = "2 m"
[spring]
stiffness = "3 kn/m"
[load]
mass = [1, true]
[model]
slack = "both"
[[cases]]
name = "a"
arm.b1 = [1, 2]
[limits]
max_tension = "1 N +/- 2 N"
"""
KEYS_AT_FAULT = [
    "name",
    "titel",
    "arm.b1",
    "arm.b3",
    "sheath.friction",
    "tendon.flexor.lenght",
    "spring.stiffness",
    "load.mass",
    "model.slack",
    "cases.0.arm.b1",
    "limits.max_tension",
]


def test_all_faults_come_at_once_in_the_order_of_the_lines(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(TEN_FAULTS)
    with pytest.raises(StudyError) as caught:
        load_study(path)
    assert [fault.key for fault in caught.value.faults] == KEYS_AT_FAULT
    assert [fault.line for fault in caught.value.faults] == [1, 2, 4, 5, 7, 9, 11, 13, 15, 18, 20]
    assert len(str(caught.value).splitlines()) == len(KEYS_AT_FAULT) + 1


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[[cases]]\nname = 'a'\n[[cases]]\nname = 'a'\n[sheath]\npath_smoothing = 0.001\n", 2),
        ("colour = 'red'\n[sheath]\nfriction = 0.1\nfriction_from = 'f.toml'\n", 3),
        ("colour = 'red'\n[sheath]\npath = 'r.csv'\n", 2),
        ("[sheath]\npath = 3\npath_smoothing = '1 mm'\n", 1),
        ("[[cases]]\nname = 'a'\narm.bb1 = 1\n[[cases]]\nname = 'a'\nsheath.path = 'r.csv'\n", 3),
        ("[sheath]\npath = 'r.csv'\n[motion]\ndirection = ['up', 'down']\n", 2),
    ],
)
def test_faults_of_different_kinds_come_at_once(tmp_path, text, expected):
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(StudyError) as caught:
        load_study(path)
    assert len(caught.value.faults) == expected


def test_a_thousand_faults_come_at_once_and_soon(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text("\n".join(f"k{i} = 1" for i in range(1000)))
    with at_most(LONGEST_TIME), pytest.raises(StudyError) as caught:
        load_study(path)
    assert [fault.line for fault in caught.value.faults] == list(range(1, 1001))


WITHOUT_VALUES = """\
arm: {a1: , b1: 1 kg}
cases:
  - name: a
    arm:
      b2:
  -
load:
sheath: {path: r.csv}
"""


def test_keys_without_a_value_come_with_every_other_fault(tmp_path):
    path = tmp_path / "study.yaml"
    path.write_text(WITHOUT_VALUES)
    with pytest.raises(StudyError) as caught:
        load_study(path)
    assert [(fault.key, fault.line) for fault in caught.value.faults] == [
        ("arm.a1", 1),
        ("arm.b1", 1),
        ("cases", 2),
        ("cases.0.arm.b2", 5),
        ("load", 7),
        ("sheath.path", 8),
    ]


def test_a_fault_of_the_command_line_is_not_sought_in_the_file(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text("[arm]\nb1 = '150 mm'\n")
    with pytest.raises(StudyError) as caught:
        load_study(path, ("arm.b1=1 kg",))
    assert [(fault.key, fault.line) for fault in caught.value.faults] == [("arm.b1", None)]


def test_a_hint_lists_the_columns_of_keys_at_fault_in_one_order(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(
        'design.minimise = ["xyzzy"]\nspring.stiffness = "1 kg"\nspool.ratio = "1 kg"\n'
        'sheath.friction = "1 kg"\narm.contact_width = "1 kg"\n'
    )
    with pytest.raises(StudyError) as caught:
        load_study(path)
    (fault,) = [fault for fault in caught.value.faults if fault.key == "design.minimise"]
    columns = ("contact_width", "friction", "spool_ratio", "spring_stiffness")
    assert fault.hint.endswith(", ".join(columns))
