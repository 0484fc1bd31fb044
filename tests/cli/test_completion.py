"""Completion offers what exists: to a question as shells ask it, and typed into real shells."""

import os
import pty
import select
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
import typer

import tendon_cli
from tendon_cli.commands import cli
from tendon_cli.quantities import OF_DESIGNS, OF_STATES
from tendon_cli.studies.json_schema import key_words
from tendon_cli.studies.load import study_from
from tendon_cli.studies.study import keys
from tests.sampled import quick_and_torture

APP = typer.main.get_command(cli.app)
PROGRAMS = Path(sys.executable).parent
PEOPLE = """\
name,weight (kg),stature (cm)
Ada Lovelace,62.5,168
Bo,90,181.5
Eve\x1b[2J,70,170
"""
OWN_STUDY = """\
[people]
file = "people.csv"
[[cases]]
name = "Bo's arm"
[[cases]]
name = "$(touch executed)"
"""
FILES = {
    "study.toml": "",
    "people.csv": PEOPLE,
    "own.toml": OWN_STUDY,
    "torn.parquet": "PAR1 and no more PAR1",
    "bad.csv": "\0",
}
CASES = ["Bo's arm", "$(touch executed)"]
TIMEOUT = 20  # s, of a shell on a terminal


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a study of people and cases, a run, an answer, and files of no table."""
    folder = tmp_path_factory.mktemp("made")
    for name, content in FILES.items():
        (folder / name).write_text(content, encoding="utf-8")
    os.mkfifo(folder / "pipe")
    (folder / "empty.parquet").mkdir()
    tendon_cli.sweep({}, folder / "run")
    tendon_cli.design({"spring": {"stiffness": ["3 kN/m", "5 kN/m"]}}, folder / "answer")
    return folder


@pytest.fixture
def offered(completed, folder, monkeypatch):
    """Return a function that returns what is offered at the end of a line after `tendon`."""
    monkeypatch.chdir(folder)
    return lambda line: [" ".join(shlex.split(word)) for word in completed(f"tendon {line}")]


@pytest.mark.parametrize("name", APP.commands)
def test_every_command_and_every_option_is_offered(offered, name):
    options = {"--help"}
    for parameter in APP.commands[name].params:
        options |= {option for option in parameter.opts if option.startswith("--")}
    assert set(offered(f"{name} --")) >= options
    assert name in offered(name[:2])


def test_a_value_that_is_offered_is_taken(tmp_path):
    excursion = tmp_path / "excursion.csv"
    excursion.write_text(
        "angle (deg),flexor (mm),extensor (mm)\n-30,-10,-10\n0,0,0\n60,20,20\n150,50,50\n"
    )
    booleans = {"true": True, "false": False}
    checked = 0
    for key, (_, values) in key_words().items():
        *tables, name = key.split(".")
        for value in values:
            content = {name: booleans.get(value, value)}
            for table in reversed(tables):
                content = {table: content}
            if key == "design.by":
                content["people"] = {}
            if key == "joint.scale_with":  # of travels that were measured
                content["joint"]["excursion"] = str(excursion)
            if key == "setting.read":  # by the torque of the motor, too, which a ratio of 1 hides
                content["spool"] = {"ratio": 0.6}
            if key == "joint.stiffness_with":  # of persons, whose stiffness differs
                content["joint"] |= {"stiffness": "1.1 N m/rad", "rest_angle": "73 deg"}
                content["people"] = {}
            study_from(content)
            checked += 1
    assert checked > 10


SLACK = ["unilateral", "bilateral"]
"""Values behind the sign at which bash takes a word apart."""
STIFFNESS = ["spring.stiffness=", "spring.stiffness=rigid"]
PERSONS = ["mean-man", "mean-woman", "Ada Lovelace", "Bo", "Eve?[2J"]  # no raw escape


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("sw", ["sweep"]),
        ("--ver", ["--version"]),
        ("--debug sw", ["sweep"]),
        ("sweep --dry", ["--dry-run"]),
        ("sweep a.toml --set model.slack=", SLACK),
        ("sweep --set model.slack=u", SLACK[:1]),
        ("sweep --set 'model.slack=u", ["model.slack=unilateral"]),
        ("sweep --set spring.stiff", STIFFNESS),
        ("sweep --set spring.stiffness=", ["rigid"]),
        ("sweep --set arm.forearm_m", ["arm.forearm_mass=", "arm.forearm_mass=..."]),
        ("sweep --set arm.forearm_mass=", []),
        ("plot r --format s", ["svg"]),
        ("show r --columns margin,max_t", ["margin,max_tension", "margin,max_torque_band"]),
        ("show run --table states --columns elbow_s", ["elbow_stiffness"]),
        ("show run --where 'elbow_s", []),
        ("plot run -y mo", ["motor_torque"]),
        ("plot run --panels load_m", ["load_mass"]),
        ("plot run --table designs -y elbow_s", []),
        ("plot answer -x from_b", ["from_by"]),
        ("show answer --sort toleran", ["tolerance", "tolerance_length"]),
        ("export answer --columns from_by,served_a", ["from_by,served_at"]),
        ("export answer --table ", ["choices", "conditions"]),
        ("show people.csv --columns ", ["name", "weight", "stature"]),
        ("show pipe --columns marg", ["margin"]),
        ("show torn.parquet --columns marg", ["margin"]),
        ("show bad.csv --columns marg", ["margin"]),
        ("show empty.parquet --columns marg", ["margin"]),
        ("show . --columns marg", ["margin"]),
        ("show missing --columns marg", ["margin"]),
        ("state own.toml --case ", CASES),
        ("plot --arm own.toml --case B", CASES[:1]),
        ("state pipe --case ", []),
        ("state own.toml --person ", PERSONS),
        ("state missing.toml --person ", ["mean-man", "mean-woman"]),
        ("sweep ", []),
        ("sweep --out ", []),
        ("swep x", []),
        ("sweep \"a'b", []),
    ],
)
def test_what_is_offered(offered, line, expected):
    assert offered(line) == expected


@pytest.mark.parametrize(
    "option", ["show r --columns", "show r --sort", "show r --where", "plot r -y", "plot r --x"]
)
def test_without_a_table_every_column_is_offered(offered, option):
    assert {*OF_DESIGNS, *OF_STATES, "load_mass"} <= set(offered(f"{option} "))
    assert {f"{key}=" for key in keys()} <= set(offered("sweep --set "))


@pytest.mark.parametrize("quote", ["", "'", '"'])
def test_bash_runs_nothing_of_a_name(completed, folder, monkeypatch, quote):
    monkeypatch.chdir(folder)
    names = completed(f"tendon state own.toml --case {quote}")
    script = "\n".join(f"printf '%s\\n' {quote}{name}{quote}" for name in names)
    echoed = subprocess.run(["bash", "-c", script], check=True, capture_output=True, text=True)
    assert echoed.stdout.splitlines() == CASES
    assert not Path("executed").exists()


def type_into(shell, setup, line, expected):
    """Return the text that a shell on its own terminal shows after a line and a tab.

    Reading ends as soon as the expected text is shown, at the latest after `TIMEOUT`.
    """
    process, terminal = pty.fork()
    if process == 0:
        os.environ |= {"PATH": f"{PROGRAMS}:{os.environ['PATH']}", "PS1": "> ", "TERM": "dumb"}
        os.execvp(shell[0], shell)  # noqa: S606 - it is the shell that is tried
    shown = ""
    is_sent = False
    deadline = time.monotonic() + TIMEOUT
    try:
        os.write(terminal, f"{setup}; echo rea''dy\n".encode())
        while time.monotonic() < deadline:
            if is_sent and expected in shown:
                break
            readable, _, _ = select.select([terminal], [], [], 0.1)
            if readable:
                output = os.read(terminal, 65536).decode(errors="replace")
                shown += output.replace("\a", "")
            is_ready = "ready" in shown.replace("rea''dy", "")
            if is_ready and not is_sent:
                shown = ""
                is_sent = True
                os.write(terminal, line.encode() + b"\t")
    finally:
        os.close(terminal)
        os.kill(process, 9)
        os.waitpid(process, 0)
    return shown


SETUP = 'eval "$(tendon --show-completion)"'
SHELLS = {
    "bash": (["bash", "--norc", "--noprofile", "-i"], SETUP),
    "zsh": (["zsh", "-f", "-i"], f"autoload -U compinit; compinit -u -D; {SETUP}"),
}


TYPED = [
    ("tendon sweep --set model.slack=b", "model.slack=bilateral"),
    ("tendon sweep stu", "study.toml"),
    ("tendon state own.toml --person Ad", "Ada\\ Lovelace"),
    ("tendon state own.toml --person 'Ad", "'Ada Lovelace'"),
]
MORE_TYPED = [
    ("tendon swe", "tendon sweep "),
    ("tendon sweep --set model.sl", "model.slack="),
    ("tendon state own.toml --person Ada\\ Lo", "Ada\\ Lovelace"),
    ("tendon show people.csv --sort sta", "stature"),
]


@pytest.mark.parametrize("name", SHELLS)
@pytest.mark.parametrize(("line", "expected"), quick_and_torture(TYPED, MORE_TYPED))
def test_a_real_shell_completes(folder, monkeypatch, name, line, expected):
    monkeypatch.chdir(folder)
    if shutil.which(name) is None:
        pytest.skip(f"there is no {name} here")
    command, setup = SHELLS[name]
    assert expected in type_into(command, setup, line, expected)


FISH_COMPLETES = {
    "tendon swe": "sweep",
    "tendon sweep --set model.slack=b": "model.slack=bilateral",
    "tendon show r --sort required_p": "required_pretension",
    "tendon sweep stu": "study.toml",
    'tendon state own.toml --person "Ad': "Ada Lovelace",
}


def test_fish_completes(folder, monkeypatch):
    monkeypatch.chdir(folder)
    if shutil.which("fish") is None:
        pytest.skip("there is no fish here")
    commands = ["tendon --show-completion | source"]
    commands += [f"complete -C '{line}'" for line in FISH_COMPLETES]
    environment = os.environ | {"PATH": f"{PROGRAMS}:{os.environ['PATH']}", "HOME": str(Path.cwd())}
    ran = subprocess.run(
        ["fish", "-c", "; ".join(commands)],
        check=True,
        capture_output=True,
        text=True,
        env=environment,
        timeout=60,
    )
    completed = [entry.partition("\t")[0] for entry in ran.stdout.splitlines()]
    assert completed == list(FISH_COMPLETES.values())
