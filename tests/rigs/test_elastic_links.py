"""The rig of elastic links judged by itself: laws of friction, energy, symmetry, convergence."""

import dataclasses
import itertools

import numpy as np
import pytest

from verification.rigs.elastic_links import LEAD_IN, Motion, Rig, Tendon, simulate
from verification.rigs.gripped_cables import Cables, link_tensions, move_cables, unstressed_grip
from verification.rigs.plain_dictionary import flexor_length, flexor_lever, make_rig

DEGREE = np.pi / 180.0

CHECKED_SUIT = {
    "spring": {"stiffness": 5000.0},
    "spool": {"ratio": 0.6},
    "tendon": {"pretension": 150.0},
    "load": {"mass": 2.0},
    "motion": {"inertia": 0.08},
}
"""Suit of the check values of motions in time."""


def cosine(middle, amplitude, frequency, cycles=2, samples=100):
    """Return middle − amplitude cos 2πft, angles in degrees, `samples` a cycle."""
    time = np.arange(cycles * samples + 1) / (samples * frequency)
    pulse = 2.0 * np.pi * frequency
    return Motion(
        time=time,
        angle=(middle - amplitude * np.cos(pulse * time)) * DEGREE,
        acceleration=amplitude * DEGREE * pulse**2 * np.cos(pulse * time),
    )


def steady(history):
    """Return the samples of a history at which both sheaths slide one way throughout."""
    full = np.abs(history.flexor_slides) + np.abs(history.extensor_slides) == 2.0
    around = full.copy()
    around[1:] &= full[:-1]
    around[:-1] &= full[1:]
    around[[0, -1]] = False
    return around


def random_cables(rng, count=40, nodes=9):
    compliance = rng.uniform(0.5, 2.0, (count, nodes + 1)) * 1e-7
    compliance[:, -1] += rng.uniform(0.0, 3e-4, count)
    return Cables(compliance, compliance * rng.uniform(20.0, 200.0, (count, 1)))


def test_every_node_sticks_within_its_limit_or_slips_at_it():
    rng = np.random.default_rng(5)
    cables = random_cables(rng)
    grip = rng.uniform(0.001, 0.1, 40)
    factor = np.exp(grip)[:, None]
    now = unstressed_grip(cables)
    motor_end = np.zeros(40)
    elbow_end = np.zeros(40)
    moved_nodes = 0
    for _ in range(30):
        motor_end = motor_end + rng.normal(0.0, 2e-5, 40)
        elbow_end = elbow_end + rng.normal(0.0, 1e-3, 40)
        after = move_cables(cables, now, now.state, grip, motor_end, elbow_end)
        taut = ~after.is_slack
        way = (after.position - now.position)[taut]
        tension = link_tensions(cables, after.position, motor_end, elbow_end)[taut]
        toward_motor = tension[:, :-1]
        toward_elbow = tension[:, 1:]
        assert (tension > 0.0).all()
        assert (toward_motor <= factor[taut] * toward_elbow + 1e-5).all()
        assert (toward_elbow <= factor[taut] * toward_motor + 1e-5).all()
        winds = way > 1e-12
        pays_out = way < -1e-12
        limit = (factor[taut] * toward_elbow)[winds]
        assert toward_motor[winds] == pytest.approx(limit, abs=1e-5)
        limit = (factor[taut] * toward_motor)[pays_out]
        assert toward_elbow[pays_out] == pytest.approx(limit, abs=1e-5)
        assert (after.tension[after.is_slack] == 0.0).all()
        moved_nodes += winds.sum() + pays_out.sum()
        now = after
    assert moved_nodes > 1000


def test_the_lever_is_the_slope_of_the_length():
    arm = {"a1": 0.04, "b1": 0.15, "a2": 0.02, "b2": 0.15}
    angle = np.linspace(0.05, 2.2, 40)
    slope = (flexor_length(arm, angle + 1e-6) - flexor_length(arm, angle - 1e-6)) / 2e-6
    assert flexor_lever(arm, angle) == pytest.approx(-slope, abs=1e-9)


def test_a_sliding_sheath_has_the_capstan_ratio():
    (history,) = simulate([make_rig(CHECKED_SUIT)], [cosine(45, 35, 0.3)], nodes=16)
    rows = steady(history)
    flexor = np.log(history.flexor_motor / history.flexor_elbow)
    extensor = np.log(history.extensor_motor / history.extensor_elbow)
    assert rows.mean() > 0.8
    assert np.abs(flexor[rows]) == pytest.approx(0.07 * np.pi, abs=1e-6)
    assert extensor[rows] == pytest.approx(-flexor[rows], abs=1e-6)


