"""Windows by compiled code and by NumPy: the same bits, whatever the designs, directions, angles and limits."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from tendon_cli import kernel
from tendon_cli.model import window
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds

from .filling import each_kind, needs_code, same_bits
from .test_extremes import situation_of

FREE_LENGTH = 0.08
ENDS = ("low", "high", "low_state", "high_state", "blocked")


def bounds_of(rng, shape):
    """Random limits, each asked for in half of the cases, some of them for each design."""

    def some(low, high, otherwise):
        lengths = [length if rng.random() < 0.4 else 1 for length in shape]
        values = rng.uniform(low, high, (*lengths, 1, 1))
        return values if rng.random() < 0.5 else otherwise

    return Bounds(
        min_flexor_tension=some(1.0, 40.0, -np.inf),
        min_extensor_tension=some(1.0, 40.0, -np.inf),
        max_tension=some(150.0, 2000.0, np.inf),
        max_spring_extension=some(0.01, 0.4, np.inf),
        peak_motor_torque=some(3.0, 40.0, np.inf),
        min_elbow_stiffness=some(-5.0, 5.0, -np.inf),
        min_spring_room=some(-0.05, 0.05, -np.inf),
        peak_motor_speed=some(1.0, 20.0, np.inf),
        speed=1.0,
    )


def folded(at, bounds, whole, cuts=()):
    """Ends by whatever code is chosen, over all angles at once or over stretches of them."""
    found = window.begin(whole[:-2])
    edges = [0, *cuts, whole[-1]]
    for first, stop in itertools.pairwise(edges):
        stretch, angles, flexion = at(slice(first, stop))
        situation = State.of(
            replace(stretch, given={"spring.free_length": FREE_LENGTH}), angles, flexion
        )
        kernel.fold_window(found, situation, bounds, (*whole[:-1], stop - first), first, whole[-1])
    return found


@needs_code
@pytest.mark.parametrize("seed", range(60))
def test_windows_are_the_same_to_the_bit_by_whatever_code(seed, monkeypatch):
    """In a third of the cases with more forms than compiled code takes at once."""
    monkeypatch.setattr(kernel.native(), "most_forms", 8 if seed % 3 else 1)
    rng = np.random.default_rng(seed)
    situation, angles, whole = situation_of(rng, "unilateral")
    flexion = np.array([[True], [False]])[: whole[-2]]
    bounds = bounds_of(rng, whole[:-2])

    def at(part):
        return situation.design, angles[part].reshape(1, -1), flexion

    cuts = sorted({int(cut) for cut in rng.integers(1, whole[-1], 2)}) if whole[-1] > 2 else ()
    with each_kind() as (kinds, choose):
        choose(None)
        plain = folded(at, bounds, whole)
        for kind in kinds:
            choose(kind)
            for found in (folded(at, bounds, whole), folded(at, bounds, whole, cuts)):
                for name in ENDS:
                    assert same_bits(found[name], plain[name]), (kind, name)


def test_a_windows_ends_are_those_of_its_states():
    rng = np.random.default_rng(5)
    for _ in range(20):
        situation, angles, whole = situation_of(rng, "both")
        flexion = np.array([[True], [False]])[: whole[-2]]
        bounds = bounds_of(rng, whole[:-2])
        found = folded(
            lambda part, s=situation, a=angles, f=flexion: (s.design, a[part].reshape(1, -1), f),
            bounds,
            whole,
        )
        design = replace(situation.design, given={"spring.free_length": FREE_LENGTH})
        each = window.window(design, angles.reshape(1, -1), flexion, bounds)
        ends = window.finished(found, situation.design, bounds)
        for name in ("low", "high", "low_state", "high_state"):
            np.testing.assert_array_equal(
                np.broadcast_to(getattr(each, name), whole[:-2]), getattr(ends, name), name
            )
