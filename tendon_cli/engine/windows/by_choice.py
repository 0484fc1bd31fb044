"""Data with a value for each choice, which is selected and concatenated field by field."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Flags, Rows

ColumnArrays = dict[str, npt.NDArray[Any]]
"""Arrays of one length by the names of a table's columns."""
Selection = Rows | Flags | list[int] | slice
"""Places of choices, or a mask."""


@dataclass(frozen=True, eq=False)
class ByChoice:
    """Data whose every field is an array, (choices,), a mapping of arrays, or more such data."""

    def select(self, rows: Selection) -> Self:
        """Select choices by place or mask."""
        selected = {field.name: _select(getattr(self, field.name), rows) for field in fields(self)}
        return type(self)(**selected)

    @classmethod
    def concatenate(cls, parts: Sequence[Self]) -> Self:
        """Concatenate several parts, whose mappings have the same keys."""
        concatenated = {
            field.name: _concatenate([getattr(part, field.name) for part in parts])
            for field in fields(cls)
        }
        return cls(**concatenated)


def _select(value: Any, rows: Selection) -> Any:
    """Select choices in one field."""
    if isinstance(value, ByChoice):
        return value.select(rows)
    if isinstance(value, Mapping):
        return {name: values[rows] for name, values in value.items()}
    return value[rows]


def _concatenate(values: list[Any]) -> Any:
    """Concatenate one field of several parts."""
    first = values[0]
    if isinstance(first, ByChoice):
        return first.concatenate(values)
    if isinstance(first, Mapping):
        return {name: np.concatenate([of_part[name] for of_part in values]) for name in first}
    return np.concatenate(values)
