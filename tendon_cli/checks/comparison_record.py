"""The record of a comparison: types for whoever makes it, says it, draws it or checks it.

Values are SI; a number that is missing or not finite is null. All that is said of a comparison
follows from its record alone.
"""

from __future__ import annotations

from typing import Any, Literal, TypeAlias, TypedDict

from tendon_cli.checks.study_differences import DifferenceRecord

Judgement: TypeAlias = Literal["better", "worse", "no difference"]
"""Judgement on a later result beside the first one."""


class ComparedResult(TypedDict):
    """Result among those that are compared."""

    label: str
    """Name by which texts tell it from the others."""
    folder: str | None
    """Its folder; null in memory."""
    name: str
    title: str
    verb: str
    study_hash: str
    choice: str
    """Choice of an answer that is compared, in words; empty if it has no axes, and for a run."""
    sentence: str
    """Its answer in a sentence or two."""
    unit: str
    """Unit of what is read, "N" or "N m"; that of pretensions."""


class QuantityRecord(TypedDict):
    """A quantity of all results."""

    name: str
    """Its name among the quantities of tendon."""
    label: str
    """Meaning in words."""
    unit: str
    values: list[float | None]
    """Value of each result."""
    spans: list[list[float] | None]
    """95 % interval of each value; null if it has none."""
    verdicts: list[Judgement | None]
    """Judgement on each result beside the first; null for the first, and where neither is better
    by itself."""
    intervals: list[list[float] | None]
    """95 % interval of the difference from the first; null if it has none."""


class BindRecord(TypedDict):
    """Limits that set the window of one answer."""

    lower: str | None
    """Limit that binds below."""
    upper: str | None
    """Limit that binds above."""
    words: list[str]
    """Both ends in words."""
    fresh: list[float | None] | None
    """Window of the fresh sample; null without one."""


class MoveRecord(TypedDict):
    """Persons, draws or designs that one of two results serves and the other does not."""

    kind: str
    """Noun for what is counted, in the plural."""
    count: int
    of: int
    """Number of those that both results judge."""
    share: float
    """Share of these, by weight."""
    names: list[str]
    """The first of them by name, of those that have one."""
    named: int
    """Number of those that have a name: of the study's own sample, or of the designs."""
    named_kind: str
    """Noun for those that have a name, in the plural."""
    named_of: int
    """Number of persons, draws or designs that have a name."""


class UnservedRecord(TypedDict):
    """A person or a draw that one of two answers serves and the other does not."""

    name: str
    """Its name; of a fresh draw its numbers."""
    why: str
    """Why the other answer does not serve it, in words."""
    command: str | None
    """Command that shows it; null if nothing that is still there can show it."""


class MarginRecord(TypedDict):
    """Motion of the margins of designs that two runs have, N."""

    designs: int
    rose: int
    """Number of designs whose margin is larger in the later run."""
    fell: int
    median: float | None
    """Median of later less first."""
    largest_rise: float | None
    rise_at: str
    """Design with the largest rise, in words."""
    largest_fall: float | None
    fall_at: str


class BrokenRecord(TypedDict):
    """A limit that designs of two runs break."""

    limit: str
    label: str
    """Words for a design that breaks it."""
    before: int
    """Number of designs that break it in the first run."""
    now: int
    newly: int
    """Number that break it in the later run only."""
    no_longer: int
    first: list[str]
    """The first designs that newly break it, in words."""


class BesideFirst(TypedDict):
    """A later result beside the first one."""

    gained: MoveRecord | None
    """Members whom the later result alone serves; null if it cannot be told."""
    lost: MoveRecord | None
    """Members whom the first alone serves."""
    why_gained: list[UnservedRecord]
    """At most three of those gained, and why the first does not serve them."""
    why_lost: list[UnservedRecord]
    """At most three of those lost, and why the later result does not serve them."""
    paired: bool
    """True if both shares are of the same members of a fresh sample, computed again for this."""
    margins: MarginRecord | None
    """Motion of margins, of two runs with designs in common."""
    broken: list[BrokenRecord]
    """Limits that designs of either run break."""


class ComparisonRecord(TypedDict):
    """The whole comparison of two or more results, the first of which is the reference."""

    results: list[ComparedResult]
    differences: list[DifferenceRecord]
    quantities: list[QuantityRecord]
    binds: list[BindRecord | None]
    """Limits that set the window of each answer; null for a run, or without a window."""
    beside: list[BesideFirst]
    """Each later result beside the first one."""
    notes: list[str]
    """Sentences on what is compared, and what cannot be."""


def as_json(record: ComparisonRecord) -> dict[str, Any]:
    """Return the record as `tendon compare --json` prints it.

    For two results values stand under `a` and `b`; for more of them in lists, the first result
    first.
    """
    if len(record["results"]) != 2:
        return {**record}
    first, second = record["results"]
    (beside,) = record["beside"]
    differences = [
        {
            "key": difference["key"],
            "a": difference["values"][0],
            "b": difference["values"][1],
            "unit": difference["unit"],
        }
        for difference in record["differences"]
    ]
    quantities = [
        {
            "name": quantity["name"],
            "unit": quantity["unit"],
            "a": quantity["values"][0],
            "b": quantity["values"][1],
            "verdict": quantity["verdicts"][1],
            "interval": quantity["intervals"][1],
        }
        for quantity in record["quantities"]
    ]
    return {
        "a": first,
        "b": second,
        "differences": differences,
        "quantities": quantities,
        "binds": {"a": record["binds"][0], "b": record["binds"][1]},
        **beside,
        "notes": record["notes"],
    }
