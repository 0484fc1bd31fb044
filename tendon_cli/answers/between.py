"""What holds between the angles and loads that were taken: proofs of the windows that an answer names."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.candidates import numbers_of
from tendon_cli.answers.coverage import grouped
from tendon_cli.answers.question import LEAN, LINEAR, Flags, Problem
from tendon_cli.answers.solve import STATUSES, Solutions, without_worst, worst
from tendon_cli.errors import UsageError
from tendon_cli.model.between import end_curves, refined
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.motor_window import narrowed
from tendon_cli.model.proof import MOST_CELLS, Cells, Proof, cells_of, knots_of, prove
from tendon_cli.model.setting import pretension_of
from tendon_cli.model.window import Ends, Window, as_read
from tendon_cli.space.axis import Numbers, Rows, scale_of
from tendon_cli.studies.filters import read_filter
from tendon_cli.studies.study import keys
from tendon_cli.units import shorten

_MARGIN = 1e-6
"""N; by which a window is proved at either end less than it is given: there a limit is just kept."""
_ENDLESS = 1e6
"""N; how far a window is proved that nothing bounds."""
_GRIDS, _MOST_NEAR = 16, 16
"""By which a window is estimated that is sampled, and for how many of its tightest conditions at either end."""
_SAFE, _MISSED = 1.1, 0.05
"""The dense grid misses at most 3 % of what is missed near an end, and elsewhere 1.2 % of the worst; the rest is
room."""
_MOST_PROVED, _MOST_NAMED = 256, 2**24
"""Choices that one name may stand for, and among which."""
_ARCS = 8
"""Of an interval of postures; so many at first."""
_ROUNDS = 24
"""In which a proof may find what an end is tightened by."""
METHOD = (
    "interval arithmetic with outward rounding on Taylor forms of second order over cells of the angle,"
    " in both directions, at both ends of the window and of the loads"
)
_LOADS = LINEAR[:2]
"""Of these a list is meant with all between; of others that hold an interval alone is."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """What is known of the window of one choice between the samples."""

    status: str
    cells: int
    margin: float
    """N."""
    estimate: float | None = None
    """By how much its ends may be off that are not proved, N."""


@dataclass(frozen=True, eq=False)
class _Held:
    """What a window is held to: conditions, each in one posture of the upper arm or in all between two."""

    row: Rows
    """Of the conditions."""
    low: Array
    high: Array
    """Inclinations of the upper arm, rad; NaN where that of the condition holds."""

    @classmethod
    def of(cls, problem: Problem) -> _Held:
        """The conditions but those with a load between others; of an interval of postures ends and arcs between."""
        needed = np.ones(len(problem.conditions), dtype=np.bool_)
        places = problem.conditions.places(np.arange(len(needed)))
        for axis in problem.conditions.axes:
            if axis.key in _LOADS:
                needed &= np.isin(axis.values[places[axis.key]], (axis.values.min(), axis.values.max()))
        rows = np.flatnonzero(needed)
        leaning = next((axis for axis in problem.conditions.axes if axis.key == LEAN and axis.is_interval), None)
        if leaning is None:
            return cls(rows, *np.full((2, len(rows)), np.nan))
        rows = rows[places[LEAN][rows] == 0]
        edges = np.linspace(leaning.values.min(), leaning.values.max(), _ARCS + 1)
        low, high = np.append(edges[:-1], edges[[0, -1]]), np.append(edges[1:], edges[[0, -1]])
        return cls(np.repeat(rows, len(low)), np.tile(low, len(rows)), np.tile(high, len(rows)))

    def __len__(self) -> int:
        return len(self.row)

    def taken(self, which: Any) -> _Held:
        """Some of them."""
        return _Held(self.row[which], self.low[which], self.high[which])

    def halved(self, which: Flags) -> _Held:
        """All, some of them in two."""
        some, middle = self.taken(which), 0.5 * (self.low + self.high)[which]
        rows = np.concatenate([self.row[~which], some.row, some.row])
        return _Held(
            rows,
            np.concatenate([self.low[~which], some.low, middle]),
            np.concatenate([self.high[~which], middle, some.high]),
        )

    @property
    def middles(self) -> _Held:
        """The posture in the middle of each."""
        middle = 0.5 * (self.low + self.high)
        return _Held(self.row, middle, middle)

    def design(self, problem: Problem, numbers: Numbers) -> Design:
        """Designs of one choice, (held, 1, 1).

        Limits are linear in sine and cosine of the forearm's inclination: what holds at the point where the tangents at
        the ends of an arc meet, and at both ends of all arcs, holds on the arcs. There the weights are larger.
        """
        if np.isnan(self.low).all():
            return problem.paired(numbers, np.zeros_like(self.row), self.row)
        grown = (1.0 + 1e-12) / np.cos(0.5 * (self.high - self.low))
        weights = {scale_of(key): grown for key in ("arm.forearm_mass", "load.mass")}
        return problem.paired(numbers, np.zeros_like(self.row), self.row, {LEAN: self.middles.low, **weights})


def certified(problem: Problem, one: Solutions) -> tuple[Solutions, Certificate]:
    """One choice with its window proved; tightened where the proof meets a state that does not keep a limit."""
    exactly = replace(problem, near=np.inf) if problem.enough < 1.0 else problem
    numbers, held, cells = numbers_of(problem, one.columns), _Held.of(problem), 0
    ends = exactly.ends_over_angles(numbers, 1)
    provable = one.has_window.item() and problem.study.trajectory is None
    for _ in range(_ROUNDS if provable else 0):
        low, high = _served(exactly, exactly.finished(ends, numbers), one)
        margin = min(_MARGIN, 0.25 * float(np.max(high - low)))
        asked = held.taken((high - low)[held.row] >= 2.0 * margin)
        proof = _proof(problem, numbers, asked, low + margin, high - margin)
        cells += proof.cells
        failing = np.unique(np.concatenate([proof.broken.row, proof.left.row]))
        if not len(failing):
            return _with_status(one, _status(problem), cells, margin, estimated(problem, numbers, one))
        if cells > MOST_CELLS:
            break
        points = asked.taken(failing).middles
        broken = _proof(problem, numbers, points, low + margin, high - margin).broken
        if len(broken):
            ends = _tightened(exactly, numbers, ends, broken, points)
            one = _solved_again(exactly, numbers, one, ends)
            if not one.has_window.item():
                break
        arcs = asked.high[failing] > asked.low[failing]
        if not len(broken) and not arcs.any():
            break
        which = np.zeros(len(asked), dtype=np.bool_)
        which[failing[arcs]] = True
        held = asked.halved(which)
    return _with_status(one, "open" if cells else "sampled", cells, 0.0)


def _proof(problem: Problem, numbers: Numbers, held: _Held, low: Array, high: Array) -> Proof:
    """That of one choice from `low` to `high`, (conditions,) N as they are read."""
    design, span = held.design(problem, numbers), (float(problem.angles.min()), float(problem.angles.max()))
    at_low, at_high = (
        np.broadcast_to(pretension_of(design, end[held.row, np.newaxis, np.newaxis]), (len(held), 1, 1)).ravel()
        for end in (low, np.minimum(high, _ENDLESS))
    )
    cells = cells_of(len(held), span, problem.flexion, knots_of(design))
    return prove(design, cells, at_low, at_high, problem.bounds)


def _status(problem: Problem) -> str:
    """What a proof that is done comes to."""
    intervals = {axis.key for axis in problem.conditions.axes if axis.is_interval}
    return "sampled" if problem.bounds.of_motion or intervals - {*LINEAR, LEAN} else "proven"


def rows_to_prove(problem: Problem) -> Rows:
    """The choices that the study names in `[design] prove`; raises UsageError for what names none."""
    count, rows = len(problem.choices), list[int]()
    for text in problem.study.design.prove:
        if text.strip().isdecimal() and int(text) < count:
            rows.append(int(text))
            continue
        if text.strip().isdecimal() or count > _MOST_NAMED:
            raise UsageError(f'"{text}" is no row of choices.parquet', where="--prove", hint=f"0 to {count - 1}")
        kept, columns = np.ones(count, dtype=np.bool_), problem.choices.columns(np.arange(count))
        for part in text.split(";"):
            asked = read_filter(part)
            axis = next((axis for axis in problem.choices.axes if asked.name in (axis.column, axis.key)), None)
            if axis is None:
                names = ", ".join(axis.column for axis in problem.choices.axes) or "this study has one choice"
                raise UsageError(f'"{shorten(asked.name)}" is no axis of the choices', where="--prove", hint=names)
            words = np.array(axis.names, dtype=object)[columns[axis.column]] if axis.names else columns[axis.column]
            quantity = None if axis.names else keys()[axis.key].number.quantity
            kept &= asked.on(axis.column, quantity).holds(words, of_axis=True)
        if not 0 < kept.sum() <= _MOST_PROVED:
            counted = say.counted(int(kept.sum()), "choice")
            raise UsageError(f'"{shorten(text)}" names {counted}, expected 1 to {_MOST_PROVED}', where="--prove")
        rows += np.flatnonzero(kept).tolist()
    return np.unique(np.array(rows, dtype=np.int64))


class Proofs:
    """Certificates of the choices that an answer names, each once."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._done: dict[tuple[float, ...], tuple[Solutions, Certificate]] = {}

    @property
    def done(self) -> list[tuple[Solutions, Certificate]]:
        """In the order in which they were asked for."""
        return [*self._done.values()]

    def of(self, some: Solutions) -> Solutions:
        """Choices with their windows proved, or tightened."""
        return Solutions.joined([self._of(some.taken(np.array([at]))) for at in range(len(some))])

    def _of(self, one: Solutions) -> Solutions:
        place = tuple(float(values[0]) for values in one.columns.values())
        if place not in self._done:
            self._done[place] = certified(self.problem, one)
        return self._done[place][0]


