"""Remarks on a suit's fit: what is wrong or left over, what may cause it, and a way out."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tendon_cli import say
from tendon_cli.fits.log_rows import Floats
from tendon_cli.fits.suit import parameters as names
from tendon_cli.fits.suit.fitted_numbers import FittedNumber
from tendon_cli.fits.suit.log_columns import MOTOR_TORQUE, SPOOL_ANGLE
from tendon_cli.fits.suit.stroke_parts import Selection
from tendon_cli.fits.suit.suit_estimate import SuitEstimate
from tendon_cli.studies.fit_section import BACKLASH

_MOST_MISFIT = {SPOOL_ANGLE: 0.0012, MOTOR_TORQUE: 0.003}
"""Smooth misfit of a channel, as a share of its range, from which the model is said not to hold."""
_MOST_OF_OTHERS = 0.006
_MORE_TORQUE = 0.1
"""Torque beyond what the stated loads ask for, as a share, from which it is said."""
_ZERO_SHARE = 0.02
"""Zero of the torque over its range from which it is said."""
_NAMED = 0.35
"""Share of what is left over that a cause explains, from which it is named."""
_AS_WELL = 0.75
"""Share of what the best cause explains, from which another one may be it as well."""
_CERTAIN = 9.0
"""Fall of the misfit's square, in its own units, from which a cause is more than chance."""
_NAMED_ALONE = (
    names.GEAR_FRICTION,
    names.GEAR_EFFICIENCY,
    BACKLASH,
    names.SPOOL_DELAY,
    names.TORQUE_DELAY,
    names.TORQUE_ZERO,
    names.INERTIA_SHARE,
)
"""Errors of sensors that have warnings of their own."""
_FAR = 2.2
"""Normal score from which a stated number is said to be off."""
_NO_SUIT = 0.05
"""Misfit of a channel, as a share of its range, from which its numbers are not to be used."""
_OTHER_NUMBER = 3.5
"""Normal score of a number of arm, load or sensor, from which the log is of another suit."""
_LATE = 0.015
"""Delay from which a channel is said to be late, s."""
_PLAY = math.radians(0.4)
"""Backlash that is named, rad."""
_FAST = 0.02
"""Torque for inertia over the range of the torque, from which a log is fast."""
_LOSES = 0.03
"""Share of the torque that a gear loses, from which it is said."""
_SLACK_SHARE = 0.02
_DELAY_OF = {SPOOL_ANGLE: names.SPOOL_DELAY, MOTOR_TORQUE: names.TORQUE_DELAY}
_AT_END = 2.2
"""Normal score at which a number lies at the end of its stated range."""


def warnings_of(
    estimate: SuitEstimate, selection: Selection, numbers: Sequence[FittedNumber]
) -> list[str]:
    """Return all warnings of a fit."""
    found = _doubts(estimate, numbers)
    for row, channel in enumerate(estimate.channels):
        share = smooth_misfit(estimate, channel)
        causes = _causes(estimate, row, channel)
        if causes or share >= _MOST_MISFIT.get(channel, _MOST_OF_OTHERS):
            found.append(_misfit_text(say.spaced(channel), share, causes))
    found += _number_warnings(numbers)
    found += _sensor_warnings(numbers)
    return found + _row_warnings(estimate, selection)


def _doubts(estimate: SuitEstimate, numbers: Sequence[FittedNumber]) -> list[str]:
    """Return the one warning that comes first: log and study are not of one suit."""
    shares = {channel: smooth_misfit(estimate, channel) for channel in estimate.channels}
    channel = max(shares, key=shares.__getitem__)
    reasons = []
    if shares[channel] > _NO_SUIT:
        reasons.append(
            f"no suit like the study's moves so, the {say.spaced(channel)} is off by"
            f" {say.percent(shares[channel])} of its swing"
        )
    known = [
        number
        for number in numbers
        if " to " not in number.prior
        and number.log is None
        and number.key not in _DELAY_OF.values()  # a delay is told and allowed for
    ]
    worst = max(known, key=lambda number: abs(number.score), default=None)
    if worst is not None and abs(worst.score) > _OTHER_NUMBER:
        reasons.append(
            f"{worst.key} would have to be {worst.text(worst.value)},"
            f" {abs(worst.score):.1f} standard deviations from {worst.prior}"
        )
    if not reasons:
        return []
    checks = ["units", "signs", _loads_text(estimate), "the spool's radius"]
    if estimate.model.study.fit.counts_per_turn is not None:
        checks.append("counts per turn")
    return [f"do not use these numbers: {'; '.join(reasons)}. First check {say.join_words(checks)}"]


