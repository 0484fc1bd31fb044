"""Rows of a block as compiled code writes them, beside those that NumPy writes."""

from __future__ import annotations

import itertools

import numpy as np

from tendon_cli.study.load import study_from
from tendon_cli.study.values import Values
from tendon_cli.sweep.columns import Tables, state_keys
from tendon_cli.sweep.evaluate import evaluate, state_columns
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Plan
from tendon_cli.sweep.rows import BlockRows
from tendon_cli.tables.write import _DTYPES, copied
from tests.si import with_units

from .processors import each_processor

_MARGIN = 9
"""Rows before and after those asked for, one more than any processor takes at a time."""

COUNTS = (1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 91)
"""Numbers of angles on both sides of what any processor takes at a time."""

DIRECTIONS = ("flexion", "extension", ["flexion", "extension"], ["extension", "flexion"])


def model(slack="unilateral", reference="published"):
    return {"slack": slack, "reference": reference}


def nested(numbers):
    """Dotted keys as TOML has them."""
    content = {}
    for key, value in numbers.items():
        *tables, name = key.split(".")
        table = content
        for each in tables:
            table = table.setdefault(each, {})
        table[name] = value
    return content


def inputs_of(numbers, order=(), unchecked=None, **options):
    """Inputs of a study given by dotted keys; `unchecked` are numbers of the arm that a study would be refused for."""
    study = study_from(with_units({"name": "rows"} | nested(numbers)), order=tuple(order))
    own = {name: Values.of(value) for name, value in (unchecked or {}).items()}
    return Inputs(Plan(study.replaced({"arm": study.arm.model_copy(update=own)}), **options))


def all_states(expected, name):
    """A column of several blocks, one after the other."""
    return np.concatenate([columns[name] for columns in expected])


def assert_same_rows(inputs, cuts=()):
    """Every block comes out the same both ways, also in stretches between cuts, which are shares of the block.

    Returns the columns of each block.
    """
    tables, blocks = Tables(inputs), inputs.plan.blocks(range(inputs.plan.designs), 4)
    return [_same_block(inputs, tables, block, cuts) for block in blocks]


def _same_block(inputs, tables, block, cuts):
    kinds = {column.name: _DTYPES[column.kind] for column in tables.states}
    leading = {column.name: values(block) for column, values in tables.leading.items()}
    keys = leading | state_keys(block, inputs.plan.elbow_angles)
    evaluated = evaluate(inputs, block)
    by_numpy = copied({**keys, "status": evaluated.state.status, **state_columns(evaluated)}, block.shape)
    count = block.design_count * block.shape[-2] * block.shape[-1]
    expected, nulls = _written(by_numpy, kinds, range(count))
    places = sorted({0, count, *(int(share * count) for share in cuts)})
    stretches = [range(count), *(range(*ends) for ends in itertools.pairwise(places))]
    for processor in each_processor():
        rows = BlockRows.of(inputs, block, keys, processor)
        for stretch in stretches:
            found, missing = _written(rows.write, kinds, stretch)
            here = {name: values[stretch.start : stretch.stop] for name, values in expected.items()}
            for name, values in here.items():
                assert same_bits(found[name], values), (processor.kind, stretch, name, found[name], values)
            assert missing == {name for name, values in here.items() if _is_null(values).any()}, processor.kind
            assert missing <= nulls
    return expected


def _written(write, kinds, rows):
    """What a filler writes, and which columns it says have nulls. It touches no row beside those asked for."""
    wide = {name: np.full(len(rows) + 2 * _MARGIN, 77, kind) for name, kind in kinds.items()}
    within = slice(_MARGIN, _MARGIN + len(rows))
    nulls = write({name: values[within] for name, values in wide.items()}, rows)
    for name, values in wide.items():
        assert (values[:_MARGIN] == 77).all(), name
        assert (values[within.stop :] == 77).all(), name
    return {name: values[within] for name, values in wide.items()}, nulls


def same_bits(found, expected):
    """The same numbers, noughts of the same sign, and no number in the same places."""
    if found.dtype.kind != "f":
        return np.array_equal(found, expected)
    null = _is_null(expected)
    bits = found.view(np.uint64)[~null], expected.view(np.uint64)[~null]
    return np.array_equal(_is_null(found), null) and np.array_equal(*bits)


def _is_null(values):
    return np.isnan(values) if values.dtype.kind == "f" else np.zeros(values.shape, bool)
