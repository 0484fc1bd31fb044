"""The compiled code writes, bit for bit, the rows of any study that NumPy writes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sweep.studies import RANGES

from .filling import COUNTS, DIRECTIONS, assert_same_rows, model, needs_code, plan_of

pytestmark = needs_code
searched = settings(deadline=None, derandomize=True, max_examples=60)

SLACKS = ["unilateral", "bilateral"]
REFERENCES = ["published", "initial"]
PRETENSIONS = {
    "both": ("tendon.pretension",),
    "by side": ("tendon.flexor.pretension", "tendon.extensor.pretension"),
    "one side": ("tendon.extensor.pretension",),
}


def levels(rng, low, high, count):
    """Return values of an axis, a few of them zero where they may be."""
    keep = (rng.random(count) > 0.15) | (low > 0.0)
    return list(dict.fromkeys((rng.uniform(low, high, count) * keep).tolist()))


def cases_of(draw, rng):
    """Return cases that each have a model, and may have a pretension, of their own."""
    cases = []
    for number in range(draw(st.integers(2, 4))):
        case = {"name": str(number), "load": {"mass": float(rng.uniform(0.0, 9.0))}}
        slack = str(rng.choice(SLACKS))
        reference = str(rng.choice(REFERENCES))
        case["model"] = model(slack, reference)
        if draw(st.booleans()):
            case["tendon"] = {"flexor": {"pretension": float(rng.uniform(0.0, 300.0))}}
        cases.append(case)
    return cases


def angles_of(draw, rng):
    low = draw(st.sampled_from([-0.7, 0.0, 1.0, 2.8]))
    high = draw(st.sampled_from([low + 0.1, 3.0]))
    count = draw(st.sampled_from(COUNTS))
    return rng.uniform(low, high, count).tolist()


@st.composite
def studies(draw):
    """Draw the plan of any study."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    varied = draw(st.lists(st.sampled_from(sorted(RANGES)), max_size=4, unique=True))
    has_cases = draw(st.integers(0, 2)) == 0
    if has_cases:
        varied = [key for key in varied if "mass" not in key]
    numbers = {key: levels(rng, *RANGES[key], draw(st.integers(1, 3))) for key in varied}
    kind = "both" if has_cases else draw(st.sampled_from(sorted(PRETENSIONS)))
    for key in PRETENSIONS[kind]:
        numbers[key] = levels(rng, 0.0, 400.0, draw(st.integers(1, 3)))
    for key, values in numbers.items():
        if len(values) == 1 and draw(st.booleans()):
            numbers[key] = values[0]
    is_weightless = draw(st.integers(0, 5)) == 0
    if is_weightless:
        numbers["arm.forearm_mass"] = 0.0
    if is_weightless and not has_cases:
        numbers["load.mass"] = 0.0
    slack = draw(st.sampled_from(SLACKS))
    reference = draw(st.sampled_from(REFERENCES))
    direction = draw(st.sampled_from(DIRECTIONS))
    content = {"model": model(slack, reference), "motion.direction": direction}
    if has_cases:
        content["cases"] = cases_of(draw, rng)
    order = draw(st.permutations(sorted(numbers)))
    block_states = draw(st.sampled_from([2**15, 2**15, 250, 40]))
    content["motion.elbow_angle"] = angles_of(draw, rng)
    return plan_of(numbers | content, order, block_states=block_states)


@pytest.mark.filterwarnings("ignore:Generating overly large repr")
@searched
@given(studies(), st.lists(st.floats(0.0, 1.0), max_size=3))
def test_any_study(plan, cuts):
    assert_same_rows(plan, cuts)
