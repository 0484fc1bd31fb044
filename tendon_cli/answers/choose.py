"""The second stage of an answer: which choices it names, how they are set, proved and judged.

The first stage solves all choices; those that may be named are set by a second sample if the
question has one, their windows are proved, and a third sample judges them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from tendon_cli.answers.question_facts import condition_values
from tendon_cli.answers.tables import VERIFIED, as_records, choice_columns, choice_rows
from tendon_cli.engine.windows import candidates
from tendon_cli.engine.windows.question import (
    Question,
    affords_motion,
    of_second_sample,
    rows_to_prove,
)
from tendon_cli.engine.windows.solutions import Solutions, solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.verification import Verified, Verifier
from tendon_cli.model.kinematics import Rows
from tendon_cli.proof.certify import Certificate, Report, certify
from tendon_cli.verbs.answer_record import ChoiceRecord

_NO_ROWS: Rows = np.empty(0, dtype=np.int64)
Best = dict[str, Solutions]
"""Best choice by each goal's column; the best compromise of a front under an empty name."""
Certificates = dict[int, Certificate]
"""Certificates by the rows of their choices, in the order of the proofs."""


@dataclass(frozen=True, eq=False)
class Chosen:
    """Choices that an answer names, with their windows proved."""

    question: Question
    """The question, about choices that the second sample has set."""
    candidates: Solutions
    """Choices that may be named, before any proof."""
    relevant: Solutions
    """The same after the proofs; those that lost their window by one have none."""
    lost: int
    """Number of them that had a window by the question's own sample, and have none now."""
    best: Best
    """Best choices; none if no choice has a window."""
    front: Solutions | None
    """Choices that no other beats, in the order of the first goal; None without several goals."""
    given_up: float | None
    """Largest share of the span of any goal on the front that the best compromise gives up."""
    proved: Solutions | None
    """Choices that the study asks to be proved; None if it asks for none."""
    certificates: Certificates
    first: Solutions
    """Choice that is named first, or else the one that is nearest to a window."""
    verifier: Verifier | None
    """Judge; None without a fresh sample."""
    verified: Mapping[int, Verified]
    """Its judgements on the choices named, by their rows."""
    judged: Verified | None
    """Its judgement on the first choice."""

    @property
    def rows_on_front(self) -> Rows:
        """Rows of the choices that no other beats; none if the study leaves its goals open."""
        if self.front is not None:
            return self.front.row
        if len(self.question.goals) == 1 and self.best:
            return next(iter(self.best.values())).row
        return _NO_ROWS

    def records(self, choices: Solutions) -> list[ChoiceRecord]:
        """Return choices as rows of the table for JSON, with their rows and what binds them."""
        return choice_records(self.question, choices, self.rows_on_front, self.verified)


def choose(solver: Solver, solved: Solutions, report: Report) -> Chosen:
    """Choose what an answer names.

    A choice that seems to have a window may lose it by the proof: then the best are chosen again
    without it.

    Args:
        solver: Solver of the question.
        solved: All choices of the question.
        report: Called as each proof goes on.
    """
    to_prove = rows_to_prove(solver.question)
    rows = np.union1d(candidates.relevant(solved, solver.question), to_prove)
    of_own_sample = solved.select(rows)
    with_motion = replace(solver, with_motion=affords_motion(solver.question, len(rows)))
    second = _second_sample(with_motion)
    if second is not None:
        as_set = _set_by(second, with_motion, of_own_sample)
    elif with_motion.columns_of_motion != solver.columns_of_motion:
        as_set = solve(with_motion, of_own_sample.points)
    else:
        as_set = of_own_sample
    question = of_second_sample(solver.question)
    relevant = as_set
    while True:
        best, front = _best_of(question, relevant)
        certificates: Certificates = {}
        given_up = None
        if front is not None:
            lost_goals = candidates.losses(front.scores(question.goals))
            given_up = float(lost_goals.max(axis=1).min())
        for column, choice in best.items():
            best[column] = _certified(with_motion, choice, certificates, report)
        if front is not None:
            front = _certified(with_motion, front, certificates, report)
        proved = None
        if len(to_prove):
            asked_for = relevant.select(np.isin(relevant.row, to_prove))
            proved = _certified(with_motion, asked_for, certificates, report)
        lost_windows = _lost_windows(relevant, certificates)
        if not lost_windows:
            break
        is_unchanged = ~np.isin(relevant.row, [choice.row.item() for choice in lost_windows])
        relevant = Solutions.concatenate([relevant.select(is_unchanged), *lost_windows])
    first = next(iter(best.values()), None) or candidates.nearest(question, relevant)
    named = [choices for choices in (*best.values(), front, proved) if choices is not None]
    verifier = Verifier.of(replace(solver, with_motion=False))
    verified = _judged(verifier, Solutions.concatenate([*named, first]))
    rows_named = {row for choices in named for row in choices.row.tolist()}
    return Chosen(
        question=question,
        candidates=as_set,
        relevant=relevant,
        lost=int(of_own_sample.feasible.sum()) - int(relevant.feasible.sum()),
        best=best,
        front=front,
        given_up=given_up,
        proved=proved,
        certificates=certificates,
        first=first,
        verifier=verifier,
        verified={row: judged for row, judged in verified.items() if row in rows_named},
        judged=verified.get(first.row.item()),
    )


