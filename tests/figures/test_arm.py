"""The drawn arm is the model's arm, and the drawing says its dimensions."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tendon_cli.figures.arm import arm_page
from tendon_cli.figures.arm_shape import ArmShape, arm_sizes
from tendon_cli.studies.load import study_from
from tests.figures.runs import by_gid, words

ANGLES = [math.radians(angle) for angle in (-20.0, 0.0, 35.0, 90.0, 140.0)]
STUDY = study_from(
    {
        "name": "arm",
        "title": "An arm",
        "arm": {"upper_arm_angle": "30 deg"},
        "spool": {"ratio": [0.7, 1.0]},
    }
)


@pytest.mark.parametrize("angle", ANGLES)
def test_points_agree_with_the_model(angle: float) -> None:
    shape = ArmShape(arm_sizes(STUDY), angle)
    points = shape.anchors
    motion = shape.sizes.anchors.motion(angle)
    assert np.linalg.norm(points["q"] - points["r"]) == pytest.approx(float(motion.flexor_path))
    foot = shape.moment_arm_foot
    assert np.linalg.norm(foot) == pytest.approx(abs(float(motion.flexor_moment_arm)))
    assert foot @ (points["q"] - points["r"]) == pytest.approx(0.0, abs=1e-9)
    assert np.linalg.norm(points["r"] - points["s"]) == pytest.approx(40.0)
    assert np.linalg.norm(points["q"] - points["p"]) == pytest.approx(20.0)


def test_the_extensor_is_longer_by_its_travel() -> None:
    def length(angle: float) -> float:
        segments = np.diff(ArmShape(arm_sizes(STUDY), angle).extensor, axis=0)  # (segments, 2), mm
        return float(np.linalg.norm(segments, axis=1).sum())

    for angle in (0.5, 1.5, 2.4):
        assert length(angle) - length(0.0) == pytest.approx(45.0 * angle, rel=1e-3)
    distances = np.linalg.norm(ArmShape(arm_sizes(STUDY), 1.2).extensor, axis=1)
    assert distances.min() == pytest.approx(45.0)


def test_gravity_pulls_down_and_the_upper_arm_leans_forward() -> None:
    shape = ArmShape(arm_sizes(STUDY), 0.0)
    lean = math.radians(30)
    np.testing.assert_allclose(shape.along, (math.sin(lean), -math.cos(lean)))
    np.testing.assert_allclose(shape.up, -shape.along)


def test_what_the_drawing_says() -> None:
    figure = arm_page(STUDY, [0.0, math.radians(60.0), math.radians(170.0)]).figure
    expected = (
        "b₁ = 150 mm",
        "b₂ = 150 mm",
        "a₁ = 40 mm",
        "a₂ = 20 mm",
        "$d_{load}$ = 320 mm",
        "$d_{com}$ = 174 mm",
        "$R_{elb}$ = 45 mm",
        "$R_{f}$ = 30 mm",
        "$R_{e}$ = 21 mm",
        "η = $R_e$ / $R_f$ = 0.7",
        "ψ = 30 deg",
        "θ = 60 deg",
        "J = 101.1 mm",
        "J ≤ 0: no equilibrium",
        "The first of several values of spool.ratio is drawn.",
    )
    for text in expected:
        assert text in words(figure)
    arms = [axes for axes in figure.axes if "spools" not in axes.get_title()]
    assert len(arms) == 4
    assert all(axes.get_aspect() == 1.0 for axes in figure.axes)
    radii = [patch.radius for patch in by_gid(figure, "spool")]
    assert radii == pytest.approx([30.0, 21.0])


def test_angles_of_the_study_and_files(tmp_path: Path) -> None:
    path = arm_page(STUDY).save(tmp_path / "arm.svg")
    assert b"<svg" in path.read_bytes()[:1000]
    titles = [axes.get_title() for axes in arm_page(STUDY).figure.axes]
    assert titles[2:] == ["θ = 0 deg", "θ = 30 deg", "θ = 60 deg", "θ = 90 deg"]
    many = arm_page(STUDY, list(np.linspace(0.0, 1.5, 30))).figure
    assert len(many.axes) == 2 + 5
