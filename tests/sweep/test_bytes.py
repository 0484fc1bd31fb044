"""The bytes of a table follow from the study alone; memory does not follow from its size."""

import hashlib
import shutil
import sys

import pyarrow.parquet as pq
import pytest

from tendon_cli.tables.schema import ROW_GROUP

from .studies import STUDY

WIDE = """
[tendon]
pretension = { from = "60 N", to = "240 N", num = 13 }
[spring]
stiffness = ["1 kN/m", "2 kN/m", "3 kN/m"]
[load]
mass = ["0 kg", "5 kg", "10 kg"]
[motion]
elbow_angle = { from = "0 deg", to = "160 deg", num = 17 }
"""

LONG = '[motion]\nelbow_angle = { from = "0 deg", to = "90 deg", num = 70001 }\n'

MEMORY = """
import contextlib, resource, sys
from tendon_cli.commands import cli
with contextlib.suppress(SystemExit):
    axis = "load.mass={ from = 0, to = 9, num = %d }"
    options = ["--no-figures", "--jobs", "1", "--quiet", "--out", "run"]
    cli.main(["sweep", "study.toml", *options, "--set", axis])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.parametrize("text", [STUDY, WIDE], ids=["everything", "wide"])
def test_bytes_are_the_same_for_any_number_of_jobs_and_any_blocks(
    new_sweep, tmp_path, small_parts, text
):
    small_parts(100 if text == STUDY else 500, 40)
    first = new_sweep(text, tmp_path, jobs=1, block_states=2**16, out="first")
    assert first.plan.parts > 3
    assert len(first.hashes) == 2 * first.plan.parts
    for jobs, block_states in ((2, 2**16), (4, 37), (1, 5)):
        out = f"{jobs}-{block_states}"
        run = new_sweep(text, tmp_path, jobs=jobs, block_states=block_states, out=out)
        assert run.hashes == first.hashes


@pytest.mark.parametrize("block_states", [999, 140_003])
def test_bytes_are_the_same_where_a_single_design_exceeds_a_block(
    new_sweep, tmp_path, block_states
):
    usual = new_sweep(LONG, tmp_path, out="usual")
    in_blocks = new_sweep(LONG, tmp_path, out="in_blocks", block_states=block_states)
    assert usual.plan.states_per_design > 2**16
    assert in_blocks.hashes == usual.hashes


def test_several_parts_are_a_folder_of_numbered_files_with_the_rows_of_one(
    new_sweep, tmp_path, small_parts
):
    """The record has the hash of each file, and other readers take them for one table."""
    single = new_sweep(WIDE, tmp_path, out="single")
    assert sorted(single.hashes) == ["designs.parquet", "states.parquet"]
    small_parts(1000)
    several = new_sweep(WIDE, tmp_path, out="several")
    parts = [f"part-{index:05d}.parquet" for index in range(several.plan.parts)]
    of_designs = [f"designs.parquet/{part}" for part in parts]
    of_states = [f"states.parquet/{part}" for part in parts]
    assert sorted(several.hashes) == of_designs + of_states
    for table in ("designs", "states"):
        expected = single.table(table).read().replace_schema_metadata()
        rows = several.table(table).read().replace_schema_metadata()
        assert rows.equals(expected)
    files = several.record["files"]
    assert {entry["path"]: entry["sha256"] for entry in files} == several.hashes
    for entry in files:
        path = several.folder / entry["path"]
        content = path.read_bytes()
        assert entry["size"] == len(content)
        assert entry["sha256"] == hashlib.sha256(content).hexdigest()
        assert entry["rows"] == pq.read_metadata(path).num_rows
    assert pq.read_table(several.folder / "states.parquet").num_rows == several.plan.states


MANY = """
load = { mass = { from = 0, to = 9, num = 140000 } }
motion = { elbow_angle = "1 rad", direction = "flexion" }
output = { tables = "designs" }
"""


@pytest.mark.parametrize(
    ("text", "table", "rows"), [(LONG, "states", 140_002), (MANY, "designs", 140_000)]
)
def test_row_groups_have_2_to_the_17_rows(new_sweep, tmp_path, text, table, rows):
    metadata = pq.read_metadata(new_sweep(text, tmp_path).folder / f"{table}.parquet")
    lengths = [metadata.row_group(index).num_rows for index in range(metadata.num_row_groups)]
    assert ROW_GROUP == 2**17
    assert lengths == [2**17, rows - 2**17]


@pytest.mark.skipif(sys.platform != "linux", reason="ru_maxrss is in other units elsewhere")
def test_memory_does_not_grow_with_the_product(outside, workplace):
    (workplace / "study.toml").write_text("", encoding="utf-8")
    peaks = []
    for designs in (550, 8_000):  # of 182 states each
        ran = outside("-c", MEMORY % designs, python=True)
        peaks.append(int(ran.out))
        shutil.rmtree(workplace / "run")
    small, large = peaks
    assert large < 1.15 * small, peaks
