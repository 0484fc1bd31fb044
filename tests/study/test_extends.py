"""A study that extends another is the study that says it all in one file."""

import hashlib
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tendon_cli as tendon
from tendon_cli.errors import UsageError
from tendon_cli.studies.json_schema import key_words, schema_text
from tendon_cli.studies.load import recorded_study, study_from

ROUTE = "x (m),y (m),z (m)\n0,0,0\n0.1,0,0\n0.2,0.05,0\n0.3,0.15,0\n0.35,0.3,0\n"
STIFFNESSES = (
    '"3 kN/m"',
    '["3 kN/m", "5 kN/m"]',
    '{ from = "2 kN/m", to = "8 kN/m", num = 4 }',
    '{ value = "3 kN/m", tolerance = "10 %" }',
    '"4 kN/m +/- 0.2 kN/m"',
)
NUMBERS = {
    "spring.stiffness": STIFFNESSES,
    "spring.flexor.stiffness": STIFFNESSES,
    "load.mass": ('"3 kg"', '["0 kg", "5 kg"]', '{ from = "0 kg", to = "5 kg", num = 3 }'),
    "spool.ratio": ("0.6", "[0.6, 1.0]"),
    "sheath.friction": ("0.1", "{ mean = 0.08, std = 0.004 }"),
    "limits.max_tension": ('"300 N"', '"250 N"'),
}


def write(folder, **files):
    """Write text files, whose names end in .toml unless they say otherwise."""
    for name, text in files.items():
        path = folder / f"{name}.toml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def layer():
    """Return a strategy of some keys with values as TOML writes them."""
    choices = {key: st.sampled_from(values) for key, values in NUMBERS.items()}
    return st.fixed_dictionaries({}, optional=choices)


def toml_of(values):
    return "".join(f"{key} = {value}\n" for key, value in values.items())


@settings(max_examples=25)
@given(base=layer(), middle=layer(), top=layer())
def test_layers_are_one_study_with_the_uppermost_value_of_each_key(
    tmp_path_factory, base, middle, top
):
    folder = write(
        tmp_path_factory.mktemp("layers"),
        base=f'name = "base"\n{toml_of(base)}',
        middle=f'extends = "base.toml"\n{toml_of(middle)}',
        study=f'extends = "middle.toml"\n{toml_of(top)}',
        whole=f'name = "study"\n{toml_of(base | middle | top)}',
    )
    extended = tendon.study(folder / "study.toml")
    whole = tendon.study(folder / "whole.toml")
    assert extended.document() == whole.document()
    assert sorted(extended.axes) == sorted(whole.axes)


def test_axes_keep_the_order_of_the_base_and_new_ones_vary_faster(tmp_path):
    write(
        tmp_path,
        base='load.mass = ["0 kg", "3 kg"]\nspool.ratio = [0.6, 1.0]\nsheath.friction = 0.1\n',
        v2='extends = "base.toml"\nsheath.friction = [0.1, 0.2]\n'
        'spring.stiffness = ["3 kN/m", "5 kN/m"]\nload.mass = ["1 kg", "2 kg"]\n'
        "spool.ratio = 0.8\n",
    )
    study = tendon.study(tmp_path / "v2.toml")
    assert study.axes == ("load.mass", "sheath.friction", "spring.stiffness")


def test_a_study_of_three_lines_is_named_after_its_own_file(tmp_path):
    write(
        tmp_path,
        base='name = "first"\ntitle = "Suit"\nload.mass = ["0 kg", "3 kg"]\n',
        v2='extends = "base.toml"\n[spring]\nstiffness = "8 kN/m"\n',
    )
    study = tendon.study(tmp_path / "v2.toml")
    assert study.name == "v2"
    assert study.title == "Suit"
    assert study.spring.stiffness.array == [8000.0]
    assert study.axes == ("load.mass",)


