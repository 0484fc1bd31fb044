"""What stands in a run folder is never lost, never mixed, and always resumable."""

import json
import signal
from pathlib import Path

import pytest

from tendon_cli.engine import records as record_module

STUDY = """
[tendon]
pretension = { from = "60 N", to = "240 N", num = 10 }
[load]
mass = ["0 kg", "5 kg"]
[motion]
elbow_angle = ["10 deg", "50 deg", "80 deg"]
"""
PARTS = 10
STOPPED = """
import os, sys
from tendon_cli.engine import plan
plan.STATES_PER_FILE = plan.STATES_PER_PART = 12
from tendon_cli.engine.journal import Journal
add = Journal.add
def add_and_signal(self, result):
    add(self, result)
    for number in map(int, sys.argv[1].split(",")):
        if len(self.parts) == 2:
            os.kill(os.getpid(), number)
Journal.add = add_and_signal
from tendon_cli import cli
cli.main(["sweep", "study.toml", "--no-figures", "--jobs", "2", "--out", "run", *sys.argv[2:]])
"""
SWEEP = ("sweep", "study.toml", "--no-figures", "--out", "run")


@pytest.fixture
def run(tendon, workplace, small_parts):
    """Sweep a study of ten parts into the folder `run`."""
    (workplace / "study.toml").write_text(STUDY, encoding="utf-8")
    small_parts(12)
    return lambda *words: tendon(*SWEEP, *words)


@pytest.fixture
def stopped(run, outside, muttered):
    """A run that a signal stopped after two of its parts."""
    ran = outside("-c", STOPPED, signal.SIGTERM, python=True)
    assert ran.exit == 143
    return run


def whole(new_sweep, workplace):
    return new_sweep(STUDY, workplace, out="whole").hashes


def everything(folder):
    return {file: file.read_bytes() for file in Path(folder).rglob("*") if file.is_file() and file.name != ".lock"}


# --- Finished runs ---------------------------------------------------------------------------------------------------


def test_a_finished_run_is_up_to_date_and_not_touched(run):
    first = run("--json")
    before = everything("run")
    second = run()
    assert (second.exit, "up to date" in second.out) == (0, True)
    assert everything("run") == before
    assert run("--json").json == first.json
    assert run("--resume").exit == 0
    assert everything("run") == before


def test_a_finished_run_has_its_files_and_nothing_temporary(run):
    record = run("--json").json
    found = {str(file.relative_to("run")) for file in everything("run")}
    assert found == {"run.json", *(entry["path"] for entry in record["files"])}


