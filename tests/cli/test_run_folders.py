"""A run folder never loses or mixes what it holds, and can always be resumed.

A folder that never was a run is not touched.
"""

import errno
import fcntl
import hashlib
import json
import os
import shutil
import signal
from pathlib import Path
from unittest import mock

import pytest

from tendon_cli.engine import records as record_module
from tendon_cli.engine import task as task_module
from tendon_cli.engine.folder import RunFolder
from tendon_cli.engine.task import PartMaker
from tests.sampled import check_all

STUDY = """
[tendon]
pretension = { from = "60 N", to = "240 N", num = 4 }
[load]
mass = ["0 kg", "5 kg"]
[motion]
elbow_angle = ["10 deg", "50 deg", "80 deg"]
"""
SEVERAL = 12  # states of a part, so that the study has four parts
ONE = 2**19  # states of a part, so that the study has one part
WITH_EVERY_OPTION = pytest.mark.parametrize(
    "words", [(), ("--resume",), ("--overwrite",)], ids=" ".join
)


@pytest.fixture
def sweep(tendon, write_study, small_parts, blank_figures):
    """Return a function that sweeps a study of four parts into the folder `run`, with figures."""
    write_study(STUDY)
    small_parts(SEVERAL)

    def call(*words):
        return tendon("sweep", "study.toml", "--out", "run", *words)

    return call


@pytest.fixture
def run(sweep):
    """Return a function that sweeps the same study without figures."""

    def call(*words):
        return sweep("--no-figures", *words)

    return call


def contents():
    """Return the bytes of every file of the run by path, None for a folder."""
    content = {}
    for path in Path("run").rglob("*"):
        if path.name != ".lock":
            content[path] = path.read_bytes() if path.is_file() else None
    return content


def signed(record):
    """Return the text of a record with the right checksum, as anybody can write one."""
    content = {key: value for key, value in record.items() if key != "checksum"}
    text = json.dumps(content, sort_keys=True).encode()
    return json.dumps({**content, "checksum": hashlib.sha256(text).hexdigest()})


def is_refused(ran):
    """Return True if a command with `--json` refused a folder."""
    return (ran.exit, ran.json["error"]["kind"]) == (7, "folder")


# --- Finished runs --------------------------------------------------------------------------------


def interrupted(*_):
    raise KeyboardInterrupt


@pytest.mark.parametrize("resume", [(), ("--resume",)])
@pytest.mark.parametrize("unfinished", [False, True])
def test_another_study_is_refused_and_what_differs_is_named(run, monkeypatch, unfinished, resume):
    with monkeypatch.context() as patch:
        expected = 0
        if unfinished:
            patch.setattr(RunFolder, "finish", interrupted)
            expected = 130
        assert run().exit == expected
    before = contents()
    settings = [
        "tendon.length=3 m",
        "load.mass=5 kg",
        "model.slack=bilateral",
        'output.tables=["designs"]',
    ]
    for setting in settings:
        ran = run("--set", setting, "--json", *resume)
        assert is_refused(ran)
        assert setting.partition("=")[0] in ran.json["error"]["message"]
    assert contents() == before


def test_another_order_of_axes_or_other_results_are_refused(run, write_study, monkeypatch):
    run()
    with monkeypatch.context() as patch:
        for module in (record_module, task_module):
            patch.setattr(module, "RESULTS_VERSION", 99)
        assert "results version" in run("--json").json["error"]["message"]
    tendon_table, _, rest = STUDY.partition("[load]")
    load, _, motion = rest.partition("[motion]")
    write_study(f"[load]{load}{tendon_table}[motion]{motion}")
    ran = run("--json")
    assert ran.exit == 7
    assert "order of the axes" in ran.json["error"]["message"]


