"""Which pretensions of a window keep limits on what is no straight line in pretension.

They may lie in several intervals: their ends are found by bisection between samples of the window.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array
from tendon_cli.model.window import Window

_STEP = 100.0
"""N; how far the search for an end begins where a window has none."""
_SAMPLES = 65
_HALVINGS = 45
_DOUBLINGS = 16

Measure = Callable[[Array], Array]
"""By how much a limit is exceeded at a pretension of each design, (designs,): above 0 it is broken."""


def cut_to_widest(found: Window, measures: dict[int, Measure]) -> npt.NDArray[np.int64]:
    """Cut open windows to the widest interval within other limits, in place; returns how many there are."""
    start = np.where(found.is_open, found.low, 0.0)
    stop = _far_end(found, start, measures)
    places = start + np.linspace(0.0, 1.0, _SAMPLES)[:, np.newaxis] * (stop - start)
    broken = {code: np.array([measure(at) > 0.0 for at in places]) for code, measure in measures.items()}
    kept = ~np.any(list(broken.values()), axis=0)
    rows = np.arange(len(start))
    edges = np.diff(kept.astype(np.int8), axis=0, prepend=0, append=0)
    intervals = np.where(found.is_open, (edges == 1).sum(axis=0), 0)
    # The widest: as many samples as the count since the last broken one says, at its largest.
    counts = np.zeros(kept.shape, dtype=np.int64)
    for at in range(_SAMPLES):
        counts[at] = np.where(kept[at], (counts[at - 1] if at else 0) + 1, 0)
    last = counts.argmax(axis=0)
    first = last - counts[last, rows] + 1
    some = intervals > 0
    cut_below, cut_above = some & (first > 0), some & (last < _SAMPLES - 1)
    low, low_by = _edge(places[first, rows], places[np.maximum(first - 1, 0), rows], measures)
    high, high_by = _edge(places[last, rows], places[np.minimum(last + 1, _SAMPLES - 1), rows], measures)
    for cut, ends, end, by, code, state, angle in (
        (cut_below, found.low, low, found.low_by, low_by, found.low_state, found.low_angle),
        (cut_above, found.high, high, found.high_by, high_by, found.high_state, found.high_angle),
    ):
        ends[cut], by[cut], state[cut], angle[cut] = end[cut], code[cut], -1, np.nan
    worst = np.array([each.sum(axis=0) for each in broken.values()]).argmax(axis=0)
    shut(found, np.array(list(broken))[worst], found.is_open & ~some)
    return intervals


def _far_end(found: Window, start: Array, measures: dict[int, Measure]) -> Array:
    """Where windows end, or if nothing ends them, beyond where any limit is kept, as far as one looks."""
    stop = np.where(np.isfinite(found.high) & found.is_open, found.high, start + _STEP)
    endless = found.is_open & np.isinf(found.high)
    for _ in range(_DOUBLINGS if endless.any() else 0):
        stop = np.where(endless & ~_broken(stop, measures), start + 2.0 * (stop - start), stop)
    return stop


def _broken(at: Array, measures: dict[int, Measure]) -> npt.NDArray[np.bool_]:
    return np.asarray(np.any([measure(at) > 0.0 for measure in measures.values()], axis=0))


def _edge(inside: Array, outside: Array, measures: dict[int, Measure]) -> tuple[Array, npt.NDArray[np.int64]]:
    """Where between two pretensions the limits are just kept, and the limit that is broken beyond."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        broken = _broken(middle, measures)
        inside, outside = np.where(broken, inside, middle), np.where(broken, middle, outside)
    beyond = np.array([measure(outside) for measure in measures.values()])
    return inside, np.array(list(measures))[beyond.argmax(axis=0)]


def shut(found: Window, code: int | npt.NDArray[np.int64], shut: npt.NDArray[np.bool_]) -> None:
    """Leave no pretension at all, for a reason."""
    shut = shut & ~np.isnan(found.low)
    for ends, by in ((found.low, found.low_by), (found.high, found.high_by)):
        ends[shut], by[shut] = np.nan, np.broadcast_to(code, shut.shape)[shut]
