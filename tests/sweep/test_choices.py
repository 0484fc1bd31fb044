"""Choices are counted over all conditions at once, however a run is cut into parts."""

import itertools

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.engine import plan as plan_module
from tendon_cli.engine.folds import (
    count_choices,
    count_feasible_choices,
    decode_feasible,
    encode_feasible,
)
from tendon_cli.engine.plan import Plan
from tendon_cli.studies.load import study_from

AXES = {
    "load.mass": ["0 kg", "2 kg", "5 kg"],
    "tendon.pretension": ["100 N", "130 N", "160 N"],
    "spool.ratio": [0.5, 0.6, 0.7, 1.0],
    "arm.forearm_mass": ["1 kg", "2 kg"],
}
ORDERS = list(itertools.permutations(AXES))


def text_of(order, cases):
    """Return a study with the axes in this order."""
    lines = [f"{key} = {AXES[key]}".replace("'", '"') for key in order]
    lines.append('motion.elbow_angle = { from = "0 deg", to = "90 deg", num = 4 }')
    lines.append('spring.stiffness = "5 kN/m"')
    for name, b1 in cases:
        lines += ["[[cases]]", f'name = "{name}"', f'arm.b1 = "{b1} mm"']
    return "\n".join(lines)


@pytest.mark.parametrize("cases", [[], [("short", 140)]], ids=["", "cases"])
@pytest.mark.parametrize("states", [40, 10**6])
def test_the_record_counts_what_pandas_counts(new_sweep, tmp_path, small_parts, states, cases):
    small_parts(states, 5)
    counts = set()
    for order in ORDERS[::17]:
        swept = new_sweep(text_of(order, cases), tmp_path, out="-".join(order))
        record = swept.record
        is_feasible = swept.designs.groupby(["pretension", "spool_ratio"])["feasible"].all()
        assert record["choices"] == len(is_feasible) == 12
        assert record["feasible_choices"] == is_feasible.sum()
        assert 0 < record["feasible_choices"] < 12
        counts.add((record["feasible_choices"], record["feasible"]))
    assert len(counts) == 1


@pytest.mark.parametrize("seed", range(20))
def test_any_judgement_of_designs_cut_anywhere(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    order = ORDERS[rng.integers(len(ORDERS))]
    content = {"name": "choices", "motion": {"elbow_angle": ["10 deg"]}}
    for key in order:
        table, name = key.split(".")
        count = rng.integers(1, 5)
        content.setdefault(table, {})[name] = [1.0 + index for index in range(count)]
    plan = Plan(study_from(content, order=order))
    monkeypatch.setattr(plan_module, "DESIGNS_AT_ONCE", int(rng.integers(1, 9)))
    monkeypatch.setattr(plan_module, "STATES_PER_FILE", 1)
    monkeypatch.setattr(plan_module, "STATES_PER_PART", int(rng.integers(2, 40)))
    feasible = rng.random(plan.shape) < 0.8
    notes = []
    for index in range(plan.parts):
        part = plan.part(index)
        notes.append(encode_feasible(feasible.ravel()[part.start : part.stop]))
        assert decode_feasible(notes[-1], len(part)) is not None
    axes = enumerate(plan.study.axes)
    conditions = tuple(axis for axis, key in axes if key in plan.study.conditions)
    by_hand = feasible.all(axis=conditions)
    assert count_choices(plan) == by_hand.size
    assert count_feasible_choices(plan, notes) == by_hand.sum()


@pytest.mark.parametrize("note", ["", "AAAA", "!", "eJwDAAAAAAE=", "eJw" + "A" * 4000])
def test_what_is_no_note_is_not_taken_for_one(note):
    assert decode_feasible(note, 4) is None
    assert decode_feasible(encode_feasible(np.ones(4, np.bool_)), 4).all()


def test_the_summary_names_the_conditions_that_the_study_has():
    study = {
        "load": {"mass": ["0 kg", "5 kg"]},
        "cases": [{"name": "a"}, {"name": "b", "arm": {"b1": "160 mm"}}],
    }
    assert "choice feasible for every case and load at once\n" in tendon.sweep(study).text
    study = {"arm": {"upper_arm_angle": ["0 deg", "9 deg"]}}
    assert "choice feasible at every upper arm angle\n" in tendon.sweep(study).text
