"""Rivals of the benchmark: they compute and write the same as tendon."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from tendon_cli.engine.plan import Plan
from tendon_cli.quantities import OF_DESIGNS
from tendon_cli.studies.load import load_study

sys.path.append(str(Path(__file__).parents[1]))  # benchmarks are not installed

from benchmarks import expert, fused, kernel, measure, report, rivals, studies


def assert_close(found, expected):
    """Compare within 1e-9, and null in the same rows; text and truth exactly."""
    if expected.dtype.kind != "f":
        np.testing.assert_array_equal(np.asarray(found), np.asarray(expected))
    else:
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.fixture(scope="module")
def both_tables(new_sweep, tmp_path_factory):
    return new_sweep(studies.states_study(4, 3, 3), tmp_path_factory.mktemp("states"))


def test_the_script_of_the_expert_writes_the_states_table(both_tables):
    ours = both_tables.states
    theirs = expert.table(4, 3, 3).to_pandas()
    assert list(theirs) == list(ours)
    for name in ours:
        assert_close(theirs[name], ours[name])


DESIGNS = studies.designs_study(5, 3, 4, 3).replace('"20 N"', '"0 N"')


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize(
    "study", [DESIGNS, studies.windows_study(3, 4, 3)], ids=["designs", "windows"]
)
@pytest.mark.parametrize(("lowest", "highest"), [("-15 deg", "90 deg"), ("-110 deg", "60 deg")])
def test_the_loop_in_c_computes_the_designs_table(new_sweep, tmp_path, study, lowest, highest):
    """Either side of the hanging arm, so that each tendon goes slack; also without equilibrium."""
    study += f'[motion]\nelbow_angle = {{ from = "{lowest}", to = "{highest}", num = 53 }}\n'
    ours = new_sweep(study, tmp_path).designs
    loop = fused.Fused(Plan(load_study(tmp_path / "study.toml")), tmp_path)
    loop.run(2)
    results = [name for name in (*OF_DESIGNS, "taut") if name not in fused.LEFT_OUT]
    assert results == list(fused.RESULTS)
    assert ours["slack_fraction"].max() > 0
    assert ours["pretension_from"].isna().all() == (lowest == "-110 deg")
    for name, column in loop.columns().items():
        assert_close(column, ours[name].astype(np.float64))


def test_the_loop_in_c_refuses_other_axes(configs, tmp_path):
    with pytest.raises(ValueError, match=r"spool\.ratio"):
        fused.Fused(Plan(load_study(configs / "quickstart.toml")), tmp_path)


def test_the_kernel_is_measured_over_all_parts(tmp_path, small_parts):
    small_parts(2000, 7)
    file = studies.written(studies.designs_study(3, 2, 2, 2), tmp_path / "study.toml")
    plan = Plan(load_study(file))
    seen = []

    class Watched(kernel.Sweep):
        def fill_designs(self, tables, designs):
            seen.append(designs)
            return super().fill_designs(tables, designs)

    assert kernel.tendon(Watched(plan), 2).processor > 0
    assert sorted(design for part in seen for design in part) == list(range(plan.designs))


@pytest.mark.parametrize("table", ["states", "designs"])
def test_a_bare_write_has_the_rows_and_the_encoding_of_a_run(
    both_tables, tmp_path, monkeypatch, table
):
    monkeypatch.setattr(rivals, "TABLES", (table,))
    ready = rivals.Ready(both_tables.folder, tmp_path / "bare", 2)
    assert ready.write().seconds > 0
    files = sorted(tmp_path.glob("bare-*.parquet"))
    [original] = rivals.table_files(both_tables.folder, table)
    rows = [pq.read_metadata(file).num_rows for file in files]
    assert sum(rows) == pq.read_metadata(original).num_rows
    ours = pq.read_metadata(original).row_group(0)
    theirs = pq.read_metadata(files[0]).row_group(0)
    for index in range(ours.num_columns):
        for name in ("encodings", "compression", "is_stats_set"):
            assert getattr(ours.column(index), name) == getattr(theirs.column(index), name)
    ready.flush()
    assert not list(tmp_path.glob("bare-*"))


def test_parts_of_a_table_are_put_together_in_order(new_sweep, tmp_path, small_parts):
    small_parts(2000)
    swept = new_sweep(studies.states_study(3, 2, 2), tmp_path)
    files = rivals.table_files(swept.folder, "states")
    assert len(files) > 1
    whole = rivals.in_memory(files)
    assert whole.column("design").to_pylist() == sorted(swept.states["design"])
    assert all(column.num_chunks == 1 for column in whole.columns)


def test_memory_and_processor_time_are_those_of_the_process():
    """Measure from a small process: the peak of a process begins with that of its parent."""
    measured = (
        "import time; held = b'x' * 60_000_000; time.sleep(0.3)\n"
        "while time.process_time() < 0.3: pass"
    )
    measuring = (
        "import sys; from benchmarks.measure import run; "
        f"c = run([sys.executable, '-c', {measured!r}]); "
        "print(c.memory, c.processor, c.seconds)"
    )
    command = [sys.executable, "-c", measuring]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=measure.ROOT)
    memory, processor, seconds = map(float, done.stdout.split())
    assert (60e6 < memory < 90e6, processor > 0.3, seconds > 0.3) == (True, True, True)


def test_a_command_that_fails_is_no_measurement():
    with pytest.raises(RuntimeError, match="out of paper"):
        measure.run([sys.executable, "-c", "raise SystemExit('out of paper')"])


def times(*runs):
    return measure.Times(tuple(measure.Took(*run) for run in runs))


def test_the_ratio_of_pairs_is_their_median():
    ours = times((2.0, 1.0), (30.0, 8.0), (4.0, 1.0))
    theirs = times((1.0, 1.0), (10.0, 1.0), (1.0, 1.0))
    ratio = report.Ratio.of("name", ours, theirs, 1.25)
    assert (ratio.value, ratio.spread, ratio.processor) == (3.0, (2.0, 4.0), 1.0)


@pytest.mark.parametrize(
    ("value", "bound", "met"),
    [
        (1.2, "at most", True),
        (1.3, "at most", False),
        (1.3, "at least", True),
        (None, "at most", None),
    ],
)
def test_a_target_is_met_or_not(value, bound, met):
    ratio = report.Ratio("name", value, 1.25, bound)
    assert ratio.met is met
    assert ("MISSED" in ratio.line()) is (met is False)


def test_the_history_grows_by_a_line(tmp_path):
    measured = report.Report()
    measured.add(report.Ratio("a / b", 1.0, 2.0))
    measured.times["a"] = times((1.23456, 2.5))
    for _ in range(2):
        report.append(measured.record({"version": "1"}, {"cores": 2}), tmp_path / "history.jsonl")
    lines = (tmp_path / "history.jsonl").read_text().splitlines()
    assert len(lines) == 2
    assert json.loads(lines[0])["processor_seconds"] == {"a": [2.5]}
