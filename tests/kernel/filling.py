"""Rows of a block as compiled code writes them, beside those that NumPy writes."""

from __future__ import annotations

import contextlib
import itertools

import numpy as np
import pytest

from tendon_cli import kernel
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.sweep import Sweep
from tendon_cli.engine.table_columns import PlanColumns
from tendon_cli.studies.load import study_from
from tendon_cli.studies.values import StudyNumber
from tests.si import with_units

needs_code = pytest.mark.skipif(
    kernel.native() is None, reason="tendon was installed without a C compiler"
)

COUNTS = (1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 91)
"""Numbers of angles on both sides of what any processor takes at a time."""

DIRECTIONS = ("flexion", "extension", ["flexion", "extension"], ["extension", "flexion"])

_MARGIN = 9
"""Rows before and after those asked for, one more than any processor takes at a time."""

_UNTOUCHED = 77
"""Value of rows that nobody has written."""


def model(slack="unilateral", reference="published"):
    return {"slack": slack, "reference": reference}


def nested(numbers):
    """Return dotted keys as nested tables, like TOML has them."""
    content = {}
    for key, value in numbers.items():
        *tables, name = key.split(".")
        table = content
        for table_name in tables:
            table = table.setdefault(table_name, {})
        table[name] = value
    return content


def plan_of(numbers, order=(), unchecked=None, **options):
    """Return the plan of a study by dotted keys.

    `unchecked` are numbers of the arm that a study would be refused for.
    """
    content = {"name": "rows", "allow_implausible": True} | nested(numbers)
    study = study_from(with_units(content), order=tuple(order))
    arm_numbers = {name: StudyNumber.of(value) for name, value in (unchecked or {}).items()}
    arm = study.arm.model_copy(update=arm_numbers)
    return Plan(study.replaced({"arm": arm}), **options)


def all_states(blocks, name):
    """Return a column of several blocks, concatenated."""
    return np.concatenate([columns[name] for columns in blocks])


def assert_same_rows(plan, cuts=()):
    """Check that all code writes the same rows, also in stretches between cuts of a block.

    Cuts are shares of the block. Returns the columns of each block.
    """
    blocks = plan.blocks(range(plan.designs), 4 * plan.block_states)
    return [_same_block(plan, block, cuts) for block in blocks]


@contextlib.contextmanager
def kinds_of_code():
    """Yield all kinds of code that this processor can run, and a function that chooses a kind.

    The last kind is None for NumPy.
    """
    code = kernel.native()
    compiled = () if code is None else code.kinds
    with pytest.MonkeyPatch.context() as patch:

        def choose(kind):
            patch.setattr(kernel, "native", lambda: None if kind is None else code)
            if kind is not None:
                patch.setattr(code, "kind", kind)

        yield (*compiled, None), choose


def _same_block(plan, block, cuts):
    """Check that all code writes the same rows of a block, and return its columns."""
    types = {column.name: column.dtype for column in PlanColumns(plan).states}
    keys = Sweep(plan).keys("states", block)
    state = plan.state(block)
    count = block.design_count * block.shape[-2] * block.shape[-1]
    places = sorted({0, count, *(int(share * count) for share in cuts)})
    between_cuts = [range(first, stop) for first, stop in itertools.pairwise(places)]
    with kinds_of_code() as (kinds, choose):
        choose(None)
        expected = _written(kernel.row_writer(state, block.shape, keys), types, range(count))
        for kind in kinds:
            choose(kind)
            write = kernel.row_writer(state, block.shape, keys)
            for rows in (range(count), *between_cuts):
                written = _written(write, types, rows)
                for name, values in expected.items():
                    result = written[name]
                    stretch = values[rows.start : rows.stop]
                    assert same_bits(result, stretch), (kind, rows, name, result, stretch)
    return expected


def _written(write, types, rows):
    """Return the rows of a writer; check that it touches no other ones and tells its nulls."""
    length = len(rows) + 2 * _MARGIN
    within = slice(_MARGIN, _MARGIN + len(rows))
    wide = {name: np.full(length, _UNTOUCHED, dtype) for name, dtype in types.items()}
    columns = {name: values[within] for name, values in wide.items()}
    names_with_nan = write(columns, rows)
    if names_with_nan is not None:
        assert set(names_with_nan) == {
            name for name, values in columns.items() if _is_null(values).any()
        }
    for name, values in wide.items():
        assert (values[: within.start] == _UNTOUCHED).all(), name
        assert (values[within.stop :] == _UNTOUCHED).all(), name
    return columns


def same_bits(values, expected):
    """Return True for the same numbers, zeros of the same sign, and NaN in the same places."""
    if values.dtype.kind != "f":
        return np.array_equal(values, expected)
    null = _is_null(expected)
    bits = values.view(np.uint64)[~null]
    expected_bits = expected.view(np.uint64)[~null]
    return np.array_equal(_is_null(values), null) and np.array_equal(bits, expected_bits)


def _is_null(values):
    return np.isnan(values) if values.dtype.kind == "f" else np.zeros(values.shape, bool)
