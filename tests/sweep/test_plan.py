"""Parts and blocks of a product hold every state exactly once, in order, whatever its shape."""

import itertools
import math
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tendon_cli.engine import plan as plan_module
from tendon_cli.engine.plan import Plan
from tendon_cli.errors import SizeError
from tendon_cli.studies.load import load_study, study_from
from tests.si import with_units

AXES = (("tendon", "pretension"), ("spring", "stiffness"), ("spool", "ratio"), ("load", "mass"))
SHAPES = st.lists(st.integers(1, 6), min_size=0, max_size=4)
searched = settings(deadline=None, derandomize=True, max_examples=80)

HUGE = """
[tendon]
pretension = { from = "1 N", to = "2 N", num = 10000000 }
[spring]
stiffness = { from = "1 kN/m", to = "2 kN/m", num = 10000000 }
[spool]
ratio = { from = 0.5, to = 1.0, num = 1000000 }
"""


def study_of(shape, angles=3, directions=("flexion", "extension"), **rest):
    """Return a study whose axes have these lengths."""
    content = {"name": "shape", "allow_implausible": True, **rest}
    for (table, key), length in zip(AXES, shape, strict=False):
        content.setdefault(table, {})[key] = [1.0 + index for index in range(length)]
    content["motion"] = {
        "direction": list(directions),
        "elbow_angle": [0.1 * (1 + index) for index in range(angles)],
    }
    return study_from(with_units(content))


def rows_of(plan, block):
    """Return the rows of a block's states in the states table, in the block's own order."""
    slices = (*block.designs, block.directions, block.angles)
    positions = itertools.product(*(range(part.start, part.stop) for part in slices))
    shape = (*plan.shape, len(plan.directions), len(plan.elbow_angles))
    return [int(np.ravel_multi_index(position, shape)) for position in positions]


@searched
@given(SHAPES, st.integers(1, 7), st.integers(1, 60), st.data())
def test_blocks_tile_any_range_of_designs_once_and_in_order(shape, angles, most, data):
    """No block has more states than asked for, and each knows its designs."""
    plan = Plan(study_of(shape, angles))
    start = data.draw(st.integers(0, plan.designs - 1))
    designs = range(start, data.draw(st.integers(start + 1, plan.designs)))
    per_design = plan.states_per_design
    numbers = np.arange(plan.designs).reshape(plan.shape)
    for states in (None, most):
        blocks = list(plan.blocks(designs, states))
        rows = [row for block in blocks for row in rows_of(plan, block)]
        assert rows == list(range(designs.start * per_design, designs.stop * per_design))
        for block in blocks:
            assert states is None or math.prod(block.shape) <= states
            first = block.first_design
            expected = range(first, first + block.design_count)
            assert len(expected) > 0
            assert numbers[block.designs].ravel().tolist() == list(expected)
            assert plan.coordinates(first) == tuple(part.start for part in block.designs)


@searched
@given(SHAPES, st.data())
def test_the_halves_of_a_block_have_its_designs_once(shape, data):
    plan = Plan(study_of(shape))
    (whole,) = plan.blocks(range(plan.designs))
    axis = data.draw(st.integers(0, len(shape) - 1)) if shape else None
    if axis is None or whole.shape[axis] < 2:
        return

    def axis_to_cut(block):
        is_whole = block.shape[axis] == whole.shape[axis]
        return axis if is_whole else None

    numbers = np.arange(plan.designs).reshape(plan.shape)
    halves = list(whole.cut(axis_to_cut))
    designs = [numbers[half.designs].ravel() for half in halves]
    assert sorted(np.concatenate(designs).tolist()) == list(range(plan.designs))
    assert [half.design_count for half in halves] == list(map(len, designs))


def test_up_to_two_million_states_a_table_is_one_file():
    """A longer study keeps its short parts."""
    for designs, parts in ((11522, 1), (11524, 5)):
        grid = {"from": "20 N", "to": "240 N", "num": designs}
        plan = Plan(study_from({"name": "long", "tendon": {"pretension": grid}}))
        assert plan.states == designs * 182
        assert plan.parts == parts


