"""The commands as people first meet them: help, version, a starter study, one state, the schema."""

from concurrent.futures import ThreadPoolExecutor

import pytest
import typer

from tendon_cli.commands import cli
from tendon_cli.studies.load import load_study
from tendon_cli.version import __version__
from tests.cli.conftest import set_options

COMMANDS = typer.main.get_command(cli.app).commands


def test_every_command_has_help_and_the_list_shows_its_whole_first_sentence(tendon):
    listed = tendon("--help")
    assert (listed.exit, listed.err) == (0, "")
    assert tendon("-h").out == listed.out
    for command, declared in COMMANDS.items():
        first_sentence = declared.help.partition("\n\n")[0]
        assert " ".join(first_sentence.split()) in " ".join(listed.out.split())
        ran = tendon(command, "--help")
        assert (ran.exit, ran.err) == (0, "")
        assert tendon(command, "-h").out == ran.out
        assert ran.out.startswith("Usage: tendon " + command)
        assert "{" not in ran.out.splitlines()[0]


def test_both_ways_to_start_give_the_same(outside):
    assert outside("--version").out == outside("-V").out == f"tendon {__version__}\n"
    assert outside("-m", "tendon_cli", "sweep", "none.toml", "--json", python=True).exit == 2


def test_a_command_without_a_study_names_the_only_one_there_is(tendon, workplace):
    (workplace / "pyproject.toml").write_text('[project]\nname = "other"\n')
    assert tendon("sweep").err.endswith("hint: `tendon init` writes a study to start from\n")
    (workplace / "my suit.yml").write_text("load.mass: 3 kg\n")
    for command in ("state", "sweep", "design"):
        ran = tendon(command)
        assert ran.exit == 2
        hint = f"this folder has one: tendon {command} 'my suit.yml'"
        assert ran.err == f"tendon: error: Missing argument 'STUDY'.\n  hint: {hint}\n"
    (workplace / "other.toml").write_text("load.mass = 3\n")
    assert (
        tendon("sweep", "--json").json["error"]["hint"] == "studies here: my suit.yml, other.toml"
    )


@pytest.mark.parametrize(
    ("named", "there"),
    [("a.yaml", "a.yml"), ("a.yml", "a.toml"), ("a.toml", "a.yaml"), ("a", "a.toml")],
)
def test_a_missing_study_is_found_under_another_ending(tendon, workplace, named, there):
    for name in (there, "b.toml"):
        (workplace / name).touch()
    assert f"hint: did you mean {there}?" in tendon("state", named).err
    assert f"hint: files there: {there}, b.toml" in tendon("state", "c.toml").err


def test_every_command_that_writes_a_result_has_a_short_option_for_its_name():
    for command, declared in COMMANDS.items():
        named = [option.opts for option in declared.params if "--out" in option.opts]
        assert named in ([], [["--out", "-o"]]), command


# --- init -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "name"), [([], "study.toml"), (["mine.yml"], "mine.yml")], ids=["None", "mine.yml"]
)
def test_the_starter_runs_unchanged(tendon, workplace, words, name):
    assert tendon("init", *words).exit == 0
    file = workplace / name
    assert file.read_text(encoding="utf-8").count("#") > 10
    fewer = set_options("tendon.pretension=[90, 180]", "spring.stiffness=[2000, 3000]")
    ran = tendon("sweep", file, "--no-figures", "--json", *fewer)
    assert (ran.exit, ran.err) == (0, "")
    assert ran.json["name"] == file.stem


def test_init_does_not_write_through_a_link(tendon, workplace):
    (workplace / "study.toml").symlink_to(workplace / "elsewhere.toml")
    assert tendon("init").exit == 2
    assert not (workplace / "elsewhere.toml").exists()


def test_of_many_inits_at_once_one_writes_the_starter(outside, workplace):
    with ThreadPoolExecutor(4) as pool:
        ended = list(pool.map(lambda _: outside("init", "mine.toml").exit, range(4)))
    assert sorted(ended) == [0, 2, 2, 2]
    assert [file.name for file in workplace.iterdir()] == ["mine.toml"]
    assert load_study(workplace / "mine.toml").name == "mine"


# --- state ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "settings",
    [[], ["motion.elbow_angle=170 deg"], ["arm.forearm_mass=0 kg", "tendon.pretension=1 N"]],
)
def test_a_state_of_any_status_is_strict_json(tendon, write_study, settings):
    write_study('[motion]\nelbow_angle = "75 deg"\n')
    page = tendon("state", "study.toml", "--json", *set_options(*settings))
    assert page.exit in (0, 4)
    assert page.json["status"].split(":")[0] in ("taut", "no equilibrium", "both slack")


FLEXION_AT_40_DEGREES = """
[tendon]
pretension = "70 N"
[motion]
elbow_angle = "40 deg"
direction = "flexion"
"""


def test_a_state_is_a_row_of_the_table(tendon, workplace, new_sweep):
    row = new_sweep(FLEXION_AT_40_DEGREES, workplace).states.iloc[0]
    results = tendon("state", "study.toml", "--json").json["results"]
    assert {name: row[name] for name in results} == results


TWO_CASES = """
[[cases]]
name = "a"
load = { mass = "1 kg" }
[[cases]]
name = "b"
load = { mass = "9 kg" }
[motion]
elbow_angle = "1 rad"
"""


def test_a_state_of_a_case_is_chosen_by_name(tendon, write_study):
    write_study(TWO_CASES)
    light = tendon("state", "study.toml", "--case", "a", "--json").json["results"]
    heavy = tendon("state", "study.toml", "--case", "b", "--json").json["results"]
    assert heavy["elbow_torque"] > light["elbow_torque"]
