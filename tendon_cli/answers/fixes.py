"""What would give a choice without a window one: the least change of one number, or of two together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from tendon_cli.answers.candidates import Candidates
from tendon_cli.answers.factors import Numbers
from tendon_cli.answers.opening import Opening, work
from tendon_cli.answers.problem import Flags, Problem
from tendon_cli.answers.solve import solve
from tendon_cli.answers.worst import WORST
from tendon_cli.model.kinematics import Array

KNOBS = {
    "spring.stiffness": (200.0, 5e4),
    "spool.ratio": (0.3, 2.0),
    "spool.flexor_radius": (0.01, 0.08),
    "arm.elbow_radius": (0.02, 0.1),
    "sheath.friction": (0.005, 0.3),
    "sheath.bend_angle": (0.2, 12.0),
    "arm.a1": (0.005, 0.1),
    "arm.b1": (0.05, 0.3),
    "arm.a2": (0.002, 0.08),
    "arm.b2": (0.05, 0.25),
    "tendon.length": (0.2, 5.0),
    "tendon.diameter": (4e-4, 4e-3),
}
"""What a designer can change, and between which values that is plausible, SI."""

_POINTS = 65
_SECTIONS = 16
_ROUNDS = 14
_HALVINGS = 52
_RADII = np.geomspace(2e-3, 2.5, 40)
_PAIRED = 4
_SMALL = 20_000
"""Work of a choice from which on values are tried one by one."""
WORK_FOR_PAIRS = 600_000
"""Of one choice under all conditions; of more, two knobs together take too long."""


@dataclass(frozen=True)
class Fix:
    """A change of one knob or two that opens a window."""

    knobs: tuple[str, ...]
    before: tuple[float, ...]
    """SI."""
    after: tuple[float, ...] | None
    """SI; None where no value within the plausible range does."""
    plausible: tuple[tuple[float, float], ...]
    pretension: float = np.nan
    """The one that then suits, N."""
    costs: dict[str, float] | None = None
    """The worst of every quantity at it, over all conditions."""

    @property
    def size(self) -> float:
        """How large the change is: the logarithm of the factor, of two knobs the root of the sum of squares."""
        if self.after is None:
            return np.inf
        return float(np.linalg.norm(np.log(np.divide(self.after, self.before))))


def fixes(problem: Problem, choice: Candidates) -> list[Fix]:
    """What each knob alone does for one choice, the least change first; and last the least of two together, if any."""
    opening = Opening.of(problem, choice)
    before = {key: value for key in KNOBS if (value := _now(problem, opening.numbers, key)) > 0.0}
    alone = [_alone(opening, key, value) for key, value in before.items()]
    alone.sort(key=lambda fix: fix.size)
    promising = [fix.knobs[0] for fix in alone][:_PAIRED] if work(problem) <= WORK_FOR_PAIRS else []
    pairs = [_together(opening, pair, before) for pair in combinations(promising, 2)]
    together = min((fix for fix in pairs if fix is not None), key=lambda fix: fix.size, default=None)
    return [*alone, *([together] if together and together.size < alone[0].size * (1 - 1e-6) else [])]


def _now(problem: Problem, numbers: Numbers, key: str) -> float:
    """A knob's value in a choice; NaN where it has none of its own: it differs between conditions, or sides."""
    table, _, name = key.rpartition(".")
    sides = [f"{table}.{side}.{name}" for side in ("flexor", "extensor")]
    given = (*problem.study.numbers, *problem.condition_numbers, *numbers)
    if key in problem.condition_numbers or any(side in given for side in sides):
        return np.nan
    if key in numbers and not np.isnan(numbers[key][0]):
        return float(numbers[key][0])
    values = problem.study.numbers.get(key)
    return np.nan if values is None or values.is_axis else values.single


def _alone(opening: Opening, key: str, before: float) -> Fix:
    low, high = KNOBS[key]
    ends = [end for end in (low, high) if (end - before) * (end - low - (high - end)) > 0.0]
    found = [_nearest(opening, key, before, end) for end in ends]
    after = min((value for value in found if value is not None), key=lambda v: abs(np.log(v / before)), default=None)
    fix = Fix((key,), (before,), None if after is None else (after,), ((low, high),))
    return _with_costs(opening, fix)


