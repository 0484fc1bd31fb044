"""Each panel of the figure of a fit accuses the effect that it names, and no other."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tendon_cli.figures.friction import fit_page
from verification.friction_rigs.cases import VARYING, fits_of

SEEDS = 2
UNSEEN = 1e-4
"""Slope of the log ratio that nobody sees in a panel: 0.04 % of its limit, less than a stroke's
scatter."""


def points_drawn(fit: Any, title: str) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y of the points of a panel."""
    (axes,) = (
        axes for axes in fit_page(fit).figure.axes if axes.get_title("left").startswith(title)
    )
    drawn = [line for line in axes.lines if line.get_alpha() == 0.6]
    x = np.concatenate([line.get_xdata() for line in drawn])
    y = np.concatenate([line.get_ydata() for line in drawn])
    return x, y


def in_order_drawn(fit: Any, values: Any) -> np.ndarray:
    """Return values of the points of a fit, one direction after the other."""
    return np.concatenate([values[fit.points["way"] == sign] for sign in (1, -1)])


def slope_seen(fit: Any, title: str) -> tuple[float, float]:
    """Return the slope of the points of a panel over one standard deviation of x, and of misfits.

    Misfits are those before any effect, over the same x.
    """
    x, y = points_drawn(fit, title)
    misfit = in_order_drawn(fit, fit.points["misfit"])

    def slope(values: np.ndarray) -> float:
        return abs(float(np.polyfit((x - x.mean()) / x.std(), values, 1)[0]))

    return slope(y), slope(misfit)


def test_points_stand_at_one_over_the_force_and_at_the_rate_of_its_change() -> None:
    for fit in fits_of(VARYING, SEEDS):
        force = in_order_drawn(fit, fit.points["force"])
        np.testing.assert_allclose(points_drawn(fit, "Zero error")[0], 1.0 / force)
        rate = in_order_drawn(fit, fit.points["rate"])
        np.testing.assert_allclose(points_drawn(fit, "A late cell?")[0], rate)


@pytest.mark.parametrize("offsets", [(3.0, 0.0), (0.0, -3.0)])
def test_a_zero_error_makes_no_cell_late(offsets: tuple[float, float]) -> None:
    for fit in fits_of(replace(VARYING, offsets=offsets), SEEDS):
        late, before = slope_seen(fit, "A late cell?")
        assert late < max(0.1 * before, UNSEEN)
        assert late < 0.1 * slope_seen(fit, "Zero error")[0]


def test_a_late_cell_is_seen_to_be_late_alone() -> None:
    fits = fits_of(replace(VARYING, delay=6.0, sinusoidal=True), 3)
    found = [{check.name for check in fit.checks if check.found} for fit in fits]
    late_alone = [
        fit
        for fit, names in zip(fits, found, strict=True)
        if "delay" in names and not names & {"offset_motor", "offset_load"}
    ]
    assert late_alone
    for fit in late_alone:
        late, before = slope_seen(fit, "A late cell?")
        assert late > 0.9 * before > 0.005
        assert slope_seen(fit, "Zero error")[0] < 0.1 * late


def test_a_clean_rig_is_accused_of_nothing() -> None:
    for fit in fits_of(VARYING, SEEDS):
        assert slope_seen(fit, "A late cell?")[0] < 0.002
        assert slope_seen(fit, "Zero error")[0] < 0.002


def test_a_remark_on_the_gain_says_by_how_much_one_cell_reads_more() -> None:
    seen = set()
    for fit in fits_of(replace(VARYING, gain_mismatch=0.12), 8):
        (gain,) = (check.value for check in fit.checks if check.name == "gain")
        more = 100.0 * (max(gain, 1.0 / gain) - 1.0)
        for text in (*fit.warnings, *fit.notes):
            if text.startswith("one cell reads"):
                assert text.startswith(f"one cell reads {more:.0f} % more than the other")
                seen.add(gain > 1.0)
    assert seen == {True, False}
