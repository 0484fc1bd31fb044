"""A motion in time is shown over time: its turns, the range of the torque, the record's ends."""

import re
from dataclasses import replace

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli import say
from tendon_cli.answers.text import short_text
from tendon_cli.cube.choice_grid import over_motion
from tendon_cli.reports.data import MOST_SAMPLES, curves, places_of, states_record
from tendon_cli.studies.spaces import space_of
from tendon_cli.verbs.answer_record import ChecksRecord, CutoffCheck

TIME = np.round(np.arange(0.0, 4.0, 0.01), 9)  # s
ANGLE = 50.0 - 30.0 * np.cos(np.pi * TIME)  # deg
TORQUE = -3.0 * np.sin(np.pi * TIME)  # N m
NOISE = np.random.default_rng(3).normal(0.0, 0.8, len(TIME))  # deg


def study_of(angle=ANGLE, **tables):
    """Return a study of a motion in time."""
    motion = {
        "trajectory": {
            "time": TIME.tolist(),
            "angle": [f"{value!r} deg" for value in angle.tolist()],
        },
        "inertia": "0.08 kg m2",
    }
    return tendon.study(
        {
            "tendon": {"pretension": "150 N"},
            "spring": {"stiffness": "5 kN/m"},
            "spool": {"ratio": 0.6},
            "motion": motion,
            **tables,
        }
    )


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Return a run of two loads along a motion with a task over time."""
    task = {"time": TIME.tolist(), "torque": TORQUE.tolist()}
    study = study_of(load={"mass": ["0 kg", "2 kg"], "torque": task})
    return tendon.sweep(study, tmp_path_factory.mktemp("motion") / "run")


@pytest.fixture(scope="module")
def answer(tmp_path_factory):
    """Return an answer for one load along a motion."""
    study = study_of(load={"mass": "2 kg"})
    return tendon.design(study, tmp_path_factory.mktemp("motion") / "answer")


def stretches(holds):
    """Count the stretches in which something holds."""
    return int((np.diff(np.concatenate(([0], holds.astype(int)))) == 1).sum())


def drawn(result, tmp_path, *names, **options):
    """Return the figure of a result as SVG."""
    file = tmp_path / "figure.svg"
    result.plot(*names, **options).savefig(file)
    return file.read_text()


def test_curves_mark_turns_their_range_and_the_ends_of_the_record(swept, tmp_path):
    states = swept.states[swept.states["load_mass"] == 0.0]
    turns = stretches((states["turning"] & ~states["at_record_end"]).to_numpy())
    assert turns >= 2
    where = ["load_mass = 0 kg"]
    torque = drawn(swept, tmp_path, "motor_torque", where=where)
    assert torque.count('id="turning') == turns
    assert torque.count('id="record end') == 2
    assert torque.count('id="torque band') == 1
    assert "time (s)" in torque
    tension = drawn(swept, tmp_path, "flexor_tension_distal", where=where)
    assert 'id="torque band' not in tension
    over_angle = drawn(swept, tmp_path, "motor_torque", where=where, x="elbow_angle")
    assert 'id="turning' not in over_angle


def test_the_page_has_the_samples_of_the_motion_with_both_candidates(swept):
    study = swept.study
    space = space_of(study)
    shown = curves(study, space.design(), (2,))
    record, _ = states_record(study, [np.arange(2)], [("", shown)])
    places = places_of(study)
    assert len(places) <= MOST_SAMPLES
    states = swept.states[swept.states["load_mass"] == 0.0]
    first = states.iloc[places]
    np.testing.assert_allclose(record["times"], first["time"], atol=1e-6)
    assert record["ends"] == first["at_record_end"].astype(int).tolist()
    np.testing.assert_array_equal(shown["turning"][0, 0], first["turning"])
    np.testing.assert_allclose(shown["motor_torque"][0, 0], first["motor_torque"])
    np.testing.assert_allclose(shown["motor_torque_other"][0, 0], first["motor_torque_other"])


def test_the_window_over_time_is_the_tightest_of_all_moments_that_count(answer, tmp_path):
    best = answer.record["best"]
    window = over_motion(answer.answer)
    assert window.is_in_time
    floor, roof = window.tightest
    assert np.nanmax(floor[window.does_count]) == pytest.approx(best["pretension_from"], rel=1e-6)
    assert roof[window.does_count].min() == pytest.approx(best["pretension_to"], rel=1e-6)
    assert not floor[~window.does_count].any()
    place = np.argmin(np.abs(window.along - best["to_time"]))
    assert roof[place] == pytest.approx(best["pretension_to"], rel=1e-6)
    figure = drawn(answer, tmp_path, "between")
    for words in ("the window over time", "time (s)", "works at all times"):
        assert words in figure
    assert figure.count('id="record end') == 2
    assert "every moment from 0.34 to 3.65 s" in " ".join(answer.text.split())


def test_the_page_of_a_state_and_its_motor_speak_of_time(tmp_path):
    page = tendon.state(study_of(load={"mass": "2 kg"}), plot=tmp_path / "motor.svg")
    assert ": 0.34 s, flexion at" in page.text
    motor = {line.symbol: line.values[0] for line in page.lines if line.section.startswith("Motor")}
    balance = motor["P_a"] + motor["P_U"] + motor["P_μ"]
    assert motor["P_m"] == pytest.approx(balance, rel=1e-6)
    figure = (tmp_path / "motor.svg").read_text()
    for words in ("Torque over time", "Torque against speed", "end of the record"):
        assert words in figure


def test_a_breach_is_named_with_the_moment_of_its_worst_state(tmp_path):
    limits = {"peak_motor_power": "5 W", "peak_motor_speed": "2 rad/s", "max_tension": "150 N"}
    run = tendon.sweep(study_of(load={"mass": "2 kg"}, limits=limits), tmp_path / "run")
    states = run.states[~run.states["at_record_end"]].set_index("time")
    record = tendon.check(run).record
    breaches = {breach["limit"]: breach for breach in record["breaches"]}
    assert set(breaches) == set(limits)
    for breach in breaches.values():
        state = states.loc[breach["time"]]
        assert state["direction"] == breach["direction"]
        assert state["elbow_angle"] == pytest.approx(breach["elbow_angle"])
    tensions = states[[name for name in states if re.match(r".*_tension_(distal|proximal)", name)]]
    assert tensions.loc[breaches["max_tension"]["time"]].max() == pytest.approx(
        breaches["max_tension"]["value"], rel=1e-3
    )
    assert "; worst at " in tendon.check(run).text


def test_what_the_cutoff_decides_is_said_first_and_nothing_of_a_clean_record(swept, answer):
    assert "decided by the cutoff" not in swept.text
    assert "decided by the cutoff" not in answer.text
    noisy = study_of(ANGLE + NOISE)
    run = tendon.sweep(noisy)
    said = say.cutoff_words(ChecksRecord.from_json(run.record["checks"]))
    assert said.startswith("The motor's peaks are decided by the cutoff: ")
    assert said in run.text.splitlines()[1]
    check = run.record["checks"]["cutoff"]
    for power in check["peak_motor_power"]:
        assert say.quantity("peak_motor_power", power, 3) in said
    assert "at 6 Hz" in said
    assert "at 4.2 Hz" in said
    decided = tendon.design(noisy)
    first = decided.short.split("\n\n")[0].replace("\n  ", " ")
    assert say.cutoff_words(decided.answer.checks) in first
    without_window = replace(decided.answer, best=None)
    first = short_text(without_window).split("\n\n")[0].replace("\n  ", " ")
    assert first.startswith("No pretension works for the design")
    assert "decided by the cutoff" in first


@pytest.mark.torture
def test_a_cutoff_that_leaves_no_window_is_named():
    limits = {"peak_motor_power": "1 W"}
    answer = tendon.design(study_of(ANGLE + NOISE, limits=limits))
    assert not answer.feasible
    assert "decided by the cutoff" in answer.short.split("\n\n")[0].replace("\n  ", " ")


def test_cutoff_words_leave_out_what_is_not_known():
    check = CutoffCheck(
        cutoff=6.0,
        lower=4.2,
        peak_motor_speed=(None, None),
        peak_motor_power=(10.0, 5.0),
        decides=True,
    )
    said = say.cutoff_words(ChecksRecord(cutoff=check))
    assert said == "The motor's peaks are decided by the cutoff: 10 W at 6 Hz, 5 W at 4.2 Hz."
    undecided = replace(check, decides=False)
    assert say.cutoff_words(ChecksRecord(cutoff=undecided)) == ""
    assert say.cutoff_words(None) == ""


def test_a_constant_torque_over_time_is_the_same_over_the_angle():
    over_time = {"time": [0.0, 4.0], "torque": [-3.0, -3.0]}
    over_angle = {"angle": ["-20 deg", "50 deg", "120 deg"], "torque": [-3.0, -3.0, -3.0]}
    runs = [
        tendon.sweep(study_of(load={"torque": torque, "scale": [0.0, 1.0]}))
        for torque in (over_time, over_angle)
    ]
    for name in ("elbow_torque", "motor_torque", "elbow_stiffness", "turning"):
        np.testing.assert_allclose(runs[0].states[name], runs[1].states[name], atol=1e-9)
    for name in ("peak_motor_power", "motor_work_in", "friction_loss"):
        np.testing.assert_allclose(runs[0].designs[name], runs[1].designs[name], rtol=1e-9)


def test_each_phase_of_a_gait_asks_for_its_own_torque():
    phase = (TIME / 1.0) % 1.0
    angle = 50.0 + 10.0 * np.sin(2.0 * np.pi * phase)
    push = np.where(phase < 0.5, -24.0 * np.sin(2.0 * np.pi * phase) ** 2, 0.0)
    task = {"time": TIME.tolist(), "torque": push.tolist()}
    run = tendon.sweep(study_of(angle, load={"torque": task, "scale": [0.0, 0.5, 1.0]}))
    torques = run.states.pivot(index="time", columns="load_scale", values="elbow_torque")
    counts = ~run.states.set_index("time")["at_record_end"].loc[lambda at: ~at.index.duplicated()]
    asked = torques[1.0] - torques[0.0]
    half = torques[0.5] - torques[0.0]
    np.testing.assert_allclose(half, 0.5 * asked, atol=1e-9)
    stance = counts & (np.abs(phase - 0.25) < 0.06)
    swing = counts & (np.abs(phase - 0.75) < 0.15)
    assert asked[stance].to_numpy() == pytest.approx(push[stance], abs=1.5)
    assert np.abs(asked[swing]).max() < 0.5