@pytest.mark.parametrize("damage", ["flip", "delete", "truncate"])
def test_a_damaged_finished_run_is_not_up_to_date(run, damage):
    run()
    file = Path("run/states.parquet/part-00003.parquet")
    content = bytearray(file.read_bytes())
    content[len(content) // 3] ^= 2
    file.write_bytes(content if damage == "flip" else content[:-1])
    if damage == "delete":
        file.unlink()
    ran = run("--json")
    assert ran.exit != 0
    assert "part-00003" in ran.json["error"]["message"]
    assert run("--overwrite").exit == 0


@pytest.mark.parametrize(
    ("setting", "named"),
    [
        ("tendon.length=3 m", "tendon.length"),
        ("load.mass=5 kg", "load.mass"),
        ("model.slack=bilateral", "model.slack"),
        ('output.tables=["designs"]', "output.tables"),
    ],
)
def test_another_study_is_refused_and_what_differs_is_named(run, setting, named):
    run()
    before = everything("run")
    ran = run("--set", setting, "--json")
    assert (ran.exit, ran.json["error"]["kind"]) == (7, "folder")
    assert named in ran.json["error"]["message"]
    assert run("--set", setting, "--resume").exit == 7
    assert everything("run") == before


def test_the_order_of_axes_makes_another_study(run, workplace):
    run()
    swapped = STUDY.split("[load]")
    load, motion = swapped[1].split("[motion]")
    (workplace / "study.toml").write_text(f"[load]{load}{swapped[0]}[motion]{motion}", encoding="utf-8")
    ran = run("--json")
    assert (ran.exit, "order of the axes" in ran.json["error"]["message"]) == (7, True)


def test_a_version_with_other_results_is_refused(run, monkeypatch):
    run()
    monkeypatch.setattr(record_module, "RESULTS_VERSION", 99)
    ran = run("--json")
    assert (ran.exit, "results version" in ran.json["error"]["message"]) == (7, True)


def test_overwrite_replaces_a_run_by_another(run, hashes_in):
    run()
    ran = run("--overwrite", "--json", "--set", "load.mass=2 kg")
    assert (ran.exit, ran.json["designs"]) == (0, 10)
    assert hashes_in(Path("run")) == {entry["path"]: entry["sha256"] for entry in ran.json["files"]}
    one_part = run("--overwrite", "--json", "--set", "load.mass=2 kg", "--set", "tendon.pretension=90 N")
    assert sorted(hashes_in(Path("run"))) == ["designs.parquet", "states.parquet"]
    assert one_part.exit == 0


def test_overwrite_deletes_no_file_of_a_stranger(run):
    run()
    Path("run/notes.txt").write_text("mine", encoding="utf-8")
    Path("run/states.parquet/notes.txt").write_text("mine", encoding="utf-8")
    run("--overwrite")
    assert Path("run/notes.txt").read_text(encoding="utf-8") == "mine"
    assert Path("run/states.parquet/notes.txt").read_text(encoding="utf-8") == "mine"


def test_overwrite_replaces_a_run_beside_a_file_of_a_stranger(run):
    run()
    Path("run/notes.txt").write_text("mine", encoding="utf-8")
    assert run("--overwrite", "--set", "load.mass=2 kg").exit == 0
    assert Path("run/run.json").exists()


def test_overwrite_replaces_a_run_with_its_figures(tendon, workplace):
    (workplace / "study.toml").write_text(STUDY, encoding="utf-8")
    words = ("sweep", "study.toml", "--out", "run", "--json")
    first = tendon(*words)
    assert first.json["figures"]
    assert all(Path("run", name).exists() for name in first.json["figures"])
    again = tendon(*words, "--overwrite", "--no-figures", "--set", "tendon.length=3 m")
    assert again.exit == 0
    assert not list(Path("run").glob("*.png"))


FOREIGN = {
    "a file": ("chapter.txt", "x"),
    "a run.json of names": ("run.json", '{"files": ["chapter.txt"]}'),
    "a run.json of paths": ("run.json", '{"files": [{"path": "chapter.txt"}]}'),
    "a run.json of nothing": ("run.json", "{}"),
    "a broken run.json": ("run.json", "{"),
    "a list": ("run.json", "[1]"),
}


def foreign_folder(kind):
    Path("run").mkdir()
    Path("run/chapter.txt").write_text("years of work", encoding="utf-8")
    name, content = FOREIGN[kind]
    Path("run", name).write_text(content, encoding="utf-8")
    return everything("run")


@pytest.mark.parametrize("kind", FOREIGN)
@pytest.mark.parametrize("words", [(), ("--resume",)])
def test_a_foreign_folder_is_refused_and_left_as_it_was(run, kind, words):
    before = foreign_folder(kind)
    assert run(*words).exit == 7
    assert everything("run") == before


@pytest.mark.parametrize(
    "kind",
    list(FOREIGN),
)
def test_a_foreign_folder_is_refused_even_with_overwrite(run, kind):
    before = foreign_folder(kind)
    assert run("--overwrite").exit == 7
    assert everything("run") == before


@pytest.mark.parametrize("path", ["../precious.txt", "/{folder}/precious.txt", "deep/er/precious.txt"])
def test_overwrite_never_reaches_outside_its_folder(run, workplace, path):
    run()
    precious = workplace / "precious.txt"
    precious.write_text("mine", encoding="utf-8")
    record = json.loads(Path("run/run.json").read_text("utf-8"))
    record["files"].append({"path": path.format(folder=workplace), "rows": 0, "size": 4, "sha256": ""})
    Path("run/run.json").write_text(json.dumps(record), encoding="utf-8")
    assert run("--overwrite").exit == 7  # a record that was changed is no record of ours
    assert precious.read_text(encoding="utf-8") == "mine"


def test_a_link_to_a_folder_is_not_written_through(run, workplace):
    (workplace / "precious").mkdir()
    Path("run").mkdir()
    Path("run/states.parquet").symlink_to(workplace / "precious")
    assert run().exit in (5, 7)
    assert not list((workplace / "precious").iterdir())


# --- Unfinished runs -------------------------------------------------------------------------------------------------


def test_an_unfinished_run_is_exit_7_and_hints_at_resume(stopped):
    before = everything("run")
    ran = stopped("--json")
    assert (ran.exit, ran.json["error"]["kind"]) == (7, "folder")
    assert "--resume" in ran.json["error"]["hint"]
    assert everything("run") == before


def test_resume_where_there_is_nothing_simply_starts(run):
    ran = run("--resume", "--json")
    assert (ran.exit, ran.json["resumed_parts"]) == (0, 0)


def test_resume_gives_the_bytes_of_a_run_that_was_never_stopped(stopped, new_sweep, workplace, hashes_in):
    ran = stopped("--resume", "--json")
    assert (ran.exit, ran.json["resumed_parts"] >= 2) == (0, True)
    assert hashes_in(Path("run")) == whole(new_sweep, workplace)
    before = everything("run")
    assert stopped("--resume").exit == 0
    assert everything("run") == before


def test_resume_redoes_parts_that_were_deleted_or_damaged(stopped, new_sweep, workplace, hashes_in):
    done = sorted(Path("run").rglob("part-*.parquet"))
    done[0].unlink()
    done[-1].write_bytes(done[-1].read_bytes()[:-1] + b"x")
    assert stopped("--resume").exit == 0
    assert hashes_in(Path("run")) == whole(new_sweep, workplace)


def test_resume_keeps_exactly_the_parts_that_stand(stopped):
    parts = sorted(Path("run/states.parquet").iterdir())
    parts[0].unlink()
    kept = {file: file.stat().st_mtime_ns for file in parts[1:]}
    assert stopped("--resume", "--json").json["resumed_parts"] == len(kept)
    assert {file: file.stat().st_mtime_ns for file in kept} == kept


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.8, 0.99])
def test_a_journal_cut_anywhere_still_resumes(stopped, new_sweep, workplace, hashes_in, share):
    journal = Path("run/journal.jsonl")
    content = journal.read_bytes()
    journal.write_bytes(content[: int(share * len(content))])
    assert stopped("--resume").exit == 0
    assert hashes_in(Path("run")) == whole(new_sweep, workplace)


