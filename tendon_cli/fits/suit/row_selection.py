"""Rows of a suit's logs that a fit uses, and why the others are set aside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tendon_cli import say
from tendon_cli.errors import InputError
from tendon_cli.fits.log_rows import Mask
from tendon_cli.fits.suit.stroke_parts import (
    MOST_STROKES,
    REASONS,
    USED,
    LogStroke,
    Parts,
    gaps_of,
    parts_of,
    strokes_of,
    thinned,
    usable,
)
from tendon_cli.fits.suit.suit_log import SuitLog
from tendon_cli.units import counted

_SLID = 3.0
"""Way of the spool after a turn, over that in which the sheath turns, from which rows are used."""


@dataclass(frozen=True, eq=False)
class Selection:
    """Means over parts of strokes, of the rows that slide."""

    logs: tuple[SuitLog, ...]
    parts: Parts
    set_aside: Mapping[str, int]
    """Number of rows set aside, by reason."""
    notes: tuple[str, ...]

    @property
    def used(self) -> int:
        """Number of rows used."""
        return round(float(self.parts.count.sum()))

    def without(self, is_left_out: Mask, reason: int) -> Selection:
        """Return the selection without some parts, for the reason with this code."""
        rows = round(float(self.parts.count[is_left_out].sum()))
        if not rows:
            return self
        name = REASONS[reason]
        aside = {**self.set_aside, name: self.set_aside.get(name, 0) + rows}
        return replace(self, parts=self.parts.select(~is_left_out), set_aside=aside)


def cut(
    logs: Sequence[SuitLog],
) -> tuple[tuple[SuitLog, ...], tuple[int, ...], tuple[LogStroke, ...]]:
    """Return logs thinned, by how much, and their strokes.

    Raises:
        InputError: if a log has a single stroke, or none.
    """
    thin = [thinned(log) for log in logs]
    strokes: list[LogStroke] = []
    for number, (log, _) in enumerate(thin):
        strokes += strokes_of(number, log)
    if len(strokes) < 2:
        raise InputError(
            f"{counted(len(strokes), 'stroke')}: friction cannot be told from the load",
            where=logs[0].source,
            hint="log two strokes or more, to and fro through most of the joint's range",
        )
    return tuple(log for log, _ in thin), tuple(every for _, every in thin), tuple(strokes)


def selected(
    logs: tuple[SuitLog, ...],
    every: tuple[int, ...],
    strokes: tuple[LogStroke, ...],
    spool_turn: float,
    spool_per_joint: float,
) -> Selection:
    """Select the rows that slide, once the sheaths have turned.

    Args:
        logs: Logs, thinned.
        every: Rows of each log that a row of the thinned one is the mean of.
        strokes: Their strokes.
        spool_turn: Way of the spool in which the sheaths turn, rad.
        spool_per_joint: Way of the spool per way of the joint.
    """
    codes = []
    lengths = np.array([float(np.ptp(logs[one.log].elbow_angle[one.rows])) for one in strokes])
    log_of = np.array([stroke.log for stroke in strokes])
    way = _SLID * spool_turn
    for stroke in strokes:
        usual = float(np.median(lengths[log_of == stroke.log]))
        codes.append(usable(stroke, logs[stroke.log], usual, way / max(spool_per_joint, 0.2), way))
    used = [place for place, code in enumerate(codes) if np.any(code == USED)]
    notes = [text for log in logs for text in _note_on_gaps(log)]
    if max(every) > 1:
        notes.append(
            f"{max(every)} neighbouring rows are averaged first, a log being longer than needed"
        )
    if len(used) > MOST_STROKES:
        notes.append(
            f"{MOST_STROKES} of {len(used)} strokes are fitted, evenly spaced: more would not"
            " narrow what the model's own misfit leaves open"
        )
        kept = np.unique(np.round(np.linspace(0, len(used) - 1, MOST_STROKES)).astype(int))
        used = [used[place] for place in kept.tolist()]
    set_aside: dict[str, int] = {}
    missing = sum(log.missing for log in logs)
    if missing:
        set_aside["without a number"] = missing
    for place in used:
        code = codes[place]
        for reason in np.unique(code[code != USED]).tolist():
            rows = int(np.count_nonzero(code == reason)) * every[strokes[place].log]
            set_aside[REASONS[reason]] = set_aside.get(REASONS[reason], 0) + rows
    kept_strokes = [strokes[place] for place in used]
    parts = parts_of(logs, every, kept_strokes, [codes[place] for place in used])
    return Selection(logs, parts, set_aside, tuple(notes))


def _note_on_gaps(log: SuitLog) -> list[str]:
    """Return a note on gaps in time, where and how long; none where the load was changed."""
    gaps = gaps_of(log)
    if log.load_mass is not None:
        gaps = gaps[log.load_mass[gaps] == log.load_mass[gaps + 1]]
    if not len(gaps) or log.time is None:
        return []
    lasts = np.diff(log.time)[gaps]
    longest = gaps[int(np.argmax(lasts))]
    found = counted(len(gaps), "gap")
    text = (
        f"{log.source}: {found} in the time, the longest of {say.number(float(lasts.max()), 3)} s"
        f" after line {log.line[longest]}; rows after a gap count once the tendons slide again"
    )
    return [text]
