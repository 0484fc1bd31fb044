"""A choice of an answer by its row, as the record has those that it names."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

from tendon_cli.answer_record import (
    AnswerRecord,
    AxisRecord,
    ChoiceRecord,
    Value,
    VerifiedRecord,
    value_of,
)
from tendon_cli.answers.answer import Answer
from tendon_cli.answers.tables import VERIFIED
from tendon_cli.errors import UsageError
from tendon_cli.studies.values import RIGID
from tendon_cli.tables.schema import finite_or_none

if TYPE_CHECKING:
    import pyarrow as pa


def choice_in_row(answer: Answer, row: int) -> ChoiceRecord:
    """Return the choice in a row of `choices.parquet`.

    Raises:
        UsageError: The answer has no such row.
        InputError: A table is damaged.
    """
    table = answer.table("choices")
    if not 0 <= row < table.num_rows:
        last = table.num_rows - 1
        raise UsageError(
            f"{answer.record['name']} has no choice {row}, expected 0 to {last}",
            where="--choice",
            hint="`tendon show` lists the choices of an answer",
        )
    record = cast("AnswerRecord", answer.record)
    axes = record["question"]["choices"]
    found = _row_of(table, row, axes)
    conditions = answer.table("conditions")
    for end in ("from", "to"):
        of_condition = record["question"]["conditions"]
        values = _row_of(conditions, found[f"{end}_condition"], of_condition)
        found[f"{end}_under"] = {axis["column"]: values[axis["column"]] for axis in of_condition}
    found["choice"] = row
    found["served_verified"] = _verified(found, record)
    return cast(ChoiceRecord, found)


def same_choice(answer: Answer, choice: ChoiceRecord, axes: list[AxisRecord]) -> ChoiceRecord:
    """Return the choice of an answer with the values of another answer's choice.

    Args:
        answer: The answer.
        choice: The choice of the other one.
        axes: Axes of the choices of the other one.

    Raises:
        UsageError: The answer has no such choice.
    """
    record = cast("AnswerRecord", answer.record)
    ours = {axis["column"]: axis for axis in record["question"]["choices"]}
    common = [axis["column"] for axis in axes if axis["column"] in ours]
    wanted = {column: value_of(choice, column) for column in common}
    table = answer.table("choices")
    columns = {column: table.column(column).to_pylist() for column in common}
    for row in range(table.num_rows):
        values = {column: _recorded(columns[column][row], ours[column]) for column in common}
        if all(_is_same(values[column], wanted[column]) for column in common):
            return choice_in_row(answer, row)
    named = ", ".join(f"{column} {value}" for column, value in wanted.items())
    raise UsageError(
        f"{record['name']} has no choice with {named}",
        where="--choice",
        hint="`tendon show` lists the choices of an answer",
    )


def _row_of(table: pa.Table, row: int, axes: list[AxisRecord]) -> dict[str, Any]:
    """Return a row of a table as the record has it: null for no number, "rigid", no empty text."""
    (values,) = table.slice(row, 1).to_pylist()
    of_axes = {axis["column"]: axis for axis in axes}
    found: dict[str, Any] = {}
    for name, value in values.items():
        if name in of_axes:
            found[name] = _recorded(value, of_axes[name])
        elif isinstance(value, float):
            found[name] = finite_or_none(value)
        else:
            found[name] = value or None if isinstance(value, str) else value
    return found


def _recorded(value: Any, axis: AxisRecord) -> Value:
    """Return the value on an axis as the record has it."""
    if not axis["named"] and isinstance(value, float) and math.isinf(value):
        return RIGID
    return cast(Value, value)


def _is_same(value: Value, other: Value) -> bool:
    """Return True if two values on an axis are the same, but for rounding."""
    if isinstance(value, str) or isinstance(other, str):
        return value == other
    return math.isclose(value, other, rel_tol=1e-12)


def _verified(row: Mapping[str, Any], record: AnswerRecord) -> VerifiedRecord | None:
    """Return the judgement of the fresh sample in a row; None without one."""
    value, low, high, start, end = (row[name] for name in VERIFIED)
    fresh = record["verified_by"]
    if value is None or fresh is None:
        return None
    return {
        "value": value,
        "interval_95": [low, high],
        "of": fresh["count"],
        "from": start,
        "to": end,
    }
