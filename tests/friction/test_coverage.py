"""The mean is right, the 95 % interval holds the truth in 95 %, and faults are warned of."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tendon_cli.fits.friction import fit_friction
from verification.friction_rigs.ablation import WITHOUT
from verification.friction_rigs.cases import CASES, FRICTION, fits_of, mentions, readings
from verification.friction_rigs.rig import simulate
from verification.friction_rigs.torture import covers, run, silent_share

CLEAN = [name for name, case in CASES.items() if case.clean]
SHARP = [
    "clean",
    "clean, no time",
    "direction column",
    "zero rows",
    "gain 3 %",
    "dwell",
    "10 rows a stroke",
]


@pytest.fixture(scope="module")
def counts():
    """Fit a seed of every case, two of those whose mean is tested; `make torture` has 200."""
    by_rig = sorted(CASES, key=lambda name: str(CASES[name].rig))
    return {name: run(name, 1 + (name in SHARP), first_seed=5) for name in by_rig}


def test_hardly_any_fit_is_silently_wrong(counts) -> None:
    assert silent_share(list(counts.values()), hidden=False) <= 0.02


def test_what_cannot_be_told_or_matters_is_put_a_number_to(counts) -> None:
    """A zero error under a constant force is noted.

    It is warned of where the levels of the directions differ.
    """
    noted = []
    warned = []
    for name, count in counts.items():
        if count.case.hides:
            noted += [(*fit.notes, *fit.warnings) for fit in count.fits]
        if "levels differ" in name:
            warned += [fit.warnings for fit in count.fits]
    assert len(noted) > 0
    assert len(warned) > 0
    assert all(mentions(texts, "zero error") for texts in noted)
    assert all(mentions(texts, "zero error") for texts in warned)


def test_clean_logs_are_quiet_and_as_sharp_as_ever(counts) -> None:
    fits = [fit for name in CLEAN for fit in counts[name].fits]
    assert np.mean([bool(fit.warnings) for fit in fits]) <= 0.05
    # The cases share their draws: one rig in four that friction favours by chance shows in all.
    assert np.mean([covers(fit) for fit in fits]) > 0.7
    for name in SHARP:
        assert abs(counts[name].bias()) < 0.007
        assert counts[name].half_width() < 0.011


def test_what_never_slips_is_refused(counts) -> None:
    for count in counts.values():
        if count.case.refused:
            assert not count.fits


@pytest.mark.parametrize(
    "changed", [{"load_spring": 0.1}, {"load_spring": 1.0, "sinusoidal": True}]
)
def test_readings_without_noise_are_exact_and_show_nothing(changed: dict[str, Any]) -> None:
    rig = replace(
        CASES["clean"].rig,
        noise=0.0,
        resolution=0.0,
        friction_scatter=0.0,
        gain_scatter=0.0,
        **changed,
    )
    for fit in fits_of(rig, 2):
        assert fit.friction == pytest.approx(rig.friction, rel=1e-4)
        assert covers(fit)
        assert not fit.warnings
        assert not any(check.found for check in fit.checks if check.name != "gain")


@pytest.mark.parametrize("down", [40.0, 60.0])
def test_a_zero_error_that_matters_is_warned_of_where_the_directions_differ(down: float) -> None:
    """Weights are exchanged at the turns.

    With 60 N up and 40 N down, 1 N moves the number by 4 %; with the same weight there is a note.
    """
    differs = down < 60.0
    rig = replace(CASES["clean"].rig, weights=(60.0, 60.0))
    heavy = simulate(rig, 2)
    light = simulate(replace(rig, weights=(down, down)), 2)
    is_down = heavy.toward < 0.0
    for seed in range(2):
        motor = np.where(is_down, light.motor_cell[:, seed], heavy.motor_cell[:, seed])
        load = np.where(is_down, light.load_cell[:, seed], heavy.load_cell[:, seed])
        fit = fit_friction(readings(motor, load), rig.bend_angle)
        messages = fit.warnings if differs else fit.notes
        assert mentions(messages, "a zero error of 1 N")
        if differs:
            text = next(text for text in messages if "a zero error of 1 N" in text)
            moved = text.partition("would move ")[2].partition(" by ")[2].partition(" %")[0]
            assert float(moved) == pytest.approx(4.0, abs=0.5)
        assert bool(fit.warnings) == differs


@pytest.mark.parametrize("name", ["dwell while sticking", "delay 100 ms, crank"])
def test_weak_spots_hold(name: str) -> None:
    """A motor pauses while the tendon sticks; noise of a late cell must not hide how late it is."""
    count = run(name, 8, first_seed=9)
    assert len(count.fits) == count.seeds
    assert np.mean([covers(fit) for fit in count.fits]) >= 0.8
    assert abs(count.bias()) < 0.015


def test_a_pause_just_below_the_limit_is_no_slip() -> None:
    """The motor stands where the ratio is at 0.92 to 0.98 of the limit, and goes on to it."""
    rig = replace(CASES["clean"].rig, dwell=60, sticking=(0.51, 0.56))
    fits = fits_of(rig, 8, first_seed=2)
    assert np.mean([covers(fit) for fit in fits]) >= 0.75
    assert np.mean([fit.friction for fit in fits]) == pytest.approx(FRICTION, rel=5e-3)


def test_every_part_that_an_ablation_takes_out_is_there() -> None:
    for changes in WITHOUT.values():
        for module, name, _ in changes:
            assert hasattr(module, name)


@pytest.mark.torture
def test_two_hundred_seeds_of_every_case() -> None:
    counts = [run(name, 200) for name in CASES]
    assert silent_share(counts, hidden=False) <= 0.02
    quiet = [fit for count in counts if not count.case.hides for fit in count.quiet]
    assert 0.90 <= np.mean([covers(fit) for fit in quiet]) <= 0.99