def test_an_unfinished_run_of_another_study_is_not_resumed(stopped):
    before = everything("run")
    ran = stopped("--resume", "--json", "--set", "tendon.length=3 m")
    assert (ran.exit, "tendon.length" in ran.json["error"]["message"]) == (7, True)
    assert everything("run") == before


def test_overwrite_starts_an_unfinished_run_anew(stopped, new_sweep, workplace, hashes_in):
    ran = stopped("--overwrite", "--json")
    assert (ran.exit, ran.json["resumed_parts"]) == (0, 0)
    assert hashes_in(Path("run")) == whole(new_sweep, workplace)


def test_what_a_killed_run_left_half_written_goes_and_nothing_of_a_stranger(stopped, new_sweep, workplace, hashes_in):
    left = [
        Path("run", name) for name in ("states.parquet/.tendon-run-0123456789ab.tmp", ".tendon-run-ba9876543210.tmp")
    ]
    his = [
        Path("run", name) for name in ("states.parquet/.part-00007.parquet.tmp", ".journal.jsonl.tmp", ".run.json.tmp")
    ]
    for file in (*left, *his):
        file.write_bytes(b"half")
    assert stopped("--resume").exit == 0
    assert hashes_in(Path("run")) == whole(new_sweep, workplace)
    assert not any(file.exists() for file in left)
    assert all(file.read_bytes() == b"half" for file in his)


