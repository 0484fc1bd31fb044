"""Numbers far from any arm are refused, with the unit in which they would be plausible."""

import re
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

import tendon_cli as tendon
from tendon_cli.commands.cli import main
from tendon_cli.errors import StudyError
from tendon_cli.quantities import PLAUSIBLE, QUANTITIES
from tendon_cli.studies.contents import keys
from tendon_cli.studies.design_section import Limits
from tendon_cli.studies.load import load_study, recorded_study, study_from
from tendon_cli.studies.study import Study
from tendon_cli.units import UNITS, known_units, parse_measure, to_float

NEEDED = {
    "arm": {"contact_width": "40 mm"},
    "spring": {"free_length": "70 mm"},
    "joint": {"rest_angle": "70 deg"},
    "motion": {"speed": "60 deg/s"},
}
"""Keys that limits and numbers need."""
PATHS = {
    **{path: key.number.name for path, key in keys().items()},
    **{f"limits.{name}": name for name in Limits.model_fields},
    "motion.speed": "speed",
    "design.pretension": "pretension",
}
"""Quantity of each key that holds a number."""
WITHOUT_RANGE = {
    "load_scale": "a task's torque may be of any size and sign",
    "reading_error": "a tension or a torque, as the gauge shows",
}
"""Quantities of keys that no unit makes plausible or implausible, with the reason."""


def content_with(key, value):
    """Return a study with one key, and with what this key needs."""
    content = {table: dict(numbers) for table, numbers in NEEDED.items()}
    table = content
    *parts, name = key.split(".")
    for part in parts:
        table = table.setdefault(part, {})
    table[name] = value
    return content


def slips_of(content):
    """Return the faults of a study that are about implausible numbers."""
    with pytest.raises(StudyError) as raised:
        study_from(content)
    return [fault for fault in raised.value.faults if fault.is_implausible]


def bounds_of(path):
    """Return smallest and largest possible value of a key, SI."""
    table, _, name = path.partition(".")
    if path in keys():
        return keys()[path].number.low, keys()[path].number.high
    fields = {"limits": Limits, "motion": Study.model_fields["motion"].annotation}
    if table not in fields:
        return 0.0, 1e5
    field = fields[table].model_fields[name]
    marks = [mark for mark in field.metadata if hasattr(mark, "low")]
    for choice in getattr(field.annotation, "__args__", ()):
        marks += [mark for mark in getattr(choice, "__metadata__", ()) if hasattr(mark, "low")]
    return marks[0].low, marks[0].high


def test_every_number_of_a_study_has_a_plausible_range_or_a_reason_for_none():
    without = {name for name in PATHS.values() if name not in PLAUSIBLE}
    assert without == set(WITHOUT_RANGE)


def test_every_default_is_plausible():
    study = Study()
    for key, values in study.numbers.items():
        low, high = PLAUSIBLE.get(PATHS[key], (float("-inf"), float("inf")))
        finite = [value for value in values.extremes if value != float("inf")]
        assert all(low <= value <= high for value in finite), key


@given(st.data())
def test_a_plausible_number_in_a_wrong_unit_is_refused_and_told_a_right_one(data):
    path = data.draw(st.sampled_from([key for key in PATHS if PATHS[key] in PLAUSIBLE]))
    quantity = PATHS[path]
    low, high = PLAUSIBLE[quantity]
    dimension = QUANTITIES[quantity].dimension
    right = UNITS[data.draw(st.sampled_from(known_units(dimension)))]
    wrong = UNITS[data.draw(st.sampled_from(known_units(dimension)))]
    value = data.draw(st.floats(max(low, high * 1e-3), high, exclude_max=True))
    number = f"{value / float(right.factor):.9g}"
    is_right = low <= to_float(Fraction(number) * right.factor) <= high
    meant = to_float(Fraction(number) * wrong.factor)
    least, largest = bounds_of(path)
    if not is_right or low <= meant <= high or not least <= meant <= largest:
        return
    content = content_with(path, f"{number} {wrong.symbol}".removesuffix(" 1"))
    (fault,) = slips_of(content)
    assert fault.key == path
    for suggested in re.findall('"([^"]*)"', fault.hint):
        if suggested != "rigid":
            assert low <= parse_measure(suggested, dimension).si <= high
            assert not [*study_from(content_with(path, suggested)).slips]
    assert re.search('"[^"]*"', fault.hint)
    accepted = study_from(content | {"allow_implausible": True})
    assert any(note.startswith(f"{path} = ") for note in accepted.warnings)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("arm.b1", "11 m", ['"11 m" is far from any arm', '"11 cm"', "10 to 600 mm"]),
        ("arm.b1", 11, ["11 is 11 m, far from any arm", '"11 cm"']),
        ("arm.b1", ["100 mm", "11 m"], ['item 2: "11 m"', '"11 cm"']),
        ("arm.b1", {"from": "11 cm", "to": "12 m", "num": 3}, ['to: "12 m"', '"12 cm"']),
        ("load.mass", {"from": "0 kg", "to": "10 t"}, ['to: "10 t"', '"10 kg"']),
        ("spring.stiffness", "5 N/m ± 1 N/m", ['mean: "5 N/m"', '"5 kN/m"']),
        ("arm.b1", "100 mm to 12 m", ['to: "12 m"', '"12 cm"']),
        ("arm.b1", {"mean": "100 mm", "std": "5 m"}, ['std: "5 m"', '"5 cm"']),
        ("spring.stiffness", "1e12 N/m", ["far from any arm", '"rigid"']),
        ("spring.flexor.stiffness", "5 N/m", ["far from any arm", '"5 kN/m"']),
        ("sheath.friction", 7, ["7 is far from any arm", '"7 %"']),
        ("limits.max_contact_pressure", "20 Pa", ["far from any arm", '"20 kPa"']),
        ("design.pretension", "38 kN", ["far from any arm", '"38 N"']),
    ],
)
def test_a_slip_is_told_with_its_place_and_what_was_meant(key, value, words):
    (fault,) = slips_of(content_with(key, value))
    assert fault.key == key
    for expected in words:
        assert expected in str(fault)


