"""Assumptions of an answer: deviations, drawn or not, cuffs and posture, and what each does.

Where deviations are drawn, the change of an end of the window by a standard deviation of a number
is the coefficient of a linear fit to the ends of the windows of all draws. In an exact suit it is
the derivative of the end (`sensitivity.py`) times the usual deviation.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from tendon_cli import say
from tendon_cli.engine.windows.question import LEAN, Question
from tendon_cli.engine.windows.solutions import Solutions, solve_windows
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.model.kinematics import Array, Spline
from tendon_cli.studies.space.axis import factor_of, shift_of, split_side
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.usual import USUAL
from tendon_cli.studies.values import Uncertain
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.verbs.answer_record import AssumedRecord, SensitivityRecord

ANCHOR_STIFFNESS = "anchor.stiffness"
MEASURED_CUFFS = (1050.0, 2250.0)
"""Softest and stiffest pair of cuffs in series that were measured, N/m per tendon: an upper-arm
cuff of 21 persons (Schiebl et al., Sensors 25(15):4605, 2025)."""
_OTHER_POSTURE = math.radians(10.0)
"""Angle by which the upper arm may lean otherwise than the study says, rad."""
_HALF_UNIFORM = math.sqrt(3.0)
"""Half the width of a uniform distribution over its standard deviation."""


# --- Deviations that are drawn --------------------------------------------------------------------


def drawn_deviations(
    question: Question, choice: Solutions, numbers: Mapping[str, Array], low: Array, high: Array
) -> list[AssumedRecord]:
    """Return the deviations that an answer draws.

    Args:
        question: The question.
        choice: The choice that is named first.
        numbers: Drawn numbers, and shifts and factors of deviations, (draws,) each.
        low: Lower ends of the windows of the draws, (draws,), as they are read.
        high: Upper ends.
    """
    study = question.study
    nominal = question.choices.at(choice.points.numbers, question.arm)
    columns = {}
    values = {}
    for key in study.to_draw:
        number = nominal.number(*split_side(key)).within(nominal.whole)
        if isinstance(number, Spline):
            continue  # a curve does not deviate
        of_key = [numbers[name] for name in (key, factor_of(key), shift_of(key)) if name in numbers]
        if of_key and np.ptp(of_key[0]) > 0.0:
            columns[key] = (of_key[0] - of_key[0].mean()) / of_key[0].std()
            values[key] = float(np.ravel(number)[0])
    moves_from = _coefficients([*columns.values()], low)
    moves_to = _coefficients([*columns.values()], high)
    records = []
    for place, key in enumerate(columns):
        usual = study.usual.get(key)
        if usual is None:
            law = study.to_draw[key]
            value = law.middle
            deviation = _standard_deviation(law)
            words = say.quantity(keys()[split_side(key)[0]].quantity, deviation, 2)
            source = "a fit to logs" if study.fitted_from is not None else "the study"
            kind = law.kind
        else:
            value = values[key]
            deviation = usual.of(value)
            words = usual.text(split_side(key)[0])
            source = usual.source
            kind = usual.law().kind
        of_study = "study" if study.fitted_from is None else "fit"
        origin = of_study if usual is None else "usual"
        records.append(
            AssumedRecord(
                key=key,
                value=finite_or_none(value),
                deviation=finite_or_none(deviation),
                deviation_words=words,
                kind=kind,
                source=source,
                from_=origin,
                moves_from=moves_from[place],
                moves_to=moves_to[place],
            )
        )
    return records


def _standard_deviation(law: Uncertain) -> float:
    """Return the standard deviation of a number, SI, as if nothing were cut off."""
    return law.spread / _HALF_UNIFORM if law.kind == "uniform" else law.spread


def _coefficients(columns: list[Array], ends: Array) -> list[float | None]:
    """Return the coefficient of each column in a linear fit to ends, N; None if it is not known."""
    is_known = np.isfinite(ends)
    if np.count_nonzero(is_known) <= 2 * len(columns):
        return [None] * len(columns)
    matrix = np.column_stack([*columns, np.ones(len(ends))])[is_known]
    fitted, *_ = np.linalg.lstsq(matrix, ends[is_known], rcond=None)
    return [float(move) for move in fitted[:-1]]


# --- Deviations that are not drawn ----------------------------------------------------------------


def exact_numbers(
    question: Question, sensitivities: Sequence[SensitivityRecord]
) -> list[AssumedRecord]:
    """Return the effect of usual errors of the numbers that a question takes as exact.

    Numbers that the study does not state, and those that it draws, takes from a body or varies as
    conditions, are left out.

    Args:
        question: The question.
        sensitivities: Derivatives of the ends of the window of the choice named first.

    Returns:
        A record of each number that moves an end.
    """
    stated = {split_side(key)[0] for key in question.study.numbers}
    varied = {
        key
        for axis in question.conditions.axes
        if axis.role == "draw" or axis.key in axis.numbers
        for key in axis.numbers
    }
    records: dict[str, AssumedRecord] = {}
    for slope in sensitivities:
        key = slope.key
        common = split_side(key)[0]
        if common not in USUAL or common not in stated or key in varied:
            continue
        usual = USUAL[common]
        deviation = usual.of(slope.value)
        if key not in records:
            records[key] = AssumedRecord(
                key=key,
                value=slope.value,
                deviation=deviation,
                deviation_words=usual.text(common),
                kind="exact",
                source=usual.source,
                from_="usual",
                moves_from=None,
                moves_to=None,
            )
        change = slope.slope * deviation
        if slope.end == "from":
            records[key].moves_from = change
        else:
            records[key].moves_to = change
    return [record for record in records.values() if largest_move(record) > 0.0]


def largest_first(records: Iterable[AssumedRecord]) -> list[AssumedRecord]:
    """Sort numbers, the one that moves an end of the window most first."""
    return sorted(records, key=lambda record: -largest_move(record))


def largest_move(record: AssumedRecord) -> float:
    """Return the larger change of either end by a deviation of a number, by magnitude, N."""
    return max(abs(record.moves_from or 0.0), abs(record.moves_to or 0.0))


# --- What is taken as given -----------------------------------------------------------------------


def taken_as_given(solver: Solver, choice: Solutions, others: Solutions) -> Iterator[AssumedRecord]:
    """Yield what a study takes as given, and whom the answer would serve if it were otherwise.

    Args:
        solver: Solver of the question.
        choice: The choice that is named first.
        others: All choices that may be named.
    """
    study = solver.question.study
    changes: list[tuple[str, float | None, float, str]] = []
    if not states_cuffs(study):
        source = "an upper-arm cuff of 21 persons"
        changes += [(ANCHOR_STIFFNESS, None, stiffness, source) for stiffness in MEASURED_CUFFS]
    if LEAN not in solver.question.axes:
        stated = float(study.numbers[LEAN].array[0])
        source = "posture changes while a suit is worn"
        postures = (stated - _OTHER_POSTURE, stated + _OTHER_POSTURE)
        changes += [(LEAN, stated, other, source) for other in postures]
    if changes:
        before, _ = solve_windows(solver, choice.points)
        at = np.where(others.row == choice.row, choice.pretension, np.nan)
        for change in changes:
            yield _otherwise(solver, before, others, at, *change)


def states_cuffs(study: Study) -> bool:
    """Return True if a study says how far its anchors give, "rigid" included."""
    varied = {key for key, number in study.numbers.items() if number.is_axis or number.uncertain}
    of_rows = {key for table in study.row_tables for key in table.keys}
    parts = (study.anchor, study.anchor.flexor, study.anchor.extensor)
    is_stated = any(part is not None and "stiffness" in part.model_fields_set for part in parts)
    return is_stated or any(split_side(key)[0] == ANCHOR_STIFFNESS for key in varied | of_rows)


def _otherwise(
    solver: Solver,
    before: Solutions,
    others: Solutions,
    at: Array,
    key: str,
    value: float | None,
    other: float,
    source: str,
) -> AssumedRecord:
    """Return whom choices serve, and how the window moves, if a number were another one.

    Args:
        solver: Solver of the question.
        before: The choice that is named first, solved with the stated number.
        others: All choices that may be named, that one among them.
        at: Its pretension in its place, (others,), N; else NaN.
        key: Key of the number.
        value: Value that the study takes; None for a rigid one.
        other: Another value.
        source: Reason why it may be the other one.
    """
    question = solver.question
    numbers = {key: np.full(len(question.conditions), other)}
    changed = solver.for_question(question.with_numbers(numbers))
    ends = changed.ends(others.points, at)
    anew, _ = solve_windows(changed, others.points, ends)
    is_served = question.groups.served_at(ends.low, ends.high, at)
    place = int(np.flatnonzero(others.row == before.row)[0])
    after = anew.select([place])
    return AssumedRecord(
        key=key,
        value=value,
        deviation=None,
        deviation_words=say.quantity(keys()[key].quantity, other, 3),
        kind="given",
        source=source,
        from_="study" if value is not None else "usual",
        moves_from=_move(before.pretension_from[0], after.pretension_from[0]),
        moves_to=_move(before.pretension_to[0], after.pretension_to[0]),
        other=other,
        served=float(question.groups.share(is_served)[place]),
        served_anew=float(anew.served.max()),
    )


def _move(before: float, after: float) -> float | None:
    """Return by how much an end of a window moves, N; None if either end is infinite or none."""
    if not (np.isfinite(before) and np.isfinite(after)):
        return None
    return float(after - before)
