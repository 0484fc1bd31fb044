"""The meaning of a valid study, however it is written."""

import json
import math
from itertools import permutations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydantic import ValidationError

from tendon_cli.errors import InputError, UsageError
from tendon_cli.model.limits import LIMITS
from tendon_cli.studies.load import load_study, study_from
from tendon_cli.studies.study import keys
from tests.si import with_units

from .csv_text import csv_text

WITH_SIDES = ("sheath", "tendon", "spring", "anchor")
SIDES = ("flexor", "extensor")
OF_BOTH_SIDES = "tendon.breaking_force"
PER_SIDE = [
    key
    for key in keys()
    if key.count(".") == 1 and key.split(".")[0] in WITH_SIDES and key != OF_BOTH_SIDES
]
# An error is stated by its deviation, and is no axis (tests/design/test_exact_numbers.py).
NOT_PLAIN = ("motion.elbow_angle", "setting.reading_error")
PLAIN = [key for key in keys() if key.count(".") == 1 and key not in NOT_PLAIN]

BASELINE = {
    "arm.a1": 0.04,
    "arm.b1": 0.15,
    "arm.a2": 0.02,
    "arm.b2": 0.15,
    "arm.elbow_radius": 0.045,
    "arm.forearm_mass": 1.54,
    "arm.forearm_com": 0.174,
    "arm.load_distance": 0.32,
    "arm.upper_arm_angle": 0.0,
    "sheath.friction": 0.07,
    "sheath.bend_angle": math.pi,
    "tendon.length": 2.0,
    "tendon.diameter": 0.0015,
    "tendon.youngs_modulus": 145e9,
    "tendon.pretension": 100.0,
    "spring.stiffness": 3000.0,
    "anchor.stiffness": math.inf,
    "spool.flexor_radius": 0.03,
    "spool.ratio": 1.0,
    "load.mass": 0.0,
    "load.scale": 1.0,
    "setting.angle": 0.0,
    "setting.upper_arm_angle": 0.0,
    "setting.load": 0.0,
    "limits.min_elbow_stiffness": 0.0,
}
# Numbers that a study need not have, or that are none by default.
OPTIONAL = {
    "arm.contact_width": 0.04,
    "arm.contact_radius": 0.05,
    "arm.contact_from": 0.17,
    "tendon.breaking_force": 1900.0,
    "spring.free_length": 0.07,
    "anchor.stiffness": 1e4,
    "joint.stiffness": 1.1,
    "joint.rest_angle": 1.3,
    **{f"limits.{name}": 0.3 for name in LIMITS if name != "min_elbow_stiffness"},
}
STATED_FOR_LIMITS = {
    "arm.contact_width": {"arm": {"contact_width": "40 mm"}},
    "spring.free_length": {"spring": {"free_length": "73 mm"}},
    "motion.speed": {"motion": {"speed": "60 deg/s"}},
}
# Tables that a study must state beside a number.
NEEDED = {"joint.stiffness": {"joint": {"rest_angle": "73 deg"}}} | {
    f"limits.{name}": STATED_FOR_LIMITS[need.key]
    for name, limit in LIMITS.items()
    for need in limit.needs
}


@pytest.fixture
def load(tmp_path):
    """Return a function that writes a study, with other files beside it, and loads it."""

    def write_and_load(text, *settings, suffix=".toml", stem="study", **files):
        for name, content in files.items():
            (tmp_path / name.replace("_", ".")).write_text(content, encoding="utf-8")
        path = tmp_path / f"{stem}{suffix}"
        path.write_text(text, encoding="utf-8")
        return load_study(path, settings)

    return write_and_load


def study_with(key, value):
    """Return a study that states one key, however implausible its value."""
    content = with_units(value, key.rpartition(".")[2])
    for part in reversed(key.split(".")):
        content = {part: content}
    for table, needed in NEEDED.get(key, {}).items():
        content[table] = content.get(table, {}) | needed
    return study_from({"name": "study", "allow_implausible": True, **content})


def without_side(key):
    """Return the key of a number that both sides have in common."""
    return ".".join(part for part in key.split(".") if part not in SIDES)


def bits(values):
    """Return the bytes of numbers, which are the same only if every bit is."""
    return np.asarray(values, np.float64).tobytes()


# --- Defaults -------------------------------------------------------------------------------------


def test_the_baseline_is_the_one_of_the_paper(load):
    study = load("")
    assert {key: values.single for key, values in study.numbers.items()} == BASELINE


