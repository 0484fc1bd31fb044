"""The compiled look at a tile finds, bit for bit, what NumPy finds."""

import math
from dataclasses import fields, is_dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tendon_cli.study.load import study_from
from tendon_cli.sweep import compiled, lines
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Plan
from tendon_cli.sweep.tile import Tile
from tests.si import with_units

from .processors import each_processor, needs_code
from .studies import BASE, RANGES, design_of

searched = settings(deadline=None, derandomize=True, max_examples=250)

WIDTHS, STRETCHES = (1, 2, 31, 32, 33, 65), (1, 2, 95, 96, 97, 193)
"""On both sides of the number of designs, and of angles, that `look.h` takes at a time."""


def leaves(found, prefix=""):
    """All arrays of what a look found, by name."""
    for field in fields(found):
        value = getattr(found, field.name)
        for place, each in enumerate(value if isinstance(value, tuple) else [value]):
            name = f"{prefix}{field.name}[{place}]"
            if is_dataclass(each):
                yield from leaves(each, f"{name}.")
            else:
                yield name, each


def assert_same(tile):
    """Both ways to look find the same, the compiled one on every kind of processor; returns what that is."""
    expected = lines.look(tile)
    for processor in each_processor():
        found = dict(leaves(compiled.look(tile, processor)))
        for name, values in leaves(expected):
            assert np.array_equal(found.pop(name), values, equal_nan=True), (processor.kind, name)
        assert not found
    return expected


def tile_of(changes, angles=(-0.2, 0.4, 1.0, 1.5), flexion=(True, False)):
    """The tile of the designs of `studies.BASE` with changes."""
    numbers = BASE | {"sheath.friction": 0.07, "load.mass": 3.0, "tendon.pretension": 100.0} | changes
    return Tile.of(design_of(numbers), np.reshape(angles, (-1, 1, 1)), np.reshape(flexion, (1, -1, 1)))


def tiles_of(study, blocks=16, **options):
    """All tiles of a study given as TOML's content."""
    plan = Plan(study_from(with_units({"name": "tiles"} | study)), **options)
    inputs = Inputs(plan)
    for rectangle in plan.rectangles(range(plan.designs)):
        for within in plan.tiles(rectangle, inputs.loops, blocks):
            yield Tile.of(*inputs.tile(rectangle.piece(within)))


# --- By search -------------------------------------------------------------------------------------------------------


def pretension_of(kind, rng, pretensions, designs):
    """Pretensions of both sides: by tile, by design, or differing between the sides, in rows or in columns."""
    shape = {"one": (1, 1, 1), "by design": (1, 1, designs)}.get(kind, (pretensions, 1, 1, designs))
    flexor, extensor = rng.uniform(0.0, 400.0, (2, *shape)) * (rng.random((2, *shape)) > 0.05)
    if kind == "in columns":
        flexor = np.asfortranarray(flexor)
    if kind in ("by side", "in columns"):
        return {"tendon.flexor.pretension": flexor, "tendon.extensor.pretension": extensor}
    return {"tendon.pretension": flexor[..., :1] if kind == "in a loop" else flexor}


