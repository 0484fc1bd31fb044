"""Figures of a joint that is not an elbow name it, and have room for all that they mark."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import tendon_cli as tendon
from tendon_cli.commands.cli import app
from tests.figures.measure import capture
from tests.figures.runs import grid, panels, words

TRAVELS = """angle (deg),flexor (mm),extensor (mm)
-40,-31,-26.4
-20,-14.6,-13.7
0,0,0
20,13,14
30,18.9,20.8
"""


@pytest.fixture
def ankle(tmp_path: Path) -> dict[str, Any]:
    """Return a study of an ankle with measured travels, whose windows have no upper end."""
    file = tmp_path / "travels.csv"
    file.write_text(TRAVELS, encoding="utf-8")
    return {
        "name": "plantar",
        "joint": {"name": "ankle", "excursion": str(file)},
        "spring": {"stiffness": ["3 kN/m", "5 kN/m"]},
        "motion": {"elbow_angle": grid("-20 deg", "20 deg", 5), "speed": "60 deg/s"},
    }


def test_figures_name_the_joint_of_the_study(ankle: dict[str, Any], tmp_path: Path) -> None:
    study = tmp_path / "ankle.toml"
    study.write_text(
        f"""
        name = "plantar"
        joint.name = "ankle"
        joint.excursion = "{ankle["joint"]["excursion"]}"
        motion.elbow_angle = ["-10 deg", "10 deg"]
        motion.speed = "60 deg/s"
        """,
        encoding="utf-8",
    )
    with capture() as drawn:
        arguments = ["state", str(study), "--reversal", "--plot", str(tmp_path / "motor.png")]
        done = CliRunner().invoke(app, arguments)
        assert done.exit_code == 0, done.output
        tendon.study(ankle).plot()
        answer = tendon.design(ankle, tmp_path / "answer")
        answer.plot("window")
        answer.plot("between")
    texts = [words(one.figure) for one in drawn]
    assert len(texts) >= 4
    assert "ankle at 60 deg/s" in texts[0]
    for text in texts:
        assert "elbow" not in text.casefold()


def test_the_starred_pretension_is_in_the_panel_of_an_open_window(
    ankle: dict[str, Any], tmp_path: Path
) -> None:
    answer = tendon.design(ankle, tmp_path / "answer")
    best = answer.record["best"]
    assert best["pretension_to"] is None
    (axes,) = panels(answer.plot("window"))
    low, high = axes.get_ylim()
    assert low <= best["pretension"] <= high