def test_the_baseline_bends_and_extends_over_91_angles_with_tendons_that_cannot_push(load):
    study = load("")
    assert study.motion.direction == ("flexion", "extension")
    angles = np.radians(np.arange(91))
    np.testing.assert_allclose(study.motion.elbow_angle.array, angles, rtol=1e-15)
    assert study.model.slack == "unilateral"
    assert study.model.reference == "published"
    assert study.output.tables == ("designs", "states")
    assert study.axes == ()
    assert study.cases is None
    assert study.title == ""
    assert study.sources == {}


@pytest.mark.parametrize("name", ["fig07", "A.b-c_9", "...a", "-", "a" * 64])
def test_the_name_is_the_stem_of_the_file_unless_given(load, name):
    assert load("", stem=name).name == name
    assert load(f'name = "{name}"').name == name


# --- TOML and YAML say the same -------------------------------------------------------------------

CASES_IN_TOML = """
[[cases]]
name = 'a'
arm.b1 = '160 mm'
[[cases]]
name = 'b'
[cases.tendon.flexor]
pretension = '90 N'
"""
CASES_IN_YAML = """
cases:
- name: a
  arm: {b1: 160 mm}
- name: b
  tendon:
    flexor: {pretension: 90 N}
"""
MOTION_IN_TOML = """
[motion]
direction = 'flexion'
elbow_angle = { from = '0 deg', to = '90 deg', num = 10 }
"""
MOTION_IN_YAML = """
motion:
  direction: [flexion]
  elbow_angle: {from: 0 deg, to: 90 deg, num: 10}
"""
TWINS = [
    ("", ""),
    ("", "# nothing\n"),
    ("name = 'x'\ntitle = 'σ'", "name: x\ntitle: σ\n"),
    (
        "[arm]\nb1 = '160 mm'\n[load]\nmass = ['0 kg', '3 kg']",
        "arm: {b1: 160 mm}\nload: {mass: [0 kg, 3 kg]}\n",
    ),
    (MOTION_IN_TOML, MOTION_IN_YAML),
    (
        "[tendon]\nlength = 2\n[tendon.flexor]\nlength = 3\n[model]\nslack = 'bilateral'",
        "tendon:\n  length: 2.0\n  flexor:\n    length: 3\nmodel:\n  slack: bilateral\n",
    ),
    (CASES_IN_TOML, CASES_IN_YAML),
    (
        "[spool]\nratio = { from = 0.1, to = 10, num = 3, spacing = 'log' }",
        "spool: {ratio: {from: 0.1, to: 10, num: 3, spacing: log}}\n",
    ),
    ("load.mass = 0x10", "load:\n  mass: 0x10\n"),
]


@pytest.mark.parametrize(("toml", "yaml"), TWINS)
@pytest.mark.parametrize("suffix", [".yaml", ".YML"])
def test_toml_and_yaml_twins_are_the_same_study(load, toml, yaml, suffix):
    assert load(toml).hash == load(yaml, suffix=suffix).hash


@pytest.mark.parametrize("form", ["{}\r\n", "\ufeff{}", "# comment\n\n{}  # comment\n\n"])
def test_line_ends_marks_and_comments_do_not_count(load, form):
    study = "[load]\nmass = ['1 kg', '2 kg']"
    assert load(form.format(study).replace("\n", "\r\n")).hash == load(study).hash


@pytest.mark.parametrize(
    "text",
    [
        "[arm]\nb1 = '160 mm'\nb2 = 0.14\n[load]\nmass = 3",
        "load.mass = 3\narm.b2 = 0.14\narm.b1 = 0.16",
        "load = { mass = '3000 g' }\narm = { b1 = '16 cm', b2 = '0.14 m' }",
        "[load]\nmass = '3.0e0 kg'\n[arm]\n'b1' = '1.6e2mm'\n\"b2\" = ' 140  mm '",
        "[arm]\nb1 = '0.16 m'\nb2 = 14e-2\na1 = '40 mm'\n[load]\nmass = 3.0\n[spool]",
    ],
)
def test_the_hash_does_not_know_layout_and_spelling(load, text):
    assert load(text).hash == load("[arm]\nb1 = 0.16\nb2 = 0.14\n[load]\nmass = 3.0").hash


