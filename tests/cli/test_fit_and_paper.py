"""`tendon fit-friction` and `tendon paper`, as they are called."""

import pandas as pd
import pytest

from tendon_cli.paper import reproduce as reproduction

JSON_KEYS = {
    "friction",
    "standard_error",
    "interval_95",
    "bend_angle",
    "gain_ratio",
    "by_direction",
    "used",
    "set_aside",
    "residuals",
    "warnings",
    "notes",
    "checks",
}


@pytest.fixture
def readings(configs):
    return configs / "friction/table_a1.csv"


def test_a_fit_prints_one_object_with_the_keys_that_scripts_rely_on(tendon, readings):
    ran = tendon("fit-friction", readings, "--bend-angle", "144 deg", "--json")
    assert ran.exit == 0
    assert set(ran.json) == JSON_KEYS
    assert round(ran.json["friction"], 4) == 0.0743  # Table A.1, both directions together


def test_a_study_takes_the_fitted_coefficient_and_runs(tendon, readings, workplace):
    fitted = tendon(
        "fit-friction", readings, "--bend-angle", "144 deg", "--out", "friction.toml", "--plot", "fit.png", "--json"
    )
    (workplace / "study.toml").write_text('[sheath]\nfriction_from = "friction.toml"\n')
    assert tendon("sweep", "study.toml", "--out", "run", "--no-figures").exit == 0
    assert pd.read_parquet("run/designs.parquet").friction.tolist() == [fitted.json["friction"]]
    assert (workplace / "fit.png").read_bytes().startswith(b"\x89PNG")


def test_a_fit_without_the_bend_angle_is_refused_and_never_guessed(tendon, readings):
    ran = tendon("fit-friction", readings)
    assert ran.exit == 2
    assert "--bend-angle" in ran.err


def test_a_fit_writes_over_its_own_files_and_nobody_elses(tendon, readings, workplace):
    (workplace / "readings.csv").write_bytes(readings.read_bytes())
    fit = ("fit-friction", "readings.csv", "--bend-angle", "144 deg")
    for _ in range(2):
        for ending in ("png", "svg", "pdf"):
            assert tendon(*fit, "--out", "friction.toml", "--plot", f"fit.{ending}").exit == 0
    (workplace / "mine.png").write_bytes(b"a picture")
    (workplace / "mine.toml").write_text("[friction]\ncoefficient = 0.1\n")
    (workplace / "link.toml").symlink_to("mine.toml")
    for option, name in (
        ("--plot", "mine.png"), ("--out", "mine.toml"), ("--out", "link.toml"), ("--out", "readings.csv"),
        ("--out", "fit.png"), ("--plot", "friction.toml"),
    ):  # fmt: skip
        before = (workplace / name).read_bytes()
        ran = tendon(*fit, option, name)
        assert (ran.exit, option in ran.err) == (2, True)
        assert (workplace / name).read_bytes() == before
    assert tendon(*fit, "--out", "same.svg", "--plot", "same.svg").exit == 2
    assert not (workplace / "same.svg").exists()


def test_readings_that_are_none_are_exit_3(tendon, workplace):
    (workplace / "junk.csv").write_text("a,b\n1,x\n2,y\n")
    ran = tendon("fit-friction", "junk.csv", "--bend-angle", "144 deg")
    assert ran.exit == 3
    assert "junk.csv" in ran.err


@pytest.mark.parametrize(("words", "folder"), [((), "results/paper"), (("--out", "paper"), "paper")])
def test_the_paper_is_reproduced_into_a_folder(tendon, workplace, words, folder):
    ran = tendon("paper", *words, "--json")
    assert ran.exit == 0
    assert ran.json["holds"] is True
    assert {file.name for file in (workplace / folder).iterdir()} == set(ran.json["files"])


def test_a_finding_that_fails_is_exit_4(tendon, monkeypatch):
    monkeypatch.setattr(reproduction.Reproduction, "holds", False)
    assert tendon("paper", "--out", "paper", "--quiet").exit == 4
