"""A folder that never was a run is never touched, and of a run only what it lists is deleted."""

import hashlib
import json
import os
import shutil
import zlib
from pathlib import Path

import pytest

from tendon_cli.engine import journal as journal_module

STUDY = (
    '[tendon]\npretension = ["90 N", "150 N", "200 N"]\n[spool]\nratio = [0.8, 1.0]\n[motion]\nelbow_angle = "50 deg"\n'
)
SEVERAL, ONE = 4, 2**19


@pytest.fixture
def sweep(tendon, workplace):
    (workplace / "study.toml").write_text(STUDY, encoding="utf-8")
    return lambda *words: tendon("sweep", "study.toml", "--out", "run", *words)


def everything(folder):
    return {path: path.read_bytes() if path.is_file() else None for path in Path(folder).rglob("*")}


def signed(record):
    """A record with the right checksum, as anybody can write one."""
    content = {key: value for key, value in record.items() if key != "checksum"}
    text = json.dumps(content, sort_keys=True).encode()
    return json.dumps({**content, "checksum": hashlib.sha256(text).hexdigest()})


# --- Folders that never were a run ------------------------------------------------------------------------------------


JOURNALS = {"empty": b"", "text": b"dear diary\n", "lines": b'{"event": 1}\n{"event": 2}\n'}


@pytest.mark.parametrize("words", [(), ("--resume",), ("--overwrite",)], ids=" ".join)
@pytest.mark.parametrize("journal", JOURNALS)
def test_a_strangers_journal_opens_no_folder(sweep, workplace, journal, words):
    folder = workplace / "run"
    folder.mkdir()
    (folder / "journal.jsonl").write_bytes(JOURNALS[journal])
    for name in ("designs.parquet", "states.parquet", "slack_map.png", "thesis.txt"):
        (folder / name).write_bytes(b"years of work")
    before = everything(folder)
    ran = sweep(*words, "--json")
    assert (ran.exit, ran.json["error"]["kind"]) == (7, "folder")
    assert everything(folder) == before


@pytest.mark.parametrize("words", [(), ("--resume",), ("--overwrite",)], ids=" ".join)
def test_a_strangers_journal_alone_is_his(sweep, workplace, words):
    (workplace / "run").mkdir()
    (workplace / "run/journal.jsonl").write_bytes(b"dear diary\n")
    assert sweep(*words).exit == 7
    assert (workplace / "run/journal.jsonl").read_bytes() == b"dear diary\n"


@pytest.mark.parametrize("parts", [10**10, -1, 0, "x", None, [], True])
@pytest.mark.parametrize("words", [("--resume",), ("--overwrite",)], ids=" ".join)
def test_a_journal_that_claims_absurd_parts_is_refused_at_once(sweep, workplace, parts, words):
    assert sweep("--no-figures").exit == 0
    record = json.loads((workplace / "run/run.json").read_text("utf-8"))
    header = {key: record[key] for key in ("study_hash", "results_version", "study", "axes", "sources")}
    text = json.dumps({**header, "tables": ["designs", "states"], "parts": parts}, sort_keys=True).encode()
    (workplace / "run/run.json").unlink()
    (workplace / "run/picture.png").write_bytes(b"his")
    (workplace / "run/journal.jsonl").write_bytes(b"%08x %s\n" % (zlib.crc32(text), text))
    before = everything("run")
    ran = sweep(*words, "--no-figures")
    assert (ran.exit, ran.out) == (7, "")
    assert everything("run") == before


def test_a_refused_folder_stays_as_it_was(sweep, tendon, workplace):
    (workplace / "run").mkdir()
    (workplace / "run/thesis.txt").write_bytes(b"years of work")
    assert sweep().exit == 7
    assert [path.name for path in (workplace / "run").iterdir()] == ["thesis.txt"]
    shutil.rmtree(workplace / "run")
    assert sweep().exit == 0
    (workplace / "run/.lock").unlink()
    before = everything("run")
    assert sweep("--set", "tendon.length=3 m").exit == 7
    assert everything("run") == before
    root = sorted(Path("/").iterdir())
    assert tendon("sweep", "study.toml", "--out", "/").exit == 7
    assert sorted(Path("/").iterdir()) == root


