"""Checks of a suit's log against its study: signs, units and exchanged columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tendon_cli import say
from tendon_cli.errors import InputError
from tendon_cli.fits.log_rows import Floats
from tendon_cli.fits.suit.log_columns import COUNTS, ELBOW_ANGLE, MOTOR_TORQUE, SPOOL_ANGLE, TIME
from tendon_cli.fits.suit.parameters import LOAD, loads_of_study, range_of
from tendon_cli.fits.suit.stroke_parts import LogStroke, Parts
from tendon_cli.fits.suit.suit_log import SuitLog
from tendon_cli.fits.suit.suit_model import SuitModel
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.study import Study

_OPPOSITE = -0.5
"""Correlation of joint and spool under which one of them has the wrong sign: in a fast log inertia
may turn the spool against the joint for a while."""
_OTHER_SUIT = 2.0
"""Factor between measured and expected ways of the spool, from which the log is of another suit."""
_OTHER_COUNTS = 1.8
"""The same for a spool in counts, which are often wrong by a factor of 2 or 4."""
_OTHER_TORQUE = 5.0
"""Factor between measured and expected ranges of the torque, from which its unit is wrong."""
_BESIDE = math.radians(20.0)
"""Angle by which a log may leave the range of the study's motion."""
_MOST_BESIDE = 0.5
"""Share of the log's range beyond that, from which the joint's angle is counted otherwise."""
_SHAPE = 5
"""Number of terms of the polynomial over the angle that both directions share."""
_DURATION = (0.1, 600.0)
"""Least and largest duration of a stroke, s."""


def check_log(study: Study, log: SuitLog) -> None:
    """Refuse a log whose joint's angle is not the study's, or whose spool has the wrong sign.

    Raises:
        InputError: if an angle cannot be of this suit.
    """
    spool = log.channels.get(SPOOL_ANGLE)
    falls = spool is not None and np.corrcoef(log.elbow_angle, spool)[0, 1] < _OPPOSITE
    if falls:
        _check_range(study, log)
        raise InputError(
            "the spool's angle falls as the joint flexes",
            where=log.source,
            hint="positive angles flex the joint and wind the flexor: turn one column's sign",
        )


def check_durations(logs: Sequence[SuitLog], strokes: Sequence[LogStroke]) -> None:
    """Refuse a time in the wrong unit, by how long the strokes take.

    Raises:
        InputError: if a stroke takes less than a tenth of a second, or more than ten minutes.
    """
    low, high = _DURATION
    for number, log in enumerate(logs):
        if log.time is None:
            continue
        times = [one.rows.time for one in strokes if one.log == number]
        taken = [float(np.ptp(time)) for time in times if time is not None]
        usual = float(np.median(taken)) if taken else low
        if low <= usual <= high:
            continue
        column = log.headings.get(TIME)
        shown = "the time" if column is None else column.shown
        unit = "s" if column is None or column.dimension != "time" else column.unit
        problem = f"a stroke takes {say.number(usual, 3)} s, as {shown} is read in {unit}"
        hint = f"expected {low:g} to {high:g} s; is the unit right?"
        if column is not None and not column.unit:
            hint = f'expected {low:g} to {high:g} s; is it "{column.header} (ms)"?'
        raise InputError(problem, where=log.source, hint=hint)


def note_on_load(study: Study, log: SuitLog) -> list[str]:
    """Return a note on a log that does not say its load, which is then the study's.

    Raises:
        InputError: if the study has several loads, and none of them is the log's.
    """
    if log.load_mass is not None:
        return []
    loads = loads_of_study(study)
    stated = study.numbers[LOAD]
    mass = QUANTITIES["load_mass"]
    if len(loads) > 1:
        few = [say.quantity(mass, value) for value in loads[:6].tolist()]
        problem = f"no column of the load, and the study has several: {say.join_words(few, 'or')}"
        hint = 'add a column "load_mass (kg)"'
        if stated.is_axis:
            hint += ", or say which load the log was taken with: --set"
            hint += f" 'load.mass=\"{few[-1]}\"'"
        raise InputError(problem, where=log.source, hint=hint)
    value = say.quantity(mass, float(loads[0]))
    if stated.uncertain is not None:
        value = "one load, which is fitted"
    text = (
        f"{log.source}: no column of the load, so all of it was taken with {value}, the study's"
        ' load.mass; if that is wrong, add a column "load_mass (kg)"'
    )
    return [text]


def check_motion(model: SuitModel, parts: Parts, logs: Sequence[SuitLog]) -> None:
    """Refuse logs in which columns are exchanged, or have the wrong sign or unit.

    Raises:
        InputError: if the columns cannot be of this suit.
    """
    middle = np.zeros((1, len(model.parameters)))
    if SPOOL_ANGLE in parts.values:
        slope = float(np.polyfit(parts.angle, parts.values[SPOOL_ANGLE], 1)[0])
        low, high = model.study.motion.elbow_angle.extremes
        usual_parts = replace(parts, angle=np.linspace(low, high, len(parts)))
        expected = model.predict(middle, usual_parts, (SPOOL_ANGLE,))[0, 0]
        usual = float(np.polyfit(usual_parts.angle, expected, 1)[0])
        _check_slope(model.study, slope, usual, logs[0])
    for log in logs:
        _check_range(model.study, log)
    if MOTOR_TORQUE in parts.values:
        shown = model.predict(middle, parts, (MOTOR_TORQUE,))[0, 0]
        _check_torque(parts, shown, logs[0])