def _nearest(opening: Opening, key: str, before: float, end: float) -> float | None:
    """The value nearest to `before`, on the way to `end`, that opens a window."""
    values = np.geomspace(before, end, _POINTS)
    first, nearest = opening.first((key,), values[:, np.newaxis])
    for _ in range(4):  # between three values, where a narrow window may hide: around the nearest to have one
        if first is not None:
            break
        values = np.geomspace(values[max(nearest - 1, 0)], values[min(nearest + 1, len(values) - 1)], _SECTIONS)
        first, nearest = opening.first((key,), values[:, np.newaxis])
    if first is None:
        return None
    return float(values[0]) if first == 0 else _edge(opening, key, values[first - 1], values[first])


def _edge(opening: Opening, key: str, shut: float, open_: float) -> float:
    """Where a window opens between two values; the last that has one."""
    # Many small questions are faster asked together, large ones one by one.
    sections, rounds = (_SECTIONS, _ROUNDS) if work(opening.problem) <= _SMALL else (3, _HALVINGS)
    for _ in range(rounds):
        values = np.linspace(shut, open_, sections)
        values[-1] = open_
        first, _ = opening.first((key,), values[1:-1, np.newaxis])
        first = sections - 1 if first is None else first + 1
        if (shut, open_) == (values[first - 1], values[first]):
            break
        shut, open_ = float(values[first - 1]), float(values[first])
    return open_


def _together(opening: Opening, keys: tuple[str, str], before: dict[str, float]) -> Fix | None:
    """The least change of two knobs, by its length in logarithms, along every direction of change."""
    start = np.array([before[key] for key in keys])
    low, high = np.array([KNOBS[key] for key in keys]).T

    def opened(logs: Array) -> Flags:
        values = start * np.exp(logs)
        within = np.all((values >= np.minimum(low, start)) & (values <= np.maximum(high, start)), axis=1)
        within[within] = opening.tried(keys, values[within])
        return np.asarray(within)

    angles, radii = np.linspace(0.0, 2 * np.pi, 33)[1:], _RADII
    for reach in (0.3, 0.03, 3e-3, 3e-4):
        found = _first_radii(opened, angles, radii, rounds=4)
        at = int(np.argmin(found))
        if np.isinf(found[at]):
            return None
        angles, radii = angles[at] + reach * np.linspace(-1.0, 1.0, 13), found[at] * np.linspace(0.7, 1.0001, 7)
    angle = float(angles[6])
    radius = float(_first_radii(opened, angles[[6]], radii, rounds=_ROUNDS)[0])
    after = start * np.exp(radius * np.array([np.cos(angle), np.sin(angle)]))
    fix = Fix(keys, tuple(map(float, start)), tuple(map(float, after)), tuple(KNOBS[key] for key in keys))
    return _with_costs(opening, fix)


def _first_radii(opened: Callable[[Array], Flags], angles: Array, radii: Array, *, rounds: int) -> Array:
    """How far one must go in the directions in which a window opens first; infinite in all others."""
    ways, found = np.column_stack([np.cos(angles), np.sin(angles)]), np.full(len(angles), np.inf)
    before, some = 0.0, np.empty(0, dtype=np.int64)
    for radius in radii:
        some = np.flatnonzero(opened(radius * ways))
        if len(some):
            break
        before = float(radius)
    if not len(some):
        return found
    near, far, rows = np.full(len(some), before), np.full(len(some), radius), np.arange(len(some))
    for _ in range(rounds):
        between = near[:, np.newaxis] + (far - near)[:, np.newaxis] * np.linspace(0.0, 1.0, 9)
        between[:, -1] = far
        points = between[:, 1:-1, np.newaxis] * ways[some, np.newaxis]
        is_open = opened(points.reshape(-1, 2)).reshape(points.shape[:2])
        first = np.argmax(np.column_stack([is_open, np.ones(len(some), bool)]), axis=1)
        near, far = between[rows, first], between[rows, first + 1]
    found[some] = far
    return found


def _with_costs(opening: Opening, fix: Fix) -> Fix:
    if fix.after is None:
        return fix
    changed = {**opening.numbers, **{key: np.array([value]) for key, value in zip(fix.knobs, fix.after, strict=True)}}
    found = solve(opening.problem, changed, 1)
    costs = {name: float(found.column(name)[0]) for name in WORST}
    return Fix(fix.knobs, fix.before, fix.after, fix.plausible, float(found.pretension[0]), costs)