# --- Overwriting ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("before", "after"), [(SEVERAL, ONE), (ONE, SEVERAL), (SEVERAL, SEVERAL)])
def test_overwrite_works_through_a_linked_folder(sweep, workplace, small_parts, hashes_in, before, after):
    (workplace / "elsewhere").mkdir()
    (workplace / "run").symlink_to(workplace / "elsewhere")
    small_parts(before)
    assert sweep("--no-figures").exit == 0
    small_parts(after)
    ran = sweep("--overwrite", "--no-figures", "--set", "tendon.length=3 m", "--json")
    assert ran.exit == 0
    assert (workplace / "run").is_symlink()
    assert hashes_in(workplace / "elsewhere") == {entry["path"]: entry["sha256"] for entry in ran.json["files"]}
    assert sweep("--no-figures", "--set", "tendon.length=3 m").exit == 0


@pytest.mark.parametrize("name", [".DS_Store", "notes.txt", "part-mine.parquet"])
@pytest.mark.parametrize("after", [SEVERAL, ONE])
def test_overwrite_with_a_strangers_file_among_the_parts_works_or_refuses(sweep, workplace, small_parts, name, after):
    small_parts(SEVERAL)
    assert sweep("--no-figures").exit == 0
    (workplace / "run/states.parquet" / name).write_bytes(b"his")
    before = everything("run")
    small_parts(after)
    ran = sweep("--overwrite", "--no-figures", "--set", "tendon.length=3 m")
    assert (workplace / "run/states.parquet" / name).read_bytes() == b"his"
    if ran.exit == 0:
        assert after == SEVERAL
        assert name != "part-mine.parquet"
        assert sweep("--no-figures", "--set", "tendon.length=3 m").exit == 0
    else:
        assert (ran.exit, name in ran.err) == (7, True)
        assert everything("run") == before


@pytest.mark.parametrize("table", ["states", "designs"])
def test_a_strangers_table_is_not_replaced_by_one_that_the_run_had_not(sweep, workplace, table):
    other = "designs" if table == "states" else "states"
    assert sweep("--no-figures", "--set", f'output.tables=["{other}"]').exit == 0
    (workplace / f"run/{table}.parquet").write_bytes(b"his")
    before = everything("run")
    ran = sweep("--no-figures", "--overwrite")
    assert (ran.exit, f"{table}.parquet" in ran.err) == (7, True)
    assert everything("run") == before


# --- Figures ----------------------------------------------------------------------------------------------------------


def test_no_figure_of_an_older_run_stays_after_a_kill_between_picture_and_record(sweep, workplace, monkeypatch):
    """The process dies after its map is in place, and is begun anew without figures."""
    from tendon_cli.engine.folder import RunFolder

    class Killed(BaseException):
        pass

    def killed(_self, _record):
        raise Killed

    with monkeypatch.context() as patch:
        patch.setattr(RunFolder, "finish", killed)
        with pytest.raises(Killed):
            sweep()
    assert (workplace / "run/slack_map.png").exists()
    assert not (workplace / "run/run.json").exists()
    assert sweep("--overwrite", "--no-figures", "--set", "tendon.length=3 m").exit == 0
    assert not (workplace / "run/slack_map.png").exists()


