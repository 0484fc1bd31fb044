"""Results side by side: what differs, better or worse, gained and lost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from tendon_cli import say
from tendon_cli.checks.compare_text import comparison_blocks, comparison_markdown, verdict_words
from tendon_cli.checks.compared import Compared, ComparedResult, Value
from tendon_cli.engine.results import AnyResult, Result, open_result
from tendon_cli.engine.study_differences import (
    CHANGES_NOTHING,
    Difference,
    study_differences,
)
from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import result_path
from tendon_cli.say import Block
from tendon_cli.say.display import Displayed
from tendon_cli.units import shorten
from tendon_cli.verbs.registry import load

VERSION = "version"
"""Key under which the versions of tendon that wrote two results differ."""
_LONGEST_LABEL = 16
"""Most characters of the label of a result."""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Displayed):
    """Two or more results side by side; the first is the reference."""

    results: tuple[Result, ...]
    """The results, of one kind."""
    pairs: tuple[Compared, ...]
    """Each later result beside the first."""

    drawn_by: ClassVar[str] = "tendon_cli.face.page_of_comparison"
    documented: ClassVar[tuple[str, ...]] = ("markdown",)

    @property
    def sides(self) -> list[ComparedResult]:
        """The results as the comparison names them, the first one first."""
        return [self.pairs[0].a, *(pair.b for pair in self.pairs)]

    def values(self, name: str) -> list[Value]:
        """Return the value of a quantity of every result; None for one without it."""
        numbers = [pair.number(name) for pair in self.pairs]
        first = numbers[0]
        later = [None if number is None else number.b for number in numbers]
        return [None if first is None else first.a, *later]

    @property
    def record(self) -> dict[str, Any]:
        """The comparison as `tendon compare --json` prints it: of several pairs, a list of them."""
        records = [pair.record() for pair in self.pairs]
        return records[0] if len(records) == 1 else {"comparisons": records}

    @property
    def blocks(self) -> list[Block]:
        """The comparison in words, as headings, items, tables and notes."""
        return comparison_blocks(self.pairs)

    @property
    def text(self) -> str:
        """The whole comparison in 80 columns."""
        return say.as_text(self.blocks, self._joint)

    @property
    def title(self) -> str:
        """The labels of the results in a line."""
        labels = [side.label for side in self.sides]
        return f"{say.join_words(labels[1:])} compared with {labels[0]}"

    @property
    def short(self) -> str:
        """In what each later result is better or worse than the first."""
        lines = [self.title]
        for words in verdict_words(self.pairs):
            lines += say.wrap(say.name_joint(words, self._joint), "  ")
        found = dict.fromkeys(found.key for pair in self.pairs for found in pair.differences)
        lines += say.wrap(f"the studies differ in {say.join_words([*found]) or 'nothing'}", "  ")
        return "\n".join(lines)

    @property
    def markdown(self) -> str:
        """The whole comparison in Markdown, for a comment in a pull request."""
        return comparison_markdown(self.blocks, self._joint)

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
    labels = labels_of(results)
    pairs = [
        compared(results[0], other, (labels[0], label), choice)
        for other, label in zip(results[1:], labels[1:], strict=True)
    ]
    return Comparison(tuple(results), tuple(pairs))


def compared(
    first: Result, second: Result, labels: tuple[str, str], choice: int | None = None
) -> Compared:
    """Compare a result with the first one.

    Args:
        first: The reference.
        second: The result that is compared with it, of the same kind.
        labels: Name of each for texts.
        choice: Row of a choice of the first answer; None for those that the answers name first.

    Raises:
        InputError: The results are of two kinds, or damaged.
        UsageError: An answer has no such choice.
    """
    if first.kind.verb != second.kind.verb:
        raise InputError(
            f"holds {second.kind.noun}, which cannot be compared with {first.kind.noun}",
            where=str(second.folder or second.record["name"]),
            hint=f"`tendon {first.kind.verb}` on its study gives one that can",
        )
    differences = [
        found
        for found in study_differences(first.record, second.record)
        if found.key.partition(".")[0] not in CHANGES_NOTHING
    ]
    versions = [result.record["versions"].get("tendon", "") for result in (first, second)]
    if versions[0] != versions[1]:
        words = (f"tendon {versions[0]}", f"tendon {versions[1]}")
        differences.append(Difference(VERSION, None, *words, words))
    found: Compared = load(first.kind.compare)((first, second), labels, differences, choice)
    return found


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
