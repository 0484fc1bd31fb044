"""A suit's numbers from its own logs, judged by a rig of elastic links."""

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon

from .conftest import LOADS, STUDY, TRUTH, logs_of

ANGLE = "elbow_angle (rad)"
SPOOL = "spool_angle (rad)"
TORQUE = "motor_torque (N m)"


def changed(logs, **columns):
    """Return logs with some columns computed anew from each log; None leaves a column out."""
    changed_logs = []
    for log in logs:
        new = {name: log[name] for name in log}
        for name, change in columns.items():
            if change is None:
                del new[name]
            else:
                new[name] = change(log)
        changed_logs.append(pd.DataFrame(new))
    return changed_logs


def values(fit):
    return {key: number.value for key, number in fit.numbers.items()}


# --- Truth ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("key", TRUTH)
def test_the_truth_lies_in_the_interval(fit, key):
    low, high = fit.numbers[key].interval_95
    assert low <= TRUTH[key] <= high


def test_friction_over_the_bend_is_known_to_one_per_cent(fit):
    product = fit.numbers["sheath.friction"].value * fit.numbers["sheath.bend_angle"].value
    assert product == pytest.approx(TRUTH["sheath.friction"] * np.pi, rel=0.01)


def test_a_clean_log_draws_no_warning(fit):
    assert fit.warnings == ()


def test_each_log_is_predicted_from_the_others(fit):
    assert fit.predicted_from == "log"
    for misfit in fit.channels.values():
        assert misfit.rms <= 1.2 * misfit.predicted_rms
        assert misfit.share < 0.02


def test_what_the_logs_do_not_tell_keeps_its_prior(fit):
    length = fit.numbers["tendon.length"]
    assert length.learned < 0.1
    assert length.value == pytest.approx(2.0, rel=0.01)
    assert length.std == pytest.approx(0.04, rel=0.1)


def test_a_number_rests_on_what_the_logs_do_not_tell(fit):
    told = fit.numbers["arm.forearm_mass"]
    assert not told.is_told
    estimate = fit.estimate
    place = estimate.model.places["arm.forearm_mass"]
    shares = np.square(estimate.covariance[place]) / np.diag(estimate.covariance)
    shares /= estimate.covariance[place, place]
    for key, number in fit.numbers.items():
        rests = key in fit.rests_on.get("arm.forearm_mass", ())
        share = shares[estimate.model.places[key]]
        assert rests == (number.is_stated and share >= 0.2)
    said = " ".join(fit.text.split())
    for key, resting in fit.rests_on.items():
        assert f"{key} is {fit.numbers[key].prior}" in said or key in fit.sensors
        assert all(name in said for name in resting)


def test_what_is_exact_is_no_assumption(logs):
    exact = STUDY | {"uncertainty": {"exact": ["arm", "sheath.bend_angle"]}}
    fit = tendon.fit_suit(exact, logs)
    assert not any(key.startswith(("arm.", "sheath.")) for key in fit.rests_on)


def test_loads_a_third_heavier_than_stated_are_never_fitted_in_silence(histories):
    heavy = [histories[0.0], histories[2.6], histories[5.2]]
    fit = tendon.fit_suit(STUDY, logs_of(heavy, LOADS, seed=2))
    assert fit.warnings


# --- Metamorphic relations ------------------------------------------------------------------------


def test_the_zero_of_the_spool_does_not_matter(fit, logs):
    moved = tendon.fit_suit(STUDY, changed(logs, **{SPOOL: lambda log: log[SPOOL] + 2.0}))
    for key, number in moved.numbers.items():
        assert number.value == pytest.approx(fit.numbers[key].value, abs=0.02 * number.std)


def test_a_torque_that_is_late_is_found_to_be_so_late(fit, logs):
    def late(log):
        return np.interp(log["time (s)"] - 0.1, log["time (s)"], log[TORQUE])

    delayed = tendon.fit_suit(STUDY, changed(logs, **{TORQUE: late}))
    more = delayed.sensors["torque delay"].value - fit.sensors["torque delay"].value
    assert more == pytest.approx(0.1, rel=0.1)
    low, high = delayed.numbers["sheath.friction"].interval_95
    assert low <= TRUTH["sheath.friction"] <= high


