"""Sentences on limits that no line of a figure shows: those that leave nothing, or bind nowhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tendon_cli import say
from tendon_cli.model.kinematics import Array

_MOST_NAMED = 3
"""Largest number of places that a sentence names."""


def crosses_zero(room: Array) -> bool:
    """Return True if some designs keep a limit and others break it."""
    return bool(np.nanmin(room, initial=np.inf) < 0.0 <= np.nanmax(room, initial=-np.inf))


def limit_remarks(
    limits: Mapping[str, str], rooms: Mapping[str, Sequence[Array]], places: Sequence[str]
) -> list[str]:
    """Say for each limit where no line shows it, unless that is because designs keep it there.

    Args:
        limits: Text of each limit, such as "max tension ≤ 300 N", by its name.
        rooms: Room that each limit leaves, by its name, in pieces; each piece is a panel, or what
            has a line of its own in a panel. Negative where the limit is broken.
        places: Name of each piece, such as "5 kg load".

    Returns:
        Sentences. Nothing is said of a limit whose lines say all.
    """
    kept = []
    unknown = []
    broken_by_all = []
    broken_at: dict[tuple[str, bool], list[str]] = {}
    for name, text in limits.items():
        pieces = rooms[name]
        has_value = [bool(np.isfinite(room).any()) for room in pieces]
        is_broken = [bool((room < 0.0).any()) and not crosses_zero(room) for room in pieces]
        has_line = any(map(crosses_zero, pieces))
        broken = [place for place, is_so in zip(places, is_broken, strict=True) if is_so]
        if not any(has_value):
            unknown.append(text)
        elif not broken and not has_line:
            kept.append(text)
        elif len(broken) == sum(has_value):
            broken_by_all.append(text)
        elif broken:
            broken_at.setdefault((_listed(broken), has_line), []).append(text)
    remarks = []
    if broken_by_all:
        remarks.append(f"No design keeps {say.join_words(broken_by_all, 'or')}.")
    for (where, has_line), texts in broken_at.items():
        others = "" if has_line else "; every other design does"
        remarks.append(f"At {where}, no design keeps {say.join_words(texts, 'or')}{others}.")
    if kept:
        remarks.append(f"Every design keeps {say.join_words(kept)}.")
    if unknown:
        remarks.append(f"No design has a value to compare with {say.join_words(unknown, 'or')}.")
    return remarks


def _listed(places: Sequence[str]) -> str:
    """Name some places; of many the first ones and the number of the others."""
    if len(places) <= _MOST_NAMED:
        return say.join_words(places)
    return f"{', '.join(places[:_MOST_NAMED])} and {len(places) - _MOST_NAMED} others"