# --- Overwriting ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("before", "after"), [(SEVERAL, ONE), (ONE, SEVERAL), (SEVERAL, SEVERAL)])
def test_overwrite_replaces_a_run_through_a_linked_folder_and_leaves_what_is_anothers(
    sweep, workplace, small_parts, hashes_in, before, after
):
    (workplace / "elsewhere").mkdir()
    (workplace / "run").symlink_to(workplace / "elsewhere")
    small_parts(before)
    assert Path("run", sweep("--json").json["figures"][0]).exists()
    Path("run/notes.txt").write_text("mine", encoding="utf-8")
    small_parts(after)
    longer = ("--no-figures", "--set", "tendon.length=3 m")
    ran = sweep("--overwrite", *longer, "--json")
    assert ran.exit == 0
    assert (workplace / "run").is_symlink()
    hashes = {entry["path"]: entry["sha256"] for entry in ran.json["files"]}
    assert hashes_in(workplace / "elsewhere") == hashes
    other_files = [
        path.name for path in Path("run").iterdir() if path.is_file() and path.suffix != ".parquet"
    ]
    assert sorted(other_files) == [".lock", "notes.txt", "run.json"]
    assert sweep(*longer).exit == 0


def test_empty_folders_of_tables_that_an_interrupted_run_left_are_no_hindrance(
    run, workplace, small_parts
):
    small_parts(ONE)
    (workplace / "run/states.parquet").mkdir(parents=True)
    assert run().exit == 0
    assert (workplace / "run/states.parquet").is_file()


@pytest.mark.parametrize("name", [".DS_Store", "notes.txt", "part-mine.parquet"])
@pytest.mark.parametrize("after", [SEVERAL, ONE])
def test_overwrite_with_a_strangers_file_among_the_parts_works_or_refuses(
    run, workplace, small_parts, name, after
):
    assert run().exit == 0
    (workplace / "run/states.parquet" / name).write_bytes(b"foreign")
    before = contents()
    small_parts(after)
    ran = run("--overwrite", "--set", "tendon.length=3 m")
    assert (workplace / "run/states.parquet" / name).read_bytes() == b"foreign"
    if ran.exit == 0:
        assert after == SEVERAL
        assert name != "part-mine.parquet"
        assert run("--set", "tendon.length=3 m").exit == 0
    else:
        assert ran.exit == 7
        assert name in ran.err
        assert contents() == before


@pytest.mark.parametrize("table", ["states", "designs"])
def test_a_strangers_table_is_not_replaced_by_one_that_the_run_had_not(run, small_parts, table):
    small_parts(ONE)
    other = "designs" if table == "states" else "states"
    assert run("--set", f'output.tables=["{other}"]').exit == 0
    Path(f"run/{table}.parquet").write_bytes(b"foreign")
    before = contents()
    ran = run("--overwrite")
    assert ran.exit == 7
    assert f"{table}.parquet" in ran.err
    assert contents() == before


@pytest.mark.parametrize(
    "path", ["../precious.txt", "/{folder}/precious.txt", "deep/er/precious.txt"]
)
def test_overwrite_never_reaches_outside_its_folder(run, workplace, path):
    run()
    (workplace / "precious.txt").write_text("mine", encoding="utf-8")
    record = json.loads(Path("run/run.json").read_text("utf-8"))
    file = {"path": path.format(folder=workplace), "rows": 0, "size": 4, "sha256": ""}
    record["files"].append(file)
    for content in (json.dumps(record), signed(record)):
        Path("run/run.json").write_text(content, encoding="utf-8")
        assert run("--overwrite").exit == 7  # a record that was changed is no record of ours
        assert (workplace / "precious.txt").read_text(encoding="utf-8") == "mine"


# --- Folders that never were a run ----------------------------------------------------------------

FOREIGN = [
    ("chapter.txt", "x"),
    ("run.json", '{"files": ["chapter.txt"]}'),
    ("run.json", '{"files": [{"path": "chapter.txt"}]}'),
    ("run.json", "{}"),
    ("run.json", "{"),
    ("run.json", "[1]"),
    ("journal.jsonl", ""),
    ("journal.jsonl", "dear diary\n"),
    ("journal.jsonl", '{"event": 1}\n{"event": 2}\n'),
]


