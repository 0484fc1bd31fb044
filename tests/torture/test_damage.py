"""Parts that are damaged after they were recorded are found, named, and computed anew; nothing else is."""

import os
import random
import shutil
from pathlib import Path

import pytest

from tendon_cli.errors import InputError
from tendon_cli.tables.digest import file_sha256
from tendon_cli.tables.read import open_table

from .test_journal import advance, folder, stopped, whole  # noqa: F401 - fixtures
from .tools import some

TABLES = ("designs", "states")


def delete(file, _chance):
    file.unlink()


def truncate(file, chance):
    os.truncate(file, chance.randrange(file.stat().st_size))


def flip(file, chance):
    content = bytearray(file.read_bytes())
    content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    file.write_bytes(content)


def lengthen(file, chance):
    with file.open("ab") as end:
        end.write(chance.randbytes(chance.randrange(1, 600)))


def lose_sector(file, chance):
    """What a disk gives back for a sector that it lost."""
    content = bytearray(file.read_bytes())
    start = chance.randrange(len(content)) // 512 * 512
    content[start : start + 512] = bytes(len(content[start : start + 512]))
    file.write_bytes(content)


def link(file, _chance):
    """The same bytes, but somewhere else: not a file of the run any more."""
    elsewhere = file.parents[2] / f"elsewhere-{file.parent.name}-{file.name}"
    shutil.move(file, elsewhere)
    file.symlink_to(elsewhere)


def swap(file, _chance):
    """A whole part, but that of another table."""
    other = file.parents[1] / ("designs.parquet" if file.parent.name == "states.parquet" else "states.parquet")
    file.write_bytes((other / file.name).read_bytes() if (other / file.name).exists() else b"")


def fold(file, _chance):
    """A folder where the file was."""
    file.unlink()
    file.mkdir()


HARMS = [delete, truncate, flip, lengthen, lose_sector, link, swap]


def parts_of(run):
    return sorted(run.glob("*.parquet/part-*.parquet"))


def harm_some(run, chance):
    """Harm some files of a run; returns them, and how."""
    files = parts_of(run)
    chosen = chance.sample(files, chance.randrange(1, len(files)))
    return {file: chance.choice(HARMS) for file in chosen}, {file: file.stat().st_mtime_ns for file in files}


def name_of(folder, file):  # noqa: F811
    return str(file.relative_to(folder.path))


def stands(file, sha256):
    return file.exists() and not file.is_symlink() and file_sha256(file) == sha256


def number(file):
    return int(file.stem.removeprefix("part-"))


@pytest.mark.parametrize("finished", [True, False], ids=["finished", "unfinished"])
@pytest.mark.parametrize("seed", some([0, 1], range(2, 60)))
def test_resume_redoes_exactly_the_parts_that_were_harmed(folder, whole, hashes_in, finished, seed):  # noqa: F811
    chance = random.Random(seed)  # noqa: S311 - a repeatable sample
    advance(folder) if finished else stopped(folder, 3)
    harmed, before = harm_some(folder.path, chance)
    for file, harm in harmed.items():
        harm(file, chance)
    harmed = [
        file for file in harmed if not stands(file, whole[name_of(folder, file)])
    ]  # two swaps may undo each other
    record, _ = advance(folder)
    assert hashes_in(folder.path) == whole, harmed
    redone = {number(file) for file in harmed}
    kept = {file: at for file, at in before.items() if number(file) not in redone}
    assert {file: file.stat().st_mtime_ns for file in kept} == kept
    if finished:
        assert sorted(record["repaired"]) == sorted(name_of(folder, file) for file in harmed)
    else:
        assert record["resumed_parts"] == 3 - len(redone)
    assert advance(folder)[1]


@pytest.mark.parametrize("harm", [*HARMS, fold], ids=lambda harm: harm.__name__)
@pytest.mark.parametrize("table", TABLES)
def test_readers_refuse_a_harmed_table_by_name(tendon, folder, harm, table):  # noqa: F811
    advance(folder)
    file = folder.path / f"{table}.parquet/part-00002.parquet"
    harm(file, random.Random(5))  # noqa: S311 - a repeatable sample
    if harm is link:
        return  # the same bytes, wherever they stand: a reader may take them
    for source, words in ((folder.path, ("--table", table)), (file.parent, ())):
        ran = tendon("plot", source, *words, "--out", "figure.png", "--json")
        assert (ran.exit, ran.json["error"]["kind"]) == (3, "input")
        assert f"{table}.parquet" in ran.json["error"]["where"]
        assert "part-00002" in ran.json["error"]["where"] + ran.json["error"]["message"] or "part 2" in ran.out
        assert not Path("figure.png").exists()
    with pytest.raises(InputError):
        open_table(file.parent)


def test_a_folder_in_the_place_of_a_part_is_one_message(tendon, folder, small_parts):  # noqa: F811
    advance(folder)
    fold(folder.path / "states.parquet/part-00001.parquet", None)
    ran = tendon("sweep", folder.path.parent / "study.toml", "--out", folder.path, "--resume", "--no-figures", "--json")
    assert ran.exit in (5, 7)
    assert "part-00001" in ran.out


# --- Flips -----------------------------------------------------------------------------------------------------------


def footer_start(content):
    return len(content) - 8 - int.from_bytes(content[-8:-4], "little")


def contents(file):
    table = open_table(file)
    return table.read(), table.facts, [(field.name, field.metadata) for field in table.schema], table.schema.metadata


@pytest.mark.torture
@pytest.mark.parametrize(("where", "flips"), [("pages", 200), ("footer", 1500)])
@pytest.mark.parametrize("table", TABLES)
def test_no_flipped_bit_changes_a_value_a_name_a_unit_or_the_study(new_sweep, tmp_path, table, where, flips):
    text = '[load]\nmass = [0.0, 3.0]\n[[cases]]\nname = "first"\n[[cases]]\nname = "second"\n'
    source = new_sweep(text, tmp_path).folder / f"{table}.parquet"
    good, original, file = source.read_bytes(), contents(source), tmp_path / "flipped.parquet"
    start = footer_start(good)
    places = range(8 * start) if where == "pages" else range(8 * start, 8 * len(good))
    noticed = 0
    for place in random.Random(1).sample(places, flips):  # noqa: S311 - a repeatable sample
        bad = bytearray(good)
        bad[place // 8] ^= 1 << place % 8
        file.write_bytes(bad)
        try:
            assert contents(file) == original, place
        except InputError as error:
            noticed += "flipped.parquet" in (error.where or "")
    assert noticed == flips
