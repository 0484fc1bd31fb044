"""How the columns of a table lie in its file: what repeats by dictionary, what does not as plain numbers."""

import pyarrow.parquet as pq
import pytest

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


@pytest.mark.parametrize(
    ("table", "repeating"),
    [
        ("designs", {"pretension", "load_mass", "case"}),
        ("states", {"pretension", "load_mass", "case", "direction", "elbow_angle", "status"}),
    ],
)
def test_axes_and_words_are_kept_by_dictionary_and_results_are_not(stored, table, repeating):
    metadata = pq.ParquetFile(stored / f"{table}.parquet").metadata
    columns = {metadata.schema.column(at).path: metadata.row_group(0).column(at) for at in range(metadata.num_columns)}
    by_dictionary = {name for name, column in columns.items() if any("DICTIONARY" in word for word in column.encodings)}
    assert repeating <= by_dictionary
    results = {"motor_torque", "elbow_stiffness", "max_tension", "margin", "design"} & set(columns)
    assert results
    assert not results & by_dictionary
