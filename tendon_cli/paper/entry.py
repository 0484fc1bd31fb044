"""A statement of the ledger, how it is judged, and how its numbers are written."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

_ROUNDING = 1e-9  # below it a number is what rounding leaves of zero
TRUE, FALSE, IN_PART = "true", "false", "true in part"


@dataclass(frozen=True)
class Entry:
    """A finding or a claim of the paper, or a slip of its letter, with the verdict and what it rests on."""

    id: str
    finding: str
    verdict: str
    """TRUE, FALSE or IN_PART, as computed."""
    recorded: str
    """The verdict on record; any other means that something has changed."""
    value: str
    """The numbers behind the verdict, with units."""
    numbers: tuple[float, ...]
    """The same numbers to six digits, in the same order."""
    figure: str | None
    """Name of the file that shows it."""

    @property
    def holds(self) -> bool:
        """Whether it is true as a whole."""
        return self.verdict == TRUE

    @property
    def as_recorded(self) -> bool:
        """Whether the verdict is the one on record."""
        return self.verdict == self.recorded


@dataclass(frozen=True)
class Verdict:
    """What a check found."""

    verdict: str
    value: str
    numbers: tuple[float, ...]

    def entry(self, id_: str, text: str, figure: str | None, recorded: str = TRUE) -> Entry:
        """The line of the ledger."""
        return Entry(id_, text, self.verdict, recorded, self.value, self.numbers, figure)


def judge(parts: Sequence[bool | np.bool_], template: str, *values: npt.ArrayLike) -> Verdict:
    """True where all parts are, false where none is; `{:2}` in the template is a value, or a list, of two decimals."""
    verdict = TRUE if all(parts) else IN_PART if any(parts) else FALSE
    numbers = [np.ravel(np.asarray(value, dtype=np.float64)).tolist() for value in values]
    return Verdict(verdict, template.format(*map(_Listed, numbers)), tuple(map(_rounded, itertools.chain(*numbers))))


class _Listed(list[float]):
    def __format__(self, digits: str) -> str:
        return ", ".join(number(value, int(digits)) for value in self)


def _rounded(value: float) -> float:
    return float(f"{value:.6g}") if abs(value) > _ROUNDING else 0.0


def number(value: float, digits: int = 1) -> str:
    """A number with a proper minus sign; a dash where there is none."""
    if math.isnan(value):
        return "–"
    text = f"{value:.{digits}f}"
    return (text.lstrip("-") if float(text) == 0.0 else text).replace("-", "−")
