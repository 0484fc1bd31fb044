"""Statements of the paper, their verdicts, and their numbers in words; statements.toml has them."""

from __future__ import annotations

import itertools
import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from verification.paper.runs import Paper

_ROUNDING = 1e-9
"""Magnitude below which a number is what rounding leaves of zero."""
TRUE = "true"
FALSE = "false"
IN_PART = "true in part"
KINDS = ("finding", "claim", "slip", "gap")
"""Kinds of statements, in the order of the page."""

Evidence = tuple[Any, ...]
"""Truth of each part of a statement, then numbers or lists of numbers in the order of its text."""
Check = Callable[[Paper], Evidence]
"""Function that finds the evidence for one statement."""


@dataclass(frozen=True)
class Entry:
    """Statement of the paper, or place where its letter fails, with its verdict and its numbers."""

    id: str
    """A letter and a number, such as F4."""
    kind: str
    """Kind of statement: finding, claim, slip (of print) or gap."""
    finding: str
    """The statement."""
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
        """True if the statement is true as a whole."""
        return self.verdict == TRUE

    @property
    def as_recorded(self) -> bool:
        """True if the verdict is the one on record."""
        return self.verdict == self.recorded


@cache
def content() -> dict[str, Any]:
    """Return the text on the paper: its page, the captions of its figures, and all statements."""
    return tomllib.loads((Path(__file__).parent / "statements.toml").read_text(encoding="utf-8"))


def judge_all(checks: Mapping[str, Check], paper: Paper) -> tuple[Entry, ...]:
    """Judge all statements by the tables and fits of the paper's studies.

    Args:
        checks: The check of each statement, by its id.
        paper: Tables and fits.
    """
    entries = []
    written = content()
    for kind in KINDS:
        for statement in written[kind]:
            id_ = statement["id"]
            text = statement["text"]
            parts, *values = checks[id_](paper)
            verdict, value, numbers = judge(
                parts, statement["value"], *values, wrap=paper.fit.bend.text
            )
            recorded = statement.get("recorded", TRUE)
            figure = statement.get("figure")
            entries.append(Entry(id_, kind, text, verdict, recorded, value, numbers, figure))
    return tuple(entries)


def judge(
    parts: Sequence[bool | np.bool_], template: str, *values: npt.ArrayLike, wrap: str = ""
) -> tuple[str, str, tuple[float, ...]]:
    """Return the verdict on a statement, its numbers in words, and the numbers.

    Args:
        parts: Truth of each part; the verdict is TRUE if all are true, FALSE if none is.
        template: Text in which `{:2}` is a value, or a list, of two decimals, and `{wrap}` the
            wrap angle of the fit.
        *values: Numbers, or lists of them, in the order of the template.
        wrap: The wrap angle in words.
    """
    if all(parts):
        verdict = TRUE
    elif any(parts):
        verdict = IN_PART
    else:
        verdict = FALSE
    numbers = [np.ravel(np.asarray(value, dtype=np.float64)).tolist() for value in values]
    text = template.format(*map(_Listed, numbers), wrap=wrap)
    rounded = tuple(
        float(f"{value:.6g}") if abs(value) > _ROUNDING else 0.0
        for value in itertools.chain(*numbers)
    )
    return verdict, text, rounded


class _Listed(list[float]):
    """Numbers whose format is a count of decimals."""

    def __format__(self, digits: str) -> str:
        texts = ("–" if math.isnan(value) else f"{value:z.{int(digits)}f}" for value in self)
        return ", ".join(texts).replace("-", "−")