def test_a_unit_and_a_bare_number_in_si_are_the_same():
    assert (
        study_with("spring.stiffness", "3 kN/m").hash == study_with("spring.stiffness", 3000.0).hash
    )
    assert (
        study_with("spring.stiffness", "3 N/mm").hash == study_with("spring.stiffness", 3000).hash
    )
    assert study_with("load.mass", ["1 kg", "500 g"]).hash == study_with("load.mass", [1, 0.5]).hash


def test_a_grid_in_another_unit_is_the_same_study():
    written = study_with("load.mass", {"from": "0 g", "to": "1000 g", "num": 5})
    assert bits(written.load.mass.array) == bits([0, 0.25, 0.5, 0.75, 1])
    assert written.hash == study_with("load.mass", {"from": "0.0 kg", "to": 1, "num": 5}).hash


def test_the_hash_knows_every_number():
    for key in keys():
        common = without_side(key)
        value = OPTIONAL.get(common) or BASELINE.get(common, 1.0)
        changed = study_with(key, math.nextafter(value, math.inf))
        assert changed.hash != study_from({"name": "study"}).hash, key


@pytest.mark.parametrize(
    "content",
    [
        {"name": "other"},
        {"title": "other"},
        {"model": {"slack": "bilateral"}},
        {"model": {"reference": "initial"}},
        {"motion": {"direction": ["extension", "flexion"]}},
        {"output": {"tables": ["designs"]}},
        {"cases": [{"name": "a"}]},
        {"load": {"mass": [0.0]}},
        {"output": {"states": ["status"]}},
        {"motion": {"speed": "60 deg/s"}},
        {"limits": {"max_tension": "300 N"}},
        {"limits": {"min_elbow_stiffness": "-2 N m/rad"}},
        {"design": {"conditions": []}},
        {"design": {"serve": 0.9}},
        {"design": {"minimise": "pretension"}},
        {"design": {"pretension": "least"}},
        {"uncertainty": {}},
    ],
)
def test_the_hash_knows_everything_else(content):
    assert study_from({"name": "study", **content}).hash != study_from({"name": "study"}).hash


# --- Exact numbers --------------------------------------------------------------------------------


FACTORS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "um": 1e-6, "in": 0.0254}


@given(st.integers(0, 1000), st.integers(1, 1000), st.integers(2, 200), st.sampled_from([*FACTORS]))
def test_a_grid_holds_the_numbers_that_a_list_would_say(first, step, num, unit):
    last = first + step * (num - 1)
    assume(last * FACTORS[unit] <= 99)
    texts = [f"{first + step * i} {unit}" for i in range(num)]
    grid = study_with("arm.a1", {"from": texts[0], "to": texts[-1], "num": num}).arm.a1
    listed = study_with("arm.a1", texts).arm.a1
    assert bits(grid.array) == bits(listed.array)


@given(
    st.floats(1e-3, 1e3),
    st.floats(1e-3, 1e3),
    st.integers(2, 50),
    st.sampled_from(["linear", "log"]),
)
def test_a_grid_starts_and_ends_exactly_and_goes_one_way(start, stop, num, spacing):
    assume(abs(start - stop) > 1e-9 * start)
    grid = {"from": start, "to": stop, "num": num, "spacing": spacing}
    array = study_with("spool.ratio", grid).spool.ratio.array
    assert array[0] == start
    assert array[-1] == stop
    assert len(array) == num
    assert np.all(np.diff(array) * (stop - start) > 0)


def test_a_log_grid_has_a_constant_factor():
    grid = {"from": 0.1, "to": 100, "num": 4, "spacing": "log"}
    ratios = study_with("spool.ratio", grid).spool.ratio.array
    np.testing.assert_allclose(ratios, [0.1, 1, 10, 100], rtol=1e-15)


def test_a_list_or_a_grid_of_one_is_an_axis_and_a_single_value_is_not():
    for value in ([2], {"from": "2 kg", "to": "5 kg", "num": 1}):
        study = study_with("load.mass", value)
        assert study.load.mass.array.tolist() == [2.0]
        assert study.axes == ("load.mass",)
    assert study_with("load.mass", 2).axes == ()
    assert study_with("motion.elbow_angle", ["0 deg", "10 deg"]).axes == ()


# --- Axes -----------------------------------------------------------------------------------------


OF_ONE_SIDE = [key.replace(".", f".{side}.") for key in PER_SIDE for side in SIDES]
GRID = {"from": 1, "to": 3, "num": 3}
ORDERS = list(permutations(["spool.ratio", "tendon.length", "load.mass", "arm.b1"]))[::3]


