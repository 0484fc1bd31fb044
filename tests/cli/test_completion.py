"""Completion: what is offered is what there is, asked as a shell asks, and typed into real shells."""

import os
import pty
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
import typer

from tendon_cli import cli
from tendon_cli.commands.completion import candidates, split_line
from tendon_cli.quantities import OF_DESIGNS, OF_STATES
from tendon_cli.studies.load import study_from
from tendon_cli.studies.schema import key_words
from tendon_cli.studies.study import keys

APP = typer.main.get_command(cli.app)
PROGRAMS = Path(sys.executable).parent


def offered(line):
    words, begun, _ = split_line(line)
    return [word for word, _ in candidates(APP, words, begun)]


def test_every_command_is_offered():
    assert set(offered("tendon ")) == set(APP.commands)


@pytest.mark.parametrize("name", APP.commands)
def test_every_option_is_offered(name):
    options = {opt for parameter in APP.commands[name].params for opt in parameter.opts if opt.startswith("--")}
    assert set(offered(f"tendon {name} --")) >= options | {"--help"}


def test_every_number_of_a_study_can_be_set():
    assert {f"{key}=" for key in keys()} <= set(offered("tendon sweep --set "))


def test_a_value_that_is_offered_is_taken(tmp_path):
    excursion = tmp_path / "excursion.csv"
    excursion.write_text("angle (deg),flexor (mm),extensor (mm)\n-30,-10,-10\n0,0,0\n60,20,20\n150,50,50\n")
    checked = 0
    for key, (_, values) in key_words().items():
        *tables, name = key.split(".")
        for value in values:
            content = {name: {"true": True, "false": False}.get(value, value)}
            for table in reversed(tables):
                content = {table: content}
            if key == "design.by":
                content["people"] = {}
            if key == "joint.scale_with":  # of travels that were measured
                content["joint"]["excursion"] = str(excursion)
            study_from(content)
            checked += 1
    assert checked > 10


@pytest.mark.parametrize(
    "line", ["show run --columns ", "show run --sort ", "show run --where '", "plot run -y ", "plot run --quantity "]
)
def test_columns_are_offered(line):
    assert {*OF_DESIGNS, *OF_STATES, "load_mass"} <= set(offered(f"tendon {line}"))


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("tendon sw", ["sweep"]),
        ("tendon sweep --dry", ["--dry-run"]),
        ("tendon sweep a.toml --set model.slack=", ["model.slack=", "model.slack=unilateral", "model.slack=bilateral"]),
        ("tendon sweep --set 'model.slack=u", ["model.slack=unilateral"]),
        ("tendon sweep --set=arm.b1", ["--set=arm.b1="]),
        ("tendon show r --columns margin,max_t", ["margin,max_tension", "margin,max_torque_band"]),
        ("tendon show r --sort -margi", ["-margin"]),
        ("tendon plot r --format s", ["svg"]),
        ("tendon completion f", ["fish"]),
        ("tendon --ver", ["--version"]),
        ("tendon --debug sw", ["sweep"]),
        ("tendon sweep ", []),
        ("tendon sweep --out ", []),
        ("tendon swep --", []),
        ("tendon sweep \"a'b", []),
    ],
)
def test_what_is_offered(line, expected):
    assert offered(line) == expected


OWN = """
[load]
mass = ["0 kg", "5 kg"]
[people]
file = "people.csv"
[[cases]]
name = "Bo's arm"
[[cases]]
name = "$(touch run-by-bash)"
"""
PEOPLE = "name,weight (kg),stature (cm)\nAda Lovelace,62.5,168\nBo,90,181.5\n"


@pytest.fixture
def own(tendon, workplace):
    """A study with cases and people, its run, and its answer."""
    (workplace / "people.csv").write_text(PEOPLE, encoding="utf-8")
    (workplace / "own.toml").write_text(OWN, encoding="utf-8")
    assert tendon("sweep", "own.toml", "--no-figures", "--out", "run").exit == 0
    (workplace / "choose.toml").write_text('[spring]\nstiffness = ["3 kN/m", "5 kN/m"]\n', encoding="utf-8")
    assert tendon("design", "choose.toml", "--no-figures", "--out", "answer").exit == 0


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("tendon state own.toml --case ", ["Bo's arm", "$(touch run-by-bash)"]),
        ("tendon plot --arm own.toml --case B", ["Bo's arm"]),
        ("tendon state own.toml --person ", ["mean-man", "mean-woman", "Ada Lovelace", "Bo"]),
        ("tendon state missing.toml --person ", ["mean-man", "mean-woman"]),
        ("tendon show run --where 'person = A", ["person = Ada Lovelace"]),
        ("tendon show run --where 'case!=", ["case!=Bo's arm", "case!=$(touch run-by-bash)"]),
        ("tendon show run --where 'load_mass = ", ["load_mass = 0 kg", "load_mass = 5 kg"]),
        ("tendon show run --where 'feasible = f", ["feasible = false"]),
        ("tendon show run --table states --where 'direction in flexion, e", ["direction in flexion, extension"]),
        ("tendon show run --table states --columns elbow_s", ["elbow_stiffness"]),
        ("tendon show run --columns elbow_s", []),
        ("tendon show answer --sort -toleran", ["-tolerance", "-tolerance_length"]),
        ("tendon export answer --columns from_by,serv", ["from_by,served", "from_by,served_at"]),
        ("tendon export answer --table ", ["choices", "conditions"]),
        ("tendon show people.csv --columns ", ["name", "weight", "stature"]),
        ("tendon show people.csv --where 'name = B", ["name = Bo"]),
    ],
)
def test_own_names_and_columns_are_offered(own, line, expected):
    assert offered(line) == expected


