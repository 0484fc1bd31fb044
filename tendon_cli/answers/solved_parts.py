"""Solved choices as the columns of a part, from which the whole answer is chosen and explained.

An interrupted answer goes on from the parts that are whole, and from nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import pyarrow as pa

from tendon_cli.engine.windows.by_choice import ColumnArrays
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.solutions import ENDS, Binding, Solutions
from tendon_cli.engine.windows.worst import OF_STATES, Worst
from tendon_cli.tables.schema import Column, Kind, stored_values

_NESTED = ("points", "from_binding", "to_binding", "worst")
_OWN = tuple(field.name for field in fields(Solutions) if field.name not in _NESTED)
_OF_BINDING = tuple(field.name for field in fields(Binding))
_KINDS: dict[str, Kind] = {
    "feasible": "truth",
    **dict.fromkeys(("windows", "between_samples", "advice"), "count"),
    **dict.fromkeys(("by", "condition", "state"), "count"),
}
"""Kinds of columns that are not numbers, by the last part of their name."""


def solved_columns(motion: Sequence[str]) -> tuple[Column, ...]:
    """Return the columns of solved choices.

    Args:
        motion: Names of the columns of motion among their worst values.
    """
    names = [*_OWN]
    names += [f"{end}_binding.{name}" for end in ENDS for name in _OF_BINDING]
    names += [f"worst.{name}" for name in (*OF_STATES, *motion)]
    return tuple(
        Column(name, _KINDS.get(name.rpartition(".")[2], "number"), "1", "as it was solved")
        for name in names
    )


def solved_rows(solutions: Solutions) -> ColumnArrays:
    """Return solved choices as the columns of `solved_columns`."""
    rows = {name: getattr(solutions, name) for name in _OWN}
    for end in ENDS:
        of_end = vars(solutions.binding(end))
        rows |= {f"{end}_binding.{name}": values for name, values in of_end.items()}
    worst = {name: getattr(solutions.worst, name) for name in OF_STATES}
    return rows | {f"worst.{name}": of for name, of in (worst | {**solutions.worst.motion}).items()}


def solutions_from(table: pa.Table, points: Points, motion: Sequence[str]) -> Solutions:
    """Return solved choices from the rows of a part.

    Args:
        table: The rows.
        points: The choices.
        motion: Names of the columns of motion among their worst values.
    """
    values = {
        column.name: stored_values(column, table.column(column.name))
        for column in solved_columns(motion)
    }
    fields_of: dict[str, Any] = {name: values[name] for name in _OWN}
    for end in ENDS:
        columns = (values[f"{end}_binding.{name}"] for name in _OF_BINDING)
        fields_of[f"{end}_binding"] = Binding(*columns)
    of_states = {name: values[f"worst.{name}"] for name in OF_STATES}
    of_motion = {name: values[f"worst.{name}"] for name in motion}
    return Solutions(points=points, worst=Worst(**of_states, motion=of_motion), **fields_of)
