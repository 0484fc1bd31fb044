"""Designs are the fold of their states, to the same bits, by whatever code."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tendon_cli import kernel
from tendon_cli.model import extremes
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design, Limb, Posture, Side
from tendon_cli.model.kinematics import Anchors, Excursion, Spline
from tendon_cli.model.statics import NO_EQUILIBRIUM, TAUT

from .filling import each_kind, needs_code, same_bits

ANGLES = (1, 2, 3, 7, 8, 9, 16, 17, 31, 33, 97, 257, 300)
SIDE = {
    "friction": (0.0, 0.25),
    "bend_angle": (0.0, 9.0),
    "length": (0.3, 3.0),
    "diameter": (0.5e-3, 3e-3),
    "youngs_modulus": (2e9, 2e11),
    "spring_stiffness": (400.0, 60e3),
    "pretension": (0.0, 400.0),
}


def spline(rng, low, high):
    """A curve that rises over most of the angles, and falls somewhere."""
    found = CubicSpline(
        np.linspace(-0.6, 3.1, 8), np.linspace(low, high, 8) + 0.06 * high * rng.standard_normal(8)
    )
    return Spline(found.x, found.c)


def situation_of(rng, slack):
    """Random designs along random axes, and directions and elbow angles for them; some past the dead centre."""
    shape = tuple(rng.integers(1, 5, rng.integers(1, 4)))

    def some(low, high):
        axes = rng.random(len(shape)) < 0.4
        lengths = [length if varies else 1 for length, varies in zip(shape, axes, strict=True)]
        return rng.uniform(low, high, (*lengths, 1, 1))

    new = (
        rng.random(5) < 0.25
    )  # a table of travels, a bend that follows, anchors, springs at the motor, a joint's torque

    def side(pretension):
        drawn = {name: some(*ends) for name, ends in SIDE.items()}
        drawn |= {"bend_angle": spline(rng, 2.0, 6.0)} if new[1] and rng.random() < 0.7 else {}
        drawn |= {"anchor_stiffness": some(3e3, 4e4)} if new[2] else {}
        drawn |= {"spring_at_motor": some(0.0, 1.0) > 0.3} if new[3] else {}
        return Side(
            **drawn | {"pretension": drawn["pretension"] if pretension is None else pretension}
        )

    on_the_bone = rng.random() < 0.1
    anchors = [
        0.0 if on_the_bone and at in (0, 2) else some(*ends)
        for at, ends in enumerate(
            [(0.0, 0.07), (0.08, 0.3), (0.0, 0.05), (0.04, 0.2), (0.02, 0.07)]
        )
    ]
    loaded = rng.random() < 0.8
    weight = (
        some(0.3, 3.0) * loaded,
        0.17,
        some(0.2, 0.4),
        0.0 if rng.random() < 0.3 else some(-2.0, 1.2),
    )
    pretension = (
        np.linspace(0.0, 300.0, shape[0]).reshape(-1, *[1] * (len(shape) + 1))
        if rng.random() < 0.7
        else None
    )
    unilateral = {"unilateral": True, "bilateral": False, "both": some(0.0, 1.0) > 0.5}[slack]
    joint = Anchors(*anchors, from_initial=some(0.0, 1.0) > 0.5)
    if new[0]:
        joint = Excursion(
            spline(rng, 0.0, 0.06), spline(rng, 0.0, 0.05), some(-0.2, 0.4), some(0.8, 1.2)
        )
    limb = Limb(joint, *weight)
    if new[4]:
        limb = replace(limb, stiffness=some(0.0, 2.0), rest_angle=some(0.0, 1.5))
    design = Design(
        limb,
        side(pretension),
        side(pretension),
        some(0.01, 0.06),
        some(0.5, 2.0),
        some(0.0, 12.0) * loaded,
        unilateral=unilateral,
        setting=Posture(some(0.0, 0.4) if new[1] else 0.0),
    )
    angles = np.append(0.0, rng.uniform(-0.5, 3.0, rng.choice(ANGLES)))[1 - int(on_the_bone) :]
    flexion = np.array([[True], [False]])[: rng.integers(1, 3)]
    whole = *shape, len(flexion), len(angles)
    return State.of(design, angles.reshape(1, -1), flexion), angles, whole


def rows_of(at, whole):
    """Every column of the states, by whatever code is chosen."""
    count = int(np.prod(whole))
    columns = {name: np.empty(count) for name in at.columns()} | {
        "status": np.empty(count, np.int8)
    }
    kernel.row_writer(at, whole, {})(columns, range(count))
    return {name: column.reshape(*whole[:-2], -1) for name, column in columns.items()}


def by_hand(rows, at, angles, whole):
    """What designs come to, from their rows alone; of no state not a number."""

    def over(ufunc, *names):
        return ufunc.reduce(np.concatenate([rows[name] for name in names], axis=-1), axis=-1)

    def with_sign(values):
        largest = np.fmax.reduce(np.abs(values), axis=-1)
        low = np.fmin.reduce(values, axis=-1)
        return np.where(
            (-low == largest) & (np.fmax.reduce(values, axis=-1) < largest), low, largest
        )

    status, each = rows["status"], np.broadcast_to(angles, whole).reshape(rows["status"].shape)
    slack = (status != TAUT) & (status != NO_EQUILIBRIUM)
    extension = [
        rows[f"{side}_tension_distal"]
        * np.broadcast_to(getattr(at, side).spring, whole).reshape(status.shape)
        for side in ("flexor", "extensor")
    ]
    return {
        "min_flexor_tension": over(np.fmin, "flexor_tension_distal", "flexor_tension_proximal"),
        "min_extensor_tension": over(
            np.fmin, "extensor_tension_distal", "extensor_tension_proximal"
        ),
        "max_tension": over(np.fmax, *(name for name in rows if "_tension_" in name)),
        "max_spring_extension": np.fmax.reduce(np.fmax(*extension), axis=-1),
        "peak_elbow_torque": with_sign(rows["elbow_torque"]),
        "peak_motor_torque": with_sign(rows["motor_torque"]),
        "min_elbow_stiffness": over(np.fmin, "elbow_stiffness"),
        "max_slack": over(np.fmax, "flexor_slack", "extensor_slack"),
        "slack_fraction": (status != TAUT).sum(axis=-1) / status.shape[-1],
        "unstable_fraction": (rows["elbow_stiffness"] < 0.0).sum(axis=-1) / status.shape[-1],
        "first_slack_angle": np.fmin.reduce(np.where(slack, each, np.nan), axis=-1),
    }


@needs_code
@pytest.mark.parametrize("slack", ["unilateral", "bilateral", "both"])
@pytest.mark.parametrize("seed", range(40))
def test_designs_are_the_fold_of_their_states_to_the_same_bits(seed, slack):
    at, angles, whole = situation_of(np.random.default_rng([seed, len(slack)]), slack)
    expected = None
    with each_kind() as (kinds, take):
        for kind in (None, *kinds):
            take(kind)
            found = extremes.begin(whole[:-2])
            kernel.fold_extremes(found, at, angles, whole)
            results = extremes.finished(found, whole[-1] * whole[-2])
            for name, values in by_hand(rows_of(at, whole), at, angles, whole).items():
                assert same_bits(values + 0.0, results[name]), (kind, name)
            expected = expected or results
            for name, values in results.items():
                assert same_bits(values, expected[name]), (kind, name)


@needs_code
def test_the_studies_of_this_page_have_states_of_every_kind():
    met = set()
    for seed in range(40):
        for slack in ("unilateral", "bilateral", "both"):
            met |= set(
                situation_of(np.random.default_rng([seed, len(slack)]), slack)[0].status.flat
            )
    assert met == {0, 1, 2, 3, 4}


@needs_code
@pytest.mark.parametrize("most", [1, 5, 64])
def test_states_may_come_in_portions(most):
    at, angles, whole = situation_of(np.random.default_rng(5), "unilateral")
    once, in_turn = (extremes.begin(whole[:-2]) for _ in range(2))
    kernel.fold_extremes(once, at, angles, whole)
    for start in range(0, len(angles), most):
        here = angles[start : start + most]
        flexion = np.array([[True], [False]])[: whole[-2]]
        portion = State.of(at.design, here.reshape(1, -1), flexion)
        kernel.fold_extremes(in_turn, portion, here, (*whole[:-1], len(here)))
    for name, values in once.items():
        assert same_bits(values + 0.0, in_turn[name] + 0.0), name


@needs_code
@pytest.mark.parametrize("springs", [1, 3, 8, 21])
@pytest.mark.parametrize("pretensions", [2, 7, 31, 65, 100])
@pytest.mark.parametrize("last", [True, False], ids=["pretension fastest", "pretension slowest"])
def test_it_does_not_matter_how_many_pretensions_go_with_how_many_designs(
    pretensions, springs, last
):
    lengths = (springs, pretensions) if last else (pretensions, springs)
    pretension, spring = (
        values.reshape([-1 if at == axis else 1 for at in range(4)])
        for values, axis in (
            (np.linspace(1.0, 300.0, pretensions), last),
            (np.linspace(1e3, 8e3, springs), not last),
        )
    )
    limb = Limb(Anchors(0.04, 0.15, 0.02, 0.15, 0.045), 1.54, 0.174, 0.32, 0.0)
    flexor, extensor = (
        Side(0.07, np.pi, 2.0, 1.5e-3, 145e9, spring, pull)
        for pull in (pretension, 2.0 * pretension)
    )
    design = Design(limb, flexor, extensor, 0.03, 0.8, 3.0)
    angles, flexion = np.linspace(0.0, 1.6, 37), np.array([[True], [False]])
    at, whole = State.of(design, angles.reshape(1, -1), flexion), (*lengths, 2, len(angles))
    expected = None
    with each_kind() as (kinds, take):
        for kind in (None, *kinds):
            take(kind)
            found = extremes.begin(whole[:-2])
            kernel.fold_extremes(found, at, angles, whole)
            expected = expected or found
            for name, values in found.items():
                assert same_bits(values + 0.0, expected[name] + 0.0), (kind, name)


@pytest.mark.parametrize("first", [1.2, 2.9], ids=["weightless", "past the dead centre"])
def test_no_slack_length_of_states_that_have_none(first):
    limb = Limb(Anchors(0.04, 0.15, 0.02, 0.15, 0.045), 0.0, 0.174, 0.32, 0.0)
    pretension, angles = np.reshape([0.0, 1.0, 500.0], (-1, 1, 1)), first + np.linspace(0.0, 0.2, 5)
    side, flexion = (
        Side(0.07, np.pi, 2.0, 1.5e-3, 145e9, 3e3, pretension),
        np.array([[True], [False]]),
    )
    design = Design(limb, side, side, 0.03, 1.0, 0.0)
    at, whole = State.of(design, angles.reshape(1, -1), flexion), (3, 2, 5)
    found = extremes.begin(whole[:-2])
    extremes.fold(found, at, angles)
    lengths = extremes.finished(found, 10)["max_slack"]
    assert same_bits(by_hand(rows_of(at, whole), at, angles, whole)["max_slack"] + 0.0, lengths)
    assert np.isnan(lengths[:2]).all()
