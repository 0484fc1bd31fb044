"""Logs of a suit: rows of a joint angle and of what the motor and the tendons showed, in SI."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.errors import InputError, UsageError
from tendon_cli.fits.log_rows import Floats, Integers, LogRows, spikes
from tendon_cli.fits.suit.log_columns import (
    CHANNELS,
    COLUMNS,
    COUNTS,
    ELBOW_ANGLE,
    LOAD_MASS,
    MOTOR_TORQUE,
    SPOOL_ANGLE,
    TIME,
    columns_by_role,
    is_wished,
    si_factor,
)
from tendon_cli.fits.suit.parameters import range_of
from tendon_cli.quantities import PLAUSIBLE
from tendon_cli.readers.clock import first_back
from tendon_cli.readers.heading import Heading
from tendon_cli.readers.table import Table, read_table
from tendon_cli.say import join_words, spaced
from tendon_cli.studies.fit_section import Fitting
from tendon_cli.units import UnitError, counted, factor_of, parse_measure, shorten

_LEAST_ROWS = 40
"""Least number of usable rows of a log."""
_COMMANDED = re.compile(r"command|desired|nominal|set[ _-]?point|soll", re.IGNORECASE)
_SPIKE_SHARE = 0.01
"""Least distance of a spike from the median of its neighbours, as a share of the range."""
_LARGEST_ANGLE = 7.0
"""Largest angle of a joint, rad: more is an angle in degrees."""
_LEAST_MOTION = np.radians(5.0)
"""Least range of the joint, rad."""
_ADVICE = (
    "log the joint angle, the spool's angle and the measured torque of the motor, both directions,"
    " with two or more loads"
)

_NAMING = '[fit.columns] in the study names other headers, such as elbow_angle = "Enc1 (deg)"'


@dataclass(frozen=True, eq=False)
class SuitLog(LogRows):
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
    place: Floats
    """Place in the log in time, 0 to 1."""
    missing: int
    """Number of rows left out for a missing number."""
    headings: Mapping[str, Heading]
    """Columns of the file that are read, by what they give."""
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.elbow_angle)


def read_logs(sources: Sequence[Any], section: Fitting) -> tuple[SuitLog, ...]:
    """Read the logs of a suit.

    Args:
        sources: Paths of CSVs, DataFrames or mappings of names to arrays.
        section: Section of the study: headers of columns, torque constant, counts per turn.

    Raises:
        InputError: if a log is wrong, or cannot tell anything about a suit.
        UsageError: if the study lacks what a column needs.
    """
    logs = []
    named = section.columns.named
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
        logs.append(_suit_log(table, columns, section))
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


def _suit_log(table: Table, columns: Mapping[str, Heading | None], section: Fitting) -> SuitLog:
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
        values[role] *= si_factor(table, column, role, section)
        if role in (ELBOW_ANGLE, SPOOL_ANGLE):
            values[role] = table.unwrapped(column, values[role], 2.0 * np.pi)
    table.raise_faults()
    notes = [*table.unread([*columns.values()]), *table.notes]
    source = table.source
    lacking = [headings[role].shown for role in values if not np.isfinite(values[role]).all()]
    known = np.all(np.isfinite([*values.values()]), axis=0)
    missing = int(np.count_nonzero(~known))
    if missing:
        notes.append(
            f"{source}: {counted(missing, 'row')} of {len(known):,} left out, without a"
            f" number in {join_words(lacking)}"
        )
    if known.sum() < _LEAST_ROWS:
        raise InputError(
            f"{counted(int(known.sum()), 'row')} with a number in every column that is read",
            where=source,
            hint=f"expected {_LEAST_ROWS} or more",
        )
    load = values.get(LOAD_MASS, _load_of_comments(table, len(known)))
    log = SuitLog(
        source=source,
        sha256=table.sha256,
        line=table.lines,
        elbow_angle=values[ELBOW_ANGLE],
        channels={role: values[role] for role in CHANNELS if role in values},
        time=values.get(TIME),
        load_mass=load,
        place=np.zeros(len(known)),
        missing=missing,
        headings=headings,
    ).select(known)
    is_spike = np.zeros(len(log), dtype=bool)
    for measured in (log.elbow_angle, *log.channels.values()):
        is_spike |= spikes(measured, _SPIKE_SHARE * float(np.ptp(measured)))
    if is_spike.any():
        found = counted(int(is_spike.sum()), "row")
        notes.append(f"{source}: {found} far from both neighbours left out")
        log = log.select(~is_spike)
    place = np.arange(len(log)) / len(log)
    if log.time is not None:
        lasts = float(np.ptp(log.time))
        place = (log.time - log.time[0]) / max(lasts, 1e-12)
        if not time_unit:
            notes.append(
                f"{source}: {headings[TIME].shown} has no unit, so it is read in seconds: the log"
                f" takes {say.number(lasts, 3)} s"
            )
    _check_values(log)
    return replace(log, place=place, notes=tuple(notes))


def _check_values(log: SuitLog) -> None:
    """Refuse values that no log of a suit has, and a time that goes back."""
    headings = log.headings
    back = None if log.time is None else first_back(log.time)
    if back is not None:
        row, problem = back
        hint = "give one log per file, its rows in order of time"
        raise InputError(problem, where=f"{log.source}, line {log.line[row]}", hint=hint)
    if log.load_mass is not None and LOAD_MASS in headings:
        low, high = PLAUSIBLE["load_mass"]
        worst = log.load_mass[np.argmax(np.abs(log.load_mass))]
        least = log.load_mass.min()
        if least < low or worst > high:
            shown = say.number(float(least if least < low else worst), 4)
            hint = f"expected {low:g} to {high:g} kg"
            if worst > high:
                hint += "; are these grams?"
            problem = f"{headings[LOAD_MASS].shown} has a load of {shown} kg"
            raise InputError(problem, where=log.source, hint=hint)
    _check_angle(log.source, headings[ELBOW_ANGLE], log.elbow_angle)
    for role, channel in log.channels.items():
        if np.ptp(channel) <= 1e-9 * np.max(np.abs(channel), initial=1e-12):
            raise InputError(
                f"{headings[role].shown} is the same in every row",
                where=log.source,
                hint="is it connected, and the right column?",
            )


def _check_angle(source: str, column: Heading, angle: Floats) -> None:
    """Refuse an angle that no joint has, and one that hardly changes."""
    if np.max(np.abs(angle)) > _LARGEST_ANGLE:
        problem = f"{column.shown} reaches {np.max(np.abs(angle)):.4g} rad, which no joint does"
        hint = "is the unit right?"
        if column.unit == "rad":
            hint = "are these degrees?"
        elif column.unit == COUNTS:
            hint = "is fit.counts_per_turn right?"
        raise InputError(problem, where=source, hint=hint)
    span = range_of(angle)
    if span < _LEAST_MOTION:
        problem = (
            f"{column.shown} moves by {np.degrees(span):.2g} deg alone, expected 5 deg or more"
        )
        is_degrees = column.unit == "deg" and 0.05 < np.degrees(span) < 4.0
        hint = "are these radians?" if is_degrees else "move the joint through most of its range"
        raise InputError(problem, where=source, hint=hint)


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
    reasons += [
        f'"{shorten(column.header, 40)}" was asked for or derived, not measured'
        for column in table.columns
        if is_wished(column)
    ]
    said = " ".join(table.comments)
    if _COMMANDED.search(said) and columns[MOTOR_TORQUE] is not None:
        reasons.append("its first lines say that the torque was commanded, not measured")
    if columns[SPOOL_ANGLE] is None and measured:
        reasons.append("it has no spool angle")
    raise InputError(
        f"cannot tell: {'; '.join(reasons)}", where=table.source, hint=f"{_ADVICE}; {_NAMING}"
    )