def _loads_text(estimate: SuitEstimate) -> str:
    """Return the loads as something to check, with the one that stands for a missing column."""
    if not np.isnan(estimate.parts.load).any():
        return "loads"
    taken = f"{say.number(estimate.model.load_of_study, 3)} kg"
    if estimate.model.study.numbers[names.LOAD].uncertain is not None:
        taken = "one load"
    return f"the load (no column: {taken} throughout)"


def smooth_misfit(estimate: SuitEstimate, channel: str) -> float:
    """Return the misfit of a channel that is no noise, as a share of its range."""
    sizes = estimate.misfit.sizes[estimate.channels.index(channel)]
    return float(math.sqrt(np.sum(np.square(sizes[1:]))))


def _misfit_text(name: str, share: float, causes: Sequence[str]) -> str:
    """Return a warning on what a channel leaves over, with all causes that the log does not part.

    Args:
        name: Name of the channel.
        share: Size of the misfit, as a share of its swing.
        causes: Causes, the one that explains most first.
    """
    size = say.percent(share)
    if not causes:
        return (
            f"the {name} is {size} of its swing away from what any such suit would show: the"
            " numbers may be off by more than their intervals; check geometry, loads and sensors"
        )
    if len(causes) == 1:
        return f"the residual of the {name}, {size} of its swing, {causes[0]}"
    return (
        f"the residual of the {name}, {size} of its swing, has one of these causes, which the log"
        f" cannot tell apart: it {'; or it '.join(causes)}"
    )


def _causes(estimate: SuitEstimate, row: int, channel: str) -> list[str]:
    """Return the causes that explain what a channel leaves over, the best first.

    Each is fitted to the misfit in units of its noise, with the parameters let go, too; one of
    several columns must explain more by as much as chance would.
    """
    parts = len(estimate.parts)
    block = slice(row * parts, (row + 1) * parts)
    noise = estimate.misfit.deviation(channel, "white")
    few = np.sqrt(np.median(estimate.parts.count) / estimate.parts.count)
    weight = 1.0 / (noise * few)
    slopes = estimate.slopes[block] * weight[:, np.newaxis]
    left = estimate.residual[row] * weight
    projector = np.linalg.inv(slopes.T @ slopes + np.eye(slopes.shape[1]))

    def freed(columns: Floats) -> Floats:
        """Return columns less what the parameters can explain of them."""
        return columns - slopes @ (projector @ (slopes.T @ columns))

    total = float(freed(left[:, np.newaxis])[:, 0] @ left)
    explained = {}
    for words, pattern in _patterns(estimate, row, channel):
        columns = np.stack(pattern, axis=1) * weight[:, np.newaxis]
        count = len(pattern)
        free = freed(columns)
        normal = columns.T @ free + 1e-9 * np.eye(count) * np.trace(columns.T @ columns)
        gain = float((free.T @ left) @ np.linalg.solve(normal, free.T @ left))
        by_chance = count * total / max(parts - 1, 1)
        share = (gain - by_chance) / max(total, 1e-300)
        if gain > _CERTAIN + 2.0 * count and share > _NAMED:
            explained[words] = share
    best = max(explained.values(), default=0.0)
    causes = [words for words, share in explained.items() if share >= _AS_WELL * best]
    return sorted(causes, key=lambda words: -explained[words])


