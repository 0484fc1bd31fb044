"""Damaged, incomplete or foreign tables are refused; a write that fails leaves what was there."""

import contextlib
import gc
import json
import os
import random
import shutil
from dataclasses import replace

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import tendon_cli
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import InputError, OutputError, Stopped
from tendon_cli.tables import write as write_module
from tendon_cli.tables.read import open_table
from tendon_cli.tables.write import table_file
from tools.torture.disk import Disk
from tools.torture.folders import flip
from tools.torture.hostile.breed import footer_start

STUDY = """
[load]
mass = [0.0, 3.0]
[[cases]]
name = "first"
[[cases]]
name = "second"
[motion]
elbow_angle = { from = "0 deg", to = "170 deg", num = 9 }
"""
OTHER_STUDY = STUDY.replace("[0.0, 3.0]", "[1.0, 4.0]")


@pytest.fixture(scope="module")
def small(new_sweep, tmp_path_factory):
    """Return a finished run of small tables."""
    return new_sweep(STUDY, tmp_path_factory.mktemp("small"))


@pytest.fixture
def parted(new_sweep, tmp_path, small_parts):
    """Return a finished run of four parts."""
    small_parts(18)
    swept = new_sweep(STUDY, tmp_path)
    assert swept.plan.parts == 4
    return swept


def contents(path):
    """Return the rows of a table and its facts."""
    table = open_table(path)
    return table.read(), table.facts


def refusal(path):
    """Return the error with which a table is refused."""
    with pytest.raises(InputError) as error:
        contents(path)
    assert error.value.exit == 3
    assert error.value.message
    return error.value


def is_refused_or_unchanged(file, original):
    """Return True if a table reads as the original or is refused by its name."""
    try:
        return contents(file) == original
    except InputError as error:
        return str(file) in str(error.where)


@pytest.mark.parametrize("fact", ["study_hash", "results_version", "table", "part"])
def test_a_table_that_does_not_say_what_it_is_is_refused(small, tmp_path, fact):
    layout = Sweep(small.plan).layout("designs", 0)
    metadata = {
        key: text
        for key, text in layout.schema.metadata.items()
        if key != b"tendon." + fact.encode()
    }
    shutil.copy(small.folder / "run.json", tmp_path)
    with table_file(
        tmp_path / "designs.parquet", replace(layout, schema=layout.schema.with_metadata(metadata))
    ) as file:
        Sweep(small.plan).fill({"designs": file}, 0)
        file.close()
        file.flush()
    assert "does not say what table it is" in refusal(tmp_path / "designs.parquet").message