@WITH_EVERY_OPTION
def test_a_foreign_folder_is_refused_and_left_as_it_was(sweep, words):
    def check(name, content):
        shutil.rmtree("run", ignore_errors=True)
        Path("run").mkdir()
        for other in ("designs.parquet", "states.parquet", "slack_map.png", "chapter.txt"):
            Path("run", other).write_bytes(b"years of work")
        Path("run", name).write_text(content, encoding="utf-8")
        before = contents()
        assert is_refused(sweep(*words, "--json"))
        assert contents() == before
        assert not Path("run/.lock").exists()

    check_all(check, FOREIGN)


@WITH_EVERY_OPTION
def test_a_strangers_journal_alone_is_his(run, words):
    Path("run").mkdir()
    Path("run/journal.jsonl").write_bytes(b"dear diary\n")
    assert run(*words).exit == 7
    assert Path("run/journal.jsonl").read_bytes() == b"dear diary\n"


ODD = [
    ("feasible", "x"),
    ("designs", -1),
    ("states", 1.5),
    ("seconds", "long"),
    ("seconds", float("nan")),
    ("files", [{}]),
    ("files", ["x"]),
    ("files", None),
    ("figures", ["../x.png"]),
    ("warnings", [1]),
    ("axes", "x"),
    ("study", []),
    ("name", 3),
    ("slack", True),
    ("parts", None),
    ("taut", "x"),
]


def test_a_record_that_is_odd_is_no_record_whatever_its_checksum(run, small_parts):
    small_parts(ONE)
    assert run().exit == 0
    file = Path("run/run.json")
    record = json.loads(file.read_text("utf-8"))
    for key, value in ODD:
        file.write_text(signed({**record, key: value}), encoding="utf-8")
        before = contents()
        assert is_refused(run("--json"))
        assert is_refused(run("--json", "--overwrite"))
        assert contents() == before


@pytest.mark.parametrize("name", ["run.json", "journal.jsonl", "states.parquet"])
def test_a_pipe_a_device_or_a_folder_as_record_or_table_is_refused_at_once(run, name):
    Path("run").mkdir()
    os.mkfifo(Path("run", name))
    assert run().exit == 7
    Path("run", name).unlink()
    Path("run", name).symlink_to("/dev/zero")
    assert run("--resume").exit == 7
    Path("run", name).unlink()
    Path("run", name).mkdir()
    Path("run", name, "mine").touch()
    assert run("--overwrite").exit == 7


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS])
def test_a_file_system_without_locks_is_said_once_and_written_to(run, monkeypatch, number):
    monkeypatch.setattr(fcntl, "flock", mock.Mock(side_effect=OSError(number, "no locks")))
    ran = run()
    assert ran.exit == 0
    assert (ran.out + ran.err).count("file system without locks") == 1
    assert "without locks" not in Path("run/run.json").read_text("utf-8")
    monkeypatch.setattr(fcntl, "flock", mock.Mock(side_effect=OSError(errno.EIO, "torn")))
    refused = run("--overwrite")
    assert refused.exit == 7
    assert "cannot be locked: torn" in refused.err


def test_the_root_is_no_run_folder(tendon, run):
    root = sorted(Path("/").iterdir())
    assert tendon("sweep", "study.toml", "--out", "/").exit == 7
    assert sorted(Path("/").iterdir()) == root


def test_a_working_directory_that_is_gone_is_named(outside, run, workplace, tmp_path_factory):
    gone = tmp_path_factory.mktemp("gone")
    ran = outside("sweep", workplace / "study.toml", "--json", cwd=gone, preexec_fn=gone.rmdir)
    assert ran.exit == 2
    assert "working directory" in ran.json["error"]["message"]


def test_a_study_whose_name_is_not_utf_8_is_swept(outside, workplace):
    odd = os.fsdecode(b"odd\xff.toml")
    (workplace / odd).write_text('name = "fine"\n' + STUDY, encoding="utf-8")
    assert outside("sweep", odd, "--json", "--no-figures").exit == 0