def _patterns(estimate: SuitEstimate, row: int, channel: str) -> list[tuple[str, list[Floats]]]:
    """Return what a channel's residual may show, in words with the cause, and its columns."""
    parts = estimate.parts
    sign = parts.sign
    speed = np.abs(parts.speed)
    place = parts.place - 0.5
    flexor, extensor = np.nan_to_num(
        estimate.model.predict(
            estimate.scores[np.newaxis], parts, ("flexor_tension_distal", "extensor_tension_distal")
        )[0]
    )
    drifts = []
    waves = []
    for log in np.unique(parts.log):
        in_log = parts.log == log
        drifts.append(np.where(in_log, place, 0.0))
        for turns in (1.0, 2.0):
            phase = 2.0 * math.pi * turns * parts.place
            waves += [np.where(in_log, wave, 0.0) for wave in (np.sin(phase), np.cos(phase))]
    found = [
        ("drifts over the log: the pretension falls or a sensor warms up; let it settle", drifts),
        (
            (
                "wanders slowly: the wearer helps or the upper arm moves; ask the wearer to relax"
                " and support the arm"
            ),
            waves,
        ),
        (
            (
                "bends with tension: the tissue or a spring stiffens as it is pulled; fit loads"
                " near those in use"
            ),
            [np.square(tension - tension.mean()) for tension in (flexor, extensor)],
        ),
        (
            (
                "follows the direction: there is backlash between motor and joint; tighten it, or"
                " measure at the spool"
            ),
            [sign],
        ),
        (
            (
                "follows the direction and the tension of one side: one sheath has more friction"
                " than the other; state sheath.friction per side"
            ),
            [sign * extensor],
        ),
    ]
    if np.ptp(speed) > 0.05 * max(float(speed.max()), 1e-12):
        words = (
            "grows with speed: the gear has viscous friction, or friction depends on speed; move"
            " more slowly"
        )
        found.append((words, [sign * (speed - speed.mean())]))
    delay = estimate.model.places.get(_DELAY_OF.get(channel, ""))
    if delay is not None:
        late = estimate.slopes[row * len(parts) : (row + 1) * len(parts), delay]
        words = "is late by more and more: the clocks part; give the channels one clock"
        found.append((words, [late * place]))
    return found


def _number_warnings(numbers: Sequence[FittedNumber]) -> list[str]:
    """Return warnings on numbers at the end of their range, or far from what is stated."""
    found = []
    for number in numbers:
        is_range = " to " in number.prior
        far = _AT_END if is_range else _FAR
        if number.log is not None or number.key in _NAMED_ALONE or abs(number.score) < far:
            continue
        value = number.text(number.value)
        where = f"{value}, {abs(number.score):.1f} standard deviations from {number.prior}: measure"
        if is_range:
            where = f"the end of its range, {value} in {number.prior}: widen"
        found.append(
            f"{number.key} comes out {'at' if is_range else 'as'} {where}"
            f" {'the range' if is_range else 'it'}, or something else is wrong"
        )
    return found


