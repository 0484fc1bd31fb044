"""What an answer assumes: deviations that it draws, cuffs, and what each does to the window.

The change of an end of the window by a standard deviation of a number is the coefficient of a
linear fit to the ends of the windows of all draws.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import factor_of, shift_of, split_side
from tendon_cli.studies.study import Study
from tendon_cli.windows.question import Question
from tendon_cli.windows.solutions import Solutions, solve_windows
from tendon_cli.windows.solver import Solver

ANCHOR_STIFFNESS = "anchor.stiffness"
MEASURED_CUFFS = (1050.0, 2250.0)
"""Softest and stiffest pair of cuffs in series that were measured, N/m per tendon: an upper-arm cuff
of 21 persons (Schiebl et al., Sensors 25(15):4605, 2025)."""


def moves_of_ends(
    question: Question, numbers: Mapping[str, Array], low: Array, high: Array
) -> dict[str, tuple[float | None, float | None]]:
    """Return the changes of both ends by a standard deviation of each number that is drawn, N.

    Args:
        question: The question.
        numbers: Drawn numbers, and shifts and factors of deviations, (draws,) each.
        low: Lower ends of the windows of the draws, (draws,).
        high: Upper ends.

    Returns:
        Changes of the lower and of the upper end by key; None for an end that is not finite.
    """
    keys = []
    columns = []
    for key in question.study.to_draw:
        of_key = [numbers[name] for name in (key, factor_of(key), shift_of(key)) if name in numbers]
        if of_key and np.ptp(of_key[0]) > 0.0:
            keys.append(key)
            columns.append((of_key[0] - of_key[0].mean()) / of_key[0].std())
    moves = [_coefficients(columns, ends) for ends in (low, high)]
    return {key: (moves[0][place], moves[1][place]) for place, key in enumerate(keys)}


def _coefficients(columns: list[Array], ends: Array) -> list[float | None]:
    """Return the coefficient of each column in a linear fit to ends, N; None if they cannot tell."""
    is_known = np.isfinite(ends)
    if np.count_nonzero(is_known) <= 2 * len(columns):
        return [None] * len(columns)
    matrix = np.column_stack([*columns, np.ones(len(ends))])[is_known]
    fitted, *_ = np.linalg.lstsq(matrix, ends[is_known], rcond=None)
    return [float(move) for move in fitted[:-1]]


def states_cuffs(study: Study) -> bool:
    """Return True if a study says how far its anchors give, "rigid" included."""
    keys = {key for key, number in study.numbers.items() if number.is_axis or number.uncertain}
    of_rows = {key for table in study.row_tables for key in table.keys}
    sides = (study.anchor, study.anchor.flexor, study.anchor.extensor)
    is_stated = any(side is not None and "stiffness" in side.model_fields_set for side in sides)
    return is_stated or any(split_side(key)[0] == ANCHOR_STIFFNESS for key in (*keys, *of_rows))


def served_with_cuffs(solver: Solver, choices: Solutions, stiffness: float) -> float:
    """Return the largest share that any choice serves with cuffs of a stiffness, N/m per tendon."""
    question = solver.question
    anchors = np.full(len(question.conditions), stiffness)
    with_cuffs = solver.for_question(question.with_numbers({ANCHOR_STIFFNESS: anchors}))
    solved, _ = solve_windows(with_cuffs, choices.points)
    return float(solved.served.max())