# --- Damage ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("where", "flips"), [("pages", 150), ("footer", 300)])
@pytest.mark.parametrize("table", ["designs", "states"])
def test_no_flipped_byte_changes_anything_unnoticed(small, tmp_path, table, where, flips):
    source = small.folder / f"{table}.parquet"
    good = source.read_bytes()
    original = contents(source)
    start = footer_start(good)
    places = range(start) if where == "pages" else range(start, len(good))
    rng = random.Random(20)  # noqa: S311 - a repeatable sample
    file = tmp_path / "table.parquet"
    for place in rng.sample(places, min(flips // 2, len(places))):
        bad = bytearray(good)
        bad[place] ^= rng.randrange(1, 256)
        file.write_bytes(bad)
        assert is_refused_or_unchanged(file, original), place


def test_every_byte_around_the_digest_and_the_end_is_watched(small, tmp_path):
    source = small.folder / "designs.parquet"
    good = source.read_bytes()
    original = contents(source)
    file = tmp_path / "table.parquet"
    digest = good.index(b"tendon.digest")
    around_digest = range(digest - 4, digest + 90)
    end = range(len(good) - 12, len(good))
    for place in (*range(8), *around_digest, *end):
        bad = bytearray(good)
        bad[place] ^= 0x10
        file.write_bytes(bad)
        assert is_refused_or_unchanged(file, original), place


def test_pages_have_checksums_that_other_readers_can_verify(small, tmp_path):
    file = tmp_path / "states.parquet"
    shutil.copy(small.folder / "states.parquet", file)
    pq.read_table(file, page_checksum_verification=True)
    metadata = pq.read_metadata(file)
    content = bytearray(file.read_bytes())
    chunk = metadata.row_group(0).column(metadata.num_columns - 1)
    content[chunk.data_page_offset + chunk.total_compressed_size - 3] ^= 1
    file.write_bytes(content)
    with pytest.raises(OSError, match="CRC"):
        pq.read_table(file, page_checksum_verification=True)


def test_a_table_truncated_anywhere_or_with_something_behind_it_is_refused_by_name(small, tmp_path):
    source = small.folder / "designs.parquet"
    good = source.read_bytes()
    file = tmp_path / "cut.parquet"
    lengths = [0, 1, 4, 7, 8, 11, 12, 100]
    lengths += [footer_start(good), len(good) // 2, len(good) - 8, len(good) - 1]
    truncated = [good[:length] for length in lengths]
    extended = [good + b"\0", good + b"PAR1"]
    for content in truncated + extended:
        file.write_bytes(content)
        assert "cut.parquet" in refusal(file).where
    for tail in (good[-8:], good):
        file.write_bytes(good + tail)
        assert is_refused_or_unchanged(file, contents(source))


@pytest.mark.parametrize("table", ["designs", "states"])
def test_a_table_moved_and_renamed_is_still_whole(small, tmp_path, table):
    shutil.copy(small.folder / f"{table}.parquet", tmp_path / "elsewhere.pq")
    assert contents(tmp_path / "elsewhere.pq") == contents(small.folder / f"{table}.parquet")


# --- Foreign files --------------------------------------------------------------------------------


def nested_lists(depth):
    """Return the type of numbers in lists within lists."""
    nested = pa.float64()
    for _ in range(depth):
        nested = pa.list_(nested)
    return nested


NOISE = random.Random(5).randbytes(3000)  # noqa: S311 - a repeatable sample
PLAIN = pa.table({"design": [0, 1], "margin": [1.0, 2.0]})
FOREIGN = {
    "plain": PLAIN,
    "ours, rewritten": PLAIN.replace_schema_metadata(
        {"tendon.study": "{}", "tendon.table": '"designs"'}
    ),
    "our keys": PLAIN.replace_schema_metadata(
        {"tendon.study": "{", "tendon.digest": "sha256:" + "0" * 64}
    ),
    "nested": pa.table({"deep": pa.nulls(1, nested_lists(60))}),
    "no columns": pa.table({}),
    "odd names": pa.table([[1.0]] * 4, names=["", "a\nb", "\x1b[31m", "a" * 10_000]),
    "same names": pa.table([[1.0], [2.0]], names=["a", "a"]),
    "other types": pa.table(
        {"when": pa.array([0], pa.timestamp("ns", "Europe/Paris")), "what": pa.array([b"\xff"])}
    ),
    "empty": b"",
    "text": b"design,margin\n0,1\n",
    "zip": b"PK\3\4" + bytes(500),
    "magic alone": b"PAR1",
    "two magics": b"PAR1\0\0\0\0PAR1",
    "huge footer": b"PAR1" + b"\xff\xff\xff\x7fPAR1",
    "noise": b"PAR1" + NOISE + b"\x40\0\0\0PAR1",
    "nothing there": None,
}


@pytest.mark.parametrize("kind", [*FOREIGN, "folder"])
def test_what_tendon_did_not_write_is_refused_by_name(tendon, tmp_path, kind):
    file = tmp_path / "foreign.parquet"
    content = FOREIGN.get(kind)
    if kind == "folder":
        file.mkdir()
    elif type(content) is bytes:
        file.write_bytes(content)
    elif content is not None:
        pq.write_table(content, file)
    error = refusal(file)
    assert "foreign.parquet" in error.where
    assert "\n" not in error.message
    ran = tendon("plot", file, "--json")
    assert (ran.exit, ran.json["error"]["kind"]) == (3, "input")


# --- Folders of parts -----------------------------------------------------------------------------


def lose_part_0(folder, _new_sweep):
    (folder / "part-00000.parquet").unlink()


def lose_part_3(folder, _new_sweep):
    (folder / "part-00003.parquet").unlink()


def flip_a_bit_of_part_2(folder, _new_sweep):
    file = folder / "part-00002.parquet"
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 4
    file.write_bytes(content)


def add_a_part(folder, _new_sweep):
    shutil.copy(folder / "part-00001.parquet", folder / "part-00004.parquet")


def take_a_part_of_another_study(folder, new_sweep):
    home = folder.parents[1] / "other"
    home.mkdir()
    other = new_sweep(OTHER_STUDY, home).folder
    shutil.copy(other / "states.parquet/part-00001.parquet", folder)


def take_a_part_of_another_table(folder, _new_sweep):
    shutil.copy(folder.with_name("designs.parquet") / "part-00001.parquet", folder)


HARMS = {
    "part 0": lose_part_0,
    "part 3": lose_part_3,
    "part-00002.parquet": flip_a_bit_of_part_2,
    "states.parquet": add_a_part,
    "another": take_a_part_of_another_study,
    "part-00001.parquet": take_a_part_of_another_table,
}
"""Harm to the states of a run, by the name that the refusal gives it."""


@pytest.mark.parametrize("name", HARMS)
def test_a_folder_of_parts_that_is_not_whole_is_refused_by_name(parted, new_sweep, name):
    folder = parted.folder / "states.parquet"
    HARMS[name](folder, new_sweep)
    error = refusal(folder)
    assert name in f"{error.where} {error.message}"


def test_parts_in_the_wrong_order_are_refused_or_put_in_order(parted):
    folder = parted.folder / "states.parquet"
    original = contents(folder)
    for before, after in ((1, 99999), (2, 1), (99999, 2)):
        (folder / f"part-{before:05d}.parquet").rename(folder / f"part-{after:05d}.parquet")
    assert is_refused_or_unchanged(folder, original)


# --- Writing that fails ---------------------------------------------------------------------------


def cut(file, _size):
    file.truncate(file.seek(0, os.SEEK_END) - 1)


def lengthen(file, _size):
    file.seek(0, os.SEEK_END)
    file.write(b"x")


def turn_a_bit_of_the_footer(file, size):
    file.seek(size - 100)
    byte = file.read(1)[0]
    file.seek(size - 100)
    file.write(bytes([byte ^ 1]))


@pytest.mark.parametrize("damage", [cut, lengthen, turn_a_bit_of_the_footer])
def test_a_file_that_differs_on_the_disk_from_what_was_written_is_not_put_in_place(
    tmp_path, write_states, monkeypatch, damage
):
    fsync = os.fsync

    def fsync_and_damage(handle):
        fsync(handle)
        for path in tmp_path.glob(".*"):
            with path.open("r+b") as file:
                damage(file, path.stat().st_size)

    monkeypatch.setattr(os, "fsync", fsync_and_damage)
    with pytest.raises(OutputError, match="not what was written"):
        write_states(tmp_path / "states.parquet")
    assert not list(tmp_path.iterdir())


def test_rows_that_the_writer_loses_are_missed(tmp_path, write_states, monkeypatch):
    write_table = pq.ParquetWriter.write_table
    calls = []

    def write_fewer_rows_at_first(self, table, **options):
        calls.append(table)
        is_first = len(calls) == 1
        write_table(self, table.slice(0, 3) if is_first else table, **options)

    monkeypatch.setattr(pq.ParquetWriter, "write_table", write_fewer_rows_at_first)
    with pytest.raises(OutputError, match="does not have the rows"):
        write_states(tmp_path / "states.parquet")
    assert not list(tmp_path.iterdir())


@pytest.fixture
def write_states(small, monkeypatch):
    """Return a function that writes a table of states to a file, through a buffer of 64 bytes."""
    monkeypatch.setattr(write_module, "_BYTES_AT_ONCE", 64)

    def write(file):
        task = Sweep(small.plan)
        layout = replace(task.layout("states", 0), at_once=1000, row_group=1000)
        with table_file(file, layout) as table:
            task.fill({"states": table}, 0)
            table.flush()

    return write


@pytest.mark.parametrize("content", [None, b"what stood there"], ids=["new", "replaced"])
def test_a_write_that_fails_changes_nothing_says_only_its_error_and_can_be_done_again(
    tmp_path, write_states, muttered, content
):
    file = tmp_path / "states.parquet"
    expected = [] if content is None else [content]
    with pytest.MonkeyPatch.context() as patch:
        disk = Disk(patch, tmp_path)
        write_states(file)
        kinds = [kind for kind, _ in disk.operations]
        file.unlink()
        if content is not None:
            file.write_bytes(content)
        for number in range(kinds.index("fsync folder")):
            disk.reset(number)
            with pytest.raises(OutputError, match="space") as error:
                write_states(file)
            assert (error.value.exit, error.value.where) == (5, str(file))
            assert [item.read_bytes() for item in tmp_path.iterdir()] == expected
    gc.collect()
    assert muttered == []
    write_states(file)
    assert [item.name for item in tmp_path.iterdir()] == ["states.parquet"]
    assert open_table(file).rows > 0


def test_a_table_that_is_not_finished_leaves_nothing_and_says_nothing(tmp_path, small, muttered):
    layout = Sweep(small.plan).layout("designs", 0)
    with contextlib.suppress(Stopped), table_file(tmp_path / "designs.parquet", layout):
        assert len(list(tmp_path.iterdir())) == 1
        raise Stopped
    gc.collect()
    assert list(tmp_path.iterdir()) == []
    assert muttered == []


def test_what_stands_in_the_place_of_the_temporary_file_is_not_written_through(
    tmp_path, write_states, monkeypatch
):
    precious = tmp_path / "precious"
    precious.write_text("mine", encoding="utf-8")
    with monkeypatch.context() as patch:
        patch.setattr(os, "urandom", bytes)  # so that the name can be foreseen
        (tmp_path / f".tendon-run-{bytes(6).hex()}.tmp").symlink_to(precious)
        with pytest.raises(OutputError):
            write_states(tmp_path / "states.parquet")
    assert precious.read_text(encoding="utf-8") == "mine"
    write_states(tmp_path / "states.parquet")
    assert open_table(tmp_path / "states.parquet").rows > 0


@pytest.mark.parametrize("name", ["tendon.digest", "tendon.digest sha256:" + "0" * 64])
def test_a_case_and_a_title_may_be_anything(new_sweep, tmp_path, name):
    new_sweep(f'title = "{name}"\n[[cases]]\nname = "{name}"\n[[cases]]\nname = "zz"\n', tmp_path)
    file = tmp_path / "run/designs.parquet"
    table, _ = contents(file)
    assert table["case"].to_pylist() == [name, "zz"]
    metadata = pq.read_metadata(file)
    chunks = [metadata.row_group(0).column(index) for index in range(metadata.num_columns)]
    assert {chunk.statistics.min for chunk in chunks if chunk.path_in_schema == "case"} == {name}


# --- In a run's folder ----------------------------------------------------------------------------


TWO_BY_TWO = """
[load]
mass = ["0 kg", "5 kg"]
[spring]
stiffness = ["3 kN/m", "5 kN/m"]
[spool]
ratio = [0.6, 0.7]
"""


@pytest.mark.parametrize(
    ("verb", "table", "tables", "harm"),
    [
        ("sweep", "states", ["designs", "states"], "another's"),
        ("sweep", "states", ["designs"], "another's"),
        ("design", "choices", ["designs"], "another's"),
        ("sweep", "designs", ["designs", "states"], "flipped"),
    ],
    ids=["in the place of its own", "beside its own", "of an answer", "flipped"],
)
def test_a_harmed_table_or_one_of_another_run_is_refused_by_all_that_open_it(
    tendon, workplace, verb, table, tables, harm
):
    (workplace / "study.toml").write_text(TWO_BY_TWO, encoding="utf-8")
    settings = {"mine": f"output.tables={json.dumps(tables)}", "other": "tendon.length=3 m"}
    for name, setting in settings.items():
        words = ("study.toml", "--out", name, "--no-figures", "--set", setting)
        assert tendon(verb, *words).exit in (0, 4)
    if harm == "flipped":
        rng = random.Random(5)  # noqa: S311 - a repeatable sample
        flip(workplace / f"mine/{table}.parquet", rng)
    else:
        shutil.copy(workplace / f"other/{table}.parquet", workplace / "mine")
    commands = [
        ("show", "mine", "--table", table),
        ("show", f"mine/{table}.parquet"),
        ("export", f"mine/{table}.parquet", "out.csv"),
        ("plot", f"mine/{table}.parquet"),
    ]
    if table in tables or verb == "design":
        # These open no table that the run does not have.
        commands += [("report", "mine"), ("check", "mine")]
        with pytest.raises(InputError):
            tendon_cli.open("mine")
    before = sorted(workplace.rglob("*"))
    for words in commands:
        ran = tendon(*words)
        assert ran.exit == 3, (words, ran.err)
        assert f"{table}.parquet" in ran.err, (words, ran.err)
    assert sorted(workplace.rglob("*")) == before