def test_units_and_the_order_of_logs_do_not_matter(fit, logs):
    in_degrees = [
        log.rename(columns={ANGLE: "Ellbogenwinkel (Grad)", TORQUE: "Motormoment (Nm)"})
        for log in changed(logs, **{ANGLE: lambda log: np.degrees(log[ANGLE])})
    ]
    turned = tendon.fit_suit(STUDY, in_degrees[::-1])
    for key in TRUTH:
        spread = fit.numbers[key].std
        assert turned.numbers[key].value == pytest.approx(fit.numbers[key].value, abs=0.05 * spread)


def test_a_number_that_is_exact_is_not_fitted_and_narrows_the_others(fit, logs):
    exact = ["arm.a1", "arm.forearm_mass", "joint sensor zero", "torque zero", "gear friction"]
    sure = tendon.fit_suit(STUDY | {"uncertainty": {"exact": exact}}, logs)
    assert not set(exact) & {*sure.numbers, *sure.sensors}
    assert sure.numbers["tendon.pretension"].std < fit.numbers["tendon.pretension"].std


def test_a_load_cell_tells_the_pretension_better(fit, logs, histories):
    with_cell = [
        log.assign(**{"flexor_tension_proximal (N)": histories[load].flexor_motor})
        for log, load in zip(logs, LOADS, strict=True)
    ]
    better = tendon.fit_suit(STUDY, with_cell)
    pretension = better.numbers["tendon.pretension"]
    assert pretension.std < fit.numbers["tendon.pretension"].std
    low, high = pretension.interval_95
    assert low <= TRUTH["tendon.pretension"] <= high


def test_current_and_counts_are_the_same_log(fit, logs):
    raw = [
        pd.DataFrame(
            {
                "t_s": log["time (s)"],
                "Enc1": np.degrees(log[ANGLE]),
                "motor_position (counts)": log[SPOOL] * 4096 / (2.0 * np.pi),
                "motor_current_A": log[TORQUE] / 0.4,
                "load_mass_kg": log["load_mass (kg)"],
            }
        )
        for log in logs
    ]
    section = {
        "columns": {"elbow_angle": "Enc1 (deg)"},
        "torque_constant": "0.4 N m/A",
        "counts_per_turn": 4096,
    }
    same = tendon.fit_suit(STUDY | {"fit": section}, raw)
    for key in TRUTH:
        assert same.numbers[key].value == pytest.approx(fit.numbers[key].value, rel=1e-3)


# --- What is said -------------------------------------------------------------------------------


def test_the_record_has_every_key(fit):
    assert set(fit.record) >= {
        "numbers",
        "sensors",
        "rests_on",
        "channels",
        "warnings",
        "notes",
        "used",
        "set_aside",
    }
    number = fit.record["numbers"]["sheath.friction"]
    assert set(number) >= {"value", "std", "interval_95", "prior", "learned"}
    assert number["prior"] == "0.03 to 0.25"
    assert set(fit.record["channels"]["motor_torque"]) == {"rms", "unit", "predicted_rms", "share"}


def test_the_text_is_a_screen(fit):
    assert len(fit.text.splitlines()) <= 30
    assert "sheath.friction" in fit.text


def test_a_number_that_leaves_doubt_takes_it_away_once_it_is_known(fit, logs):
    shares = [doubt.share for doubt in fit.doubts]
    assert shares == sorted(shares, reverse=True)
    assert 0.0 < sum(shares[:1]) < 1.0
    first = fit.doubts[0]
    known = tendon.fit_suit(STUDY | {"uncertainty": {"exact": [first.key]}}, logs)
    left = known.window.margin_std / fit.window.margin_std
    assert left == pytest.approx(np.sqrt(1.0 - first.share), abs=0.1)


