"""The record of an answer: the best choices and their limits, or the conflicts and what helps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tendon_cli.answers.assumed import (
    drawn_deviations,
    exact_numbers,
    largest_first,
    taken_as_given,
)
from tendon_cli.answers.choose import Chosen
from tendon_cli.answers.decision import decision_record
from tendon_cli.answers.help import what_would_help
from tendon_cli.answers.limit_curves import curves_of
from tendon_cli.answers.needed_parts import parts_record
from tendon_cli.answers.notes import (
    PROOF_METHOD,
    note_on_motion,
    note_without_fresh_sample,
    notes_of,
    scope_words,
)
from tendon_cli.answers.question_facts import (
    condition_values,
    goal_record,
    question_record,
    value_at,
    with_named_rows,
)
from tendon_cli.answers.sensitivity import sensitivities
from tendon_cli.answers.setup import drift_record, setting_record
from tendon_cli.engine.cutoff_check import check_of_designs
from tendon_cli.engine.plan import columns_of_motion
from tendon_cli.engine.windows import candidates
from tendon_cli.engine.windows.candidates import LimitPair
from tendon_cli.engine.windows.coverage import normalise, serves
from tendon_cli.engine.windows.question import (
    Question,
    affords_motion,
    is_sought,
    select_numbers,
)
from tendon_cli.engine.windows.solutions import Solutions, solve_windows
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.study_arm import as_read
from tendon_cli.engine.windows.verification import Verified, Verifier, fresh_record
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.window import Ends
from tendon_cli.studies.answer_draws import numbers_of_paper
from tendon_cli.studies.space.axis import PRETENSION, limit_of
from tendon_cli.studies.space.space import Space
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.verbs.answer_record import (
    AnswerResults,
    AssumedRecord,
    BetweenSamples,
    ChecksRecord,
    ChoiceCertificate,
    ChoiceRecord,
    ConflictRecord,
    ListedRecord,
    SensitivityRecord,
    TradeOffRecord,
    Values,
)

_MOST_LISTED = 100
"""Most pretensions of a list that are judged one by one."""


def explain(solver: Solver, solved: Solutions, chosen: Chosen) -> AnswerResults:
    """Return the record of an answer, but for its part on persons or draws.

    Args:
        solver: Solver of the question.
        solved: All choices of the question.
        chosen: Choices that the answer names.
    """
    question = solver.question
    solver = replace(solver, with_motion=False)
    first = chosen.first
    verifier = chosen.verifier
    conflicts = candidates.conflicts_of(solved)
    slopes: list[SensitivityRecord] = []
    if chosen.best:
        slopes = sensitivities(*_nominal(solver, first))
    best = {column: chosen.records(choice)[0] for column, choice in chosen.best.items()}
    record = AnswerResults(
        question=question_record(question),
        choices=len(solved),
        conditions=len(question.conditions),
        feasible=int(solved.feasible.sum()) - chosen.lost,
        trade_offs=[*_trade_offs(chosen)],
        serve=question.serve,
        verified_by=None if verifier is None else fresh_record(verifier.sample),
        goals=[goal_record(goal) for goal in question.goals],
        best=next(iter(best.values()), None),
        best_by={column: row for column, row in best.items() if column and not question.goals},
        decided=None,
        given_up=chosen.given_up,
        window_for_all=None,
        front=[] if chosen.front is None else chosen.records(chosen.front),
        setting=None,
        drift=None,
        parts_needed=None,
        sensitivities=slopes,
        assumed=_assumed(solver, chosen, slopes),
        listed=_listed(solver, first, chosen.judged),
        of_paper=numbers_of_paper(question.stated or question.study),
        checks=_checks(solver, first),
        between_samples=None,
        proved=[] if chosen.proved is None else chosen.records(chosen.proved),
        conflicts=[*_conflicts(solver, chosen, solved, conflicts)],
        fixes=[],
        would_take=[],
        notes=[*_notes(question, verifier)],
        population=None,
    )
    if chosen.best:
        of_first = next(iter(chosen.certificates.values()))
        record.between_samples = _between_samples(solver, chosen)
        record.window_for_all = _window_for_all(question, of_first.ends)
        record.setting = setting_record(question, first, chosen.judged)
        record.drift = drift_record(question, first)
        record.decided = decision_record(
            chosen.question, solved, chosen.candidates, first, record.setting.accuracy
        )
        record.parts_needed = parts_record(solver, first, of_first.ends)
    else:
        binding = {limit for pair in conflicts for limit in pair}
        help_ = what_would_help(solver, first, binding, verifier)
        record.fixes = [*help_.fixes]
        record.would_take = [*help_.relaxations]
        record.notes += help_.notes
    said = (record, chosen.records(first)[0])
    record.question = with_named_rows(record.question, said)
    return record


def _trade_offs(chosen: Chosen) -> Iterator[TradeOffRecord]:
    """Yield the best choice with each value of each limit on which the choices differ."""
    question = chosen.question
    feasible = chosen.relevant.select(chosen.relevant.feasible)
    axes = {axis.key: axis for axis in question.choices.axes}
    for key, of_values in candidates.by_limits(question, feasible).items():
        best: list[ChoiceRecord | None] = []
        for rows in of_values:
            record = None
            if len(rows):
                first = candidates.named_first(question, feasible.select(rows))
                certificate = chosen.certificates.get(first.row.item())
                proved = first if certificate is None else certificate.solution
                (record,) = chosen.records(proved)
            best.append(record)
        values = [value_at(axes[key], place) for place in range(len(axes[key]))]
        yield TradeOffRecord(key=key, column=axes[key].column, values=values, best=best)


def _between_samples(solver: Solver, chosen: Chosen) -> BetweenSamples:
    """Return the record of all proofs, with the scope and curves of the choice named first."""
    of_first = next(iter(chosen.certificates.values()))
    scope = of_first.scope
    of_each = [
        ChoiceCertificate(
            status=certificate.status,
            cells=certificate.cells,
            margin=certificate.margin,
            estimate=certificate.estimate,
            choice=row,
        )
        for row, certificate in chosen.certificates.items()
    ]
    return BetweenSamples(
        status=of_first.status,
        cells=of_first.cells,
        margin=of_first.margin,
        estimate=of_first.estimate,
        choices=of_each,
        method=PROOF_METHOD,
        scope=scope_words(scope.angles, scope.ranges, _times(solver.question)),
        curves=curves_of(solver, chosen.first, of_first.ends),
    )


def _times(question: Question) -> tuple[float, float] | None:
    """Return the first and the last time that count in a motion in time, s; None without one."""
    trajectory = question.study.trajectory
    if trajectory is None:
        return None
    counted = trajectory.time[trajectory.counted]
    return float(counted[0]), float(counted[-1])


def _checks(solver: Solver, choice: Solutions) -> ChecksRecord | None:
    """Return the checks of a choice at its pretension, None without a trajectory.

    A choice without a window is checked at the pretension that it asks for, or else at the study's.
    """
    stated = solver.question.study.numbers[PRETENSION].array[:1]
    known = (choice.pretension, choice.pretension_from, stated)
    pretension = next(values for values in known if np.isfinite(values).all())
    at_pretension = choice.points.at_pretension(pretension)
    designs = (design for _, _, design in solver.portions(at_pretension))
    check = check_of_designs(solver.question.study, designs)
    return None if check is None else ChecksRecord(cutoff=check)


def _nominal(solver: Solver, choice: Solutions) -> tuple[Solver, Solutions]:
    """Return the solver of the suit without deviations where these are drawn, and its solution.

    Drawn rows that set limits stay: no other number of the study says what the suit must keep.
    """
    question = solver.question
    if not question.study.usual:
        return solver, choice
    others = tuple(
        axis
        for axis in question.conditions.axes
        if axis.role != "draw" or any(map(limit_of, axis.numbers))
    )
    sample = replace(question.sample, enough=1.0, sets_by_sample=False)
    exact = replace(question, conditions=Space(others), serve=1.0, sample=sample)
    of_suit = solver.for_question(exact)
    solved, _ = solve_windows(of_suit, choice.points)
    return of_suit, solved


def _listed(solver: Solver, choice: Solutions, judged: Verified | None) -> list[ListedRecord]:
    """Return the pretensions that a study lists, judged with one choice.

    A fresh sample judges, or without one the conditions.
    """
    question = solver.question
    stated = question.study.numbers[PRETENSION]
    if not stated.is_axis or len(stated) > _MOST_LISTED:
        return []
    low, high = judged.windows if judged is not None else _windows_of(solver, choice)
    weights = np.ones(len(low)) if judged is None else judged.sample.weighting
    repeated = choice.points.select(np.zeros(len(stated), dtype=np.int64))
    readings = as_read(question, repeated, stated.array)
    records = []
    for pretension, reading in zip(stated.array.tolist(), readings.tolist(), strict=True):
        share = float(normalise(weights) @ serves(low, high, reading))
        records.append(ListedRecord(pretension=pretension, reading=reading, served=min(share, 1.0)))
    return records


def _windows_of(solver: Solver, choice: Solutions) -> tuple[Array, Array]:
    """Return the ends of the windows of one choice under each group, (groups,) each, N."""
    ends = solver.ends(choice.points)
    low, high = solver.question.groups.windows(ends.low, ends.high)
    return low[0], high[0]


def _assumed(
    solver: Solver, chosen: Chosen, slopes: list[SensitivityRecord]
) -> list[AssumedRecord]:
    """Return what an answer assumes, what moves the window most first.

    Args:
        solver: Solver of the question.
        chosen: Choices that the answer names.
        slopes: Derivatives of the ends of the window of the first one.
    """
    question = solver.question
    choice = chosen.first
    if chosen.judged is not None:
        numbers = chosen.judged.sample.axis.numbers
        assumed = drawn_deviations(question, choice, numbers, *chosen.judged.windows)
    elif question.study.usual:
        numbers = select_numbers(question.condition_numbers, question.groups.first_conditions)
        assumed = drawn_deviations(question, choice, numbers, *_windows_of(solver, choice))
    else:
        return largest_first(exact_numbers(question, slopes))
    if question.study.usual and not is_sought(question):
        assumed += taken_as_given(solver, choice, chosen.relevant)
    return largest_first(assumed)


# --- The record -----------------------------------------------------------------------------------


def _window_for_all(question: Question, ends: Ends) -> list[float | None] | None:
    """Return the window that serves all, N; None if there is none, or if all must be served."""
    if question.serve >= 1.0:
        return None
    low = float(ends.low.max())
    high = float(ends.high.min())
    if not low <= high:
        return None
    return [low, finite_or_none(high)]


def _notes(question: Question, verifier: Verifier | None) -> Iterator[str]:
    """Yield the notes of a question, and on worst values or a fresh sample that it lacks."""
    yield from notes_of(question)
    if verifier is None and question.conditions.groups is not None:
        is_wanted = question.study.design.verify > 0
        yield note_without_fresh_sample(question.groups.noun, is_wanted=is_wanted)
    choices = len(question.choices)
    if columns_of_motion(question.study) and not affords_motion(question, choices):
        yield note_on_motion(choices)


def _conflicts(
    solver: Solver, chosen: Chosen, solved: Solutions, conflicts: dict[LimitPair, Rows]
) -> Iterator[ConflictRecord]:
    """Yield the limits that leave choices without a window, the most frequent conflict first.

    `gap` is the distance between the pretensions asked for, N, in the choice that is nearest to a
    window; null if there is no such distance.
    """
    most_frequent_first = sorted(conflicts.items(), key=lambda one: (-len(one[1]), one[0]))
    for pair, rows in most_frequent_first:
        closest = candidates.nearest(chosen.question, solved.select(rows))
        gap = float(closest.pretension_from[0]) - float(closest.pretension_to[0])
        yield ConflictRecord(
            limits=list(pair),
            choices=len(rows),
            gap=finite_or_none(gap),
            nearest=chosen.records(closest)[0],
            fails=_failing_conditions(solver, closest),
        )


def _failing_conditions(solver: Solver, choice: Solutions) -> list[Values]:
    """Return the conditions that a choice does not keep; none if persons or draws are counted."""
    question = solver.question
    if question.conditions.groups is not None:
        return []
    ends = solver.ends(choice.points)
    is_kept = serves(ends.low, ends.high, choice.pretension[:, np.newaxis])[0]
    return [condition_values(question, row) for row in np.flatnonzero(~is_kept).tolist()]


def named_rows(record: AnswerResults) -> list[ChoiceRecord]:
    """Return the choices that a record names, in the order of their rows in the table."""
    rows = [row for limit in record.trade_offs for row in limit.best if row is not None]
    rows += record.proved
    if record.best:
        rows.append(record.best)
    rows += [*record.best_by.values(), *record.front]
    named = {row.choice: row for row in rows}
    return [named[choice] for choice in sorted(named)]
