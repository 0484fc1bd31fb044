"""Words for what the cutoff of a motion's low-pass decides."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tendon_cli.say.words import join_words, quantity

if TYPE_CHECKING:
    from tendon_cli.verbs.answer_record import ChecksRecord


def cutoff_words(checks: ChecksRecord | None) -> str:
    """Say that the cutoff decides the peaks of the motor, with those at both cutoffs.

    "The motor's peaks are decided by the cutoff: 111 rad/s and 575 W at 15 Hz, 45 rad/s and 230 W
    at 10.5 Hz." Empty if it does not decide them, or if nothing was checked.

    Args:
        checks: Key `checks` of a record; None if it has none.
    """
    if checks is None or not checks.cutoff.decides:
        return ""
    check = checks.cutoff
    texts = []
    for place, cutoff in enumerate((check.cutoff, check.lower)):
        speed = check.peak_motor_speed[place]
        power = check.peak_motor_power[place]
        peaks = []
        if speed is not None:
            peaks.append(quantity("peak_motor_speed", speed, 3))
        if power is not None:
            peaks.append(quantity("peak_motor_power", power, 3))
        texts.append(f"{join_words(peaks)} at {quantity('cutoff', cutoff)}")
    return f"The motor's peaks are decided by the cutoff: {', '.join(texts)}."