@pytest.mark.parametrize("efficiency", [0.9, 0.8])
def test_a_gear_is_told_from_the_sheath(logs, efficiency):
    """It divides the torque where the motor drives, and multiplies it where it is driven."""

    def geared(log):
        speed = np.gradient(log[SPOOL])
        return log[TORQUE] * efficiency ** -np.sign(log[TORQUE] * speed)

    fit = tendon.fit_suit(STUDY, changed(logs, **{TORQUE: geared}))
    assert fit.sensors["gear efficiency"].value == pytest.approx(efficiency, abs=0.03)
    for key, truth in TRUTH.items():
        low, high = fit.numbers[key].interval_95
        assert low <= truth <= high
    assert any(note.startswith("a gear passes") for note in fit.notes)
    assert fit.warnings == ()


def test_a_load_that_is_exact_is_not_fitted(logs):
    sure = tendon.fit_suit(STUDY | {"uncertainty": {"exact": ["load.mass"]}}, logs)
    assert not any(key.startswith("load") for key in (*sure.numbers, *sure.sensors))


# --- Logs that cannot be fitted -------------------------------------------------------------------

BAD = {
    "no joint angle": ({ANGLE: None}, "cannot tell: it has no joint angle"),
    "no motion": ({ANGLE: lambda log: 0.5 + 0.001 * log[ANGLE]}, "expected 5 deg or more"),
    "exchanged": ({ANGLE: lambda log: log[SPOOL], SPOOL: lambda log: log[ANGLE]}, "the study says"),
    "degrees": ({ANGLE: lambda log: np.degrees(log[ANGLE])}, "which no joint does"),
    "sign of the spool": ({SPOOL: lambda log: -log[SPOOL]}, "falls as the joint flexes"),
    "sign of the torque": ({TORQUE: lambda log: -log[TORQUE]}, "friction would help"),
    "constant torque": ({TORQUE: lambda log: 0.0 * log[TORQUE] + 2.0}, "the same in every row"),
    "no numbers": ({TORQUE: lambda log: np.nan * log[TORQUE]}, "0 rows with a number"),
    "time": ({"time (s)": lambda log: log["time (s)"][::-1].to_numpy()}, "time goes back"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_log_is_refused_in_one_message(logs, name):
    change, message = BAD[name]
    with pytest.raises(tendon.InputError, match=message) as caught:
        tendon.fit_suit(STUDY, changed(logs, **change))
    assert caught.value.hint


def test_one_stroke_is_refused(logs):
    one = [log.iloc[:58] for log in logs[:1]]
    with pytest.raises(tendon.InputError, match="stroke"):
        tendon.fit_suit(STUDY, one)


def test_a_commanded_torque_without_a_joint_angle_cannot_tell(tmp_path):
    rows = "\n".join(f"{0.01 * row:.2f},{row},{0.1 * row}" for row in range(100))
    log = tmp_path / "motor.csv"
    head = "# spool angle and commanded motor torque"
    columns = "time (s),motor_angle_nominal (deg),motor_torque (N m)"
    log.write_text(f"{head}\n{columns}\n{rows}\n")
    with pytest.raises(tendon.InputError) as caught:
        tendon.fit_suit(STUDY, log)
    assert "[fit.columns]" in caught.value.hint
    for reason in ("cannot tell", "no joint angle", "nominal", "commanded"):
        assert reason in str(caught.value)


def test_a_study_without_a_range_has_nothing_to_fit(logs):
    with pytest.raises(tendon.StudyError, match="nothing is to be fitted"):
        tendon.fit_suit({"arm": {}}, logs)


def test_a_study_of_several_suits_is_refused(logs):
    with pytest.raises(tendon.StudyError, match="a log is of one suit"):
        tendon.fit_suit(STUDY | {"spring": {"stiffness": [3000, 5000]}}, logs)


def test_further_lines_of_a_remark_begin_below_its_first(fit):
    lines = [line for line in fit.text.splitlines() if line.startswith("  ")]
    remarks = lines[next(at for at, line in enumerate(lines) if "  assumed" in line) :]
    named = [line for line in remarks if line[2] != " "]
    further = [line for line in remarks if line[2] == " "]
    at = len("  assumed   ")
    assert further
    assert all(line[at - 2 : at] == "  " and line[at] != " " for line in further)
    assert all(line[at - 1] == " " and line[at] != " " for line in named)
