"""`tendon design` from the command line: exit codes, what is printed and where, folders whole or not at all."""

import contextlib
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

from tendon_cli import kernel
from tendon_cli.answers import answer as answer_module
from tendon_cli.answers import parts as parts_module
from tendon_cli.answers import refine, run
from tendon_cli.answers.folder import made_whole
from tendon_cli.errors import Stopped

from .studies import CATALOGUE, LOADS, RANGES

GOOD, SHUT = CATALOGUE, LOADS


@pytest.fixture
def study(workplace):
    def write(text, name="suit.toml"):
        (workplace / name).write_text(text, encoding="utf-8")
        return name

    return write


def test_an_answer_exits_with_0_and_stands_in_its_folder(tendon, study, workplace):
    done = tendon("design", study(GOOD), "--no-figures")
    assert done.exit == 0
    assert "K 5 kN/m, η 0.6" in done.out
    folder = workplace / "results" / "suit-design"
    assert sorted(file.name for file in folder.iterdir()) == ["choices.parquet", "conditions.parquet", "design.json"]
    assert [item.name for item in folder.parent.iterdir()] == ["suit-design"]


def test_where_nothing_suits_it_exits_with_4_and_still_answers(tendon, study):
    done = tendon("design", study(SHUT), "--no-figures", "--json")
    assert done.exit == 4
    assert done.json["best"] is None
    assert done.json["fixes"]
    assert done.json["conflicts"][0]["limits"] == ["extensor slack", "min_elbow_stiffness"]


def test_the_same_question_again_is_up_to_date_and_another_is_refused(tendon, study, workplace):
    file = study(GOOD)
    first = tendon("design", file, "--no-figures", "--json")
    record = workplace / "results" / "suit-design" / "design.json"
    before = record.read_bytes()
    again = tendon("design", file, "--no-figures", "--json")
    assert again.json == first.json
    assert "up to date" in tendon("design", file, "--no-figures").out
    assert record.read_bytes() == before
    other = tendon("design", file, "--no-figures", "--set", "spool.ratio=0.9")
    assert other.exit == 7
    assert "spool.ratio was" in other.err
    assert tendon("design", file, "--no-figures", "--set", "spool.ratio=0.9", "--overwrite").exit in (0, 4)
    assert record.read_bytes() != before


def test_a_damaged_table_is_noticed(tendon, study, workplace):
    file = study(GOOD)
    tendon("design", file, "--no-figures")
    table = workplace / "results" / "suit-design" / "conditions.parquet"
    table.write_bytes(table.read_bytes()[:-1] + b"x")
    done = tendon("design", file, "--no-figures")
    assert done.exit == 7
    assert "conditions.parquet is missing or damaged" in done.err
    assert tendon("design", file, "--no-figures", "--overwrite").exit == 0


def test_a_folder_of_something_else_is_left_alone(tendon, study, workplace):
    foreign = workplace / "mine"
    foreign.mkdir()
    (foreign / "notes.txt").write_text("keep")
    for words in ((), ("--overwrite",)):
        assert tendon("design", study(GOOD), "--no-figures", "--out", "mine", *words).exit == 7
    assert [file.name for file in foreign.iterdir()] == ["notes.txt"]


def test_overwriting_leaves_what_is_not_of_the_answer(tendon, study, workplace):
    tendon("design", study(GOOD), "--no-figures")
    note = workplace / "results" / "suit-design" / "notes.txt"
    note.write_text("keep")
    assert tendon("design", study(SHUT), "--no-figures", "--overwrite").exit == 4
    assert note.read_text() == "keep"


def test_what_is_stopped_leaves_nothing_behind(study, workplace, monkeypatch):
    import tendon_cli
    from tendon_cli.answers.parts import Choices

    monkeypatch.setattr(parts_module, "CHOICES_PER_PART", 2)
    solve_part, asked = Choices.part, []

    def stopping(self, index):
        asked.append(index)
        if index == 2:
            raise Stopped
        return solve_part(self, index)

    monkeypatch.setattr(Choices, "part", stopping)
    with pytest.raises(Stopped):
        tendon_cli.design(tendon_cli.load_study(study(GOOD)), workplace / "out", jobs=1)
    assert asked == [0, 1, 2]
    assert [item.name for item in workplace.iterdir()] == ["suit.toml"]


