"""Windows along random motions, against a dense sweep over pretensions.

Which states count turns with the pretension: a tendon that turns at one sample more may break a
limit for some newtons in the middle of what would be a window.
"""

from dataclasses import replace

import numpy as np
import pytest

from tendon_cli.model.bounds import Bounds
from tendon_cli.model.motion_window import window_along

from .designs import baseline, design
from .motions import Wave
from .test_sliding import LIMITS, keeps, values_at

STABLE = "stiffness"
"""Stands for no other limit than to be taut and stable."""


def random_motion(seed):
    """Return a random suit along a random motion, and a limit with its bound."""
    rng = np.random.default_rng(seed)
    task = (0.0, 0.0)
    if rng.random() < 0.4:
        task = (rng.uniform(0.0, 5.0), rng.uniform(0.3, 2.0))
    wave = Wave(rng.uniform(35.0, 70.0), rng.uniform(10.0, 30.0), rng.uniform(0.3, 2.0), *task)
    trajectory = wave.trajectory(np.arange(0.0, rng.uniform(2.0, 4.0), 0.01), 0.3)
    suit = design(
        baseline(
            ratio=rng.uniform(0.4, 1.0),
            load_mass=rng.choice([0.0, 1.0, 2.0, 4.0]),
            spring_stiffness=rng.choice([2e3, 5e3, 1e4]),
            friction=rng.uniform(0.03, 0.15),
            pretension=150.0,
        )
    )
    arm = replace(suit.arm, inertia=rng.uniform(0.02, 0.1))
    made = replace(suit, trajectory=trajectory, arm=arm)
    limit = str(rng.choice([STABLE, STABLE, *LIMITS]))
    if limit == STABLE:
        return made, limit, np.inf
    at_150, _ = values_at(made, np.array([150.0]))
    return made, limit, rng.uniform(1.0, 2.0) * float(at_150[limit][0])


def faults_of(seed, swept=120):
    """Return how a sweep over pretensions contradicts the window along a random motion.

    Returns:
        Number of pretensions in the window that break a limit; and the width of the widest stretch
        of swept pretensions that keep all limits beyond the window, less the window's own, N.
    """
    made, limit, bound = random_motion(seed)
    limits = {} if limit == STABLE else {limit: bound}
    if not np.all(np.isfinite(list(limits.values()))):
        return 0, 0.0
    window = window_along(made, made.trajectory, Bounds(**limits))
    low = float(window.low)
    high = float(window.high)
    if not low <= high:
        low = 0.0
        high = -1.0
    last = 1.3 * high if np.isfinite(high) and high > 0.0 else 3000.0
    # Most holes lie close to an end.
    near = np.linspace(0.9 * high, 1.1 * high, swept // 2) if high > 0.0 else []
    pretensions = np.sort([*np.linspace(0.5, last, swept - swept // 2), *near])
    pretensions = pretensions[np.isfinite(pretensions)]
    is_kept = keeps(values_at(made, pretensions)[0], limit, bound)
    reserve = 1e-6 * (1.0 + pretensions)
    is_inside = (pretensions >= low + reserve) & (pretensions <= high - reserve)
    is_outside = (pretensions < low - reserve) | (pretensions > high + reserve)
    widest = 0.0
    start = None
    for pretension, is_other in zip(pretensions, is_outside & is_kept, strict=True):
        if is_other:
            start = pretension if start is None else start
            widest = max(widest, pretension - start)
        else:
            start = None
    return int((is_inside & ~is_kept).sum()), widest - max(high - low, 0.0)


def check_motions(seeds):
    """Fail with the seeds of motions whose window a sweep contradicts."""
    faults = {}
    for seed in seeds:
        holes, wider = faults_of(seed)
        if holes or wider > 0.0:
            faults[seed] = (holes, wider)
    assert not faults


def test_no_sweep_refuses_a_pretension_in_a_window_or_finds_a_wider_one():
    check_motions([8, 35, 36, 49, 60, 149, 184, 243, 374, 395, *range(10)])


@pytest.mark.torture
def test_no_sweep_contradicts_the_windows_of_two_hundred_motions():
    check_motions(range(1000, 1200))


def test_a_window_ends_where_a_tendon_turns_at_one_sample_more():
    """Swings of 45 ∓ 30° whose upper end has a hole of some newtons just below."""
    trajectory = Wave(45.0, 30.0, 0.6).trajectory(np.arange(0.0, 3.0, 0.01), 0.3)
    suit = design(baseline(ratio=0.45, spring_stiffness=1e4, pretension=150.0))
    made = replace(suit, trajectory=trajectory, arm=replace(suit.arm, inertia=0.06))
    window = window_along(made, trajectory, Bounds())
    pretensions = np.linspace(float(window.low) + 1e-3, float(window.high) - 1e-3, 2000)
    assert keeps(values_at(made, pretensions)[0], STABLE, np.inf).all()