def estimated(problem: Problem, numbers: Numbers, one: Solutions) -> float | None:
    """By how much the ends that limits on the whole motion set may be off, N, as they are read.

    It is what a grid sixteen times as dense takes from the window of the conditions that it serves. That grid misses,
    too: of a peak between two angles a share of what grids as wide as the window's, displaced by shares of a step, miss
    at worst; of one near the first or last angle, which all grids hold, a share of what the window's misses.
    """
    if not problem.bounds.of_motion:
        return None
    ends, window = problem.ends(numbers, 1), (one["pretension_from"][0], one["pretension_to"][0])
    low, high = (
        np.where(each[0] * sign <= end * sign, each[0] * sign, -np.inf)
        for each, end, sign in zip((ends.low, ends.high), window, (1.0, -1.0), strict=True)
    )
    rows = np.unique([*np.argsort(-low)[:_MOST_NEAR], *np.argsort(-high)[:_MOST_NEAR]])
    found = replace(problem, bounds=problem.bounds.of_states).windows(numbers, 1)
    some = Window(**{name: values[0, rows] for name, values in vars(found).items()})
    design = problem.paired(numbers, np.zeros_like(rows), rows)

    def ends_over(angles: Array) -> Array:
        grid = np.unique(angles)[np.newaxis]
        each = as_read(narrowed(some, design, grid, problem.flexion, problem.bounds, problem.loads).window, design)
        return np.array([each.low.max(), -each.high.min()])

    angles, step = problem.angles[0], np.diff(problem.angles)[0, 0]
    displaced = [np.append(angles[:-1] + share * step, angles[[0, -1]]) for share in np.arange(_GRIDS) / _GRIDS]
    near_ends = step * 2.0 ** (-0.5 * np.arange(1, 2 * _GRIDS))
    finest = ends_over(np.concatenate([*displaced, angles[0] + near_ends, angles[-1] - near_ends]))
    with np.errstate(invalid="ignore"):
        off = [np.nan_to_num(finest - ends_over(grid), nan=0.0, posinf=np.inf) for grid in displaced]
    estimate = float(np.max(_SAFE * np.maximum(off[0], 0.0) + _MISSED * np.max(off, axis=0)) + _MARGIN)
    return estimate if np.isfinite(estimate) else None


