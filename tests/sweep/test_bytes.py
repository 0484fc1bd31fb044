"""The bytes of a table follow from the study alone; memory does not follow from its size."""

import hashlib
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
from tendon_cli import cli
with contextlib.suppress(SystemExit):
    axis = "load.mass={ from = 0, to = 9, num = %d }"
    cli.main(["sweep", "study.toml", "--no-figures", "--jobs", "1", "--quiet", "--set", axis])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.parametrize("text", [STUDY, WIDE], ids=["everything", "wide"])
def test_bytes_are_the_same_for_any_number_of_jobs_and_any_blocks(
    new_sweep, tmp_path, small_parts, text
):
    small_parts(100 if text == STUDY else 500, 40)
    runs = [
        new_sweep(
            text, tmp_path, jobs=jobs, block_states=block_states, out=f"{jobs}-{block_states}"
        )
        for jobs, block_states in [
            (1, 2**16),
            (2, 2**16),
            (4, 2**16),
            (2, 1),
            (1, 5),
            (4, 37),
            (1, 250),
        ]
    ]
    assert runs[0].plan.parts > 3
    assert len(runs[0].hashes) == 2 * runs[0].plan.parts
    assert all(run.hashes == runs[0].hashes for run in runs)


@pytest.mark.parametrize("block_states", [2**16, 999, 140_003])
def test_bytes_are_the_same_where_a_single_design_exceeds_a_block(
    new_sweep, tmp_path, block_states
):
    usual = new_sweep(LONG, tmp_path, out="usual")
    other = new_sweep(LONG, tmp_path, out="other", block_states=block_states)
    assert usual.plan.states_per_design > 2**16
    assert usual.hashes == other.hashes


def test_several_parts_are_a_folder_of_numbered_files_with_the_rows_of_one(
    new_sweep, tmp_path, small_parts
):
    """Their record has the hash of each, and other readers take them for one table."""
    one = new_sweep(WIDE, tmp_path, out="one")
    assert sorted(one.hashes) == ["designs.parquet", "states.parquet"]
    rows = {table: one.table(table).read() for table in ("designs", "states")}
    small_parts(1000)
    several = new_sweep(WIDE, tmp_path, out="several")
    parts = [f"part-{index:05d}.parquet" for index in range(several.plan.parts)]
    assert sorted(several.hashes) == [
        f"{table}.parquet/{part}" for table in ("designs", "states") for part in parts
    ]
    for table, expected in rows.items():
        assert (
            several.table(table)
            .read()
            .replace_schema_metadata()
            .equals(expected.replace_schema_metadata())
        )
    assert {entry["path"]: entry["sha256"] for entry in several.record["files"]} == several.hashes
    for entry in several.record["files"]:
        content = (several.folder / entry["path"]).read_bytes()
        assert (entry["size"], entry["sha256"]) == (
            len(content),
            hashlib.sha256(content).hexdigest(),
        )
        assert entry["rows"] == pq.read_metadata(several.folder / entry["path"]).num_rows
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
    for designs in (550, 22_000):  # of 182 states each
        ran = outside("-c", MEMORY % designs, python=True)
        peaks.append(int(ran.out))
        for file in workplace.rglob("*.parquet"):
            assert file.is_dir() or file.unlink() is None
        for file in workplace.rglob("*.json"):
            file.unlink()
        for folder in sorted(workplace.rglob("*.parquet")):
            folder.rmdir()
    assert peaks[1] < 1.15 * peaks[0], peaks
