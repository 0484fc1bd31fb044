"""What the paper states, how it is judged, and how its numbers are written; the statements are in statements.toml."""

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

from tendon_cli.paper.runs import Paper

_ROUNDING = 1e-9  # below it a number is what rounding leaves of zero
TRUE, FALSE, IN_PART = "true", "false", "true in part"

Evidence = tuple[Any, ...]
"""Truths of which the verdict is made, then numbers or lists of numbers in the order of the statement's text."""
Check = Callable[[Paper], Evidence]


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
    def kind(self) -> str:
        """What it is: a finding, claim or slip."""
        return {"C": "claim", "S": "slip"}.get(self.id[0], "finding")

    @property
    def holds(self) -> bool:
        """Whether it is true as a whole."""
        return self.verdict == TRUE

    @property
    def as_recorded(self) -> bool:
        """Whether the verdict is the one on record."""
        return self.verdict == self.recorded


@cache
def content() -> dict[str, Any]:
    """What is written of the paper: its page, the captions of its figures, and all statements."""
    return tomllib.loads((Path(__file__).parent / "statements.toml").read_text(encoding="utf-8"))


def judged(checks: Mapping[str, Check], paper: Paper) -> tuple[Entry, ...]:
    """All statements, judged by the paper's tables and fits."""
    entries = []
    for each in (*content()["finding"], *content()["claim"], *content()["slip"]):
        parts, *values = checks[each["id"]](paper)
        verdict, value, numbers = judge(parts, each["value"], *values, wrap=paper.fit.bend.text)
        recorded = each.get("recorded", TRUE)
        entries.append(
            Entry(each["id"], each["text"], verdict, recorded, value, numbers, each.get("figure"))
        )
    return tuple(entries)


def judge(
    parts: Sequence[bool | np.bool_], template: str, *values: npt.ArrayLike, wrap: str = ""
) -> tuple[str, str, tuple[float, ...]]:
    """The verdict, its numbers in words, and the numbers: true where all parts are, false where none is.

    `{:2}` in the template is a value, or a list, of two decimals, `{wrap}` the wrap angle of the fit.
    """
    verdict = TRUE if all(parts) else IN_PART if any(parts) else FALSE
    numbers = [np.ravel(np.asarray(value, dtype=np.float64)).tolist() for value in values]
    rounded = (
        float(f"{value:.6g}") if abs(value) > _ROUNDING else 0.0
        for value in itertools.chain(*numbers)
    )
    return verdict, template.format(*map(_Listed, numbers), wrap=wrap), tuple(rounded)


class _Listed(list[float]):
    def __format__(self, digits: str) -> str:
        texts = ("–" if math.isnan(value) else f"{value:z.{int(digits)}f}" for value in self)
        return ", ".join(texts).replace("-", "−")
