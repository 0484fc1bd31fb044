"""Several suits instead of one: which few, each at its pretension, serve the largest share of people. Exact.

A suit at a pretension serves the persons whose window holds it. Along the line of pretensions only the largest such
sets matter: those between an end at which a window begins and the next one, at which a window ends. Of these, the two
or three that together serve most are found by going through all, but for those that a bound shows to be no better.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.answers.coverage import ROUNDING
from tendon_cli.model.kinematics import Array

_AT_ONCE = 2**22
"""Numbers of a matrix that are in memory at once."""
_IN_A_GROUP = 16


@dataclass(frozen=True)
class Sizes:
    """The suits that together serve most."""

    choices: tuple[int, ...]
    """Rows of the windows, ascending."""
    pretensions: tuple[float, ...]
    """One for each suit, N: the middle of those at which it serves the same persons."""
    share: float
    """Of the weighting."""


@dataclass(frozen=True, eq=False)
class _Sets:
    """Sets of persons that one suit serves at one pretension."""

    choice: npt.NDArray[np.int64]
    pretension: Array
    serves: Array
    """1 for each person served, else 0; shape (sets, persons)."""

    def only(self, chosen: npt.NDArray[np.int64], people: npt.NDArray[np.bool_]) -> _Sets:
        """Some of the sets, of some of the persons."""
        return _Sets(self.choice[chosen], self.pretension[chosen], self.serves[np.ix_(chosen, people)])


_Found = tuple[tuple[int, ...], float]
"""Chosen sets, and what they weigh together."""


def best_sizes(low: Array, high: Array, weighting: Array, most: int, heed: Callable[[], None] = lambda: None) -> Sizes:
    """The at most `most` suits (1, 2 or 3) that serve the largest share; of equal shares, the one of fewer suits.

    `low` and `high` are the ends of the windows, N, of shape (choices, persons), empty where low > high or NaN.
    `heed` is called every now and then, and may raise to end the search.
    """
    sets = _largest_sets(low, high)
    weights = weighting / np.sum(weighting)
    found: _Found = ((), ROUNDING)
    for search in (_best_one, _best_pair, _best_triple)[:most]:
        found = search(sets, weights, found, heed) if len(sets.choice) else ((), 0.0)
    chosen = sorted(found[0], key=lambda at: (sets.choice[at], sets.pretension[at]))
    choices = tuple(int(sets.choice[at]) for at in chosen)
    return Sizes(choices, tuple(float(sets.pretension[at]) for at in chosen), found[1] if chosen else 0.0)


def _largest_sets(low: Array, high: Array) -> _Sets:
    """For each choice the sets of persons that no other pretension serves together with more."""
    choices, pretensions, serves = [], [], [np.empty((0, low.shape[1]))]
    for choice, (starts, stops) in enumerate(zip(low, high, strict=True)):
        is_open = starts <= stops
        ends = np.concatenate([starts[is_open], stops[is_open]])
        order = np.argsort(ends, kind="stable")  # at one pretension windows begin before others end
        begins = order < is_open.sum()
        last = np.flatnonzero(begins[:-1] & ~begins[1:])
        begin, end = ends[order[last]], ends[order[last + 1]]
        serves.append(((starts <= begin[:, np.newaxis]) & (begin[:, np.newaxis] <= stops)).astype(np.float64))
        choices += [choice] * len(last)
        pretensions.append(np.where(np.isinf(end), begin, (begin + end) / 2.0))
    return _Sets(np.array(choices, dtype=np.int64), np.concatenate([np.empty(0), *pretensions]), np.concatenate(serves))


def _best_one(sets: _Sets, weights: Array, found: _Found, _heed: Callable[[], None]) -> _Found:
    alone = sets.serves @ weights
    at = int(np.argmax(alone))
    return ((at,), float(alone[at])) if alone[at] > found[1] + ROUNDING else found


def _best_pair(sets: _Sets, weights: Array, found: _Found, heed: Callable[[], None]) -> _Found:
    alone = sets.serves @ weights
    order = np.argsort(-alone, kind="stable")
    alone, serves = alone[order], sets.serves[order]
    rows = max(1, _AT_ONCE // len(order))
    for start in range(0, len(order), rows):
        heed()
        # The second of a pair is the lighter one, and must have at least what the first one lacks.
        stop = int(np.searchsorted(-alone, float(alone[start]) - found[1], side="right"))
        if stop <= start:
            break
        both = _together(serves[start : start + rows], serves[start:stop], weights)
        at = np.unravel_index(int(np.argmax(both)), both.shape)
        if both[at] > found[1] + ROUNDING:
            found = (int(order[start + at[0]]), int(order[start + at[1]])), float(both[at])
    return found


def _best_triple(sets: _Sets, weights: Array, found: _Found, heed: Callable[[], None]) -> _Found:
    """Sets that are neighbours serve much the same persons: together, in groups, they give the bounds of a search."""
    found = _climbed(sets, weights, _with_one_more(sets, weights, found))
    starts = np.flatnonzero((np.diff(sets.choice, prepend=-1) != 0) | (np.arange(len(sets.choice)) % _IN_A_GROUP == 0))
    group = np.cumsum(np.isin(np.arange(len(sets.choice)), starts)) - 1
    joint = np.maximum.reduceat(sets.serves, starts, axis=0)
    for at, start in enumerate(starts):
        rest = joint[at:]
        if _bound(joint[at], rest, weights).max() <= found[1] + ROUNDING:
            continue
        for first in np.flatnonzero(group == at):
            heed()
            hopeful = _bound(sets.serves[first], rest, weights).max(axis=1) > found[1] + ROUNDING
            others = start + np.flatnonzero(hopeful[group[start:] - at])
            if not len(others):
                continue
            weight, left = float(sets.serves[first] @ weights), weights * (1.0 - sets.serves[first])
            people = left > 0.0
            pair = _best_pair(sets.only(others, people), left[people], ((), found[1] - weight), heed)
            if pair[0]:
                found = (int(first), *(int(others[other]) for other in pair[0])), weight + pair[1]
    return found


def _bound(first: Array, rest: Array, weights: Array) -> Array:
    """What a set and any two of the rest weigh at most."""
    return float(first @ weights) + _together(rest, rest, weights * (1.0 - first))


def _together(some: Array, others: Array, weights: Array) -> Array:
    """What each of some sets and each of others weigh together."""
    weighted = some * weights
    total = weighted.sum(axis=1)[:, np.newaxis] + (others @ weights)[np.newaxis]
    return np.asarray(total - weighted @ others.T)


def _with_one_more(sets: _Sets, weights: Array, found: _Found) -> _Found:
    left = weights * (1.0 - sets.serves[list(found[0])].max(axis=0, initial=0.0))
    adds = sets.serves @ left
    at = int(np.argmax(adds))
    return ((*found[0], at), found[1] + float(adds[at])) if adds[at] > ROUNDING else found


def _climbed(sets: _Sets, weights: Array, found: _Found) -> _Found:
    """A set after the other exchanged for the one that adds most to those that stay, as long as that helps."""
    helped = True
    while helped:
        helped = False
        for gone in range(len(found[0])):
            stay = found[0][:gone] + found[0][gone + 1 :]
            kept = float(sets.serves[list(stay)].max(axis=0, initial=0.0) @ weights)
            changed = _with_one_more(sets, weights, (stay, kept))
            if changed[1] > found[1] + ROUNDING:
                found, helped = changed, True
    return found
