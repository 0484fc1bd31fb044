"""Parts that the choice named first needs, and remedies if no choice has a window, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from tendon_cli import say
from tendon_cli.answers.phrases import COSTS, costs, share_words, value_words
from tendon_cli.studies.axis_words import parameter
from tendon_cli.studies.study import keys
from tendon_cli.verbs.answer_record import (
    AnswerResults,
    FailingPart,
    FixRecord,
    MotorRecord,
    PartsRecord,
    QuestionRecord,
    RelaxationRecord,
    RopeRecord,
    SpoolRecord,
    SpringRecord,
    StrapRecord,
)

_SURELY = 1.0 + 1e-9
"""Factor by which a value must be beyond a bound to be so in spite of rounding."""
_DEMANDS = {
    "load.mass": "loads of at most {} instead of {}",
    "arm.upper_arm_angle": "an upper arm tilted by at most {} instead of {}",
    "arm.contact_width": "a strap of {} instead of {}",
    "anchor.stiffness": "tissue and cuffs of {} per tendon instead of {}",
}


# --- Parts ----------------------------------------------------------------------------------------


def failure_words(record: AnswerResults) -> str:
    """Say what the choice named first fails: "the strap presses ..."; empty if nothing."""
    parts = record.parts_needed
    return "" if parts is None else say.join_words([*_failures(parts).values()])


def can_be_built(record: AnswerResults) -> bool:
    """Return True unless a part of the choice named first has no room."""
    parts = record.parts_needed
    return parts is None or "spring" not in parts.fails


def _is_pressed(strap: StrapRecord) -> bool:
    """Return True unless the strap never presses, so that none is too narrow."""
    return strap.least_width > 0.0


def short_parts(parts: PartsRecord) -> Iterator[tuple[str, str]]:
    """Yield each part that the choice named first needs, and what it must be in a few words."""
    strap = parts.strap
    if strap is not None and _is_pressed(strap):
        instead = ""
        if "strap" in parts.fails:
            instead = f" instead of {_length(strap.width)}"
        yield "strap", f"a strap at least {_at_least(strap.least_width)} wide{instead}"
    spring = parts.spring
    if spring is not None:
        yield "spring", _spring_words(spring)
    yield "rope", f"a rope that breaks at {_strength(parts.rope)} or more{_ropes_that_fit(parts)}"
    yield "motor", f"a motor of {_motor(parts.motor).removeprefix('motor: ')}"


def _spring_words(spring: SpringRecord) -> str:
    """Say the travel of the springs, and how long the flexor's may be unloaded."""
    words = f"springs with {_at_least(spring.travel, 3)} of travel"
    if spring.room is None or spring.free_length is not None or spring.room <= 0.0:
        return words
    most = _at_most(spring.room)
    if spring.least_length is None or spring.least_length > spring.room:
        return f"{words}, the flexor's at most {most} long unloaded"
    least = _at_least(spring.least_length)
    return f"{words}, the flexor's {least.partition(' ')[0]} to {most} long unloaded"


def _ropes_that_fit(parts: PartsRecord) -> str:
    """Say which ropes of that strength suit the narrower spool, if the study states none."""
    rope = parts.rope
    spool = parts.spool
    if rope.construction is not None:
        return ""
    fitting = [kind for kind, least in rope.spools.items() if least <= spool.diameter * _SURELY]
    if not fitting:
        widest = min(rope.spools.values())
        narrow = f"the {spool.side}'s spool is {_length(spool.diameter)} across"
        return f"; {narrow}, and none fits one below {_at_least(widest)}"
    kinds = [f"{_at_least(rope.kinds[kind], 3)} of {kind}" for kind in fitting]
    words = f": {say.join_words(kinds, 'or')}"
    return words if "7x19" in fitting else f"{words}, which rubs three times as much as steel"


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


def _strap_fails(strap: StrapRecord) -> str:
    """Say that the strap hurts, and how wide it should be."""
    pressure = say.quantity("max_contact_pressure", strap.pressure or math.nan)
    return (
        f"the strap of {_length(strap.width)} presses with up to {pressure}"
        f" (pain begins at {_pain(strap)}; {_at_least(strap.least_width)} would do)"
    )


