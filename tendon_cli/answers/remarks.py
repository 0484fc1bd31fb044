"""Whether a suit can be built and worn: what an answer says of limits that the study does not set.

Each is compared with what is known, and said only if it exceeds that. Beyond the upper end of a window the elbow is
not held near one angle: `drift_of` says how far it goes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.candidates import Candidates, numbers_of
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.setting import settings
from tendon_cli.answers.solve import severest, worst
from tendon_cli.model.actuator import evaluate
from tendon_cli.model.drift import Drift, drift
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.studies.values import Values

STRAP = 0.04
"""Width of a strap if the study gives none, m."""
DISCOMFORT, PAIN = 30.4e3, 52.9e3
"""Pressure under a cuff at the knee that is uncomfortable for a while, and that hurts, Pa."""
OF_CUFFS = "cuffs at the knee, Ergonomics 63(5):618, 2020; nothing is known of elbows"
BREAKING, ROPE, SAFETY = 2.1e3, 1.5875e-3, 10.0
"""A stainless rope of 1/16 inch, 7x7, breaks at so many N; the customary factor."""
OF_ROPES = "makers' tables for stainless 7x7 rope"
SPRINGS = ((3e3, 5e3), (0.084, 0.073))
"""Stiffness, N/m, and unloaded length of springs that are made for 300 N, m."""
OF_SPRINGS = "extension springs made for 300 N: 73 mm at 5 kN/m, 84 mm at 3 kN/m"

BEYOND = 1.1
"""Times the upper end of a window, where the drift is worked out."""


@dataclass(frozen=True)
class Remark:
    """What exceeds what is known."""

    about: str
    text: str
    source: str


def bench_record(problem: Problem, choice: Candidates) -> dict[str, Any]:
    """What to set for a choice, the drift beyond its window, and remarks, as the record of an answer has them."""
    numbers, solutions = numbers_of(problem, choice.columns), choice.solutions
    values = settings(problem, numbers, solutions.pretension)
    beyond, posture = drift_of(problem, choice), problem.study.setting
    return {
        "setting": {
            "angle": _first(posture.angle), "upper_arm_angle": _first(posture.upper_arm_angle),
            "load": _first(posture.load), "after": posture.after, "read": posture.read,
            "newtons_per_metre": float(values.per_length[0]),
        },
        "drift": None if beyond is None else {"pretension": beyond[0], **asdict(beyond[1])},
        "remarks": [asdict(each) for each in remarks(problem, choice)],
    }  # fmt: skip


def _first(values: Values) -> float:
    return float(values.array[0])


def remarks(problem: Problem, choice: Candidates) -> Iterator[Remark]:
    """What a suit would do that no limit forbids and nobody would want, at its pretension over all it serves."""
    numbers, solutions = numbers_of(problem, choice.columns), choice.solutions
    pretension = solutions.pretension
    if np.isnan(pretension[0]) or not solutions.served_at[0] > 0.0:
        return
    yield from _of_strap(problem, choice)
    if "max_tension" not in problem.bounds:
        yield from _of_rope(problem, choice)
    if not {"max_spring_extension", "min_spring_room"} & set(problem.bounds):
        everyone = np.ones((1, len(problem.conditions)), dtype=np.bool_)
        few = problem.under(severest(problem, numbers, pretension, everyone, 1))
        yield from _of_spring(few, choice)


def _of_strap(problem: Problem, choice: Candidates) -> Iterator[Remark]:
    if "max_contact_pressure" in problem.bounds:
        return
    pressure, width = float(choice.solutions.max_contact_pressure[0]), ""
    if np.isnan(pressure):
        everyone = np.ones((1, len(problem.conditions)), dtype=np.bool_)
        strapped = problem.saying({"arm.contact_width": np.full(len(problem.conditions), STRAP)})
        at = worst(strapped, numbers_of(problem, choice.columns), choice.solutions.pretension, everyone)
        pressure, width = float(at["max_contact_pressure"][0]), f" if it is {1e3 * STRAP:.0f} mm wide"
    if pressure > DISCOMFORT:
        known = f"discomfort begins at {1e-3 * DISCOMFORT:.1f} kPa"
        if pressure > PAIN:
            known = f"pain begins at {1e-3 * PAIN:.1f} kPa"
        shown = say.quantity("max_contact_pressure", pressure)
        yield Remark("strap", f"the strap presses the elbow with up to {shown}{width}; {known}", OF_CUFFS)


def _of_rope(problem: Problem, choice: Candidates) -> Iterator[Remark]:
    design = problem.design(numbers_of(problem, choice.columns))
    diameter = float(min(np.min(design.flexor.diameter), np.min(design.extensor.diameter)))
    breaking, tension = BREAKING * (diameter / ROPE) ** 2, float(choice.solutions.max_tension[0])
    if tension > breaking / SAFETY:
        rope = f"a rope of {say.number(1e3 * diameter, 3)} mm breaks at about {say.number(breaking, 2)} N"
        factor = f"{say.number(breaking / tension, 2)} times the largest tension, where {SAFETY:.0f} is customary"
        yield Remark("rope", f"{rope}, {factor}", OF_ROPES)


def _of_spring(problem: Problem, choice: Candidates) -> Iterator[Remark]:
    """By how much the flexor's spring is stretched, against the room between its anchors."""
    design = problem.design(numbers_of(problem, choice.columns), pretension=choice.solutions.pretension)
    state = evaluate(design, problem.angles, problem.flexion)
    extension: Array = np.asarray(state.balance.flexor / design.flexor.spring_stiffness)
    path = state.motion.flexor_path
    if path is None:
        return
    room = np.broadcast_to(path, extension.shape) - extension
    if not np.isfinite(room).any():
        return
    at = np.unravel_index(int(np.nanargmin(room)), room.shape)
    if room[at] < np.interp(np.min(design.flexor.spring_stiffness), *SPRINGS):
        apart = say.quantity("max_spring_extension", float(room[at] + extension[at]))
        stretched = say.quantity("max_spring_extension", float(extension[at]))
        text = f"the flexor's spring is stretched by {stretched} between anchors {apart} apart"
        left = say.quantity("max_spring_extension", float(room[at]))
        yield Remark("spring", f"{text}: {left} are left for the spring itself" if room[at] > 0.0 else text, OF_SPRINGS)


def drift_of(problem: Problem, choice: Candidates) -> tuple[float, Drift] | None:
    """The pretension 10 % beyond the upper end, N, and the arm's drift there under the condition that binds.

    None if it is not stability that bounds the window above.
    """
    solutions = choice.solutions
    high, state = float(solutions.pretension_to[0]), int(solutions.to_state[0])
    is_stability = state >= 0 and LIMIT_NAMES[solutions.to_by[0]] == "min_elbow_stiffness"
    if not (is_stability and np.isfinite(high) and problem.limit("min_elbow_stiffness") == 0.0):
        return None
    alone = problem.under(solutions.to_condition[:1])
    design = alone.design(numbers_of(problem, choice.columns), pretension=np.array([BEYOND * high]))
    start = float(problem.angles[0, state % problem.angles.size])
    first, last = float(problem.angles.min()), float(problem.angles.max())
    ways = [drift(design, start, end) for end in (first, last) if end != start]
    return BEYOND * high, max(ways, key=lambda way: abs(way.end - way.start))