def test_what_is_stopped_while_it_refines_ends_before_the_next_windows(study, workplace, monkeypatch):
    import tendon_cli

    stop, after = threading.Event(), []

    def refining(*words):
        stop.set()
        monkeypatch.setattr(kernel, "fold_window", lambda *some: after.append(some))
        return refine.refined(*words)

    monkeypatch.setattr(answer_module, "refined", refining)
    with pytest.raises(Stopped):
        run.design(tendon_cli.load_study(study(RANGES)), workplace / "out", stop=stop)
    assert (stop.is_set(), after) == (True, [])
    assert [item.name for item in workplace.iterdir()] == ["suit.toml"]


def test_a_signal_is_told_as_it_is_for_an_answer(tendon, study, workplace, monkeypatch):
    monkeypatch.setattr(answer_module, "front", lambda _: signal.raise_signal(signal.SIGINT) or np.arange(1))
    monkeypatch.setattr(answer_module, "sensitivities", lambda *_: pytest.fail("it went on"))
    done = tendon("design", study(RANGES + '[design]\nmaximise = ["tolerance", "served"]\n'), "--no-figures")
    assert done.exit == 130
    assert "nothing is written" in done.err
    assert "--resume" not in done.err
    assert not list((workplace / "results").iterdir())


def killed_while_making(folder):
    """A process that is killed while it makes the folder of an answer; gives what it leaves."""
    code = (
        "import os, signal, sys; from pathlib import Path; from tendon_cli.answers.folder import made_whole\n"
        "with made_whole(Path(sys.argv[1])) as making:\n"
        " (making / 'choices.parquet').mkdir(); (making / 'choices.parquet/.part-00000.parquet.tmp').touch()\n"
        " os.kill(os.getpid(), signal.SIGKILL)"
    )
    assert subprocess.run([sys.executable, "-c", code, str(folder)], check=False).returncode == -signal.SIGKILL
    (left,) = (each for each in folder.parent.iterdir() if each.name.startswith(f".{folder.name}."))
    return left


def test_what_a_killed_one_left_is_removed_by_the_next_and_nothing_else(tendon, study, workplace):
    file = study(GOOD)
    out = workplace / "out"
    left = killed_while_making(out)
    strange = killed_while_making(workplace / "out2").rename(workplace / ".out.00112233aabb.tmp")
    (strange / "notes.txt").write_text("keep")
    unmarked = workplace / ".out.aabb00112233.tmp"
    unmarked.mkdir()
    (workplace / ".out.ffffffffffff.tmp").symlink_to(strange)
    with contextlib.suppress(Stopped), made_whole(out) as making:
        assert not left.exists()
        with contextlib.suppress(Stopped), made_whole(out):  # somebody else, at the same time
            assert making.exists()
            raise Stopped
        raise Stopped
    assert tendon("design", file, "--no-figures", "--out", "out").exit == 0
    assert sorted(item.name for item in workplace.iterdir()) == sorted(
        ["out", "suit.toml", strange.name, unmarked.name, ".out.ffffffffffff.tmp"]
    )
    assert (strange / "notes.txt").read_text() == "keep"
    assert not [item.name for item in out.iterdir() if item.name.startswith(".")]


def test_tables_of_several_parts_are_one_table(tendon, study, workplace, monkeypatch):
    from tendon_cli.tables.read import open_table

    monkeypatch.setattr(parts_module, "CHOICES_PER_PART", 4)
    done = tendon("design", study(GOOD), "--no-figures", "--json", "--jobs", 2)
    table = open_table(workplace / "results" / "suit-design" / "choices.parquet")
    assert table.rows == 9
    assert [entry["path"] for entry in done.json["files"]] == [
        *(f"choices.parquet/part-{at:05d}.parquet" for at in range(3)),
        "conditions.parquet",
    ]


def test_a_dry_run_tells_the_question_and_writes_nothing(tendon, study, workplace):
    done = tendon("design", study(GOOD), "--dry-run", "--json")
    assert done.exit == 0
    assert done.json["choices"] == {"spring.stiffness": 3, "spool.ratio": 3}
    assert done.json["windows"] == 36
    assert not (workplace / "results").exists()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[design]\nminimise = "max_tensoin"\n', "max_tension"),
        ('[design]\nminimise = "tolerance"\nmaximise = "tolerance"\n', "minimised, too"),
        ('[design]\nconditions = ["tendon.pretension"]\n', "what tendon design solves for"),
        ('[limits]\nmax_tenson = "3 N"\n', "max_tension"),
        ('[limits]\nmax_contact_pressure = "30 kPa"\n', "contact_width"),
        ('[limits]\nmax_tension = "3 mm"\n', "N"),
    ],
)
def test_what_cannot_be_asked_is_refused_with_a_hint(tendon, study, text, words):
    done = tendon("design", study(text))
    assert done.exit == 2
    assert words in done.err
    assert "Traceback" not in done.err
