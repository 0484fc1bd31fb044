"""A task says what it is, and a registry dispatches: a third verb touches its own room alone."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import tendon_cli
from tendon_cli.engine.results import Result
from tendon_cli.engine.task import Task
from tendon_cli.verbs import registry
from tendon_cli.verbs.registry import TaskKind, kinds, load, table_kinds
from tests.conftest import Ran
from tests.shells import asked_by_bash
from tests.weigh import G

ROOT = Path(__file__).parents[1]
WEIGHING = """
import contextlib, io, json, shlex, sys
from tendon_cli.verbs import registry
registry.KINDS = (*registry.KINDS, "tests.weigh.WEIGH")
from tendon_cli.commands.cli import main

ended = []
for line in sys.argv[1:]:
    out = io.StringIO()
    err = io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main(shlex.split(line))
    except SystemExit as end:
        ended.append([end.code, out.getvalue(), err.getvalue()])
print(json.dumps(ended))
"""
"""A tendon that can weigh runs command lines, and says how each has ended."""
STUDY = 'name = "sack"\nload.mass = ["1 kg", "2 kg", "4 kg"]\n'


@pytest.fixture
def weighing(outside, workplace):
    """Return a function that runs command lines of a tendon that can weigh."""
    (workplace / "study.toml").write_text(STUDY)

    def call(*lines, **variables):
        env = {**os.environ, "PYTHONPATH": str(ROOT), **variables}
        return [Ran(*one) for one in outside("-c", WEIGHING, *lines, python=True, env=env).json]

    return call


def test_a_third_verb_has_a_command_with_the_options_of_all(weighing):
    lines = ("--help", "weigh --help", "weigh study.toml --dry-run --json")
    listed, options, dry = weighing(*lines)
    assert "Weigh every load of a study." in listed.out
    for option in ("--resume", "--dry-run", "--set", "--scheduler"):
        assert option in options.out
    assert "--prove" not in options.out
    assert dry.json["rows"] == {"weights": 3}


def test_a_third_verb_runs_into_a_folder_and_is_up_to_date_there(weighing, workplace):
    done, again = weighing("weigh study.toml", "weigh study.toml")
    folder = workplace / "results/sack-weights"
    assert done.out.startswith("3 loads, the heaviest weighs 39.2 N\n")
    assert "weights.parquet, weigh.json, weights.png" in done.out
    assert json.loads((folder / "weigh.json").read_text())["verb"] == "weigh"
    assert (folder / "weights.png").exists()
    assert "up to date" in again.out


def test_a_third_verb_is_resumed_and_no_other_takes_its_folder(weighing):
    weigh = "weigh study.toml --out run --no-figures"
    (broken,) = weighing(weigh, BROKEN_SCALES="1")
    assert (broken.exit, "the scales are broken" in broken.err) == (6, True)
    sweep = "sweep study.toml --out run"
    shown, again, resumed, swept = weighing(
        "show run --table weights", weigh, f"{weigh} --resume --json", sweep
    )
    assert (shown.exit, again.exit) == (3, 7)
    assert resumed.json["resumed_parts"] == 2
    assert "`tendon weigh` wrote it, not `tendon sweep`" in swept.err


def test_tables_of_a_third_verb_are_shown_exported_checked_and_reported(weighing, workplace):
    _, shown, heavy, exported, checked, reported = weighing(
        "weigh study.toml --out run --no-figures",
        "show run --json",
        "show run --where 'load_weight > 20 N' --json",
        "export run weights.csv",
        "check run",
        "report run",
    )
    assert [row["load_weight"] for row in shown.json["data"]] == [G, 2 * G, 4 * G]
    assert heavy.json["rows"] == 1
    assert exported.exit == 0
    assert checked.out == "sack: every file is as it was written\n"
    assert reported.exit == 0
    assert "the heaviest weighs" in (workplace / "run/report.html").read_text()
    part = workplace / "run/weights.parquet/part-00001.parquet"
    part.write_bytes(part.read_bytes()[:-9])
    (harmed,) = weighing("check run")
    assert harmed.exit == 3


def test_words_of_a_third_verb_are_completed(weighing):
    weighing("weigh study.toml --out run --no-figures")
    offered = {
        "tendon we": "weigh",
        "tendon show run --table ": "weights",
        "tendon show run --columns load_w": "load_weight",
    }
    for line, word in offered.items():
        (completed,) = weighing("", **asked_by_bash(line))
        assert completed.out.split() == [word]


def test_a_result_of_a_third_verb_is_opened_and_drawn(weighing, workplace, monkeypatch):
    weighing("weigh study.toml --out run --no-figures")
    monkeypatch.setattr(registry, "KINDS", (*registry.KINDS, "tests.weigh.WEIGH"))
    result = tendon_cli.open("run")
    assert result.text == "3 loads, the heaviest weighs 39.2 N"
    result.plot(out="own.png")
    assert (workplace / "own.png").read_bytes().startswith(b"\x89PNG")


# --- The kinds that there are ---------------------------------------------------------------------

NAMED = ("task", "result", "size", "draw", "check_figures", "check", "page")


@pytest.mark.parametrize("kind", kinds().values(), ids=lambda kind: kind.verb)
def test_what_a_kind_names_exists(kind):
    named = [getattr(kind, name) for name in NAMED]
    named += [table.axes for table in kind.tables]
    assert all(callable(load(name)) for name in named if name)
    assert set(NAMED) <= {*TaskKind._fields}
    assert issubclass(load(kind.task), Task)
    assert load(kind.task).kind is kind
    assert issubclass(load(kind.result), Result)


def test_no_two_kinds_share_a_record_or_a_table():
    records = [kind.record for kind in kinds().values()]
    assert len({*records}) == len(records)
    assert len(table_kinds()) == sum(len(kind.tables) for kind in kinds().values())


def test_knowing_every_kind_imports_no_room():
    script = (
        "import sys\nfrom tendon_cli.verbs.registry import kinds\nkinds()\n"
        "print(*[name for name in sys.modules if name.startswith('tendon_cli.')])"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    rooms = {name.split(".")[1] for name in done.stdout.split()}
    assert rooms == {"answers", "engine", "verbs", "version"}
    assert len(done.stdout.split()) == 7  # the rooms, and in each the module of its kind