# --- Unfinished runs ------------------------------------------------------------------------------


def test_a_strangers_part_that_comes_meanwhile_stays_and_the_run_is_not_finished(run, monkeypatch):
    late = Path("run/states.parquet/part-00077.parquet")
    make = PartMaker.make

    def meanwhile(self, *arguments):
        late.write_bytes(b"mine")
        return make(self, *arguments)

    with monkeypatch.context() as patch:
        patch.setattr(PartMaker, "make", meanwhile)
        assert is_refused(run("--json"))
    assert is_refused(run("--resume", "--json"))
    assert late.read_bytes() == b"mine"
    late.unlink()
    assert run("--resume", "--json").json["resumed_parts"] == 4


def test_parts_of_another_study_are_replaced_only_where_a_run_was(run, small_parts):
    """A table that somebody copied into a folder is none of ours; nor is one of another study."""
    assert run("--set", "tendon.length=3 m").exit == 0
    Path("run/run.json").unlink()
    before = contents()
    for words in ((), ("--resume",)):
        ran = run(*words, "--json")
        assert is_refused(ran)
        assert "tendon.length was 3" in ran.json["error"]["message"]
    Path("run/.lock").rename("lock")
    for words in ((), ("--resume",), ("--overwrite",)):
        ran = run(*words, "--json")
        assert is_refused(ran)
        assert "is not a run folder" in ran.json["error"]["message"]
    assert contents() == before
    Path("lock").rename("run/.lock")
    assert run("--overwrite").exit == 0


def test_files_of_two_runs_are_not_mixed(run, workplace):
    assert run("--set", "tendon.length=3 m").exit == 0
    Path("run").rename("other")
    assert run().exit == 0
    Path("run/run.json").unlink()
    part = "states.parquet/part-00003.parquet"
    Path("run", part).write_bytes(Path("other", part).read_bytes())
    before = contents()
    for words in ((), ("--resume",), ("--overwrite",)):
        ran = run(*words, "--json")
        assert is_refused(ran)
        assert "files of two runs" in ran.json["error"]["message"]
    assert contents() == before


OLD = "which tendon 0.3.0 reads"


def test_a_run_of_an_older_version_is_refused_and_its_reader_named(run, tendon):
    assert run().exit == 0
    file = Path("run/run.json")
    record = json.loads(file.read_text("utf-8"))
    file.write_text(signed({**record, "results_version": 6}), encoding="utf-8")
    for words in ((), ("--resume",)):
        assert OLD in run(*words, "--json").json["error"]["message"]
    for command in ("report", "check", "show"):
        ran = tendon(command, "run", "--json") if command != "report" else tendon(command, "run")
        assert ran.exit == 3
        assert OLD in ran.out + ran.err
    file.unlink()
    Path("run/journal.jsonl").write_text("{}", encoding="utf-8")
    before = contents()
    for words in ((), ("--resume",), ("--overwrite",)):
        assert "tendon 0.3.0" in run(*words, "--json").json["error"]["hint"]
    assert contents() == before


def test_an_answer_with_a_table_that_is_not_written_any_more_can_be_replaced(tendon, workplace):
    """Once an answer had its named choices in a table of their own."""
    (workplace / "suit.toml").write_text('spool = { ratio = 0.6 }\nload = { mass = "5 kg" }\n')
    words = ("design", "suit.toml", "--no-figures", "--out", "answer")
    assert tendon(*words).exit in (0, 4)
    folder = workplace / "answer"
    record = json.loads((folder / "design.json").read_text("utf-8"))
    shutil.copy(folder / "conditions.parquet", folder / "named.parquet")
    (entry,) = [entry for entry in record["files"] if entry["path"] == "conditions.parquet"]
    record |= {"results_version": 6, "files": [*record["files"], entry | {"path": "named.parquet"}]}
    (folder / "design.json").write_text(signed(record), encoding="utf-8")
    assert OLD in tendon(*words, "--json").json["error"]["message"]
    assert tendon(*words, "--overwrite").exit in (0, 4)
    assert not (folder / "named.parquet").exists()


