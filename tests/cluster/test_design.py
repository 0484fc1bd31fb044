"""Choices solved on a cluster give the answer that they give here, to the byte, and a cluster that is gone is told."""

import json
from pathlib import Path

import pytest

pytest.importorskip("distributed", reason="the extra tendon-cli[dask] is not installed")

STUDY = """
name = "suit"
[spring]
stiffness = { from = "3 kN/m", to = "8 kN/m", num = 20 }
[spool]
ratio = { from = 0.5, to = 0.7, num = 15 }
[load]
mass = { from = "0 kg", to = "3 kg", num = 4000 }
[motion]
elbow_angle = ["0 deg", "45 deg", "90 deg"]
[design]
maximise = ["tolerance"]
"""
"""300 choices of 4000 conditions: three parts."""

DESIGN = ("design", "suit.toml", "--no-figures", "--json")


def test_the_answer_is_that_of_this_machine_to_the_byte(tendon, workplace, cluster, hashes_in):
    (workplace / "suit.toml").write_text(STUDY, encoding="utf-8")
    here = tendon(*DESIGN, "--out", "here")
    there = tendon(*DESIGN, "--out", "there", "--scheduler", cluster.address)
    assert (there.exit, there.err) == (0, ""), there.out
    assert len(list(Path("there/choices.parquet").iterdir())) == 3
    assert hashes_in(Path("there")) == hashes_in(Path("here"))
    differ = {"seconds", "checksum"}
    assert {k: v for k, v in there.json.items() if k not in differ} == {
        k: v for k, v in here.json.items() if k not in differ
    }


def test_a_scheduler_that_is_not_there_is_told_and_leaves_nothing(tendon, workplace):
    (workplace / "suit.toml").write_text(STUDY, encoding="utf-8")
    ran = tendon(*DESIGN, "--out", "out", "--scheduler", "tcp://127.0.0.1:1")
    assert (ran.exit, ran.json["error"]["kind"]) == (6, "workers")
    assert sorted(item.name for item in workplace.iterdir()) == ["suit.toml"]
    assert json.loads(ran.out)["error"]["hint"]
