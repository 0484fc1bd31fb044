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

import tendon_cli
from tendon_cli import cli
from tendon_cli.commands.completion import candidates, split_line
from tendon_cli.quantities import OF_DESIGNS, OF_STATES
from tendon_cli.studies.json_schema import key_words
from tendon_cli.studies.load import study_from
from tendon_cli.studies.study import keys

APP = typer.main.get_command(cli.app)
PROGRAMS = Path(sys.executable).parent
FILES = {
    "study.toml": "",
    "people.csv": "name,weight (kg),stature (cm)\nAda Lovelace,62.5,168\nBo,90,181.5\nEve\x1b[2J,70,170\n",
    "own.toml": '[people]\nfile = "people.csv"\n[[cases]]\nname = "Bo\'s arm"\n[[cases]]\nname = "$(touch executed)"\n',
    "torn.parquet": "PAR1 and no more PAR1",
    "bad.csv": "\0",
}
CASES = ["Bo's arm", "$(touch executed)"]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a study of people and cases, a run, an answer, and what is no table."""
    folder = tmp_path_factory.mktemp("made")
    for name, content in FILES.items():
        (folder / name).write_text(content, encoding="utf-8")
    os.mkfifo(folder / "pipe")
    (folder / "empty.parquet").mkdir()
    tendon_cli.sweep({}, folder / "run")
    tendon_cli.design({"spring": {"stiffness": ["3 kN/m", "5 kN/m"]}}, folder / "answer")
    return folder


@pytest.fixture(autouse=True)
def there(made, monkeypatch):
    monkeypatch.chdir(made)


def offered(line):
    words, begun, _ = split_line(f"tendon {line}")
    return [word for word, _ in candidates(APP, words, begun)]


@pytest.mark.parametrize("name", APP.commands)
def test_every_command_and_every_option_is_offered(name):
    options = {
        opt
        for parameter in APP.commands[name].params
        for opt in parameter.opts
        if opt.startswith("--")
    }
    assert set(offered(f"{name} --")) >= options | {"--help"}
    assert name in offered("")


def test_a_value_that_is_offered_is_taken(tmp_path):
    excursion = tmp_path / "excursion.csv"
    excursion.write_text(
        "angle (deg),flexor (mm),extensor (mm)\n-30,-10,-10\n0,0,0\n60,20,20\n150,50,50\n"
    )
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
    ("line", "expected"),
    [
        ("sw", ["sweep"]),
        ("--ver", ["--version"]),
        ("--debug sw", ["sweep"]),
        ("sweep --dry", ["--dry-run"]),
        (
            "sweep a.toml --set model.slack=",
            ["model.slack=", "model.slack=unilateral", "model.slack=bilateral"],
        ),
        ("sweep --set 'model.slack=u", ["model.slack=unilateral"]),
        ("plot r --format s", ["svg"]),
        ("completion f", ["fish"]),
        ("show r --columns margin,max_t", ["margin,max_tension", "margin,max_torque_band"]),
        ("show r --sort -margi", ["-margin"]),
        ("show run --table states --columns elbow_s", ["elbow_stiffness"]),
        ("show run --where 'elbow_s", []),
        ("show answer --sort -toleran", ["-tolerance", "-tolerance_length"]),
        ("export answer --columns from_by,serv", ["from_by,served", "from_by,served_at"]),
        ("export answer --table ", ["choices", "conditions"]),
        ("show people.csv --columns ", ["name", "weight", "stature"]),
        *(
            (f"show {source} --columns marg", ["margin"])
            for source in ("pipe", "torn.parquet", "bad.csv", "empty.parquet", ".", "missing")
        ),
        ("state own.toml --case ", CASES),
        ("plot --arm own.toml --case B", CASES[:1]),
        ("state pipe --case ", []),
        (
            "state own.toml --person ",
            ["mean-man", "mean-woman", "Ada Lovelace", "Bo", "Eve?[2J"],
        ),  # harmless
        ("state missing.toml --person ", ["mean-man", "mean-woman"]),
        *((line, []) for line in ("sweep ", "sweep --out ", "swep --", "sweep \"a'b")),
    ],
)
def test_what_is_offered(line, expected):
    assert offered(line) == expected


@pytest.mark.parametrize(
    "option", ["show r --columns", "show r --sort", "show r --where", "plot r -y", "plot r --x"]
)
def test_without_a_table_every_column_is_offered(option):
    assert {*OF_DESIGNS, *OF_STATES, "load_mass"} <= set(offered(f"{option} "))
    assert {f"{key}=" for key in keys()} <= set(offered("sweep --set "))


@pytest.mark.parametrize("quote", ["", "'", '"'])
def test_bash_runs_nothing_of_a_name(outside, made, quote):
    names = outside(
        "completion", "bash", "--line", f"tendon state own.toml --case {quote}", cwd=made
    ).out
    script = "\n".join(f"printf '%s\\n' {quote}{name}{quote}" for name in names.splitlines())
    echoed = subprocess.run(["bash", "-c", script], check=True, capture_output=True, text=True)
    assert echoed.stdout.splitlines() == CASES
    assert not (made / "executed").exists()
    assert not Path("executed").exists()


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
    "zsh": (
        ["zsh", "-f", "-i"],
        'autoload -U compinit; compinit -u -D; eval "$(tendon completion zsh)"',
    ),
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
        ("tendon state own.toml --person 'Ad", "'Ada Lovelace'"),
        ("tendon state own.toml --person Ada\\ Lo", "Ada\\ Lovelace"),
        ("tendon show people.csv --sort sta", "stature"),
    ],
)
def test_a_real_shell_completes(name, line, wanted):
    if shutil.which(name) is None:
        pytest.skip(f"there is no {name} here")
    command, setup = SHELLS[name]
    assert wanted in typed(command, setup, line, wanted)


def test_fish_completes():
    if shutil.which("fish") is None:
        pytest.skip("there is no fish here")
    lines = (
        "tendon swe",
        "tendon sweep --set model.slack=b",
        "tendon show r --sort required_p",
        "tendon sweep stu",
    )
    lines += ('tendon state own.toml --person "Ad',)
    asked = "; ".join(
        ["tendon completion fish | source", *(f"complete -C '{line}'" for line in lines)]
    )
    environment = os.environ | {"PATH": f"{PROGRAMS}:{os.environ['PATH']}", "HOME": str(Path.cwd())}
    ran = subprocess.run(
        ["fish", "-c", asked],
        check=True,
        capture_output=True,
        text=True,
        env=environment,
        timeout=60,
    )
    completed = [entry.partition("\t")[0] for entry in ran.stdout.splitlines()]
    assert completed == [
        "sweep",
        "model.slack=bilateral",
        "required_pretension",
        "study.toml",
        "Ada Lovelace",
    ]
