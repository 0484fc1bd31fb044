"""Sensitivity of a window: derivatives of its ends by every number of a study, and Sobol indices.

The derivatives are exact in the state that binds. The indices say which uncertain numbers, and the
dimensions of a body as one group, make a window uncertain.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tendon_cli.answers.phrases import input_words
from tendon_cli.engine.windows.coverage import normalise
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import Question, cost_per_design
from tendon_cli.engine.windows.solutions import (
    ENDS,
    WINDOWS_AT_ONCE,
    Binding,
    End,
    Solutions,
    solve_windows,
)
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.model.bounds import Bounds, limit_end
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Spline
from tendon_cli.model.limits import CONTACT_PRESSURE, LIMIT_NAMES, LIMITS, POWER
from tendon_cli.model.limits import PRETENSION as LIMIT_PRETENSION
from tendon_cli.model.moving import Moving
from tendon_cli.model.power_window import power_excess
from tendon_cli.model.setting import pretension_of, reading_at
from tendon_cli.studies.answer_draws import drawn_numbers
from tendon_cli.studies.space.axis import (
    DRAW_AXIS,
    LIMIT,
    PERSON_AXIS,
    PRETENSION,
    WORDS,
    Axis,
    Numbers,
    factor_of,
    limit_of,
    of_side,
)
from tendon_cli.studies.space.space import Space
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import quantile
from tendon_cli.verbs.answer_record import IndexRecord, SensitivityRecord, SobolRecord

_STEP = 1e-30
"""Imaginary step of a complex-step derivative: nothing cancels, so that it may be tiny."""
_SAME_ANGLE = 1e-9
"""Distance within which two angles are the same, rad."""
_FACTORS = (0.99, 1.01)
"""Factors by which a number is changed to see if the same limit still binds."""
_NEAR = 3
"""Distance up to which states count as the same: the binding angle moves with most numbers."""


Slope = Callable[[Design, Bounds], Array]
"""Function from designs and bounds with a complex number to the derivatives of an end by it, N."""


def sensitivities(solver: Solver, choice: Solutions) -> list[SensitivityRecord]:
    """Return how both ends of one choice's window move, as recorded, the largest per 1 % first.

    `key` is the dotted key of a number, or `limits.` and the name of a limit, and `slope` is N per
    its SI unit; `steady` is true if the same limit binds in the same state when the number is 1 %
    larger or smaller, for the person or draw that sets the end if there are some. An end has no
    records if the limit that sets it is not on states, if it has no slope, or if it is infinite.
    """
    numbers = {end: _numbers_at(solver.question, choice, end) for end in ENDS}
    if solver.question.conditions.groups is None:
        every = list(dict.fromkeys(key for of_end in numbers.values() for key in of_end))
        changed = dict.fromkeys(ENDS, _changed_bindings(solver, choice.points, every))
    else:
        changed = {
            end: _changed_bindings(
                _solver_of_group(solver, choice, end), choice.points, list(of_end)
            )
            for end, of_end in numbers.items()
        }
    records = [
        record
        for end in ENDS
        if _has_slopes(choice, end)
        for record in _of_end(solver.question, choice, end, numbers[end], changed[end])
    ]
    known = [record for record in records if np.isfinite(record.slope)]
    # Numbers that act alike, such as the length of a tendon and its modulus, keep their order.
    return sorted(known, key=lambda record: -float(f"{abs(record.per_percent):.9g}"))


def _solver_of_group(solver: Solver, choice: Solutions, end: End) -> Solver:
    """Return the solver for the person or draw that sets an end, under all its conditions."""
    question = solver.question
    groups = question.groups
    group = groups.of[choice.binding(end).condition]
    own = question.for_conditions(groups.conditions_of(group))
    return solver.for_question(replace(own, serve=1.0))


def _has_slopes(choice: Solutions, end: End) -> bool:
    """Return True if an end is finite, and the limit that sets it is on states."""
    binding = choice.binding(end)
    is_of_state = int(binding.state[0]) >= 0
    is_finite = bool(np.isfinite(choice.pretension_at(end)[0]))
    return is_finite and (is_of_state or int(binding.by[0]) == POWER)


def _numbers_at(question: Question, choice: Solutions, end: End) -> dict[str, float]:
    """Return the numbers under the condition that sets an end, by key; none without slopes."""
    if not _has_slopes(choice, end):
        return {}
    condition = choice.binding(end).condition
    return _numbers_under(question.for_conditions(condition), choice.points)


def _of_end(
    question: Question,
    choice: Solutions,
    end: End,
    values: dict[str, float],
    changed: dict[str, dict[End, Binding]],
) -> Iterator[SensitivityRecord]:
    """Yield the record of each number that moves one end.

    Args:
        question: The question.
        choice: The choice.
        end: "from" or "to".
        values: Numbers under the condition that sets the end, by key.
        changed: Limits that set the ends with one number 1 % off, by its key.
    """
    binding = choice.binding(end)
    code = int(binding.by[0])
    state = int(binding.state[0])
    name = LIMIT_NAMES[code]
    points = choice.points
    alone = question.for_conditions(binding.condition)
    bounds = alone.bounds
    design = alone.designs(points)
    slope = (
        _slope_of_power_end(alone, choice, end, design)
        if code == POWER
        else _slope_of_form_end(alone, choice, end)
    )

    def record(
        key: str, value: float, derivative: float, *, steady: bool = True
    ) -> SensitivityRecord:
        """Return the record of one number, SI, and the derivative of the end by it."""
        return SensitivityRecord(
            end=end,
            key=key,
            value=value,
            slope=derivative,
            steady=steady,
            per_percent=derivative * value / 100.0,
        )

    derivatives = dict.fromkeys(values, math.nan)
    if code != POWER and values:
        stepped_one_each = _stepped_one_each(alone.condition_numbers, values)
        along = slope(alone.designs(points, stepped_one_each), bounds)
        derivatives = dict(zip(values, np.broadcast_to(along, len(values)).tolist(), strict=True))
    for key, value in values.items():
        if not math.isfinite(derivatives[key]):
            stepped = {**alone.condition_numbers, key: np.array([value + _STEP * 1j])}
            derivatives[key] = slope(alone.designs(points, stepped), bounds).item()
        steady = _is_steady(changed[key][end], code, state)
        yield record(key, value, derivatives[key], steady=steady)
    if name not in bounds:
        return
    needs = [need.key for need in LIMITS[name].needs]
    if "motion.speed" in needs and question.study.trajectory is None:
        speed = float(bounds.speed)
        stepped_bounds = bounds.changed("speed", np.asarray(speed + _STEP * 1j))
        yield record("motion.speed", speed, slope(design, stepped_bounds).item())
    key = f"{LIMIT}{name}"
    limit = np.asarray(bounds.of(design)[name]).item()
    stepped = {**alone.condition_numbers, key: np.array([limit + _STEP * 1j])}
    yield record(key, limit, slope(alone.designs(points, stepped), bounds).item())


def _stepped_one_each(given: Numbers, values: Mapping[str, float]) -> dict[str, Array]:
    """Return numbers of one condition as often as there are values, each with one value stepped.

    Args:
        given: Numbers of the condition, (1,).
        values: Numbers to step, by key.
    """
    count = len(values)
    stepped: dict[str, Array] = {key: np.repeat(number, count) for key, number in given.items()}
    for place, (key, value) in enumerate(values.items()):
        column = stepped.get(key, np.full(count, np.nan)).astype(np.complex128)
        column[place] = value + _STEP * 1j
        stepped[key] = column  # type: ignore[assignment]
    return stepped


def _slope_of_form_end(alone: Question, choice: Solutions, end: End) -> Slope:
    """Return the slope of an end that a limit on a form sets, where the limit is just kept."""
    code = int(choice.binding(end).by[0])
    state = int(choice.binding(end).state[0])
    angle_between = float(choice.binding(end).angle[0])
    direction, place = divmod(state, alone.angles.size)
    angle = float(alone.angles[0, place]) if np.isnan(angle_between) else angle_between
    of_states = np.broadcast_to(alone.flexion, (len(alone.flexion), alone.angles.size))
    elbow_angle = np.array([[angle]])
    flexion = np.array([[bool(of_states[direction, place])]])
    contact = alone.designs(choice.points).arm.first_contact
    begins = bool(np.isclose(contact, angle, rtol=0.0, atol=_SAME_ANGLE).all())

    def slope(changed: Design, bounds: Bounds) -> Array:
        moved = elbow_angle
        if begins and LIMIT_NAMES[code] == CONTACT_PRESSURE:
            moved = elbow_angle + 1j * np.asarray(changed.arm.contact_from).imag
        kept = limit_end(code, changed, moved, flexion, bounds, upper=end == "to")
        read = kept if code == LIMIT_PRETENSION else reading_at(changed, kept)
        return np.asarray(read.imag / _STEP).ravel()

    return slope


def _slope_of_power_end(alone: Question, choice: Solutions, end: End, design: Design) -> Slope:
    """Return the slope of an end F that the limit on power sets.

    Its excess e is 0 there, so that dF/dp = -(de/dp)/(de/dF).
    """
    pretension = float(choice.pretension_at(end)[0])

    flexion = alone.flexion
    trajectory = alone.study.trajectory
    if trajectory is not None:
        kept = np.full((1, 1, 1), pretension_of(design, pretension))
        held = Moving.of(design, trajectory).at_pretension(kept).flexion
        flexion = held.reshape(1, -1)

    def excess_of(changed: Design, bounds: Bounds, at_pretension: complex) -> complex:
        return power_excess(changed, alone.angles, flexion, bounds, at_pretension)

    def slope(changed: Design, bounds: Bounds) -> Array:
        by_number = excess_of(changed, bounds, pretension).imag
        by_pretension = excess_of(design, alone.bounds, pretension + _STEP * 1j).imag
        return np.array(-by_number / by_pretension if by_pretension else math.nan)

    return slope


def _numbers_under(alone: Question, points: Points) -> dict[str, float]:
    """Return every number that counts for a choice under one condition, by its key.

    If the sides differ, the key is that of one side. Numbers that are not finite are left out.
    """
    space = alone.choices.at(points.numbers, alone.condition_numbers)
    values = {}
    for (key, side), number in space.model_numbers.items():
        is_number = key in keys() and not isinstance(number.value, Spline)
        is_number &= limit_of(key) is None
        if is_number and key not in (PRETENSION, *WORDS):
            name = of_side(key, side) if side and key in space.keys_of_sides else key
            values[name] = float(np.asarray(number.within(space.whole)).item())
    return {key: value for key, value in values.items() if np.isfinite(value)}


def _is_steady(changed: Binding, code: int, state: int) -> bool:
    """Return True if one limit binds in one state, or near it, whichever way a number is changed.

    Args:
        changed: Limits that bind with the number 1 % off, (factors,).
        code: The limit.
        state: The state.
    """
    is_same = (changed.by == code) & (np.abs(changed.state - state) <= _NEAR)
    return bool(is_same.all())


def _changed_bindings(
    solver: Solver, points: Points, keys_of_numbers: Sequence[str]
) -> dict[str, dict[End, Binding]]:
    """Return the limits that set both ends of a choice with one number 1 % off, (factors,) each.

    A number is changed by a factor, whether the choice or a condition sets it. The limits are those
    at samples.

    Args:
        solver: Solver of the question.
        points: The choice.
        keys_of_numbers: Keys of the numbers to change.
    """
    each = len(_FACTORS)
    count = each * len(keys_of_numbers)
    factors = {factor_of(key): np.ones(count) for key in keys_of_numbers}
    places = {key: slice(each * at, each * (at + 1)) for at, key in enumerate(keys_of_numbers)}
    for key, place in places.items():
        factors[factor_of(key)][place] = _FACTORS
    varied = points.select(np.zeros(count, dtype=np.int64)).with_numbers(factors)
    parts = []
    at_once = max(1, WINDOWS_AT_ONCE // len(solver.question.conditions))
    for rows in solver.cut(count, at_once):
        some = varied.select(rows)
        solved, _ = solve_windows(solver, some, solver.read(solver.fold(some), some))
        parts.append(solved)
    if not parts:
        return {}
    solved = Solutions.concatenate(parts)
    return {
        key: {end: solved.binding(end).select(place) for end in ENDS}
        for key, place in places.items()
    }


# --- Sobol indices --------------------------------------------------------------------------------

BODY = "body"
"""Name of all dimensions of a body together: they are correlated, so none has its own index."""

_STATES = 2e7
"""Most states that are worked out for the indices."""
_MOST_POINTS = 4096
_FEWEST_POINTS = 64
_RESAMPLES = 200
"""Samples of the bootstrap."""

ResultsAt = Callable[[Array], Array]
"""Function from points of the unit cube, (points, inputs), to results, (results, points)."""


def sobol(
    results_at: ResultsAt, inputs: tuple[str, ...], names: tuple[str, ...], count: int, seed: int
) -> Iterator[SobolRecord]:
    """Yield first-order and total indices of results, by Saltelli's design of Sobol points.

    Standard errors are bootstrapped, from the samples in which a result varies. A result that is
    not finite everywhere, or never varies, has no indices.

    Args:
        results_at: Function from points to results.
        inputs: Names of the inputs.
        names: Names of the results.
        count: Number of points, a power of two.
        seed: Seed of the random numbers.
    """
    from scipy import stats  # only uncertain numbers pay for its import

    random = np.random.default_rng([seed, 7])
    width = len(inputs)
    points = stats.qmc.Sobol(2 * width, rng=random, bits=64).random(count)
    a, b = np.split(points, 2, axis=1)
    mixed = [np.where(np.arange(width) == place, b, a) for place in range(width)]
    results = results_at(np.concatenate([a, b, *mixed])).reshape(len(names), width + 2, count)
    # SciPy's bootstrap draws anew each time: the same question would not have the same answer.
    draws = random.integers(count, size=(_RESAMPLES, count))

    for name, values in zip(names, results, strict=True):
        if not np.isfinite(values).all() or np.ptp(values[:2]) == 0.0:
            continue
        centred = values - values[:2].mean()
        varied = [draw for draw in draws if np.ptp(values[:2, draw]) > 0.0]
        resampled = [_saltelli(centred[:, draw]) for draw in varied]
        first_error, total_error = np.std(resampled, axis=0, ddof=1)
        first, total = _saltelli(centred)
        of_inputs: dict[str, IndexRecord] = {}
        for place, key in enumerate(inputs):
            of_inputs[key] = IndexRecord(
                name=input_words(key),
                first=float(first[place]),
                first_standard_error=float(first_error[place]),
                total=float(total[place]),
                total_standard_error=float(total_error[place]),
            )
        yield SobolRecord(end=name, standard_deviation=float(np.std(values[0])), inputs=of_inputs)


def _saltelli(values: Array) -> Array:
    """Return first-order and total indices, (2, inputs).

    They are those of Saltelli et al. 2010, table 2, (b) and (f).

    Args:
        values: A result at the points a, at b, and at a with each input of b, (2 + inputs, points).
    """
    at_a = values[0]
    at_b = values[1]
    at_mixed = values[2:]
    first = np.mean(at_b * (at_mixed - at_a), axis=-1)
    total = 0.5 * np.mean(np.square(at_a - at_mixed), axis=-1)
    return np.asarray(np.stack([first, total]) / np.var(values[:2]))


def indices(solver: Solver, points: Points) -> list[SobolRecord]:
    """Return the Sobol indices of both ends of one choice's window, as recorded.

    The window holds under all conditions but persons and draws, which vary; of a table of drawn
    rows the row does. There are no indices if
    the study draws nothing.
    """
    question = solver.question
    study = question.study
    drawing = study.drawing
    if drawing is None or study.usual:
        return []  # the answer says what each deviation does to the window
    people = study.people.population if study.people is not None else None
    person_axis = question.axes.get(PERSON_AXIS)
    laws = study.to_draw
    drawn_axes = [axis for axis in question.conditions.axes if axis.role == "draw"]
    tables = [axis for axis in drawn_axes if axis.key not in (DRAW_AXIS, PERSON_AXIS)]
    inputs = (*laws, *(axis.key for axis in tables))
    if person_axis is not None and len(person_axis) > 1:
        inputs = (*inputs, BODY)
    others = [axis for axis in question.conditions.axes if axis.role != "draw"]
    conditions = int(np.prod([len(axis) for axis in others]))
    cost = cost_per_design(question) * max(1, conditions)
    most = max(_STATES / (cost * (len(inputs) + 2)), 1.0)
    exponent = np.clip(np.floor(np.log2(most)), np.log2(_FEWEST_POINTS), np.log2(_MOST_POINTS))

    def ends_at(places: Array) -> Array:
        """Return both ends of the window at points of the unit cube, (2, points) N."""
        drawn: dict[str, Array] = {}
        if person_axis is not None and people is not None:
            # The last input is a share of the weighting: it selects a person.
            up_to = np.cumsum(normalise(people.weighting))
            rows = np.searchsorted(up_to, places[:, -1], side="right")
            persons = np.minimum(rows, len(people) - 1)
            drawn |= {key: values[persons] for key, values in person_axis.numbers.items()}
        of_laws = {key: quantile(law, places[:, at]) for at, (key, law) in enumerate(laws.items())}
        drawn |= drawn_numbers(study, of_laws)
        for place, axis_of_rows in enumerate(tables, start=len(laws)):
            count = len(axis_of_rows)
            rows = np.minimum((places[:, place] * count).astype(np.int64), count - 1)
            drawn |= {key: values[rows] for key, values in axis_of_rows.numbers.items()}
        axis = replace(Axis.of_points(drawn), key=DRAW_AXIS, role="draw")
        varied = replace(question, conditions=Space((axis, *others)).grouped())
        windows = solver.for_question(varied).ends(points)
        return np.concatenate(varied.groups.windows(windows.low, windows.high))

    ends = ("pretension_from", "pretension_to")
    return list(sobol(ends_at, inputs, ends, int(2**exponent), drawing.seed))