def _with_status(
    one: Solutions, status: str, cells: int, margin: float, estimate: float | None = None
) -> tuple[Solutions, Certificate]:
    known = {"between_samples": np.array([STATUSES.index(status)])}
    return replace(one, results=one.results | known), Certificate(status, cells, margin, estimate)


def _served(problem: Problem, ends: Ends, one: Solutions) -> tuple[Array, Array]:
    """Between which pretensions, as they are read, conditions must hold, (conditions,); empty where they need not."""
    low, high = one["pretension_from"], one["pretension_to"]
    if problem.enough >= 1.0:
        return np.repeat(low, len(problem.conditions)), np.repeat(high, len(problem.conditions))
    begin, end = (each[0] for each in grouped(ends.low, ends.high, problem.groups))
    return np.maximum(begin, low)[problem.groups], np.minimum(end, high)[problem.groups]


def _tightened(problem: Problem, numbers: Numbers, ends: Ends, broken: Cells, held: _Held) -> Ends:
    """Ends of one choice, tightened around the states in which a limit is not kept."""
    ends = Ends(**{name: values.copy() for name, values in vars(ends).items()})
    angles, middle = problem.angles.ravel(), 0.5 * (broken.low + broken.high)
    direction = (broken.flexion[:, np.newaxis] == problem.flexion.ravel()).argmax(axis=1)
    state = direction * len(angles) + np.abs(middle[:, np.newaxis] - angles).argmin(axis=1)
    for name, upper in (("low", False), ("high", True)):
        row, near = np.unique(np.stack([broken.row, state])[:, broken.upper == upper], axis=1)
        if not len(row):
            continue
        some, start = held.taken(row), np.full(len(row), np.inf if upper else -np.inf)
        found = refined(
            some.design(problem, numbers), near, start, angles, problem.flexion, problem.bounds, upper=upper
        )
        value, of_state, of_angle = (getattr(ends, f"{name}{of}") for of in ("", "_state", "_angle"))
        for at, end, its_state, its_angle in zip(some.row, *found, strict=True):
            if (end < value[0, at]) if upper else (end > value[0, at]):
                value[0, at], of_state[0, at], of_angle[0, at] = end, its_state, its_angle
    return ends


