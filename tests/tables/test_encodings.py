"""Columns are stored in little room: words by dictionary, repeated numbers as small as that."""

from io import BytesIO

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tendon_cli.tables.schema import Column, TableLayout, schema_of
from tendon_cli.tables.write import RowGroups

STUDY = """
[tendon]
pretension = ["60 N", "120 N"]
[load]
mass = [0.0, 3.0]
[[cases]]
name = "first"
[[cases]]
name = "second"
"""
ROWS = 2**17
REPEATING = {"pretension", "load_mass", "elbow_angle", "spring_stiffness", "design"}
"""Columns of numbers that repeat."""


@pytest.fixture(scope="module")
def stored(new_sweep, tmp_path_factory):
    """Return the folder of a finished run."""
    return new_sweep(STUDY, tmp_path_factory.mktemp("stored")).folder


def chunks_in(file):
    """Return the metadata of the first chunk of every column, by the name of the column."""
    metadata = pq.ParquetFile(file).metadata
    row_group = metadata.row_group(0)
    return {
        metadata.schema.column(index).path: row_group.column(index)
        for index in range(metadata.num_columns)
    }


def row_groups(file, columns):
    """Return the writer of a table of one row group."""
    return RowGroups(file, TableLayout(tuple(columns), schema_of(columns, {}), ROWS))


@pytest.mark.parametrize("table", ["designs", "states"])
def test_numbers_that_repeat_are_as_small_as_in_a_dictionary(stored, table, tmp_path):
    chunks = chunks_in(stored / f"{table}.parquet")
    by_zstandard = {name for name, chunk in chunks.items() if chunk.compression == "ZSTD"}
    assert by_zstandard >= REPEATING & set(chunks)

    values = {
        "one": np.full(ROWS, 0.07),
        "many": np.resize(np.repeat(np.linspace(0.0, 1.0, 91), 7), ROWS),
    }
    columns = [Column(name, "number", "1", name, is_axis=True, nullable=False) for name in values]
    groups = row_groups(BytesIO(), columns)

    def write(targets, rows):
        for name, column in values.items():
            targets[name][...] = column[rows.start : rows.stop]

    groups.fill(ROWS, write)
    size = groups.close().size
    rival = tmp_path / "rival.parquet"
    pq.write_table(pa.table(values), rival, compression="snappy", use_dictionary=True)
    assert size < rival.stat().st_size


@pytest.mark.parametrize("states_per_design", [1, 182])
def test_numbers_of_designs_take_next_to_nothing(states_per_design, tmp_path):
    columns = [Column("design", "count", "1", "number of the design, from 0")]
    numbers = 10**9 + np.arange(ROWS) // states_per_design
    file = tmp_path / "numbers.parquet"

    def write(targets, rows):
        targets["design"][:] = numbers[rows.start : rows.stop]

    with file.open("wb") as opened:
        groups = row_groups(opened, columns)
        groups.fill(ROWS, write)
        groups.close()
    chunk = pq.read_metadata(file).row_group(0).column(0)
    assert chunk.total_compressed_size < ROWS / 64
    assert np.array_equal(pq.read_table(file)["design"].to_numpy(), numbers)