@searched
@given(SHAPES, st.integers(1, 300), st.integers(1, 40))
def test_parts_tile_the_designs_and_follow_from_the_study_alone(shape, part_states, block_states):
    study = study_of(shape)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plan_module, "STATES_PER_PART", part_states)
        patch.setattr(plan_module, "STATES_PER_FILE", part_states)
        plan = Plan(study)
        parts = [plan.part(index) for index in range(plan.parts)]
        assert [design for part in parts for design in part] == list(range(plan.designs))
        assert {len(part) for part in parts[:-1]} <= {plan.part_designs}
        in_blocks = Plan(study, block_states=block_states)
        assert parts == [in_blocks.part(index) for index in range(in_blocks.parts)]
        assert sum(plan.rows("states", part) for part in parts) == plan.states
        if plan.states <= part_states:
            assert plan.part_designs == plan.designs
            return
        most = max(1, part_states // plan.states_per_design)
        assert most / 2 < plan.part_designs <= most
        of_whole_axes = [math.prod(shape[axis:]) for axis in range(len(shape) + 1)]
        largest = max(count for count in of_whole_axes if count <= most)
        assert plan.part_designs % largest == 0


def test_parts_are_longer_where_no_states_are_written(monkeypatch):
    with_states = study_of([6, 6])
    without = study_of([6, 6], output={"tables": ["designs"]})
    monkeypatch.setattr(plan_module, "STATES_PER_FILE", 1)
    monkeypatch.setattr(plan_module, "STATES_PER_PART", 60)
    assert Plan(without).part_designs > Plan(with_states).part_designs


def test_axes_vary_as_the_product_of_the_document_the_last_fastest(new_sweep, tmp_path):
    text = """
    [load]
    mass = [0.0, 2.0]
    [spool]
    ratio = [1.0, 0.8, 0.9]
    [tendon]
    pretension = [90.0, 120.0]
    [[cases]]
    name = "b"
    [[cases]]
    name = "a"
    [motion]
    direction = ["extension", "flexion"]
    elbow_angle = ["1 rad", "0.2 rad"]
    """
    swept = new_sweep(text, tmp_path)
    product = list(itertools.product("ba", [0.0, 2.0], [1.0, 0.8, 0.9], [90.0, 120.0]))
    columns = ["case", "load_mass", "spool_ratio", "pretension"]
    assert list(swept.designs[columns].itertuples(index=False, name=None)) == product
    assert swept.designs["design"].tolist() == list(range(len(product)))
    motion = list(itertools.product(["extension", "flexion"], [1.0, 0.2]))
    states = [(*row, *state) for row in product for state in motion]
    columns += ["direction", "elbow_angle"]
    assert list(swept.states[columns].itertuples(index=False, name=None)) == states


def test_a_product_of_10_to_the_20_is_read_and_refused_before_anything_is_allocated(tmp_path):
    file = tmp_path / "huge.toml"
    file.write_text(HUGE, encoding="utf-8")
    load_study(file)  # imports are not counted
    tracemalloc.start()
    try:
        study = load_study(file)
        of_reading = tracemalloc.get_traced_memory()[1]
        tracemalloc.reset_peak()
        before = tracemalloc.get_traced_memory()[0]
        with pytest.raises(SizeError, match="states"):
            Plan(study)
        of_plan = tracemalloc.get_traced_memory()[1] - before
    finally:
        tracemalloc.stop()
    assert of_reading < 5_000_000
    assert of_plan < 1_000_000


def test_more_than_2_to_the_63_states_are_refused_and_just_below_are_not():
    def study_with(angles):
        axis = {"from": 1.0, "to": 2.0, "num": 10**7}
        content = {
            "name": "a",
            "allow_implausible": True,
            "tendon": {"pretension": axis},
            "spring": {"stiffness": axis},
            "motion": {"elbow_angle": {"from": 0.0, "to": 1.0, "num": angles}},
        }
        return study_from(with_units(content))

    assert Plan(study_with(angles=46_000)).states < 2**63
    with pytest.raises(SizeError):
        Plan(study_with(angles=46_200))