def test_lists_of_tables_and_distributions_are_replaced_whole(tmp_path):
    write(
        tmp_path,
        base='[[cases]]\nname = "a"\narm.b1 = "120 mm"\n[[cases]]\nname = "b"\n'
        '[spring]\nstiffness = { from = "1 kN/m", to = "5 kN/m", num = 5 }\n',
        v2='extends = "base.toml"\n[[cases]]\nname = "c"\narm.b2 = "110 mm"\n'
        '[spring]\nstiffness = { mean = "3 kN/m", std = "0.1 kN/m" }\n',
    )
    study = tendon.study(tmp_path / "v2.toml")
    assert study.cases.names == ("c",)
    assert study.cases.keys == ("arm.b2",)
    assert study.uncertain.keys() == {"spring.stiffness"}


def test_paths_are_relative_to_the_file_that_names_them(tmp_path, monkeypatch):
    write(tmp_path / "lib", base='[sheath]\npath = "route.csv"\n')
    write(tmp_path / "mine", v2='extends = "../lib/base.toml"\n')
    write(tmp_path / "own", v3='extends = "../mine/v2.toml"\n[sheath]\npath = "bent.csv"\n')
    (tmp_path / "lib" / "route.csv").write_text(ROUTE)
    (tmp_path / "own" / "bent.csv").write_text(ROUTE.replace("0.3\n", "0.2\n"))
    lib = tendon.study(tmp_path / "lib" / "base.toml")
    mine = tendon.study(tmp_path / "mine" / "v2.toml")
    own = tendon.study(tmp_path / "own" / "v3.toml")
    assert mine.sheath.bend_angle.single == lib.sheath.bend_angle.single
    assert own.sources["sheath.path"]["file"] == "bent.csv"
    # A path of the command line is relative to the study, as it is without a base.
    (tmp_path / "mine" / "other.csv").write_text(ROUTE)
    there = tendon.study(tmp_path / "mine" / "v2.toml", ["sheath.path=other.csv"])
    assert there.sources["sheath.path"]["file"] == "other.csv"
    monkeypatch.chdir(tmp_path / "lib")
    from_python = tendon.study({"extends": "base.toml", "load": {"mass": "3 kg"}})
    assert from_python.sheath.bend_angle.single == lib.sheath.bend_angle.single


def test_a_setting_comes_last_and_may_name_another_base(tmp_path):
    write(
        tmp_path,
        base='[load]\nmass = "1 kg"\n',
        other='[load]\nmass = "4 kg"\n[spool]\nratio = 0.8\n',
        v2='extends = "base.toml"\n',
    )
    path = tmp_path / "v2.toml"
    assert tendon.study(path, ["load.mass=2 kg"]).load.mass.single == 2.0
    assert tendon.study(path, ["extends=other.toml"]).load.mass.single == 4.0
    both = tendon.study(path, ["load.mass=2 kg", "extends=other.toml"])
    assert (both.load.mass.single, both.spool.ratio.single) == (2.0, 0.8)
    with pytest.raises(UsageError, match="cannot extend"):
        both.vary(extends="base.toml")


def test_the_record_holds_the_whole_study_and_the_hash_of_both_files(tmp_path):
    write(tmp_path, base='[load]\nmass = "1 kg"\n', v2='extends = "base.toml"\n')
    run = tendon.sweep(tmp_path / "v2.toml", tmp_path / "run")
    record = json.loads((tmp_path / "run" / "run.json").read_text())
    assert record["study"]["load"]["mass"] == 1.0
    for key, name in (("study", "v2.toml"), ("extends", "base.toml")):
        content = (tmp_path / name).read_bytes()
        expected = {"file": name, "sha256": hashlib.sha256(content).hexdigest()}
        assert record["sources"][key] == expected
    assert recorded_study(record).hash == run.study.hash


def test_yaml_and_toml_extend_each_other(tmp_path):
    write(tmp_path, base='[load]\nmass = "1 kg"\n')
    (tmp_path / "v2.yaml").write_text("extends: base.toml\nspool: {ratio: 0.8}\n")
    write(tmp_path, v3='extends = "v2.yaml"\n')
    study = tendon.study(tmp_path / "v3.toml")
    assert (study.load.mass.single, study.spool.ratio.single) == (1.0, 0.8)


def test_schema_and_completion_know_the_key():
    assert "extends" in json.loads(schema_text())["properties"]
    assert "extends" in key_words()
    assert "extends" not in study_from({}).document()
