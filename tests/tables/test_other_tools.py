"""The lines by which other tools read tables, as docs/tables.md shows them, give what was written, with its units."""

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
FOLDERS = {"DuckDB": "run/designs.parquet/*.parquet"}
"""How a tool names a table of several parts, where not as one of a single file."""
TORTURE = [pytest.param(tool, marks=pytest.mark.torture) for tool in ("polars", "DuckDB")]


def line_of(tool, column):
    """The code in a row of the page's table."""
    row = re.search(rf"^\| {tool} \| `(.*?)` \| `(.*?)`.* \|$", PAGE, re.MULTILINE)
    return row[column]


def evaluated(tool, code):
    module = {"Arrow": "pyarrow.dataset"}.get(tool, tool.lower())
    pytest.importorskip(module, reason=f"{module} is not installed")
    names = {module.partition(".")[0]: importlib.import_module(module.partition(".")[0])}
    return eval(code, {"tendon": tendon, "json": json} | names)  # noqa: S307 - our own page


def numbers(tool, table, column):
    """A column's values, one a design."""
    if tool == "xarray":
        return table[column].to_numpy().ravel()
    return np.asarray({"DuckDB": lambda: table.df()[column]}.get(tool, lambda: table[column])())


@pytest.mark.parametrize("parts", [1, 4])
@pytest.mark.parametrize("tool", ["pandas", "xarray", "Arrow", *TORTURE])
def test_a_tool_reads_what_was_written_and_its_units(workplace, small_parts, tool, parts):
    small_parts(182 * 8 // parts, 8 // parts)
    (workplace / "study.toml").write_text(STUDY, encoding="utf-8")
    run = tendon.sweep(tendon.load_study("study.toml"), out="run")
    assert (workplace / "run/designs.parquet").is_dir() == (parts > 1)
    code = line_of(tool, 1)
    if parts > 1:
        code = code.replace("run/designs.parquet", FOLDERS.get(tool, "run/designs.parquet"))
    table = evaluated(tool, code)
    for column in ("margin", "max_tension", "required_pretension"):
        np.testing.assert_array_equal(numbers(tool, table, column), run.designs[column].to_numpy())
    units = line_of(tool, 2)
    if parts == 1:
        known = evaluated(tool, code + units if units.startswith(".") else units)
        assert (known["pretension"] if isinstance(known, dict) else known) in ("N", b"N")
