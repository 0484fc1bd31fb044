"""Fits of rigs drawn at random: what is silently wrong is what an interval of 95 % promises."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.commands.fit_friction import fit_friction
from tendon_cli.errors import InputError
from tendon_cli.figures.friction import fit_page
from tendon_cli.fits.friction.budget import ZEROS
from verification.friction_rigs.random_rigs import (
    RandomRig,
    drawn_rig,
    forces_of,
    motion_of,
    outcome_of,
    outcomes,
    readings_of,
)

CALM = RandomRig(1, scatter=0.0, noise=0.0, stick=0.3)


@pytest.mark.parametrize("spring", [0.0, 0.8])
def test_the_simulated_tendon_slides_at_the_capstan_limit_and_never_beyond(spring: float) -> None:
    rig = replace(CALM, spring=spring)
    travel, _, friction = motion_of(rig, np.random.default_rng(0))
    motor, load = forces_of(rig, travel, friction)
    log_ratio = np.log(motor / load)
    limit = rig.friction * rig.bend
    assert np.abs(log_ratio).max() == pytest.approx(limit, rel=1e-9)
    slides = np.isclose(np.abs(log_ratio), limit, rtol=1e-9)
    assert 0.5 < slides.mean() < 0.9  # a turn takes 0.3 of a stroke


def test_a_log_without_faults_gives_its_friction() -> None:
    outcome = outcome_of(replace(CALM, spring=0.5, noise=1e-4))
    assert abs(outcome.error) < 2e-3
    assert not outcome.warnings


def with_large_zero(seed: int) -> RandomRig:
    """Return a rig with rests, partial strokes and a zero error of 15 % of the force."""
    rig = drawn_rig(seed)
    rests = {"partial": 0.84, "holds": 0.9, "middle_holds": 0.9}
    sound = replace(rig, slow_noise=0.0, lag=0.0, drift=0.0, noise=4e-4, spring=0.21, **rests)
    return replace(sound, zero=(0.0, 0.15 * rig.weight))


def test_a_zero_error_that_either_cell_may_have_is_warned_of() -> None:
    """Rests and partial strokes leave little that tells in which cell the zero error is."""
    warnings = outcome_of(with_large_zero(1022)).warnings
    assert any("hardly in which cell" in warning for warning in warnings)


@pytest.mark.parametrize("seed", [1039, 1094])
def test_a_large_zero_error_never_misleads_by_two_half_widths(seed: int) -> None:
    outcome = outcome_of(with_large_zero(seed))
    assert outcome.warnings or outcome.ratio <= 2.0


def test_one_large_zero_error_is_not_shared_out_between_the_cells() -> None:
    rig = replace(CALM, spring=1.0, strokes=24, noise=4e-4, zero=(0.0, -13.0))
    outcome = outcome_of(rig)
    assert abs(outcome.error) < 0.02
    assert outcome.ratio <= 1.0


@pytest.mark.parametrize("seed", [30, 183])
def test_a_sound_log_is_not_explained_by_zero_errors_as_large_as_half_the_force(seed: int) -> None:
    outcome = outcome_of(drawn_rig(seed))
    assert abs(outcome.error) < 0.02
    assert not outcome.warnings


@pytest.mark.parametrize("seed", [1, 2])
def test_a_late_cell_is_not_explained_by_zero_errors_of_both(seed: int) -> None:
    rig = RandomRig(seed, spring=1.0, lag=0.12, is_sine=True)
    fit = tendon.fit_friction(readings_of(rig), rig.bend)
    found = {check.name: check.value for check in fit.checks if check.found}
    assert found["delay"] == pytest.approx(rig.lag, rel=0.1)
    zeros = [found.get(name, 0.0) for name in ("offset_motor", "offset_load")]
    assert np.abs(zeros).max() < 0.005 * rig.weight
    assert fit.friction == pytest.approx(rig.friction, rel=0.01)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_late_cell_is_in_the_interval_while_the_force_grows_steadily(seed: int) -> None:
    """Alike zero errors, friction that depends on the force and a delay then look the same."""
    rig = RandomRig(seed, spring=1.0, lag=0.12)
    fit = tendon.fit_friction(readings_of(rig), rig.bend)
    low, high = fit.interval_95
    assert low <= rig.friction <= high
    assert any("late" in warning for warning in fit.warnings)


def test_zero_errors_of_both_cells_that_differ_are_not_explained_by_a_delay() -> None:
    for seed in (1, 2):
        rig = RandomRig(seed, spring=1.0, zero=(1.5, -1.0))
        fit = tendon.fit_friction(readings_of(rig), rig.bend)
        found = {check.name for check in fit.checks if check.found}
        assert {"offset_motor", "offset_load"} <= found
        assert "delay" not in found


@pytest.mark.parametrize("change", [0.02, -0.02])
def test_friction_that_varies_along_the_stroke_is_not_taken_for_zero_errors(change: float) -> None:
    """Behind a spring the force goes with the place, and alike zero errors explain as much."""
    rig = RandomRig(1, spring=1.0, strokes=16)
    travel, _, friction = motion_of(rig, np.random.default_rng(1))
    motor, load = forces_of(rig, travel, friction * (1.0 + change * (travel - 0.5)))
    noise = np.random.default_rng(2).normal(scale=0.05, size=(2, len(travel)))
    log = pd.DataFrame(
        {
            "motor (N)": motor + noise[0],
            "load (N)": load + noise[1],
            "time (s)": np.arange(len(travel)) / rig.rate,
        }
    )
    fit = tendon.fit_friction(log, rig.bend)
    low, high = fit.interval_95
    assert low <= rig.friction <= high
    (said,) = (text for text in fit.warnings if "cannot tell" in text)
    assert "zero errors that are alike" in said
    assert "on the place" in said
    tared = tendon.fit_friction(log, rig.bend, cell_uncertainty="0.05 N")
    assert tared.friction == pytest.approx(rig.friction, rel=0.01)


@pytest.mark.parametrize("share", [0.03, -0.03])
def test_a_zero_error_that_looks_like_friction_is_in_the_interval(share: float) -> None:
    """Under a constant force no reading tells the motor's zero error from friction."""
    for seed in (1, 2):
        rig = RandomRig(seed)
        off = replace(rig, zero=(share * rig.weight, 0.0))
        fit = tendon.fit_friction(readings_of(off), rig.bend)
        low, high = fit.interval_95
        assert low <= rig.friction <= high
        assert not fit.warnings
        assert fit.uncertainty.contribution_of(ZEROS[0]) > 0.0