def choice_records(
    question: Question,
    choices: Solutions,
    rows_on_front: Rows = _NO_ROWS,
    verified: Mapping[int, Verified] | None = None,
) -> list[ChoiceRecord]:
    """Return choices as rows of the table for JSON, with their rows and what binds them.

    Args:
        question: The question.
        choices: The choices.
        rows_on_front: Rows of the choices that no other beats.
        verified: Judgements of a fresh sample by the rows of choices.
    """
    rows = choice_rows(question, choices) | {"on_front": np.isin(choices.row, rows_on_front)}
    columns = choice_columns(question)
    records = as_records(tuple(one for one in columns if one.name not in VERIFIED), rows)
    return [
        _choice_record(question, number, record, (verified or {}).get(number))
        for number, record in zip(choices.row.tolist(), records, strict=True)
    ]


def _choice_record(
    question: Question, number: int, row: dict[str, Any], judged: Verified | None
) -> ChoiceRecord:
    """Return a choice from its row of the table, with the conditions that bind it."""
    under: dict[str, Any] = {}
    for end in ("from", "to"):
        binds = row[f"{end}_by"] is not None
        condition = row[f"{end}_condition"]
        under[f"{end}_under"] = condition_values(question, condition) if binds else {}
    if judged is not None:
        row["feasible"] = row["feasible"] and judged.is_enough(question.serve)
    names = {field.name for field in fields(ChoiceRecord)}
    return ChoiceRecord(
        choice=number,
        served_verified=None if judged is None else judged.record,
        columns={name: value for name, value in row.items() if name not in names},
        **{name: value for name, value in row.items() if name in names},
        **under,
    )


def _second_sample(solver: Solver) -> Verifier | None:
    """Return the second and larger sample that sets choices; None if the question has none.

    It leaves out columns of a cycle that are no goals: for ten thousand draws they would take ten
    times as long as all the rest.
    """
    if not solver.question.sample.sets_by_sample:
        return None
    is_cycle = solver.question.study.trajectory is None
    return Verifier.of(replace(solver, with_motion=not is_cycle), second=True)


def _set_by(second: Verifier, solver: Solver, choices: Solutions) -> Solutions:
    """Return choices as a second sample sets them.

    Columns of motion that it leaves out are those of the question's own sample.

    Args:
        second: The second sample.
        solver: Solver of the question.
        choices: Choices of the question, solved under its own conditions.
    """
    as_set = second.set_choices(choices)
    goals = as_set.worst.motion
    others = [name for name in solver.columns_of_motion if name not in goals]
    if not others:
        return as_set
    ends = solver.ends(as_set.points)
    groups = solver.question.groups
    is_served = groups.served_at(ends.low, ends.high, as_set.pretension)
    served = is_served[:, groups.of]
    known = solver.worst_of_motion(as_set.points, as_set.pretension, served, others)
    return replace(as_set, worst=replace(as_set.worst, motion={**goals, **known}))


def _best_of(question: Question, choices: Solutions) -> tuple[Best, Solutions | None]:
    """Return the best of some choices, and with several goals their front."""
    feasible = choices.select(choices.feasible)
    if not len(feasible):
        return {}, None
    if len(question.goals) > 1:
        front = candidates.front_of(question, feasible)
        return {"": candidates.compromise(question, front)}, front
    orders = candidates.orders_of(question).items()
    return {name: feasible.select([order.best(feasible)]) for name, order in orders}, None


def _certified(
    solver: Solver, choices: Solutions, certificates: Certificates, report: Report
) -> Solutions:
    """Return choices with their windows proved, or tightened.

    Args:
        solver: Solver of the question.
        choices: The choices.
        certificates: Certificates so far, to which those of the other choices are added.
        report: Called as each proof goes on.
    """
    proved = []
    for place in range(len(choices)):
        choice = choices.select([place])
        row = choice.row.item()
        if row not in certificates:
            certificates[row] = certify(solver, choice, report)
        proved.append(certificates[row].solution)
    return Solutions.concatenate(proved)


def _lost_windows(relevant: Solutions, certificates: Certificates) -> list[Solutions]:
    """Return proved choices that have no window, although they seemed to have one before."""
    seemed_feasible = relevant.row[relevant.feasible]
    choices = [certificate.solution for certificate in certificates.values()]
    return [
        choice
        for choice in choices
        if not choice.feasible.item() and choice.row.item() in seemed_feasible
    ]


def _judged(verifier: Verifier | None, choices: Solutions) -> dict[int, Verified]:
    """Return the judgements of a fresh sample on the choices that have a pretension, by row."""
    if verifier is None:
        return {}
    _, different = np.unique(choices.row, return_index=True)
    choices = choices.select(different)
    choices = choices.select(~np.isnan(choices.pretension))
    judged = verifier.judge(choices.points, choices.pretension)
    return dict(zip(choices.row.tolist(), judged, strict=True))