def test_any_number_may_be_an_axis():
    for key in [*PLAIN, *OF_ONE_SIDE]:
        value = (BASELINE | OPTIONAL)[without_side(key)]
        step = 0.001 * (value or 1.0)
        assert study_with(key, [value, value + step]).axes == (key,)


@pytest.mark.parametrize(
    ("line", "suffix"),
    [
        ("[{table}]\n{name} = [0.2, 0.3]\n", ".toml"),
        ("{table}.{name} = [0.2, 0.3]\n", ".toml"),
        ("{table}:\n  {name}: [0.2, 0.3]\n", ".yaml"),
    ],
    ids=["table", "dotted", "yaml"],
)
def test_axes_stand_in_the_order_of_the_document(load, line, suffix):
    for order in ORDERS:
        lines = []
        for key in order:
            table, name = key.split(".")
            lines.append(line.format(table=table, name=name))
        assert load("".join(lines), suffix=suffix).axes == order


REOPENED = """
[tendon]
length = [2, 3]
[spool]
ratio = [0.8, 1]
[tendon.flexor]
pretension = ['90 N', '100 N']
"""
SIDE_BEFORE_TABLE = """
[tendon.flexor]
length = [2, 3]
[spool]
ratio = [0.8, 1]
[tendon]
diameter = [0.001, 0.002]
"""
PRETENSIONS = "flexor = { pretension = [90, 100] }"
INLINE_TABLE = f"tendon = {{ length = [2, 3], {PRETENSIONS}, diameter = [0.001, 0.002] }}\n"
TEXT_OF_SEVERAL_LINES = (
    'title = """\n[spool]\\\nratio = [1, 2]\\\n"""\n# [load]\n[tendon] # first\n'
    "length = [ # x = 1\n  2,\n  3, # [arm]\n]\n"
    "[load]\nmass = [1,\n2]\n['arm'] # a = 1\n\"b1\" = [0.1, 0.2]\n[spool]\nratio = [1, 2]\n"
)


@pytest.mark.parametrize(
    ("text", "axes"),
    [
        (REOPENED, "tendon.length spool.ratio tendon.flexor.pretension"),
        (
            "tendon.length = [2, 3]\nspool.ratio = [0.8, 1]\ntendon.diameter = [0.001, 0.002]\n",
            "tendon.length spool.ratio tendon.diameter",
        ),
        (SIDE_BEFORE_TABLE, "tendon.flexor.length spool.ratio tendon.diameter"),
        (INLINE_TABLE, "tendon.length tendon.flexor.pretension tendon.diameter"),
        (
            "load.mass = [1, 2]\nspring.at = ['joint']\nspool.ratio = [1, 2]\n",
            "load.mass spring.at spool.ratio",
        ),
        (TEXT_OF_SEVERAL_LINES, "tendon.length load.mass arm.b1 spool.ratio"),
    ],
)
def test_tables_opened_again_dotted_keys_and_long_texts_keep_the_order_of_the_document(
    load, text, axes
):
    assert load(text).axes == tuple(axes.split())


def test_cases_are_the_slowest_axis_wherever_they_stand(load):
    cases = "[[cases]]\nname = 'a'\n[[cases]]\nname = 'b'\n"
    study = load(f"load.mass = [1, 2]\n{cases}[spool]\nratio = [1, 2]\n")
    assert study.axes == ("case", "load.mass", "spool.ratio")


def test_the_order_of_the_axes_is_part_of_the_study(load):
    mass = "[load]\nmass = [1, 2]\n"
    ratio = "[spool]\nratio = [1, 2]\n"
    assert load(mass + ratio).hash != load(ratio + mass).hash


# --- --set ----------------------------------------------------------------------------------------


RATIO = "spool.ratio=[0.9, 1.0]"
B1 = "arm.b1=[0.1, 0.2]"


@pytest.mark.parametrize(
    ("text", "settings", "axes"),
    [
        ("arm.b1 = 0.1\nload.mass = [1, 2]\n", [B1], "load.mass arm.b1"),
        ("load.mass = [1, 2]", [RATIO, B1], "load.mass spool.ratio arm.b1"),
        ("load.mass = [1, 2]", [B1, RATIO], "load.mass arm.b1 spool.ratio"),
        (
            REOPENED,
            ["tendon.length={from=1, to=2, num=5}"],
            "tendon.length spool.ratio tendon.flexor.pretension",
        ),
        (REOPENED, ["spool.ratio=0.9"], "tendon.length tendon.flexor.pretension"),
    ],
)
def test_new_set_axes_come_last_others_keep_their_place_and_one_value_is_none(
    load, text, settings, axes
):
    assert load(text, *settings).axes == tuple(axes.split())


