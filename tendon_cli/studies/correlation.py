"""Correlation of the uncertain numbers of a study, as a fit to a suit's logs gives it."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at
# every start.

from collections.abc import Mapping
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from tendon_cli.model.kinematics import Array
from tendon_cli.studies.fields import fault
from tendon_cli.studies.parts import Part, Words, field_default

_MOST_NUMBERS = 200
_ROUNDING = 1e-6
"""Rounding of a correlation that is written as text."""

Row = tuple[Annotated[float, Field(ge=-1.0 - _ROUNDING, le=1.0 + _ROUNDING)], ...]
"""Correlations of one number with all."""


class Correlation(Part):
    """Correlation of the normal scores of uncertain numbers, which are drawn together."""

    keys: Words = field_default((), description="keys of uncertain numbers")
    matrix: tuple[Row, ...] = field_default(
        (), description="their correlation, a row for each key in the order of the keys"
    )

    @model_validator(mode="after")
    def _checked(self) -> Self:
        """Refuse a matrix that is no correlation of these keys."""
        count = len(self.keys)
        if count > _MOST_NUMBERS:
            raise fault(f"{count:,} keys, expected {_MOST_NUMBERS} at most")
        if len(self.matrix) != count or any(len(row) != count for row in self.matrix):
            raise fault(f"the matrix is not square, expected {count} rows of {count} numbers")
        if not count:
            return self
        matrix = np.array(self.matrix)
        is_correlation = (
            np.allclose(matrix, matrix.T, atol=_ROUNDING)
            and np.allclose(np.diag(matrix), 1.0, atol=_ROUNDING)
            and np.linalg.eigvalsh(matrix).min() > -_ROUNDING * count
        )
        if not is_correlation:
            raise fault(
                "the matrix is no correlation, expected a symmetric one with a diagonal of 1"
            )
        return self

    def __call__(self, scores: Array, places: Mapping[str, int]) -> Array:
        """Return independent normal scores as correlated ones.

        Numbers of which the correlation is not known keep their scores. Of numbers that are not
        drawn, the correlation with the others falls away.

        Args:
            scores: Independent scores, (draws, numbers).
            places: Column of each number, by its key.
        """
        known = [place for place, key in enumerate(self.keys) if key in places]
        if not known:
            return scores
        columns = [places[self.keys[place]] for place in known]
        matrix = np.array(self.matrix)[np.ix_(known, known)]
        values, vectors = np.linalg.eigh(matrix)
        root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
        mixed = scores.copy()
        mixed[:, columns] = scores[:, columns] @ root
        return mixed