def test_a_run_killed_as_it_began_can_be_resumed(run):
    Path("run").mkdir()
    Path("run/.tendon-run-0123456789ab.tmp").write_bytes(b"")
    assert run("--resume").exit == 0


# --- Signals ---------------------------------------------------------------------------------------------------------


SIGNALS = [("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)]


@pytest.mark.parametrize(("name", "code"), SIGNALS)
def test_a_signal_stops_cleanly_and_what_is_done_is_kept(run, outside, new_sweep, workplace, hashes_in, name, code):
    ran = outside("-c", STOPPED, int(getattr(signal, name)), "--json", python=True)
    assert (ran.exit, ran.json["error"]["exit"], ran.json["error"]["kind"]) == (code, code, "stopped")
    assert "--resume" in ran.json["error"]["hint"]
    kept = hashes_in(Path("run"))
    assert 4 <= len(kept) < 2 * PARTS
    assert not [file for file in everything("run") if file.name.endswith(".tmp")]
    assert not Path("run/run.json").exists()
    complete = whole(new_sweep, workplace)
    assert kept.items() <= complete.items()
    assert run("--resume").exit == 0
    assert hashes_in(Path("run")) == complete


def test_a_stopped_run_says_one_thing(run, outside):
    ran = outside("-c", STOPPED, int(signal.SIGTERM), "--quiet", python=True)
    assert ran.out == ""
    assert ran.err.startswith("tendon: error: ")
    assert "SIGTERM" in ran.err


MIDWAY = """
import os, sys
from tendon_cli.engine import sweep
state_rows = sweep.state_rows
def signal_and_rows(inputs, block, keys):
    os.kill(os.getpid(), int(sys.argv[1]))
    return state_rows(inputs, block, keys)
sweep.state_rows = signal_and_rows
from tendon_cli import cli
cli.main(["sweep", "study.toml", "--no-figures", "--jobs", "1", "--out", "run"])
"""


def test_a_run_stopped_within_a_part_prints_no_traceback(run, outside, workplace):
    (workplace / "study.toml").write_text(STUDY.replace("num = 10", "num = 30000"), encoding="utf-8")
    ran = outside("-c", MIDWAY, int(signal.SIGTERM), python=True)
    assert ran.exit == 143
    assert "Traceback" not in ran.err


def test_a_second_sigint_ends_at_once(run, outside):
    twice = f"{int(signal.SIGINT)},{int(signal.SIGINT)}"
    assert outside("-c", STOPPED, twice, python=True).exit == 130
    assert run("--resume").exit == 0


def test_a_run_that_was_told_to_ignore_hang_ups_goes_on(run, outside):
    ignore = {"preexec_fn": lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)}
    assert outside("-c", STOPPED, int(signal.SIGHUP), python=True, **ignore).exit == 0


def test_the_handlers_of_before_are_back_after_a_sweep(run):
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    run()
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)] == before


def test_a_figure_that_was_deleted_is_drawn_again(tendon, workplace):
    (workplace / "study.toml").write_text(
        '[tendon]\npretension = ["80 N", "120 N", "160 N"]\n[spool]\nratio = [0.8, 1.0]\n'
    )
    assert tendon("sweep", "study.toml", "--out", "run").exit == 0
    drawn = (workplace / "run/slack_map.png").read_bytes()
    (workplace / "run/slack_map.png").unlink()
    assert "up to date" in tendon("sweep", "study.toml", "--out", "run").out
    assert (workplace / "run/slack_map.png").read_bytes() == drawn
