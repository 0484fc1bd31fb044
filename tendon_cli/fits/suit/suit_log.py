"""Logs of a suit: rows of a joint angle and of what the motor and the tendons showed, in SI."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.errors import InputError, UsageError
from tendon_cli.fits.log_rows import Floats, Integers, spikes
from tendon_cli.fits.suit.log_checks import check_values, note_on_time
from tendon_cli.fits.suit.log_columns import (
    CHANNELS,
    COLUMNS,
    ELBOW_ANGLE,
    LOAD_MASS,
    MOTOR_TORQUE,
    SPOOL_ANGLE,
    TIME,
    Scaling,
    columns_by_role,
    si_factor,
    wished_columns,
)
from tendon_cli.readers.heading import Heading
from tendon_cli.readers.table import Table, read_table
from tendon_cli.say import join_words, spaced
from tendon_cli.units import UnitError, counted, factor_of, parse_measure, shorten

_LEAST_ROWS = 40
"""Least number of usable rows of a log."""
_COMMANDED = re.compile(r"command|desired|nominal|set[ _-]?point|soll", re.IGNORECASE)
_SPIKE_SHARE = 0.01
"""Least distance of a spike from the median of its neighbours, as a share of the range."""
_ADVICE = (
    "log the joint angle, the spool's angle and the measured torque of the motor, both directions,"
    " with two or more loads"
)

_NAMING = '[fit.columns] in the study names other headers, such as elbow_angle = "Enc1 (deg)"'


@dataclass(frozen=True, eq=False)
class SuitLog:
    """Rows of one log in their order; a row without a number in any column is left out."""

    source: str
    sha256: str
    line: Integers
    """Line of each row in the file."""
    elbow_angle: Floats
    """Angle of the joint θ, rad."""
    channels: Mapping[str, Floats]
    """Measured values, by their name in CHANNELS, SI."""
    time: Floats | None
    """Time, s; None if the log has none."""
    load_mass: Floats | None
    """Mass of the load, kg; None if the log has no column of it."""
    missing: int
    """Number of rows left out for a missing number."""
    notes: tuple[str, ...] = field(default=())
    headings: Mapping[str, Heading] = field(default_factory=dict)
    """Columns of the file that are read, by what they give."""

    def __len__(self) -> int:
        return len(self.elbow_angle)


def read_logs(
    sources: Sequence[Any], named: Mapping[str, str], scaling: Scaling
) -> tuple[SuitLog, ...]:
    """Read the logs of a suit.

    Args:
        sources: Paths of CSVs, DataFrames or mappings of names to arrays.
        named: Headers that the study names, by column.
        scaling: Torque constant and counts per turn of the study.

    Raises:
        InputError: if a log is wrong, or cannot tell anything about a suit.
        UsageError: if the study lacks what a column needs.
    """
    logs = []
    for number, source in enumerate(sources):
        table = _table_of(source, named, f"log {number + 1}")
        by_role = columns_by_role(table.columns, named)
        for role in named:
            if role not in by_role:
                raise UsageError(
                    f'there is no column "{shorten(named[role])}" in {table.source}',
                    where=f"fit.columns.{role}",
                    hint=f"the columns are {table.shown}",
                )
        columns = {role: table.only(by_role.get(role, []), spaced(role)) for role in COLUMNS}
        _refuse_blind(table, columns)
        logs.append(_suit_log(table, columns, scaling))
    first = logs[0]
    for log in logs[1:]:
        if set(log.channels) != set(first.channels):
            differing = min(set(log.channels) ^ set(first.channels))
            raise InputError(
                f"only one of {first.source} and {log.source} has the column {differing}",
                where=log.source,
                hint="fit logs of one kind together",
            )
    return tuple(logs)


def _table_of(given: Any, named: Mapping[str, str], source: str) -> Table:
    """Return the columns of a log; refuse one in which no header is known."""
    headers = {role: header for role, header in named.items() if not header.strip().isdecimal()}

    def known(columns: Sequence[Heading]) -> list[Heading]:
        """Return the columns that are read of a line that names an angle or anything measured."""
        by_role = columns_by_role(columns, headers)  # every line has a column of a number
        if not any(by_role.get(role) for role in (ELBOW_ANGLE, *CHANNELS)):
            return []
        return [column for role in COLUMNS for column in by_role.get(role, [])]

    is_file = isinstance(given, Path)
    table = read_table(given, known, source="" if is_file else source)
    if is_file and not table.has_header and not named:
        shown = f"the columns are {table.shown}"
        raise InputError(
            f"no header names an angle, a torque or a tension of a suit; {shown}",
            where=table.place(),
            hint='call them "elbow_angle (deg)", "spool_angle (rad)", "motor_torque (N m)", or name'
            ' them: [fit.columns] elbow_angle = "Enc1 (deg)"',
        )
    return table


def _suit_log(table: Table, columns: Mapping[str, Heading | None], scaling: Scaling) -> SuitLog:
    """Return the log of a table, its rows checked."""
    values: dict[str, Floats] = {}
    headings = {role: column for role, column in columns.items() if column is not None}
    time_unit = ""
    for role, column in headings.items():
        if role == TIME:
            times, time_unit = table.times(column, may_lack=True)
            values[role] = times * factor_of(time_unit)
            if not time_unit and column.unit:
                table.unit_of(column, "time")
            continue
        values[role] = table.numbers(column, may_lack=True)
        values[role] *= si_factor(table, column, role, scaling)
        if role in (ELBOW_ANGLE, SPOOL_ANGLE):
            values[role] = table.unwrapped(column, values[role], 2.0 * np.pi)
    table.raise_faults()
    notes = [*table.unread([*columns.values()]), *table.notes]
    is_number = {role: np.isfinite(column) for role, column in values.items()}
    known = np.all(list(is_number.values()), axis=0)
    missing = int(np.count_nonzero(~known))
    if missing:
        lacking = [headings[role].shown for role, mask in is_number.items() if not mask.all()]
        notes.append(
            f"{table.source}: {counted(missing, 'row')} of {len(known):,} left out, without a"
            f" number in {join_words(lacking)}"
        )
    if known.sum() < _LEAST_ROWS:
        raise InputError(
            f"{counted(int(known.sum()), 'row')} with a number in every column that is read",
            where=table.source,
            hint=f"expected {_LEAST_ROWS} or more",
        )
    values = {role: column[known] for role, column in values.items()}
    lines = table.lines[known]
    is_spike = np.zeros(len(lines), dtype=bool)
    for role, measured in values.items():
        if role not in (TIME, LOAD_MASS):
            is_spike |= spikes(measured, _SPIKE_SHARE * float(np.ptp(measured)))
    if is_spike.any():
        found = counted(int(is_spike.sum()), "row")
        notes.append(f"{table.source}: {found} far from both neighbours left out")
        values = {role: column[~is_spike] for role, column in values.items()}
        lines = lines[~is_spike]
    if TIME in headings and not time_unit:
        notes.append(note_on_time(table.source, headings[TIME], values[TIME]))
    check_values(table.source, headings, values, lines)
    return SuitLog(
        source=table.source,
        sha256=table.sha256,
        line=lines,
        elbow_angle=values[ELBOW_ANGLE],
        channels={role: values[role] for role in CHANNELS if role in values},
        time=values.get(TIME),
        load_mass=values.get(LOAD_MASS, _load_of_comments(table, len(lines))),
        missing=missing,
        notes=tuple(notes),
        headings=headings,
    )


def _load_of_comments(table: Table, rows: int) -> Floats | None:
    """Return the load that a comment above the header states, such as "# load_mass = 2 kg"."""
    for comment in table.comments:
        match = re.search(r"load[ _]?mass\s*[=:]\s*([0-9.]+\s*\w+)", comment)
        if match is None:
            continue
        with suppress(UnitError):
            return np.full(rows, parse_measure(match[1], "mass").si)
    return None


def _refuse_blind(table: Table, columns: Mapping[str, Heading | None]) -> None:
    """Refuse a log that cannot tell anything about a suit, with all reasons."""
    reasons = []
    if columns[ELBOW_ANGLE] is None:
        shown = ", ".join(column.shown for column in table.columns[:8])
        reasons.append(
            "it has no joint angle, so nothing says what the tendons did to the arm (its columns"
            f" are {shown})"
        )
    measured = [role for role in CHANNELS if columns[role] is not None]
    if not measured:
        reasons.append("it has no spool angle, motor torque or tension that was measured")
    if not reasons:
        return
    wished = wished_columns(table.columns)
    reasons += [f'"{name}" was asked for or derived, not measured' for name in wished]
    said = " ".join(table.comments)
    if _COMMANDED.search(said) and columns[MOTOR_TORQUE] is not None:
        reasons.append("its first lines say that the torque was commanded, not measured")
    if columns[SPOOL_ANGLE] is None and measured:
        reasons.append("it has no spool angle")
    raise InputError(
        f"cannot tell: {'; '.join(reasons)}", where=table.source, hint=f"{_ADVICE}; {_NAMING}"
    )
