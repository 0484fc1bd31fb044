"""Parts that the choice named first needs in words, and those of the study that fail advice.

Numbers are rounded to the safe side: whoever orders what is printed has enough.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from tendon_cli import say
from tendon_cli.answer_record import (
    AnswerResults,
    FailingPart,
    MotorRecord,
    PartsRecord,
    RopeRecord,
    SpoolRecord,
    SpringRecord,
    StrapRecord,
)

HEADING = "Parts it needs"
_OF_CUFFS = "cuffs at the knee, Ergonomics 63(5):618"
_USUAL_ROPE = "7x7"
_SURELY = 1.0 + 1e-9
"""Factor by which a value must be beyond a bound to be so in spite of rounding."""


def but_words(record: AnswerResults) -> str:
    """Say what the choice named first fails: "But the strap presses ..."; empty if nothing."""
    failures = failure_words(record)
    return f"But {failures}." if failures else ""


def failure_words(record: AnswerResults) -> str:
    """Say what the choice named first fails: "the strap presses ..."; empty if nothing."""
    parts = record.parts_needed
    return "" if parts is None else say.join_words([*_failures(parts).values()])


def can_be_built(record: AnswerResults) -> bool:
    """Return True unless a part of the choice named first has no room."""
    parts = record.parts_needed
    return parts is None or "spring" not in parts.fails


def parts_words(record: AnswerResults) -> Iterator[str]:
    """Say each part that the choice named first needs, or that it keeps or fails its advice."""
    parts = record.parts_needed
    if parts is None:
        return
    failures = _failures(parts)
    if parts.strap is not None and _is_pressed(parts.strap):
        yield failures.get("strap") or _strap(parts.strap)
    yield failures.get("rope") or _rope(parts.rope)
    yield failures.get("spool") or _spool(parts.spool)
    if parts.spring is not None:
        yield failures.get("spring") or _spring(parts.spring)
    yield _motor(parts.motor)


def _is_pressed(strap: StrapRecord) -> bool:
    """Return True unless the strap never presses, so that none is too narrow."""
    return strap.least_width > 0.0


def short_parts(parts: PartsRecord) -> Iterator[str]:
    """Say in a few words each what parts the choice named first needs."""
    strap = parts.strap
    if strap is not None and _is_pressed(strap):
        instead = ""
        if "strap" in parts.fails:
            instead = f" instead of {_length(strap.width)}"
        yield f"a strap at least {_at_least(strap.least_width)} wide{instead}"
    rope = parts.rope
    diameter = _at_least(rope.least_diameter, 3)
    spool = parts.spool
    ropes = [f"{_at_most(most)} ({name})" for name, most in spool.largest_ropes.items()]
    of_side = f"the {spool.side}'s spool, {_length(spool.diameter)} across,"
    no_rope = _no_rope_fits(parts)
    yield (
        f"a rope that breaks at {_strength(rope)} or more"
        f"{f': {no_rope}' if no_rope else f' (7x7: {diameter})'}"
    )
    if not no_rope:
        yield f"{of_side} takes a rope of at most {say.join_words(ropes, 'or')}"
    spring = parts.spring
    if spring is not None:
        words = f"springs with {_at_least(spring.travel, 3)} of travel"
        if spring.room is not None and spring.free_length is None and spring.room > 0.0:
            words += f", the flexor's at most {_at_most(spring.room)} long unloaded"
        yield words
    yield f"a motor of {_motor(parts.motor).removeprefix('motor: ')}"


# --- What fails -----------------------------------------------------------------------------------


def _failures(parts: PartsRecord) -> dict[FailingPart, str]:
    """Say what each part fails, by the part, in the order of the record."""
    words: dict[FailingPart, str] = {}
    for part in parts.fails:
        if part == "strap" and parts.strap is not None:
            words[part] = _strap_fails(parts.strap)
        elif part == "spring" and parts.spring is not None:
            words[part] = _spring_fails(parts.spring)
        elif part == "rope":
            words[part] = _rope_fails(parts.rope)
        elif part == "spool":
            words[part] = _spool_fails(parts.spool)
    return words


def _no_rope_fits(parts: PartsRecord) -> str:
    """Say that a 7x7 rope of the strength needed is too thick for the spool; empty if it is not."""
    least = parts.rope.least_diameter
    spool = parts.spool
    most = spool.largest_ropes[_USUAL_ROPE]
    if least <= most * _SURELY:
        return ""
    wider = spool.least_ratios[_USUAL_ROPE] * least
    return (
        f"{_at_least(least, 3)} of {_USUAL_ROPE}, too thick for the {spool.side}'s spool"
        f" ({_length(spool.diameter)} across; {_at_least(wider)} would do)"
    )


def _strap_fails(strap: StrapRecord) -> str:
    """Say that the strap hurts, and how wide it should be."""
    pressure = say.quantity("max_contact_pressure", strap.pressure or math.nan)
    return (
        f"the strap of {_length(strap.width)} presses with up to {pressure}"
        f" (pain begins at {_pain(strap)}; {_at_least(strap.least_width)} would do)"
    )


def _spring_fails(spring: SpringRecord) -> str:
    """Say that the flexor's spring has no room between its anchors."""
    itself = ""
    if spring.free_length is not None:
        itself = f" of {_length(spring.free_length)}"
    return (
        f"it cannot be built: the flexor's spring{itself} is stretched by"
        f" {_length(spring.extension)} between anchors {_length(spring.distance)} apart"
    )