@pytest.mark.parametrize("frequency", [0.3, 1.3])
def test_work_of_the_motor_is_stored_lost_or_given_to_the_joint(frequency):
    motion = cosine(50, 30, frequency, cycles=1, samples=300)
    (history,) = simulate([make_rig(CHECKED_SUIT)], [motion], nodes=8)
    mean = 0.5 * (history.required_torque[1:] + history.required_torque[:-1])
    joint = np.sum(mean * np.diff(history.angle))
    stored = history.stored[-1] - history.stored[0]
    lost = history.dissipated[-1]
    assert (np.diff(history.dissipated) >= 0.0).all()
    assert history.motor_work[-1] == pytest.approx(joint + stored + lost, abs=2e-3 * lost)


def test_without_friction_nothing_is_lost_and_both_ways_agree():
    suit = CHECKED_SUIT | {"sheath": {"friction": 0.0}}
    (history,) = simulate([make_rig(suit)], [cosine(45, 40, 0.5, cycles=1)], nodes=5)
    assert history.dissipated[-1] == pytest.approx(0.0, abs=1e-9)
    assert history.motor_torque == pytest.approx(history.motor_torque[::-1], abs=1e-6)
    assert history.flexor_motor == pytest.approx(history.flexor_elbow, abs=1e-5)


def test_without_friction_a_spring_serves_either_end():
    suit = CHECKED_SUIT | {"sheath": {"friction": 0.0}}
    at_motor = CHECKED_SUIT | {
        "sheath": {"friction": 0.0},
        "spring": {"stiffness": 5000.0, "at": "motor"},
    }
    motion = cosine(45, 40, 0.5, cycles=1)
    here, there = simulate([make_rig(suit), make_rig(at_motor)], [motion, motion], nodes=5)
    assert there.spool_angle == pytest.approx(here.spool_angle, abs=1e-8)
    assert there.motor_torque == pytest.approx(here.motor_torque, abs=1e-5)


def test_a_symmetric_suit_is_symmetric():
    tendon = Tendon(8e-6, 2e-4, 0.0, 0.1, lambda angle: np.full_like(angle, 3.0), 150.0)
    rig = Rig(
        flexor=tendon,
        extensor=tendon,
        flexor_travel=lambda angle: 0.05 * angle,
        extensor_travel=lambda angle: 0.05 * angle,
        flexor_arm=lambda angle: np.full_like(angle, 0.05),
        extensor_arm=lambda angle: np.full_like(angle, 0.05),
        flexor_radius=0.03,
        ratio=1.0,
        weight_moment=3.0,
    )
    there = cosine(0, 40, 0.5)
    back = Motion(there.time, -there.angle, -there.acceleration)
    first, second = simulate([rig, rig], [there, back], nodes=8)
    rows = np.abs(np.diff(first.spool_angle, prepend=0.0)) > 1e-6
    assert second.spool_angle == pytest.approx(-first.spool_angle, abs=1e-9)
    assert second.motor_torque[rows] == pytest.approx(-first.motor_torque[rows], abs=1e-7)
    assert second.extensor_motor[rows] == pytest.approx(first.flexor_motor[rows], abs=1e-5)


def test_more_links_change_little_and_ever_less():
    suit = CHECKED_SUIT | {"sheath": {"friction": 0.2}}
    motion = cosine(45, 35, 0.5, cycles=1, samples=60)
    runs = [simulate([make_rig(suit)], [motion], nodes)[0] for nodes in (3, 6, 12, 24)]
    rows = steady(runs[0])
    angles = [run.spool_angle[rows] for run in runs]
    changes = [np.abs(b - a).max() for a, b in itertools.pairwise(angles)]
    assert changes[1] < 0.3 * changes[0]
    assert changes[2] < 0.3 * changes[1]
    assert changes[2] < 1e-5


def test_finer_steps_change_little_and_ever_less():
    rig = make_rig(CHECKED_SUIT)
    lost = []
    for samples in (30, 60, 120):
        (run,) = simulate([rig], [cosine(50, 30, 1.0, samples=samples)], nodes=6)
        lost.append(run.dissipated[-1] - run.dissipated[samples])
    assert abs(lost[2] - lost[1]) < 0.5 * abs(lost[1] - lost[0])
    assert lost[1] == pytest.approx(lost[2], rel=2e-3)


def test_a_slack_extensor_leaves_the_flexor_alone():
    suit = {"load": {"mass": 10.0}}
    (history,) = simulate([make_rig(suit)], [cosine(60, 25, 0.2)], nodes=8)
    slack = history.extensor_slack
    lever = flexor_lever({"a1": 0.04, "b1": 0.15, "a2": 0.02, "b2": 0.15}, history.angle)
    wanted = history.required_torque / lever
    assert slack.mean() > 0.9
    assert (history.extensor_motor[slack] == 0.0).all()
    assert history.flexor_elbow[slack] == pytest.approx(wanted[slack], abs=0.1)
    assert not history.flexor_slack.any()


