"""The commands as people first meet them: help, version, a starter study, one state, the schema."""

import re
from concurrent.futures import ThreadPoolExecutor

import pytest
import typer

from tendon_cli import cli
from tendon_cli.studies.load import load_study, study_from
from tendon_cli.version import __version__

COMMANDS = typer.main.get_command(cli.app).commands


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_and_the_list_shows_its_whole_first_sentence(tendon, command):
    listed = tendon("--help")
    assert (listed.exit, listed.err, tendon("-h").out) == (0, "", listed.out)
    assert " ".join(COMMANDS[command].help.split("\n\n")[0].split()) in " ".join(listed.out.split())
    ran = tendon(command, "--help")
    assert (ran.exit, ran.err, tendon(command, "-h").out) == (0, "", ran.out)
    assert ran.out.startswith("Usage: tendon " + command)
    assert "{" not in ran.out.splitlines()[0]


@pytest.mark.parametrize("python", [False, True], ids=["console script", "python -m tendon_cli"])
def test_both_ways_to_start_give_the_same(outside, tendon, python):
    words = ["-m", "tendon_cli"] if python else []
    assert outside(*words, "--version", python=python).out == f"tendon {__version__}\n"
    assert outside(*words, "sweep", "none.toml", "--json", python=python).exit == 2


# --- init -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [None, "mine.yml"])
def test_the_starter_runs_unchanged(tendon, workplace, name):
    assert tendon("init", *([name] if name else [])).exit == 0
    file = workplace / (name or "study.toml")
    assert len(re.findall(r"#", file.read_text(encoding="utf-8"))) > 10
    fewer = ("--set", "tendon.pretension=[90, 180]", "--set", "spring.stiffness=[2000, 3000]")
    ran = tendon("sweep", file, "--no-figures", "--json", *fewer)
    assert (ran.exit, ran.err, ran.json["name"]) == (0, "", file.stem)


def test_init_does_not_write_through_a_link(tendon, workplace):
    (workplace / "study.toml").symlink_to(workplace / "elsewhere.toml")
    assert tendon("init").exit == 2
    assert not (workplace / "elsewhere.toml").exists()


def test_of_many_inits_at_once_one_writes_the_starter(outside, workplace):
    with ThreadPoolExecutor(8) as pool:
        ended = list(pool.map(lambda _: outside("init", "mine.toml").exit, range(8)))
    assert sorted(ended) == [0, *[2] * 7]
    assert [file.name for file in workplace.iterdir()] == ["mine.toml"]
    assert load_study(workplace / "mine.toml").name == "mine"


# --- state ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "settings",
    [[], ["motion.elbow_angle=170 deg"], ["arm.forearm_mass=0 kg", "tendon.pretension=1 N"]],
)
def test_a_state_of_any_status_is_strict_json(tendon, workplace, settings):
    (workplace / "study.toml").write_text('[motion]\nelbow_angle = "75 deg"\n', encoding="utf-8")
    words = [word for setting in settings for word in ("--set", setting)]
    page = tendon("state", "study.toml", "--json", *words)
    assert page.exit in (0, 4)
    assert page.json["status"].split(":")[0] in ("taut", "no equilibrium", "both slack")


def test_a_state_is_a_row_of_the_table(tendon, workplace, new_sweep):
    text = (
        '[tendon]\npretension = "70 N"\n[motion]\nelbow_angle = "40 deg"\ndirection = "flexion"\n'
    )
    row = new_sweep(text, workplace).states.iloc[0]
    results = tendon("state", "study.toml", "--json").json["results"]
    assert {name: row[name] for name in results} == results


def test_a_state_of_a_case_is_chosen_by_name(tendon, workplace):
    text = '[[cases]]\nname = "a"\nload = { mass = "1 kg" }\n[[cases]]\nname = "b"\nload = { mass = "9 kg" }\n'
    (workplace / "study.toml").write_text(
        text + '[motion]\nelbow_angle = "1 rad"\n', encoding="utf-8"
    )
    a, b = (
        tendon("state", "study.toml", "--case", name, "--json").json["results"] for name in "ab"
    )
    assert b["elbow_torque"] > a["elbow_torque"]


@pytest.mark.parametrize(
    ("setting", "content"),
    [
        ("arm.b1=160 mm", {"arm": {"b1": 0.16}}),
        ('arm.b1="160 mm"', {"arm": {"b1": 0.16}}),
        ("sheath.friction=0.1", {"sheath": {"friction": 0.1}}),
        ('load.mass=["3 kg","5 kg"]', {"load": {"mass": [3, 5]}}),
        ('load.mass=["500 g", 2]', {"load": {"mass": [0.5, 2]}}),
        (
            "load.mass={ from = 1, to = 2, num = 3 }",
            {"load": {"mass": {"from": 1, "to": 2, "num": 3}}},
        ),
        ("tendon.flexor.pretension=90 N", {"tendon": {"flexor": {"pretension": 90}}}),
        ("model.slack=bilateral", {"model": {"slack": "bilateral"}}),
        ("name=other", {"name": "other"}),
        ('output.tables=["designs"]', {"output": {"tables": ["designs"]}}),
    ],
)
def test_a_setting_is_what_the_study_would_say(workplace, setting, content):
    (workplace / "study.toml").write_text("", encoding="utf-8")
    assert load_study("study.toml", [setting]).hash == study_from({"name": "study"} | content).hash
