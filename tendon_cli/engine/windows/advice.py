"""Advice on choices at their pretensions: what cannot be built, would hurt, break, or wear soon.

Advice never changes a window. It compares the worst values of a choice with published values for
the parts that a study states, and with the room that any spring needs. The sources stand in
`docs/design.md`.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import Question
from tendon_cli.engine.windows.study_arm import of_designs, study_arm
from tendon_cli.engine.windows.worst import Worst
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import BREAKING_FORCE, FREE_LENGTH, spool_to_tendon
from tendon_cli.model.winding import MOST_TRAVEL, least_free_length

Codes = npt.NDArray[np.int64]
"""Sums of codes of the advice that choices fail."""

NO_ROOM = 1
"""Code: the flexor's spring has no room, or none can be wound; the choice cannot be built."""
HURTS = 2
"""Code: the strap presses so hard that it hurts."""
WEAK = 4
"""Code: the rope is too weak for the largest tension."""
NARROW = 8
"""Code: a spool is too small for the rope."""
_FAULTS = {
    NO_ROOM: "no spring for the flexor can be wound in its room",
    HURTS: "strap presses too hard",
    WEAK: "rope too weak",
    NARROW: "spool too small for the rope",
}
ADVICE = tuple(
    ", ".join(words for code, words in _FAULTS.items() if failed & code)
    for failed in range(2 * NARROW)
)
"""Advice that a choice fails in words, by the sum of its codes; the first is empty."""

PAIN = 52.9e3
"""Pressure under a cuff at the knee from which on it hurts, Pa."""
ROPE_SAFETY = 10.0
"""Customary ratio of a rope's breaking tension to its largest tension."""
WIDTHS = {"7x7": 28.0, "7x19": 18.0}
"""Diameter of a spool over that of a rope of each construction, below which it wears soon."""
STEEL_STRENGTH = 8.33e8
"""Breaking tension of a stainless rope over the square of its diameter, Pa: 2.1 kN at 1/16 inch."""
FLEXIBLE_ROPES = {"7x19": (STEEL_STRENGTH, WIDTHS["7x19"]), "Dyneema": (1.0e9, 8.0)}
"""Ropes that may be wound on a narrow spool: strength, Pa, and least width of a spool over the
rope's. Dyneema rubs in a sheath some three times as much as steel."""
_AXES = 4
"""Number of axes of designs: choices, conditions, directions, angles."""
_ROUNDING = 1e-9
"""Share of a bound within which it is kept."""


def advice_of(question: Question, points: Points, worst: Worst) -> Codes:
    """Return the advice that choices fail, (choices,), as sums of codes; 0 if they keep all of it.

    A choice whose worst values are not known fails nothing.

    Args:
        question: The question.
        points: The choices.
        worst: Their worst values at their pretensions.
    """
    failed = np.zeros(len(points), dtype=np.int64)
    study = question.study
    if not study.design.advice:
        return failed
    failed[_cannot_be_wound(question, points, worst)] |= NO_ROOM
    failed[worst.max_contact_pressure > PAIN * (1.0 + _ROUNDING)] |= HURTS
    is_rope_stated = study.tendon.rope is not None
    is_strength_stated = is_stated(question, BREAKING_FORCE)
    if not (is_rope_stated or is_strength_stated):
        narrowest = narrowest_spool(question, points)
        fits = np.zeros(len(points), dtype=np.bool_)
        for rope in FLEXIBLE_ROPES:
            fits |= least_spool(rope, worst.max_tension) <= narrowest * (1.0 + _ROUNDING)
        failed[~fits & ~np.isnan(worst.max_tension)] |= NARROW
        return failed
    design = question.designs(points)
    breaking = _least(design.given[BREAKING_FORCE], len(points))
    failed[worst.max_tension * ROPE_SAFETY > breaking * (1.0 + _ROUNDING)] |= WEAK
    if study.tendon.rope is not None:
        widths = _least(spool_to_tendon(design), len(points))
        failed[widths < WIDTHS[study.tendon.rope] * (1.0 - _ROUNDING)] |= NARROW
    return failed


def _cannot_be_wound(question: Question, points: Points, worst: Worst) -> Flags:
    """Return True for choices whose flexor's spring has no room, or cannot be wound, (choices,).

    A spring of the room that is left must bear the force, and may not travel too far.
    """
    flexor = study_arm(question, points).flexor
    stiffness = of_designs(np.asarray(flexor.spring_stiffness), len(points))
    travel = np.where(np.isinf(stiffness), 0.0, worst.max_spring_extension)
    with np.errstate(invalid="ignore"):
        force = np.where(np.isinf(stiffness), 0.0, stiffness * travel)
    needed = least_free_length(stiffness, force)
    room = worst.spring_room  # less the unloaded length, where the study states it
    stated = is_stated(question, FREE_LENGTH.key)
    length = room
    if stated:
        length = _least(question.designs(points).given[FREE_LENGTH.key], len(points))
        needed = np.where(needed > length * (1.0 + _ROUNDING), np.inf, 0.0)
    is_crowded = room < needed - _ROUNDING
    is_too_far = travel > MOST_TRAVEL * length * (1.0 + _ROUNDING)
    return np.asarray(is_crowded | is_too_far)


def narrowest_spool(question: Question, points: Points) -> Array:
    """Return the diameter of the narrower part of the spool of choices, (choices,), m.

    It is counted to the middle of the rope.
    """
    design = study_arm(question, points)
    flexor = 2.0 * of_designs(np.asarray(design.flexor_radius), len(points))
    extensor = flexor * of_designs(np.asarray(design.ratio), len(points))
    return np.minimum(flexor, extensor)


def least_rope(strength: float, tension: Array) -> Array:
    """Return the diameter of the weakest rope that bears a tension with the customary reserve, m.

    Args:
        strength: Breaking tension over the square of the diameter, Pa.
        tension: Largest tension, N.
    """
    return np.asarray(np.sqrt(ROPE_SAFETY * tension / strength))


def least_spool(rope: str, tension: Array) -> Array:
    """Return the narrowest spool for the weakest sufficient rope of a kind, m.

    Args:
        rope: One of `FLEXIBLE_ROPES`.
        tension: Largest tension, N.
    """
    strength, width = FLEXIBLE_ROPES[rope]
    return width * least_rope(strength, tension)


def is_stated(question: Question, key: str) -> bool:
    """Return True if the study, or any of its axes or cases, gives a number."""
    return any(
        key in space.single or any(key in axis.numbers for axis in space.axes)
        for space in (question.choices, question.conditions)
    )


def _least(values: npt.ArrayLike, count: int) -> Array:
    """Return the least of numbers of designs over all conditions, (count,).

    Args:
        values: Numbers that broadcast to (choices, conditions, 1, 1).
        count: Number of choices.
    """
    of_designs = np.asarray(values, dtype=np.float64)
    if of_designs.ndim < _AXES:
        of_designs = of_designs.reshape((1,) * (_AXES - of_designs.ndim) + of_designs.shape)
    least = np.fmin.reduce(of_designs, axis=(1, 2, 3))
    return np.broadcast_to(least, (count,))
