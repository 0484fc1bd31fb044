"""Random motions: derivatives, numbers in a study, and the rig's courses that are kept."""

import csv
import dataclasses

import numpy as np
import pytest

from verification.rigs.elastic_links import Motion
from verification.rigs.random_motions import (
    CACHE,
    KINDS,
    Reaches,
    Sines,
    cached,
    draw_case,
    random_cases,
    run_cases,
)


@pytest.mark.parametrize(
    "joint",
    [
        Sines(0.8, 0.7, (0.3, 0.1, 0.05), (0.2, 1.0, 2.0)),
        Reaches(0.2, 1.4, 0.5, 0.6),
    ],
)
def test_derivatives_are_those_of_the_angle(joint):
    time = np.linspace(0.01, 3.9, 200)
    step = 1e-5
    for order in (0, 1):
        later = joint.derivative(time + step, order)
        earlier = joint.derivative(time - step, order)
        slope = (later - earlier) / (2.0 * step)
        assert joint.derivative(time, order + 1) == pytest.approx(slope, abs=1e-3)


def test_a_cycle_begins_where_it_ends():
    for case in random_cases():
        ends = case.joint.derivative(np.array([0.0, case.period]), 0)
        assert ends[1] == pytest.approx(ends[0], abs=1e-9)


def test_every_kind_is_there_as_often_as_said():
    for kind, count in KINDS.items():
        assert len(random_cases(kind)) == count


def test_a_study_states_the_very_numbers(tmp_path):
    case = next(case for case in random_cases("plain") if case.task)
    study = case.study(tmp_path, cycles=2, samples=50)
    value, unit = study["tendon"]["pretension"].split()
    assert float(value) == case.suit["tendon"]["pretension"]
    assert unit == "N"
    rows = list(csv.reader((tmp_path / "trajectory.csv").read_text().splitlines()))
    assert rows[0] == ["time (s)", "angle (rad)"]
    assert len(rows) == 102
    angle = case.joint.derivative(np.array([float(rows[60][0])]), 0)
    assert float(rows[60][1]) == pytest.approx(angle[0], abs=1e-15)
    task = list(csv.reader((tmp_path / "task.csv").read_text().splitlines()))
    assert task[0] == ["time (s)", "torque (N m)"]


def test_taut_motions_are_taut_and_cost_something():
    for case in random_cases():
        course = case.course()
        assert course.is_slack.any() == (case.kind == "slack") or case.kind == "slack"
        assert course.lost > 0.0
        assert np.isfinite(course.motor_torque).all()
        assert np.abs(course.motor_torque).max() <= course.peak_torque * (1.0 + 1e-6)


def test_what_is_kept_is_small():
    assert CACHE.stat().st_size < 300_000


def test_a_course_is_that_of_the_rig():
    case = random_cases("plain")[3]
    (cycle,) = run_cases([case], cycles=2, samples=160, nodes=8)
    course = case.course()
    torque = cycle.motor_torque[:-1:2]
    slides = course.slides != 0
    apart = np.abs(torque - course.motor_torque)[slides]
    assert np.median(apart) < 2e-3 * course.peak_torque
    lost = cycle.dissipated[-1] - cycle.dissipated[0]
    assert lost == pytest.approx(course.lost, rel=0.03)


@pytest.mark.torture
def test_courses_are_those_of_the_rig_with_more_links_and_samples():
    kept = cached()
    names = list(KINDS)
    picked = range(0, len(kept["seed"]), 9)
    cases = [draw_case(names[kept["kind"][row]], int(kept["seed"][row])) for row in picked]
    cycles = run_cases(cases, cycles=3, samples=640, nodes=48)
    for case, cycle in zip(cases, cycles, strict=True):
        course = case.course()
        if course.is_slack.any():
            continue
        steady = course.slides != 0
        steady &= np.roll(steady, 1) & np.roll(steady, -1)
        apart = np.abs(cycle.motor_torque[:-1:8] - course.motor_torque)[steady]
        assert apart.max() < 5e-3 * course.peak_torque, case
        lost = cycle.dissipated[-1] - cycle.dissipated[0]
        assert lost == pytest.approx(course.lost, rel=0.02), case


def test_the_same_seed_draws_the_same_case():
    first = draw_case("plain", 4)
    assert first == draw_case("plain", 4)
    assert first != draw_case("plain", 5)
    assert isinstance(first.motion(1, 10), Motion)
    assert dataclasses.replace(first, seed=9).suit == first.suit
