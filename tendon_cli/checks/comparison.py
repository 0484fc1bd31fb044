"""Two or more results side by side: what differs, better or worse, gained and lost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from tendon_cli import say
from tendon_cli.checks.comparison_record import ComparisonRecord, as_json
from tendon_cli.checks.comparison_text import (
    comparison_blocks,
    comparison_markdown,
    comparison_text,
    verdict_words,
)
from tendon_cli.display import Displayed
from tendon_cli.engine.results import AnyResult, Result, open_result
from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import result_path
from tendon_cli.registry import load
from tendon_cli.say import Block
from tendon_cli.units import shorten

_LONGEST_LABEL = 16
"""Most characters of the label of a result."""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Displayed):
    """Two or more results side by side; the first is the reference."""

    results: tuple[Result, ...]
    """The results, of one kind."""
    compared: ComparisonRecord
    """The comparison of all of them."""

    drawn_by: ClassVar[str] = "tendon_cli.face.page_of_comparison"

    @property
    def record(self) -> dict[str, Any]:
        """The comparison as `tendon compare --json` prints it."""
        return as_json(self.compared)

    @property
    def blocks(self) -> list[Block]:
        """The comparison in words, as headings, items, tables and notes."""
        return comparison_blocks(self.compared)

    @property
    def text(self) -> str:
        """The whole comparison in 80 columns."""
        return comparison_text(self.compared, self._joint)

    @property
    def short(self) -> str:
        """In what each later result is better or worse than the first."""
        labels = [result["label"] for result in self.compared["results"]]
        lines = [f"{say.join_words(labels[1:])} compared with {labels[0]}"]
        for words in verdict_words(self.compared):
            lines += say.wrap(say.name_joint(words, self._joint), "  ")
        keys = [difference["key"] for difference in self.compared["differences"]]
        differs = say.join_words(keys) or "nothing"
        lines += say.wrap(f"the studies differ in {differs}", "  ")
        return "\n".join(lines)

    @property
    def markdown(self) -> str:
        """The whole comparison in Markdown, for a comment in a pull request."""
        return comparison_markdown(self.compared, self._joint)

    @property
    def _joint(self) -> str:
        """Name of the joint of the first result."""
        return say.joint_name(self.results[0].record)


def compare_results(first: AnyResult, *others: AnyResult, choice: int | None = None) -> Comparison:
    """Compare runs, or answers, with the first of them.

    Nothing is computed again that stands in their records and tables, but for shares among persons
    or draws that two answers have in common: these are paired, which tells smaller differences.

    Args:
        first: A run or an answer, or its folder; the reference.
        others: The results that are compared with it.
        choice: Row of a choice of the first answer, compared with the same choice of the others;
            by default each answer has the choice that it names first.

    Raises:
        InputError: There is no result, a damaged one, or a run is compared with an answer.
        UsageError: Nothing to compare with is given, or an answer has no such choice.

    >>> import tendon_cli as tendon
    >>> study = tendon.study({"spool": {"ratio": 0.6}, "spring": {"stiffness": "5 kN/m"}})
    >>> answers = [tendon.design(study.vary(**{"spool.ratio": ratio})) for ratio in (0.6, 0.7)]
    >>> compared = tendon.compare(*answers)
    >>> [(found["key"], found["a"], found["b"]) for found in compared.record["differences"]]
    [('spool.ratio', 0.6, 0.7)]
    """
    if not others:
        raise UsageError("nothing to compare with, expected two results or more")
    results = [_opened(result) for result in (first, *others)]
    kinds = {result.kind.verb: result.kind for result in results}
    if len(kinds) > 1:
        first_kind, other = list(kinds.values())[:2]
        odd = next(result for result in results if result.kind.verb == other.verb)
        raise InputError(
            f"holds {other.noun}, which cannot be compared with {first_kind.noun}",
            where=str(odd.folder or odd.record["name"]),
            hint=f"`tendon {first_kind.verb}` on its study gives one that can",
        )
    (kind,) = kinds.values()
    if not kind.compare:
        raise UsageError(f"{kind.noun} cannot be compared")
    compared = load(kind.compare)(results, labels_of(results), choice)
    return Comparison(tuple(results), compared)


def _opened(result: AnyResult) -> Result:
    """Return a result, opened and verified if it is a folder."""
    return result if isinstance(result, Result) else open_result(result_path(result))


def labels_of(results: Sequence[Result]) -> list[str]:
    """Return a label for each result: its name, its folder, or else its place as a letter."""
    names = [str(result.record["name"]) for result in results]
    folders = [Path(result.folder or "").absolute().name for result in results]
    for candidates in (names, folders):
        labels = [shorten(name, _LONGEST_LABEL) for name in candidates]
        if max(Counter(labels).values()) == 1 and all(labels):
            return labels
    return [chr(ord("A") + place % 26) + "'" * (place // 26) for place in range(len(results))]