@st.composite
def tiles(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    designs, count = draw(st.sampled_from(WIDTHS)), draw(st.sampled_from(STRETCHES))
    varied = draw(st.sets(st.sampled_from(sorted(RANGES)), max_size=6))
    changes = {key: rng.uniform(*RANGES[key], (1, 1, designs)) for key in varied}
    flags = {"all": True, "none": False, "some": rng.random((1, 1, designs)) < 0.5}
    changes["unilateral"] = flags[draw(st.sampled_from(["all", "all", "none", "some"]))]
    changes["from_initial"] = flags[draw(st.sampled_from(["all", "none", "some"]))]
    kinds = ["one", "by design", "in a loop", "by side", "in columns", "together"]
    changes |= pretension_of(draw(st.sampled_from(kinds)), rng, draw(st.integers(2, 5)), designs)
    if draw(st.integers(0, 5)) == 0:
        changes |= {"arm.forearm_mass": 0.0, "load.mass": 0.0}
    low = draw(st.sampled_from([-40.0, 0.0, 60.0, 165.0]))
    angles = np.radians(rng.uniform(low, draw(st.sampled_from([low + 5.0, 170.0])), count))
    orders = {"ascending": np.sort(angles), "any": angles, "repeated": angles[rng.integers(0, count, count)]}
    angles = orders[draw(st.sampled_from(sorted(orders)))]
    return tile_of(changes, angles, draw(st.sampled_from([(True,), (False,), (True, False), (False, True)])))


@needs_code
@pytest.mark.filterwarnings("ignore:Generating overly large repr")
@searched
@given(tiles())
def test_any_tile(tile):
    assert_same(tile)


# --- By hand ---------------------------------------------------------------------------------------------------------


@needs_code
@pytest.mark.parametrize("designs", WIDTHS)
@pytest.mark.parametrize("count", STRETCHES)
def test_designs_and_angles_on_both_sides_of_what_is_taken_at_a_time(designs, count):
    pretension = np.linspace(0.0, 300.0, 3 * designs).reshape(3, 1, 1, designs)
    mass = np.linspace(0.0, 9.0, designs).reshape(1, 1, -1)
    seen = assert_same(
        tile_of({"tendon.pretension": pretension, "load.mass": mass}, np.radians(np.linspace(-40, 170, count)))
    )
    assert seen.slack.shape == (3, 2, designs)


@needs_code
def test_taut_states():
    seen = assert_same(tile_of({"tendon.pretension": 5000.0}))
    assert not seen.slack.any()
    assert np.isnan(seen.first_slack_angle).all()


@needs_code
@pytest.mark.parametrize(("inclination", "side"), [(0.6, "extensor"), (-2.0, "flexor")])
def test_either_side_slack(inclination, side):
    """A forearm in front of the plumb line pulls at the flexor, and the extensor goes slack first."""
    seen = assert_same(tile_of({"tendon.pretension": 1.0, "arm.upper_arm_angle": inclination}))
    loose, other = seen.sides if side == "flexor" else seen.sides[::-1]
    assert np.isinf(other.limit).all()
    assert (loose.limit > 1.0).all()
    assert seen.slack.all()


@needs_code
def test_both_sides_slack_without_any_load():
    weightless = {"arm.forearm_mass": 0.0, "load.mass": 0.0}
    seen = assert_same(tile_of(weightless | {"tendon.pretension": np.array([0.0, 50.0, 500.0]).reshape(3, 1, 1, 1)}))
    assert not seen.one_sided.any()
    assert seen.slack[0].all()
    assert np.isfinite(seen.both_limit).all()


@needs_code
def test_no_load_where_no_pretension_is_needed_either():
    """Nought is not more than a share of nought: neither side goes slack before the other."""
    weightless = {"arm.forearm_mass": 0.0, "load.mass": 0.0, "from_initial": True}
    seen = assert_same(tile_of(weightless, [0.0]))
    assert (seen.shortfall == 0.0).all()
    assert (seen.both_limit == 0.0).all()
    assert not seen.one_sided.any()


@needs_code
@pytest.mark.parametrize(("degrees", "every"), [((160.0, 165.0, 170.0), True), ((-40.0, 60.0, 170.0), False)])
def test_no_equilibrium(degrees, every):
    """Beside designs that have one, some of them slack, so that no design learns from its neighbour."""
    geometry = {"arm.a2": np.array([0.02, 0.001, 0.05]).reshape(1, 1, 3)}
    seen = assert_same(tile_of(geometry | {"tendon.pretension": 2.0}, np.radians(degrees)))
    gone = seen.no_equilibrium == len(degrees)
    assert gone.any() == every
    assert not gone.all()
    assert seen.slack.any()
    for values in (seen.stiffness[0], seen.flexor.lowest[0], seen.motor.highest[0], seen.elbow_torque.lowest):
        assert np.array_equal(np.isnan(values), gone)


@needs_code
@pytest.mark.parametrize("bilateral", [1, 16, 31, 32])
def test_both_models_side_by_side(bilateral):
    """The bilateral designs find what they find in a tile of their own."""
    unilateral = (np.arange(32) >= bilateral).reshape(1, 1, -1)
    rest = {"tendon.pretension": 20.0, "load.mass": np.linspace(0, 9, 32).reshape(1, 1, -1)}
    mixed = assert_same(tile_of(rest | {"unilateral": unilateral}))
    alone = assert_same(tile_of(rest | {"unilateral": False}))
    for (name, one), (_, other) in zip(leaves(mixed), leaves(alone), strict=True):
        assert np.array_equal(one[..., :bilateral], other[..., :bilateral], equal_nan=True), name


@needs_code
@pytest.mark.parametrize("key", ["sheath.friction", "sheath.bend_angle", "load.mass", "arm.a1", "tendon.pretension"])
def test_nought_of_what_may_be_nought(key):
    assert_same(tile_of({key: 0.0}))
    assert_same(tile_of({key: np.array([0.0, 0.05]).reshape(1, 1, 2)}))


@needs_code
def test_coincident_anchors():
    """Both anchors in one place at 90 degrees, where the flexor has no direction."""
    level = {"arm.a1": 0.15, "arm.b1": 0.0, "arm.a2": 0.0, "arm.b2": 0.15}
    seen = assert_same(tile_of(level, [0.3, 0.5 * math.pi, 1.9]))
    assert (seen.no_equilibrium > 0).all()


@needs_code
def test_angles_that_come_twice_and_in_any_order():
    once = assert_same(tile_of({"tendon.pretension": 30.0}, [-0.5, 0.2, 0.9]))
    twice = assert_same(tile_of({"tendon.pretension": 30.0}, [0.9, -0.5, 0.2, 0.2, -0.5, 0.9]))
    assert np.array_equal(twice.first_slack_angle, once.first_slack_angle)
    assert np.array_equal(twice.slack, 2 * once.slack)
    assert once.slack.all()


@needs_code
@pytest.mark.parametrize(
    "own", [{"flexor": {"pretension": 9}}, {"flexor": {"pretension": 9}, "extensor": {"length": 1}}]
)
@pytest.mark.parametrize("direction", ["flexion", ["extension", "flexion"]])
def test_pretension_linked_with_other_axes_through_cases(own, direction):
    """Pretensions by case and axis, which come in columns."""
    study = {
        "cases": [{"name": "one"}, {"name": "heavy", "load": {"mass": 3.0}}, {"name": "own", "tendon": own}],
        "tendon": {"pretension": [10.0, 20.0, 30.0]},
        "motion": {"elbow_angle": np.linspace(-0.7, 2.9, 97).tolist(), "direction": direction},
    }
    seen = [assert_same(tile) for tile in tiles_of(study, blocks=1, block_states=600)]
    assert any(len(each.slack) > 1 and each.slack.shape[-1] > 1 for each in seen)


@needs_code
@pytest.mark.parametrize("key", ["a1", "b1", "a2", "b2", "elbow_radius", "upper_arm_angle", "forearm_com"])
def test_one_axis_of_the_arm(key):
    for tile in tiles_of({"arm": {key: [0.03, 0.05, 0.1]}, "motion": {"elbow_angle": [0.1, 1.0, 2.9]}}):
        assert tile.shape == (3, 2, 3)
        assert_same(tile)