def test_a_stated_zero_leaves_its_own_uncertainty_and_no_other() -> None:
    """A zero error e moves μ by e sinh(μφ)/(Fφ), as an exact log shows."""
    rig = RandomRig(1)
    log = readings_of(rig)
    slope = math.sinh(rig.friction * rig.bend) / (rig.weight * rig.bend)
    for text, stated in (("0 N", 0.0), ("0.5 N", 0.5)):
        fit = tendon.fit_friction(log, rig.bend, cell_uncertainty=text)
        expected = pytest.approx(stated * slope, rel=0.03)
        assert fit.uncertainty.contribution_of(ZEROS[0]) == expected
    for text in (None, "0.5 %"):
        assumed = tendon.fit_friction(log, rig.bend, cell_uncertainty=text)
        expected = pytest.approx(0.02 * rig.weight * slope, rel=0.1)
        assert assumed.uncertainty.contribution_of(ZEROS[0]) == expected
    given = tendon.fit_friction(log, rig.bend, zero_motor="0 N")
    assert given.uncertainty.contribution_of(ZEROS[0]) == 0.0


def rested(seed: int, *, ends: tuple[float, float], weight: float = 20.0) -> pd.DataFrame:
    """Return a log with four seconds at rest without load at both ends.

    The zero of the motor's cell goes from the first of `ends` to the second, N.
    """
    rig = RandomRig(seed, strokes=12, weight=weight, columns=("time", "direction"))
    bare = pd.DataFrame({"motor (N)": 0.0, "load (N)": 0.0, "direction": ["rest"] * 200})
    log = pd.concat([bare, readings_of(rig), bare], ignore_index=True)
    log["time (s)"] = np.arange(len(log)) / rig.rate
    log["motor (N)"] += np.linspace(*ends, len(log))
    return log


def test_noise_of_both_cells_does_not_pass_for_zero_errors() -> None:
    """A cell's noise moves its 1/F and the log ratio together, which looks like a zero error."""
    errors = []
    for seed in range(4):
        rig = RandomRig(seed, spring=1.0, noise=0.02, strokes=14)
        fit = tendon.fit_friction(readings_of(rig), rig.bend)
        errors.append(fit.friction / rig.friction - 1.0)
    assert abs(np.mean(errors)) < 0.01
    assert np.max(np.abs(errors)) < 0.05


def test_a_hum_is_filtered_and_said() -> None:
    """At 80 readings a second the 50 Hz of the mains show as 30 Hz."""
    rig = RandomRig(1, rate=80.0, strokes=12)
    log = readings_of(rig)
    log["motor (N)"] += 10.0 * np.sin(2.0 * np.pi * 50.0 * log["time (s)"])
    fit = tendon.fit_friction(log, rig.bend)
    assert fit.friction == pytest.approx(rig.friction, rel=0.005)
    assert any("a hum of 30 Hz" in note and "50 Hz" in note for note in fit.notes)
    assert not any("hum" in note for note in tendon.fit_friction(readings_of(rig), rig.bend).notes)