def test_the_same_with_resume_leaves_what_the_record_lists(sweep, workplace, monkeypatch):
    test_no_figure_of_an_older_run_stays_after_a_kill_between_picture_and_record(sweep, workplace, monkeypatch)
    shutil.rmtree(workplace / "run")
    with monkeypatch.context() as patch:
        patch.setattr(journal_module.Journal, "announce", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        assert sweep().exit == 130
    assert not (workplace / "run/slack_map.png").exists()
    ran = sweep("--resume", "--json")
    assert (ran.exit, ran.json["figures"]) == (0, ["slack_map.png"])
    assert not list((workplace / "run").glob(".tendon-*"))


def test_a_strangers_picture_is_not_drawn_over(sweep, workplace):
    assert sweep("--no-figures").exit == 0
    (workplace / "run/slack_map.png").write_bytes(b"his")
    ran = sweep("--json")
    assert (ran.exit, ran.json["figures"]) == (0, [])
    assert any("slack_map.png" in warning for warning in ran.json["warnings"])
    assert (workplace / "run/slack_map.png").read_bytes() == b"his"


@pytest.mark.parametrize("error", [ValueError("odd"), MemoryError(), OSError(28, "No space left on device")])
def test_a_figure_never_costs_a_run(sweep, workplace, monkeypatch, error):
    from tendon_cli.figures import draw

    def broken(*_):
        raise error

    with monkeypatch.context() as patch:
        patch.setattr(draw, "_slack_maps", broken)
        ran = sweep("--json")
    assert (ran.exit, ran.json["figures"]) == (0, [])
    assert any("slack map" in warning for warning in ran.json["warnings"])
    assert (workplace / "run/run.json").exists()
    assert sweep("--json").json["figures"] == ["slack_map.png"]


# --- Records ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("feasible", "x"), ("designs", -1), ("states", 1.5), ("seconds", "long"), ("seconds", float("nan")),
        ("files", [{}]), ("files", ["x"]), ("files", None), ("figures", ["../x.png"]), ("warnings", [1]),
        ("axes", "x"), ("study", []), ("name", 3), ("slack", True), ("parts", None), ("taut", "x"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("words", [(), ("--overwrite",)], ids=" ".join)
def test_a_record_that_is_odd_is_no_record_whatever_its_checksum(sweep, workplace, key, value, words):
    assert sweep("--no-figures").exit == 0
    file = workplace / "run/run.json"
    file.write_text(signed({**json.loads(file.read_text("utf-8")), key: value}), encoding="utf-8")
    before = everything("run")
    ran = sweep("--no-figures", *words, "--json")
    assert (ran.exit, ran.json["error"]["kind"]) == (7, "folder")
    assert everything("run") == before


@pytest.mark.parametrize("name", ["run.json", "journal.jsonl"])
def test_a_pipe_or_a_device_as_record_or_journal_is_refused_at_once(sweep, workplace, name):
    (workplace / "run").mkdir()
    os.mkfifo(workplace / "run" / name)
    assert sweep().exit == 7
    (workplace / "run" / name).unlink()
    (workplace / "run" / name).symlink_to("/dev/zero")
    assert sweep("--resume").exit == 7


# --- Where folders may be ---------------------------------------------------------------------------------------------


def test_a_working_directory_that_is_gone_is_told(outside, sweep, workplace, tmp_path_factory):
    gone = tmp_path_factory.mktemp("gone")
    ran = outside("sweep", workplace / "study.toml", "--json", cwd=gone, preexec_fn=gone.rmdir)
    assert (ran.exit, "working directory" in ran.json["error"]["message"]) == (2, True)


def test_a_study_whose_name_is_not_utf_8_is_swept(outside, sweep, workplace):
    odd = os.fsdecode(b"odd\xff.toml")
    (workplace / odd).write_text('name = "fine"\n' + STUDY, encoding="utf-8")
    assert outside("sweep", odd, "--json", "--no-figures").exit == 0


def test_a_late_part_of_an_older_run_does_not_stay(sweep, workplace, small_parts, monkeypatch):
    """A worker thought dead puts its part in place while another run is being written."""
    small_parts(SEVERAL)
    add = journal_module.Journal.add

    def late(self, result):
        (self.path.parent / "states.parquet/part-00077.parquet").write_bytes(b"of an older run")
        add(self, result)

    monkeypatch.setattr(journal_module.Journal, "add", late)
    assert sweep("--no-figures").exit == 0
    assert not (workplace / "run/states.parquet/part-00077.parquet").exists()
    assert sweep("--no-figures").exit == 0