@pytest.mark.parametrize(
    ("setting", "content"),
    [
        ("arm.b1=160 mm", {"arm": {"b1": 0.16}}),
        (" arm.b1 = '160 mm' ", {"arm": {"b1": 0.16}}),
        ('load.mass=["3 kg","5 kg"]', {"load": {"mass": [3.0, 5.0]}}),
        ("arm={b1='160 mm', b2=0.14}", {"arm": {"b1": 0.16, "b2": 0.14}}),
        ("spool.ratio=70 %", {"spool": {"ratio": 0.7}}),
        ("model.slack=bilateral", {"model": {"slack": "bilateral"}}),
        ("motion.direction=flexion", {"motion": {"direction": ["flexion"]}}),
        ("output.tables=['designs']", {"output": {"tables": ["designs"]}}),
        ("tendon.flexor.pretension=90 N", {"tendon": {"flexor": {"pretension": 90.0}}}),
        ("name=other", {"name": "other"}),
        ('load.mass=["500 g", 2]', {"load": {"mass": [0.5, 2]}}),
        ("load.mass={ from = 1, to = 3, num = 3 }", {"load": {"mass": GRID}}),
        ("title=a = b", {"title": "a = b"}),
        ("title= 3 ", {"title": "3"}),
        ("cases=[{name='b', arm={b1='160 mm'}}]", {"cases": [{"name": "b", "arm": {"b1": 0.16}}]}),
    ],
)
def test_a_setting_says_what_the_file_could_say(load, setting, content):
    assert load("", setting).hash == study_from({"name": "study"} | content).hash


def test_the_last_setting_of_a_key_counts(load):
    assert load("arm.b1 = 0.1", "arm.b1=0.2 m", "arm.b1=0.3 m").arm.b1.single == 0.3


@pytest.mark.parametrize(
    "setting", ["arm.b1", "=1", "arm.=1", ".b1=1", "load.mass=[1", "load.mass={"]
)
def test_what_is_not_key_and_value_is_an_error_of_usage(load, setting):
    with pytest.raises(UsageError, match="--set"):
        load("", setting)


def test_a_setting_that_mends_the_file_makes_it_valid(load):
    assert load("[load]\nmass = '5 m'\n", "load.mass=5 kg").load.mass.single == 5.0


# --- Sides and cases ------------------------------------------------------------------------------


def test_a_side_overrides_the_common_value_and_leaves_it():
    for key in PER_SIDE:
        table, name = key.split(".")
        value = (BASELINE | OPTIONAL)[key] * 1.5
        study = study_with(f"{table}.flexor.{name}", value)
        assert study.numbers[f"{table}.flexor.{name}"].single == value
        if key in BASELINE:
            assert study.numbers[key].single == BASELINE[key]
        assert f"{table}.extensor.{name}" not in study.numbers


TWO_CASES = """
[[cases]]
name = 'a'
[[cases]]
name = 'b b'
arm.b1 = '160 mm'
model.slack = 'bilateral'
tendon.flexor.pretension = '90 N'
[cases.sheath.extensor]
friction = 0.1
"""


def test_cases_say_only_what_they_override(load):
    cases = load(TWO_CASES).cases
    assert cases.names == ("a", "b b")
    second = {
        "arm.b1": 0.16,
        "tendon.flexor.pretension": 90.0,
        "sheath.extensor.friction": 0.1,
        "model.slack": 0.0,
    }
    assert {key: values[1] for key, values in cases.numbers.items()} == second
    assert all(np.isnan(values[0]) for values in cases.numbers.values())
    assert cases.document()[0] == {"name": "a"}
    assert cases.document()[1]["model"] == {"slack": "bilateral"}


def test_each_side_has_its_own_friction_and_bend():
    flexor = {"friction": 0.9, "bend_angle": "1 rad"}
    extensor = {"friction": 0.01, "bend_angle": "20 rad"}
    study = study_from({"name": "a", "sheath": {"flexor": flexor, "extensor": extensor}})
    assert study.axes == ()


# --- Studies of every shape -----------------------------------------------------------------------


def near(key):
    """Return a strategy of possible values around the baseline's."""
    value = (BASELINE | OPTIONAL)[key] or 1.0
    return st.floats(0.5 * value, 1.5 * value)


