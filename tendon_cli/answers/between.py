"""What an answer says of its windows between the samples: what was proved, for what, and the lines over the angle."""

from __future__ import annotations

from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.asked import LOADS
from tendon_cli.answers.proofs import Certificate, certified
from tendon_cli.answers.question import Problem
from tendon_cli.answers.solve import Solutions
from tendon_cli.errors import UsageError
from tendon_cli.model.between import end_curves
from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import Rows
from tendon_cli.studies.filters import read_filter
from tendon_cli.studies.study import keys
from tendon_cli.units import shorten

_MOST_PROVED, _MOST_NAMED = 256, 2**24
"""Choices that one name may stand for, and among which."""
METHOD = (
    "interval arithmetic with outward rounding on Taylor forms of second order over cells of the angle and of numbers"
    " in a box, in both directions, at both ends of the window and of the loads"
)


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


def scope(problem: Problem) -> str:
    """For what a proof holds, in words: "every angle from 0 to 90 deg and every load from 0 to 10 kg"."""
    words = [_every("angle", "elbow_angle", problem.angles)]
    for axis in problem.conditions.axes:
        if (axis.key in LOADS or axis.is_interval) and len(axis) > 1:
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
    numbers, pretension = problem.numbers_of(choice.columns), choice["pretension"][:1]
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
