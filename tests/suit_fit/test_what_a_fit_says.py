"""Intervals, notes, text and figure of a fit say the same as its estimate."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tendon_cli.fits.suit.misfit import kernels_of
from tendon_cli.fits.suit.parameters import usual_inertia
from tendon_cli.fits.suit.suit_remarks import _sensor_warnings, fast_note
from tendon_cli.studies.fit_section import BACKLASH
from tests.suit_fit.conftest import TRUTH as STATED

NORMAL = 1.96
"""Half the width of a 95 % interval of a normal number, in standard deviations."""
LOAD_DISTANCE = 0.32  # m


@pytest.mark.parametrize("key", ["sheath.friction", "tendon.length"])
def test_the_interval_of_a_number_that_is_nearly_normal_ends_at_1_96_deviations(fit, key):
    number = fit.numbers[key]
    low, high = number.interval_95
    assert low == pytest.approx(number.value - NORMAL * number.std, abs=0.1 * number.std)
    assert high == pytest.approx(number.value + NORMAL * number.std, abs=0.1 * number.std)


def test_every_interval_is_about_four_deviations_wide_and_holds_its_value(fit):
    for number in fit.numbers.values():
        low, high = number.interval_95
        assert low < number.value < high
        assert 3.0 < (high - low) / number.std < 5.0


def test_every_head_of_the_text_stands_once_if_there_is_something_to_say(fit):
    heads = [line[:11].strip() for line in fit.text.splitlines()[1:]]
    assert heads.count("helps") == heads.count("holds?") == heads.count("rows") == 1
    assert heads.count("assumed") == bool(fit.rests_on)


@pytest.mark.parametrize(("degrees", "is_play"), [(0.7, True), (-0.7, False)])
def test_a_negative_backlash_is_no_backlash(fit, degrees, is_play):
    (play,) = (number for number in fit.fitted if number.key == BACKLASH)
    turned = replace(play, value=np.radians(degrees), std=1e-4)
    (warning,) = _sensor_warnings([turned])
    assert ("there is backlash" in warning) == is_play
    assert ("backlash cannot be negative" in warning) != is_play


def test_the_first_line_counts_the_stated_numbers_that_the_logs_tell(fit):
    first, *rest = fit.text.splitlines()
    told, stated = map(int, re.search(r"determine (\d+) of (\d+) numbers", first).groups())
    assert stated == sum(number.is_stated for number in fit.fitted) < len(fit.fitted)
    untold = [line for line in rest if line.startswith("not told")]
    assert told == stated - sum(key in line for key in STATED for line in untold)


def test_the_note_on_inertia_says_the_torque_of_forearm_and_load(fit):
    estimate = fit.estimate
    assert fast_note(estimate) == []  # cycles of 8 s
    faster = 20.0 * estimate.parts.acceleration
    parts = replace(estimate.parts, acceleration=faster)
    (note,) = fast_note(replace(estimate, parts=parts))
    inertia = usual_inertia(estimate.model.study) + parts.load * LOAD_DISTANCE**2
    torque = np.quantile(np.abs(inertia * faster), 0.95)
    said = float(re.search(r"up to ([\d.]+) N m", note).group(1))
    assert said == pytest.approx(torque, rel=0.05)


def test_terms_of_the_misfit_are_correlations_of_what_their_names_say(fit):
    parts = fit.estimate.parts
    white, stroke, kind, common = kernels_of(parts)
    away = np.abs(parts.angle[:, np.newaxis] - parts.angle) / np.ptp(parts.angle)
    # A bell over a quarter of the range of the angle on top of half the variance.
    half = 0.5 + 0.5 * np.exp(-np.square(away / 0.25) / 2.0)
    np.testing.assert_allclose(common, half)
    same_stroke = np.equal.outer(parts.stroke, parts.stroke)
    same_kind = np.equal.outer(parts.flexion, parts.flexion)
    same_kind &= np.equal.outer(parts.load, parts.load)
    np.testing.assert_allclose(stroke, np.where(same_stroke, half, 0.0))
    np.testing.assert_allclose(kind, np.where(same_kind, half, 0.0))
    # The mean of n rows scatters by 1/√n of a row's scatter.
    np.testing.assert_allclose(np.diag(white) * parts.count, np.median(parts.count))
    assert np.count_nonzero(white) == len(white)


def test_the_figure_shows_each_residual_in_the_unit_of_its_panel(fit):
    panels = fit.plot().axes
    channels = fit.record["channels"]
    assert len(panels) == 2 * len(channels)
    for loops, left, name in zip(panels[::2], panels[1::2], channels, strict=True):
        points = [line for line in left.lines if line.get_linestyle() == "None"]
        shown = np.concatenate([line.get_ydata() for line in points])
        factor = 180.0 / np.pi if name.endswith("angle") else 1.0
        rms = np.sqrt(np.mean(np.square(shown)))
        assert rms == pytest.approx(factor * channels[name]["rms"], rel=1e-6)
        # A point lies by its residual above the line of its stroke.
        measured = [line for line in loops.lines if line.get_linestyle() == "None"]
        fitted = set()
        for line in loops.lines:
            if line.get_linestyle() != "None":
                fitted |= {(round(x, 6), round(y, 6)) for x, y in line.get_xydata()}
        for above, beside in zip(measured, points, strict=True):
            model = np.array(above.get_ydata()) - beside.get_ydata()
            at = zip(np.round(above.get_xdata(), 6), np.round(model, 6), strict=True)
            assert set(at) <= fitted