def numbers(key):
    """Return a strategy of single values, lists and grids of a key."""
    grids = st.fixed_dictionaries(
        {
            "from": near(key),
            "to": near(key).map(lambda value: 2 * value),
            "num": st.integers(1, 5),
            "spacing": st.sampled_from(["linear", "log"]),
        }
    ).filter(lambda grid: grid["from"] != grid["to"])
    lists = st.lists(near(key), min_size=1, max_size=4, unique=True)
    return near(key) | lists | grids


@st.composite
def contents(draw):
    """Draw a study as a dictionary, whose tables and keys stand in any order."""
    paths = [path for key in PLAIN for path in _with_sides(key)]
    stated = draw(st.lists(st.sampled_from(paths), unique=True, max_size=6))
    content = {"name": draw(st.from_regex(r"[A-Za-z0-9_-]{1,20}", fullmatch=True))}
    for path in stated:
        *tables, name = path.split(".")
        inner = content
        for table in tables:
            inner = inner.setdefault(table, {})
        inner[name] = with_units(draw(numbers(f"{tables[0]}.{name}")), name)
    for path in stated:
        for table, stated_too in NEEDED.get(path, {}).items():
            for name, value in stated_too.items():
                content.setdefault(table, {}).setdefault(name, value)
    names = st.text(min_size=1, max_size=9).filter(_is_name)
    content["cases"] = []
    for case_name in draw(st.lists(names, unique=True, max_size=3)):
        case = {"name": case_name}
        for key in ("arm.b1", "load.mass", "spool.ratio"):
            if key not in stated:
                table, name = key.split(".")
                case[table] = {name: draw(near(key))}
        content["cases"].append(case)
    content["model"] = {"slack": draw(st.sampled_from(["unilateral", "bilateral"]))}
    content["allow_implausible"] = True
    return content


def _with_sides(key):
    """Return a key and, if the sides have values of their own, the keys of the sides."""
    if key not in PER_SIDE:
        return [key]
    return [key, *(key.replace(".", f".{side}.") for side in SIDES)]


def _is_name(text):
    """Return True if a text can name a case: printable, and without half surrogates."""
    return text.isprintable() and text.encode("utf-8", "ignore").decode() == text


@given(contents())
def test_a_document_reads_back_as_the_same_study(content):
    study = study_from(content)
    record = json.loads(json.dumps(study.record))
    again = study_from(record["study"], order=tuple(record["axes"]))
    assert again.hash == study.hash
    assert again.axes == study.axes
    for key, values in study.numbers.items():
        assert bits(again.numbers[key].array) == bits(values.array)


@given(contents())
def test_the_product_is_the_one_of_the_axes(content):
    study = study_from(content)
    axes = [key for key, values in study.numbers.items() if values.is_axis]
    has_cases = bool(content["cases"])
    if has_cases:
        axes.append("case")
    assert sorted(study.axes) == sorted(axes)
    assert (study.axes[:1] == ("case",)) is has_cases


@pytest.mark.parametrize("value", [5, [3, 1, 2], {"from": 9, "to": 2, "num": 4}])
def test_extremes_are_those_of_the_values_which_are_read_only(value):
    values = study_with("load.mass", value).load.mass
    assert values.extremes == (values.array.min(), values.array.max())
    with pytest.raises(ValueError, match="read-only"):
        values.array[0] = 9.0


# --- Nothing changes after it is read -------------------------------------------------------------


def test_a_study_is_frozen():
    study = study_from({"name": "a"})
    with pytest.raises(ValidationError, match="frozen"):
        study.name = "x"
    with pytest.raises(ValidationError, match="frozen"):
        study.arm.b1 = "x"
    with pytest.raises(ValidationError, match="frozen"):
        study.tendon.flexor = "x"
    with pytest.raises(ValidationError, match="frozen"):
        study.model.slack = "x"


# --- Routes ---------------------------------------------------------------------------------------


ROUTE = "[sheath]\npath = 'r.csv'\n"


def half_circle_points(count=40):
    """Return way-points on half a circle of 0.1 m, (count, 3), m."""
    turn = np.linspace(0, math.pi, count)
    return np.column_stack([0.1 * np.cos(turn), 0.1 * np.sin(turn), 0 * turn])


def half_circle(scale=1.0, separator=",", header="x,y,z", comment=""):
    """Return way-points on half a circle as CSV."""
    points = scale * half_circle_points()
    header = header.replace(",", separator)
    return comment + csv_text(header, *points.T, separator=separator)


