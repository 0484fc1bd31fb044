"""A column is one entry of a table of quantities.

The entries that the page for contributors shows are in tables, commands and studies at once.
"""

import json
import os
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tendon_cli.kernel import NO_COMPILED_VARIABLE

PAGE = Path(__file__).parents[2] / "CONTRIBUTING.md"
OF_STATES = "flexor_friction_force"
OF_DESIGNS = "mean_motor_torque"
STUDY = """
[tendon]
pretension = ["90 N", "130 N"]
[spool]
ratio = [0.6, 1.0]
[load]
mass = ["0 kg", "5 kg"]
[motion]
elbow_angle = { from = "0 deg", to = "170 deg", num = 18 }
"""
COMMANDS = r"""
import importlib.util, json, re, sys
from pathlib import Path

entries = json.loads(sys.argv[1])
spec = importlib.util.find_spec("tendon_cli.quantities")
source = Path(spec.origin).read_text(encoding="utf-8")
for table, entry in entries.items():
    start = re.compile(rf"^{table} = \(.*\n", re.MULTILINE)
    source, times = start.subn(lambda match: match[0] + entry, source)
    assert times == 1, table
sys.modules[spec.name] = module = importlib.util.module_from_spec(spec)
exec(compile(source, spec.origin, "exec"), module.__dict__)

from tendon_cli.commands.cli import main

for words in sys.argv[2:]:
    try:
        main(words.split())
    except SystemExit as end:
        assert not end.code, words
"""
"""Program that runs commands of a package with more entries in its tables of quantities."""


@pytest.fixture(scope="module")
def entries():
    """Return the entries that the page shows, by the name of their table."""
    text = PAGE.read_text(encoding="utf-8")
    shown = re.compile(r"^(_OF_\w+) = \(\n    \.\.\.\n(.*?)^\)$", re.MULTILINE | re.DOTALL)
    return dict(shown.findall(text))


@pytest.mark.parametrize("compiled", [True, False])
def test_a_column_is_an_entry_in_one_table(outside, workplace, entries, compiled):
    assert [*entries] == ["_OF_STATES", "_OF_DESIGNS"]
    Path("study.toml").write_text(STUDY, encoding="utf-8")
    Path("kept.toml").write_text(f'{STUDY}[output]\nstates = ["{OF_STATES}"]\n', encoding="utf-8")
    ran = outside(
        "-c",
        COMMANDS,
        json.dumps(entries),
        "sweep study.toml --no-figures --out run --allow-no-equilibrium --quiet",
        "sweep kept.toml --no-figures --out kept --allow-no-equilibrium --quiet",
        f"show run --table states --columns {OF_STATES} --sort -{OF_STATES} --head 1",
        f"show run --columns {OF_DESIGNS} --csv --head 0",
        python=True,
        env={**os.environ, NO_COMPILED_VARIABLE: "" if compiled else "1"},
    )
    assert ran.exit == 0, ran.err
    states = pd.read_parquet("run/states.parquet")
    designs = pd.read_parquet("run/designs.parquet")

    expected = (states["flexor_tension_proximal"] - states["flexor_tension_distal"]).abs()
    np.testing.assert_array_equal(states[OF_STATES], expected)
    assert states.attrs["units"][OF_STATES] == "N"
    long_name = "what friction in the sheath takes of the flexor tension"
    assert states.attrs["long_names"][OF_STATES] == long_name
    assert (states[OF_STATES].isna() == (states["status"] == "no equilibrium")).all()
    assert 0 < states[OF_STATES].isna().sum() < len(states)

    by_design = states.groupby("design")["motor_torque"]
    mean = by_design.mean().where(by_design.count() == by_design.size())
    np.testing.assert_allclose(designs[OF_DESIGNS], mean, rtol=1e-12)
    assert designs.attrs["units"][OF_DESIGNS] == "N m"

    kept = pd.read_parquet("kept/states.parquet")
    assert [name for name in kept if name not in designs] == ["direction", "elbow_angle", OF_STATES]
    np.testing.assert_array_equal(kept[OF_STATES], expected)
    assert ran.out.split()[:3] == [OF_STATES, "N", f"{expected.max():.6g}"]
    assert f"{OF_DESIGNS} (N m)" in ran.out