# --- Figures --------------------------------------------------------------------------------------


def test_no_figure_of_an_older_run_stays_after_a_kill_between_picture_and_record(
    sweep, monkeypatch
):
    with monkeypatch.context() as patch:
        patch.setattr(RunFolder, "finish", interrupted)
        assert sweep().exit == 130
    assert Path("run/slack_map.png").exists()
    assert not Path("run/run.json").exists()
    assert sweep("--overwrite", "--no-figures", "--set", "tendon.length=3 m").exit == 0
    assert not Path("run/slack_map.png").exists()


def test_a_strangers_picture_is_not_drawn_over_and_a_deleted_figure_is_drawn_again(sweep, run):
    assert run().exit == 0
    Path("run/slack_map.png").write_bytes(b"foreign")
    ran = sweep("--json")
    assert ran.exit == 0
    assert ran.json["figures"] == []
    assert any("slack_map.png" in warning for warning in ran.json["warnings"])
    assert Path("run/slack_map.png").read_bytes() == b"foreign"
    shutil.rmtree("run")
    assert sweep().exit == 0
    drawn = Path("run/slack_map.png").read_bytes()
    Path("run/slack_map.png").unlink()
    assert "up to date" in sweep().out
    assert Path("run/slack_map.png").read_bytes() == drawn


@pytest.fixture
def read_only(monkeypatch):
    """Let nothing be written anywhere, as on a file system that is mounted to be read."""
    opened = os.open
    may_access = os.access

    def to_read(path, flags, *more, **options):
        if flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            raise OSError(errno.EROFS, "Read-only file system")
        return opened(path, flags, *more, **options)

    def cannot(*_, **__):
        raise OSError(errno.EROFS, "Read-only file system")

    def use():
        monkeypatch.setattr(os, "open", to_read)
        monkeypatch.setattr(os, "mkdir", cannot)
        monkeypatch.setattr(
            os, "access", lambda path, mode: mode != os.W_OK and may_access(path, mode)
        )

    return use


@pytest.mark.parametrize("verb", ["sweep", "design"])
def test_the_same_question_needs_no_folder_to_write_in(
    tendon, write_study, read_only, blank_figures, verb
):
    write_study(STUDY)
    springs = """spring.stiffness=["5 kN/m", "6 kN/m", "7 kN/m"]"""
    ask = (verb, "study.toml", "--out", "run", "--json", "--set", springs)
    first = tendon(*ask)
    assert first.exit == 0, first.err
    Path("run/.lock").unlink()
    missing = first.json["figures"][0]
    Path("run", missing).rename("drawn.png")
    before = contents()
    read_only()
    again = tendon(*ask, "--no-figures")
    without = tendon(*ask)
    assert (again.exit, without.exit) == (0, 0), again.err + without.err
    assert again.json == first.json
    # A figure that cannot be drawn is no reason to keep the answer back.
    assert "figures are not drawn" in without.json["warnings"][-1]
    assert contents() == before
    assert not Path("run/.lock").exists()
    assert tendon(*ask, "--overwrite").exit == 5


def test_a_figure_never_costs_a_run(sweep, monkeypatch):
    from tendon_cli.figures import draw

    for error in (ValueError("odd"), MemoryError(), OSError(28, "No space left on device")):
        with monkeypatch.context() as patch:
            patch.setattr(draw, "_slack_maps", mock.Mock(side_effect=error))
            ran = sweep("--json", "--overwrite")
        assert ran.exit == 0
        assert ran.json["figures"] == []
        assert any("slack map" in warning for warning in ran.json["warnings"])
        assert Path("run/run.json").exists()
    assert sweep("--json").json["figures"] == ["slack_map.png"]


# --- Signals --------------------------------------------------------------------------------------


def handlers():
    """Return the handlers of the signals that a sweep handles."""
    return [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]


def test_the_handlers_of_before_are_back_after_a_sweep(run):
    before = handlers()
    run()
    assert handlers() == before