def bend_of(study):
    """Return the bend angle of a study's sheath, rad."""
    return study.sheath.bend_angle.single


@pytest.mark.parametrize(
    "layout",
    [
        {"separator": ","},
        {"separator": ";"},
        {"separator": "\t"},
        {"header": "X,Y,Z"},
        {"header": "x_m,y_m,z_m"},
        {"header": "x [m],y [m],z [m]"},
        {"header": "x (m),y (m),z (m)"},
        {"scale": 1000, "header": "x_mm,y_mm,z_mm", "comment": "# digitised\n\n"},
        {"scale": 1e-3, "header": "x_km,y_km,z_km"},
    ],
)
def test_a_half_circle_bends_by_pi_however_it_is_written(load, layout):
    assert bend_of(load(ROUTE, r_csv=half_circle(**layout))) == pytest.approx(math.pi, rel=1e-4)


def test_decimal_commas_stand_between_semicolons_and_columns_in_any_order_among_others(load):
    plain = bend_of(load(ROUTE, r_csv=half_circle()))
    decimal_commas = half_circle(separator=";").replace(".", ",")
    assert bend_of(load(ROUTE, r_csv=decimal_commas)) == plain
    x, y, z = half_circle_points().T
    reordered = csv_text("t,z,x,y", 0 * x, z, x, y)
    assert bend_of(load(ROUTE, r_csv=reordered)) == plain


def test_a_route_stands_for_its_bend_angle_and_is_remembered(load):
    study = load(ROUTE, r_csv=half_circle())
    assert "path" not in study.document()["sheath"]
    (source,) = study.sources.values()
    assert source["file"] == "r.csv"
    assert len(source["sha256"]) == 64
    assert source["warnings"] == []
    known = study.uncertain["sheath.bend_angle"]
    assert known.kind == "normal"
    assert known.middle == bend_of(study)
    assert known.spread == source["standard_error"]
    stated = {"mean": known.middle, "std": known.spread}
    assert study.hash == study_with("sheath.bend_angle", stated).hash


def test_a_route_of_one_side_or_of_a_case_leaves_the_others(load):
    text = "[sheath.flexor]\npath = 'r.csv'\n[[cases]]\nname = 'a'\nsheath.path = 'r.csv'\n"
    study = load(text, r_csv=half_circle())
    flexor_bend = study.numbers["sheath.flexor.bend_angle"].single
    (case_bend,) = study.cases.numbers["sheath.bend_angle"]
    rows = (
        "[[table]]\nname = 'sheath'\nrows = [{name = 'a', 'sheath.path' = 'r.csv'}, {name = 'b'}]\n"
    )
    row_bends = load(rows, r_csv=half_circle()).row_tables[0].numbers["sheath.bend_angle"]
    np.testing.assert_array_equal(row_bends, [case_bend, np.nan])
    assert flexor_bend == pytest.approx(math.pi, rel=1e-4)
    assert case_bend == pytest.approx(math.pi, rel=1e-4)
    assert study.numbers["sheath.bend_angle"].single == math.pi


def noisy_half_circle():
    """Return way-points on half a circle with a noise of 1 mm as CSV."""
    noise = np.random.default_rng(7).normal(0, 1e-3, (200, 3))
    points = half_circle_points(count=200) + noise
    return csv_text("x,y,z", *points.T)


def test_noise_that_dominates_is_warned_of_and_taken_off(load):
    study = load(ROUTE, r_csv=noisy_half_circle())
    (source,) = study.sources.values()
    (warning,) = study.warnings
    assert "noise of about" in warning
    assert "path_smoothing" in warning
    assert source["noise"] == pytest.approx(1e-3, rel=0.2)
    assert source["as_it_stands"] > 10 * math.pi
    assert study.notes == (source["note"],)
    assert source["note"].startswith(f"r.csv bends by {math.degrees(bend_of(study)):.2f} deg +/- ")
    assert f"{math.degrees(source['as_it_stands']):.2f} deg as it stands" in source["note"]
    assert abs(bend_of(study) - math.pi) < 2 * source["standard_error"] < 0.2


