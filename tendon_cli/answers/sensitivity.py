"""How both ends of a window move with every number of the study, by derivative in the state that binds.

And where the uncertainty of a window comes from: Sobol indices of uncertain numbers, and of bodies as one group.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.coverage import grouped, normalised
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.solve import Solutions, solve
from tendon_cli.model.bounds import Bounds, limit_end
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Spline
from tendon_cli.model.limits import LIMIT_NAMES, LIMITS
from tendon_cli.model.limits import PRETENSION as LIMIT_PRETENSION
from tendon_cli.model.motor_window import excess
from tendon_cli.model.setting import shown
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, PRETENSION, WORDS, Axis, Numbers, of_side
from tendon_cli.space.space import Space
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import quantile

_STEP = 1e-30  # of an imaginary change: a complex step has no error of difference, so it may be as small as can be
_FACTORS = (0.99, 1.01)  # by which a number is changed to see whether its derivative says enough
_NEAR = 3  # states apart that count as the same, for the angle that binds moves with most numbers

Slope = Callable[
    [Design, Bounds], float
]  # how an end moves with what is complex in a design or in the bounds, N


def sensitivities(problem: Problem, choice: Solutions) -> list[dict[str, Any]]:
    """How both ends of one choice's window move, as recorded, the largest per 1 % first.

    `slope` is N per SI unit of a number, by its dotted key, or of a limit, `limits.` and its name; `steady` is whether
    the same limit binds in the same state when the number is 1 % larger or smaller. An end that no limit on motion
    sets has none.
    """
    slopes = [each for end in ("from", "to") for each in _of_end(problem, choice, end)]
    return sorted(slopes, key=lambda each: -abs(each["per_percent"]))


def _of_end(problem: Problem, choice: Solutions, end: str) -> Iterator[dict[str, Any]]:
    code, state, condition = (int(choice[f"{end}_{of}"][0]) for of in ("by", "state", "condition"))
    name = LIMIT_NAMES[code]
    of_motion = code >= 0 and name in LIMITS and LIMITS[name].of_motion
    if not (state >= 0 or of_motion) or not np.isfinite(choice[f"pretension_{end}"][0]):
        return
    numbers, alone = problem.numbers_of(choice.columns), problem.under(np.array([condition]))
    design, bounds = alone.design(numbers), alone.bounds
    slope = (_of_motor if of_motion else _of_state)(alone, choice, end, design)

    def record(key: str, value: float, moved: float, *, steady: bool = True) -> dict[str, Any]:
        each = {"end": end, "key": key, "value": value, "slope": moved, "steady": steady}
        return {**each, "per_percent": moved * value / 100.0}

    values = _numbers_at(alone, numbers)
    steady = _steady(problem, numbers, values, end, (code, state))
    for key, value in values.items():
        changed = alone.design(
            numbers, {**alone.condition_numbers, key: np.array([value + _STEP * 1j])}
        )
        yield record(key, value, slope(changed, bounds), steady=steady[key])
    if name not in bounds:
        return
    has_speed = (
        "motion.speed" in (need.key for need in LIMITS[name].needs)
        and problem.study.trajectory is None
    )
    of_bounds = {"motion.speed": ("speed", bounds.speed)} if has_speed else {}
    for key, (bound, given) in {**of_bounds, f"limits.{name}": (name, bounds[name])}.items():
        value = float(given)
        yield record(
            key, value, slope(design, bounds.changed(bound, np.asarray(value + _STEP * 1j)))
        )


def _of_state(alone: Problem, choice: Solutions, end: str, design: Design) -> Slope:  # noqa: ARG001
    """Of an end that a limit on a state sets: it is where the limit is just kept."""
    code, state, between = (
        int(choice[f"{end}_by"][0]),
        int(choice[f"{end}_state"][0]),
        choice.scalar(f"{end}_angle"),
    )
    direction, place = divmod(state, alone.angles.size)
    angle = np.array([[float(alone.angles[0, place]) if np.isnan(between) else between]])
    ways = np.broadcast_to(alone.flexion, (len(alone.flexion), alone.angles.size))
    flexion = np.array([[bool(ways[direction, place])]])

    def slope(changed: Design, bounds: Bounds) -> float:
        kept = limit_end(code, changed, angle, flexion, bounds, upper=end == "to")
        read = kept if code == LIMIT_PRETENSION else shown(changed, kept)
        return float(read.imag.item()) / _STEP

    return slope


def _of_motor(alone: Problem, choice: Solutions, end: str, design: Design) -> Slope:
    """Of an end F that a limit on the motor sets: its excess e is 0 there, so that dF/dp = -(de/dp)/(de/dF)."""
    name, state = LIMIT_NAMES[choice[f"{end}_by"][0]], int(choice[f"{end}_state"][0])
    pretension = choice.scalar(f"pretension_{end}")

    def slope(changed: Design, bounds: Bounds) -> float:
        by_number, by_pretension = (
            excess(name, each, alone.angles, alone.flexion, held, at, state).imag
            for each, held, at in (
                (changed, bounds, pretension),
                (design, alone.bounds, pretension + _STEP * 1j),
            )
        )
        return -by_number / by_pretension

    return slope


def _numbers_at(alone: Problem, numbers: Numbers) -> dict[str, float]:
    """Every number that counts for a choice under one condition, by its key; of one side where the sides differ."""
    space = alone.choices.at(numbers, alone.condition_numbers)
    values = {}
    for (key, side), number in space.of_the_model.items():
        if (
            key not in (PRETENSION, *WORDS)
            and key in keys()
            and not isinstance(number.value, Spline)
        ):
            name = of_side(key, side) if side and key in space.of_sides else key
            values[name] = float(np.asarray(number.within(space.whole)).item())
    return {key: value for key, value in values.items() if np.isfinite(value)}


def _steady(
    problem: Problem, numbers: Numbers, values: dict[str, float], end: str, binding: tuple[int, int]
) -> dict[str, bool]:
    """Whether the same limit binds in the same state when each number is 1 % larger, and smaller, in every condition.

    Numbers that no condition says are changed as choices are, all of them at once.
    """
    of_conditions = {key: each for key, each in problem.condition_numbers.items() if key in values}
    alone = [key for key in values if key not in of_conditions]
    changed = {key: np.full(2 * len(alone), each[0]) for key, each in numbers.items()}
    for row, key in enumerate(alone):
        column = changed.setdefault(key, np.full(2 * len(alone), np.nan))
        column[2 * row : 2 * row + 2] = values[key] * np.array(_FACTORS)
    rows = [_binds(problem, changed, 2 * len(alone), end, binding)] if alone else []
    for key, given in of_conditions.items():
        scaled = np.where(np.isnan(given), values[key], given)
        rows += [
            _binds(problem.saying({key: scaled * factor}), numbers, 1, end, binding)
            for factor in _FACTORS
        ]
    pairs = np.all(np.concatenate(rows).reshape(-1, 2), axis=1)
    return dict(zip([*alone, *of_conditions], np.asarray(pairs).tolist(), strict=True))


def _binds(
    problem: Problem, numbers: Numbers, count: int, end: str, binding: tuple[int, int]
) -> Flags:
    """Of choices, whether a limit binds in a state, or next to it."""
    solved = solve(replace(problem, near=-1.0), numbers, count, with_worst=False)
    near = np.abs(solved[f"{end}_state"] - binding[1]) <= _NEAR
    return np.asarray((solved[f"{end}_by"] == binding[0]) & near)


# --- Sobol indices ---------------------------------------------------------------------------------------------------

BODY = "body"  # all dimensions of a body together: they are correlated, so that none has an index alone

_STATES = 2e7  # most states that are worked out for the indices
_MOST, _FEWEST = 4096, 64
_RESAMPLES = 200

Ends = Callable[
    [Array], Array
]  # from points of the unit cube, (points, inputs), to results, (results, points)


def sobol(
    ends: Ends, inputs: tuple[str, ...], names: tuple[str, ...], count: int, seed: int
) -> Iterator[Any]:
    """First-order and total indices of results by Saltelli's design of `count` (a power of two) Sobol points.

    Standard errors are of the bootstrap. A result that is not finite everywhere, or never changes, has no indices.
    """
    from scipy import stats  # only uncertain numbers pay for its import

    random, width = np.random.default_rng([seed, 7]), len(inputs)
    a, b = np.split(stats.qmc.Sobol(2 * width, rng=random, bits=64).random(count), 2, axis=1)
    mixed = [np.where(np.arange(width) == at, b, a) for at in range(width)]
    results = ends(np.concatenate([a, b, *mixed])).reshape(len(names), width + 2, count)
    # SciPy's bootstrap draws anew each time, so that the same question would not have the same answer.
    draws = random.integers(count, size=(_RESAMPLES, count))

    def indices(values: Array) -> Array:
        """Saltelli et al. 2010, table 2, (b) and (f)."""
        of_a, of_b, of_mixed = values[0], values[1], values[2:]
        first = np.mean(of_b * (of_mixed - of_a), axis=-1)
        total = 0.5 * np.mean(np.square(of_a - of_mixed), axis=-1)
        return np.asarray(np.stack([first, total]) / np.var(values[:2]))

    for name, values in zip(names, results, strict=True):
        if not np.isfinite(values).all() or np.ptp(values) == 0.0:
            continue
        apart = values - values[:2].mean()
        first_error, total_error = np.std(
            [indices(apart[:, some]) for some in draws], axis=0, ddof=1
        )
        first, total = indices(apart)
        columns = {"first": first, "first_standard_error": first_error}
        columns |= {"total": total, "total_standard_error": total_error}
        of_inputs = {
            key: {"name": _words(key), **{what: float(row[at]) for what, row in columns.items()}}
            for at, key in enumerate(inputs)
        }
        yield {"end": name, "standard_deviation": float(np.std(values[0])), "inputs": of_inputs}


def _words(key: str) -> str:
    if key not in keys():
        return key
    side = say.side_of(key)
    return say.column(keys()[key].number.quantity.name) + (f" of the {side}" if side else "")


def indices(problem: Problem, numbers: Numbers) -> list[dict[str, Any]]:
    """The indices of both ends of one choice's window over all its conditions but persons and draws, as recorded."""
    study = problem.study
    if study.uncertainty is None or not study.uncertain:
        return []
    people = study.people.population if study.people is not None else None
    whose = problem.axes.get(PERSON_AXIS)
    inputs = (*study.uncertain, *((BODY,) if whose is not None and len(whose) > 1 else ()))
    others = [each for each in problem.conditions.axes if each.key not in (PERSON_AXIS, DRAW_AXIS)]
    each_point = problem.states_per_design * max(1, int(np.prod([len(axis) for axis in others])))
    most = max(_STATES / (each_point * (len(inputs) + 2)), 1.0)
    count = int(2 ** np.clip(np.floor(np.log2(most)), np.log2(_FEWEST), np.log2(_MOST)))

    def ends(points: Array) -> Array:
        drawn: dict[str, Array] = {}
        if whose is not None and people is not None:  # the persons at these shares of the weighting
            up_to = np.cumsum(normalised(people.weighting))
            persons = np.minimum(
                np.searchsorted(up_to, points[:, -1], side="right"), len(people) - 1
            )
            drawn |= {key: values[persons] for key, values in whose.numbers.items()}
        drawn |= {
            key: quantile(known, points[:, at])
            for at, (key, known) in enumerate(study.uncertain.items())
        }
        axis = replace(Axis.of_points(drawn), key=DRAW_AXIS)
        asked = replace(problem, conditions=Space((axis, *others)).grouped())
        windows = asked.ends(numbers, 1)
        return np.concatenate(grouped(windows.low, windows.high, asked.groups))

    return list(
        sobol(ends, inputs, ("pretension_from", "pretension_to"), count, study.uncertainty.seed)
    )