def test_rests_without_load_say_how_well_the_zeros_are_known() -> None:
    known = tendon.fit_friction(rested(1, ends=(0.0, 0.0)), 2.5)
    unknown = tendon.fit_friction(readings_of(RandomRig(1, strokes=12, weight=20.0)), 2.5)
    assert known.uncertainty.standard_error < 0.3 * unknown.uncertainty.standard_error
    assert "mostly from the cells' zeros" in unknown.text
    assert "cells' zeros" not in known.text
    left = tendon.fit_friction(rested(1, ends=(0.2, 0.2)), 2.5)
    low, high = left.interval_95
    assert low <= 0.1 <= high


@pytest.mark.parametrize("seed", [1, 2])
def test_rests_without_load_show_a_zero_that_drifts(seed: int) -> None:
    log = rested(seed, ends=(0.5, 1.4))
    fit = tendon.fit_friction(log, 2.5)
    warning = next(text for text in fit.warnings if "without load the motor's cell" in text)
    assert "reads 0.541 N at the start and 1.36 N at the end" in warning
    assert warning.endswith('--zero-motor "0.95 N"')
    assert any(text.startswith("drift: ") and "zero" in text for text in fit.warnings)
    assert not any("would not show it" in text for text in fit.notes)
    corrected = tendon.fit_friction(log, 2.5, zero_motor="0.95 N")
    assert abs(corrected.friction / 0.1 - 1.0) < 0.01 < abs(fit.friction / 0.1 - 1.0)
    assert not any("--zero-motor" in text for text in corrected.warnings)


def test_rests_without_load_are_no_slack_tendon_and_a_zero_that_is_right_is_not_spoken_of() -> None:
    for zero in ("0 N", "1.6 N"):  # the second leaves every rest below zero
        fit = tendon.fit_friction(rested(1, ends=(0.0, 0.0)), 2.5, zero_motor=zero)
        assert not any("slack" in text for text in fit.warnings)
        is_spoken_of = any("without load the motor's cell" in text for text in fit.warnings)
        assert is_spoken_of is (zero != "0 N")
    slack = rested(1, ends=(0.0, 0.0))
    strokes = np.flatnonzero(slack["direction"] != "rest")
    slack.loc[strokes[::4], ["motor (N)", "load (N)"]] = 0.0
    assert any("slack" in text for text in tendon.fit_friction(slack, 2.5).warnings)


def test_a_zero_of_the_load_cell_that_passes_for_a_gain_is_spoken_of() -> None:
    log = rested(1, ends=(0.0, 0.0))
    log["load (N)"] += 1.6
    fit = tendon.fit_friction(log, 2.5)
    note = next(text for text in fit.notes if "without load the load's cell" in text)
    assert note.endswith('--zero-load "1.6 N"')
    corrected = tendon.fit_friction(log, 2.5, zero_load="1.6 N")
    assert abs(corrected.gain_ratio - 1.0) < 0.01 < abs(fit.gain_ratio - 1.0)
    assert not any("--zero-load" in text for text in corrected.notes)


@pytest.mark.parametrize("column", ["phase", "direction"])
def test_rows_without_load_read_as_strokes_give_no_number(column: str) -> None:
    """The load's zero keeps the rests above zero, so that they seem to be strokes."""
    noise = np.random.default_rng(1)
    log = rested(1, ends=(0.0, 0.0)).rename(columns={"direction": column})
    log["motor (N)"] += 0.02 * noise.standard_normal(len(log))
    log["load (N)"] += 1.6
    if column == "direction":
        assert tendon.fit_friction(log, 2.5).friction == pytest.approx(0.1, rel=0.01)
        return
    with pytest.raises(InputError, match="only 1 of") as error:
        tendon.fit_friction(log, 2.5)
    assert error.value.hint.endswith("--direction phase")
    named = tendon.fit_friction(log, 2.5, direction="phase")
    assert named.friction == pytest.approx(0.1, rel=0.01)


def test_a_doubtful_number_is_said_first_and_not_written(tmp_path: Path) -> None:
    log = rested(1, ends=(0.0, 0.0)).rename(columns={"direction": "phase"})
    fit = tendon.fit_friction(log, 2.5)
    assert fit.text.startswith("warning: do not use this number: there are rows without load")
    assert fit.text.count("do not use") == 1
    source = tmp_path / "log.csv"
    written = tmp_path / "mu.toml"
    log.to_csv(source, index=False)
    with pytest.raises(InputError, match="is not written"):
        fit_friction([source], "2.5 rad", out=written)
    assert not written.exists()
    fit_friction([source], "2.5 rad", direction="phase", out=written)
    assert written.exists()