def test_a_source_that_is_no_table_is_not_waited_for(workplace, tendon):
    os.mkfifo("pipe")
    Path("torn.parquet").write_bytes(b"PAR1 and no more PAR1")
    Path("bad.csv").write_bytes(b"\xff\0")
    Path("empty.parquet").mkdir()
    for source in ("pipe", "torn.parquet", "bad.csv", "empty.parquet", ".", "missing"):
        ran = tendon("completion", "fish", "--line", f"tendon show {source} --columns marg")
        assert (ran.exit, ran.out.split()[:1], ran.err) == (0, ["margin"], "")
        assert tendon("completion", "fish", "--line", f"tendon state {source} --case ").exit == 0


def test_no_sign_that_a_terminal_obeys_is_offered(workplace, tendon):
    Path("people.csv").write_text("name,weight (kg)\nAda\x1b[2J,60\nBo,70\n", encoding="utf-8")
    offered_names = tendon("completion", "fish", "--line", "tendon show people.csv --where 'name = ").out
    assert "name = Bo" in offered_names.splitlines()
    assert "\x1b" not in offered_names + tendon("show", "people.csv").out


@pytest.mark.parametrize("quote", ["", "'", '"'])
def test_bash_runs_nothing_of_a_name(own, tendon, quote):
    line = f"tendon state own.toml --case {quote}"
    names = tendon("completion", "bash", "--line", line).out.splitlines()
    echoed = subprocess.run(
        ["bash", "-c", "\n".join(f"printf '%s\\n' {quote}{name}{quote}" for name in names)],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    assert echoed.stdout.splitlines() == ["Bo's arm", "$(touch run-by-bash)"]
    assert not Path("run-by-bash").exists()


def typed(shell, setup, line, wanted):
    """What a shell on a terminal of its own shows after a line and a tab, until it shows what is wanted or 20 s."""
    process, terminal = pty.fork()
    if process == 0:
        os.environ |= {"PATH": f"{PROGRAMS}:{os.environ['PATH']}", "PS1": "> ", "TERM": "dumb"}
        os.execvp(shell[0], shell)  # noqa: S606 - it is the shell that is tried
    shown, end = "", time.monotonic() + 20
    try:
        os.write(terminal, f"{setup}; echo rea''dy\n".encode())
        sent = False
        while time.monotonic() < end and not (sent and wanted in shown):
            if select.select([terminal], [], [], 0.1)[0]:
                shown += os.read(terminal, 65536).decode(errors="replace").replace("\a", "")
            if not sent and "ready" in shown.replace("rea''dy", ""):
                shown, sent = "", True
                os.write(terminal, line.encode() + b"\t")
    finally:
        os.close(terminal)
        os.kill(process, 9)
        os.waitpid(process, 0)
    return shown


SHELLS = {
    "bash": (["bash", "--norc", "--noprofile", "-i"], 'eval "$(tendon completion bash)"'),
    "zsh": (["zsh", "-f", "-i"], 'autoload -U compinit; compinit -u -D; eval "$(tendon completion zsh)"'),
}


@pytest.mark.parametrize("name", SHELLS)
@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        ("tendon swe", "tendon sweep "),
        ("tendon sweep --set model.sl", "model.slack="),
        ("tendon sweep --set model.slack=b", "model.slack=bilateral"),
        ("tendon sweep stu", "study.toml"),
        ("tendon state own.toml --person Ad", "Ada\\ Lovelace"),
        ("tendon show people.csv --where 'name = Ad", "name = Ada Lovelace'"),
        ("tendon show people.csv --sort sta", "stature"),
    ],
)
def test_a_real_shell_completes(name, line, wanted, workplace):
    if shutil.which(name) is None:
        pytest.skip(f"there is no {name} here")
    (workplace / "study.toml").touch()
    (workplace / "own.toml").write_text('[people]\nfile = "people.csv"\n', encoding="utf-8")
    (workplace / "people.csv").write_text(PEOPLE, encoding="utf-8")
    command, setup = SHELLS[name]
    assert wanted in typed(command, f"cd {workplace}; {setup}", line, wanted)


def test_fish_completes(workplace):
    if shutil.which("fish") is None:
        pytest.skip("there is no fish here")
    (workplace / "study.toml").touch()
    (workplace / "people.csv").write_text(PEOPLE, encoding="utf-8")
    lines = ("tendon swe", "tendon sweep --set model.slack=b", "tendon show run --sort required_p", "tendon sweep stu")
    lines += ('tendon show people.csv --where "name = Ad',)
    asked = "; ".join(["tendon completion fish | source", *(f"complete -C '{line}'" for line in lines)])
    environment = os.environ | {"PATH": f"{PROGRAMS}:{os.environ['PATH']}", "HOME": str(workplace)}
    ran = subprocess.run(["fish", "-c", asked], check=True, capture_output=True, text=True, env=environment, timeout=60)
    completed = [entry.partition("\t")[0] for entry in ran.stdout.splitlines()]
    assert completed == ["sweep", "model.slack=bilateral", "required_pretension", "study.toml", "name = Ada Lovelace"]
