"""Data with a value for each choice, which is selected and concatenated field by field."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from tendon_cli.model.design import map_arrays
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
        selected: Self = map_arrays(self, lambda values: values[rows])
        return selected

    @classmethod
    def concatenate(cls, parts: Sequence[Self]) -> Self:
        """Concatenate several parts, whose mappings have the same keys."""
        first, *others = parts
        concatenated: Self = map_arrays(first, lambda *values: np.concatenate(values), *others)
        return concatenated
