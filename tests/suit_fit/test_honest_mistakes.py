"""Honest mistakes in a log or its study: each is refused, or said before any number."""

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.fits.suit.suit_window import window_ends

from .conftest import STUDY
from .test_fit_suit import ANGLE, SPOOL, TORQUE, changed

LOAD = "load_mass (kg)"
TIME = "time (s)"
COUNTS = 4096
"""Counts of the encoder in a turn."""


def counted_logs(logs):
    """Return logs whose spool is in counts."""
    return [
        log.assign(**{"motor (counts)": log[SPOOL] * COUNTS / (2.0 * np.pi)}).drop(columns=SPOOL)
        for log in logs
    ]


def counted_study(counts):
    return STUDY | {"fit": {"counts_per_turn": counts}}


# --- The load -------------------------------------------------------------------------------------


def test_a_log_without_its_load_is_not_fitted_with_one_of_several(logs):
    bare = changed(logs[:1], **{LOAD: None})
    several = STUDY | {"load": {"mass": ["0 kg", "3 kg"]}}
    with pytest.raises(tendon.InputError, match="several: 0 kg or 3 kg") as caught:
        tendon.fit_suit(several, bare)
    # The hint's own option is what the fit then takes.
    assert "--set 'load.mass=\"3 kg\"'" in caught.value.hint


def test_a_log_that_says_its_load_may_have_a_study_of_several(fit, logs):
    several = STUDY | {"load": {"mass": ["0 kg", "3 kg"]}}
    same = tendon.fit_suit(several, logs)
    assert same.numbers["tendon.pretension"].value == pytest.approx(
        fit.numbers["tendon.pretension"].value
    )


def test_loads_of_a_table_are_loads_of_the_study(fit, logs):
    rows = [{"name": "empty", "load.mass": "0 kg"}, {"name": "full", "load.mass": "4 kg"}]
    tasks = STUDY | {"table": [{"name": "task", "rows": rows}]}
    of_tasks = tendon.fit_suit(tasks, logs)
    assert set(of_tasks.window.loads) == {0.0, 4.0, *fit.window.loads}
    with pytest.raises(tendon.InputError, match="several: 0 kg or 4 kg"):
        tendon.fit_suit(tasks, changed(logs[:1], **{LOAD: None}))


def test_a_table_of_several_suits_is_refused(logs):
    rows = [{"name": "soft", "spring.stiffness": 5e3}, {"name": "stiff", "spring.stiffness": 9e3}]
    suits = STUDY | {"table": [{"name": "springs", "rows": rows}]}
    with pytest.raises(tendon.StudyError, match=r"sets spring\.stiffness .* one suit"):
        tendon.fit_suit(suits, logs)


def test_the_load_that_a_log_is_taken_with_is_said(logs):
    fit = tendon.fit_suit(STUDY, changed(logs[:1], **{LOAD: None}))
    assert any("taken with 0 kg, the study's load.mass" in note for note in fit.notes)
    fit = tendon.fit_suit(STUDY, logs[:1])
    assert not any("load.mass" in note for note in fit.notes)
    unknown = STUDY | {"load": {"mass": "0 kg to 4 kg"}}
    fit = tendon.fit_suit(unknown, changed(logs[:1], **{LOAD: None}))
    assert any("taken with one load, which is fitted" in note for note in fit.notes)


# --- Time -----------------------------------------------------------------------------------------


def test_a_time_without_a_unit_is_said_to_be_in_seconds(logs):
    bare = [log.rename(columns={TIME: "time"}) for log in logs]
    fit = tendon.fit_suit(STUDY, bare)
    said = [note for note in fit.notes if "has no unit, so it is read in seconds" in note]
    assert len(said) == len(logs)
    assert "the log takes 24 s" in said[0]


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_a_time_that_makes_strokes_implausible_is_refused(logs, factor):
    wrong = changed(logs, **{TIME: lambda log: factor * log[TIME]})
    with pytest.raises(tendon.InputError, match="a stroke takes"):
        tendon.fit_suit(STUDY, wrong)


def test_times_of_day_are_times(fit, logs):
    start = pd.Timestamp("2026-01-01 10:00")
    dated = changed(logs, **{TIME: lambda log: start + pd.to_timedelta(log[TIME], unit="s")})
    same = tendon.fit_suit(STUDY, [log.rename(columns={TIME: "time"}) for log in dated])
    for key, number in same.numbers.items():
        assert number.value == pytest.approx(fit.numbers[key].value, abs=1e-3 * number.std)


def test_a_gap_in_the_time_is_said_and_ends_a_stroke(fit, logs):
    holed = [log.drop(index=range(100, 160)).reset_index(drop=True) for log in logs]
    holed_fit = tendon.fit_suit(STUDY, holed)
    assert sum("1 gap in the time" in note for note in holed_fit.notes) == len(logs)
    low, high = fit.numbers["tendon.pretension"].interval_95
    assert low < holed_fit.numbers["tendon.pretension"].value < high
    assert not any("gap" in note for note in fit.notes)


# --- Units, signs and counts ----------------------------------------------------------------------