def test_a_rest_changes_nothing():
    motion = cosine(45, 30, 0.5, cycles=1, samples=60)
    rest = Motion(
        time=np.linspace(0.0, 5.0, 122),
        angle=np.append(motion.angle, np.full(61, motion.angle[20])),
        acceleration=np.zeros(122),
    )
    (history,) = simulate([make_rig(CHECKED_SUIT)], [rest], nodes=8)
    assert np.ptp(history.spool_angle[62:]) == pytest.approx(0.0, abs=1e-12)
    assert history.dissipated[-1] == pytest.approx(history.dissipated[62], rel=1e-12)


def test_the_lead_in_ends_where_the_motion_begins():
    motion = cosine(45, 30, 0.5, cycles=1)
    (history,) = simulate([make_rig(CHECKED_SUIT)], [motion], nodes=4)
    assert LEAD_IN > 0
    assert len(history.time) == len(motion.time)
    assert history.dissipated[0] == 0.0


EXTREMES = {
    "much friction": {"sheath": {"friction": 0.8}},
    "no springs": {"spring": {"stiffness": np.inf}, "tendon": {"pretension": 400.0}},
    "a large extensor spool": {"spool": {"ratio": 1.5}},
    "no pretension": {"tendon": {"pretension": 0.0}},
    "one smooth sheath": {"sheath": {"friction": 0.1, "extensor": {"friction": 0.0}}},
    "a spring at the motor on one side": {"spring": {"flexor": {"at": "motor"}}},
}


def test_extremes_balance_too():
    names = list(EXTREMES)
    task = 6.0 * np.sin(np.linspace(0.0, 30.0, 121))
    motion = dataclasses.replace(cosine(50, 30, 0.5, samples=60), task=task)
    rigs = [make_rig(EXTREMES[name]) for name in names]
    for name, history in zip(names, simulate(rigs, [motion] * len(rigs), nodes=6), strict=True):
        mean = 0.5 * (history.required_torque[1:] + history.required_torque[:-1])
        joint = np.sum(mean * np.diff(history.angle))
        stored = history.stored[-1] - history.stored[0]
        lost = history.dissipated[-1]
        assert history.motor_work[-1] == pytest.approx(joint + stored + lost, abs=0.03 * lost), name
        assert min(history.flexor_motor.min(), history.extensor_elbow.min()) >= 0.0


def test_a_flexor_without_a_lever_has_no_balance():
    with pytest.raises(RuntimeError, match="no spool angle balances"):
        simulate([make_rig({})], [cosine(120, 50, 0.5, cycles=1, samples=40)], nodes=3)


CHECKED = {
    "A": ((45, 35, 0.75), (0, 0), (7.527, 3.474, 6.899, 22.382, 4.446, 8.403)),
    "B": ((50, 10, 2.0), (0, 0), (7.275, 3.405, 0.981, 6.166, 2.145, 0.531)),
    "C": ((50, 30, 1.3), (0, 0), (10.160, 4.457, 8.225, 23.421, 5.358, 4.939)),
    "D": ((45, 30, 0.5), (4, 2.0), (7.855, 3.019, 6.909, 28.847, 9.522, 10.983)),
}
"""Motion; task; torque, its rms, speed, power, braking, loss per cycle: section 19."""


CYCLE = 200
"""Samples of a cycle of the check values."""


@pytest.fixture(scope="module")
def checked_cycles():
    """Return the second cycle of each motion of the check values."""
    motions = []
    for (middle, amplitude, frequency), (task, pulse), _ in CHECKED.values():
        motion = cosine(middle, amplitude, frequency, cycles=2, samples=CYCLE)
        torque = task * np.sin(2.0 * np.pi * pulse * motion.time)
        motions.append(dataclasses.replace(motion, task=torque))
    histories = simulate([make_rig(CHECKED_SUIT)] * len(motions), motions, nodes=8)
    cycles = [history.select(slice(CYCLE, None)) for history in histories]
    return dict(zip(CHECKED, cycles, strict=True))


@pytest.mark.parametrize("name", CHECKED)
def test_the_check_values_of_motions_in_time(checked_cycles, name):
    cycle = checked_cycles[name]
    _, _, wanted = CHECKED[name]
    torque, rms, speed, power, braking, lost = wanted
    rows = steady(cycle)
    spool_speed = np.gradient(cycle.spool_angle, cycle.time)
    spool_power = cycle.motor_torque * spool_speed
    assert np.abs(cycle.motor_torque).max() == pytest.approx(torque, rel=6e-3)
    assert np.sqrt(np.mean(cycle.motor_torque[1:] ** 2)) == pytest.approx(rms, rel=2.5e-2)
    assert np.abs(spool_speed[rows]).max() == pytest.approx(speed, rel=1e-2)
    assert spool_power[rows].max() == pytest.approx(power, rel=1e-2)
    assert -spool_power[rows].min() == pytest.approx(braking, rel=1e-2)
    assert cycle.dissipated[-1] - cycle.dissipated[0] == pytest.approx(lost, rel=2.5e-2)