def test_a_number_that_fits_in_no_unit_is_told_the_range_alone():
    (fault,) = slips_of({"arm": {"forearm_mass": "0.3 t"}, "sheath": {"bend_angle": "180 deg"}})
    assert fault.hint == 'did you mean "0.3 kg" or "0.3 g"?'
    (fault,) = slips_of({"spring": {"stiffness": "0.002 N/m"}})
    assert fault.hint is None
    assert "expected 0.01 to 10,000 kN/m" in fault.problem


def test_every_slip_of_a_study_is_told_at_once_beside_its_other_faults(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(
        'colour = "red"\n[arm]\nb1 = "11 m"\n[load]\nmass = ["5 t", "6 t"]\n'
        '[[cases]]\nname = "tall"\narm.a1 = "40 m"\n'
    )
    with pytest.raises(StudyError) as raised:
        load_study(path)
    faults = raised.value.faults
    places = [(fault.line, fault.key) for fault in faults]
    assert places == [
        (1, "colour"),
        (3, "arm.b1"),
        (5, "load.mass"),
        (5, "load.mass"),
        (8, "cases.0.arm.a1"),
    ]
    assert '"40 m"' in faults[-1].problem
    assert "allow_implausible = true" in raised.value.hint


def test_a_long_list_of_slips_is_counted():
    slips = slips_of({"arm": {"b1": [11 + at for at in range(40)]}})
    assert len(slips) < 10
    assert "more values" in slips[-1].problem


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("spring.stiffness", 0, "0 N/m is impossible"),
        ("arm.b1", "-1 mm", "-1 mm is impossible"),
        ("load.mass", "-5 kg", "is negative"),
        ("tendon.length", float("inf"), "not a finite number"),
    ],
)
def test_zero_negative_and_infinite_values_keep_their_own_words(key, value, words):
    with pytest.raises(StudyError, match=words) as raised:
        study_from(content_with(key, value))
    assert not any(fault.is_implausible for fault in raised.value.faults)


@pytest.mark.parametrize(
    ("key", "value"),
    [("spring.free_length", 0), ("load.mass", 0), ("limits.min_flexor_tension", 0)],
)
def test_zero_is_no_slip_where_it_is_possible(key, value):
    assert study_from(content_with(key, value)).slips == {}


def test_a_number_out_of_range_is_told_the_unit_that_makes_it_plausible():
    with pytest.raises(StudyError, match=r'110 m is out of range.*did you mean "110 mm"'):
        study_from({"arm": {"b1": "110 m"}})


# --- Files ---------------------------------------------------------------------------------------