@pytest.mark.parametrize("words", [("pulling", "paying out"), ("wound", "spare")])
def test_names_of_ones_own_stand_beside_rest(words: tuple[str, str]) -> None:
    log = rested(1, ends=(0.0, 0.0))
    log["direction"] = log["direction"].replace(dict(zip(("pull", "release"), words, strict=True)))
    assert tendon.fit_friction(log, 2.5).friction == pytest.approx(0.1, rel=0.01)


def test_mixed_names_are_told_apart() -> None:
    log = rested(1, ends=(0.0, 0.0)).replace({"direction": {"release": "spare"}})
    with pytest.raises(InputError, match="are mixed") as error:
        tendon.fit_friction(log, 2.5)
    assert '"pull" is read as pull, "rest" is read as rest, "spare" is unknown' in error.value.hint


def test_the_figure_of_a_fit_without_a_fault_says_what_was_not_tested() -> None:
    fit = tendon.fit_friction(readings_of(RandomRig(1)), 2.5)
    assert not fit.warnings
    verdict = fit_page(fit).says
    untested = "zero of the motor's cell, zero of the load's cell, a late cell"
    assert f"No fault found; not tested: {untested}" in verdict
    assert "the bend angle." in verdict
    rests = tendon.fit_friction(rested(1, ends=(0.0, 0.0)), 2.5)
    assert "zero of the" not in fit_page(rests).says


def test_the_figure_says_which_fault_was_found_and_allowed_for() -> None:
    """Strokes of a load that rises and falls, and a cell that reads 2 N too much."""
    time = np.arange(0.0, 64.0, 0.02)
    phase = time % 8.0 / 8.0
    is_pulling = phase < 0.5
    load = 20.0 + 30.0 * np.where(is_pulling, phase, 1.0 - phase)
    noise = np.random.default_rng(1).normal(scale=0.02, size=(2, len(time)))
    log = pd.DataFrame(
        {
            "time (s)": time,
            "direction": np.where(is_pulling, "pull", "release"),
            "motor (N)": load * np.exp(np.where(is_pulling, 0.2, -0.2)) + noise[0],
            "load (N)": load + 2.0 + noise[1],
        }
    )
    fit = tendon.fit_friction(log, 2.5)
    assert fit.friction == pytest.approx(0.08, rel=0.01)
    assert not fit.warnings
    says = fit_page(fit).says
    assert "Found and allowed for: zero of the load's cell; not tested: the bend angle." in says
    assert "No fault found" not in says


def test_rows_without_load_do_not_widen_the_axis_of_the_figure() -> None:
    log = rested(1, ends=(0.5, 1.4))
    log.loc[log["direction"] == "rest", "load (N)"] = 0.01
    fit = tendon.fit_friction(log, 2.5)
    assert fit.rows["log_ratio"].max() > 2.0
    upper = fit_page(fit).figure.axes[0]
    strokes = fit.rows["log_ratio"][fit.rows["run"] >= 0]
    assert upper.get_ylim()[0] < strokes.min()
    assert strokes.max() < upper.get_ylim()[1] < 1.3 * strokes.max()


@pytest.mark.torture
def test_drift_is_rarely_found_in_random_logs_without_any() -> None:
    tested = 0
    found = 0
    for seed in range(300):
        rig = replace(drawn_rig(seed), drift=0.0)
        try:
            fit = tendon.fit_friction(readings_of(rig), rig.bend)
        except tendon.TendonError:
            continue
        tested += any(check.name == "drift" and check.found is not None for check in fit.checks)
        found += any(text.startswith("drift: ") for text in fit.warnings)
    assert found <= 0.05 * tested


def counted(seeds: range) -> tuple[float, float]:
    """Return the share of logs that are silently wrong, and that by over two half-widths."""
    ends = outcomes(seeds)
    silent = [end for end in ends if end.is_silent]
    return len(silent) / len(ends), sum(end.ratio > 2.0 for end in silent) / len(ends)


def test_few_random_logs_are_silently_wrong() -> None:
    wrong, far = counted(range(16))
    assert wrong <= 0.07
    assert far == 0.0


@pytest.mark.torture
def test_five_per_cent_of_random_logs_are_silently_wrong() -> None:
    wrong, far = counted(range(300))
    assert wrong <= 0.05
    assert far <= 0.01


def test_readings_follow_from_the_seed() -> None:
    assert readings_of(drawn_rig(3)).equals(readings_of(drawn_rig(3)))
