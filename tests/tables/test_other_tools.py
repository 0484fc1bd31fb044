"""Other tools read tables and units as written, by the lines that docs/tables.md shows."""

import importlib
import json
import re
from pathlib import Path

import numpy as np
import pytest

import tendon_cli as tendon

PAGE = (Path(__file__).parents[2] / "docs/tables.md").read_text(encoding="utf-8")
STUDY = """
[tendon]
pretension = ["100 N", "130 N"]
[load]
mass = ["0 kg", "5 kg"]
[[cases]]
name = "first"
[[cases]]
name = "second"
"""
SINGLE_FILE = "run/designs.parquet"
PATTERNS = {"DuckDB": "run/designs.parquet/*.parquet"}
"""Names of a table of several parts, for tools that do not read it under the name of its folder."""
TORTURE = [pytest.param(tool, marks=pytest.mark.torture) for tool in ("polars", "DuckDB")]


def line_of(tool, column):
    """Return the code in a row of the page's table."""
    row = re.search(rf"^\| {tool} \| `(.*?)` \| `(.*?)`.* \|$", PAGE, re.MULTILINE)
    return row[column]


def evaluate(tool, code):
    """Return the value of an expression that uses a tool; skip the test if it is not installed."""
    module = "pyarrow.dataset" if tool == "Arrow" else tool.lower()
    pytest.importorskip(module, reason=f"{module} is not installed")
    package = module.partition(".")[0]
    names = {"tendon": tendon, "json": json, package: importlib.import_module(package)}
    return eval(code, names)  # noqa: S307 - our own page


def values_of(tool, table, column):
    """Return the values of a column, one per design."""
    if tool == "xarray":
        return table[column].to_numpy().ravel()
    if tool == "DuckDB":
        return np.asarray(table.df()[column])
    return np.asarray(table[column])


@pytest.mark.parametrize("parts", [1, 4])
@pytest.mark.parametrize("tool", ["pandas", "xarray", "Arrow", *TORTURE])
def test_a_tool_reads_what_was_written_and_its_units(workplace, small_parts, tool, parts):
    small_parts(182 * 8 // parts, 8 // parts)
    (workplace / "study.toml").write_text(STUDY, encoding="utf-8")
    run = tendon.sweep(tendon.study("study.toml"), out="run")
    assert (workplace / SINGLE_FILE).is_dir() == (parts > 1)

    code = line_of(tool, 1)
    if parts > 1:
        code = code.replace(SINGLE_FILE, PATTERNS.get(tool, SINGLE_FILE))
    table = evaluate(tool, code)
    for column in ("margin", "max_tension", "required_pretension"):
        np.testing.assert_array_equal(
            values_of(tool, table, column), run.designs[column].to_numpy()
        )

    if parts == 1:
        units = line_of(tool, 2)
        is_method = units.startswith(".")
        known = evaluate(tool, code + units if is_method else units)
        unit = known["pretension"] if isinstance(known, dict) else known
        assert unit in ("N", b"N")
