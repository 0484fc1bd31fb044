"""Rows of a suit's logs that a fit uses, and why the others are set aside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tendon_cli import say
from tendon_cli.errors import InputError
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
from tendon_cli.fits.suit.suit_log import Floats, Integers, Mask, SuitLog
from tendon_cli.units import counted

_SLID = 3.0
"""Way of the spool after a turn, over that in which the sheath turns, from which rows are used."""


@dataclass(frozen=True, eq=False)
class Selection:
    """Rows that slide, and the means over parts of their strokes."""

    logs: tuple[SuitLog, ...]
    """Logs, thinned."""
    every: tuple[int, ...]
    """Rows of each log that a row of the thinned one is the mean of."""
    strokes: tuple[LogStroke, ...]
    codes: tuple[Integers, ...]
    """Code of the reason for which each row is set aside, for each stroke."""
    parts: Parts
    notes: tuple[str, ...]

    @property
    def used(self) -> int:
        """Number of rows used."""
        return sum(
            int(np.count_nonzero(code == USED)) * self.every[stroke.log]
            for stroke, code in zip(self.strokes, self.codes, strict=True)
        )

    @property
    def set_aside(self) -> dict[str, int]:
        """Number of rows set aside, by reason."""
        found: dict[str, int] = {}
        missing = sum(log.missing for log in self.logs)
        if missing:
            found["without a number"] = missing
        for stroke, code in zip(self.strokes, self.codes, strict=True):
            for reason in np.unique(code[code != USED]):
                rows = int(np.count_nonzero(code == reason)) * self.every[stroke.log]
                found[REASONS[reason]] = found.get(REASONS[reason], 0) + rows
        return found


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
        problem = f"{counted(len(strokes), 'stroke')}: friction cannot be told from the load"
        hint = "log two strokes or more, to and fro through most of the joint's range"
        raise InputError(problem, where=logs[0].source, hint=hint)
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
    for stroke in strokes:
        log = logs[stroke.log]
        usual = _usual_length(strokes, logs, stroke.log)
        way = _SLID * spool_turn
        codes.append(usable(stroke, log, usual, way / max(spool_per_joint, 0.2), way))
    used = [place for place, code in enumerate(codes) if np.any(code == USED)]
    notes = [text for log in logs for text in _note_on_gaps(log)]
    if max(every) > 1:
        notes.append(
            f"{max(every)} neighbouring rows are averaged first, a log being longer than needed"
        )
    if len(used) > MOST_STROKES:
        kept = set(np.round(np.linspace(0, len(used) - 1, MOST_STROKES)).astype(int).tolist())
        strokes_kept = [place for rank, place in enumerate(used) if rank in kept]
        notes.append(
            f"{MOST_STROKES} of {len(used)} strokes are fitted, evenly spaced: more would not"
            " narrow what the model's own misfit leaves open"
        )
        used = strokes_kept
    codes = [codes[place] for place in used]
    strokes = tuple(strokes[place] for place in used)
    parts = parts_of(logs, strokes, codes)
    return Selection(logs, every, strokes, tuple(codes), parts, tuple(notes))


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


def _usual_length(strokes: Sequence[LogStroke], logs: Sequence[SuitLog], number: int) -> float:
    """Return the median length of the strokes of one log, rad."""
    lengths = [
        abs(float(np.ptp(logs[number].elbow_angle[stroke.rows])))
        for stroke in strokes
        if stroke.log == number
    ]
    return float(np.median(lengths))


def without_parts(selection: Selection, is_left_out: Mask, reason: int) -> Selection:
    """Return a selection without some parts of strokes.

    Args:
        selection: The selection.
        is_left_out: True for the parts that are left out, (parts,).
        reason: Code of the reason.
    """
    codes = []
    parts = selection.parts
    for place, (stroke, before) in enumerate(zip(selection.strokes, selection.codes, strict=True)):
        of_stroke = parts.stroke == place
        code = before.copy()
        if np.any(of_stroke & is_left_out):
            angle = selection.logs[stroke.log].elbow_angle[stroke.rows]
            is_near = _near(angle, parts.angle[of_stroke], is_left_out[of_stroke])
            code[is_near & (code == USED)] = reason
        codes.append(code)
    kept = parts.select(~is_left_out)
    return Selection(
        selection.logs, selection.every, selection.strokes, tuple(codes), kept, selection.notes
    )


def _near(angle: Floats, middles: Floats, is_marked: Mask) -> Mask:
    """Return True for rows whose nearest part is marked."""
    nearest = np.argmin(np.abs(angle[:, np.newaxis] - middles), axis=1)
    return np.asarray(is_marked[nearest])