def _sensor_warnings(numbers: Sequence[FittedNumber]) -> list[str]:
    """Return warnings on errors of sensors which the fit allows for."""
    by_key = {number.key: number for number in numbers}
    found = []
    for key, name in ((names.SPOOL_DELAY, "spool's angle"), (names.TORQUE_DELAY, "torque")):
        number = by_key.get(key)
        if number is not None and abs(number.value) > max(_LATE, 3.0 * number.std):
            way = "late" if number.value > 0.0 else "early"
            found.append(
                f"the {name} is {1e3 * abs(number.value):.0f} ms {way} against the joint's angle,"
                " which the fit allows for: give the channels one clock"
            )
    play = by_key.get(BACKLASH)
    if play is not None and abs(play.value) > max(_PLAY, 3.0 * play.std):
        cause = ": there is backlash"
        if play.value < 0.0:
            cause = (
                "; backlash cannot be negative: is one clock late, or are the two directions"
                " zeroed separately?"
            )
        found.append(
            f"the spool differs by {say.number(math.degrees(play.value), 2)} deg between the"
            f" directions beyond what stretch explains, which the fit allows for{cause}"
        )
    gain = by_key.get(names.TORQUE_GAIN)
    loads = [number for number in numbers if number.unit == "kg" and number.is_sensor]
    if gain is not None and loads:
        heavier = [number.value / number.law.middle - 1.0 for number in loads]
        more = gain.value + float(np.mean(heavier))
        if abs(more) > _MORE_TORQUE:
            way = "more" if more > 0.0 else "less"
            found.append(
                f"the motor shows {say.percent(abs(more))} {way} torque than the stated loads need,"
                " which the fit allows for: weigh the loads and calibrate the torque constant"
            )
    zero = by_key.get(names.TORQUE_ZERO)
    if zero is not None:
        span = zero.std / max(math.sqrt(1.0 - min(zero.learned, 0.999999)), 1e-6)
        least = _ZERO_SHARE * span / names.TORQUE_ZERO_SHARE
        if abs(zero.value) > max(least, 2.5 * zero.std):
            found.append(
                f"the torque is {zero.text(zero.value)} off at all angles, which the fit allows"
                " for: the sensor's zero is off, or the wearer helps or resists; log once with the"
                " tendons off"
            )
    gear = by_key.get(names.GEAR_FRICTION)
    if gear is not None and gear.interval_95[1] < 0.0:
        found.append(
            f"the gear's friction comes out as {gear.text(gear.value)}, which would help the"
            " motion: the wearer helps, or the torque is filtered"
        )
    return found


def _row_warnings(estimate: SuitEstimate, selection: Selection) -> list[str]:
    """Return warnings on slack, on few strokes and on rows without numbers."""
    aside = selection.set_aside
    total = selection.used + sum(aside.values())
    slack = aside.get("slack", 0) / total
    missing = aside.get("without a number", 0) / total
    table = (
        (
            slack > _SLACK_SHARE,
            (
                f"a tendon is slack in {say.percent(slack)} of the rows, which are left out: with"
                " more pretension they would count"
            ),
        ),
        (
            missing > 0.2,
            f"{say.percent(missing)} of the rows lack a number: check what the logger lost",
        ),
        (
            estimate.strokes < 6,
            (
                f"only {say.counted(estimate.strokes, 'stroke')}: the intervals assume that more"
                " would scatter as usual; log six or more"
            ),
        ),
    )
    return [words for is_true, words in table if is_true]


def gear_note(numbers: Sequence[FittedNumber]) -> list[str]:
    """Return a note on a gear that loses torque; none where the log does not show one."""
    gear = next((number for number in numbers if number.key == names.GEAR_EFFICIENCY), None)
    if gear is None or not gear.is_told or gear.interval_95[1] > 1.0 - _LOSES:
        return []
    low, high = (gear.text(end) for end in gear.interval_95)
    note = (
        f"a gear passes {gear.text(gear.value)} of the torque ({low} to {high}), which the fit"
        " allows for; the torques of a study are those of the spool"
    )
    if gear.score < -_AT_END:
        note += "; gears seldom lose more: is the torque constant right?"
    return [note]


def fast_note(estimate: SuitEstimate) -> list[str]:
    """Return a note on inertia in a fast log; none for a slow one."""
    parts = estimate.parts
    if MOTOR_TORQUE not in parts.values or estimate.model.study.motion.inertia is not None:
        return []
    loads = np.nan_to_num(parts.load, nan=0.0)
    distance = estimate.model.study.numbers["arm.load_distance"].single
    inertia = names.usual_inertia(estimate.model.study) + loads * distance**2
    torque = float(np.quantile(np.abs(inertia * parts.acceleration), 0.95))
    span = estimate.misfit.scales[MOTOR_TORQUE]
    if torque < _FAST * span:
        return []
    note = (
        f"inertia may take up to {say.number(torque, 2)} N m in these motions, and the study states"
        " none, so the logs decide how much there is; move more slowly, or state"
        ' motion.inertia = "0.07 kg m2"'
    )
    return [note]