def _rope_fails(rope: RopeRecord) -> str:
    """Say that the rope breaks too soon."""
    breaking = rope.breaking_force or math.nan
    times = say.number(breaking / rope.tension, 2, toward=-math.inf)
    return (
        f"the rope breaks at {say.quantity('breaking_force', breaking)}, only {times} times the"
        f" largest tension ({rope.reserve:.0f} is customary; {_strength(rope)} would do)"
    )


def _spool_fails(spool: SpoolRecord) -> str:
    """Say that a spool is too small for its rope."""
    construction = spool.construction or ""
    least = say.number(spool.least_ratios.get(construction, math.nan))
    rope = _at_most(spool.largest_ropes.get(construction, math.nan))
    ratio = say.number(spool.ratio * _SURELY, 3, toward=-math.inf)
    return (
        f"the {spool.side}'s spool of {_length(spool.diameter)} is only {ratio} rope"
        f" diameters wide ({construction} needs {least}; a spool of"
        f" {_at_least(spool.least_diameter)} or a rope of at most {rope} would do)"
    )


# --- What is needed, or kept ----------------------------------------------------------------------


def _strap(strap: StrapRecord) -> str:
    """Say how wide the strap must be, or that the one of the study suits."""
    if strap.width is None or strap.pressure is None:
        return (
            f"strap: at least {_at_least(strap.least_width)} wide, to press with at most"
            f" {_pain(strap)}, where pain begins ({_OF_CUFFS})"
        )
    pressure = say.quantity("max_contact_pressure", strap.pressure)
    words = f"strap of {_length(strap.width)}"
    if strap.pressure > strap.most_pressure * _SURELY:
        return f"{words}: presses with up to {pressure}"
    return f"{words}: wide enough, presses with up to {pressure}; pain begins at {_pain(strap)}"


def _rope(rope: RopeRecord) -> str:
    """Say at which tension the rope may break, or that the one of the study suits."""
    breaking = rope.breaking_force
    if breaking is None:
        return (
            f"rope: breaks at {_strength(rope)} or more, {rope.reserve:.0f} times the"
            f" largest tension (stainless 7x7: {_at_least(rope.least_diameter, 3)})"
        )
    words = f"rope of {say.quantity('breaking_force', breaking)}"
    share = "any"
    if rope.tension > 0.0:
        share = say.number(breaking / rope.tension, 2, toward=-math.inf)
    if breaking * _SURELY < rope.least_breaking_force:
        return f"{words}: breaks at {share} times the largest tension"
    return f"{words}: strong enough, breaks at {share} times the largest tension"


def _spool(spool: SpoolRecord) -> str:
    """Say which ropes suit the narrower spool, or that the one of the study does."""
    construction = spool.construction
    own = _length(spool.rope_diameter)
    of_side = f"the {spool.side}'s spool, {_length(spool.diameter)} across"
    if construction is None:
        ropes = [
            f"{_at_most(diameter)} ({name}, D/d of {spool.least_ratios[name]:.0f})"
            for name, diameter in spool.largest_ropes.items()
        ]
        needed = _at_least(spool.least_diameter)
        return (
            f"rope on {of_side}: at most {' or '.join(ropes)}; a 7x7 rope of {own} needs a spool"
            f" of {needed}"
        )
    ratio = say.number(spool.ratio * _SURELY, 3, toward=-math.inf)
    least = spool.least_ratios[construction]
    words = of_side.removeprefix("the ")
    if spool.ratio * _SURELY < least:
        return f"{words}: {ratio} rope diameters wide"
    return f"{words}: wide enough, {ratio} rope diameters; {construction} needs {least:.0f}"


def _spring(spring: SpringRecord) -> str:
    """Say how far the springs travel, and how long the flexor's may be without load."""
    stiffness = spring.stiffness
    of_stiffness = ""
    if stiffness is not None:
        of_stiffness = f" {say.quantity('spring_stiffness', stiffness)},"
    words = f"springs:{of_stiffness} {_at_least(spring.travel, 3)} of travel"
    room = spring.room
    if room is None:
        return words
    its_length = spring.free_length
    of_length = "" if its_length is None else f" of {_length(its_length)}"
    if room < 0.0:
        return f"{words}; the flexor's{of_length} is {_at_least(-room)} too long for its room"
    if its_length is None:
        return f"{words}, the flexor's at most {_at_most(room)} long unloaded"
    return f"{words}; the flexor's{of_length} fits with {_at_most(room)} to spare"


def _motor(motor: MotorRecord) -> str:
    """Say what the motor must give."""
    needs = [say.quantity("peak_motor_torque", motor.torque, 3, toward=math.inf)]
    for name, value in (("peak_motor_speed", motor.speed), ("peak_motor_power", motor.power)):
        if value is not None and value > 0.0:
            needs.append(say.quantity(name, value, 3, toward=math.inf))
    return f"motor: {say.join_words(needs)}"


# --- Numbers --------------------------------------------------------------------------------------


def _length(value: float | None) -> str:
    """Say a length that is stated."""
    return say.quantity("max_spring_extension", math.nan if value is None else value)


def _at_least(value: float, digits: int = 2) -> str:
    """Say a length that is needed, rounded up."""
    return say.at_least("max_spring_extension", value, digits)


def _at_most(value: float) -> str:
    """Say a length that is allowed, rounded down."""
    return say.at_most("max_spring_extension", value)


def _strength(rope: RopeRecord) -> str:
    """Say the tension below which the rope should not break, rounded up."""
    return say.quantity("breaking_force", rope.least_breaking_force, 3, toward=math.inf)


def _pain(strap: StrapRecord) -> str:
    """Say the pressure from which on a strap hurts."""
    return say.quantity("max_contact_pressure", strap.most_pressure)