CURVE = "angle (deg),flexor (m),extensor (m)\n"
FILES = [
    (
        'people.file = "people.csv"\n',
        "people.csv",
        "stature (m),weight (kg)\n1.7,70\n175,80\n",
        ("people.file", "people.csv, line 3: stature of 175 m", "far from any person", '"175 cm"'),
    ),
    (
        'load.torque = "task.csv"\n',
        "task.csv",
        "angle (deg),torque (N m)\n-10,100\n50,1100\n100,300\n",
        ("load.torque", "task.csv, line 3: torque of 1100 N m", '"1100 N mm"'),
    ),
    (
        'joint.excursion = "travel.csv"\n',
        "travel.csv",
        CURVE + "".join(f"{angle},{angle / 10},{angle / 1000}\n" for angle in range(-20, 111, 5)),
        ("joint.excursion", "travel.csv, line 2: flexor of -2 m", '"-2 cm"'),
    ),
    (
        'motion.trajectory = "walk.csv"\nmotion.cutoff = "0.5 Hz"\n',
        "walk.csv",
        "time (min),angle (deg)\n"
        + "".join(f"{row},{40 + 20 * (row % 20) / 20}\n" for row in range(100)),
        ("motion.trajectory", "a time between samples of 1 min", '"1 ms"'),
    ),
    (
        'sheath.path = "route.csv"\n',
        "route.csv",
        "x,y,z\n0,0,0\n300,0,0\n300,400,0\n300,800,50\n",
        ("sheath.path", "route.csv: a route of", "far from any arm", 'mm"'),
    ),
]


@pytest.mark.parametrize(("study", "name", "content", "words"), FILES, ids=lambda text: text[:14])
def test_a_slip_in_a_file_is_a_fault_of_its_key_with_the_line(
    tmp_path, study, name, content, words
):
    path = tmp_path / "study.toml"
    (tmp_path / name).write_text(content)
    path.write_text(study)
    with pytest.raises(StudyError) as raised:
        load_study(path)
    text = str(raised.value)
    for expected in words:
        assert expected in text


def test_persons_that_are_accepted_are_noted_with_their_line(tmp_path):
    (tmp_path / "people.csv").write_text("stature (m),weight (kg)\n1.7,70\n2.6,80\n")
    path = tmp_path / "study.toml"
    path.write_text('allow_implausible = true\npeople.file = "people.csv"\n')
    study = load_study(path)
    assert any(
        "people.csv, line 3, stature = 2.6 is 2.6 m" in warning for warning in study.warnings
    )
    again = recorded_study(study.record)
    assert again.people.nominal.values[1, 0] == 2.6


# --- The way in and out ---------------------------------------------------------------------------


def exit_code_of(*arguments):
    """Return the exit code of a command that runs in this process."""
    with pytest.raises(SystemExit) as left:
        main([*arguments])
    return left.value.code


def test_a_setting_is_refused_and_accepted_alike(tmp_path, capsys):
    path = tmp_path / "study.toml"
    path.write_text('[motion]\nelbow_angle = ["0 deg", "90 deg"]\n')
    assert exit_code_of("state", str(path), "--set", "arm.b1=11 m") == 2
    told = capsys.readouterr().err
    assert '"11 m" is far from any arm' in told
    assert '"11 cm"' in told
    accepted = ["--set", "arm.b1=11 m", "--set", "allow_implausible=true"]
    assert exit_code_of("state", str(path), *accepted) == 0
    assert "arm.b1 = 11 is 11 m, far from any arm" in "".join(capsys.readouterr())


def test_accepting_implausible_numbers_changes_no_study():
    content = {"load": {"mass": "3 kg"}}
    assert study_from(content | {"allow_implausible": True}).hash == study_from(content).hash


def test_an_accepted_study_reads_back_from_its_record_and_an_older_one_does_too():
    study = study_from({"arm": {"b1": "11 m"}, "allow_implausible": True})
    assert recorded_study(study.record).warnings == study.warnings
    older = study.record
    del older["study"]["allow_implausible"]
    assert recorded_study(older).arm.b1.single == 11.0
    assert study.vary(**{"load.mass": "2 kg"}).arm.b1.single == 11.0
    with pytest.raises(StudyError):
        tendon.study({}).vary(**{"arm.b1": "11 m"})


@pytest.mark.parametrize(
    "content",
    [
        # A finger.
        {
            "arm": {"a1": "5 mm", "b1": "15 mm", "a2": "4 mm", "b2": "15 mm"}
            | {"elbow_radius": "4 mm", "forearm_mass": "20 g", "forearm_com": "20 mm"},
            "spring": {"stiffness": "200 N/m"},
            "spool": {"flexor_radius": "5 mm"},
            "tendon": {"diameter": "0.3 mm", "pretension": "2 N"},
        },
        # An ankle, and a leg about the knee.
        {"joint": {"stiffness": "400 N m/rad", "rest_angle": "0 deg"}},
        {"arm": {"forearm_mass": "5 kg"}, "load": {"mass": "80 kg"}},
    ],
)
def test_other_joints_are_plausible(content):
    assert study_from(content).slips == {}