def _solved_again(problem: Problem, numbers: Numbers, one: Solutions, ends: Ends) -> Solutions:
    """One choice, from ends of its windows over all angles."""
    solved, held = without_worst(problem, numbers, 1, problem.finished(ends, numbers))
    worsts = worst(problem, numbers, solved["pretension"], held)
    return replace(one, results=solved.with_worst(slice(None), worsts).results)


def scope(problem: Problem) -> str:
    """For what a proof holds, in words: "every angle from 0 to 90 deg and every load from 0 to 10 kg"."""
    words = [_every("angle", "elbow_angle", problem.angles)]
    for axis in problem.conditions.axes:
        if (axis.key in _LOADS or axis.is_interval) and len(axis) > 1:
            quantity = keys()[axis.key].number.quantity
            words.append(
                _every(
                    "load" if axis.key == "load.mass" else quantity.name.replace("_", " "), quantity.name, axis.values
                )
            )
    return say.listed(words)


def _every(what: str, quantity: str, values: Array) -> str:
    low, high = (say.quantity(quantity, float(end)) for end in (values.min(), values.max()))
    unit = high.partition(" ")[2]
    return f"every {what} from {low.removesuffix(' ' + unit)} to {high}"


def between_record(problem: Problem, chosen: Solutions) -> dict[str, Any]:
    """How, and for what, windows are proved, and the curves of the choice named first."""
    return {"method": METHOD, "scope": scope(problem), "curves": curves_of(problem, chosen)}


def curves_of(problem: Problem, choice: Solutions) -> dict[str, Any]:
    """One choice over the elbow angle (rad): what each limit asks for, N, over both directions and all conditions.

    If some conditions are not served at its pretension, only those that are count (`all_conditions`). `lower` and
    `upper` have by limit the least and the largest pretensions, null where it asks for nothing; `samples` are the
    study's angles. Limits on the whole motion have no curve.
    """
    lower, upper = dict[str, Array](), dict[str, Array]()
    numbers, pretension = numbers_of(problem, choice.columns), choice["pretension"][:1]
    ends = problem.ends(numbers, 1)
    serves = (ends.low <= pretension) & (pretension <= ends.high)
    counts = serves if serves.any() else ~serves
    for _, conditions, design in problem.chunks(numbers, 1):
        held = counts[:, conditions, np.newaxis, np.newaxis]
        some = end_curves(design, problem.angles, problem.flexion, problem.bounds, held)
        for whole, part, tighter in zip((lower, upper), some, (np.maximum, np.minimum), strict=True):
            whole |= {name: tighter(values, whole.get(name, values)) for name, values in part.items()}
    return {
        "elbow_angle": problem.angles.ravel().tolist(),
        "samples": np.unique(problem.study.angles).tolist(),
        "all_conditions": bool(counts.all()),
        "lower": {name: _listed(values) for name, values in lower.items()},
        "upper": {name: _listed(values) for name, values in upper.items()},
    }


def _listed(values: Array) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]
