"""`tendon plot`, as it is called: which table it takes, what it writes, and what it refuses."""

import json
import math
import re

import matplotlib.image
import pytest

import tendon_cli as tendon_library

PERSONS = """
[[cases]]
name = "small"
arm = { b1 = "140 mm" }
[[cases]]
name = "tall"
tendon = { extensor = { pretension = "90 N" } }

[tendon]
pretension = ["80 N", "120 N", "160 N"]

[load]
mass = "5 kg"
"""


@pytest.fixture
def run_folder(tendon, workplace):
    (workplace / "persons.toml").write_text(PERSONS)
    assert tendon("sweep", "persons.toml", "--out", "run", "--no-figures").exit == 0
    return workplace / "run"


def figures(ran):
    """Return the figures that a command wrote, having ended well."""
    assert (ran.exit, ran.err) == (0, "")
    return ran.json["figures"]


def test_a_run_folder_gives_its_states_unless_told_otherwise(tendon, run_folder, workplace):
    one_case = ("--where", "case = small", "--json")
    figures(tendon("plot", run_folder, "--out", "folder.svg", *one_case))
    figures(tendon("plot", run_folder / "states.parquet", "--out", "states.svg", *one_case))
    drawn = [(workplace / name).read_text("utf-8") for name in ("folder.svg", "states.svg")]
    # The layout solves for places, which may differ by a rounding, as then do the names of what
    # clips there: matplotlib makes them from the places.
    drawn = [re.sub(r"(\d)\.\d+", r"\1", text) for text in drawn]
    of_folder, of_states = (re.sub(r"\bp[0-9a-f]{10}\b", "clip", text) for text in drawn)
    assert of_folder == of_states


@pytest.mark.parametrize(
    ("words", "drawn"),
    [
        # An axis that a case overrides on one side is still one.
        ("run --table designs --out map.png", "map.png"),
        ("run --quantity required_pretension --x case --out lines.pdf", "lines.pdf"),
        ("--arm persons.toml --angle 30deg --angle 1rad", "persons-arm.png"),
    ],
)
def test_what_is_asked_for_is_drawn(tendon, run_folder, blank_figures, words, drawn):
    assert figures(tendon("plot", *words.split(), "--json")) == [drawn]


ANSWER = """
[spring]
stiffness = ["2 kN/m", "5 kN/m"]
[spool]
ratio = [0.6, 0.8]
[motion]
elbow_angle = { from = "0 deg", to = "90 deg", num = 4 }
"""


def test_an_answer_gives_the_figures_that_design_drew(tendon, workplace):
    (workplace / "suit.toml").write_text(ANSWER)
    assert tendon("design", "suit.toml", "--out", "answer").exit == 0
    first = json.loads((workplace / "answer" / "design.json").read_text())["figures"]
    assert len(first) > 1
    drawn = figures(tendon("plot", "answer", "--json"))
    assert drawn == [f"suit-{name}" for name in first]
    for name in first:
        again = matplotlib.image.imread(workplace / f"suit-{name}")
        assert (again == matplotlib.image.imread(workplace / "answer" / name)).all()
    refused = tendon("plot", "answer", "--out", "one.png")
    assert (refused.exit, f"{len(first)} figures" in refused.err) == (2, True)
    assert not (workplace / "one.png").exists()


SIDES = """
[sheath.flexor]
path = "front.csv"
path_smoothing = "1 mm"
[sheath.extensor]
path = "back.csv"
[[cases]]
name = "small"
arm = { b1 = "140 mm" }
sheath = { extensor = { path = "short.csv" } }
"""


def test_sheaths_of_either_side_and_of_a_case_are_drawn(tendon, workplace, write_study):
    for name, last in (("front", 0.2), ("back", 0.3), ("short", 0.1)):
        (workplace / f"{name}.csv").write_text(
            f"x,y,z\n0,0,0\n0.1,0,0\n0.2,0.1,0\n0.2,{last},0.1\n0.3,{last},0.1\n"
        )
    write_study(SIDES)
    command = ("plot", "--arm", "study.toml", "--json", "--out", "arm.svg", "--case", "small")
    drawn = figures(tendon(*command))
    assert drawn == ["arm.svg", "arm-route-flexor.svg", "arm-route-extensor.svg"]
    flexor = (workplace / "arm-route-flexor.svg").read_text()
    extensor = (workplace / "arm-route-extensor.svg").read_text()
    assert "Route of the flexor sheath: front.csv" in flexor
    assert "smoothed for a noise of 1 mm" in flexor
    assert "short.csv" in extensor
    assert "smoothed" not in extensor
    assert "b₁ = 140 mm" in (workplace / "arm.svg").read_text()


def test_a_route_is_drawn_with_the_angle_of_a_setting(tendon, workplace, write_study):
    for name, end in (("route", 0.2), ("other", 0.4)):
        (workplace / f"{name}.csv").write_text(f"x,y,z\n0,0,0\n0.1,0,0\n0.2,0.1,0\n0.2,{end},0.1\n")
    write_study('[sheath]\npath = "route.csv"\n')
    (workplace / "other.toml").write_text('[sheath]\npath = "other.csv"\n')
    command = ("plot", "--arm", "study.toml", "--json", "--out", "arm.svg")
    drawn = figures(tendon(*command, "--set", "sheath.path=other.csv"))
    assert drawn == ["arm.svg", "arm-route.svg"]
    angle = tendon_library.study("other.toml").sheath.bend_angle.single
    drawn = (workplace / "arm-route.svg").read_text()
    assert f"φ = {math.degrees(angle):.4g} deg" in drawn
    assert "other.csv" in drawn


def test_an_option_that_a_figure_has_no_use_for_is_refused(tendon, workplace, write_study):
    study = write_study('[load]\nmass = "5 kg"\n')
    assert tendon("design", study, "--no-figures", "--out", "answer").exit == 0
    for source, words, option in (
        (study, ("--arm", "--size", "column"), "--size"),
        (study, ("--arm", "-y", "motor_torque"), "--quantity"),
        (study, ("--arm", "--format", "svg"), "--format"),
        ("answer", ("--between", "--size", "column"), "--size"),
        ("answer", ("--size", "column"), "--size"),
    ):
        ran = tendon("plot", source, *words)
        assert ran.exit == 2
        assert option in ran.err
        assert "no use" in ran.err
        assert not list(workplace.glob("*.png"))


def test_a_column_of_nulls_is_told_without_a_filter_that_nobody_gave(workplace):
    motion = {
        "speed": "60 deg/s",
        "elbow_angle": {"from": "0 deg", "to": "170 deg", "num": 5},
    }
    run = tendon_library.sweep({"load": {"mass": ["0 kg", "5 kg"]}, "motion": motion})
    assert run.designs["efficiency"].isna().all()
    with pytest.raises(
        tendon_library.UsageError, match="no row of the table has a value of eff"
    ) as raised:
        run.plot("efficiency")
    assert "--where" not in f"{raised.value} {raised.value.hint}"
    with pytest.raises(tendon_library.UsageError, match="no selected row has a value") as raised:
        run.plot("efficiency", where="load_mass >= 0 kg")
    assert raised.value.where == "--where"


def test_an_answer_without_a_window_is_told_to_have_none(tendon, workplace):
    asked = {"limits": {"max_tension": "1 N"}, "motion": {"elbow_angle": "60 deg"}}
    assert not tendon_library.design(asked, "answer").feasible
    told = tendon("plot", "--between", "answer").err
    assert "the answer has no window" in told
    assert "--overwrite" not in told
