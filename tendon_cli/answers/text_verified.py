"""The judgement of a fresh sample in words."""

from __future__ import annotations

from tendon_cli import say
from tendon_cli.answer_record import FreshRecord, VerifiedRecord

_MOST_DIGITS = 7
"""Most significant digits of a share that is printed beside the one asked for."""
_ROUNDING = 1e-12
"""Rounding of a share."""


def members(fresh: FreshRecord) -> str:
    """Say who or what judges: "10,000 newly drawn persons", "9,999 new draws for 3 persons"."""
    count = f"{fresh.count:,}"
    several = "" if fresh.count == 1 else "s"
    if fresh.kind == "persons":
        return f"{count} newly drawn person{several}"
    whom = ""
    if fresh.persons == 1:
        whom = " for this person"
    elif fresh.persons:
        whom = f" for these {fresh.persons:,} persons"
    return f"{count} new draw{several}{whom}"


def judgement_words(fresh: FreshRecord, judged: VerifiedRecord, serve: float) -> str:
    """Say whom a choice serves: "only 93 % of 10,000 new draws (...), not the 95 % asked for"."""
    is_short = not is_enough(judged, serve) and not is_undecided(judged, serve)
    only = "only " if is_short else ""
    return f"{only}{share_words(fresh, judged, serve)}{verdict(fresh, judged, serve)}"


def share_words(fresh: FreshRecord, judged: VerifiedRecord, serve: float) -> str:
    """Say a share with its interval: "94.7 % of 10,000 newly drawn persons (94.2 to 95.2 %)".

    Args:
        fresh: The sample.
        judged: Its judgement.
        serve: Share that is enough: one that is less is never rounded to it.
    """
    value = judged.value
    low, high = judged.interval_95
    return say.share_of(members(fresh), value, low, high, _share(value, serve))


def is_enough(judged: VerifiedRecord, serve: float) -> bool:
    """Return True if the share is at least `serve`, apart from rounding."""
    return judged.value >= serve - _ROUNDING


def is_undecided(judged: VerifiedRecord, serve: float) -> bool:
    """Return True if the interval of the share holds the one asked for."""
    low, high = judged.interval_95
    return low <= serve <= high


def verdict(fresh: FreshRecord, judged: VerifiedRecord, serve: float) -> str:
    """Say what the share means for the one asked for, after `share_words`; empty if it is more."""
    enough = say.percent(serve)
    if is_undecided(judged, serve):
        return f", too close to {enough} to tell from {fresh.count:,}"
    return "" if is_enough(judged, serve) else f", not the {enough} asked for"


def _share(value: float, serve: float) -> str:
    """Say a share with as many digits as tell it from the one asked for."""
    text = say.percent(value)
    for digits in range(4, _MOST_DIGITS + 1):
        if text != say.percent(serve) or abs(value - serve) < _ROUNDING:
            break
        text = f"{say.number(100.0 * value, digits)} %"
    return text