def _check_range(study: Study, log: SuitLog) -> None:
    """Refuse a joint's angle that lies mostly beside the motion of the study."""
    low, high = study.motion.elbow_angle.extremes
    angle = log.elbow_angle

    def beside(angles: Floats) -> float:
        """Return the share of the log's range that lies beside the study's motion."""
        first, last = np.quantile(angles, (0.02, 0.98))
        within = min(last, high + _BESIDE) - max(first, low - _BESIDE)
        return 1.0 - float(within / (last - first))

    if beside(angle) <= _MOST_BESIDE:
        return
    first, last = np.degrees(np.quantile(angle, (0.02, 0.98)))
    column = log.headings.get(ELBOW_ANGLE)
    shown = "the joint" if column is None else column.shown
    problem = (
        f"{shown} goes from {first:.0f} to {last:.0f} deg, the study's motion from"
        f" {math.degrees(low):.0f} to {math.degrees(high):.0f} deg"
    )
    hint = "is the unit right, and 0 deg where the study has it?"
    if beside(-angle) <= _MOST_BESIDE:
        hint = "flexion is positive: turn the column's sign"
    elif beside(math.pi - angle) <= _MOST_BESIDE:
        hint = "the study counts 0 deg when the joint is straight: log 180 deg less this angle"
    elif column is not None and column.unit == COUNTS:
        hint = "is fit.counts_per_turn right, and 0 where the study has it?"
    raise InputError(problem, where=log.source, hint=hint)


def _check_slope(study: Study, slope: float, usual: float, log: SuitLog) -> None:
    """Refuse a way of the spool per way of the joint that is not this suit's.

    Args:
        study: Study of the suit.
        slope: Way of the spool per way of the joint, measured.
        usual: The same by the study.
        log: First of the logs.
    """
    if min(usual, slope) <= 0.0:
        return
    column = log.headings.get(SPOOL_ANGLE)
    counts = study.fit.counts_per_turn
    is_counted = column is not None and column.unit == COUNTS and counts is not None
    away = abs(math.log(slope / usual))
    least = _OTHER_COUNTS if is_counted else _OTHER_SUIT
    if away < math.log(least):
        return
    problem = f"the spool turns {slope:.3g} times as far as the joint, the study says {usual:.3g}"
    hint = "is the spool's radius right, and does the angle count the spool, not its motor?"
    if is_counted and counts is not None:
        better = counts.single * slope / usual
        hint = (
            f"is fit.counts_per_turn = {counts.single:g} right, at the spool and not at its motor?"
            f" About {say.number(better, 2)} would suit the study"
        )
    elif abs(math.log(slope * usual)) < math.log(2.0):
        hint = "are the columns of joint and spool exchanged?"
    elif away > 0.7 * math.log(math.degrees(1.0)):
        hint = "is one of the angles in degrees, the other in radians?"
    raise InputError(problem, where=log.source, hint=hint)


def _check_torque(parts: Parts, expected: Floats, log: SuitLog) -> None:
    """Refuse a torque with the wrong sign, with which friction would help, or in another unit."""
    torque = parts.values[MOTOR_TORQUE]
    band = _band(parts, torque)
    usual = _band(parts, expected)
    agreement = float(np.corrcoef(torque, expected)[0, 1])
    if band < 0.0 and agreement < 0.0 and usual > 0.0:
        raise InputError(
            "the torque is larger in extension than in flexion: friction would help",
            where=log.source,
            hint="positive torque pulls the flexor: turn the column's sign",
        )
    swing = range_of(torque)
    least = range_of(expected)
    if min(swing, least) <= 0.0 or abs(math.log(swing / least)) < math.log(_OTHER_TORQUE):
        return
    problem = (
        f"the torque swings over {say.number(swing, 3)} N m, by the study over about"
        f" {say.number(least, 2)} N m"
    )
    column = log.headings.get(MOTOR_TORQUE)
    hint = "is the unit right, and is it the torque at the spool, behind the gear?"
    if column is not None and column.unit in ("A", "mA"):
        hint = "is fit.torque_constant right, at the spool behind the gear?"
    raise InputError(problem, where=log.source, hint=hint)


def _band(parts: Parts, values: Floats) -> float:
    """Return the mean of a channel in flexion above that in extension, at the same angles."""
    columns = [*np.vander(parts.angle - parts.angle.mean(), _SHAPE).T, parts.sign]
    solved, *_ = np.linalg.lstsq(np.stack(columns, axis=1), values, rcond=None)
    return 2.0 * float(solved[-1])
