"""What would give a choice without a window one: the least change of one number, or of two together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from tendon_cli.design.candidates import Candidates, numbers_of
from tendon_cli.design.problem import Flags, Problem
from tendon_cli.design.solve import Solutions, solve
from tendon_cli.design.worst import WORST
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
_RADII = np.geomspace(2e-3, 2.5, 40)
_PAIRED = 4
_STATES_FOR_PAIRS = 20_000
"""Of one choice; of more, two knobs together take too long."""

_STATES_FOR_FIXES = 40_000
"""Of one choice; of more, as of a crowd, changes of one knob take too long."""

Opened = Callable[[Array], tuple[Flags, Array]]
"""Of values of a knob, or of some: whether there is a window, and how wide it is, negative where empty."""


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


def affordable(problem: Problem) -> bool:
    """Whether changes are tried at all: a few thousand designs are, under every condition."""
    return len(problem.conditions) * problem.states_per_design <= _STATES_FOR_FIXES


def fixes(problem: Problem, choice: Candidates) -> list[Fix]:
    """What each knob alone does for one choice, the least change first; and last the least of two together, if any."""
    numbers = dict(numbers_of(problem, choice.columns))
    before = {key: value for key in KNOBS if (value := _now(problem, numbers, key)) > 0.0}
    alone = [_alone(problem, numbers, key, value) for key, value in before.items()]
    alone.sort(key=lambda fix: fix.size)
    states = len(problem.conditions) * problem.states_per_design
    promising = [fix.knobs[0] for fix in alone][:_PAIRED] if states <= _STATES_FOR_PAIRS else []
    pairs = [_together(problem, numbers, pair, before) for pair in combinations(promising, 2)]
    together = min((fix for fix in pairs if fix is not None), key=lambda fix: fix.size, default=None)
    return [*alone, *([together] if together and together.size < alone[0].size * (1 - 1e-6) else [])]


def _now(problem: Problem, numbers: dict[str, Array], key: str) -> float:
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


def _opened(problem: Problem, numbers: dict[str, Array], keys: tuple[str, ...]) -> Opened:
    """Tries values of some knobs, (points, knobs), all else as it is."""

    def opened(values: Array) -> tuple[Flags, Array]:
        changed = {key: np.repeat(value, len(values)) for key, value in numbers.items()}
        changed |= dict(zip(keys, values.T, strict=True))
        found = solve(problem, changed, len(values), with_worst=False)
        return found.feasible, _width(problem, found)

    return opened


def _width(problem: Problem, found: Solutions) -> Array:
    """How far a window is open, N, or where a share is asked for, by how much more than enough is served."""
    if problem.enough < 1.0:
        return found.served - problem.enough
    with np.errstate(invalid="ignore"):
        width = found.pretension_to - found.pretension_from
    return np.where(np.isnan(width), -np.inf, width)


def _alone(problem: Problem, numbers: dict[str, Array], key: str, before: float) -> Fix:
    opened, (low, high) = _opened(problem, numbers, (key,)), KNOBS[key]
    ends = [end for end in (low, high) if (end - before) * (end - low - (high - end)) > 0.0]
    found = [_nearest(opened, before, end) for end in ends]
    after = min((value for value in found if value is not None), key=lambda v: abs(np.log(v / before)), default=None)
    fix = Fix((key,), (before,), None if after is None else (after,), ((low, high),))
    return _with_costs(problem, numbers, fix)


def _nearest(opened: Opened, before: float, end: float) -> float | None:
    """The value nearest to `before`, on the way to `end`, that opens a window."""
    values = np.geomspace(before, end, _POINTS)
    is_open, width = opened(values[:, np.newaxis])
    if not is_open.any():
        values, is_open = _closer(opened, values, width)
        if not is_open.any():
            return None
    first = int(np.argmax(is_open))
    return values[0] if first == 0 else _edge(opened, values[first - 1], values[first])


def _closer(opened: Opened, values: Array, width: Array) -> tuple[Array, Flags]:
    """Between three values, where a narrow window may hide: around the one that is nearest to have one."""
    is_open = np.zeros(len(values), dtype=np.bool_)
    for _ in range(4):
        at = int(np.argmax(width))
        values = np.geomspace(values[max(at - 1, 0)], values[min(at + 1, len(values) - 1)], _SECTIONS)
        is_open, width = opened(values[:, np.newaxis])
        if is_open.any():
            break
    return values, is_open


def _edge(opened: Opened, shut: float, open_: float) -> float:
    """Where a window opens between two values; the last that has one."""
    for _ in range(_ROUNDS):
        values = np.linspace(shut, open_, _SECTIONS)
        values[-1] = open_
        is_open, _ = opened(values[1:-1, np.newaxis])
        first = int(np.argmax(np.append(is_open, True))) + 1
        shut, open_ = float(values[first - 1]), float(values[first])
    return open_


def _together(
    problem: Problem, numbers: dict[str, Array], keys: tuple[str, str], before: dict[str, float]
) -> Fix | None:
    """The least change of two knobs, by its length in logarithms, along every direction of change."""
    start = np.array([before[key] for key in keys])
    low, high = np.array([KNOBS[key] for key in keys]).T
    tried = _opened(problem, numbers, keys)

    def opened(logs: Array) -> Flags:
        values = start * np.exp(logs)
        within = (values >= np.minimum(low, start)) & (values <= np.maximum(high, start))
        return np.asarray(tried(values)[0] & np.all(within, axis=1))

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
    return _with_costs(problem, numbers, fix)


def _first_radii(opened: Callable[[Array], Flags], angles: Array, radii: Array, *, rounds: int) -> Array:
    """How far one must go in each direction until a window opens; infinite where it does not."""
    ways = np.column_stack([np.cos(angles), np.sin(angles)])

    def tried(radii: Array) -> Flags:
        return opened((radii[..., np.newaxis] * ways[:, np.newaxis]).reshape(-1, 2)).reshape(radii.shape)

    is_open = tried(np.broadcast_to(radii, (len(angles), len(radii))))
    any_open = is_open.any(axis=1)
    first = np.argmax(is_open, axis=1)
    near, far = np.where(first > 0, radii[first - 1], 0.0), radii[first]
    for _ in range(rounds):
        between = near[:, np.newaxis] + (far - near)[:, np.newaxis] * np.linspace(0.0, 1.0, 9)
        between[:, -1] = far
        is_open = tried(between[:, 1:-1])
        first = np.argmax(np.column_stack([is_open, np.ones(len(ways), bool)]), axis=1)
        near, far = between[np.arange(len(ways)), first], between[np.arange(len(ways)), first + 1]
    return np.where(any_open, far, np.inf)


def _with_costs(problem: Problem, numbers: dict[str, Array], fix: Fix) -> Fix:
    if fix.after is None:
        return fix
    changed = numbers | {key: np.array([value]) for key, value in zip(fix.knobs, fix.after, strict=True)}
    found = solve(problem, changed, 1)
    costs = {name: float(found.column(name)[0]) for name in WORST}
    return Fix(fix.knobs, fix.before, fix.after, fix.plausible, float(found.pretension[0]), costs)