def _spring_fails(spring: SpringRecord) -> str:
    """Say that the flexor's spring has no room between its anchors."""
    needed = spring.least_length
    if spring.free_length is None and needed is not None and 0.0 < (spring.room or 0.0) < needed:
        return (
            f"it cannot be built: the flexor's spring is {_at_least(needed)} long unloaded or more,"
            f" where {_at_most(spring.room or 0.0)} are left"
        )
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


def _motor(motor: MotorRecord) -> str:
    """Say what the motor must give."""
    torque = say.quantity("peak_motor_torque", motor.torque, 3, toward=math.inf)
    needs = [f"{torque} at the spool"]
    if motor.worn_torque is not None:
        worn = say.quantity("peak_motor_torque", motor.worn_torque, 3, toward=math.inf)
        needs = [f"{torque} at the spool ({worn} with worn sheaths)"]
    for name, value in (("peak_motor_speed", motor.speed), ("peak_motor_power", motor.power)):
        if value is not None and value > 0.0:
            needs.append(say.quantity(name, value, 3, toward=math.inf))
    return f"motor: {say.join_words(needs)}"


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


# --- Remedies -------------------------------------------------------------------------------------


def fix_words(question: QuestionRecord, fix: FixRecord) -> str:
    """Say a fix in a line: "K from 3 kN/m to 3.4 kN/m, set to 120 N: tension 377 N".

    If no change of the number can be seen in print, it is the pretension that matters.
    """
    before = parameter(fix.parameter, fix.before)
    words = f"set to {fix.printed_pretension} {question.unit}"
    if not before.endswith(f" {fix.printed}"):
        words = f"{_change_words(fix)}{_nearest_words(fix)}, {words}"
    judged = fix.served_verified
    gains = [] if judged is None else [f"{say.percent(judged.value)} served"]
    of_costs = zip(COSTS.values(), costs(fix), strict=True)
    gains += [f"{head} {cost}" for head, cost in of_costs if cost != "-"]
    return f"{words}: {', '.join(gains)}" if gains else words


def _change_words(fix: FixRecord) -> str:
    """Say the change of a fix: "K from 3 kN/m to 3.4 kN/m"."""
    key = fix.parameter
    value = say.quantity(keys()[key].quantity, fix.before)
    name = parameter(key, fix.before).removesuffix(value).rstrip()
    return f"{name} from {value} to {fix.printed}"


def _nearest_words(fix: FixRecord) -> str:
    """Name the row of a table that is nearest to the value of a fix, in brackets; or nothing."""
    nearest = fix.nearest
    if nearest is None:
        return ""
    value = parameter(fix.parameter, nearest.value)
    return f" (nearest in the catalogue: {nearest.table} {nearest.name}, {value})"


def relaxations_words(
    answer: AnswerResults, relaxations: Sequence[RelaxationRecord]
) -> Iterator[str]:
    """Say the value that each demand would have to take, and the suit that then serves."""
    question = answer.question
    fresh = answer.verified_by
    not_enough = []
    for record in relaxations:
        key = record.key
        quantity = keys()[key].quantity
        text = _DEMANDS.get(key, f"{key.removeprefix('limits.')} = {{}} instead of {{}}")
        if record.after is None or record.pretension is None:
            farthest = say.quantity(quantity, record.farthest)
            not_enough.append(text.partition(" instead of")[0].format(farthest))
            continue
        changed = text.format(record.printed, say.quantity(quantity, record.before))
        others = [axis for axis in question.choices if axis.key != key]
        values = [value_words(axis, record.values[axis.column]) for axis in others]
        pretension = f"{record.printed_pretension} {question.unit}"
        suit = f"{', '.join(values)} at {pretension}" if values else pretension
        share = record.served
        some = "all" if share is None or share >= 1.0 else f"{say.percent(share)} of the"
        whom = f"{some} {question.counted}"
        judged = record.served_verified
        if judged is not None and fresh is not None:
            judges = replace(fresh, count=judged.of)
            whom = share_words(judges, judged, answer.serve)
        yield f"{changed}: {suit} serves {whom}"
    if not_enough:
        own = "its" if len(not_enough) == 1 else "their"
        yield f"not enough on {own} own: {', '.join(not_enough)}"
