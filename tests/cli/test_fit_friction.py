"""`tendon fit-friction`, as it is called."""

import math

import numpy as np
import pandas as pd
import pytest

from tendon_cli.fits.friction.budget import USUAL_ZERO


@pytest.fixture
def readings(configs):
    return configs / "friction/table_a1.csv"


def test_a_study_takes_the_fitted_coefficient_and_runs(tendon, readings, write_study):
    fit = ("fit-friction", readings, "--bend-angle", "144 deg")
    fitted = tendon(*fit, "--out", "friction.toml", "--json")
    write_study('[sheath]\nfriction_from = "friction.toml"\n')
    assert tendon("sweep", "study.toml", "--out", "run", "--no-figures").exit == 0
    assert pd.read_parquet("run/designs.parquet").friction.tolist() == [fitted.json["friction"]]


def test_a_fit_writes_over_nobody_elses_files_and_none_of_another_kind(
    tendon, readings, workplace, blank_figures
):
    (workplace / "readings.csv").write_bytes(readings.read_bytes())
    fit = ("fit-friction", "readings.csv", "--bend-angle", "144 deg")
    assert tendon(*fit, "--out", "friction.toml", "--plot", "fit.png").exit == 0
    (workplace / "mine.toml").write_text("[friction]\ncoefficient = 0.1\n")
    (workplace / "link.toml").symlink_to("mine.toml")
    for option, name in (
        ("--out", "link.toml"),
        ("--out", "readings.csv"),
        ("--out", "fit.png"),
        ("--plot", "friction.toml"),
    ):
        before = (workplace / name).read_bytes()
        ran = tendon(*fit, option, name)
        assert ran.exit == 2
        assert name in ran.err
        assert (workplace / name).read_bytes() == before


def test_a_fit_says_which_files_it_wrote_and_what_it_replaced(
    tendon, readings, workplace, blank_figures
):
    (workplace / "one.csv").write_bytes(readings.read_bytes())
    (workplace / "two.csv").write_bytes(readings.read_bytes())
    outputs = ("--out", "mu.toml", "--plot", "mu.svg", "--strokes", "strokes.csv")
    first = tendon("fit-friction", "one.csv", *outputs)
    assert first.err.splitlines() == ["mu.svg written", "mu.toml written", "strokes.csv written"]
    again = tendon("fit-friction", "one.csv", *outputs)
    assert again.err.splitlines() == [
        "mu.svg replaced",
        "mu.toml replaced",
        "strokes.csv replaced",
    ]
    other = tendon("fit-friction", "two.csv", "--out", "mu.toml", "--json")
    before = "before, it held the coefficient of one.csv"
    assert other.err.splitlines() == [f"mu.toml replaced; {before}"]
    assert other.json["source"] == "two.csv"
    assert tendon("fit-friction", "two.csv").err == ""


def test_a_fit_takes_the_bend_angle_of_a_measured_route_with_its_error(tendon, readings, workplace):
    turn = np.linspace(0.0, np.pi, 51)
    points = 100.0 * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    points += np.random.default_rng(4).standard_normal(points.shape)
    np.savetxt("route.csv", points, delimiter=",", header="x_mm,y_mm,z_mm", comments="")
    fit = ("fit-friction", readings, "--json")
    along_route = (*fit, "--route", "route.csv")
    by_angle = tendon(*fit, "--bend-angle", "180 deg").json
    by_route = tendon(*along_route, "--out", "friction.toml").json
    assert by_route["bend_angle"] == pytest.approx(math.pi, rel=0.1)
    ratio = by_angle["bend_angle"] / by_route["bend_angle"]
    assert by_route["friction"] == pytest.approx(by_angle["friction"] * ratio, rel=1e-9)
    assert by_route["standard_error"] > by_angle["standard_error"] * ratio
    assert any("route.csv bends by" in text for text in by_route["notes"])
    assert "deg of route.csv" in (workplace / "friction.toml").read_text()
    # A noise that is stated counts if it is larger than that of the points.
    for noise, counts in (("1 mm", False), ("4 mm", True)):
        record = tendon(*along_route, "--path-smoothing", noise).json
        assert any("path_smoothing" in text for text in record["warnings"]) is counts


def test_the_help_of_cell_uncertainty_says_what_is_assumed_without_it(tendon):
    text = tendon("fit-friction", "--help").out
    option = text.partition("--cell-uncertainty")[2].partition("--strokes")[0]
    assert f"{100.0 * USUAL_ZERO:g} % of the force is assumed for a zero" in " ".join(
        option.split()
    )
