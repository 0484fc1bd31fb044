"""How the columns of a table lie in its file: words by dictionary, numbers that repeat as small as that."""

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


@pytest.fixture(scope="module")
def stored(new_sweep, tmp_path_factory):
    return new_sweep(STUDY, tmp_path_factory.mktemp("stored")).folder


def columns_of(file):
    metadata = pq.ParquetFile(file).metadata
    return {
        metadata.schema.column(at).path: metadata.row_group(0).column(at)
        for at in range(metadata.num_columns)
    }


REPEATING = {"pretension", "load_mass", "elbow_angle", "spring_stiffness", "design"}


@pytest.mark.parametrize("table", ["designs", "states"])
def test_numbers_that_repeat_are_as_small_as_in_a_dictionary(stored, table, tmp_path):
    columns = columns_of(stored / f"{table}.parquet")
    assert {
        name for name, column in columns.items() if column.compression == "ZSTD"
    } >= REPEATING & set(columns)
    pattern = {
        "one": np.full(2**17, 0.07),
        "many": np.resize(np.repeat(np.linspace(0.0, 1.0, 91), 7), 2**17),
    }
    kept = [Column(name, "number", "1", name, is_axis=True, nullable=False) for name in pattern]
    groups = RowGroups(BytesIO(), TableLayout(tuple(kept), schema_of(kept, {}), 2**17))

    def write(to, rows):
        for name, values in pattern.items():
            to[name][...] = values[rows.start : rows.stop]

    groups.fill(2**17, write)
    ours = groups.close().size
    pq.write_table(
        pa.table(pattern), tmp_path / "rival.parquet", compression="snappy", use_dictionary=True
    )
    assert ours < (tmp_path / "rival.parquet").stat().st_size


@pytest.mark.parametrize("each", [1, 182])
def test_numbers_of_designs_take_next_to_nothing(each, tmp_path):
    kept = [Column("design", "count", "1", "number of the design, from 0")]
    numbers, file = 10**9 + np.arange(2**17) // each, tmp_path / "numbers.parquet"
    with file.open("wb") as opened:
        groups = RowGroups(opened, TableLayout(tuple(kept), schema_of(kept, {}), 2**17))
        groups.fill(
            2**17,
            lambda to, rows: to["design"].__setitem__(slice(None), numbers[rows.start : rows.stop]),
        )
        groups.close()
    column = pq.read_metadata(file).row_group(0).column(0)
    assert column.total_compressed_size < 2**17 / 64
    assert np.array_equal(pq.read_table(file)["design"].to_numpy(), numbers)
