"""Windows by compiled code and by NumPy are the same to the bit.

So it is whatever the designs, directions, angles and limits.
"""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from tendon_cli import kernel
from tendon_cli.model import window
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tests.sampled import quick_and_torture

from .filling import kinds_of_code, needs_code, same_bits
from .random_states import random_states

FREE_LENGTH = 0.08  # of the spring, m
CONTACT_WIDTH = 0.04  # of the strap, m
CONTACT_RADIUS = 0.05  # of the strap, m
ENDS = ("low", "high", "low_state", "high_state", "blocked")


def random_bounds(rng, shape):
    """Return random limits: half of the cases ask for each, and it may differ between designs."""

    def drawn(low, high, otherwise):
        lengths = [length if rng.random() < 0.4 else 1 for length in shape]
        values = rng.uniform(low, high, (*lengths, 1, 1))
        return values if rng.random() < 0.5 else otherwise

    return Bounds(
        min_flexor_tension=drawn(1.0, 40.0, -np.inf),
        min_extensor_tension=drawn(1.0, 40.0, -np.inf),
        max_tension=drawn(150.0, 2000.0, np.inf),
        max_spring_extension=drawn(0.01, 0.4, np.inf),
        max_contact_pressure=drawn(2e4, 6e5, np.inf),
        peak_motor_torque=drawn(3.0, 40.0, np.inf),
        min_elbow_stiffness=drawn(-5.0, 5.0, -np.inf),
        min_spring_room=drawn(-0.05, 0.05, -np.inf),
        peak_motor_speed=drawn(1.0, 20.0, np.inf),
        speed=1.0,
    )


def with_parts(design):
    """Return designs with the numbers that limits on springs and straps need."""
    strapped = replace(design.arm, contact_width=CONTACT_WIDTH, contact_radius=CONTACT_RADIUS)
    return replace(design, arm=strapped, given={"spring.free_length": FREE_LENGTH})


def folded(states, bounds, cuts=()):
    """Return ends by the chosen code, over all angles at once or over stretches between cuts."""
    shape = states.shape
    count = shape[-1]
    result = window.begin(shape[:-2])
    design = with_parts(states.design)
    for first, stop in itertools.pairwise([0, *cuts, count]):
        angles = states.angles[first:stop].reshape(1, -1)
        situation = State.of(design, angles, states.flexion)
        stretch_shape = (*shape[:-1], stop - first)
        kernel.fold_window(result, situation, bounds, stretch_shape, first, count)
    return result


@needs_code
@pytest.mark.parametrize("seed", quick_and_torture(range(15), range(15, 60)))
def test_windows_are_the_same_to_the_bit_by_whatever_code(seed, monkeypatch):
    """In a third of the cases there are more forms than compiled code takes at once."""
    monkeypatch.setattr(kernel.native(), "most_forms", 8 if seed % 3 else 1)
    rng = np.random.default_rng(seed)
    states = random_states(rng, "unilateral")
    bounds = random_bounds(rng, states.shape[:-2])
    count = states.shape[-1]
    cuts = []
    if count > 2:
        cuts = sorted({int(cut) for cut in rng.integers(1, count, 2)})
    with kinds_of_code() as (kinds, choose):
        choose(None)
        expected = folded(states, bounds)
        for kind in kinds:
            choose(kind)
            for result in (folded(states, bounds), folded(states, bounds, cuts)):
                for name in ENDS:
                    assert same_bits(result[name], expected[name]), (kind, name)
