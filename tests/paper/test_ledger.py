"""The ledger of `make paper` says of every finding, slip and gap what the tables say."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tendon_cli.model.actuator import State
from verification.paper import __main__, slips
from verification.paper.reproduce import Reproduction
from verification.paper.runs import FOLDER, READINGS, STUDIES
from verification.paper.statements import Entry

CLAIMS = [f"C{number}" for number in range(1, 9)]
FINDINGS = ["F4", "F6a", "F6b", "F7a", "F7b", "F7c", "F7d", "F8a", "F8b", "F9", "F10", "F11", "TA1"]
SLIPS = ["S1", "S3", "S5", "S6"]
GAPS = ["S2", "S4", "S7"]
KEYS = ["id", "kind", "finding", "verdict", "recorded", "value", "numbers", "figure", "holds"]
KEPT = Path(__file__).parents[2] / "results" / "paper"


@pytest.fixture(scope="module")
def page(reproduced):
    """Return the ledger as text."""
    return (reproduced.out / "ledger.md").read_text(encoding="utf-8")


# --- Text and data -------------------------------------------------------------------------


def test_every_verdict_is_the_one_on_record_in_the_text_and_the_data(reproduced):
    assert [entry.id for entry in reproduced.entries if not entry.as_recorded] == []
    assert all(entry.holds for entry in reproduced.entries if entry.kind != "claim")
    assert reproduced.holds
    ledger = json.loads((reproduced.out / "ledger.json").read_bytes())
    assert [entry["id"] for entry in ledger] == FINDINGS + CLAIMS + SLIPS + GAPS
    for entry in ledger:
        assert list(entry) == KEYS
        assert entry["holds"] is (entry["verdict"] == "true")
        assert re.search(r"\d", entry["value"])


def test_every_figure_named_is_there_and_embedded(reproduced, page):
    named = {entry.figure for entry in reproduced.entries if entry.figure}
    assert named | {"ledger.md", "ledger.json"} == set(reproduced.files)
    assert {file.name for file in reproduced.out.iterdir()} == set(reproduced.files)
    for name in named:
        assert f"]({name})\n" in page
        assert (reproduced.out / name).read_bytes().startswith(b"\x89PNG")


def test_the_page_has_every_entry_and_no_date_or_path(reproduced, page):
    for entry in reproduced.entries:
        (row,) = [line for line in page.splitlines() if line.startswith(f"| {entry.id} |")]
        assert row.split(" | ")[1] == entry.verdict
    assert "13 of 13 findings of the paper hold" in page
    assert "held 270 to 355 mm from the elbow" in page.partition("## Findings")[0]
    assert str(reproduced.out.parent) not in page
    assert not re.search(r"\b20\d\d\b|\d\d:\d\d", page)


def test_a_verdict_that_is_not_the_one_on_record_is_marked_and_named(reproduced):
    failed = Entry("F4", "finding", "a|b", "false", "true", "0", (0.0,), "fig04.png")
    broken = replace(reproduced, entries=(failed,))
    assert "| F4 | ✗ false, on record true | a\\|b |" in broken.page()
    assert not broken.holds
    assert "F4 is false, on record true: a|b" in broken.text()
    assert "F4" not in reproduced.text()
    became_true = [replace(entry, verdict="true") for entry in reproduced.entries_of("claim")]
    assert not replace(reproduced, entries=became_true).holds


def test_a_finding_that_fails_is_exit_4(reproduced, monkeypatch, capsys):
    folders = []

    def reproduced_in(out, **_):
        folders.append(out)
        return reproduced

    monkeypatch.setattr(__main__, "reproduce", reproduced_in)
    assert __main__.main([]) == 0
    assert "13 of 13 findings of the paper hold." in capsys.readouterr().out
    monkeypatch.setattr(Reproduction, "holds", False)
    assert __main__.main(["elsewhere"]) == 4
    assert folders == [Path("results/paper"), Path("elsewhere")]


def test_progress_counts_every_step_once(reproduced, steps):
    total = steps[0][1]
    assert steps == [(done, total) for done in range(1, total + 1)]


# --- Sources -----------------------------------------------------------------------------


def test_each_study_of_the_paper_is_shipped(configs):
    names = sorted(f"{name}.toml" for name in STUDIES)
    assert names == sorted(file.name for file in FOLDER.iterdir())
    assert configs / "paper" == FOLDER
    assert READINGS.is_file()


def test_the_kept_ledger_is_what_the_tool_says_today(reproduced, again):
    assert (KEPT / "ledger.json").read_bytes() == (reproduced.out / "ledger.json").read_bytes()
    assert {file.name for file in KEPT.iterdir()} == set(reproduced.files)
    _, reproduced_again = again
    assert reproduced_again.json().encode() == (reproduced.out / "ledger.json").read_bytes()
    assert reproduced_again.page().encode() == (reproduced.out / "ledger.md").read_bytes()


# --- The letter of the paper ----------------------------------------------------------------------


def stretch_of(coupling, flexor, extensor):
    """Return the stretch of both tendons together from a pretension of 100 N, m."""
    flexor_stretch = coupling.flexor_compliance * (flexor - 100.0)
    extensor_stretch = coupling.extensor_compliance * (extensor - 100.0)
    return flexor_stretch + extensor_stretch


def test_eq_12_as_printed_solves_the_printed_equation_and_the_elbow(paper):
    design, angle, flexion = paper["fig07"].inputs()
    state = State.of(design, angle, flexion)
    coupling = state.coupling
    flexor, extensor = slips.eq_12_as_printed(design, angle, flexion)
    stretch = stretch_of(coupling, flexor, extensor)
    travels = state.motion.flexor_travel + state.motion.extensor_travel
    np.testing.assert_allclose(stretch, np.broadcast_to(travels, stretch.shape))
    torque = coupling.moment_arm * flexor - 0.045 * extensor
    wanted = np.broadcast_to(coupling.elbow_torque, torque.shape)
    np.testing.assert_allclose(torque, wanted, atol=1e-12)


def test_eq_11_first_keeps_the_compatibility_and_the_motor_and_loses_the_elbow(paper):
    design, angle, flexion = paper["fig07"].inputs()
    state = State.of(design, angle, flexion)
    coupling = state.coupling
    flexor, extensor = slips.eq_11_first(design, angle, flexion)
    stretch = stretch_of(coupling, flexor, extensor)
    mismatch = np.broadcast_to(coupling.mismatch, stretch.shape)
    np.testing.assert_allclose(stretch, mismatch, atol=1e-15)
    motor_torque = (flexor / state.flexor.capstan - extensor / state.extensor.capstan) * 0.03
    by_eq_11 = coupling.elbow_torque * 0.03 / (coupling.moment_arm * state.flexor.capstan)
    np.testing.assert_allclose(motor_torque, by_eq_11, atol=1e-12)
    unbalanced = coupling.moment_arm * flexor - 0.045 * extensor - coupling.elbow_torque
    assert np.abs(unbalanced).max() > 1.0


def test_eq_11_has_equal_torques_where_moment_arm_and_friction_make_the_spool_whatever_the_load(
    paper,
):
    run = paper["fig06"]
    (angle, *others) = slips.crossings_by_eq_11(run)
    np.testing.assert_allclose(others, angle)
    design, angles, flexion = run.inputs()
    arm = State.of(design, angles, flexion).coupling.moment_arm
    rising = np.argsort(np.ravel(angles))
    at_crossing = np.interp(np.radians(angle), np.ravel(angles)[rising], arm.ravel()[rising])
    assert at_crossing * np.exp(-0.07 * np.pi) == pytest.approx(0.03, rel=2e-3)


@pytest.mark.parametrize("friction", [0.0, 0.07, 0.5])
def test_a_9_gives_a_negative_magnitude_and_yet_a_17(friction):
    normal_force = slips.normal_force(100.0, 2.0, 1e-3, friction)
    assert normal_force < 0.0
    balance = 100.0 * 2.0 * 1e-3 + normal_force - friction * normal_force * 2.0 * 1e-3 / 2.0
    assert balance == pytest.approx(0.0, abs=1e-15)
    assert slips.transmitted(friction, 2.0) == pytest.approx(np.exp(-friction * 2.0), rel=1e-4)
