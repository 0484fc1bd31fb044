"""Limits in words: what it means that one is not kept, and why two leave no pretension."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tendon_cli.say.words import quantity


@dataclass(frozen=True)
class LimitWords:
    """A limit in words; `{}` stands for its bound."""

    label: str
    """What is wrong if it is not kept, for a legend or a table."""
    topic: str
    """What it is about."""
    broken: str
    """What happens if it is not kept, as a sentence."""
    keeps: str
    """What a pretension does that is high enough, after "the pretension that"."""
    breaks: str
    """What a pretension does that is too high, after "the pretension ... already"."""


LIMITS = {
    "flexor slack": LimitWords(
        "flexor slack", "slack", "the flexor goes slack", "prevents slack in the flexor", "lets the flexor go slack"
    ),
    "extensor slack": LimitWords(
        "extensor slack", "slack", "the extensor goes slack", "prevents slack", "lets the extensor go slack"
    ),
    "min_flexor_tension": LimitWords(
        "flexor tension too low", "flexor tension", "the flexor has less than {}", "keeps {} in the flexor",
        "leaves less than {} in the flexor",
    ),
    "min_extensor_tension": LimitWords(
        "extensor tension too low", "extensor tension", "the extensor has less than {}", "keeps {} in the extensor",
        "leaves less than {} in the extensor",
    ),
    "max_tension": LimitWords(
        "tension too high", "tension", "a tendon carries more than {}", "keeps both tendons below {}",
        "loads a tendon with more than {}",
    ),
    "max_spring_extension": LimitWords(
        "spring stretched too far", "spring extension", "a spring is stretched by more than {}",
        "keeps the springs within {}", "stretches a spring by more than {}",
    ),
    "peak_motor_torque": LimitWords(
        "motor torque too high", "motor torque", "the motor needs more than {}", "keeps the motor within {}",
        "asks the motor for more than {}",
    ),
    "max_contact_pressure": LimitWords(
        "strap presses too hard", "strap pressure", "the strap presses with more than {}",
        "keeps the strap's pressure below {}", "makes the strap press with more than {}",
    ),
    "min_elbow_stiffness": LimitWords(
        "elbow too soft", "stiffness", "the elbow is less stiff than {}", "makes the elbow stiffer than {}",
        "makes the elbow less stiff than {}",
    ),
    "max_pretension": LimitWords(
        "pretension too high", "the largest pretension", "the pretension is above {}", "is below {}", "exceeds {}"
    ),
    "min_spool_to_tendon": LimitWords(
        "spool too small", "spool size", "a spool is less than {} tendon diameters wide", "suits the spool",
        "needs a spool of more than {} tendon diameters",
    ),
    "max_spool_travel": LimitWords(
        "spool turns too far", "spool travel", "the spool turns by more than {}", "keeps the spool within {}",
        "turns the spool by more than {}",
    ),
    "max_backlash": LimitWords(
        "too much backlash", "backlash", "the spool differs by more than {} between the directions",
        "keeps the backlash below {}", "causes a backlash of more than {}",
    ),
    "max_torque_band": LimitWords(
        "torque differs too much", "torque difference", "the motor torque differs by more than {} between directions",
        "keeps the directions within {} of torque", "makes the motor torque differ by more than {}",
    ),
    "peak_motor_speed": LimitWords(
        "motor too fast", "motor speed", "the motor turns faster than {}", "keeps the motor slower than {}",
        "turns the motor faster than {}",
    ),
    "peak_motor_power": LimitWords(
        "motor power too high", "motor power", "the motor gives more than {}", "keeps the motor below {}",
        "asks the motor for more than {}",
    ),
    "max_motor_work_in": LimitWords(
        "motor work too high", "motor work", "the motor works more than {} per cycle", "keeps the motor below {}",
        "asks the motor for more than {} per cycle",
    ),
    "max_friction_loss": LimitWords(
        "friction loss too high", "friction loss", "friction takes more than {} per cycle",
        "keeps the friction loss below {}", "loses more than {} per cycle to friction",
    ),
    "min_efficiency": LimitWords(
        "efficiency too low", "efficiency", "the efficiency is below {}", "keeps the efficiency above {}",
        "lowers the efficiency below {}",
    ),
    "no equilibrium": LimitWords(
        "no equilibrium", "equilibrium", "the flexor has passed the joint's centre", "allows equilibrium",
        "leaves no equilibrium",
    ),
}  # fmt: skip
_STABLE = LimitWords(
    "elbow unstable", "stability", "the elbow becomes unstable", "keeps the elbow stable", "makes the elbow unstable"
)


def limit_words(limit: str, bounds: Mapping[str, float]) -> LimitWords:
    """A limit in words; `bounds` has the limits of the study by name, SI. Without a bound stability is meant."""
    if limit == "min_elbow_stiffness" and bounds.get(limit, 0.0) == 0.0:
        return _STABLE
    words = LIMITS[limit]
    bound = quantity(limit, bounds[limit]) if limit in bounds else "its limit"
    return LimitWords(**{name: text.format(bound) for name, text in vars(words).items()})


def conflict(limits: Sequence[str], bounds: Mapping[str, float]) -> str:
    """Why no pretension is left, as a sentence: "the pretension that prevents slack already makes the elbow unstable".

    The first limit asks for more pretension, the second for less; one alone is broken at any pretension.
    """
    words = [limit_words(each, bounds) for each in limits]
    if len(words) == 1:
        return f"{words[0].broken} at any pretension"
    return f"the pretension that {words[0].keeps} already {words[1].breaks}"


def conflict_label(limits: Sequence[str], bounds: Mapping[str, float]) -> str:
    """The same in few words, for a legend or a table: "slack and stability exclude each other"."""
    words = [limit_words(each, bounds) for each in limits]
    return words[0].label if len(words) == 1 else f"{words[0].topic} and {words[1].topic} exclude each other"