WRONG = {
    "torque in mN m": ({TORQUE: lambda log: 1e3 * log[TORQUE]}, "the torque swings over"),
    "grams": ({LOAD: lambda log: 1e3 * log[LOAD]}, "a load of"),
    "a negative load": ({LOAD: lambda log: log[LOAD] - 5.0}, "a load of -3 kg"),
    "sign of the joint": ({ANGLE: lambda log: -log[ANGLE]}, "the study's motion from 0 to 90"),
    "every sign": (
        {name: lambda log, name=name: -log[name] for name in (ANGLE, SPOOL, TORQUE)},
        "the study's motion from 0 to 90",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_be_is_refused(logs, name):
    change, message = WRONG[name]
    heavier = logs[1:]  # without a load grams are kilograms
    with pytest.raises(tendon.InputError, match=message) as caught:
        tendon.fit_suit(STUDY, changed(heavier, **change))
    assert caught.value.hint


def test_an_angle_between_the_limbs_is_told_from_a_wrong_sign(logs):
    between = changed(logs, **{ANGLE: lambda log: np.pi - log[ANGLE]})
    with pytest.raises(tendon.InputError) as caught:
        tendon.fit_suit(STUDY, between)
    assert "log 180 deg less this angle" in caught.value.hint


@pytest.mark.parametrize("factor", [0.25, 2.0, 4.0])
def test_counts_that_are_wrong_by_a_multiple_are_refused_with_the_right_number(logs, factor):
    with pytest.raises(tendon.InputError, match="times as far as the joint") as caught:
        tendon.fit_suit(counted_study(factor * COUNTS), counted_logs(logs))
    better = caught.value.hint.partition("About ")[2].partition(" would")[0]
    assert float(better.replace(",", "")) == pytest.approx(COUNTS, rel=0.25)


def test_a_unit_says_that_a_column_of_the_motor_is_its_angle(fit, logs):
    same = tendon.fit_suit(counted_study(COUNTS), counted_logs(logs))
    for key, number in same.numbers.items():
        assert number.value == pytest.approx(fit.numbers[key].value, rel=1e-3)


def test_numbers_not_to_be_used_are_said_so_before_any_number(fit, logs):
    assert fit.text.startswith("3 logs, 18 strokes")
    logs = logs[::2]
    wrong = tendon.fit_suit(counted_study(1.3 * COUNTS), counted_logs(logs))
    first, *_ = wrong.text.splitlines()
    assert first.startswith("warning: do not use these numbers: ")
    assert "counts per turn" in first
    wrong = tendon.fit_suit(counted_study(0.5 * COUNTS), counted_logs(logs))
    assert wrong.text.startswith("warning: do not use these numbers: ")
    swapped = [log.assign(**{LOAD: 4.0 - log[LOAD]}) for log in logs]
    first, *_ = tendon.fit_suit(STUDY, swapped).text.splitlines()
    assert first.startswith("warning: do not use these numbers: ")
    assert "loads" in first


# --- The window -----------------------------------------------------------------------------------


def test_the_fit_says_whether_its_pretension_lies_in_the_window(fit):
    """The ends are those of a sweep of the fitted suit: taut and stable between, not beyond."""
    window = fit.window
    fitted = fit.numbers["tendon.pretension"].value
    assert window.pretension == pytest.approx(fitted)
    assert window.margin == pytest.approx(min(fitted - window.low, window.high - fitted))
    assert f"the fitted {fitted:.3g} N lies inside" in " ".join(fit.text.split())
    tables = {key: {} for key in ("arm", "sheath", "tendon", "spring", "anchor", "joint", "spool")}
    for key, number in fit.numbers.items():
        table, name = key.split(".")
        if table in tables:
            unit = "" if number.unit == "1" else f" {number.unit}"
            tables[table][name] = f"{number.value!r}{unit}"
    tables["load"] = {"mass": ["0 kg", "2 kg", "4 kg"]}
    inside = (window.low + 1.0, fitted, window.high - 1.0)
    for pretension, holds in [(window.low - 2.0, False), (window.high + 2.0, False)] + [
        (value, True) for value in inside
    ]:
        tables["tendon"]["pretension"] = f"{pretension!r} N"
        run = tendon.sweep(tables)
        assert (run.record["feasible"] == 3) == holds, pretension


@pytest.mark.parametrize(
    ("stated", "judged", "warned"),
    [(["0 kg", "4 kg"], (0.0, 4.0), False), ("4 kg", (4.0,), True), (None, (0.0, 4.0), False)],
)
def test_the_window_is_judged_for_the_loads_of_the_study_and_of_the_logs(
    logs, stated, judged, warned
):
    """The study of a suit that was logged with a load in the hand may have it empty, too."""
    study = STUDY if stated is None else STUDY | {"load": {"mass": stated}}
    fit = tendon.fit_suit(study, logs[2:])
    assert fit.window.loads == judged
    said = " ".join(fit.text.split())
    assert ("an empty hand was not judged; add 0 kg to load.mass" in said) == warned
    low, high = window_ends(fit.estimate.model, fit.estimate.scores[np.newaxis], np.array(judged))[
        0
    ]
    assert (fit.window.low, fit.window.high) == pytest.approx((low, high))
