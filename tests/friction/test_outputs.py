"""The outputs of a fit: JSON, summary, fragment, figure."""

from __future__ import annotations

import hashlib
import json
import os
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

from tendon_cli.errors import OutputError, UsageError
from tendon_cli.figures.friction import draw, fit_page
from tendon_cli.fits.friction import fit_friction, write_fragment

EXAMPLES = Path(__file__).parents[2] / "configs" / "friction"
TABLE = EXAMPLES / "table_a1.csv"
LOG = EXAMPLES / "raw_log.csv"


@pytest.fixture(scope="module", params=[TABLE, LOG], ids=["table", "log"])
def fit(request):
    return fit_friction(request.param, bend_angle="144 deg +/- 2 deg")


@pytest.fixture(scope="module")
def of_table():
    return fit_friction(TABLE, bend_angle="144 deg")


def fragment_of(fit, path: Path):
    """Return the table that a study reads of a fit."""
    write_fragment(fit, path)
    content = tomllib.loads(path.read_text(encoding="utf-8"))
    assert list(content) == ["friction"]
    return content["friction"]


def test_json_has_the_promised_keys(fit) -> None:
    answer = fit.record
    assert {
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
        "friction_bend",
        "friction_bend_standard_error",
        "friction_bend_interval_95",
        "plain",
        "budget",
        "coverage_factor",
        "strokes",
        "unit",
        "sha256",
    } <= set(answer)
    assert json.loads(json.dumps(answer, allow_nan=False)) == answer
    assert answer["bend_angle"] == pytest.approx(2.5132741, abs=1e-6)
    assert answer["interval_95"][0] < answer["friction"] < answer["interval_95"][1]
    product = answer["friction"] * answer["bend_angle"]
    assert answer["friction_bend"] == pytest.approx(product, rel=1e-12)
    names = {check["name"] for check in answer["checks"]}
    assert {"offset_motor", "offset_load", "delay", "gain", "force_dependence", "drift"} <= names
    residuals = answer["residuals"]
    assert len(residuals["rows"]) == min(20, answer["used"])
    assert residuals["max"] == abs(residuals["rows"][0]["residual"]) >= residuals["rms"]


def test_the_budget_adds_up_to_the_standard_error(fit) -> None:
    answer = fit.record
    parts = answer["budget"]
    total = sum(part["contribution"] ** 2 for part in parts) ** 0.5
    assert answer["standard_error"] == pytest.approx(total)
    for part in parts:
        assert part["type"] in {"A", "B"}
        contribution = abs(part["sensitivity"]) * part["standard_uncertainty"]
        assert part["contribution"] == pytest.approx(contribution)
    low, high = answer["interval_95"]
    assert high - low == pytest.approx(2.0 * answer["coverage_factor"] * answer["standard_error"])


@pytest.mark.parametrize(("path", "truth"), [(LOG, 0.08), (EXAMPLES / "several_angles.csv", 0.11)])
def test_every_example_is_read_and_holds_its_truth(path: Path, truth: float) -> None:
    bend_angle = "144 deg" if path == LOG else None
    low, high = fit_friction(path, bend_angle=bend_angle).interval_95
    assert low < truth < high


def test_summary_is_short_and_says_what_was_set_aside() -> None:
    text = fit_friction(LOG, bend_angle="144 deg").text
    assert len(text.splitlines()) < 20
    for words in (
        "μ = ",
        "95 % interval",
        "144 deg",
        "sticking after a reversal",
        "plain answer",
        "type A",
    ):
        assert words in text


def test_fragment_says_where_it_comes_from(tmp_path: Path) -> None:
    fit = fit_friction(TABLE, bend_angle="144 deg +/- 2 deg")
    table = fragment_of(fit, tmp_path / "friction.toml")
    assert table["coefficient"] == fit.friction
    assert table["standard_error"] == fit.uncertainty.standard_error
    assert tuple(table["interval_95"]) == fit.uncertainty.interval_95
    assert (table["bend_angle"], table["bend_angle_uncertainty"]) == ("144 deg", "2 deg")
    assert (table["source"], table["rows_used"], table["rows_set_aside"]) == ("table_a1.csv", 6, 0)
    assert table["sha256"] == hashlib.sha256(TABLE.read_bytes()).hexdigest()
    assert [path.name for path in tmp_path.iterdir()] == ["friction.toml"]


@pytest.mark.parametrize("name", ['a"b\\c\n[sheath]\x7f#é.csv', r"$\frac{$_^.csv"])
def test_a_hostile_name_is_written_and_drawn(name: str, of_table, tmp_path: Path) -> None:
    fit = replace(of_table, source=name)
    assert fragment_of(fit, tmp_path / "friction.toml")["source"] == name
    draw(fit, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").exists()


def test_a_name_that_is_not_utf_8_is_read_and_drawn(tmp_path: Path) -> None:
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/k\xe4fig.csv"))
    path.write_bytes(TABLE.read_bytes())
    fit = fit_friction(path, bend_angle="144 deg")
    draw(fit, tmp_path / "figure.svg")
    assert fragment_of(fit, tmp_path / "friction.toml")["source"] == fit.source == "k\ufffdfig.csv"


def test_what_cannot_be_written_leaves_nothing_behind(of_table, tmp_path: Path) -> None:
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "folder.png").mkdir()
    for write, ending in ((write_fragment, "toml"), (draw, "png")):
        for path in (tmp_path / "no" / f"file.{ending}", tmp_path / f"folder.{ending}"):
            with pytest.raises(OutputError):
                write(of_table, path)
    with pytest.raises(UsageError):
        draw(of_table, tmp_path / "figure.docx")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder.png", "folder.toml"]


def test_fits_that_write_one_fragment_at_once_all_succeed(of_table, tmp_path: Path) -> None:
    path = tmp_path / "friction.toml"
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda _: write_fragment(of_table, path), range(64)))
    assert tomllib.loads(path.read_text())["friction"]["coefficient"] == of_table.friction
    assert list(tmp_path.iterdir()) == [path]


def test_the_same_fit_gives_the_same_bytes_that_name_it(of_table, tmp_path: Path) -> None:
    fit = replace(of_table, source="Kräfte.csv")
    pages = {name: fit_page(fit) for name in ("a", "b")}
    for ending in ("png", "svg", "pdf"):
        for name, page in pages.items():
            page.save(tmp_path / f"{name}.{ending}")
        content = (tmp_path / f"a.{ending}").read_bytes()
        assert content == (tmp_path / f"b.{ending}").read_bytes(), ending
        named = f"tendon fit-friction Kr?fte.csv, SHA-256 {fit.sha256}"
        assert named.encode() in content, ending


def test_a_figure_has_the_value_and_the_warnings_of_its_fit(fit, tmp_path: Path) -> None:
    draw(fit, tmp_path / "figure.svg")
    drawing = (tmp_path / "figure.svg").read_text(encoding="utf-8")
    assert f"μ = {fit.friction:.4f}" in drawing
    assert all(word in drawing for text in fit.warnings for word in text.split())