@pytest.mark.parametrize(("stated", "within"), [("0.8 mm", 0.2), ("0.1 mm", 0.2), ("5 mm", 1.0)])
def test_a_stated_noise_that_is_not_that_of_the_points_is_warned_of(load, stated, within):
    text = ROUTE + f"path_smoothing = '{stated}'\n"
    study = load(text, r_csv=noisy_half_circle())
    assert bend_of(study) == pytest.approx(math.pi, abs=within)
    is_warned_of = f"not by the {stated} that path_smoothing says" in str(study.warnings)
    assert is_warned_of == (stated != "0.8 mm")


CORNER = "x,y,z\n0,0,0\n1,0,0\n1,1,0\n"


@pytest.mark.parametrize("smoothing", ["", "path_smoothing = '1 mm'\n"])
def test_smoothing_silences_no_warning_of_a_coarse_route(load, smoothing):
    study = load(ROUTE + smoothing, r_csv=CORNER)
    assert any("turns by 90 deg at one way-point" in warning for warning in study.warnings)
    assert bend_of(study) == pytest.approx(math.pi / 2)
    assert study.uncertain["sheath.bend_angle"].reach[1] > math.pi


def test_a_route_that_no_sheath_follows_is_refused(load):
    steps = np.arange(1100)
    turn = 0.1 * steps
    helix = csv_text("x,y,z", np.cos(turn), np.sin(turn), 0.001 * steps)
    with pytest.raises(InputError, match=r"bends by 109\.[89]\d* rad, expected 100 at most"):
        load(ROUTE, r_csv=helix)


# --- Warnings of numbers --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value", "understood"),
    [
        ("arm.a1", 40, "arm.a1 = 40 is 40 m"),
        (
            "tendon.youngs_modulus",
            [145e9, 145e3],
            "tendon.youngs_modulus item 2 = 145000 is 145000 Pa",
        ),
        (
            "spring.flexor.stiffness",
            {"from": 3, "to": 300, "num": 3},
            "spring.flexor.stiffness from = 3 is 3 N/m",
        ),
        ("motion.speed", 60, "motion.speed = 60 is 60 rad/s"),
        ("limits.max_tension", "300 kN", "limits.max_tension = 300000 is 300000 N"),
    ],
)
def test_a_number_far_from_any_arm_is_shown_as_it_was_understood(key, value, understood):
    (warning,) = study_with(key, value).warnings
    assert warning.startswith(f"{understood}, far from any arm")


def test_a_strange_number_of_a_case_and_a_distribution_that_is_cut_off_are_warned_of():
    case = {"name": "a", "arm": {"a1": 40}}
    mass = {"mean": "1 kg", "std": "1 kg"}
    content = {"load": {"mass": mass}, "cases": [case], "allow_implausible": True}
    cut, strange = study_from(content).warnings
    assert strange.startswith("cases.0.arm.a1 = 40 is 40 m")
    assert "15.9% of its distribution is cut off" in cut
    unusual = study_from({"arm": {"a1": 0.3, "b1": [0.01, 0.6]}, "load": {"mass": 100}})
    assert unusual.warnings == ()


def test_relative_paths_are_relative_to_the_study(tmp_path, monkeypatch):
    path = tmp_path / "deep" / "study.toml"
    path.parent.mkdir()
    path.write_text("[sheath]\npath = '../r.csv'\n")
    (tmp_path / "r.csv").write_text(half_circle())
    monkeypatch.chdir("/")
    assert bend_of(load_study(path)) == pytest.approx(math.pi, rel=1e-4)


# --- Fitted friction ------------------------------------------------------------------------------

FRAGMENT = "[friction]\ncoefficient = 0.073\nstandard_error = 0.002\nsource = 'readings.csv'\n"


def test_a_fragment_gives_the_friction_and_is_remembered(load):
    study = load("[sheath]\nfriction_from = 'f.toml'\n", f_toml=FRAGMENT)
    assert study.sheath.friction.single == 0.073
    assert study.numbers["sheath.friction"].single == 0.073
    assert "friction_from" not in study.document()["sheath"]
    (source,) = study.sources.values()
    assert source["standard_error"] == 0.002
    assert source["fitted_from"] == "readings.csv"
    assert source["file"] == "f.toml"
    assert study.hash == study_with("sheath.friction", {"mean": 0.073, "std": 0.002}).hash


def test_a_setting_may_name_a_fragment_and_one_of_one_side_leaves_the_other(load):
    study = load("", "sheath.extensor.friction_from=f.toml", f_toml=FRAGMENT)
    assert study.numbers["sheath.friction"].single == 0.07
    assert study.numbers["sheath.extensor.friction"].single == 0.073
