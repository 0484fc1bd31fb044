"""Rows of a block as compiled code writes them, beside those that NumPy writes."""

from __future__ import annotations

import contextlib
import itertools

import numpy as np
import pytest

from tendon_cli import kernel
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.sweep import Sweep
from tendon_cli.engine.table_columns import Tables
from tendon_cli.studies.load import study_from
from tendon_cli.studies.values import Values
from tests.si import with_units

needs_code = pytest.mark.skipif(
    kernel.native() is None, reason="tendon was installed without a C compiler"
)
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


def plan_of(numbers, order=(), unchecked=None, **options):
    """The plan of a study by dotted keys; `unchecked` are numbers of the arm that a study would be refused for."""
    study = study_from(with_units({"name": "rows"} | nested(numbers)), order=tuple(order))
    own = {name: Values.of(value) for name, value in (unchecked or {}).items()}
    return Plan(study.replaced({"arm": study.arm.model_copy(update=own)}), **options)


def all_states(expected, name):
    """A column of several blocks, one after the other."""
    return np.concatenate([columns[name] for columns in expected])


def assert_same_rows(plan, cuts=()):
    """Every block comes out the same both ways, also in stretches between cuts, which are shares of the block.

    Returns the columns of each block.
    """
    blocks = plan.blocks(range(plan.designs), 4 * plan.block_states)
    return [_same_block(plan, block, cuts) for block in blocks]


@contextlib.contextmanager
def each_kind():
    """Every kind of code that this processor can run, in turn, and None for NumPy: a function that takes one."""
    kinds = native.kinds if (native := kernel.native()) else ()
    with pytest.MonkeyPatch.context() as patch:
        yield (*kinds, None), lambda kind: patch.setattr(kernel, "kind", lambda: kind)


def _same_block(plan, block, cuts):
    columns = {column.name: column.dtype for column in Tables(plan).states}
    keys, at = Sweep(plan).keys("states", block), plan.state(block)
    count = block.design_count * block.shape[-2] * block.shape[-1]
    places = sorted({0, count, *(int(share * count) for share in cuts)})
    stretches = [range(count), *(range(*ends) for ends in itertools.pairwise(places))]
    with each_kind() as (kinds, take):
        take(None)
        expected = _written(kernel.row_writer(at, block.shape, keys), columns, range(count))
        for kind in kinds:
            take(kind)
            write = kernel.row_writer(at, block.shape, keys)
            for stretch in stretches:
                found = _written(write, columns, stretch)
                for name, values in expected.items():
                    here = values[stretch.start : stretch.stop]
                    assert same_bits(found[name], here), (kind, stretch, name, found[name], here)
    return expected


def _written(write, kinds, rows):
    """What a writer writes. It touches no row beside those asked for."""
    wide = {name: np.full(len(rows) + 2 * _MARGIN, 77, kind) for name, kind in kinds.items()}
    within = slice(_MARGIN, _MARGIN + len(rows))
    with_nan = write({name: values[within] for name, values in wide.items()}, rows)
    if with_nan is not None:
        assert set(with_nan) == {
            name
            for name, values in wide.items()
            if values.dtype.kind == "f" and np.isnan(values[within]).any()
        }
    for name, values in wide.items():
        assert (values[:_MARGIN] == 77).all(), name
        assert (values[within.stop :] == 77).all(), name
    return {name: values[within] for name, values in wide.items()}


def same_bits(found, expected):
    """The same numbers, noughts of the same sign, and no number in the same places."""
    if found.dtype.kind != "f":
        return np.array_equal(found, expected)
    null = _is_null(expected)
    bits = found.view(np.uint64)[~null], expected.view(np.uint64)[~null]
    return np.array_equal(_is_null(found), null) and np.array_equal(*bits)


def _is_null(values):
    return np.isnan(values) if values.dtype.kind == "f" else np.zeros(values.shape, bool)
