"""What comes out: JSON, summary, fragment, figure."""

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
from tendon_cli.figures.friction import draw
from tendon_cli.friction import fit_friction, summary_lines, write_fragment

EXAMPLES = Path(__file__).parents[2] / "configs" / "friction"
TABLE = EXAMPLES / "table_a1.csv"
LOG = EXAMPLES / "raw_log.csv"


def test_json_has_the_promised_keys() -> None:
    for path in (TABLE, LOG):
        fit = fit_friction(path, bend_angle="144 deg +/- 2 deg")
        answer = fit.record
        assert {
            "friction", "standard_error", "interval_95", "bend_angle", "gain_ratio", "by_direction", "used",
            "set_aside", "residuals", "warnings", "notes", "checks", "friction_bend", "friction_bend_standard_error",
            "friction_bend_interval_95", "plain", "budget", "coverage_factor", "strokes", "unit", "sha256",
        } <= set(answer)  # fmt: skip
        assert json.loads(json.dumps(answer, allow_nan=False)) == answer
        assert answer["bend_angle"] == pytest.approx(2.5132741, abs=1e-6)
        assert answer["interval_95"][0] < answer["friction"] < answer["interval_95"][1]
        assert answer["friction_bend"] == pytest.approx(answer["friction"] * answer["bend_angle"], rel=1e-12)
        names = [check["name"] for check in answer["checks"]]
        assert {"offset_motor", "offset_load", "delay", "gain", "force_dependence", "drift"} <= set(names)
        assert len(answer["residuals"]["rows"]) == min(20, answer["used"])
        assert (
            answer["residuals"]["max"] == abs(answer["residuals"]["rows"][0]["residual"]) >= answer["residuals"]["rms"]
        )


def test_the_budget_adds_up_to_the_standard_error() -> None:
    for path in (TABLE, LOG):
        answer = fit_friction(path, bend_angle="144 deg +/- 2 deg").record
        parts = answer["budget"]
        assert answer["standard_error"] == pytest.approx(sum(part["contribution"] ** 2 for part in parts) ** 0.5)
        for part in parts:
            assert part["type"] in {"A", "B"}
            assert part["contribution"] == pytest.approx(abs(part["sensitivity"]) * part["standard_uncertainty"])
        low, high = answer["interval_95"]
        assert high - low == pytest.approx(2.0 * answer["coverage_factor"] * answer["standard_error"])


def test_every_example_is_read_and_holds_its_truth() -> None:
    for name, angle, truth in (("raw_log.csv", "144 deg", 0.08), ("several_angles.csv", None, 0.11)):
        fit = fit_friction(EXAMPLES / name, bend_angle=angle)
        low, high = fit.uncertainty.interval_95
        assert low < truth < high
    assert LOG.stat().st_size < 300_000


def test_summary_is_short_and_says_what_was_set_aside() -> None:
    text = summary_lines(fit_friction(LOG, bend_angle="144 deg"))
    assert len(text.splitlines()) < 20
    for words in ("μ = ", "95 % interval", "144 deg", "sticking after a reversal", "plain answer", "type A"):
        assert words in text


def test_fragment_says_where_it_comes_from(tmp_path: Path) -> None:
    fit = fit_friction(TABLE, bend_angle="144 deg +/- 2 deg")
    write_fragment(fit, tmp_path / "friction.toml")
    table = tomllib.loads((tmp_path / "friction.toml").read_text(encoding="utf-8"))["friction"]
    assert table["coefficient"] == fit.friction
    assert table["standard_error"] == fit.uncertainty.standard_error
    assert tuple(table["interval_95"]) == fit.uncertainty.interval_95
    assert (table["bend_angle"], table["bend_angle_uncertainty"]) == ("144 deg", "2 deg")
    assert (table["source"], table["rows_used"], table["rows_set_aside"]) == ("table_a1.csv", 6, 0)
    assert table["sha256"] == hashlib.sha256(TABLE.read_bytes()).hexdigest()
    assert [path.name for path in tmp_path.iterdir()] == ["friction.toml"]


def test_fragment_of_a_file_with_a_hostile_name(tmp_path: Path) -> None:
    name = 'a"b\\c\n[sheath]\x7f#é.csv'
    fit = replace(fit_friction(TABLE, bend_angle="144 deg"), source=name)
    write_fragment(fit, tmp_path / "friction.toml")
    table = tomllib.loads((tmp_path / "friction.toml").read_text(encoding="utf-8"))
    assert list(table) == ["friction"]
    assert table["friction"]["source"] == name


def test_what_cannot_be_written_leaves_nothing_behind(tmp_path: Path) -> None:
    fit = fit_friction(TABLE, bend_angle="144 deg")
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "folder.png").mkdir()
    for path in (tmp_path / "no" / "friction.toml", tmp_path / "folder.toml"):
        with pytest.raises(OutputError):
            write_fragment(fit, path)
    for path in (tmp_path / "no" / "figure.png", tmp_path / "folder.png"):
        with pytest.raises(OutputError):
            draw(fit, path)
    with pytest.raises(UsageError):
        draw(fit, tmp_path / "figure.docx")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder.png", "folder.toml"]


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
@pytest.mark.parametrize("name", ["table_a1.csv", "raw_log.csv"])
def test_the_same_fit_gives_the_same_bytes(name: str, ending: str, tmp_path: Path) -> None:
    fit = fit_friction(EXAMPLES / name, bend_angle="144 deg")
    for copy in ("a", "b"):
        draw(fit, tmp_path / f"{copy}.{ending}")
    first = (tmp_path / f"a.{ending}").read_bytes()
    assert first == (tmp_path / f"b.{ending}").read_bytes()
    assert len(first) > 5000


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_a_figure_says_of_itself_what_was_fitted(ending: str, tmp_path: Path) -> None:
    fit = replace(fit_friction(TABLE, bend_angle="144 deg"), source="Kräfte.csv")
    draw(fit, tmp_path / f"figure.{ending}")
    content = (tmp_path / f"figure.{ending}").read_bytes()
    assert f"tendon fit-friction Kr?fte.csv, SHA-256 {fit.sha256}".encode() in content
    if ending == "svg":
        assert "repeat the measurement" in content.decode()
        assert f"μ = {fit.friction:.4f}" in content.decode()


def test_a_name_that_looks_like_a_formula_is_drawn(tmp_path: Path) -> None:
    fit = replace(fit_friction(TABLE, bend_angle="144 deg"), source=r"$\frac{$_^.csv")
    draw(fit, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").exists()


def test_a_name_that_is_not_utf_8_is_read_and_drawn(tmp_path: Path) -> None:
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/k\xe4fig.csv"))
    path.write_bytes(TABLE.read_bytes())
    fit = fit_friction(path, bend_angle="144 deg")
    draw(fit, tmp_path / "figure.svg")
    write_fragment(fit, tmp_path / "friction.toml")
    assert fit.source == "k\ufffdfig.csv"


def test_fits_that_write_one_fragment_at_once_all_succeed(tmp_path: Path) -> None:
    fit = fit_friction(TABLE, bend_angle="144 deg")
    path = tmp_path / "friction.toml"
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda _: write_fragment(fit, path), range(64)))
    assert tomllib.loads(path.read_text())["friction"]["coefficient"] == fit.friction
    assert [file.name for file in tmp_path.iterdir()] == ["friction.toml"]
