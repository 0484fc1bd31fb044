"""Of any study the compiled code writes, bit for bit, the rows that NumPy writes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sweep.studies import RANGES

from .filling import COUNTS, DIRECTIONS, assert_same_rows, model, needs_code, plan_of

pytestmark = needs_code
searched = settings(deadline=None, derandomize=True, max_examples=250)


def some(rng, low, high, count):
    """Values of an axis, some of them nought where they may be."""
    keep = (rng.random(count) > 0.15) | (low > 0.0)
    return list(dict.fromkeys((rng.uniform(low, high, count) * keep).tolist()))


def cases_of(draw, rng):
    """Cases that each have a model, and may have a pretension, of their own."""
    cases = []
    for at in range(draw(st.integers(2, 4))):
        own = {"name": str(at), "load": {"mass": float(rng.uniform(0.0, 9.0))}}
        slack, reference = (
            rng.choice(["unilateral", "bilateral"]),
            rng.choice(["published", "initial"]),
        )
        own["model"] = model(str(slack), str(reference))
        if draw(st.booleans()):
            own["tendon"] = {"flexor": {"pretension": float(rng.uniform(0.0, 300.0))}}
        cases.append(own)
    return cases


def angles_of(draw, rng):
    low = draw(st.sampled_from([-0.7, 0.0, 1.0, 2.8]))
    return rng.uniform(
        low, draw(st.sampled_from([low + 0.1, 3.0])), draw(st.sampled_from(COUNTS))
    ).tolist()


@st.composite
def studies(draw):
    """The plan of any study."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    varied = draw(st.lists(st.sampled_from(sorted(RANGES)), max_size=4, unique=True))
    cases = draw(st.integers(0, 2)) == 0
    numbers = {
        key: some(rng, *RANGES[key], draw(st.integers(1, 3)))
        for key in varied
        if not (cases and "mass" in key)
    }
    kinds = {
        "both": ("tendon.pretension",),
        "by side": ("tendon.flexor.pretension", "tendon.extensor.pretension"),
        "one side": ("tendon.extensor.pretension",),
    }
    pretensions = kinds["both" if cases else draw(st.sampled_from(sorted(kinds)))]
    numbers |= {key: some(rng, 0.0, 400.0, draw(st.integers(1, 3))) for key in pretensions}
    numbers |= {
        key: values[0]
        for key, values in numbers.items()
        if len(values) == 1 and draw(st.booleans())
    }
    if draw(st.integers(0, 5)) == 0:
        numbers |= {"arm.forearm_mass": 0.0} | ({} if cases else {"load.mass": 0.0})
    slack, reference = (
        draw(st.sampled_from(["unilateral", "bilateral"])),
        draw(st.sampled_from(["published", "initial"])),
    )
    content = {
        "model": model(slack, reference),
        "motion.direction": draw(st.sampled_from(DIRECTIONS)),
    }
    content |= {"cases": cases_of(draw, rng)} if cases else {}
    order = draw(st.permutations(sorted(numbers)))
    block_states = draw(st.sampled_from([2**15, 2**15, 250, 40]))
    content["motion.elbow_angle"] = angles_of(draw, rng)
    return plan_of(numbers | content, order, block_states=block_states)


@pytest.mark.filterwarnings("ignore:Generating overly large repr")
@searched
@given(studies(), st.lists(st.floats(0.0, 1.0), max_size=3))
def test_any_study(plan, cuts):
    assert_same_rows(plan, cuts)
